//! Objects: what they are, in canonical position with the transform that puts them where their numbers say.

use glam::{DMat3, DVec2, DVec3};

use crate::geometry::Solid;
use crate::math::Transform;
use crate::scene::description::{ObjectDescription, ObjectTree, Offset, ShapeDescription};

use super::fields::{Choice, Fields};
use super::operators::{operator, repeat};
use super::transforms::transform;
use super::tree::{Node, Result};

pub(super) fn object(node: &Node) -> Result<ObjectTree> {
    let mut tree = Vec::new();
    // Objects whose operands are being read, and what comes next, the first at the end: a node to read, or nothing,
    // where the last of those objects has all its operands in the tree.
    let (mut open, mut next) = (Vec::new(), vec![Some(node)]);
    while let Some(node) = next.pop() {
        if let Some(node) = node {
            let (object, operands) = read(node)?;
            open.push(object);
            next.push(None);
            next.extend(operands.into_iter().rev().map(Some));
        } else {
            tree.extend(open.pop());
        }
    }
    Ok(ObjectTree(tree))
}

/// An object and what it is made of.
fn read<'n, 't>(node: &'n Node<'t>) -> Result<(ObjectDescription, Vec<&'n Node<'t>>)> {
    let choice = Choice::of(node, "an object")?;
    let mut operands = Vec::new();
    let object = choice.record(|f| {
        let shape = shape(&choice, f, &mut operands)?;
        Ok(ObjectDescription {
            name: f.optional("name", Node::text)?,
            material: f.optional("material", Node::reference)?,
            transform: f
                .optional("transform", transform)?
                .unwrap_or(Transform::IDENTITY),
            shape,
            offset: Offset(choice.offset),
        })
    })?;
    Ok((object, operands))
}

fn shape<'n, 't>(
    choice: &Choice<'n, 't>,
    f: &mut Fields<'n, 't>,
    operands: &mut Vec<&'n Node<'t>>,
) -> Result<ShapeDescription> {
    const NAMES: [&str; 14] = [
        "Sphere",
        "Box",
        "Cylinder",
        "Cone",
        "Torus",
        "Plane",
        "Rectangle",
        "Disk",
        "Mesh",
        "Instance",
        "Union",
        "Intersection",
        "Difference",
        "Repeat",
    ];
    let (solid, placement) = match choice.name {
        "Sphere" => {
            let center = f.or("center", DVec3::ZERO, Node::point)?;
            let radius = f.required("radius", Node::length)?;
            (
                Solid::Sphere { radius },
                Transform::rigid(DMat3::IDENTITY, center),
            )
        }
        "Box" => {
            let center = f.or("center", DVec3::ZERO, Node::point)?;
            let half = 0.5 * f.required("size", Node::lengths)?;
            let axes = f.optional("axes", axes)?.unwrap_or(DMat3::IDENTITY);
            (Solid::Box { half }, Transform::rigid(axes, center))
        }
        "Cylinder" => {
            let (placement, height) = segment(f)?;
            let radius = f.required("radius", Node::length)?;
            (Solid::Cylinder { radius, height }, placement)
        }
        "Cone" => {
            let (placement, height) = segment(f)?;
            let from_radius = f.required("from_radius", Node::length_or_zero)?;
            let to_radius = f.or("to_radius", 0.0, Node::length_or_zero)?;
            if from_radius == 0.0 && to_radius == 0.0 {
                return Err(choice
                    .fault("both radii of the `Cone` are 0")
                    .help("one may be 0, not both"));
            }
            let solid = Solid::Cone {
                from_radius,
                to_radius,
                height,
            };
            (solid, placement)
        }
        "Torus" => {
            let center = f.or("center", DVec3::ZERO, Node::point)?;
            let axis = f.or("axis", DVec3::Y, Node::direction)?;
            let major = f.required("major_radius", Node::length)?;
            let minor = f.required("minor_radius", |node| {
                let minor = node.length()?;
                (minor < major).then_some(minor).ok_or_else(|| {
                    node.refuse(&format!("must be less than the `major_radius`, {major}"))
                })
            })?;
            (
                Solid::Torus { major, minor },
                Transform::rigid(around(axis), center),
            )
        }
        "Plane" => {
            let point = f.or("point", DVec3::ZERO, Node::point)?;
            let normal = f.required("normal", Node::direction)?;
            (Solid::Plane, Transform::rigid(around(normal), point))
        }
        "Rectangle" => {
            let center = f.or("center", DVec3::ZERO, Node::point)?;
            let half = f.required("size", |node| {
                let [width, height] = node.tuple("`(width, height)`")?;
                Ok(0.5 * DVec2::new(width.length()?, height.length()?))
            })?;
            let axes = f.optional("axes", axes)?.unwrap_or(DMat3::IDENTITY);
            (Solid::Rectangle { half }, Transform::rigid(axes, center))
        }
        "Disk" => {
            let center = f.or("center", DVec3::ZERO, Node::point)?;
            let normal = f.required("normal", Node::direction)?;
            let radius = f.required("radius", Node::length)?;
            (
                Solid::Disk { radius },
                Transform::rigid(around(normal), center),
            )
        }
        "Mesh" => {
            return Ok(ShapeDescription::Mesh {
                file: f.required("file", Node::reference)?,
                smooth: f.or("smooth", true, Node::boolean)?,
            });
        }
        "Instance" => {
            return Ok(ShapeDescription::Instance {
                of: f.required("of", Node::reference)?,
            });
        }
        "Union" | "Intersection" | "Difference" => {
            return operator(choice.name, f, operands);
        }
        "Repeat" => return repeat(f, operands).map(ShapeDescription::Repeat),
        _ => return Err(choice.unknown("an object", &NAMES)),
    };
    Ok(ShapeDescription::Solid { solid, placement })
}

/// A right-handed frame whose z axis is the unit vector `axis`.
fn around(axis: DVec3) -> DMat3 {
    let (x, y) = axis.any_orthonormal_pair();
    DMat3::from_cols(x, y, axis)
}

/// From the z axis to the line between `from` and `to`, and its length.
fn segment(f: &mut Fields) -> Result<(Transform, f64)> {
    let from = f.required("from", Node::point)?;
    f.required("to", |node| {
        let axis = node.point()? - from;
        let length = axis.length();
        if length < 1e-12 {
            return Err(node.refuse("is the same point as `from`"));
        }
        Ok((Transform::rigid(around(axis / length), from), length))
    })
}

/// The x and y axis of a box or rectangle; z follows.
fn axes(node: &Node) -> Result<DMat3> {
    let [first, second] = node.tuple("`((x, y, z), (x, y, z))`")?;
    let (x, y) = (first.direction()?, second.direction()?);
    // Hand-written axes are rounded; beyond that a box would be skewed.
    if x.dot(y).abs() > 1e-3 {
        let angle = x.dot(y).acos().to_degrees();
        return Err(second
            .refuse(&format!("is at {angle:.1} degrees to the first axis"))
            .help("the axes are perpendicular"));
    }
    let y = (y - x.dot(y) * x).normalize();
    Ok(DMat3::from_cols(x, y, x.cross(y)))
}

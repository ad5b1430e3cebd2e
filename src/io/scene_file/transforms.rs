//! Transforms, as lists of steps.

use glam::{DAffine3, DMat3};

use crate::math::Transform;

use super::fields::Choice;
use super::tree::{Node, Result};

/// A list of steps, the first applied first.
pub(super) fn transform(node: &Node) -> Result<Transform> {
    let mut total = Transform::IDENTITY;
    for node in node.items()? {
        total = step(node)?.after(&total);
        if !total.is_finite() {
            return Err(node.refuse("takes the object beyond what numbers can hold"));
        }
    }
    Ok(total)
}

/// One step; a `Matrix` is where it takes the three axes and the origin.
fn step(node: &Node) -> Result<Transform> {
    let choice = Choice::of(node, "a transform")?;
    let matrix = match choice.name {
        "Translate" => DAffine3::from_translation(choice.value()?.point()?),
        "Scale" => DAffine3::from_scale(choice.value()?.factors()?),
        "Matrix" => {
            let form = "`((x, y, z), (x, y, z), (x, y, z), (x, y, z))`";
            let [x, y, z, origin] = choice.value()?.tuple(form)?;
            let axes = DMat3::from_cols(x.point()?, y.point()?, z.point()?);
            DAffine3::from_mat3_translation(axes, origin.point()?)
        }
        "Rotate" => choice.record(|f| {
            let axis = f.required("axis", Node::direction)?;
            let degrees = f.required("degrees", Node::coordinate)?;
            Ok(DAffine3::from_axis_angle(axis, degrees.to_radians()))
        })?,
        _ => return Err(choice.unknown("a transform", &["Translate", "Rotate", "Scale", "Matrix"])),
    };
    Transform::new(matrix).ok_or_else(|| node.refuse("flattens the object"))
}

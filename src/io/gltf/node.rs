//! The scene's nodes: what stands where.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DAffine3, DMat4, DQuat, DVec3};

use crate::camera::{Camera, Projection};
use crate::color::Rgb;
use crate::error::Result;
use crate::light::{Cone, DistantLight, Light, PointLight};
use crate::math::Transform;

use super::json::Json;

/// A node of the scene with its place in the world; `None` where its transform flattens space.
pub(super) struct Node<'a> {
    pub(super) json: Json<'a>,
    pub(super) world_from_node: Option<Transform>,
}

/// The nodes of the scene in depth-first order: the default scene's, else the first one's, else all.
///
/// # Errors
/// Where a node is met twice (glTF's nodes are trees) or a transform is malformed.
pub(super) fn walk<'a>(root: &Json<'a>) -> Result<Vec<Node<'a>>> {
    let mut visited = vec![false; root.list("nodes")?.len()];
    let mut open: Vec<_> = (roots(root)?.into_iter().rev())
        .map(|node| (node, DAffine3::IDENTITY))
        .collect();
    let mut nodes = Vec::new();
    while let Some(((index, json), world_from_parent)) = open.pop() {
        if std::mem::replace(&mut visited[index], true) {
            return Err((json.error(format!("node {index} is in the scene twice")))
                .help("a node has one parent, and is not below itself"));
        }
        let matrix = world_from_parent * local_matrix(&json)?;
        let children = resolve(root, &json.list("children")?)?;
        open.extend(children.into_iter().rev().map(|child| (child, matrix)));
        nodes.push(Node {
            json,
            world_from_node: Transform::new(matrix),
        });
    }
    Ok(nodes)
}

/// The nodes where the walk begins, with their indices.
fn roots<'a>(root: &Json<'a>) -> Result<Vec<(usize, Json<'a>)>> {
    if let Some(reference) = root.get("scene")? {
        let (_, scene) = root.element("scenes", &reference)?;
        return resolve(root, &scene.list("nodes")?);
    }
    if let Some(scene) = root.list("scenes")?.first() {
        return resolve(root, &scene.list("nodes")?);
    }
    let nodes = root.list("nodes")?;
    let mut is_child = vec![false; nodes.len()];
    for node in &nodes {
        for (child, _) in resolve(root, &node.list("children")?)? {
            is_child[child] = true;
        }
    }
    let nodes = nodes.into_iter().enumerate();
    Ok(nodes.filter(|&(i, _)| !is_child[i]).collect())
}

fn resolve<'a>(root: &Json<'a>, references: &[Json<'a>]) -> Result<Vec<(usize, Json<'a>)>> {
    (references.iter())
        .map(|reference| root.element("nodes", reference))
        .collect()
}

fn local_matrix(node: &Json<'_>) -> Result<DAffine3> {
    if let Some(matrix) = node.get("matrix")? {
        let m = DMat4::from_cols_array(&matrix.numbers()?);
        if m.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return Err(matrix.error(format!("the last row is {}, not [0, 0, 0, 1]", m.row(3))));
        }
        return Ok(DAffine3::from_mat4(m));
    }
    let rotation = DQuat::from_array(node.numbers_or("rotation", [0.0, 0.0, 0.0, 1.0])?);
    let length = rotation.length();
    if length < 1e-6 {
        return Err(node
            .need("rotation")?
            .error(format!("the quaternion {rotation} has no direction")));
    }
    Ok(DAffine3::from_scale_rotation_translation(
        DVec3::from_array(node.numbers_or("scale", [1.0; 3])?),
        rotation / length,
        DVec3::from_array(node.numbers_or("translation", [0.0; 3])?),
    ))
}

/// The camera of a node, if it has one: it looks along the node's -z axis.
///
/// # Errors
/// Where the camera's fields are missing or out of range.
pub(super) fn camera(
    root: &Json<'_>,
    node: &Json<'_>,
    world_from_node: &Transform,
) -> Result<Option<Camera>> {
    let Some(reference) = node.get("camera")? else {
        return Ok(None);
    };
    let (_, camera) = root.element("cameras", &reference)?;
    let kind = camera.need("type")?;
    let projection = match kind.text()? {
        "perspective" => {
            let yfov = camera.need("perspective")?.need("yfov")?;
            let vfov = yfov.number()?;
            if vfov <= 0.0 || vfov >= std::f64::consts::PI {
                return Err((yfov.error(format!("a field of view of {vfov} radians")))
                    .help("it must be above 0 and below pi"));
            }
            Projection::pinhole(vfov)
        }
        "orthographic" => {
            let ymag = camera.need("orthographic")?.need("ymag")?;
            // Negative ones turn the picture round, which the format advises against.
            let half = ymag.number()?.abs();
            if !(half > 0.0 && half.is_finite()) {
                return Err((ymag.error(format!("a picture of half the height {half}")))
                    .help("it must be above 0"));
            }
            Projection::Orthographic { height: 2.0 * half }
        }
        other => {
            return Err((kind.error(format!("`{other}` is no type of camera")))
                .help("cameras are `perspective` or `orthographic`"));
        }
    };
    let eye = world_from_node.point(DVec3::ZERO);
    Ok(Some(Camera {
        name: camera.name().or_else(|| node.name()),
        eye,
        look_at: eye + world_from_node.vector(DVec3::NEG_Z).normalize(),
        up: world_from_node.vector(DVec3::Y).normalize(),
        projection,
        motion: None,
    }))
}

/// The light of a node, if it has one (`KHR_lights_punctual`). Intensities are taken as they stand: a candela is one W/sr
/// here, not 1/683, and a lux one W/m².
///
/// # Errors
/// Where the light's fields are missing or out of range.
pub(super) fn light(
    root: &Json<'_>,
    node: &Json<'_>,
    world_from_node: &Transform,
    warnings: &mut Vec<String>,
) -> Result<Option<Light>> {
    let Some(extension) = node.extension("KHR_lights_punctual")? else {
        return Ok(None);
    };
    let reference = extension.need("light")?;
    let lights = (root.extension("KHR_lights_punctual")?)
        .ok_or_else(|| reference.error("the file has no lights"))?;
    let (_, light) = lights.element("lights", &reference)?;
    let kind = light.need("type")?.text()?;
    let known = ["point", "spot", "directional"];
    if !known.contains(&kind) {
        warnings.push(light.warning(&format!(
            "lights of type `{kind}` are not read, only `point`, `spot` and `directional`"
        )));
        return Ok(None);
    }
    let strength = light.number_or("intensity", 1.0)?;
    let color = light.numbers_or("color", [1.0; 3])?;
    let intensity = Rgb::from_array(color.map(|c| (c * strength) as f32));
    if !intensity.is_finite() || intensity.min_element() < 0.0 {
        return Err(light.error(format!(
            "the intensity {intensity} is negative or not finite"
        )));
    }
    Ok(Some(match kind {
        // It shines along the node's -z axis.
        "directional" => Light::Distant(DistantLight {
            direction: world_from_node.vector(DVec3::Z).normalize(),
            irradiance: intensity,
            angle: 0.0,
        }),
        _ => Light::Point(PointLight {
            position: world_from_node.point(DVec3::ZERO),
            intensity,
            cone: match kind {
                "spot" => Some(cone(&light, world_from_node)?),
                _ => None,
            },
        }),
    }))
}

/// The cone of a spot light, which shines along the node's -z axis.
fn cone(light: &Json<'_>, world_from_node: &Transform) -> Result<Cone> {
    let spot = light.need("spot")?;
    let inner = spot.number_or("innerConeAngle", 0.0)?;
    let outer = spot.number_or("outerConeAngle", FRAC_PI_4)?;
    // A right angle may be written a little larger.
    if !(inner >= 0.0 && inner < outer && outer <= FRAC_PI_2 + 1e-6) {
        return Err(
            (spot.error(format!("a cone between the angles {inner} and {outer}")))
                .help("they must be at least 0, at most pi / 2, and the inner one the lesser"),
        );
    }
    let axis = world_from_node.vector(DVec3::NEG_Z).normalize();
    Ok(Cone::new(axis, inner, outer))
}

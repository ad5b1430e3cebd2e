//! Cameras and how they move.

use glam::DVec3;

use crate::camera::{Camera, Interpolation, Key, Motion, Projection};

use super::fields::{Choice, Fields};
use super::tree::{Fault, Node, Result};

/// Reads a field of view or a height, as the projection has it.
type ReadField = fn(&Node) -> Result<f64>;

pub(super) fn camera(node: &Node, name: Option<&str>) -> Result<Camera> {
    const NAMES: [&str; 3] = ["Perspective", "Orthographic", "Panorama"];
    let choice = Choice::of(node, "a camera")?;
    choice.record(|f| {
        let (field, projection): (_, fn(&mut Fields) -> Result<Projection>) = match choice.name {
            "Perspective" => (Some(("vfov", vfov as ReadField)), perspective),
            "Orthographic" => (Some(("height", height as ReadField)), orthographic),
            "Panorama" => (None, |_| Ok(Projection::Panorama)),
            _ => return Err(choice.unknown("a camera", &NAMES)),
        };
        let eye = f.required("eye", Node::point)?;
        let look_at = f.required("look_at", |node| looking(node, eye))?;
        let up = f.or("up", DVec3::Y, |node| upright(node, look_at - eye))?;
        if !is_upright(look_at - eye, up) {
            return Err(choice
                .fault("the camera looks straight along the y axis, which is its `up`")
                .help("give it another `up`, as in `up: (0, 0, -1)`"));
        }
        let projection = projection(f)?;
        let first = Key {
            frame: 0.0,
            eye,
            look_at,
            up,
            field: projection.field().unwrap_or_default(),
        };
        Ok(Camera {
            name: name.map(str::to_owned),
            eye,
            look_at,
            up,
            projection,
            motion: f.optional("motion", |node| motion(node, first, field))?,
        })
    })
}

fn perspective(f: &mut Fields) -> Result<Projection> {
    Ok(Projection::Perspective {
        vfov: f.required("vfov", vfov)?,
        aperture: f.or("aperture", 0.0, Node::length_or_zero)?,
        focus: f.optional("focus", Node::length)?,
    })
}

fn orthographic(f: &mut Fields) -> Result<Projection> {
    let height = f.required("height", height)?;
    Ok(Projection::Orthographic { height })
}

fn vfov(node: &Node) -> Result<f64> {
    let degrees = node.number()?;
    let open = degrees > 0.0 && degrees < 180.0;
    (open.then_some(degrees.to_radians()))
        .ok_or_else(|| node.refuse("degrees is not between 0 and 180"))
}

fn height(node: &Node) -> Result<f64> {
    node.length()
}

fn looking(node: &Node, eye: DVec3) -> Result<DVec3> {
    let look_at = node.point()?;
    let somewhere = (look_at - eye).try_normalize().is_some();
    (somewhere.then_some(look_at))
        .ok_or_else(|| node.refuse("is where the camera itself is: it looks nowhere"))
}

fn is_upright(axis: DVec3, up: DVec3) -> bool {
    axis.normalize().cross(up).length() > 1e-6
}

fn upright(node: &Node, axis: DVec3) -> Result<DVec3> {
    let up = node.direction()?;
    (is_upright(axis, up).then_some(up)).ok_or_else(|| node.refuse("lies along the view"))
}

/// The keys of a motion. What one leaves out is as in the key before it, and at the first as in the camera.
fn motion(node: &Node, camera: Key, field: Option<(&'static str, ReadField)>) -> Result<Motion> {
    let choice = Choice::of(node, "a motion")?;
    let interpolation = match choice.name {
        "Linear" => Interpolation::Linear,
        "Smooth" => Interpolation::Smooth,
        _ => return Err(choice.unknown("a motion", &["Linear", "Smooth"])),
    };
    let read_keys = |node: &Node| {
        let mut keys: Vec<Key> = Vec::new();
        for node in node.items()? {
            let key = key(node, keys.last().unwrap_or(&camera), keys.is_empty(), field)?;
            keys.push(key);
        }
        if keys.is_empty() {
            return Err(node.refuse("has no keys").help("write at least one"));
        }
        Ok(keys)
    };
    choice.record(|f| {
        Ok(Motion {
            keys: f.required("keys", read_keys)?,
            interpolation,
        })
    })
}

fn key(
    node: &Node,
    before: &Key,
    first: bool,
    field: Option<(&'static str, ReadField)>,
) -> Result<Key> {
    let mut f = Fields::of(node, "key")?;
    let frame = f.required("frame", |node| {
        let frame = f64::from(node.count(0, 1_000_000)?);
        let later = first || frame > before.frame;
        (later.then_some(frame)).ok_or_else(|| {
            let rule = format!("is not after the frame of the key before, {}", before.frame);
            node.refuse(&rule).help("order the keys by their frames")
        })
    })?;
    let eye = f.or("eye", before.eye, Node::point)?;
    let look_at = f.or("look_at", before.look_at, |node| looking(node, eye))?;
    let up = f.or("up", before.up, Node::direction)?;
    let axis = (look_at - eye).try_normalize();
    if !axis.is_some_and(|axis| is_upright(axis, up)) {
        let message = "at this key the camera looks nowhere, or along its `up`";
        return Err(
            Fault::new(node.offset, message).help("give the key another `eye`, `look_at` or `up`")
        );
    }
    let field = match field {
        Some((name, read)) => f.or(name, before.field, read)?,
        None => before.field,
    };
    f.finish()?;
    Ok(Key {
        frame,
        eye,
        look_at,
        up,
        field,
    })
}

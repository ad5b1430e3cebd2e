//! What is infinitely far away.

use std::f32::consts::PI;

use glam::DVec3;

use crate::color::Rgb;
use crate::light::{DistantLight, Sky};
use crate::scene::description::EnvironmentDescription;

use super::fields::Fields;
use super::tree::{Node, Result, Value};

/// Above this nothing multiplies light.
const LARGEST_SCALE: f64 = 1e6;

/// An environment that is a picture.
pub(super) fn image(f: &mut Fields) -> Result<EnvironmentDescription> {
    let degrees = f.or("rotate", 0.0, Node::coordinate)?;
    Ok(EnvironmentDescription::Image {
        file: f.required("file", Node::reference)?,
        rotate: degrees.to_radians(),
        scale: scale(f)?,
    })
}

/// An environment that is a clear sky.
pub(super) fn sky(f: &mut Fields) -> Result<EnvironmentDescription> {
    Ok(EnvironmentDescription::Sky(Sky {
        sun: f.required("sun", heavenly)?,
        turbidity: f.or("turbidity", 3.0, |node| node.within(1.0, 10.0))?,
        ground: f.or("ground", Rgb::splat(0.2), Node::albedo)?,
        scale: scale(f)?,
        disk: f.or("disk", true, Node::boolean)?,
    }))
}

fn scale(f: &mut Fields) -> Result<f32> {
    Ok(f.or("scale", 1.0, |node| node.within(0.0, LARGEST_SCALE))? as f32)
}

/// A `Sun` among the lights.
pub(super) fn sun(f: &mut Fields) -> Result<DistantLight> {
    let direction = f.required("direction", heavenly)?;
    let degrees = f.or("angle", DistantLight::SUN_DEGREES, |node| {
        match node.within(0.0, 180.0)? {
            n if n > 0.0 && n < 1e-3 => Err(node
                .refuse("is less than 0.001 degrees")
                .help("0 is a sun without extent, whose shadows are sharp")),
            n => Ok(n),
        }
    })?;
    let angle = degrees.to_radians();
    let radiance = f.optional("radiance", |node| {
        if angle == 0.0 {
            return Err(node
                .refuse("is the radiance of a sun without extent")
                .help("give its `irradiance` in place of that"));
        }
        Ok(node.radiance()? * PI * (0.5 * angle).sin().powi(2) as f32)
    })?;
    let irradiance = match radiance {
        None => f.required("irradiance", Node::radiance)?,
        Some(irradiance) => {
            f.optional("irradiance", |node| {
                Err::<(), _>(
                    node.refuse("is given beside `radiance`, which says it already")
                        .help("remove one of the two"),
                )
            })?;
            irradiance
        }
    };
    Ok(DistantLight {
        direction,
        irradiance,
        angle,
    })
}

/// Where something stands in the sky, as a unit vector towards it: `(x, y, z)`, or degrees above the horizon and
/// to the right of -z.
fn heavenly(node: &Node) -> Result<DVec3> {
    if !matches!(node.value, Value::Fields(None, _)) {
        return node.direction();
    }
    let mut f = Fields::of(node, "direction")?;
    let elevation = f.required("elevation", |node| node.within(-90.0, 90.0))?;
    let azimuth = f.or("azimuth", 0.0, |node| node.within(-360.0, 360.0))?;
    f.finish()?;
    let (rise, level) = elevation.to_radians().sin_cos();
    let (right, ahead) = azimuth.to_radians().sin_cos();
    Ok(DVec3::new(level * right, rise, -level * ahead))
}

//! Materials under their names.

use glam::Vec3;

use crate::color::Rgb;
use crate::material::Fresnel;
use crate::scene::description::{ColorDescription, MaterialDescription, SurfaceDescription};

use super::fields::Choice;
use super::tree::{Node, Result};

pub(super) fn material(node: &Node, name: &str) -> Result<MaterialDescription> {
    const NAMES: [&str; 4] = ["Diffuse", "Mirror", "Dielectric", "Emissive"];
    let choice = Choice::of(node, "a material")?;
    let (surface, emission) = match choice.name {
        "Diffuse" => choice.record(|f| {
            let color = f.required("color", Node::color)?;
            Ok((SurfaceDescription::Diffuse { color }, Rgb::ZERO))
        }),
        "Mirror" => choice.record(|f| {
            let color = f.or("color", ColorDescription::Constant(Vec3::ONE), Node::color)?;
            Ok((SurfaceDescription::Mirror { color }, Rgb::ZERO))
        }),
        "Dielectric" => choice.record(|f| {
            let ior = f.required("ior", |node| node.within(0.01, 100.0))? as f32;
            let fresnel = f.or("fresnel", Fresnel::Exact, fresnel)?;
            Ok((SurfaceDescription::Dielectric { ior, fresnel }, Rgb::ZERO))
        }),
        "Emissive" => choice.record(|f| {
            let emission = f.required("radiance", Node::radiance)?;
            let color = f.or("color", ColorDescription::Constant(Vec3::ZERO), Node::color)?;
            Ok((SurfaceDescription::Diffuse { color }, emission))
        }),
        _ => Err(choice.unknown("a material", &NAMES)),
    }?;
    Ok(MaterialDescription {
        name: name.to_owned(),
        surface,
        emission,
    })
}

fn fresnel(node: &Node) -> Result<Fresnel> {
    let choice = Choice::of(node, "a Fresnel reflectance")?;
    match choice.name {
        "None" => choice.alone(Fresnel::None),
        "Schlick" => choice.alone(Fresnel::Schlick),
        "Exact" => choice.alone(Fresnel::Exact),
        _ => Err(choice.unknown("a Fresnel reflectance", &["None", "Schlick", "Exact"])),
    }
}

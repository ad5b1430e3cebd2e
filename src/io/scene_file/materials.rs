//! Materials under their names.

use glam::Vec3;

use crate::color::Rgb;
use crate::material::Fresnel;
use crate::scene::description::{
    MaterialDescription, ReliefDescription, SurfaceDescription, TextureDescription,
};

use super::fields::{Choice, Fields};
use super::tree::{Node, Result};

pub(super) fn material(node: &Node, name: &str) -> Result<MaterialDescription> {
    const NAMES: [&str; 4] = ["Diffuse", "Mirror", "Dielectric", "Emissive"];
    let choice = Choice::of(node, "a material")?;
    if !NAMES.contains(&choice.name) {
        return Err(choice.unknown("a material", &NAMES));
    }
    choice.record(|f| {
        let mut emission = Rgb::ZERO;
        let mut emission_texture = None;
        let surface = match choice.name {
            "Diffuse" => SurfaceDescription::Diffuse {
                color: f.required("color", Node::texture)?,
            },
            "Mirror" => SurfaceDescription::Mirror {
                color: f.or(
                    "color",
                    TextureDescription::Constant(Vec3::ONE),
                    Node::texture,
                )?,
            },
            "Dielectric" => SurfaceDescription::Dielectric {
                ior: f.required("ior", |node| node.within(0.01, 100.0))? as f32,
                fresnel: f.or("fresnel", Fresnel::Exact, fresnel)?,
            },
            _ => {
                emission = f.required("radiance", Node::radiance)?;
                emission_texture = f.optional("texture", Node::texture)?;
                SurfaceDescription::Diffuse {
                    color: f.or(
                        "color",
                        TextureDescription::Constant(Vec3::ZERO),
                        Node::texture,
                    )?,
                }
            }
        };
        Ok(MaterialDescription {
            name: name.to_owned(),
            surface,
            emission,
            emission_texture,
            relief: relief(f)?,
        })
    })
}

/// The field `bump` or `normal_map`, which every material may have.
fn relief(f: &mut Fields) -> Result<Option<ReliefDescription>> {
    let bump = f.optional("bump", |node| {
        let mut f = Fields::of(node, "bump")?;
        let relief = ReliefDescription::Bump {
            texture: f.required("texture", Node::texture)?,
            height: f.required("height", Node::coordinate)?,
        };
        f.finish()?;
        Ok(relief)
    })?;
    let normal_map = f.optional("normal_map", |node| {
        if bump.is_some() {
            return Err(node.refuse("comes on top of a `bump`: a surface has one of the two"));
        }
        let mut f = Fields::of(node, "normal_map")?;
        let relief = ReliefDescription::NormalMap {
            texture: f.required("texture", Node::texture)?,
            scale: f.or("scale", 1.0, Node::coordinate)?,
        };
        f.finish()?;
        Ok(relief)
    })?;
    Ok(bump.or(normal_map))
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

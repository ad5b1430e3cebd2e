//! Materials under their names.

use std::f32::consts::TAU;

use glam::Vec3;

use crate::color::Rgb;
use crate::error::did_you_mean;
use crate::material::{self, Fresnel, Metal, Principled, Roughness, Surface};
use crate::scene::description::{
    MaterialDescription, ReliefDescription, SurfaceDescription, TextureDescription,
};

use super::fields::{Choice, Fields};
use super::tree::{Fault, Node, Result, Value};

/// Surfaces may be parts of others this deep.
const MAX_NESTING: usize = 8;

/// The material `name`; `all` are the scene's, which it may name as its parts.
pub(super) fn material(node: &Node, name: &str, all: &Node) -> Result<MaterialDescription> {
    Reader { all, depth: 0 }.material(node, name)
}

/// Reads a material with all that it is made of.
#[derive(Clone, Copy)]
struct Reader<'n, 't> {
    all: &'n Node<'t>,
    depth: usize,
}

impl Reader<'_, '_> {
    fn material(self, node: &Node, name: &str) -> Result<MaterialDescription> {
        let choice = Choice::of(node, "a material")?;
        choice.record(|f| {
            let surface = self.surface(&choice, f)?;
            let emits = choice.name == "Emissive";
            Ok(MaterialDescription {
                name: name.to_owned(),
                surface,
                emission: if emits {
                    f.required("radiance", Node::radiance)?
                } else {
                    Rgb::ZERO
                },
                emission_texture: if emits {
                    f.optional("texture", Node::texture)?
                } else {
                    None
                },
                relief: relief(f)?,
            })
        })
    }

    fn surface(self, choice: &Choice, f: &mut Fields) -> Result<SurfaceDescription> {
        const NAMES: [&str; 11] = [
            "Diffuse",
            "Mirror",
            "Dielectric",
            "ThinDielectric",
            "Conductor",
            "Glossy",
            "Plastic",
            "Principled",
            "Mix",
            "TwoSided",
            "Emissive",
        ];
        Ok(match choice.name {
            "Diffuse" => Surface::Diffuse {
                color: f.required("color", Node::texture)?,
            },
            "Mirror" => Surface::Mirror {
                color: f.or("color", 1.0.into(), Node::texture)?,
            },
            "Dielectric" => Surface::Dielectric {
                ior: f.required("ior", |node| node.within(0.01, 100.0))? as f32,
                fresnel: f.or("fresnel", Fresnel::Exact, fresnel)?,
                roughness: f.or("roughness", 0.0.into(), Node::texture)?,
                absorption: absorption(f)?,
            },
            "ThinDielectric" => Surface::ThinDielectric {
                ior: f.or("ior", 1.5, |node| node.within(1.0, 100.0))? as f32,
            },
            "Conductor" => Surface::Conductor {
                metal: metal(choice, f)?,
                roughness: roughness(f, 0.0)?,
            },
            "Glossy" => Surface::Glossy {
                color: f.required("color", Node::texture)?,
                roughness: roughness(f, 0.3)?,
            },
            "Plastic" => Surface::Plastic {
                color: f.required("color", Node::texture)?,
                ior: f.or("ior", 1.5, |node| node.within(1.0, 3.0))? as f32,
                roughness: f.or("roughness", 0.0.into(), Node::texture)?,
            },
            "Principled" => Surface::Principled(Box::new(principled(f)?)),
            "Mix" => Surface::Mix {
                a: f.required("a", |node| self.part(node))?,
                b: f.required("b", |node| self.part(node))?,
                weight: f.or("weight", 0.5.into(), Node::texture)?,
            },
            "TwoSided" => Surface::TwoSided {
                front: f.required("front", |node| self.part(node))?,
                back: f.required("back", |node| self.part(node))?,
            },
            "Emissive" => Surface::Diffuse {
                color: f.or("color", 0.0.into(), Node::texture)?,
            },
            _ => return Err(choice.unknown("a material", &NAMES)),
        })
    }

    /// A surface that is part of another: written out, or one of the scene's materials by its name.
    fn part(self, node: &Node) -> Result<Box<SurfaceDescription>> {
        if self.depth == MAX_NESTING {
            let message = format!("more than {MAX_NESTING} materials inside one another");
            return Err(Fault::new(node.offset, message).help("is one made of itself?"));
        }
        let within = Self {
            depth: self.depth + 1,
            ..self
        };
        let part = match &node.value {
            Value::String(name) => within.material(self.named(name, node)?, name)?,
            _ => within.material(node, "")?,
        };
        if part.emission != Rgb::ZERO {
            return Err(node.refuse("emits light, which a part of a material cannot"));
        }
        if part.relief.is_some() {
            let fault = node.refuse("has a bump or normal map, which a part of a material cannot");
            return Err(fault.help("the whole can have one"));
        }
        Ok(Box::new(part.surface))
    }

    fn named(&self, name: &str, at: &Node) -> Result<&Node<'_>> {
        let Value::Fields(_, entries) = &self.all.value else {
            return Err(self.all.fault("materials under their names"));
        };
        let found = entries.iter().find(|(key, _)| key.text == name);
        found.map(|(_, node)| node).ok_or_else(|| {
            Fault::new(at.offset, format!("there is no material `{name}`")).help(did_you_mean(
                name,
                entries.iter().map(|(key, _)| &*key.text),
            ))
        })
    }
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

/// By name, or by its index of refraction.
fn metal(choice: &Choice, f: &mut Fields) -> Result<Metal> {
    let index = |node: &Node| node.three("`(r, g, b)`", |node| node.within(0.0, 100.0));
    let named = f.optional("metal", |node| {
        let name = node.text()?;
        Metal::named(&name).ok_or_else(|| {
            let metals: Vec<&str> = Metal::names().collect();
            (node.refuse("is not a metal that is known")).help(format!(
                "known are {}; or give `eta` and `k`",
                metals.join(", ")
            ))
        })
    })?;
    let eta = f.optional("eta", index)?;
    let k = f.optional("k", index)?;
    match (named, eta, k) {
        (Some(metal), None, None) => Ok(metal),
        (None, Some(eta), Some(k)) => Ok(Metal::new(eta.as_vec3(), k.as_vec3())),
        (None, None, None) => Err(choice
            .fault("`Conductor` needs a `metal`, or `eta` and `k`")
            .help("as in `Conductor(metal: \"gold\")`")),
        _ => Err(choice.fault("`Conductor` has either a `metal` or both `eta` and `k`")),
    }
}

fn roughness(f: &mut Fields, default: f32) -> Result<Roughness<TextureDescription>> {
    Ok(Roughness {
        value: f.or("roughness", default.into(), Node::texture)?,
        anisotropy: f.or("anisotropy", 0.0.into(), Node::texture)?,
        rotation: f.or("anisotropy_rotation", 0.0.into(), |node| {
            number(node, TAU, |node| {
                Ok(node.within(-3600.0, 3600.0)?.to_radians())
            })
        })?,
    })
}

/// A number of its own range, or a texture whose 1 stands for `full`.
fn number(
    node: &Node,
    full: f32,
    read: impl FnOnce(&Node) -> Result<f64>,
) -> Result<TextureDescription> {
    if let Value::Number(_) = node.value {
        return Ok((read(node)? as f32).into());
    }
    Ok(TextureDescription::Scale {
        of: Box::new(node.texture()?),
        by: Vec3::splat(full),
    })
}

/// From the colour that is left of white light after a distance, by Beer's law.
fn absorption(f: &mut Fields) -> Result<Rgb> {
    let color = f.or("attenuation_color", Vec3::ONE, Node::albedo)?;
    let distance = f.or("attenuation_distance", 1.0, Node::length)?;
    Ok(material::absorption(color, distance))
}

fn principled(f: &mut Fields) -> Result<Principled<TextureDescription>> {
    let base = f.or("base_color", 1.0.into(), Node::texture)?;
    let default = Principled::new(base);
    Ok(Principled {
        metallic: f.or("metallic", default.metallic, Node::texture)?,
        roughness: roughness(f, 0.5)?,
        ior: f.or("ior", default.ior, |node| {
            Ok(node.within(1.0, 100.0)? as f32)
        })?,
        specular: f.or("specular", default.specular, Node::texture)?,
        specular_color: f.or("specular_color", default.specular_color, Node::texture)?,
        transmission: f.or("transmission", default.transmission, Node::texture)?,
        thin: f.or("thin", default.thin, Node::boolean)?,
        absorption: absorption(f)?,
        clearcoat: f.or("clearcoat", default.clearcoat, Node::texture)?,
        clearcoat_roughness: f.or(
            "clearcoat_roughness",
            default.clearcoat_roughness,
            Node::texture,
        )?,
        sheen_color: f.or("sheen_color", default.sheen_color, Node::texture)?,
        sheen_roughness: f.or("sheen_roughness", default.sheen_roughness, Node::texture)?,
        iridescence: f.or("iridescence", default.iridescence, Node::texture)?,
        iridescence_ior: f.or("iridescence_ior", default.iridescence_ior, |node| {
            Ok(node.within(1.0, 10.0)? as f32)
        })?,
        iridescence_thickness: f.or(
            "iridescence_thickness",
            default.iridescence_thickness,
            |node| number(node, 1000.0, |node| node.within(0.0, 10_000.0)),
        )?,
        base_color: default.base_color,
    })
}

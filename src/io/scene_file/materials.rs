//! Materials under their names.

use glam::Vec3;

use crate::color::Rgb;
use crate::error::did_you_mean;
use crate::material::{self, Fresnel, Metal, Principled, Roughness, Surface};
use crate::scene::description::{ColorDescription, MaterialDescription, SurfaceDescription};

use super::fields::{Choice, Fields};
use super::tree::{Fault, Node, Result, Value};

/// Surfaces may be parts of others this deep.
const MAX_NESTING: usize = 8;

/// The material `name`; `all` are the scene's, which it may name as its parts.
pub(super) fn material(node: &Node, name: &str, all: &Node) -> Result<MaterialDescription> {
    let (surface, emission) = Reader { all, depth: 0 }.surface(node)?;
    Ok(MaterialDescription {
        name: name.to_owned(),
        surface,
        emission,
    })
}

/// Reads a surface with all that it is made of.
#[derive(Clone, Copy)]
struct Reader<'n, 't> {
    all: &'n Node<'t>,
    depth: usize,
}

impl Reader<'_, '_> {
    /// A surface, and what it emits.
    fn surface(self, node: &Node) -> Result<(SurfaceDescription, Rgb)> {
        const NAMES: [&str; 10] = [
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
        ];
        let choice = Choice::of(node, "a material")?;
        let surface = match choice.name {
            "Diffuse" => choice.record(|f| {
                let color = f.required("color", Node::color)?;
                Ok(Surface::Diffuse { color })
            }),
            "Mirror" => choice.record(|f| {
                let color = f.or("color", constant(Vec3::ONE), Node::color)?;
                Ok(Surface::Mirror { color })
            }),
            "Dielectric" => choice.record(|f| {
                Ok(Surface::Dielectric {
                    ior: f.required("ior", |node| node.within(0.01, 100.0))? as f32,
                    fresnel: f.or("fresnel", Fresnel::Exact, fresnel)?,
                    roughness: f.or("roughness", 0.0, share)?,
                    absorption: absorption(f)?,
                })
            }),
            "ThinDielectric" => choice.record(|f| {
                let ior = f.or("ior", 1.5, |node| node.within(1.0, 100.0))? as f32;
                Ok(Surface::ThinDielectric { ior })
            }),
            "Conductor" => choice.record(|f| {
                Ok(Surface::Conductor {
                    metal: metal(&choice, f)?,
                    roughness: roughness(f, 0.0)?,
                })
            }),
            "Glossy" => choice.record(|f| {
                Ok(Surface::Glossy {
                    color: f.required("color", Node::color)?,
                    roughness: roughness(f, 0.3)?,
                })
            }),
            "Plastic" => choice.record(|f| {
                Ok(Surface::Plastic {
                    color: f.required("color", Node::color)?,
                    ior: f.or("ior", 1.5, |node| node.within(1.0, 3.0))? as f32,
                    roughness: f.or("roughness", 0.0, share)?,
                })
            }),
            "Principled" => choice
                .record(principled)
                .map(|p| Surface::Principled(Box::new(p))),
            "Mix" => choice.record(|f| {
                Ok(Surface::Mix {
                    a: f.required("a", |node| self.part(node))?,
                    b: f.required("b", |node| self.part(node))?,
                    weight: f.or("weight", 0.5, share)?,
                })
            }),
            "TwoSided" => choice.record(|f| {
                Ok(Surface::TwoSided {
                    front: f.required("front", |node| self.part(node))?,
                    back: f.required("back", |node| self.part(node))?,
                })
            }),
            "Emissive" => {
                return choice.record(|f| {
                    let emission = f.required("radiance", Node::radiance)?;
                    let color = f.or("color", constant(Vec3::ZERO), Node::color)?;
                    Ok((Surface::Diffuse { color }, emission))
                });
            }
            _ => Err(choice.unknown("a material", &[&NAMES[..], &["Emissive"]].concat())),
        };
        Ok((surface?, Rgb::ZERO))
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
        let (surface, emission) = match &node.value {
            Value::String(name) => within.surface(self.named(name, node)?)?,
            _ => within.surface(node)?,
        };
        if emission != Rgb::ZERO {
            return Err(node.refuse("emits light, which a part of a material cannot"));
        }
        Ok(Box::new(surface))
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

fn constant(color: Rgb) -> ColorDescription {
    ColorDescription::Constant(color)
}

/// A number in 0..=1.
fn share(node: &Node) -> Result<f32> {
    Ok(node.within(0.0, 1.0)? as f32)
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

fn roughness(f: &mut Fields, default: f32) -> Result<Roughness> {
    Ok(Roughness {
        value: f.or("roughness", default, share)?,
        anisotropy: f.or("anisotropy", 0.0, share)?,
        rotation: f.or("anisotropy_rotation", 0.0, |node| {
            Ok(node.within(-3600.0, 3600.0)?.to_radians() as f32)
        })?,
    })
}

/// From the colour that is left of white light after a distance, by Beer's law.
fn absorption(f: &mut Fields) -> Result<Rgb> {
    let color = f.or("attenuation_color", Vec3::ONE, Node::albedo)?;
    let distance = f.or("attenuation_distance", 1.0, Node::length)?;
    Ok(material::absorption(color, distance))
}

fn principled(f: &mut Fields) -> Result<Principled<ColorDescription>> {
    let base = f.or("base_color", constant(Vec3::ONE), Node::color)?;
    let default = Principled::new(base, constant);
    Ok(Principled {
        metallic: f.or("metallic", default.metallic, share)?,
        roughness: roughness(f, 0.5)?,
        ior: f.or("ior", default.ior, |node| {
            Ok(node.within(1.0, 100.0)? as f32)
        })?,
        specular: f.or("specular", default.specular, share)?,
        specular_color: f.or("specular_color", default.specular_color, Node::color)?,
        transmission: f.or("transmission", default.transmission, share)?,
        thin: f.or("thin", default.thin, Node::boolean)?,
        absorption: absorption(f)?,
        clearcoat: f.or("clearcoat", default.clearcoat, share)?,
        clearcoat_roughness: f.or("clearcoat_roughness", default.clearcoat_roughness, share)?,
        sheen_color: f.or("sheen_color", default.sheen_color, Node::color)?,
        sheen_roughness: f.or("sheen_roughness", default.sheen_roughness, share)?,
        iridescence: f.or("iridescence", default.iridescence, share)?,
        iridescence_ior: f.or("iridescence_ior", default.iridescence_ior, |node| {
            Ok(node.within(1.0, 10.0)? as f32)
        })?,
        iridescence_thickness: f.or("iridescence_thickness", 400.0, |node| {
            node.within(0.0, 10_000.0)
        })? as f32,
        base_color: default.base_color,
    })
}

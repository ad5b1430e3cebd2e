//! What the picture is taken with: film, integrator, environment and lights.

use crate::color::Tonemap;
use crate::film::Filter;
use crate::light::{Cone, Light, PointLight};
use crate::scene::description::EnvironmentDescription;
use crate::scene::{FilmSettings, IntegratorSettings};

use super::fields::{Choice, Fields};
use super::sky;
use super::tree::{Node, Result};

pub(super) fn film(node: &Node) -> Result<FilmSettings> {
    let default = FilmSettings::default();
    let mut f = Fields::of(node, "film")?;
    let film = FilmSettings {
        size: f.or("size", default.size, |node| {
            let [width, height] = node.tuple("`(width, height)`")?;
            Ok((width.count(1, 65_536)?, height.count(1, 65_536)?))
        })?,
        spp: f.or("spp", default.spp, |node| node.count(1, 1 << 24))?,
        filter: f.or("filter", default.filter, filter)?,
        tonemap: f.or("tonemap", default.tonemap, tonemap)?,
    };
    f.finish()?;
    Ok(film)
}

fn filter(node: &Node) -> Result<Filter> {
    let choice = Choice::of(node, "a filter")?;
    let radius =
        |default| choice.record(|f| f.or("radius", default, |node| node.within(0.001, 64.0)));
    Ok(match choice.name {
        "Box" => Filter::Box {
            radius: radius(0.5)?,
        },
        "Tent" => Filter::Tent {
            radius: radius(1.0)?,
        },
        "Gaussian" => Filter::Gaussian {
            radius: radius(1.5)?,
        },
        _ => return Err(choice.unknown("a filter", &["Box", "Tent", "Gaussian"])),
    })
}

fn tonemap(node: &Node) -> Result<Tonemap> {
    let choice = Choice::of(node, "a curve")?;
    match choice.name {
        "Srgb" => choice.alone(Tonemap::Srgb),
        "Gamma22" => choice.alone(Tonemap::Gamma22),
        "None" => choice.alone(Tonemap::None),
        _ => Err(choice.unknown("a curve", &["Srgb", "Gamma22", "None"])),
    }
}

pub(super) fn integrator(node: &Node) -> Result<IntegratorSettings> {
    const NAMES: [&str; 7] = [
        "Path", "Direct", "Whitted", "Normals", "Depth", "Flat", "Ao",
    ];
    let choice = Choice::of(node, "an integrator")?;
    match choice.name {
        "Path" => choice.record(|f| {
            Ok(IntegratorSettings::Path {
                max_depth: f.or("max_depth", Some(8), |node| {
                    node.unless_none(|node| node.count(0, 1_000_000))
                })?,
                russian_roulette: f.or("russian_roulette", true, Node::boolean)?,
            })
        }),
        "Direct" => choice.record(|f| {
            Ok(IntegratorSettings::Direct {
                max_depth: f.or("max_depth", 8, |node| node.count(0, 10_000))?,
            })
        }),
        "Whitted" => choice.record(|f| {
            Ok(IntegratorSettings::Whitted {
                max_depth: f.or("max_depth", 8, |node| node.count(0, 10_000))?,
                shadow_factor: f.or("shadow_factor", 0.0, |node| node.within(0.0, 1.0))? as f32,
                background: f.optional("background", Node::radiance)?,
            })
        }),
        "Normals" => choice.alone(IntegratorSettings::Normals),
        "Depth" => choice.alone(IntegratorSettings::Depth),
        "Flat" => choice.alone(IntegratorSettings::Flat),
        "Ao" => choice.record(|f| {
            Ok(IntegratorSettings::Ao {
                radius: f.optional("radius", Node::length)?,
            })
        }),
        _ => Err(choice.unknown("an integrator", &NAMES)),
    }
}

pub(super) fn environment(node: &Node) -> Result<EnvironmentDescription> {
    let choice = Choice::of(node, "an environment")?;
    choice.record(|f| match choice.name {
        "Constant" => {
            let color = f.required("color", Node::radiance)?;
            Ok(EnvironmentDescription::Constant(color))
        }
        "Image" => sky::image(f),
        "Sky" => sky::sky(f),
        _ => Err(choice.unknown("an environment", &["Constant", "Image", "Sky"])),
    })
}

pub(super) fn light(node: &Node) -> Result<Light> {
    let choice = Choice::of(node, "a light")?;
    match choice.name {
        "Point" => choice.record(|f| {
            Ok(Light::Point(PointLight {
                position: f.required("position", Node::point)?,
                intensity: f.required("intensity", Node::radiance)?,
                cone: None,
            }))
        }),
        "Spot" => choice.record(|f| Ok(Light::Point(spot(&choice, f)?))),
        "Sun" => choice.record(|f| Ok(Light::Distant(sky::sun(f)?))),
        _ => Err(choice.unknown("a light without extent", &["Point", "Spot", "Sun"])),
    }
}

fn spot<'n, 't>(choice: &Choice<'n, 't>, f: &mut Fields<'n, 't>) -> Result<PointLight> {
    let position = f.required("position", Node::point)?;
    let target = f.optional("target", |node| {
        let towards = node.point()? - position;
        (towards.try_normalize()).ok_or_else(|| node.refuse("is the same point as `position`"))
    })?;
    let direction = f.optional("direction", Node::direction)?;
    let axis = match (target, direction) {
        (Some(axis), None) | (None, Some(axis)) => axis,
        (None, None) => {
            return Err(choice
                .fault("nothing says where the `Spot` shines")
                .help("give it a `target` or a `direction`"));
        }
        (Some(_), Some(_)) => {
            return Err(choice
                .fault("the `Spot` has both a `target` and a `direction`")
                .help("leave one of them out"));
        }
    };
    let angle = f.or("angle", 45.0, |node| node.within(0.001, 180.0))?;
    let inner = f.or("inner_angle", 0.0, |node| node.within(0.0, angle))?;
    Ok(PointLight {
        position,
        intensity: f.required("intensity", Node::radiance)?,
        cone: Some(Cone::new(axis, inner.to_radians(), angle.to_radians())),
    })
}

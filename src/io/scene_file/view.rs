//! What the picture is taken with: film, camera, integrator, environment and lights.

use glam::DVec3;

use crate::camera::Camera;
use crate::color::{Rgb, Tonemap};
use crate::film::Filter;
use crate::light::PointLight;
use crate::scene::{FilmSettings, IntegratorSettings};

use super::fields::{Choice, Fields};
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

pub(super) fn camera(node: &Node, name: Option<&str>) -> Result<Camera> {
    let choice = Choice::of(node, "a camera")?;
    if choice.name != "Perspective" {
        return Err(choice.unknown("a camera", &["Perspective"]));
    }
    choice.record(|f| {
        let eye = f.required("eye", Node::point)?;
        let forward = |node: &Node| {
            let look_at = node.point()?;
            let axis = (look_at - eye).try_normalize();
            axis.map(|axis| (look_at, axis))
                .ok_or_else(|| node.refuse("is where the camera itself is: it looks nowhere"))
        };
        let (look_at, axis) = f.required("look_at", forward)?;
        let upright = |node: &Node| {
            let up = node.direction()?;
            let level = axis.cross(up).length() > 1e-6;
            (level.then_some(up)).ok_or_else(|| node.refuse("lies along the view"))
        };
        let up = f.or("up", DVec3::Y, upright)?;
        if axis.cross(up).length() <= 1e-6 {
            return Err(choice
                .fault("the camera looks straight along the y axis, which is its `up`")
                .help("give it another `up`, as in `up: (0, 0, -1)`"));
        }
        Ok(Camera {
            name: name.map(str::to_owned),
            eye,
            look_at,
            up,
            vfov: f.required("vfov", |node| {
                let degrees = node.number()?;
                let open = degrees > 0.0 && degrees < 180.0;
                (open.then_some(degrees.to_radians()))
                    .ok_or_else(|| node.refuse("degrees is not between 0 and 180"))
            })?,
            aperture: f.or("aperture", 0.0, Node::length_or_zero)?,
            focus: f.optional("focus", Node::length)?,
        })
    })
}

pub(super) fn integrator(node: &Node) -> Result<IntegratorSettings> {
    const NAMES: [&str; 6] = ["Path", "Whitted", "Normals", "Depth", "Flat", "Ao"];
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

pub(super) fn environment(node: &Node) -> Result<Rgb> {
    let choice = Choice::of(node, "an environment")?;
    match choice.name {
        "Constant" => choice.record(|f| f.required("color", Node::radiance)),
        _ => Err(choice.unknown("an environment", &["Constant"])),
    }
}

pub(super) fn light(node: &Node) -> Result<PointLight> {
    let choice = Choice::of(node, "a light")?;
    match choice.name {
        "Point" => choice.record(|f| {
            Ok(PointLight {
                position: f.required("position", Node::point)?,
                intensity: f.required("intensity", Node::radiance)?,
            })
        }),
        _ => Err(choice.unknown("a light without extent", &["Point"])),
    }
}

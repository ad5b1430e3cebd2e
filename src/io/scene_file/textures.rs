//! Textures, under their names and in the place of colours.

use glam::Vec3;

use crate::color::{Encoding, Rgb};
use crate::scene::description::TextureDescription;
use crate::texture::{Pattern, PixelFilter, Ramp, Sampling, Wrap};

use super::fields::{Choice, Fields};
use super::transforms::transform;
use super::tree::{Fault, Node, Result, Value};

const NAMES: [&str; 14] = [
    "Checker",
    "UvChecker",
    "Image",
    "Noise",
    "Turbulence",
    "Marble",
    "Wood",
    "Clouds",
    "Rings",
    "Fire",
    "Scale",
    "Channel",
    "Transform",
    "Mix",
];

/// Textures may be written inside one another this deep.
const MAX_NESTING: usize = 32;

impl Node<'_> {
    /// A colour or number in 0..=1 that may vary over a surface: `(r, g, b)`, a grey, a texture's name, or a texture.
    pub(super) fn texture(&self) -> Result<TextureDescription> {
        nested(self, 0)
    }
}

fn nested(node: &Node, depth: usize) -> Result<TextureDescription> {
    match node.value {
        Value::List(None, _) | Value::Number(_) => {
            return shade(node).map(TextureDescription::Constant);
        }
        Value::String(_) => return node.reference().map(TextureDescription::Named),
        _ if depth == MAX_NESTING => {
            let message = format!("more than {MAX_NESTING} textures inside one another");
            return Err(Fault::new(node.offset, message).help("give some of them names"));
        }
        _ => {}
    }
    let choice = Choice::of(node, "a colour, `(r, g, b)`, or a texture")?;
    let inner = |node| nested(node, depth + 1).map(Box::new);
    match choice.name {
        "Image" => choice.record(image),
        "Scale" => choice.record(|f| {
            Ok(TextureDescription::Scale {
                of: f.required("of", inner)?,
                by: f.required("by", shade)?,
            })
        }),
        "Channel" => choice.record(|f| {
            Ok(TextureDescription::Channel {
                of: f.required("of", inner)?,
                by: f.required("channel", channel)?,
            })
        }),
        "Transform" => choice.record(|f| {
            Ok(TextureDescription::Transform {
                of: f.required("of", inner)?,
                transform: f.required("transform", transform)?,
            })
        }),
        "Mix" => choice.record(|f| {
            Ok(TextureDescription::Mix {
                a: f.required("a", inner)?,
                b: f.required("b", inner)?,
                by: f.required("by", inner)?,
            })
        }),
        name => {
            let Some(default) = default_colors(name) else {
                return Err(choice.unknown("a texture", &NAMES));
            };
            choice.record(|f| {
                Ok(TextureDescription::Pattern {
                    pattern: pattern(name, f)?,
                    colors: colors(f, default)?,
                })
            })
        }
    }
}

fn pattern(name: &str, f: &mut Fields) -> Result<Pattern> {
    let octaves =
        |f: &mut Fields, default| f.or("octaves", default, |node: &Node| node.count(1, 64));
    let scale = |f: &mut Fields| f.or("scale", 1.0, Node::length);
    let step = |f: &mut Fields, default| f.or("step", default, Node::length);
    Ok(match name {
        "Checker" => Pattern::Checker {
            step: step(f, 1.0)?,
        },
        "UvChecker" => Pattern::UvChecker {
            step: step(f, 0.1)?,
        },
        "Noise" => Pattern::Noise {
            scale: scale(f)?,
            octaves: octaves(f, 1)?,
        },
        "Turbulence" => Pattern::Turbulence {
            scale: scale(f)?,
            octaves: octaves(f, 6)?,
        },
        "Marble" => Pattern::Marble {
            grain: f.or("grain", 15.0, Node::coordinate)?,
            octaves: octaves(f, 40)?,
            alpha: f.or("alpha", 0.5, Node::coordinate)?,
        },
        "Wood" => Pattern::Wood {
            grain: f.or("grain", 15.0, Node::coordinate)?,
            octaves: octaves(f, 5)?,
        },
        "Clouds" => Pattern::Clouds {
            scale: scale(f)?,
            octaves: octaves(f, 6)?,
            cover: f.or("cover", 0.5, |node| node.within(0.0, 1.0))?,
        },
        "Rings" => Pattern::Rings {
            step: step(f, 1.0)?,
            grain: f.or("grain", 0.0, Node::coordinate)?,
        },
        _ => Pattern::Fire {
            scale: scale(f)?,
            octaves: octaves(f, 6)?,
        },
    })
}

/// The colours that a pattern has where the scene gives it none; `None` where there is no such pattern.
fn default_colors(pattern: &str) -> Option<Ramp> {
    let grey = |a: f32, b: f32| Ramp::between(Rgb::splat(a), Rgb::splat(b));
    Some(match pattern {
        "Checker" | "UvChecker" | "Marble" => grey(1.0, 0.0),
        "Noise" | "Turbulence" | "Rings" => grey(0.0, 1.0),
        "Wood" => Ramp::between(Rgb::new(0.8, 0.5, 0.2), Rgb::new(0.4, 0.2, 0.1)),
        "Clouds" => Ramp::between(Rgb::new(0.18, 0.4, 0.8), Rgb::splat(0.95)),
        "Fire" => Ramp::new(vec![
            (0.0, Rgb::ZERO),
            (0.3, Rgb::new(0.4, 0.01, 0.0)),
            (0.6, Rgb::new(1.0, 0.2, 0.0)),
            (0.85, Rgb::new(1.0, 0.7, 0.1)),
            (1.0, Rgb::new(1.0, 1.0, 0.8)),
        ])?,
        _ => return None,
    })
}

/// The fields `a` and `b`, or the field `ramp`.
fn colors(f: &mut Fields, default: Ramp) -> Result<Ramp> {
    let ends = (f.optional("a", shade)?, f.optional("b", shade)?);
    let ramp = f.optional("ramp", |node| {
        if ends != (None, None) {
            return Err(node.refuse("has its own ends: leave out `a` and `b`"));
        }
        let stop = |node: &Node| {
            let [position, color] = node.tuple("`(position, (r, g, b))`")?;
            Ok((position.coordinate()? as f32, shade(color)?))
        };
        let stops: Vec<_> = node.items()?.iter().map(stop).collect::<Result<_>>()?;
        let rule = "is no ramp: it needs a colour at least, and positions that do not go down";
        Ramp::new(stops).ok_or_else(|| node.refuse(rule))
    })?;
    Ok(match (ramp, ends) {
        (Some(ramp), _) => ramp,
        (None, (None, None)) => default,
        (None, (a, b)) => Ramp::between(a.unwrap_or(default.at(0.0)), b.unwrap_or(default.at(1.0))),
    })
}

fn image(f: &mut Fields) -> Result<TextureDescription> {
    Ok(TextureDescription::Image {
        file: f.required("file", Node::reference)?,
        encoding: f.optional("color_space", |node| {
            let choice = Choice::of(node, "a colour space")?;
            match choice.name {
                "Srgb" => choice.alone(Encoding::Srgb),
                "Linear" => choice.alone(Encoding::Linear),
                _ => Err(choice.unknown("a colour space", &["Srgb", "Linear"])),
            }
        })?,
        sampling: Sampling {
            wrap: [f.or("wrap", Wrap::Repeat, wrap)?; 2],
            filter: f.or("filter", PixelFilter::Bilinear, |node| {
                let choice = Choice::of(node, "a filter")?;
                match choice.name {
                    "Bilinear" => choice.alone(PixelFilter::Bilinear),
                    "Nearest" => choice.alone(PixelFilter::Nearest),
                    _ => Err(choice.unknown("a filter", &["Bilinear", "Nearest"])),
                }
            })?,
        },
    })
}

fn wrap(node: &Node) -> Result<Wrap> {
    let choice = Choice::of(node, "a way to go on beyond the edges")?;
    match choice.name {
        "Repeat" => choice.alone(Wrap::Repeat),
        "Clamp" => choice.alone(Wrap::Clamp),
        "Mirror" => choice.alone(Wrap::Mirror),
        _ => {
            let names = ["Repeat", "Clamp", "Mirror"];
            Err(choice.unknown("a way to go on beyond the edges", &names))
        }
    }
}

/// The colour that is 1 in the channel alone.
fn channel(node: &Node) -> Result<Rgb> {
    let choice = Choice::of(node, "a channel")?;
    match choice.name {
        "Red" => choice.alone(Rgb::X),
        "Green" => choice.alone(Rgb::Y),
        "Blue" => choice.alone(Rgb::Z),
        _ => Err(choice.unknown("a channel", &["Red", "Green", "Blue"])),
    }
}

/// A colour, or a grey as one number.
fn shade(node: &Node) -> Result<Rgb> {
    match node.value {
        Value::Number(_) => Ok(Vec3::splat(node.within(0.0, 1.0)? as f32)),
        _ => node.albedo(),
    }
}

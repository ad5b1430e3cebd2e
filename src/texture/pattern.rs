//! Patterns made by formulas: a number for every point, which a ramp turns into a colour.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::noise::{fbm, harmonics, noise, turbulence};
use super::{Reach, TexturePoint};

/// A number for every surface point, most of them in 0..=1. All but [`Pattern::UvChecker`] fill space and are fixed
/// to the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Cubes, 0 in the one at the origin's positive corner and 1 in its neighbours, and so on.
    Checker {
        /// Edge length, above 0.
        step: f64,
    },
    /// Squares of the surface coordinates in the same way.
    UvChecker {
        /// Edge length in surface coordinates, above 0.
        step: f64,
    },
    /// `(1 + fbm(p / scale)) / 2`.
    Noise {
        /// Size of the largest features, above 0.
        scale: f64,
        /// How many sizes there are, each half of the one before.
        octaves: u32,
    },
    /// `turbulence(p / scale)`.
    Turbulence {
        /// As for noise.
        scale: f64,
        /// As for noise.
        octaves: u32,
    },
    /// Veins: `sin(x + y + z + grain * harmonics(p)) + alpha`.
    Marble {
        /// How much noise bends the veins.
        grain: f64,
        /// How many levels of noise.
        octaves: u32,
        /// Share of the second colour: added to the sine, which is in -1..=1.
        alpha: f64,
    },
    /// Year rings: `(1 - cos(pi frac(grain * harmonics(p)))) / 2`.
    Wood {
        /// How many rings there are to a unit of noise.
        grain: f64,
        /// How many levels of noise.
        octaves: u32,
    },
    /// Sky between clouds that grow dense inwards: `1 - exp(-8 max(0, (1 + fbm(p / scale)) / 2 - (1 - cover)))`.
    Clouds {
        /// As for noise.
        scale: f64,
        /// As for noise.
        octaves: u32,
        /// 0 is a clear sky, 1 an overcast one.
        cover: f64,
    },
    /// Spherical shells around the origin: `(1 + sin(2 pi (|p| / step + grain * noise(p / step)))) / 2`.
    Rings {
        /// From one shell to the next, above 0.
        step: f64,
        /// How much noise bends them.
        grain: f64,
    },
    /// Flames along y, bright where noise is near 0: `1 - 1.5 turbulence((x, y / 2, z) / scale)`.
    Fire {
        /// As for noise.
        scale: f64,
        /// As for noise.
        octaves: u32,
    },
}

impl Pattern {
    /// The number at a point.
    pub fn value(&self, point: &TexturePoint) -> f64 {
        let p = point.p;
        match *self {
            Self::Checker { step } => {
                // A face that lies on a boundary between cubes takes the colours just inside the
                // object everywhere, instead of flickering with the last bit of its points.
                parity(p / step - 1e-6 * point.n)
            }
            Self::UvChecker { step } => parity(point.uv.as_dvec2().extend(0.0) / step),
            Self::Noise { scale, octaves } => 0.5 + 0.5 * fbm(p / scale, octaves),
            Self::Turbulence { scale, octaves } => turbulence(p / scale, octaves),
            Self::Marble {
                grain,
                octaves,
                alpha,
            } => (p.element_sum() + grain * harmonics(p, octaves)).sin() + alpha,
            Self::Wood { grain, octaves } => {
                let v = grain * harmonics(p, octaves);
                0.5 - 0.5 * (PI * (v - v.floor())).cos()
            }
            Self::Clouds {
                scale,
                octaves,
                cover,
            } => {
                let depth = 0.5 + 0.5 * fbm(p / scale, octaves) - (1.0 - cover);
                1.0 - (-8.0 * depth.max(0.0)).exp()
            }
            Self::Rings { step, grain } => {
                let r = p.length() / step + grain * noise(p / step);
                0.5 + 0.5 * (TAU * r).sin()
            }
            Self::Fire { scale, octaves } => {
                let q = DVec3::new(p.x, 0.5 * p.y, p.z) / scale;
                1.0 - 1.5 * turbulence(q, octaves)
            }
        }
    }

    /// A small part of its smallest features.
    pub(super) fn reach(&self) -> Reach {
        let space = match *self {
            Self::UvChecker { step } => {
                return Reach {
                    uv: step / FINE,
                    ..Reach::ENDLESS
                };
            }
            Self::Checker { step } => step,
            Self::Noise { scale, octaves }
            | Self::Turbulence { scale, octaves }
            | Self::Clouds { scale, octaves, .. }
            | Self::Fire { scale, octaves } => scale * 2.0_f64.powi(1 - octaves as i32),
            Self::Marble { grain, octaves, .. } | Self::Wood { grain, octaves } => {
                1.0 / (1.0 + 0.05 * grain.abs() * f64::from(octaves))
            }
            Self::Rings { step, grain } => step / (1.0 + grain.abs()),
        };
        Reach {
            space: space / FINE,
            ..Reach::ENDLESS
        }
    }
}

/// Parts of a feature between which a pattern is as good as straight, and f32 still sees a difference.
const FINE: f64 = 256.0;

/// Which colour a cell has: 0 or 1.
fn parity(cell: DVec3) -> f64 {
    cell.floor().element_sum().rem_euclid(2.0)
}

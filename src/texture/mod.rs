//! Colour as a function of the surface point.

mod bitmap;
mod noise;
mod pattern;
mod ramp;

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2};

use crate::color::{Rgb, luminance};
use crate::math::Transform;

pub use bitmap::{Bitmap, PixelFilter, Sampling, Wrap, bilinear};
pub use noise::{fbm, harmonics, noise, turbulence};
pub use pattern::Pattern;
pub use ramp::Ramp;

/// Where a texture is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint {
    /// The point in object space.
    pub p: DVec3,
    /// The outward geometric normal in object space, unit length.
    pub n: DVec3,
    /// Surface coordinates.
    pub uv: Vec2,
}

/// A colour that may vary over a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// The same everywhere.
    Constant(Rgb),
    /// A pattern's numbers as colours.
    Pattern {
        /// A number for every point.
        pattern: Pattern,
        /// A colour for every number.
        colors: Ramp,
    },
    /// A picture laid over the surface coordinates, times `scale`.
    Image {
        /// The picture.
        image: Arc<Bitmap>,
        /// Multiplies each channel.
        scale: Rgb,
        /// How it is looked up.
        sampling: Sampling,
    },
    /// A texture times a colour.
    Scale {
        /// The texture.
        of: Arc<Texture>,
        /// Multiplies each channel.
        by: Rgb,
    },
    /// A grey: the sum of a texture's channels, each times its part of `by`; for one channel as a number.
    Channel {
        /// The texture.
        of: Arc<Texture>,
        /// `Rgb::X` for red, and so on.
        by: Rgb,
    },
    /// A texture in a space of its own; surface coordinates are moved along, as the point (u, v, 0).
    Transform {
        /// The texture.
        of: Arc<Texture>,
        /// From the object's space to the texture's.
        texture_from_object: Box<Transform>,
    },
    /// From `a` to `b`, straight in linear light, as `by` goes from 0 to 1.
    Mix {
        /// Where `by` is 0 or less.
        a: Arc<Texture>,
        /// Where `by` is 1 or more.
        b: Arc<Texture>,
        /// As a scalar.
        by: Arc<Texture>,
    },
}

impl From<f32> for Texture {
    /// The same grey everywhere.
    fn from(value: f32) -> Self {
        Self::Constant(Rgb::splat(value))
    }
}

impl Texture {
    /// The picture `image`, bilinear and repeated, times `scale`.
    pub fn image(image: Arc<Bitmap>, scale: Rgb) -> Self {
        Self::Image {
            image,
            scale,
            sampling: Sampling::default(),
        }
    }

    /// The colour at a point.
    pub fn eval(&self, point: &TexturePoint) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            Self::Pattern { pattern, colors } => colors.at(pattern.value(point) as f32),
            Self::Image {
                image,
                scale,
                sampling,
            } => image.sample(point.uv, *sampling) * *scale,
            Self::Scale { of, by } => of.eval(point) * *by,
            Self::Channel { of, by } => Rgb::splat(of.eval(point).dot(*by)),
            Self::Transform {
                of,
                texture_from_object: t,
            } => of.eval(&TexturePoint {
                p: t.point(point.p),
                n: t.normal(point.n),
                uv: t
                    .point(point.uv.as_dvec2().extend(0.0))
                    .truncate()
                    .as_vec2(),
            }),
            Self::Mix { a, b, by } => {
                // What is not seen is not evaluated.
                match by.eval_scalar(point) {
                    t if t <= 0.0 => a.eval(point),
                    t if t >= 1.0 => b.eval(point),
                    t => a.eval(point).lerp(b.eval(point), t),
                }
            }
        }
    }

    /// The luminance at a point: where a number is wanted, and of a grey its value. Who wants one channel takes it from
    /// [`Texture::eval`].
    pub fn eval_scalar(&self, point: &TexturePoint) -> f32 {
        luminance(self.eval(point))
    }

    /// The luminance, cut to 0..=1.
    pub fn eval_share(&self, point: &TexturePoint) -> f32 {
        self.eval_scalar(point).clamp(0.0, 1.0)
    }

    /// Whether it is the same grey everywhere.
    pub fn is(&self, value: f32) -> bool {
        matches!(self, Self::Constant(color) if *color == Rgb::splat(value))
    }

    /// How far [`Texture::slope`] looks.
    fn reach(&self) -> Reach {
        match self {
            Self::Constant(_) => Reach::ENDLESS,
            Self::Pattern { pattern, .. } => pattern.reach(),
            // Half a pixel each way: between neighbours, and without steps where one pair follows another.
            Self::Image { image, .. } => Reach {
                uv: 0.5 / image.width.max(image.height) as f64,
                ..Reach::ENDLESS
            },
            Self::Scale { of, .. } | Self::Channel { of, .. } => of.reach(),
            Self::Transform {
                of,
                texture_from_object: t,
            } => {
                let inner = of.reach();
                Reach {
                    space: inner.space / t.max_stretch(),
                    uv: inner.uv / t.max_stretch(),
                }
            }
            Self::Mix { a, b, by } => a.reach().min(b.reach()).min(by.reach()),
        }
    }

    /// How fast the scalar grows at a point along `direction` of object space, a tangent of unit length, when surface
    /// coordinates grow by `uv_rate` along it: a central difference over a small part of the texture's features.
    pub fn slope(&self, point: &TexturePoint, direction: DVec3, uv_rate: DVec2) -> f64 {
        let reach = self.reach();
        let reach = reach.space.min(reach.uv / uv_rate.abs().max_element());
        // Nothing varies along it, or the surface coordinates have no derivative.
        if !reach.is_finite() || reach == 0.0 {
            return 0.0;
        }
        let value = |s: f64| {
            f64::from(self.eval_scalar(&TexturePoint {
                p: point.p + s * direction,
                n: point.n,
                uv: (point.uv.as_dvec2() + s * uv_rate).as_vec2(),
            }))
        };
        (value(reach) - value(-reach)) / (2.0 * reach)
    }

    /// How many textures it is made of, itself included; one that is used twice counts twice, as it is evaluated.
    pub fn parts(&self) -> usize {
        1 + match self {
            Self::Constant(_) | Self::Pattern { .. } | Self::Image { .. } => 0,
            Self::Scale { of, .. } | Self::Channel { of, .. } | Self::Transform { of, .. } => {
                of.parts()
            }
            Self::Mix { a, b, by } => a.parts() + b.parts() + by.parts(),
        }
    }
}

/// Over what distances a texture hardly changes: in object space, and in surface coordinates.
#[derive(Clone, Copy)]
struct Reach {
    space: f64,
    uv: f64,
}

impl Reach {
    /// Of what never changes.
    const ENDLESS: Self = Self {
        space: f64::INFINITY,
        uv: f64::INFINITY,
    };

    fn min(self, other: Self) -> Self {
        Self {
            space: self.space.min(other.space),
            uv: self.uv.min(other.uv),
        }
    }
}

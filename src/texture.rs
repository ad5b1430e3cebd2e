//! Colour as a function of the surface point.

use std::sync::Arc;

use glam::{DVec3, Vec2};

use crate::color::Rgb;

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
    /// Cubes of edge `step`, alternating in all three directions, fixed to the object.
    Checker {
        /// Colour of the cube at the origin's positive corner.
        a: Rgb,
        /// The other colour.
        b: Rgb,
        /// Edge length, above 0.
        step: f64,
    },
    /// A picture laid over the surface coordinates, repeated, times `scale`.
    Image {
        /// The picture.
        image: Arc<Bitmap>,
        /// Multiplies each channel.
        scale: Rgb,
    },
}

/// A decoded picture in linear light, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// Pixels across, at least 1.
    pub width: usize,
    /// Pixels down, at least 1.
    pub height: usize,
    /// `width * height` colours.
    pub pixels: Vec<Rgb>,
}

impl Bitmap {
    /// Bilinear lookup; `uv` repeats, v = 0 is the bottom edge.
    fn sample(&self, uv: Vec2) -> Rgb {
        let (w, h) = (self.width as i64, self.height as i64);
        let x = f64::from(uv.x - uv.x.floor()) * w as f64 - 0.5;
        let y = (1.0 - f64::from(uv.y - uv.y.floor())) * h as f64 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
        let at = |dx: i64, dy: i64| {
            let column = (x0 as i64 + dx).rem_euclid(w);
            let row = (y0 as i64 + dy).rem_euclid(h);
            self.pixels[(row * w + column) as usize]
        };
        let top = at(0, 0).lerp(at(1, 0), fx);
        let bottom = at(0, 1).lerp(at(1, 1), fx);
        top.lerp(bottom, fy)
    }
}

impl Texture {
    /// The colour at a point.
    pub fn eval(&self, point: &TexturePoint) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            Self::Checker { a, b, step } => {
                // A face that lies on a boundary between cubes takes the colours just inside the
                // object everywhere, instead of flickering with the last bit of its points.
                let cell = (point.p / *step - 1e-6 * point.n).floor();
                let odd = (cell.x + cell.y + cell.z).rem_euclid(2.0) != 0.0;
                if odd { *b } else { *a }
            }
            Self::Image { image, scale } => image.sample(point.uv) * *scale,
        }
    }
}

//! Pictures laid over surface coordinates.

use std::ops::{Add, Mul};

use glam::Vec2;

use crate::color::Rgb;

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

/// How a picture is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampling {
    /// What lies beyond the picture's left and right edges, and beyond its lower and upper ones.
    pub wrap: [Wrap; 2],
    /// What lies between pixels.
    pub filter: PixelFilter,
}

/// What lies beyond the edges of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The pixels at the edge.
    Clamp,
    /// The picture's mirror image.
    Mirror,
}

/// What lies between the centres of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelFilter {
    /// The mean of the four around, weighted by distance in both directions.
    #[default]
    Bilinear,
    /// The pixel itself.
    Nearest,
}

impl Wrap {
    /// The pixel that stands for pixel `i` (a whole number) of a row of `count`.
    fn index(self, i: f64, count: usize) -> usize {
        let n = count as f64;
        let i = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0.0, n - 1.0),
            Self::Mirror => {
                let i = i.rem_euclid(2.0 * n);
                i.min(2.0 * n - 1.0 - i)
            }
        };
        i as usize
    }
}

impl Bitmap {
    /// The picture's colour at `uv`: (0, 0) is its lower left corner, (1, 1) the upper right one.
    pub fn sample(&self, uv: Vec2, sampling: Sampling) -> Rgb {
        let x = f64::from(uv.x) * self.width as f64;
        let y = (1.0 - f64::from(uv.y)) * self.height as f64;
        match sampling.filter {
            PixelFilter::Nearest => self.pixels[self.index(x.floor(), y.floor(), sampling.wrap)],
            PixelFilter::Bilinear => {
                let (pixels, between) = self.around(x, y, sampling.wrap);
                bilinear(pixels.map(|i| self.pixels[i]), between)
            }
        }
    }

    /// The indices of the four pixels whose centres are around a point, `x` to the right and `y` down from the upper left
    /// corner in pixels: the upper two, then the lower two; and how far it is from the left ones to the right ones, and
    /// from the upper ones to the lower ones.
    pub fn around(&self, x: f64, y: f64, wrap: [Wrap; 2]) -> ([usize; 4], [f32; 2]) {
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        (
            corners.map(|(right, down)| self.index(x0 + right, y0 + down, wrap)),
            [(x - x0) as f32, (y - y0) as f32],
        )
    }

    /// Where the pixel in column `x` and row `y`, whole numbers, is in the list.
    fn index(&self, x: f64, y: f64, wrap: [Wrap; 2]) -> usize {
        wrap[1].index(y, self.height) * self.width + wrap[0].index(x, self.width)
    }
}

/// The mean of the values of four pixels, given as [`Bitmap::around`] does.
pub fn bilinear<T>([a, b, c, d]: [T; 4], [right, down]: [f32; 2]) -> T
where
    T: Add<Output = T> + Mul<f32, Output = T>,
{
    let upper = a * (1.0 - right) + b * right;
    let lower = c * (1.0 - right) + d * right;
    upper * (1.0 - down) + lower * down
}

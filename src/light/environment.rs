use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2};

use crate::color::{Rgb, luminance};
use crate::texture::{Bitmap, Wrap, bilinear};

use super::{LightSample, Source};

/// A picture of all directions, infinitely far away: equirectangular as a panorama camera renders it. Its middle column
/// looks along -z, what lies to the right of that (+x) is in the right half, and the uppermost row is around +y.
///
/// Between the centres of pixels it is interpolated, and light sampling draws from that very interpolation, of luminance
/// times the sine of the row's polar angle: a pixel by its weight, then a point of the tent around it. Beyond the pole a
/// tent folds back, as the lookup repeats the last row there.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    bitmap: Bitmap,
    /// What is added to longitudes, in turns.
    turn: f64,
    /// For each row the factor of its pixels' luminance in the density, which has still to be divided by the sine of the
    /// polar angle; 0 in black pictures.
    row_factors: Vec<f32>,
    /// The share of each row and those above it.
    rows: Vec<f32>,
    /// For each pixel its share of its row and those to its left.
    columns: Vec<f32>,
    /// The radiance of all directions.
    total: Rgb,
}

/// What lies beyond the edges of the picture: itself, and at the poles its last row.
const WRAP: [Wrap; 2] = [Wrap::Repeat, Wrap::Clamp];

/// Nearer to the poles than this the density does not grow any further.
const LEAST_SINE: f64 = 1e-6;

impl EnvironmentMap {
    /// Of a picture whose pixels are finite and at least 0, turned by `rotate` radians about +y, as objects are.
    pub fn new(bitmap: Bitmap, rotate: f64) -> Self {
        let (width, height) = (bitmap.width, bitmap.height);
        let pixel = TAU / width as f64 * PI / height as f64;
        let sine = |row: usize| ((row as f64 + 0.5) / height as f64 * PI).sin();
        let mut columns = Vec::with_capacity(width * height);
        let mut weights = Vec::with_capacity(height);
        let mut total = DVec3::ZERO;
        for (row, pixels) in bitmap.pixels.chunks(width).enumerate() {
            columns.extend(cumulative(pixels.iter().map(|&p| f64::from(luminance(p)))));
            let sum = pixels.iter().fold(DVec3::ZERO, |sum, p| sum + p.as_dvec3());
            let light: f64 = pixels.iter().map(|&p| f64::from(luminance(p))).sum();
            total += sum * sine(row) * pixel;
            weights.push(light * sine(row));
        }
        let sum = weights.iter().sum::<f64>() * pixel;
        let factor = |row: usize| if sum > 0.0 { sine(row) / sum } else { 0.0 };
        Self {
            turn: rotate / TAU,
            row_factors: (0..height).map(|row| factor(row) as f32).collect(),
            rows: cumulative(weights.iter().copied()).collect(),
            columns,
            total: total.as_vec3(),
            bitmap,
        }
    }

    /// Density as the picture is bright.
    pub(super) fn sample(&self, u2: Vec2) -> Option<LightSample> {
        let (width, height) = (self.bitmap.width, self.bitmap.height);
        let (row, v) = choose(&self.rows, u2.y)?;
        let (column, u) = choose(&self.columns[row * width..][..width], u2.x)?;
        let x = column as f64 + 0.5 + tent(u);
        let y = (row as f64 + 0.5 + tent(v)).abs();
        let y = y.min(2.0 * height as f64 - y);
        let longitude = (x / width as f64 - 0.5 - self.turn) * TAU;
        let (right, ahead) = longitude.sin_cos();
        let (level, rise) = (y / height as f64 * PI).sin_cos();
        let wi = DVec3::new(level * right, rise, -level * ahead);
        let (li, pdf) = self.beyond(wi);
        (pdf > 0.0).then_some(LightSample {
            source: Source::Direction(wi),
            li,
            pdf,
        })
    }

    /// The radiance from the unit direction `wi`, and the density per solid angle with which [`Self::sample`] draws it.
    pub fn beyond(&self, wi: DVec3) -> (Rgb, f32) {
        let (width, height) = (self.bitmap.width as f64, self.bitmap.height as f64);
        let level = wi.x.hypot(wi.z);
        let x = (wi.x.atan2(-wi.z) / TAU + 0.5 + self.turn) * width;
        let y = level.atan2(wi.y) / PI * height;
        let (pixels, between) = self.bitmap.around(x, y, WRAP);
        let colors = pixels.map(|i| self.bitmap.pixels[i]);
        let weights = pixels
            .map(|i| luminance(self.bitmap.pixels[i]) * self.row_factors[i / self.bitmap.width]);
        let density = bilinear(weights, between) / level.max(LEAST_SINE) as f32;
        (bilinear(colors, between), density)
    }

    /// Radiance over all directions, summed over channels.
    pub(super) fn power(&self) -> f64 {
        f64::from(self.total.element_sum())
    }
}

/// The shares of `weights` up to and including each; all 0 where the weights are.
fn cumulative(weights: impl Iterator<Item = f64> + Clone) -> impl Iterator<Item = f32> {
    let total: f64 = weights.clone().sum();
    let mut sum = 0.0;
    weights.map(move |w| {
        sum += w;
        if total > 0.0 {
            (sum / total) as f32
        } else {
            0.0
        }
    })
}

/// The index whose share `u` falls into, and how far into it.
fn choose(cumulative: &[f32], u: f32) -> Option<(usize, f32)> {
    let index = cumulative.partition_point(|&c| c <= u);
    let end = *cumulative.get(index)?;
    let start = if index == 0 {
        0.0
    } else {
        cumulative[index - 1]
    };
    Some((index, (u - start) / (end - start)))
}

/// From -1 to 1, with a density that falls from 0 to both sides in proportion.
fn tent(u: f32) -> f64 {
    let u = f64::from(u);
    if u < 0.5 {
        (2.0 * u).sqrt() - 1.0
    } else {
        1.0 - (2.0 * (1.0 - u)).sqrt()
    }
}

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2};

use crate::color::{Rgb, luminance};
use crate::texture::{Bitmap, Wrap, bilinear};

use super::{LightSample, Source};

/// A picture of all directions, infinitely far away: equirectangular as a panorama camera renders it. Its middle column
/// looks along -z, what lies to the right of that (+x) is in the right half, and the uppermost row is around +y.
///
/// Between the centres of pixels it is interpolated, and light sampling draws from the same interpolation of weights: a
/// pixel by its weight, then a point of the tent around it. Beyond the pole a tent folds back, as the lookup repeats the
/// last row there. A pixel's weight is what its luminance has above the mean of all directions, times the sine of its polar
/// angle; what is below the mean is left to samples of surfaces (Karlík et al. 2019, "MIS Compensation").
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    bitmap: Bitmap,
    /// What is added to longitudes, in turns.
    turn: f64,
    /// Of the luminance, over all directions.
    mean: f32,
    /// For each row the factor of its pixels' excess in the density, which has still to be divided by the sine of the
    /// polar angle; 0 in even pictures.
    row_factors: Vec<f32>,
    /// The share of each row and those above it.
    rows: Vec<f32>,
    /// For each pixel its share of its row and those to its left.
    columns: Vec<f32>,
    /// The excess over all directions.
    total: f64,
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
        let rows = || bitmap.pixels.chunks(width).enumerate();
        let light = |row: &[Rgb]| -> f64 { row.iter().map(|&p| f64::from(luminance(p))).sum() };
        let all: f64 = rows().map(|(i, row)| sine(i) * light(row)).sum();
        let sines: f64 = (0..height).map(sine).sum();
        let mean = (all / (sines * width as f64)) as f32;
        let of_row = |row: &[Rgb]| -> f64 { row.iter().map(|&p| f64::from(excess(p, mean))).sum() };
        let weights: Vec<f64> = rows().map(|(i, row)| sine(i) * of_row(row)).collect();
        let total = weights.iter().sum::<f64>() * pixel;
        let factor = |row: usize| if total > 0.0 { sine(row) / total } else { 0.0 };
        let columns = rows()
            .flat_map(|(_, row)| cumulative(row.iter().map(move |&p| f64::from(excess(p, mean)))));
        Self {
            turn: rotate / TAU,
            mean,
            row_factors: (0..height).map(|row| factor(row) as f32).collect(),
            rows: cumulative(weights.iter().copied()).collect(),
            columns: columns.collect(),
            total,
            bitmap,
        }
    }

    /// A direction in which there is more light than on average.
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
            face: 0,
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
        let weights = pixels.map(|i| {
            excess(self.bitmap.pixels[i], self.mean) * self.row_factors[i / self.bitmap.width]
        });
        let density = bilinear(weights, between) / level.max(LEAST_SINE) as f32;
        (bilinear(colors, between), density)
    }

    /// What is above the mean over all directions, summed over channels.
    pub(super) fn power(&self) -> f64 {
        3.0 * self.total
    }
}

/// What a pixel's luminance has above the mean.
fn excess(color: Rgb, mean: f32) -> f32 {
    (luminance(color) - mean).max(0.0)
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

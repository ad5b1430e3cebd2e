//! Integrals over cells of the sphere, halved until they settle.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

/// Gauss and Legendre's points and weights on 0..=1.
const POINTS: [(f32, f64); 4] = [
    (0.069_431_84, 0.173_927_422_568_727),
    (0.330_009_5, 0.326_072_577_431_273),
    (0.669_990_5, 0.326_072_577_431_273),
    (0.930_568_16, 0.173_927_422_568_727),
];

/// A part of the sphere: polar angles and azimuths between bounds.
#[derive(Clone, Copy)]
pub struct Cell {
    pub polar: [f32; 2],
    pub azimuth: [f32; 2],
}

impl Cell {
    /// `rows` bands by `columns`; for an even number of rows a boundary lies on the horizon.
    pub fn all(rows: usize, columns: usize) -> Vec<Self> {
        let row = |i| PI * i as f32 / rows as f32;
        let column = |j| TAU * j as f32 / columns as f32;
        let cell = |k: usize| {
            let (i, j) = (k / columns, k % columns);
            Self {
                polar: [row(i), row(i + 1)],
                azimuth: [column(j), column(j + 1)],
            }
        };
        (0..rows * columns).map(cell).collect()
    }

    /// Which of [`Cell::all`] a direction is in.
    pub fn index(w: Vec3, rows: usize, columns: usize) -> usize {
        let turn = (w.y.atan2(w.x) / TAU).rem_euclid(1.0);
        let polar = w.truncate().length().atan2(w.z);
        let row = (polar / PI * rows as f32) as usize;
        let column = (turn * columns as f32) as usize;
        row.min(rows - 1) * columns + column.min(columns - 1)
    }

    /// A direction in the cell, and the sine of its polar angle.
    fn at(&self, u: f32, v: f32) -> (Vec3, f32) {
        let theta = self.polar[0] + u * (self.polar[1] - self.polar[0]);
        let phi = self.azimuth[0] + v * (self.azimuth[1] - self.azimuth[0]);
        let (sin, cos) = theta.sin_cos();
        (Vec3::new(sin * phi.cos(), sin * phi.sin(), cos), sin)
    }

    fn gauss(&self, f: &impl Fn(Vec3) -> f64) -> f64 {
        let mut sum = 0.0;
        for (u, a) in POINTS {
            for (v, b) in POINTS {
                let (w, sin) = self.at(u, v);
                sum += a * b * f64::from(sin) * f(w);
            }
        }
        let height = f64::from(self.polar[1] - self.polar[0]);
        sum * height * f64::from(self.azimuth[1] - self.azimuth[0])
    }

    /// The integral of `f` per solid angle, to about `tolerance`.
    pub fn integral(&self, tolerance: f64, f: &impl Fn(Vec3) -> f64) -> f64 {
        self.refine(self.gauss(f), tolerance, 0, f)
    }

    fn refine(&self, whole: f64, tolerance: f64, depth: u32, f: &impl Fn(Vec3) -> f64) -> f64 {
        let halves = |[a, b]: [f32; 2]| [[a, 0.5 * (a + b)], [0.5 * (a + b), b]];
        let mut parts = Vec::with_capacity(4);
        for polar in halves(self.polar) {
            for azimuth in halves(self.azimuth) {
                let cell = Self { polar, azimuth };
                parts.push((cell, cell.gauss(f)));
            }
        }
        let sum: f64 = parts.iter().map(|(_, part)| *part).sum();
        if depth == 10 || (sum - whole).abs() < tolerance {
            return sum;
        }
        let refined =
            |(cell, part): &(Self, f64)| cell.refine(*part, 0.5 * tolerance, depth + 1, f);
        parts.iter().map(refined).sum()
    }
}

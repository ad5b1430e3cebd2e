//! Integrals over cells of the sphere, halved until they settle.

use std::f32::consts::TAU;

use glam::{DVec4, Vec3};

/// Gauss and Legendre's points and weights on 0..=1.
const POINTS: [(f32, f64); 4] = [
    (0.069_431_84, 0.173_927_422_568_727),
    (0.330_009_48, 0.326_072_577_431_273),
    (0.669_990_52, 0.326_072_577_431_273),
    (0.930_568_16, 0.173_927_422_568_727),
];

/// A part of the sphere: cosines and azimuths between bounds. The azimuth is 0 opposite to the view.
#[derive(Clone, Copy)]
pub struct Cell {
    pub cosine: [f32; 2],
    pub azimuth: [f32; 2],
}

impl Cell {
    /// `rows` bands of equal height by `columns`; a boundary lies on the horizon.
    pub fn all(rows: usize, columns: usize) -> Vec<Self> {
        let row = |i| 2.0 * i as f32 / rows as f32 - 1.0;
        let column = |j| TAU * j as f32 / columns as f32;
        let cell = |k: usize| {
            let (i, j) = (k / columns, k % columns);
            Self {
                cosine: [row(i), row(i + 1)],
                azimuth: [column(j), column(j + 1)],
            }
        };
        (0..rows * columns).map(cell).collect()
    }

    /// Which of [`Cell::all`] a direction is in.
    pub fn index(w: Vec3, rows: usize, columns: usize) -> usize {
        let turn = (w.y.atan2(w.x) / TAU).rem_euclid(1.0);
        let row = (0.5 * (w.z + 1.0) * rows as f32) as usize;
        let column = (turn * columns as f32) as usize;
        row.min(rows - 1) * columns + column.min(columns - 1)
    }

    fn at(&self, u: f32, v: f32) -> Vec3 {
        let z = self.cosine[0] + u * (self.cosine[1] - self.cosine[0]);
        let phi = self.azimuth[0] + v * (self.azimuth[1] - self.azimuth[0]);
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    fn gauss(&self, f: &impl Fn(Vec3) -> DVec4) -> DVec4 {
        let mut sum = DVec4::ZERO;
        for (u, a) in POINTS {
            for (v, b) in POINTS {
                sum += a * b * f(self.at(u, v));
            }
        }
        let height = f64::from(self.cosine[1] - self.cosine[0]);
        sum * height * f64::from(self.azimuth[1] - self.azimuth[0])
    }

    /// The integral of `f` per solid angle, each part to about `tolerance`.
    pub fn integral(&self, tolerance: f64, f: &impl Fn(Vec3) -> DVec4) -> DVec4 {
        self.refine(self.gauss(f), tolerance, 0, f)
    }

    fn refine(
        &self,
        whole: DVec4,
        tolerance: f64,
        depth: u32,
        f: &impl Fn(Vec3) -> DVec4,
    ) -> DVec4 {
        let halves = |[a, b]: [f32; 2]| [[a, 0.5 * (a + b)], [0.5 * (a + b), b]];
        let mut parts = Vec::with_capacity(4);
        for cosine in halves(self.cosine) {
            for azimuth in halves(self.azimuth) {
                let cell = Self { cosine, azimuth };
                parts.push((cell, cell.gauss(f)));
            }
        }
        let sum: DVec4 = parts.iter().map(|(_, part)| *part).sum();
        if depth == 10 || (sum - whole).abs().max_element() < tolerance {
            return sum;
        }
        let refined =
            |(cell, part): &(Self, DVec4)| cell.refine(*part, 0.5 * tolerance, depth + 1, f);
        parts.iter().map(refined).sum()
    }
}

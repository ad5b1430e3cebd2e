use std::f64::consts::PI;

use glam::{DVec3, Vec2};

use crate::color::Rgb;
use crate::sampling::uniform_triangle;

use super::{LightSample, Source};

/// A triangle in world space that emits `radiance` from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLight {
    /// First corner.
    pub corner: DVec3,
    /// From the first corner to the second and third.
    pub edges: [DVec3; 2],
    /// W/(m² sr).
    pub radiance: Rgb,
    /// How far off the surface a point must be to lie clearly in front of it.
    pub error: f64,
}

impl TriangleLight {
    /// Uniform in area.
    pub(super) fn sample(&self, from: DVec3, u2: Vec2) -> Option<LightSample> {
        let uv = uniform_triangle(u2).as_dvec2();
        let p = self.corner + uv.x * self.edges[0] + uv.y * self.edges[1];
        let pdf = self.pdf(from, p);
        let cross = self.cross();
        let n = (cross / cross.length()) * (from - p).dot(cross).signum();
        (pdf > 0.0 && pdf.is_finite()).then(|| LightSample {
            source: Source::Point(p + self.error * n),
            li: self.radiance,
            pdf,
        })
    }

    /// Density in area turned into solid angle: d² / (|cos| area).
    pub(super) fn pdf(&self, from: DVec3, p: DVec3) -> f32 {
        let to = p - from;
        let d2 = to.length_squared();
        // |to . cross| is d |cos| times twice the area.
        let facing = 0.5 * to.dot(self.cross()).abs();
        if facing > 0.0 {
            (d2 * d2.sqrt() / facing) as f32
        } else {
            0.0
        }
    }

    fn cross(&self) -> DVec3 {
        self.edges[0].cross(self.edges[1])
    }

    pub(super) fn power(&self) -> f64 {
        2.0 * PI * 0.5 * self.cross().length() * f64::from(self.radiance.element_sum())
    }
}

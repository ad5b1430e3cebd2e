use std::f64::consts::TAU;

use glam::{DVec3, Vec2};

use crate::color::Rgb;
use crate::sampling::{SphericalTriangle, uniform_triangle};

use super::flat::{Flat, SMALL};
use super::surface::SurfaceSample;

/// A triangle in world space that emits `radiance` from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLight {
    corner: DVec3,
    /// From the corner to the second and third.
    edges: [DVec3; 2],
    flat: Flat,
    /// W/(m² sr).
    pub radiance: Rgb,
    error: f64,
}

impl TriangleLight {
    /// Of `corners` that are not on a line; `error` is how far off the surface a point must be to lie clearly in front
    /// of it.
    pub fn new([a, b, c]: [DVec3; 3], radiance: Rgb, error: f64) -> Self {
        let edges = [b - a, c - a];
        Self {
            corner: a,
            edges,
            flat: Flat::new(edges, 0.5),
            radiance,
            error,
        }
    }

    /// Uniform in solid angle from nearby, else in area.
    pub(super) fn sample(&self, from: DVec3, u2: Vec2) -> Option<SurfaceSample> {
        let to = self.corner - from;
        let n = self.flat.normal_towards(to, self.error)?;
        let (p, pdf) = if let Some(seen) = self.seen(to) {
            let direction = seen.sample(u2.as_dvec2());
            let p = from + n.dot(to) / n.dot(direction) * direction;
            let on_plane = p - n.dot(p - self.corner) * n;
            (on_plane, seen.solid_angle().recip())
        } else {
            let p = self.point(u2);
            (p, self.flat.pdf(p - from))
        };
        Some(SurfaceSample {
            p: p + self.error * n,
            face: 0,
            pdf,
        })
    }

    pub(super) fn pdf(&self, from: DVec3, p: DVec3) -> f64 {
        let to = self.corner - from;
        if self.flat.normal_towards(to, self.error).is_none() {
            return 0.0;
        }
        match self.seen(to) {
            Some(seen) => seen.solid_angle().recip(),
            None => self.flat.pdf(p - from),
        }
    }

    /// A point, uniform in area.
    pub(super) fn point(&self, u2: Vec2) -> DVec3 {
        let uv = uniform_triangle(u2).as_dvec2();
        self.corner + uv.x * self.edges[0] + uv.y * self.edges[1]
    }

    /// What directions are drawn from, the corner being seen at `to`; `None` where the triangle is too far for that to
    /// be worth its time, or its solid angle too small or too close to a hemisphere for rounding.
    fn seen(&self, to: DVec3) -> Option<SphericalTriangle> {
        let [b, c] = self.edges;
        if !self.flat.is_near(to + (b + c) / 3.0) {
            return None;
        }
        let seen = SphericalTriangle::new([to, to + b, to + c]);
        (SMALL..TAU - SMALL)
            .contains(&seen.solid_angle())
            .then_some(seen)
    }

    /// Of both sides.
    pub(super) fn area(&self) -> f64 {
        2.0 * self.flat.area()
    }
}

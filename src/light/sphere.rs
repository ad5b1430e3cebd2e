use std::f64::consts::PI;

use glam::{DVec3, Vec2};

use crate::color::Rgb;
use crate::math::Frame;
use crate::sampling::{uniform_cone, uniform_cone_pdf, uniform_sphere};

use super::surface::SurfaceSample;

/// A sphere in world space that emits `radiance` from every point of its surface, inward too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    /// Centre.
    pub center: DVec3,
    /// Above 0.
    pub radius: f64,
    /// W/(m² sr).
    pub radiance: Rgb,
    /// How far off the surface a point must be to lie clearly in front of it.
    pub error: f64,
}

impl SphereLight {
    /// From outside, uniform over the cone in which the sphere is seen; from inside, over all directions.
    pub(super) fn sample(&self, from: DVec3, u2: Vec2) -> Option<SurfaceSample> {
        let axis = self.center - from;
        let one_minus_cos = self.one_minus_cos(from)?;
        let frame = Frame::around(axis.try_normalize().unwrap_or(DVec3::Z).as_vec3());
        let direction = frame.to_world(uniform_cone(u2, one_minus_cos)).as_dvec3();
        let direction = direction.normalize();
        // The foot of the perpendicular from the centre, then half the chord back towards `from`,
        // or on to the far side from inside.
        let along = axis.dot(direction);
        let offset2 = (axis - along * direction).length_squared();
        let half = (self.radius * self.radius - offset2).max(0.0).sqrt();
        let outside = axis.length_squared() > self.radius * self.radius;
        let t = if outside { along - half } else { along + half };
        let n = (from + t * direction - self.center).try_normalize()?;
        let clearance = if outside { self.error } else { -self.error };
        Some(SurfaceSample {
            p: self.center + (self.radius + clearance) * n,
            face: 0,
            pdf: self.pdf(from),
        })
    }

    pub(super) fn pdf(&self, from: DVec3) -> f64 {
        let pdf = self.one_minus_cos(from).map(uniform_cone_pdf);
        f64::from(pdf.unwrap_or(0.0))
    }

    /// A point, uniform in area.
    pub(super) fn point(&self, u2: Vec2) -> DVec3 {
        self.center + self.radius * uniform_sphere(u2).as_dvec3().normalize()
    }

    /// Of the half angle in which the sphere is seen, which from inside is pi; `None` from the surface itself, whose
    /// outside sees nothing of it.
    fn one_minus_cos(&self, from: DVec3) -> Option<f32> {
        let distance = self.center.distance(from);
        if (distance - self.radius).abs() <= self.error {
            return None;
        }
        let sin2 = (self.radius / distance).powi(2);
        // 1 - sqrt(1 - s) without cancellation.
        let outside = || (sin2 / (1.0 + (1.0 - sin2).sqrt())) as f32;
        Some(if sin2 < 1.0 { outside() } else { 2.0 })
    }

    /// Of the outside.
    pub(super) fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }
}

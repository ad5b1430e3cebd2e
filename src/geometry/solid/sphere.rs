use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{Span, closest_approach, turn};
use crate::math::{Bounds, Ray};

/// The ball around the origin.
#[derive(Clone, Copy)]
pub(super) struct Sphere {
    pub(super) radius: f64,
}

#[expect(clippy::unused_self, reason = "called like every solid's")]
impl Sphere {
    /// The discriminant is a difference of squared lengths at the closest approach (Haines et al. 2019,
    /// "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, chapter 7).
    #[inline(always)]
    pub(super) fn spans(self, ray: &Ray) -> Option<Span> {
        let (t, p) = closest_approach(ray, DVec3::ZERO);
        let room = self.radius * self.radius - p.length_squared();
        let half = (room / ray.direction.length_squared()).sqrt();
        (room >= 0.0).then(|| Span::new((t - half, 0), (t + half, 0)))
    }

    pub(super) fn bounds(self) -> Bounds {
        Bounds::symmetric(DVec3::splat(self.radius))
    }

    pub(super) fn contains(self, p: DVec3) -> bool {
        p.length_squared() <= self.radius * self.radius
    }

    #[inline(always)]
    pub(super) fn normal(self, p: DVec3, _face: u32) -> DVec3 {
        p.normalize_or(DVec3::Z)
    }

    /// Longitude from +x and latitude from the south pole at -z.
    pub(super) fn uv(self, p: DVec3, _face: u32) -> DVec2 {
        let latitude = p.z.atan2(p.truncate().length());
        DVec2::new(turn(p.truncate()), 0.5 + latitude / PI)
    }

    pub(super) fn project(self, p: DVec3, _face: u32) -> DVec3 {
        self.radius * p.normalize_or(DVec3::Z)
    }
}

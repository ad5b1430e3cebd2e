use glam::{DVec2, DVec3};

use super::Span;
use crate::math::{Bounds, Ray};

/// The half-space z <= 0.
#[derive(Clone, Copy)]
pub(super) struct Plane;

#[expect(clippy::unused_self, reason = "called like every solid's")]
impl Plane {
    #[inline(always)]
    pub(super) fn spans(self, ray: &Ray) -> Option<Span> {
        let t = -ray.origin.z / ray.direction.z;
        let (below, above) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        if ray.direction.z > 0.0 {
            Some(Span::new(below, (t, 0)))
        } else if ray.direction.z < 0.0 {
            Some(Span::new((t, 0), above))
        } else {
            (ray.origin.z <= 0.0).then(|| Span::new(below, above))
        }
    }

    pub(super) fn bounds(self) -> Bounds {
        Bounds {
            max: DVec3::INFINITY.with_z(0.0),
            ..Bounds::ALL
        }
    }

    pub(super) fn contains(self, p: DVec3) -> bool {
        p.z <= 0.0
    }

    #[inline(always)]
    pub(super) fn normal(self, _p: DVec3, _face: u32) -> DVec3 {
        DVec3::Z
    }

    pub(super) fn uv(self, p: DVec3, _face: u32) -> DVec2 {
        p.truncate()
    }

    pub(super) fn project(self, p: DVec3, _face: u32) -> DVec3 {
        p.with_z(0.0)
    }
}

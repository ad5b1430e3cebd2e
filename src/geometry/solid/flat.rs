//! Pieces of the plane z = 0: surfaces, without an inside.

use glam::{DVec2, DVec3};

use super::plane::Plane;
use super::{Span, turn};
use crate::math::{Bounds, Ray};

/// Between `-half` and `half`.
#[derive(Clone, Copy)]
pub(super) struct Rectangle {
    pub(super) half: DVec2,
}

/// Around the origin.
#[derive(Clone, Copy)]
pub(super) struct Disk {
    pub(super) radius: f64,
}

/// What lies behind the piece that `holds` points, along the ray; nothing for rays in the plane.
#[inline(always)]
fn behind(ray: &Ray, holds: impl Fn(DVec2) -> bool) -> Option<Span> {
    let t = -ray.origin.z / ray.direction.z;
    let p = ray.at(t).truncate();
    (ray.direction.z != 0.0 && holds(p))
        .then(|| Plane.spans(ray))
        .flatten()
}

#[expect(clippy::unused_self, reason = "called like every solid's")]
impl Rectangle {
    #[inline(always)]
    pub(super) fn spans(self, ray: &Ray) -> Option<Span> {
        behind(ray, |p| p.abs().cmple(self.half).all())
    }

    pub(super) fn bounds(self) -> Bounds {
        Bounds::symmetric(self.half.extend(0.0))
    }

    pub(super) fn contains(self, _p: DVec3) -> bool {
        false
    }

    pub(super) fn normal(self, _p: DVec3, _face: u32) -> DVec3 {
        DVec3::Z
    }

    pub(super) fn uv(self, p: DVec3, _face: u32) -> DVec2 {
        (0.5 * (p.truncate() / self.half + 1.0)).clamp(DVec2::ZERO, DVec2::ONE)
    }

    pub(super) fn project(self, p: DVec3, _face: u32) -> DVec3 {
        p.truncate().clamp(-self.half, self.half).extend(0.0)
    }
}

#[expect(clippy::unused_self, reason = "called like every solid's")]
impl Disk {
    #[inline(always)]
    pub(super) fn spans(self, ray: &Ray) -> Option<Span> {
        behind(ray, |p| p.length_squared() <= self.radius * self.radius)
    }

    pub(super) fn bounds(self) -> Bounds {
        Bounds::symmetric(DVec2::splat(self.radius).extend(0.0))
    }

    pub(super) fn contains(self, _p: DVec3) -> bool {
        false
    }

    pub(super) fn normal(self, _p: DVec3, _face: u32) -> DVec3 {
        DVec3::Z
    }

    /// Around the axis, and from the middle to the rim.
    pub(super) fn uv(self, p: DVec3, _face: u32) -> DVec2 {
        let flat = p.truncate();
        DVec2::new(turn(flat), (flat.length() / self.radius).min(1.0))
    }

    pub(super) fn project(self, p: DVec3, _face: u32) -> DVec3 {
        p.truncate().clamp_length_max(self.radius).extend(0.0)
    }
}

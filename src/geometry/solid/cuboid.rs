use glam::{DVec2, DVec3};

use super::Span;
use crate::math::{Bounds, Ray};

/// The box between `-half` and `half`.
#[derive(Clone, Copy)]
pub(super) struct Cuboid {
    pub(super) half: DVec3,
}

impl Cuboid {
    /// The slab method (Kay and Kajiya 1986, "Ray Tracing Complex Scenes"), keeping the face of each end. Without branches,
    /// which rays would take at random.
    #[inline(always)]
    pub(super) fn spans(self, ray: &Ray) -> Option<Span> {
        let inverse = ray.direction.recip();
        let ahead = self.half.copysign(ray.direction);
        let near = ((-ahead - ray.origin) * inverse).to_array();
        let far = ((ahead - ray.origin) * inverse).to_array();
        // Not a number is a ray in the plane of a face: it lies between that and the other one.
        let enter = near
            .into_iter()
            .fold(f64::NEG_INFINITY, |a, t| if t > a { t } else { a });
        let exit = far
            .into_iter()
            .fold(f64::INFINITY, |a, t| if t < a { t } else { a });
        let face = |planes: [f64; 3], t: f64, positive: bool| {
            let axis = if planes[0] == t {
                0
            } else {
                1 + usize::from(planes[1] != t)
            };
            2 * axis as u32 + u32::from((ray.direction[axis] > 0.0) == positive)
        };
        (enter <= exit).then(|| {
            Span::new(
                (enter, face(near, enter, false)),
                (exit, face(far, exit, true)),
            )
        })
    }

    /// Whether the ray starts beyond a face and does not come back to it.
    #[inline(always)]
    pub(super) fn is_behind(self, ray: &Ray) -> bool {
        let beyond = ray.origin.abs().cmpgt(self.half);
        let away = (ray.origin * ray.direction).cmpge(DVec3::ZERO);
        ray.tmin >= 0.0 && (beyond & away).any()
    }

    pub(super) fn bounds(self) -> Bounds {
        Bounds::symmetric(self.half)
    }

    pub(super) fn contains(self, p: DVec3) -> bool {
        p.abs().cmple(self.half).all()
    }

    #[expect(clippy::unused_self, reason = "called like every solid's")]
    #[inline(always)]
    pub(super) fn normal(self, _p: DVec3, face: u32) -> DVec3 {
        let (axis, sign) = axis_and_sign(face);
        sign * DVec3::AXES[axis]
    }

    /// The two axes after the face's own, the first mirrored on negative faces: right-handed from outside.
    pub(super) fn uv(self, p: DVec3, face: u32) -> DVec2 {
        let (axis, sign) = axis_and_sign(face);
        let q = (p / self.half).clamp(DVec3::NEG_ONE, DVec3::ONE);
        0.5 * (DVec2::new(sign * q[(axis + 1) % 3], q[(axis + 2) % 3]) + 1.0)
    }

    pub(super) fn project(self, p: DVec3, face: u32) -> DVec3 {
        let (axis, sign) = axis_and_sign(face);
        let mut q = p.clamp(-self.half, self.half);
        q[axis] = sign * self.half[axis];
        q
    }
}

fn axis_and_sign(face: u32) -> (usize, f64) {
    (
        face as usize / 2,
        if face.is_multiple_of(2) { -1.0 } else { 1.0 },
    )
}

use glam::{DVec2, DVec3};

use super::Span;
use crate::math::{Bounds, Ray};

/// The box between `-half` and `half`.
#[derive(Clone, Copy)]
pub(super) struct Cuboid {
    pub(super) half: DVec3,
}

impl Cuboid {
    /// The slab method (Kay and Kajiya 1986, "Ray Tracing Complex Scenes"), keeping the face of each end.
    #[inline(always)]
    pub(super) fn spans(self, ray: &Ray) -> Option<Span> {
        let mut enter = (f64::NEG_INFINITY, 0);
        let mut exit = (f64::INFINITY, 0);
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            if d == 0.0 {
                if o.abs() > self.half[axis] {
                    return None;
                }
                continue;
            }
            let (ahead, behind) = (
                2 * axis as u32 + u32::from(d > 0.0),
                2 * axis as u32 + u32::from(d < 0.0),
            );
            let half = self.half[axis].copysign(d);
            let (near, far) = ((-half - o) / d, (half - o) / d);
            if near > enter.0 {
                enter = (near, behind);
            }
            if far < exit.0 {
                exit = (far, ahead);
            }
        }
        (enter.0 <= exit.0).then(|| Span::new(enter, exit))
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

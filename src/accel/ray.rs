use glam::{DVec3, Vec3};

use crate::math::Ray;

/// A ray made ready for one tree: f32, relative to the tree's centre, with everything that the box and
/// triangle tests share.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreeRay {
    /// Origin relative to the tree's centre.
    pub origin: Vec3,
    /// For the box test, near planes: `t = plane * inverse - near`, widened outward by [`PAD`].
    pub inverse: Vec3,
    pub near: Vec3,
    /// The same for far planes.
    pub far: Vec3,
    /// 1 where the direction is negative: which of a box's planes is the near one.
    pub sign: [usize; 3],
    /// Woop's permutation: the direction is longest along `axes[2]`.
    pub axes: [usize; 3],
    /// Woop's shear: direction components along `axes[0]` and `axes[1]` over the one along `axes[2]`.
    pub shear: [f32; 2],
    /// The direction's component along `axes[2]`.
    pub length: f64,
    /// `t` of the caller's ray is `t` here times this power of two.
    pub unit: f64,
}

/// Boxes grow by this part of the largest distance that matters to the ray. Every rounding in the box
/// and triangle tests is below 2^-22 of it, so no box loses a hit that the triangle test would accept.
const PAD: f32 = 1.0 / (1 << 20) as f32;

impl TreeRay {
    /// `extent` is the tree's half size around `center`, its largest component.
    pub(super) fn new(ray: &Ray, center: DVec3, extent: f32) -> Self {
        let longest = ray.direction.abs().max_element();
        // A length near 1 keeps every product inside the range of f32; scaling by 2^k is exact.
        let unit = if (1e-18..1e18).contains(&longest) {
            1.0
        } else {
            exponent_of(longest).recip()
        };
        let direction = (ray.direction * unit).as_vec3();
        let origin = (ray.origin - center).as_vec3();
        let magnitude = direction.abs();
        // Components below 2^-40 of the longest cannot leave the padding while the ray is in the tree.
        let most = (2.0_f64.powi(40) / exponent_of(f64::from(magnitude.max_element()))) as f32;
        let inverse = magnitude.recip().min(Vec3::splat(most)) * direction.signum();
        let pad = PAD * (origin.abs().max_element() + extent);
        let outward = Vec3::splat(pad) * direction.signum();
        let z = magnitude.max_position();
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        Self {
            origin,
            inverse,
            near: (origin + outward) * inverse,
            far: (origin - outward) * inverse,
            sign: [0, 1, 2].map(|i| usize::from(direction[i].is_sign_negative())),
            axes,
            shear: [
                direction[axes[0]] / direction[z],
                direction[axes[1]] / direction[z],
            ],
            length: f64::from(direction[z]),
            unit,
        }
    }
}

/// The power of two at or below `x`, for x > 0; subnormal numbers count as the least normal one.
fn exponent_of(x: f64) -> f64 {
    f64::from_bits(x.max(f64::MIN_POSITIVE).to_bits() & 0x7ff0_0000_0000_0000)
}

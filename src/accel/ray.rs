use glam::{DVec3, Vec3};

use crate::math::Ray;

/// A ray made ready for one tree, relative to the tree's centre, with everything that the box and
/// triangle tests share.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreeRay {
    /// Origin relative to the tree's centre.
    pub origin: Vec3,
    /// For the box test: `t = plane * inverse - near` or `- far`, each widened outward by `slack`.
    pub inverse: Vec3,
    pub near: Vec3,
    pub far: Vec3,
    /// 1 where the direction is negative: which of a box's planes is the near one.
    pub sign: [usize; 3],
    /// Woop's permutation: the direction is longest along `axes[2]`.
    pub axes: [usize; 3],
    /// Woop's shear: direction components along `axes[0]` and `axes[1]` over the one along `axes[2]`.
    pub shear: [f32; 2],
    /// More than any rounding of a coordinate in the f32 tests: rounding the origin, subtracting it,
    /// and the shear cost less than 12 units of 2^-24 of the largest distance that matters.
    pub slack: f32,
    /// The same in f64, for what f32 leaves in doubt.
    pub exact_origin: DVec3,
    pub exact_shear: [f64; 2],
    /// The direction's component along `axes[2]`.
    pub length: f64,
    /// A power of two: boxes and `inverse` use the direction over `unit`, so that f32 can hold it.
    pub unit: f64,
}

const SLACK: f32 = 1.0 / (1 << 20) as f32;

impl TreeRay {
    /// `extent` is the largest distance along an axis from `center` to what the tree holds.
    pub(super) fn new(ray: &Ray, center: DVec3, extent: f32) -> Self {
        let z = ray.direction.abs().max_position();
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let length = ray.direction[z];
        let exact_shear = [
            ray.direction[axes[0]] / length,
            ray.direction[axes[1]] / length,
        ];
        let unit = exponent_of(length.abs());
        let direction = (ray.direction / unit).as_vec3();
        let exact_origin = ray.origin - center;
        let origin = exact_origin.as_vec3();
        let slack = SLACK * (origin.abs().max_element() + extent);
        // The longest component is now in 1..2. One below 2^-40 of it cannot leave the slack while the
        // ray is in the tree, and a bounded inverse keeps infinities out of the products.
        let inverse =
            direction.abs().recip().min(Vec3::splat(2.0_f32.powi(40))) * direction.signum();
        let outward = slack * direction.signum();
        Self {
            origin,
            inverse,
            near: (origin + outward) * inverse,
            far: (origin - outward) * inverse,
            sign: [0, 1, 2].map(|i| usize::from(direction[i].is_sign_negative())),
            axes,
            shear: exact_shear.map(|s| s as f32),
            slack,
            exact_origin,
            exact_shear,
            length,
            unit,
        }
    }

    /// `t` of the caller's ray in the units of the box test, not below its true value.
    pub(super) fn box_limit(&self, t: f64) -> f32 {
        ((t * self.unit) as f32).next_up()
    }

    /// The same, not above its true value.
    pub(super) fn box_start(&self, t: f64) -> f32 {
        ((t * self.unit) as f32).next_down()
    }
}

/// The power of two at or below `x`, for x > 0; subnormal numbers count as the least normal one.
fn exponent_of(x: f64) -> f64 {
    f64::from_bits(x.max(f64::MIN_POSITIVE).to_bits() & 0x7ff0_0000_0000_0000)
}

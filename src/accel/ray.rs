use glam::{DVec2, DVec3, Vec3A};

use crate::math::Ray;

/// A ray made ready for one tree, relative to the tree's centre, in f32: what the box test needs, and the test that
/// finds the triangles which [`ExactRay`] decides on.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreeRay {
    /// For the box test: `t = plane * inverse + near` or `+ far`, each widened outward by `slack`.
    pub inverse: Vec3A,
    pub near: Vec3A,
    pub far: Vec3A,
    /// Origin relative to the tree's centre, in the order of `axes`, as the next one is.
    pub origin: Vec3A,
    /// Woop's shear: the direction's first two components over the third. Then how far one unit of the box test goes
    /// along the third axis: 1 to 2, or -1 to -2.
    pub shear: Vec3A,
    /// Woop's permutation: the direction is longest along `axes[2]`.
    pub axes: [u32; 3],
    /// A bit for each axis along which the direction is negative, so that the upper plane of a box is the near one.
    pub negative: u32,
    /// More than any rounding of a coordinate in the f32 tests: rounding the origin, subtracting it,
    /// and the shear cost less than 12 units of 2^-24 of the largest distance that matters.
    pub slack: f32,
    /// How far an f32 edge function may be off for each unit that a sheared coordinate may be long: [`TreeRay::doubt`].
    pub scale: f32,
    /// A power of two: boxes and `inverse` use the direction over `unit`, so that f32 can hold it.
    pub unit: f64,
}

/// A ray relative to a tree's centre, in f64 and in the order of its axes: longest along the third.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExactRay {
    pub origin: [f64; 3],
    /// Direction components along the first two axes over the one along the third.
    pub shear: [f64; 2],
    /// The direction's component along the third axis.
    pub length: f64,
}

/// By whether the first axis is the longest, plus twice whether the second one is.
pub(super) static AXES: [[u32; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];

/// Squares of sums of a few such numbers are in the range of f32.
const LARGEST: f64 = 4e18;

/// No inverse of a direction's component is larger.
pub(super) const STEEPEST: f32 = (1_u64 << 40) as f32;

/// A [`TreeRay`]'s unit is within this.
pub(super) const UNITS: [f64; 2] = [f64::MIN_POSITIVE, 0.25 / f64::MIN_POSITIVE];

pub(super) const SLACK: f32 = 1.0 / (1 << 20) as f32;

/// Of an edge function's two products each factor is off by a slack: four, and more than all rounding.
pub(super) const EDGE: f32 = 6.0;

/// See [`TreeRay::depths`].
pub(super) const OFF: f32 = 8.0;

impl TreeRay {
    /// `extent` is the largest distance along an axis from `center` to what the tree holds.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, center: DVec3, extent: f32) -> Self {
        let size = ray.direction.abs();
        // Without branches, which random rays would take at random.
        let first = (size.x >= size.y) & (size.x >= size.z);
        let second = !first & (size.y >= size.z);
        let axes = AXES[usize::from(first) + 2 * usize::from(second)];
        let [x, y, z] = axes.map(|axis| axis as usize);
        let unit = exponent_of(size.max_element());
        let direction = (ray.direction * reciprocal(unit)).as_vec3a();
        let from = (ray.origin - center).as_vec3a();
        let slack = SLACK * (from.abs().max_element() + extent);
        // The longest component is now in 1..2. One below 2^-40 of it cannot leave the slack while the
        // ray is in the tree, and a bounded inverse keeps infinities out of the products.
        let inverse = (direction.abs().recip().min(Vec3A::splat(STEEPEST))).copysign(direction);
        let outward = Vec3A::splat(slack).copysign(direction);
        let (origin, components) = (from.to_array(), direction.to_array());
        let across = inverse.to_array()[z];
        Self {
            inverse,
            near: (from + outward) * -inverse,
            far: (from - outward) * -inverse,
            origin: Vec3A::new(origin[x], origin[y], origin[z]),
            shear: Vec3A::new(
                components[x] * across,
                components[y] * across,
                components[z],
            ),
            axes,
            negative: direction.is_negative_bitmask(),
            slack,
            scale: EDGE * slack,
            unit,
        }
    }

    /// The ray itself, with which this was made.
    #[inline(always)]
    pub(super) fn exact(&self, ray: &Ray, center: DVec3) -> ExactRay {
        let [x, y, z] = self.axes.map(|axis| axis as usize);
        let (origin, direction) = ((ray.origin - center).to_array(), ray.direction.to_array());
        ExactRay {
            origin: [origin[x], origin[y], origin[z]],
            shear: (DVec2::new(direction[x], direction[y]) / direction[z]).to_array(),
            length: direction[z],
        }
    }

    /// Whether kernels may walk with this, of `ray`: wherever [`fits_kernels`] says so, and some roundings beyond.
    #[inline(always)]
    pub(super) fn fits_kernels(&self, ray: &Ray) -> bool {
        const MOST: f32 = SLACK * (LARGEST * (1.0 + 1e-5)) as f32;
        (self.slack < MOST) & (ray.tmin >= 0.0)
    }

    /// How far an f32 edge function of a triangle may be off where no sheared coordinate is beyond ±size: each is
    /// within `slack` of its true value, and products may underflow.
    #[inline(always)]
    pub(super) fn doubt(&self, size: f32) -> f32 {
        self.scale * (size + self.slack) + f32::MIN_POSITIVE
    }

    /// Between which depths along the third axis hits of a triangle may lie, of a ray from `start` to `limit` in the units
    /// of the box test.
    ///
    /// The kernels' test compares these times the triangle's area with its moment `u a.z + v b.z + w c.z`. What is off
    /// in proportion to the area is taken care of here: each depth by the slack, and of both sums the rounding, less than
    /// 6 units of 2^-24 of the largest distance. What edge functions are off, by `doubt` each, is left: three times in
    /// the moment, and three times in the area, times the depth of the hit, which no corner's is below. That is [`OFF`]
    /// doubts times the depth of the farthest corner, and with its own slack six slacks more, which are
    /// `scale`.
    #[inline(always)]
    pub(super) fn depths(&self, start: f32, limit: f32) -> (f32, f32) {
        let unit = self.shear.z.abs();
        (
            start * unit - 2.0 * self.slack,
            limit * unit + 2.0 * self.slack,
        )
    }

    /// `t` of the caller's ray in the units of the box test, not below its true value.
    #[inline(always)]
    pub(super) fn box_limit(&self, t: f64) -> f32 {
        let t = t * self.unit;
        (t + t.abs() * BOX_ROUNDING) as f32 + f32::MIN_POSITIVE
    }

    /// In the same units, not before anything that lies up to `reach` from the origin along the longest axis.
    #[inline(always)]
    pub(super) fn box_end(&self, reach: f32) -> f32 {
        (reach + self.slack) * self.inverse[self.axes[2] as usize].abs() * (1.0 + SLACK)
    }

    /// `t` as [`TreeRay::box_limit`] has it, not above its true value, and at least 0 where that is.
    #[inline(always)]
    pub(super) fn box_start(&self, t: f64) -> f32 {
        let unit = t * self.unit;
        let start = (unit - unit.abs() * BOX_ROUNDING) as f32 - f32::MIN_POSITIVE;
        if t < 0.0 { start } else { start.max(0.0) }
    }
}

/// More than what rounding to f32 changes.
pub(super) const BOX_ROUNDING: f64 = 1.0 / (1 << 22) as f64;

/// Whether kernels may walk with the [`TreeRay`] of `ray`: no operation on it overflows, and distances are at least 0,
/// so that their bits order them.
#[inline]
pub(super) fn fits_kernels(ray: &Ray, center: DVec3, extent: f32) -> bool {
    let reach = (ray.origin - center).abs().max_element() + f64::from(extent);
    ray.tmin >= 0.0 && reach < LARGEST
}

/// The power of two at or below `x`, for x > 0, as far as it and its reciprocal are normal numbers; else the nearest
/// such.
#[inline(always)]
fn exponent_of(x: f64) -> f64 {
    let x = x.clamp(UNITS[0], UNITS[1]);
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

/// `1 / x` for a power of two, both normal numbers.
#[inline(always)]
fn reciprocal(x: f64) -> f64 {
    f64::from_bits(0x7fe0_0000_0000_0000 - x.to_bits())
}

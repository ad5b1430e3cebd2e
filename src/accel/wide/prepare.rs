//! Rays made ready: eight at once with AVX-512, one with AVX2.

use std::arch::x86_64::*;

use glam::DVec3;

use crate::accel::ray::{AXES, EDGE, SLACK, STEEPEST, TreeRay, UNITS};
use crate::math::Ray;

use super::kernel::PREPARED;

/// In the steps of [`TreeRay::new`], with the same bits.
///
/// # Safety
/// The processor has what [`super::avx512::Avx512`] needs; `into` may be written to.
#[inline(always)]
pub(super) unsafe fn prepare(
    rays: &[&Ray; PREPARED],
    center: DVec3,
    extent: f32,
    into: &[*mut TreeRay; PREPARED],
) {
    // SAFETY: a ray is eight numbers side by side.
    unsafe {
        let row = |i: usize| _mm512_loadu_pd((&raw const *rays[i]).cast());
        let [ox, oy, oz, dx, dy, dz, ..] = transposed([
            row(0),
            row(1),
            row(2),
            row(3),
            row(4),
            row(5),
            row(6),
            row(7),
        ]);
        // In the steps of `TreeRay::new`.
        let (sx, sy, sz) = (_mm512_abs_pd(dx), _mm512_abs_pd(dy), _mm512_abs_pd(dz));
        let (xy, xz) = (ge(sx, sy), ge(sx, sz));
        let yz = ge(sy, sz);
        let (first, second) = (xy & xz, !(xy & xz) & yz);
        let unit = _mm512_max_pd(_mm512_max_pd(sx, sy), sz);
        let unit = _mm512_min_pd(
            _mm512_max_pd(unit, _mm512_set1_pd(UNITS[0])),
            _mm512_set1_pd(UNITS[1]),
        );
        let unit = _mm512_and_si512(
            _mm512_castpd_si512(unit),
            _mm512_set1_epi64(0x7ff0_0000_0000_0000),
        );
        let reciprocal = _mm512_sub_epi64(_mm512_set1_epi64(0x7fe0_0000_0000_0000), unit);
        let reciprocal = _mm512_castsi512_pd(reciprocal);
        let direction = |d: __m512d| _mm512_cvtpd_ps(_mm512_mul_pd(d, reciprocal));
        let (dx, dy, dz) = (direction(dx), direction(dy), direction(dz));
        let relative = |o: __m512d, c: f64| _mm512_cvtpd_ps(_mm512_sub_pd(o, _mm512_set1_pd(c)));
        let (ox, oy, oz) = (
            relative(ox, center.x),
            relative(oy, center.y),
            relative(oz, center.z),
        );
        let sign = _mm256_set1_ps(-0.0);
        let abs = |x: __m256| _mm256_andnot_ps(sign, x);
        let signed = |x: __m256, d: __m256| _mm256_or_ps(x, _mm256_and_ps(d, sign));
        let reach = _mm256_max_ps(_mm256_max_ps(abs(ox), abs(oy)), abs(oz));
        let slack = _mm256_mul_ps(
            _mm256_set1_ps(SLACK),
            _mm256_add_ps(reach, _mm256_set1_ps(extent)),
        );
        let inverse = |d: __m256| {
            let inverse = _mm256_div_ps(_mm256_set1_ps(1.0), abs(d));
            signed(_mm256_min_ps(inverse, _mm256_set1_ps(STEEPEST)), d)
        };
        let (ix, iy, iz) = (inverse(dx), inverse(dy), inverse(dz));
        let opposite = |i| _mm256_xor_ps(i, sign);
        let near = |o, d, i| _mm256_mul_ps(_mm256_add_ps(o, signed(slack, d)), opposite(i));
        let far = |o, d, i| _mm256_mul_ps(_mm256_sub_ps(o, signed(slack, d)), opposite(i));
        let inverses = columns(ix, iy, iz, iz);
        let nears = columns(near(ox, dx, ix), near(oy, dy, iy), near(oz, dz, iz), iz);
        let fars = columns(far(ox, dx, ix), far(oy, dy, iy), far(oz, dz, iz), iz);
        let turned = |x: __m256, y: __m256, z: __m256| {
            (
                pick(first, second, y, z, x),
                pick(first, second, z, x, y),
                pick(first, second, x, y, z),
            )
        };
        let (ox, oy, oz) = turned(ox, oy, oz);
        let origins = columns(ox, oy, oz, slack);
        let signs = [dx, dy, dz].map(|d| _mm256_movemask_ps(d) as usize);
        let (dx, dy, dz) = turned(dx, dy, dz);
        let (_, _, across) = turned(ix, iy, iz);
        let shears = columns(_mm256_mul_ps(dx, across), _mm256_mul_ps(dy, across), dz, dz);
        let mut units = [0.0; PREPARED];
        _mm512_storeu_pd(units.as_mut_ptr(), _mm512_castsi512_pd(unit));
        for (i, into) in into.iter().enumerate() {
            let bit = |mask: usize| mask >> i & 1;
            let negative = bit(signs[0]) | bit(signs[1]) << 1 | bit(signs[2]) << 2;
            let longest = bit(usize::from(first)) | bit(usize::from(second)) << 1;
            let [.., slack] = floats(origins[i]);
            into.write(TreeRay {
                inverse: inverses[i].into(),
                near: nears[i].into(),
                far: fars[i].into(),
                origin: origins[i].into(),
                shear: shears[i].into(),
                axes: AXES[longest],
                negative: negative as u32,
                slack,
                scale: EDGE * slack,
                unit: units[i],
            });
        }
    }
}

/// In the steps of [`TreeRay::new`], with the same bits.
///
/// # Safety
/// The processor has AVX2.
#[inline(always)]
pub(super) unsafe fn prepare_one(ray: &Ray, center: DVec3, extent: f32) -> TreeRay {
    // SAFETY: a ray is eight numbers side by side, a point three. What a fourth lane holds does not matter.
    unsafe {
        let numbers = (&raw const *ray).cast::<f64>();
        let (origin, direction) = (_mm256_loadu_pd(numbers), _mm256_loadu_pd(numbers.add(3)));
        let size = _mm256_andnot_pd(_mm256_set1_pd(-0.0), direction);
        let longest = _mm256_max_pd(
            _mm256_permute4x64_pd::<0b11_00_10_01>(size),
            _mm256_permute4x64_pd::<0b11_01_00_10>(size),
        );
        let longest = _mm256_max_pd(size, longest);
        let axis = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(size, longest));
        let axis = (axis | 4).trailing_zeros() as usize;
        let unit = _mm256_min_pd(
            _mm256_max_pd(longest, _mm256_set1_pd(UNITS[0])),
            _mm256_set1_pd(UNITS[1]),
        );
        let exponent = _mm256_set1_epi64x(0x7ff0_0000_0000_0000);
        let unit = _mm256_and_si256(_mm256_castpd_si256(unit), exponent);
        let reciprocal = _mm256_sub_epi64(_mm256_set1_epi64x(0x7fe0_0000_0000_0000), unit);
        let direction = _mm256_mul_pd(direction, _mm256_castsi256_pd(reciprocal));
        let direction = _mm256_cvtpd_ps(direction);
        let center = _mm256_setr_pd(center.x, center.y, center.z, 0.0);
        let from = _mm256_cvtpd_ps(_mm256_sub_pd(origin, center));
        let sign = _mm_set1_ps(-0.0);
        let abs = |x: __m128| _mm_andnot_ps(sign, x);
        let signed = |x: __m128| _mm_or_ps(x, _mm_and_ps(direction, sign));
        let reach = abs(from);
        let reach = _mm_max_ps(
            _mm_max_ps(reach, _mm_permute_ps::<0b11_00_10_01>(reach)),
            _mm_permute_ps::<0b11_01_00_10>(reach),
        );
        let slack = _mm_mul_ps(_mm_set1_ps(SLACK), _mm_add_ps(reach, _mm_set1_ps(extent)));
        let inverse = _mm_div_ps(_mm_set1_ps(1.0), abs(direction));
        let inverse = signed(_mm_min_ps(inverse, _mm_set1_ps(STEEPEST)));
        let (outward, opposite) = (signed(slack), _mm_xor_ps(inverse, sign));
        let turn = _mm_loadu_si128(TURNS[axis].as_ptr().cast());
        let seen = _mm_permutevar_ps(direction, turn);
        let across = _mm_permute_ps::<0b10_10_10_10>(_mm_permutevar_ps(inverse, turn));
        let [i, j, k, _] = TURNS[axis];
        TreeRay {
            inverse: inverse.into(),
            near: _mm_mul_ps(_mm_add_ps(from, outward), opposite).into(),
            far: _mm_mul_ps(_mm_sub_ps(from, outward), opposite).into(),
            origin: _mm_permutevar_ps(from, turn).into(),
            shear: _mm_blend_ps::<0b0100>(_mm_mul_ps(seen, across), seen).into(),
            axes: [i, j, k],
            negative: _mm_movemask_ps(direction) as u32 & 7,
            slack: _mm_cvtss_f32(slack),
            scale: EDGE * _mm_cvtss_f32(slack),
            unit: _mm256_cvtsd_f64(_mm256_castsi256_pd(unit)),
        }
    }
}

/// [`AXES`] by the longest one, as lanes.
static TURNS: [[u32; 4]; 3] = [[1, 2, 0, 3], [2, 0, 1, 3], [0, 1, 2, 3]];

/// Rows to columns.
#[inline(always)]
unsafe fn transposed(r: [__m512d; 8]) -> [__m512d; 8] {
    unsafe {
        let [a, b, c, d, e, f, g, h] = r;
        // Pairs of rows, then fours, then all.
        let (ab0, ab1) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
        let (cd0, cd1) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
        let (ef0, ef1) = (_mm512_unpacklo_pd(e, f), _mm512_unpackhi_pd(e, f));
        let (gh0, gh1) = (_mm512_unpacklo_pd(g, h), _mm512_unpackhi_pd(g, h));
        let even = |a, b| _mm512_shuffle_f64x2::<0b10_00_10_00>(a, b);
        let odd = |a, b| _mm512_shuffle_f64x2::<0b11_01_11_01>(a, b);
        // Lanes 0 and 4, 2 and 6 of four rows; and 1 and 5, 3 and 7.
        let (abcd04, abcd26) = (even(ab0, cd0), odd(ab0, cd0));
        let (abcd15, abcd37) = (even(ab1, cd1), odd(ab1, cd1));
        let (efgh04, efgh26) = (even(ef0, gh0), odd(ef0, gh0));
        let (efgh15, efgh37) = (even(ef1, gh1), odd(ef1, gh1));
        [
            even(abcd04, efgh04),
            even(abcd15, efgh15),
            even(abcd26, efgh26),
            even(abcd37, efgh37),
            odd(abcd04, efgh04),
            odd(abcd15, efgh15),
            odd(abcd26, efgh26),
            odd(abcd37, efgh37),
        ]
    }
}

/// Four rows of eight to eight columns of four.
#[inline(always)]
unsafe fn columns(x: __m256, y: __m256, z: __m256, w: __m256) -> [__m128; 8] {
    unsafe {
        let (xy0, xy1) = (_mm256_unpacklo_ps(x, y), _mm256_unpackhi_ps(x, y));
        let (zw0, zw1) = (_mm256_unpacklo_ps(z, w), _mm256_unpackhi_ps(z, w));
        let (c0, c1) = (
            _mm256_shuffle_ps::<0b01_00_01_00>(xy0, zw0),
            _mm256_shuffle_ps::<0b11_10_11_10>(xy0, zw0),
        );
        let (c2, c3) = (
            _mm256_shuffle_ps::<0b01_00_01_00>(xy1, zw1),
            _mm256_shuffle_ps::<0b11_10_11_10>(xy1, zw1),
        );
        [
            _mm256_castps256_ps128(c0),
            _mm256_castps256_ps128(c1),
            _mm256_castps256_ps128(c2),
            _mm256_castps256_ps128(c3),
            _mm256_extractf128_ps::<1>(c0),
            _mm256_extractf128_ps::<1>(c1),
            _mm256_extractf128_ps::<1>(c2),
            _mm256_extractf128_ps::<1>(c3),
        ]
    }
}

/// `a` where `first` has a bit, `b` where `second` has one, else `c`.
#[inline(always)]
unsafe fn pick(first: u8, second: u8, a: __m256, b: __m256, c: __m256) -> __m256 {
    unsafe { _mm256_mask_mov_ps(_mm256_mask_mov_ps(c, second, b), first, a) }
}

#[inline(always)]
unsafe fn ge(a: __m512d, b: __m512d) -> u8 {
    unsafe { _mm512_cmp_pd_mask::<_CMP_GE_OQ>(a, b) }
}

#[inline(always)]
fn floats(v: __m128) -> [f32; 4] {
    // SAFETY: four numbers.
    unsafe { std::mem::transmute(v) }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::super::avx2::Avx2;
    use super::super::avx512::Avx512;
    use super::super::kernel::Kernel;
    use super::*;
    use crate::accel::Kernel as Choice;

    /// Of any length and place, along axes and planes too.
    fn any_ray(rng: &mut Pcg64Mcg) -> Ray {
        let mut vector = |scale: f64| {
            DVec3::from_array([0, 1, 2].map(|_| match rng.random_range(0..8) {
                0 => 0.0,
                1 => -0.0,
                2 => scale,
                _ => scale * rng.random_range(-1.0..1.0),
            }))
        };
        let origin = vector(3.0);
        let mut direction = vector(2.0);
        if direction == DVec3::ZERO {
            direction.y = -1.0;
        }
        let lengths = [1.0, 1e-12, 1e10, 1e-300, 1e300];
        Ray::new(origin, lengths[rng.random_range(0..5)] * direction)
    }

    #[test]
    fn kernels_make_rays_ready_with_the_same_bits() {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..10_000 {
            let rays: [Ray; PREPARED] = std::array::from_fn(|_| any_ray(&mut rng));
            let (center, extent) = (DVec3::new(0.5, -2.0, 1e3), rng.random_range(0.0..10.0));
            let plain = rays.map(|ray| TreeRay::new(&ray, center, extent));
            let same = |ready: &TreeRay, i: usize| {
                assert_eq!(
                    format!("{ready:?}"),
                    format!("{:?}", plain[i]),
                    "{:?}",
                    rays[i]
                );
            };
            // SAFETY: only with kernels that the processor has.
            if Choice::available().contains(&Choice::Avx2) {
                let kernel = unsafe { Avx2::new() };
                for (i, ray) in rays.iter().enumerate() {
                    same(&kernel.prepare_one(ray, center, extent), i);
                }
            }
            if Choice::available().contains(&Choice::Avx512) {
                let kernel = unsafe { Avx512::new() };
                let mut ready = plain;
                ready.rotate_left(1);
                unsafe {
                    kernel.prepare(
                        &rays.each_ref(),
                        center,
                        extent,
                        &ready.each_mut().map(|r| &raw mut *r),
                    );
                };
                (0..PREPARED).for_each(|i| same(&ready[i], i));
            }
        }
    }
}

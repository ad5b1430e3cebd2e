//! Eight rays made ready at once, with AVX-512.

use std::arch::x86_64::*;

use glam::DVec3;

use crate::accel::ray::{AXES, SIGNS, SLACK, STEEPEST, TreeRay, UNITS};
use crate::math::Ray;

use super::kernel::PREPARED;

/// In the steps of [`TreeRay::new`], with the same bits.
///
/// # Safety
/// The processor has what [`super::avx512::Avx512`] needs; `into` may be written to.
#[inline(always)]
pub(super) unsafe fn prepare(
    rays: &[Ray; PREPARED],
    center: DVec3,
    extent: f32,
    into: &[*mut TreeRay; PREPARED],
) {
    // SAFETY: a ray is eight numbers side by side.
    unsafe {
        let row = |i: usize| _mm512_loadu_pd((&raw const rays[i]).cast());
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
        let near = |o, d, i| _mm256_mul_ps(_mm256_add_ps(o, signed(slack, d)), i);
        let far = |o, d, i| _mm256_mul_ps(_mm256_sub_ps(o, signed(slack, d)), i);
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
            let [x, y, z, slack] = floats(origins[i]);
            let [a, b, along, _] = floats(shears[i]);
            into.write(TreeRay {
                inverse: inverses[i].into(),
                near: nears[i].into(),
                far: fars[i].into(),
                sign: SIGNS[negative],
                axes: AXES[longest],
                origin: [x, y, z],
                shear: [a, b],
                slack,
                unit: units[i],
                along,
            });
        }
    }
}

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

//! The triangle test in f64 for eight rays of a packet, with AVX-512.

use std::arch::x86_64::*;

use crate::accel::triangle::TINY;

use super::packet::{GROUP, Met};

/// In the steps of [`crate::accel::triangle::Triangle::intersect`], with the same bits: of rays with the directions
/// `shear` and `length`, and of a triangle with these corners relative to their origin.
///
/// # Safety
/// The processor has what [`super::avx512::Avx512`] needs.
#[inline(always)]
pub(super) unsafe fn decide(
    shear: [&[f64; GROUP]; 2],
    length: &[f64; GROUP],
    corners: [[f64; 3]; 3],
) -> Met {
    unsafe {
        let (sx, sy) = (
            _mm512_loadu_pd(shear[0].as_ptr()),
            _mm512_loadu_pd(shear[1].as_ptr()),
        );
        let [a, b, c] = corners;
        let (ax, ay) = (sheared(a[0], a[2], sx), sheared(a[1], a[2], sy));
        let (bx, by) = (sheared(b[0], b[2], sx), sheared(b[1], b[2], sy));
        let (cx, cy) = (sheared(c[0], c[2], sx), sheared(c[1], c[2], sy));
        let u = edge(bx, by, cx, cy);
        let v = edge(cx, cy, ax, ay);
        let w = edge(ax, ay, bx, by);
        let zero = _mm512_setzero_pd();
        let not_negative = |x| _mm512_cmp_pd_mask::<_CMP_GE_OQ>(x, zero);
        let not_positive = |x| _mm512_cmp_pd_mask::<_CMP_LE_OQ>(x, zero);
        let front = not_negative(u) & not_negative(v) & not_negative(w);
        let back = not_positive(u) & not_positive(v) & not_positive(w);
        // Both only where all are 0.
        let mut met = Met {
            mask: front ^ back,
            inside: 0,
            t: [0.0; GROUP],
            u: [0.0; GROUP],
            v: [0.0; GROUP],
        };
        if met.mask != 0 {
            let all = |x: f64| _mm512_set1_pd(x);
            let det = _mm512_add_pd(_mm512_add_pd(u, v), w);
            let moment = _mm512_add_pd(_mm512_mul_pd(u, all(a[2])), _mm512_mul_pd(v, all(b[2])));
            let moment = _mm512_add_pd(moment, _mm512_mul_pd(w, all(c[2])));
            let length = _mm512_loadu_pd(length.as_ptr());
            let t = _mm512_div_pd(moment, _mm512_mul_pd(det, length));
            _mm512_storeu_pd(met.t.as_mut_ptr(), t);
            _mm512_storeu_pd(met.u.as_mut_ptr(), _mm512_div_pd(v, det));
            _mm512_storeu_pd(met.v.as_mut_ptr(), _mm512_div_pd(w, det));
            let back = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(det, zero);
            let ascending = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(length, zero);
            met.inside = !(back ^ ascending);
        }
        met
    }
}

#[inline(always)]
unsafe fn sheared(x: f64, z: f64, shear: __m512d) -> __m512d {
    unsafe {
        let x = _mm512_sub_pd(_mm512_set1_pd(x), _mm512_mul_pd(_mm512_set1_pd(z), shear));
        let seen = _mm512_cmp_pd_mask::<_CMP_NLT_UQ>(_mm512_abs_pd(x), _mm512_set1_pd(TINY));
        _mm512_maskz_mov_pd(seen, x)
    }
}

/// `qx py - qy px`, with residuals where the products are equal.
#[inline(always)]
unsafe fn edge(px: __m512d, py: __m512d, qx: __m512d, qy: __m512d) -> __m512d {
    unsafe {
        let (right, left) = (_mm512_mul_pd(qx, py), _mm512_mul_pd(qy, px));
        let equal = _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(right, left);
        let edge = _mm512_sub_pd(right, left);
        if equal == 0 {
            return edge;
        }
        let residual = _mm512_sub_pd(
            _mm512_fmsub_pd(qx, py, right),
            _mm512_fmsub_pd(qy, px, left),
        );
        _mm512_mask_mov_pd(edge, equal, residual)
    }
}

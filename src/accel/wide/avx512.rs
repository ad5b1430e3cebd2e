//! Nodes of 16 children, with AVX-512.

use std::arch::x86_64::*;

use glam::{DVec3, Vec3A};

use crate::accel::ray::{OFF, TreeRay};
use crate::math::Ray;

use super::avx2::{Avx2, opaque, sort4};
use super::block::{Block, LANES};
use super::decide::decide;
use super::kernel::{Aligned, Kernel, PREPARED, Stack, Waiting, are_few, enter_few};
use super::node::Node;
use super::packet::{GROUP, Met, PACKET, Points, Window};
use super::prepare::prepare;

#[derive(Clone, Copy)]
pub(super) struct Avx512 {
    triangles: Avx2,
}

impl Avx512 {
    /// # Safety
    /// The processor has AVX-512 with VL, DQ and BW, and what AVX2 needs.
    pub(super) unsafe fn new() -> Self {
        Self {
            triangles: unsafe { Avx2::new() },
        }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Boxes {
    inverse: [__m512; 3],
    near: [__m512; 3],
    far: [__m512; 3],
    start: __m512,
    /// Where in a node the planes stand that the ray meets first and last, in bytes.
    near_at: [usize; 3],
    far_at: [usize; 3],
}

impl Kernel<16> for Avx512 {
    type Boxes = Boxes;

    #[inline(always)]
    fn prepare_one(self, ray: &Ray, center: DVec3, extent: f32) -> TreeRay {
        self.triangles.prepare_one(ray, center, extent)
    }

    #[inline(always)]
    unsafe fn prepare(
        self,
        rays: &[&Ray; PREPARED],
        center: DVec3,
        extent: f32,
        into: &[*mut TreeRay; PREPARED],
    ) {
        unsafe { prepare(rays, center, extent, into) };
    }

    #[inline(always)]
    fn boxes(self, ray: &TreeRay, start: f32) -> Boxes {
        // SAFETY: see `new`.
        unsafe {
            // Numbers are spread as they are loaded; in registers each takes a shuffle.
            let ray = &*opaque(ray);
            let all = |x: f32| _mm512_set1_ps(x);
            let three = |v: Vec3A| [all(v.x), all(v.y), all(v.z)];
            let negative = ray.negative as usize & 7;
            Boxes {
                inverse: three(ray.inverse),
                near: three(ray.near),
                far: three(ray.far),
                start: all(start),
                near_at: Node::<16>::FIRST[negative],
                far_at: Node::<16>::FIRST[7 - negative],
            }
        }
    }

    #[inline(always)]
    fn enter(
        self,
        node: &Node<16>,
        boxes: &Boxes,
        limit: f32,
        stack: &mut Stack,
        len: &mut usize,
    ) -> u32 {
        let (enter, mask) = self.entered(node, boxes, limit);
        if mask & mask.wrapping_sub(1) == 0 {
            return node.only(u32::from(mask));
        }
        if are_few(u32::from(mask)) {
            let mut at = Aligned([0.0; 16]);
            // SAFETY: see `new`.
            unsafe { _mm512_store_ps(at.0.as_mut_ptr(), enter) };
            return enter_few(node, &at, u32::from(mask), stack, len);
        }
        // SAFETY: the stack has room for all that wait in the deepest tree; the last entry was just written.
        unsafe {
            let top = stack.as_mut_ptr().add(*len).cast::<Waiting>();
            let count = self.sorted(node, enter, mask, top);
            *len += count - 1;
            *top.add(count - 1) as u32
        }
    }

    #[inline(always)]
    fn meet(self, node: &Node<16>, boxes: &Boxes, limit: f32, at: &mut Aligned<16>) -> u32 {
        let (enter, mask) = self.entered(node, boxes, limit);
        // SAFETY: see `new`.
        unsafe { _mm512_store_ps(at.0.as_mut_ptr(), enter) };
        u32::from(mask)
    }

    #[inline(always)]
    unsafe fn sort(self, node: &Node<16>, at: &Aligned<16>, mask: u32, top: *mut Waiting) -> usize {
        unsafe { self.sorted(node, _mm512_load_ps(at.0.as_ptr()), mask as u16, top) }
    }

    #[inline(always)]
    fn decide(
        self,
        shear: [&[f64; GROUP]; 2],
        length: &[f64; GROUP],
        corners: [[f64; 3]; 3],
    ) -> Met {
        // SAFETY: see `new`.
        unsafe { decide(shear, length, corners) }
    }

    #[inline(always)]
    fn within(self, points: &Points, window: &Window) -> u64 {
        // SAFETY: see `new`; points are loaded from where they stand.
        unsafe {
            let all = |x: f32| _mm512_set1_ps(x);
            let [x0, x1] = window.x;
            let [y0, y1] = window.y;
            let (x0, x1, y0, y1, near) = (all(x0), all(x1), all(y0), all(y1), all(window.near));
            let mut mask = 0;
            for group in 0..PACKET / 16 {
                let load = |row: &[f32; PACKET]| _mm512_load_ps(row.as_ptr().add(16 * group));
                let (x, y, reach) = (load(&points.x), load(&points.y), load(&points.reach));
                let m = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(x, x0);
                let m = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(m, x, x1);
                let m = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(m, y, y0);
                let m = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(m, y, y1);
                let m = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(m, reach, near);
                mask |= u64::from(m) << (16 * group);
            }
            mask
        }
    }

    #[inline(always)]
    fn candidates(
        self,
        block: &Block,
        ray: &TreeRay,
        start: f32,
        limit: f32,
    ) -> (u32, [f32; LANES]) {
        // SAFETY: see `new`; planes are loaded from where they stand in the block.
        unsafe {
            let ray = &*opaque(ray);
            let all = |x: f32| _mm512_set1_ps(x);
            let planes = block.planes_along(ray.axes);
            let (ox, oy, oz) = (all(ray.origin.x), all(ray.origin.y), all(ray.origin.z));
            let (sx, sy) = (all(ray.shear.x), all(ray.shear.y));
            // Two corners side by side.
            let corners = |first: usize| {
                let [x, y, z] = planes.map(|plane| _mm512_loadu_ps(plane.add(LANES * first)));
                let z = _mm512_sub_ps(z, oz);
                let (x, y) = (_mm512_sub_ps(x, ox), _mm512_sub_ps(y, oy));
                (_mm512_fnmadd_ps(z, sx, x), _mm512_fnmadd_ps(z, sy, y), z)
            };
            // The upper half of one beside the lower half of another.
            let beside = |upper, lower| _mm512_shuffle_f32x4::<0b01_00_11_10>(upper, lower);
            let swapped = |x| beside(x, x);
            let (abx, aby, abz) = corners(0);
            let (bcx, bcy, bcz) = corners(1);
            let (cax, cay) = (beside(bcx, abx), beside(bcy, aby));
            let wu = _mm512_fmsub_ps(bcx, aby, _mm512_mul_ps(bcy, abx));
            let vw = _mm512_fmsub_ps(abx, cay, _mm512_mul_ps(aby, cax));
            let farther = |x, y| _mm512_range_ps::<FARTHER>(x, y);
            let size = farther(farther(abx, aby), farther(bcx, bcy));
            let size = farther(size, swapped(size));
            let (slack, scale) = (all(ray.slack), all(ray.scale));
            let (size, least) = (_mm512_add_ps(size, slack), all(f32::MIN_POSITIVE));
            let doubt = _mm512_fmadd_ps(scale, size, least);
            // False where the lane holds no triangle. Halves hold two edge functions of three each.
            let (low, high) = (_mm512_min_ps(wu, vw), _mm512_max_ps(wu, vw));
            let front = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(low, _mm512_fnmsub_ps(scale, size, least));
            let back = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(high, doubt);
            // From here on lower halves count. Distance times area, both positive for a hit ahead.
            let (uw, cbz) = (swapped(wu), swapped(bcz));
            let area = _mm512_add_ps(_mm512_add_ps(wu, vw), uw);
            let moment = _mm512_fmadd_ps(vw, bcz, _mm512_mul_ps(wu, cbz));
            let moment = _mm512_fmadd_ps(uw, abz, moment);
            let sign = _mm512_set1_ps(-0.0);
            let turned = _mm512_and_ps(_mm512_xor_ps(area, all(ray.shear.z)), sign);
            let moment = _mm512_xor_ps(moment, turned);
            let area = _mm512_andnot_ps(sign, area);
            let reach = farther(farther(abz, bcz), cbz);
            let off = _mm512_mul_ps(doubt, _mm512_fmadd_ps(reach, all(OFF), scale));
            let (start, limit) = ray.depths(start, limit);
            let first = _mm512_fmsub_ps(all(start), area, off);
            let last = _mm512_fmadd_ps(all(limit), area, off);
            let ahead = _mm512_cmp_ps_mask::<_CMP_NLT_UQ>(moment, first);
            let within = _mm512_mask_cmp_ps_mask::<_CMP_NGT_UQ>(ahead, moment, last);
            let (front, back) = (u32::from(front), u32::from(back));
            let inside = front & front >> LANES | back & back >> LANES;
            let mut depths = [0.0; LANES];
            _mm256_storeu_ps(depths.as_mut_ptr(), _mm512_castps512_ps256(reach));
            (inside & u32::from(within) & LOWER, depths)
        }
    }
}

impl Avx512 {
    /// Where the ray enters the boxes, and a bit for each that it meets.
    #[inline(always)]
    fn entered(self, node: &Node<16>, boxes: &Boxes, limit: f32) -> (__m512, u16) {
        // SAFETY: see `new`; planes are loaded from where they stand in the node.
        unsafe {
            let base = (&raw const *node).cast::<u8>();
            let near = |axis: usize| {
                let planes = _mm512_loadu_ps(base.add(boxes.near_at[axis]).cast());
                _mm512_fmadd_ps(planes, boxes.inverse[axis], boxes.near[axis])
            };
            let far = |axis: usize| {
                let planes = _mm512_loadu_ps(base.add(boxes.far_at[axis]).cast());
                _mm512_fmadd_ps(planes, boxes.inverse[axis], boxes.far[axis])
            };
            let enter = _mm512_max_ps(
                _mm512_max_ps(near(0), near(1)),
                _mm512_max_ps(near(2), boxes.start),
            );
            let leave = _mm512_min_ps(
                _mm512_min_ps(far(0), far(1)),
                _mm512_min_ps(far(2), _mm512_set1_ps(limit)),
            );
            let mask = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave);
            (enter, mask)
        }
    }

    /// Writes the children in `mask` to `top`, far ones first, and up to 11 entries more; returns how many.
    #[inline(always)]
    unsafe fn sorted(self, node: &Node<16>, enter: __m512, mask: u16, top: *mut Waiting) -> usize {
        unsafe {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            // The lowest four bits of the distance make room for the lane: the keys order both.
            let keys = _mm512_ternarylogic_epi32::<0xCA>(
                _mm512_set1_epi32(15),
                lanes,
                _mm512_castps_si512(enter),
            );
            let keys = _mm512_mask_compress_epi32(_mm512_set1_epi32(-1), mask, keys);
            let children = _mm512_loadu_si512(node.children.as_ptr().cast());
            let count = mask.count_ones() as usize;
            if count <= 4 {
                let keys = sort4(_mm512_castsi512_si128(keys));
                let links = _mm512_permutexvar_epi32(_mm512_castsi128_si512(keys), children);
                let links = _mm512_castsi512_si128(links);
                _mm_storeu_si128(top.cast(), _mm_unpacklo_epi32(links, keys));
                _mm_storeu_si128(top.add(2).cast(), _mm_unpackhi_epi32(links, keys));
            } else {
                let keys = sort16(keys);
                let links = _mm512_permutexvar_epi32(keys, children);
                let low = _mm512_unpacklo_epi32(links, keys);
                let high = _mm512_unpackhi_epi32(links, keys);
                let order = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
                let first = _mm512_permutex2var_epi64(low, order, high);
                let order = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
                let last = _mm512_permutex2var_epi64(low, order, high);
                _mm512_storeu_si512(top.cast(), first);
                _mm512_storeu_si512(top.add(8).cast(), last);
            }
            count
        }
    }
}

/// Sorts signed numbers, the greatest first: Batcher's bitonic network.
#[inline(always)]
unsafe fn sort16(mut a: __m512i) -> __m512i {
    macro_rules! step {
        ($partner:expr, $greater:literal) => {
            let b = $partner;
            a = _mm512_mask_mov_epi32(_mm512_min_epi32(a, b), $greater, _mm512_max_epi32(a, b));
        };
    }
    unsafe {
        step!(_mm512_shuffle_epi32::<0xB1>(a), 0b1001_1001_1001_1001);
        step!(_mm512_shuffle_epi32::<0x4E>(a), 0b1100_0011_1100_0011);
        step!(_mm512_shuffle_epi32::<0xB1>(a), 0b1010_0101_1010_0101);
        step!(_mm512_shuffle_i32x4::<0xB1>(a, a), 0b1111_0000_0000_1111);
        step!(_mm512_shuffle_epi32::<0x4E>(a), 0b1100_1100_0011_0011);
        step!(_mm512_shuffle_epi32::<0xB1>(a), 0b1010_1010_0101_0101);
        step!(_mm512_shuffle_i32x4::<0x4E>(a, a), 0b0000_0000_1111_1111);
        step!(_mm512_shuffle_i32x4::<0xB1>(a, a), 0b0000_1111_0000_1111);
        step!(_mm512_shuffle_epi32::<0x4E>(a), 0b0011_0011_0011_0011);
        step!(_mm512_shuffle_epi32::<0xB1>(a), 0b0101_0101_0101_0101);
    }
    a
}

/// The mask of the lower half of 16 lanes.
const LOWER: u32 = (1 << LANES) - 1;

/// Of two numbers the size of that which is farther from 0.
const FARTHER: i32 = 0b10_11;

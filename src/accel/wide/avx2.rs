//! Nodes of 8 children, with AVX2 and FMA.

use std::arch::x86_64::*;

use glam::{DVec3, Vec3A};

use crate::accel::ray::{OFF, TreeRay};
use crate::math::Ray;

use super::block::{Block, LANES};
use super::kernel::{Aligned, Kernel, Stack, Waiting, are_few, enter_few};
use super::node::Node;
use super::packet::{PACKET, Points, Window};
use super::prepare::prepare_one;

#[derive(Clone, Copy)]
pub(super) struct Avx2(());

impl Avx2 {
    /// # Safety
    /// The processor has AVX2 and FMA.
    pub(super) unsafe fn new() -> Self {
        Self(())
    }
}

#[derive(Clone, Copy)]
pub(super) struct Boxes {
    inverse: [__m256; 3],
    near: [__m256; 3],
    far: [__m256; 3],
    start: __m256,
    /// Where in a node the planes stand that the ray meets first and last, in bytes.
    near_at: [usize; 3],
    far_at: [usize; 3],
}

impl Kernel<8> for Avx2 {
    type Boxes = Boxes;

    #[inline(always)]
    fn prepare_one(self, ray: &Ray, center: DVec3, extent: f32) -> TreeRay {
        // SAFETY: see `new`.
        unsafe { prepare_one(ray, center, extent) }
    }

    #[inline(always)]
    fn boxes(self, ray: &TreeRay, start: f32) -> Boxes {
        // SAFETY: see `new`.
        unsafe {
            let all = |x: f32| _mm256_set1_ps(x);
            let three = |v: Vec3A| [all(v.x), all(v.y), all(v.z)];
            let negative = ray.negative as usize & 7;
            Boxes {
                inverse: three(ray.inverse),
                near: three(ray.near),
                far: three(ray.far),
                start: all(start),
                near_at: Node::<8>::FIRST[negative],
                far_at: Node::<8>::FIRST[7 - negative],
            }
        }
    }

    #[inline(always)]
    fn enter(
        self,
        node: &Node<8>,
        boxes: &Boxes,
        limit: f32,
        stack: &mut Stack,
        len: &mut usize,
    ) -> u32 {
        let (enter, mask) = self.entered(node, boxes, limit);
        if are_few(mask) {
            let mut at = Aligned([0.0; 8]);
            // SAFETY: see `new`.
            unsafe { _mm256_store_ps(at.0.as_mut_ptr(), enter) };
            return enter_few(node, &at, mask, stack, len);
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
    fn meet(self, node: &Node<8>, boxes: &Boxes, limit: f32, at: &mut Aligned<8>) -> u32 {
        let (enter, mask) = self.entered(node, boxes, limit);
        // SAFETY: see `new`.
        unsafe { _mm256_store_ps(at.0.as_mut_ptr(), enter) };
        mask
    }

    #[inline(always)]
    unsafe fn sort(self, node: &Node<8>, at: &Aligned<8>, mask: u32, top: *mut Waiting) -> usize {
        unsafe { self.sorted(node, _mm256_load_ps(at.0.as_ptr()), mask, top) }
    }

    #[inline(always)]
    fn within(self, points: &Points, window: &Window) -> u64 {
        // SAFETY: see `new`; points are loaded from where they stand.
        unsafe {
            let all = |x: f32| _mm256_set1_ps(x);
            let [x0, x1] = window.x;
            let [y0, y1] = window.y;
            let (x0, x1, y0, y1, near) = (all(x0), all(x1), all(y0), all(y1), all(window.near));
            let mut mask = 0;
            for group in 0..PACKET / 8 {
                let load = |row: &[f32; PACKET]| _mm256_load_ps(row.as_ptr().add(8 * group));
                let (x, y, reach) = (load(&points.x), load(&points.y), load(&points.reach));
                let x = _mm256_and_ps(
                    _mm256_cmp_ps::<_CMP_GE_OQ>(x, x0),
                    _mm256_cmp_ps::<_CMP_LE_OQ>(x, x1),
                );
                let y = _mm256_and_ps(
                    _mm256_cmp_ps::<_CMP_GE_OQ>(y, y0),
                    _mm256_cmp_ps::<_CMP_LE_OQ>(y, y1),
                );
                let reach = _mm256_cmp_ps::<_CMP_GE_OQ>(reach, near);
                let inside = _mm256_and_ps(_mm256_and_ps(x, y), reach);
                mask |= u64::from(_mm256_movemask_ps(inside) as u8) << (8 * group);
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
            let all = |x: f32| _mm256_set1_ps(x);
            let planes = block.planes_along(ray.axes);
            let (ox, oy, oz) = (all(ray.origin.x), all(ray.origin.y), all(ray.origin.z));
            let (sx, sy) = (all(ray.shear.x), all(ray.shear.y));
            let corner = |corner: usize| {
                let [x, y, z] = planes.map(|plane| _mm256_load_ps(plane.add(LANES * corner)));
                let z = _mm256_sub_ps(z, oz);
                let (x, y) = (_mm256_sub_ps(x, ox), _mm256_sub_ps(y, oy));
                (_mm256_fnmadd_ps(z, sx, x), _mm256_fnmadd_ps(z, sy, y), z)
            };
            let (ax, ay, az) = corner(0);
            let (bx, by, bz) = corner(1);
            let (cx, cy, cz) = corner(2);
            let u = _mm256_fmsub_ps(cx, by, _mm256_mul_ps(cy, bx));
            let v = _mm256_fmsub_ps(ax, cy, _mm256_mul_ps(ay, cx));
            let w = _mm256_fmsub_ps(bx, ay, _mm256_mul_ps(by, ax));
            let sign = _mm256_set1_ps(-0.0);
            let abs = |x: __m256| _mm256_andnot_ps(sign, x);
            let most = |x, y, z| _mm256_max_ps(_mm256_max_ps(x, y), z);
            let size = _mm256_max_ps(
                most(abs(ax), abs(bx), abs(cx)),
                most(abs(ay), abs(by), abs(cy)),
            );
            let (slack, scale) = (all(ray.slack), all(ray.scale));
            let doubt = _mm256_fmadd_ps(scale, _mm256_add_ps(size, slack), all(f32::MIN_POSITIVE));
            // False where the lane holds no triangle.
            let inside = _mm256_or_ps(
                _mm256_cmp_ps::<_CMP_GE_OQ>(
                    _mm256_min_ps(_mm256_min_ps(u, v), w),
                    _mm256_xor_ps(doubt, sign),
                ),
                _mm256_cmp_ps::<_CMP_LE_OQ>(most(u, v, w), doubt),
            );
            // Distance times area, both positive for a hit ahead.
            let area = _mm256_add_ps(_mm256_add_ps(u, v), w);
            let moment = _mm256_fmadd_ps(u, az, _mm256_fmadd_ps(v, bz, _mm256_mul_ps(w, cz)));
            let turned = _mm256_and_ps(_mm256_xor_ps(area, all(ray.shear.z)), sign);
            let moment = _mm256_xor_ps(moment, turned);
            let area = abs(area);
            let reach = most(abs(az), abs(bz), abs(cz));
            let off = _mm256_mul_ps(doubt, _mm256_fmadd_ps(reach, all(OFF), scale));
            let (start, limit) = ray.depths(start, limit);
            let behind = _mm256_fmsub_ps(all(start), area, off);
            let behind = _mm256_cmp_ps::<_CMP_LT_OQ>(moment, behind);
            let beyond = _mm256_fmadd_ps(all(limit), area, off);
            let beyond = _mm256_cmp_ps::<_CMP_GT_OQ>(moment, beyond);
            let mask = _mm256_andnot_ps(_mm256_or_ps(behind, beyond), inside);
            let mut depths = [0.0; LANES];
            _mm256_storeu_ps(depths.as_mut_ptr(), reach);
            (_mm256_movemask_ps(mask) as u32, depths)
        }
    }
}

impl Avx2 {
    /// Where the ray enters the boxes, and a bit for each that it meets.
    #[inline(always)]
    fn entered(self, node: &Node<8>, boxes: &Boxes, limit: f32) -> (__m256, u32) {
        // SAFETY: see `new`; planes are loaded from where they stand in the node.
        unsafe {
            let base = (&raw const *node).cast::<u8>();
            let near = |axis: usize| {
                let planes = _mm256_load_ps(base.add(boxes.near_at[axis]).cast());
                _mm256_fmadd_ps(planes, boxes.inverse[axis], boxes.near[axis])
            };
            let far = |axis: usize| {
                let planes = _mm256_load_ps(base.add(boxes.far_at[axis]).cast());
                _mm256_fmadd_ps(planes, boxes.inverse[axis], boxes.far[axis])
            };
            let enter = _mm256_max_ps(
                _mm256_max_ps(near(0), near(1)),
                _mm256_max_ps(near(2), boxes.start),
            );
            let leave = _mm256_min_ps(
                _mm256_min_ps(far(0), far(1)),
                _mm256_min_ps(far(2), _mm256_set1_ps(limit)),
            );
            let met = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
            (enter, _mm256_movemask_ps(met) as u32)
        }
    }

    /// Writes the children in `mask` to `top`, far ones first, and up to three entries more; returns how many.
    #[inline(always)]
    unsafe fn sorted(self, node: &Node<8>, enter: __m256, mask: u32, top: *mut Waiting) -> usize {
        unsafe {
            // The lowest three bits of the distance make room for the lane: the keys order both.
            let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let keys = _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(enter));
            let keys = _mm256_or_si256(keys, lanes);
            let order = _mm_loadl_epi64(COMPRESS[mask as usize & 255].as_ptr().cast());
            let order = _mm256_cvtepu8_epi32(order);
            let count = mask.count_ones() as usize;
            // Places beyond the last get a key below all others.
            let beyond = _mm256_cmpgt_epi32(lanes, _mm256_set1_epi32(count as i32 - 1));
            let keys = _mm256_or_si256(_mm256_permutevar8x32_epi32(keys, order), beyond);
            let children = _mm256_load_si256(node.children.as_ptr().cast());
            if count <= 4 {
                let keys = sort4(_mm256_castsi256_si128(keys));
                let links = _mm256_permutevar8x32_epi32(children, _mm256_castsi128_si256(keys));
                let links = _mm256_castsi256_si128(links);
                _mm_storeu_si128(top.cast(), _mm_unpacklo_epi32(links, keys));
                _mm_storeu_si128(top.add(2).cast(), _mm_unpackhi_epi32(links, keys));
            } else {
                let keys = sort8(keys);
                let links = _mm256_permutevar8x32_epi32(children, keys);
                let low = _mm256_unpacklo_epi32(links, keys);
                let high = _mm256_unpackhi_epi32(links, keys);
                let first = _mm256_permute2x128_si256::<0x20>(low, high);
                let last = _mm256_permute2x128_si256::<0x31>(low, high);
                _mm256_storeu_si256(top.cast(), first);
                _mm256_storeu_si256(top.add(4).cast(), last);
            }
            count
        }
    }
}

/// `x`, of which the compiler no longer knows what it holds. It would fill registers with each number in `x` before a
/// loop that has too few of them, and take each from memory after all.
#[inline(always)]
pub(super) fn opaque<T>(mut x: *const T) -> *const T {
    // SAFETY: it does nothing.
    unsafe {
        std::arch::asm!("/* {0} */", inout(reg) x, options(nostack, preserves_flags, readonly));
    }
    x
}

/// Sorts signed numbers, the greatest first: Batcher's bitonic network.
#[inline(always)]
unsafe fn sort8(mut a: __m256i) -> __m256i {
    macro_rules! step {
        ($partner:expr, $greater:literal) => {
            let b = $partner;
            a = _mm256_blend_epi32::<$greater>(_mm256_min_epi32(a, b), _mm256_max_epi32(a, b));
        };
    }
    unsafe {
        step!(_mm256_shuffle_epi32::<0xB1>(a), 0b1001_1001);
        step!(_mm256_shuffle_epi32::<0x4E>(a), 0b1100_0011);
        step!(_mm256_shuffle_epi32::<0xB1>(a), 0b1010_0101);
        step!(_mm256_permute2x128_si256::<0x01>(a, a), 0b0000_1111);
        step!(_mm256_shuffle_epi32::<0x4E>(a), 0b0011_0011);
        step!(_mm256_shuffle_epi32::<0xB1>(a), 0b0101_0101);
    }
    a
}

/// Sorts signed numbers, the greatest first.
#[inline(always)]
pub(super) unsafe fn sort4(a: __m128i) -> __m128i {
    unsafe {
        let b = _mm_shuffle_epi32::<0b01_00_11_10>(a);
        let a = _mm_blend_epi32::<0b1100>(_mm_max_epi32(a, b), _mm_min_epi32(a, b));
        let b = _mm_shuffle_epi32::<0b10_11_00_01>(a);
        let a = _mm_blend_epi32::<0b1010>(_mm_max_epi32(a, b), _mm_min_epi32(a, b));
        let b = _mm_shuffle_epi32::<0b11_01_10_00>(a);
        _mm_blend_epi32::<0b0100>(_mm_max_epi32(a, b), _mm_min_epi32(a, b))
    }
}

/// For each mask its lanes, the set ones first.
static COMPRESS: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][place] = lane as u8;
                place += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

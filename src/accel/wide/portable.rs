//! Four lanes at a time, with the vectors that every processor of a family has; for any ray, also one that f32 cannot hold.

use glam::Vec4;

use crate::accel::ray::TreeRay;
use crate::math::Ray;

use super::block::{Block, LANES};
use super::kernel::{Aligned, Kernel, Stack, Waiting, are_few, enter_few};
use super::node::Node;

#[derive(Clone, Copy)]
pub(super) struct Portable;

#[derive(Clone, Copy)]
pub(super) struct Boxes {
    ray: TreeRay,
    start: f32,
}

impl<const N: usize> Kernel<N> for Portable {
    type Boxes = Boxes;

    #[inline(always)]
    fn takes(self, _ray: &Ray, _local: &TreeRay) -> bool {
        true
    }

    #[inline(always)]
    fn boxes(self, ray: &TreeRay, start: f32) -> Boxes {
        let mut ray = *ray;
        for axis in 0..3 {
            // Too far away for f32, the axis says nothing: a box then begins before all others and ends behind them.
            if !(ray.near[axis].is_finite() && ray.far[axis].is_finite()) {
                ray.inverse[axis] = f32::MIN_POSITIVE.copysign(ray.inverse[axis]);
                (ray.near[axis], ray.far[axis]) = (f32::MIN, f32::MAX);
            }
        }
        Boxes { ray, start }
    }

    #[inline(always)]
    fn enter(
        self,
        node: &Node<N>,
        boxes: &Boxes,
        limit: f32,
        stack: &mut Stack,
        len: &mut usize,
    ) -> u32 {
        let mut at = Aligned([0.0; N]);
        let mask = meet(node, boxes, limit, &mut at);
        if are_few(mask) {
            return enter_few(node, &at, mask, stack, len);
        }
        // SAFETY: the stack has room for all that wait in the deepest tree; the last entry was just written.
        unsafe {
            let top = stack.as_mut_ptr().add(*len).cast::<Waiting>();
            let count = sorted(node, &at, mask, top);
            *len += count - 1;
            *top.add(count - 1) as u32
        }
    }

    #[inline(always)]
    fn meet(self, node: &Node<N>, boxes: &Boxes, limit: f32, at: &mut Aligned<N>) -> u32 {
        meet(node, boxes, limit, at)
    }

    #[inline(always)]
    unsafe fn sort(self, node: &Node<N>, at: &Aligned<N>, mask: u32, top: *mut Waiting) -> usize {
        unsafe { sorted(node, at, mask, top) }
    }

    #[inline(always)]
    fn candidates(
        self,
        block: &Block,
        ray: &TreeRay,
        _start: f32,
        _limit: f32,
    ) -> (u32, [f32; LANES]) {
        let mut mask = 0;
        for from in (0..LANES).step_by(4) {
            mask |= candidates(block, ray, from) << from;
        }
        (mask, [f32::INFINITY; LANES])
    }
}

/// A bit for each of four triangles, from number `from` on, that is not certainly missed.
#[inline(always)]
fn candidates(block: &Block, ray: &TreeRay, from: usize) -> u32 {
    let [x, y, z] = ray.axes.map(|axis| axis as usize);
    let corner = |corner: usize| {
        let along = |axis: usize, origin: f32| {
            Vec4::from_slice(&block.planes[axis][corner][from..]) - Vec4::splat(origin)
        };
        let z = along(z, ray.origin.z);
        (
            along(x, ray.origin.x) - z * ray.shear.x,
            along(y, ray.origin.y) - z * ray.shear.y,
        )
    };
    let ((ax, ay), (bx, by), (cx, cy)) = (corner(0), corner(1), corner(2));
    let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
    let most = |a: Vec4, b: Vec4, c: Vec4| a.max(b).max(c);
    let size = most(ax.abs(), bx.abs(), cx.abs()).max(most(ay.abs(), by.abs(), cy.abs()));
    let doubt = (size + Vec4::splat(ray.slack)) * ray.scale + Vec4::splat(f32::MIN_POSITIVE);
    // What is not a number misses nothing; only a lane without a triangle holds none.
    let missed = u.min(v).min(w).cmplt(-doubt) & most(u, v, w).cmpgt(doubt);
    let held = Vec4::from_slice(&block.planes[0][0][from..]);
    (held.cmpeq(held) & !missed).bitmask()
}

/// Where the ray enters the boxes, at least 0, and a bit for each that it meets.
#[inline(always)]
fn meet<const N: usize>(node: &Node<N>, boxes: &Boxes, limit: f32, at: &mut Aligned<N>) -> u32 {
    let ray = &boxes.ray;
    let mut mask = 0;
    for from in (0..N).step_by(4) {
        let (mut first, mut last) = (Vec4::splat(boxes.start), Vec4::splat(limit));
        for axis in 0..3 {
            let sign = (ray.negative >> axis & 1) as usize;
            let plane = |side: usize| Vec4::from_slice(&node.planes[side][axis][from..]);
            let inverse = ray.inverse[axis];
            first = first.max(plane(sign) * inverse + Vec4::splat(ray.near[axis]));
            last = last.min(plane(1 - sign) * inverse + Vec4::splat(ray.far[axis]));
        }
        mask |= first.cmple(last).bitmask() << from;
        // Behind the origin there is no order.
        first.max(Vec4::ZERO).write_to_slice(&mut at.0[from..]);
    }
    mask
}

/// Writes the children in `mask` to `top`, far ones first; returns how many.
///
/// # Safety
/// There is room.
#[inline(always)]
unsafe fn sorted<const N: usize>(
    node: &Node<N>,
    at: &Aligned<N>,
    mut mask: u32,
    top: *mut Waiting,
) -> usize {
    let mut count = 0;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & (N - 1);
        mask &= mask - 1;
        let entry = u64::from(at.0[lane].to_bits()) << 32 | u64::from(node.children[lane]);
        let mut place = count;
        // SAFETY: the caller's, and entries below `count` were written.
        unsafe {
            while place > 0 && *top.add(place - 1) < entry {
                *top.add(place) = *top.add(place - 1);
                place -= 1;
            }
            *top.add(place) = entry;
        }
        count += 1;
    }
    count
}

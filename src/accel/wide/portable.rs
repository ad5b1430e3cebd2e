//! Plain Rust that compilers turn into whatever vectors there are; for any ray, also one that f32 cannot hold.

use crate::accel::ray::TreeRay;
use crate::math::Ray;

use super::block::{Block, LANES};
use super::kernel::{Kernel, Stack, Waiting, are_few, enter_few};
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
        Boxes { ray: *ray, start }
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
        let (enter, mask) = meet(node, boxes, limit);
        if are_few(mask) {
            return enter_few(node, &enter, mask, stack, len);
        }
        // SAFETY: the stack has room for all that wait in the deepest tree; the last entry was just written.
        unsafe {
            let top = stack.as_mut_ptr().add(*len).cast::<Waiting>();
            let count = sorted(node, &enter, mask, top);
            *len += count - 1;
            *top.add(count - 1) as u32
        }
    }

    #[inline(always)]
    unsafe fn push(self, node: &Node<N>, boxes: &Boxes, limit: f32, top: *mut Waiting) -> usize {
        let (enter, mask) = meet(node, boxes, limit);
        unsafe { sorted(node, &enter, mask, top) }
    }

    #[inline(always)]
    fn candidates(
        self,
        block: &Block,
        ray: &TreeRay,
        _start: f32,
        _limit: f32,
    ) -> (u32, [f32; LANES]) {
        let (scale, least) = ray.doubt();
        let mut size = [0.0_f32; LANES];
        let mut corners = [[[0.0; LANES]; 2]; 3];
        let [x, y, z] = ray.axes.map(|axis| axis as usize);
        for (p, planes) in corners.iter_mut().zip(&block.corners) {
            for lane in 0..LANES {
                let z = planes[z][lane] - ray.origin[2];
                p[0][lane] = planes[x][lane] - ray.origin[0] - z * ray.shear[0];
                p[1][lane] = planes[y][lane] - ray.origin[1] - z * ray.shear[1];
                size[lane] = size[lane].max(p[0][lane].abs()).max(p[1][lane].abs());
            }
        }
        let [a, b, c] = corners;
        let mut mask = 0;
        for lane in 0..LANES {
            let edge = |p: &[[f32; LANES]; 2], q: &[[f32; LANES]; 2]| {
                q[0][lane] * p[1][lane] - q[1][lane] * p[0][lane]
            };
            let (u, v, w) = (edge(&b, &c), edge(&c, &a), edge(&a, &b));
            let doubt = scale * size[lane] + least;
            let inside = u.min(v).min(w) >= -doubt || u.max(v).max(w) <= doubt;
            mask |= u32::from(inside) << lane;
        }
        (mask, [f32::INFINITY; LANES])
    }
}

/// Where the ray enters the boxes, at least 0, and a bit for each that it meets.
#[inline(always)]
fn meet<const N: usize>(node: &Node<N>, boxes: &Boxes, limit: f32) -> ([f32; N], u32) {
    let ray = &boxes.ray;
    let mut enter = [boxes.start; N];
    let mut leave = [limit; N];
    for axis in 0..3 {
        let sign = (ray.negative >> axis & 1) as usize;
        let (near, far) = (&node.planes[sign][axis], &node.planes[1 - sign][axis]);
        for lane in 0..N {
            let near = near[lane] * ray.inverse[axis] + ray.near[axis];
            let far = far[lane] * ray.inverse[axis] + ray.far[axis];
            // What is not a number says nothing.
            enter[lane] = if near > enter[lane] {
                near
            } else {
                enter[lane]
            };
            leave[lane] = if far < leave[lane] { far } else { leave[lane] };
        }
    }
    let mut met = [0; N];
    for lane in 0..N {
        met[lane] = u32::from(enter[lane] <= leave[lane]) << lane;
        // Behind the origin there is no order.
        enter[lane] = enter[lane].max(0.0);
    }
    (enter, met.iter().fold(0, |all, bit| all | bit))
}

/// Writes the children in `mask` to `top`, far ones first; returns how many.
///
/// # Safety
/// There is room.
#[inline(always)]
unsafe fn sorted<const N: usize>(
    node: &Node<N>,
    enter: &[f32; N],
    mut mask: u32,
    top: *mut Waiting,
) -> usize {
    let mut count = 0;
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize & (N - 1);
        mask &= mask - 1;
        let entry = u64::from(enter[lane].to_bits()) << 32 | u64::from(node.children[lane]);
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

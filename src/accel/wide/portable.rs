//! Plain Rust that compilers turn into whatever vectors there are; for any ray, also one that f32 cannot hold.

use std::array::from_fn;
use std::mem::MaybeUninit;

use crate::accel::ray::TreeRay;

use super::block::{Block, LANES};
use super::kernel::{Kernel, STACK, Stack, Waiting};
use super::node::{NONE, Node};

#[derive(Clone, Copy)]
pub(super) struct Portable;

#[derive(Clone, Copy)]
pub(super) struct Boxes {
    ray: TreeRay,
    start: f32,
}

impl<const N: usize> Kernel<N> for Portable {
    type Boxes = Boxes;
    type Corners = TreeRay;

    #[inline(always)]
    fn boxes(self, ray: &TreeRay, start: f32) -> Boxes {
        Boxes { ray: *ray, start }
    }

    #[inline(always)]
    fn corners(self, ray: &TreeRay, _start: f32) -> TreeRay {
        *ray
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
        let ray = &boxes.ray;
        let mut enter = [boxes.start; N];
        let mut leave = [limit; N];
        for axis in 0..3 {
            let sign = ray.sign[axis] as usize;
            let (near, far) = (&node.planes[sign][axis], &node.planes[1 - sign][axis]);
            for lane in 0..N {
                enter[lane] = enter[lane].max(near[lane] * ray.inverse[axis] - ray.near[axis]);
                leave[lane] = leave[lane].min(far[lane] * ray.inverse[axis] - ray.far[axis]);
            }
        }
        let first = *len;
        for lane in 0..N {
            if enter[lane] > leave[lane] {
                continue;
            }
            let entry =
                u64::from(enter[lane].max(0.0).to_bits()) << 32 | u64::from(node.children[lane]);
            let mut place = *len;
            while place > first {
                // SAFETY: just written.
                let above = unsafe { stack[place - 1].assume_init() };
                if above >= entry {
                    break;
                }
                stack[place].write(above);
                place -= 1;
            }
            stack[place].write(entry);
            *len += 1;
        }
        if *len == first {
            return NONE;
        }
        *len -= 1;
        // SAFETY: just written.
        unsafe { stack[*len].assume_init() as u32 }
    }

    #[inline(always)]
    unsafe fn push(self, node: &Node<N>, boxes: &Boxes, limit: f32, top: *mut Waiting) -> usize {
        let mut stack: Stack = [MaybeUninit::uninit(); STACK];
        let mut len = 0;
        let nearest = Kernel::<N>::enter(self, node, boxes, limit, &mut stack, &mut len);
        if nearest == NONE {
            return 0;
        }
        unsafe {
            for (i, waiting) in stack[..=len].iter().enumerate() {
                top.add(i).write(waiting.assume_init());
            }
        }
        len + 1
    }

    #[inline(always)]
    fn candidates(self, block: &Block, ray: &TreeRay, _limit: f32) -> u32 {
        let (scale, least) = ray.doubt();
        let mut size = [0.0_f32; LANES];
        let corners = block.corners.each_ref().map(|planes| {
            let relative = |i: usize| -> [f32; LANES] {
                from_fn(|lane| planes[ray.axes[i] as usize][lane] - ray.origin[i])
            };
            let (px, py, pz) = (relative(0), relative(1), relative(2));
            let p: [[f32; LANES]; 2] = [
                from_fn(|lane| px[lane] - pz[lane] * ray.shear[0]),
                from_fn(|lane| py[lane] - pz[lane] * ray.shear[1]),
            ];
            size = from_fn(|lane| size[lane].max(p[0][lane].abs()).max(p[1][lane].abs()));
            p
        });
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
        mask
    }
}

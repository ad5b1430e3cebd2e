use std::mem::MaybeUninit;

use glam::DVec3;

use crate::accel::ray::TreeRay;
use crate::accel::triangle::Triangle;
use crate::math::Ray;

use super::Walk;
use super::block::{Block, LANES};
use super::node::{LEAF, NONE, Node};
use super::packet::{GROUP, Met, PACKET, Points, Window};

/// The most subtrees of one tree that a ray may leave to wait; trees are built so.
pub(super) const MOST_WAITING: usize = 480;

/// Entries of a stack: for two levels of trees, with what kernels write beyond the last.
pub(super) const STACK: usize = 2 * MOST_WAITING + 64;

pub(in crate::accel) type Stack = [MaybeUninit<Waiting>; STACK];

/// A subtree that waits: in the upper half the bits of where the ray enters it, of which kernels use the lowest
/// ([`LOST`]) for an order of their own; in the lower half the link.
pub(in crate::accel) type Waiting = u64;

/// The bits of a distance that a [`Waiting`] does not keep.
const LOST: u32 = 15;

/// With this [`is_near`] compares.
#[inline(always)]
pub(in crate::accel) fn limit_bits(limit: f32) -> u32 {
    limit.max(0.0).to_bits() | LOST
}

/// Whether the ray may enter the subtree at or before the limit that `bits` are of.
#[inline(always)]
pub(in crate::accel) fn is_near(waiting: Waiting, bits: u32) -> bool {
    (waiting >> 32) as u32 <= bits
}

/// A number for each child, for vectors to load and to store.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(in crate::accel) struct Aligned<const N: usize>(pub [f32; N]);

/// Whether [`enter_few`] is for these children.
#[inline(always)]
pub(super) fn are_few(mask: u32) -> bool {
    mask.count_ones() <= 3
}

/// [`Kernel::enter`] for the children in `mask`, at most three, that the ray enters at `at`: one number at a time is sooner
/// done than a sort of vectors, and the processor guesses well how many there are.
#[inline(always)]
pub(super) fn enter_few<const N: usize>(
    node: &Node<N>,
    at: &Aligned<N>,
    mask: u32,
    stack: &mut Stack,
    len: &mut usize,
) -> u32 {
    let rest = mask & mask.wrapping_sub(1);
    if rest == 0 {
        return node.only(mask);
    }
    let waiting = |mask: u32| -> Waiting {
        let lane = mask.trailing_zeros() as usize & (N - 1);
        u64::from(at.0[lane].to_bits()) << 32 | u64::from(node.children[lane])
    };
    let mut push = |waiting| {
        // SAFETY: the stack has room for all that wait in the deepest tree.
        unsafe { stack.get_unchecked_mut(*len).write(waiting) };
        *len += 1;
    };
    let (near, far) = in_order(waiting(mask), waiting(rest));
    let last = rest & (rest - 1);
    if last == 0 {
        push(far);
        return near as u32;
    }
    let (near, other) = in_order(near, waiting(last));
    push(far.max(other));
    push(far.min(other));
    near as u32
}

/// The lesser one first. It branches: the processor guesses which one that is and goes on there, and guesses well enough.
#[inline(always)]
fn in_order(a: Waiting, b: Waiting) -> (Waiting, Waiting) {
    if a < b {
        // SAFETY: it does nothing, but may not be left out, and so the branch does not become moves.
        #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
        unsafe {
            std::arch::asm!("", options(nomem, nostack, preserves_flags));
        };
        (a, b)
    } else {
        (b, a)
    }
}

/// Rays that are made ready at once.
pub(in crate::accel) const PREPARED: usize = 8;

/// One ray against the boxes of a node, and against the triangles of a leaf. Whoever has a kernel has the instructions
/// that it is written for.
pub(in crate::accel) trait Kernel<const N: usize>: Copy {
    /// What the box test takes from the ray.
    type Boxes: Copy;

    /// `ray` made ready for a tree, as [`TreeRay::new`] does it.
    #[inline(always)]
    fn prepare_one(self, ray: &Ray, center: DVec3, extent: f32) -> TreeRay {
        TreeRay::new(ray, center, extent)
    }

    /// Whether the kernel takes `ray`, of which `local` was made.
    #[inline(always)]
    fn takes(self, ray: &Ray, local: &TreeRay) -> bool {
        local.fits_kernels(ray)
    }

    /// Writes each of `rays`, made ready for a tree as [`TreeRay::new`] does it, to the same one of `into`.
    ///
    /// # Safety
    /// They may be written to.
    #[inline(always)]
    unsafe fn prepare(
        self,
        rays: &[&Ray; PREPARED],
        center: DVec3,
        extent: f32,
        into: &[*mut TreeRay; PREPARED],
    ) {
        for (ray, into) in rays.iter().zip(into) {
            unsafe { into.write(TreeRay::new(ray, center, extent)) };
        }
    }

    /// For boxes behind `start`, at least 0.
    fn boxes(self, ray: &TreeRay, start: f32) -> Self::Boxes;

    /// The nearest child that the ray meets before `limit`, or [`NONE`]; the others go onto the stack of `len`
    /// entries, far ones first.
    fn enter(
        self,
        node: &Node<N>,
        boxes: &Self::Boxes,
        limit: f32,
        stack: &mut Stack,
        len: &mut usize,
    ) -> u32;

    /// Where the ray enters the boxes of the children, into `at`, and a bit for each that it meets before `limit`.
    fn meet(self, node: &Node<N>, boxes: &Self::Boxes, limit: f32, at: &mut Aligned<N>) -> u32;

    /// Writes the children in `mask`, which the ray enters at `at`, to `top`, where there is room for `N` and what the
    /// kernel writes beyond, far ones first; returns how many.
    ///
    /// # Safety
    /// There is such room.
    unsafe fn sort(self, node: &Node<N>, at: &Aligned<N>, mask: u32, top: *mut Waiting) -> usize;

    /// What rays of a packet meet of a triangle with these corners, relative to their origin: [`Packet::decide`].
    #[inline(always)]
    fn decide(
        self,
        shear: [&[f64; GROUP]; 2],
        length: &[f64; GROUP],
        corners: [[f64; 3]; 3],
    ) -> Met {
        let mut met = Met {
            mask: 0,
            inside: 0,
            t: [0.0; GROUP],
            u: [0.0; GROUP],
            v: [0.0; GROUP],
        };
        for i in 0..GROUP {
            let shear = [shear[0][i], shear[1][i]];
            if let Some(hit) = Triangle::intersect_from_origin(shear, length[i], corners) {
                met.mask |= 1 << i;
                met.inside |= u8::from(hit.inside) << i;
                (met.t[i], met.u[i], met.v[i]) = (hit.t, hit.u, hit.v);
            }
        }
        met
    }

    /// A bit for each point in the window whose ray looks as far.
    #[inline(always)]
    fn within(self, points: &Points, window: &Window) -> u64 {
        (0..PACKET).fold(0, |mask, i| {
            let (x, y) = (points.x[i], points.y[i]);
            let inside = (window.x[0] <= x)
                & (x <= window.x[1])
                & (window.y[0] <= y)
                & (y <= window.y[1])
                & (window.near <= points.reach[i]);
            mask | u64::from(inside) << i
        })
    }

    /// A bit for each triangle that is not certainly missed, or certainly hit before `start` or beyond `limit`; and for
    /// each how far its farthest corner is, forward or backward along the ray's longest axis.
    fn candidates(
        self,
        block: &Block,
        ray: &TreeRay,
        start: f32,
        limit: f32,
    ) -> (u32, [f32; LANES]);
}

/// The way of a ray through a tree. It is no function that calls another at each leaf: such a call may not be inlined,
/// and then its kernel's instructions are calls, too.
pub(in crate::accel) struct Descent<'a, K: Kernel<N>, const N: usize> {
    kernel: K,
    walk: Walk<'a, N>,
    boxes: K::Boxes,
    stack: &'a mut Stack,
    /// Entries on the stack.
    len: usize,
    link: u32,
}

/// Room for what waits on a [`Descent`].
#[inline(always)]
pub(in crate::accel) fn stack() -> Stack {
    [MaybeUninit::uninit(); STACK]
}

impl<'a, K: Kernel<N>, const N: usize> Descent<'a, K, N> {
    /// For boxes behind `start`, at least 0.
    #[inline(always)]
    pub(in crate::accel) fn new(
        kernel: K,
        walk: Walk<'a, N>,
        ray: &TreeRay,
        start: f32,
        stack: &'a mut Stack,
    ) -> Self {
        Self {
            kernel,
            walk,
            boxes: kernel.boxes(ray, start),
            stack,
            len: 0,
            link: walk.root,
        }
    }

    /// The next leaf whose box the ray meets before `limit`, nearest first as far as boxes tell. Limits never grow.
    #[inline(always)]
    pub(in crate::accel) fn next(&mut self, limit: f32) -> Option<u32> {
        loop {
            while self.link & LEAF == 0 {
                // SAFETY: links of a tree lead to its nodes.
                let node = unsafe { self.walk.node(self.link) };
                self.link =
                    (self.kernel).enter(node, &self.boxes, limit, self.stack, &mut self.len);
            }
            if self.link != NONE {
                let leaf = self.link & !LEAF;
                self.link = NONE;
                return Some(leaf);
            }
            let bits = limit_bits(limit);
            self.link = loop {
                if self.len == 0 {
                    return None;
                }
                self.len -= 1;
                // SAFETY: `enter` wrote all entries below `len`, which never is above what the tree's depth allows.
                let waiting = unsafe { self.stack.get_unchecked(self.len).assume_init() };
                if is_near(waiting, bits) {
                    break waiting as u32;
                }
            };
        }
    }
}

use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use glam::DVec3;

use crate::accel::ray::TreeRay;
use crate::accel::triangle::Triangle;
use crate::math::Ray;

use super::Walk;
use super::block::Block;
use super::node::{LEAF, NONE, Node};
use super::packet::{GROUP, Met, PACKET, Points, Window};

/// The most subtrees of one tree that a ray may leave to wait; trees are built so.
pub(super) const MOST_WAITING: usize = 480;

/// Entries of a stack: for two levels of trees, with what kernels write beyond the last.
pub(super) const STACK: usize = 2 * MOST_WAITING + 64;

pub(super) type Stack = [MaybeUninit<Waiting>; STACK];

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

/// Rays that are made ready at once.
pub(in crate::accel) const PREPARED: usize = 8;

/// One ray against the boxes of a node, and against the triangles of a leaf. Whoever has a kernel has the instructions
/// that it is written for.
pub(in crate::accel) trait Kernel<const N: usize>: Copy {
    /// What the box test takes from the ray.
    type Boxes: Copy;
    /// What the triangle test takes from the ray.
    type Corners: Copy;

    /// Writes each of `rays`, made ready for a tree as [`TreeRay::new`] does it, to the same one of `into`.
    ///
    /// # Safety
    /// They may be written to.
    #[inline(always)]
    unsafe fn prepare(
        self,
        rays: &[Ray; PREPARED],
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

    /// Hits before `start` do not matter.
    fn corners(self, ray: &TreeRay, start: f32) -> Self::Corners;

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

    /// Writes the children that the ray meets before `limit` to `top`, where there is room for `N` and what the kernel
    /// writes beyond, far ones first; returns how many.
    ///
    /// # Safety
    /// There is such room.
    unsafe fn push(
        self,
        node: &Node<N>,
        boxes: &Self::Boxes,
        limit: f32,
        top: *mut Waiting,
    ) -> usize;

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

    /// A bit for each triangle that is not certainly missed, or certainly hit before the start or beyond `limit`.
    fn candidates(self, block: &Block, corners: &Self::Corners, limit: f32) -> u32;
}

/// Visits the leaves whose boxes the ray meets from `start` on, nearest first as far as boxes tell. `visit` gets a
/// leaf's index and answers with the new limit, or breaks.
#[inline(always)]
pub(super) fn traverse<K: Kernel<N>, const N: usize>(
    kernel: K,
    walk: Walk<'_, N>,
    ray: &TreeRay,
    start: f32,
    mut limit: f32,
    mut visit: impl FnMut(u32) -> ControlFlow<(), f32>,
) -> ControlFlow<()> {
    let boxes = kernel.boxes(ray, start);
    let mut stack: Stack = [MaybeUninit::uninit(); STACK];
    let mut len = 0;
    let mut link = walk.root;
    loop {
        while link & LEAF == 0 {
            // SAFETY: links of a tree lead to its nodes.
            let node = unsafe { walk.nodes.get_unchecked(link as usize) };
            link = kernel.enter(node, &boxes, limit, &mut stack, &mut len);
        }
        if link != NONE {
            limit = visit(link & !LEAF)?;
        }
        let bits = limit_bits(limit);
        link = loop {
            if len == 0 {
                return ControlFlow::Continue(());
            }
            len -= 1;
            // SAFETY: `enter` wrote all entries below `len`, which never is above what the tree's depth allows.
            let waiting = unsafe { stack.get_unchecked(len).assume_init() };
            if is_near(waiting, bits) {
                break waiting as u32;
            }
        };
    }
}

//! Trees of boxes with many children a node, tested all at once.

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, clippy::wildcard_imports)]
mod avx2;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, clippy::wildcard_imports)]
mod avx512;
mod block;
mod collapse;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, clippy::wildcard_imports)]
mod decide;
mod kernel;
mod node;
mod packet;
mod portable;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, clippy::wildcard_imports)]
mod prepare;
mod stream;

use std::any::Any;
use std::mem::MaybeUninit;

use glam::DVec3;
use obvhs::aabb::Aabb;

use crate::memory::Pages;

use super::build;
use super::options::{AccelOptions, Kernel as Choice};
#[cfg(target_arch = "x86_64")]
use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
use avx512::Avx512;
use node::{Node, STEP};
use portable::Portable;

pub(super) use block::{Block, LANES};
use kernel::Aligned;
pub(super) use kernel::{Descent, Kernel, PREPARED, Waiting, is_near, limit_bits, stack};
pub(super) use node::LEAF;
pub(super) use packet::{Catch, GROUP, PACKET, Packet, Seat, walk_packet};
pub(super) use stream::{Entrant, Group, Next, RAYS, Root, Traffic, stream};

/// A tree with as many children a node as its kernel tests at once; what its leaves hold is the caller's affair.
#[derive(Debug)]
pub(super) struct WideTree {
    nodes: Nodes,
    root: u32,
    kernel: Choice,
}

#[derive(Debug)]
enum Nodes {
    Eight(Pages<Node<8>>),
    Sixteen(Pages<Node<16>>),
}

/// What each leaf holds: leaf `i` has the primitives `order[starts[i]..starts[i + 1]]`.
pub(super) struct Leaves {
    pub starts: Vec<u32>,
    pub order: Vec<u32>,
}

/// Work on a tree, compiled for every kernel.
pub(super) trait Task {
    type Output;

    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, walk: Walk<'_, N>) -> Self::Output;
}

/// The nodes of a tree.
#[derive(Clone, Copy)]
pub(super) struct Walk<'a, const N: usize> {
    nodes: &'a [Node<N>],
    root: u32,
}

impl<'a, const N: usize> Walk<'a, N> {
    /// Only what is below `link`.
    #[inline(always)]
    pub(super) fn below(self, link: u32) -> Self {
        Self { root: link, ..self }
    }

    /// Where to start from.
    #[inline(always)]
    pub(super) fn root(self) -> u32 {
        self.root
    }

    /// # Safety
    /// `link` is one of this tree, to a node.
    #[inline(always)]
    unsafe fn node(self, link: u32) -> &'a Node<N> {
        unsafe { &*self.nodes.as_ptr().byte_add(link as usize * STEP) }
    }

    /// The children that the ray meets before `limit`, far ones first.
    #[inline(always)]
    pub(super) fn children<'b, K: Kernel<N>>(
        self,
        kernel: K,
        node: u32,
        boxes: &K::Boxes,
        limit: f32,
        room: &'b mut Children,
    ) -> &'b [Waiting] {
        let top = room.0.as_mut_ptr().cast::<Waiting>();
        let mut at = Aligned([0.0; N]);
        // SAFETY: links of a tree lead to its nodes; there is room for all that `sort` writes, which is at least what it
        // says.
        unsafe {
            let node = self.node(node);
            let mask = kernel.meet(node, boxes, limit, &mut at);
            let count = kernel.sort(node, &at, mask, top);
            std::slice::from_raw_parts(top, count)
        }
    }
}

/// Room for the children of a node.
pub(super) struct Children([MaybeUninit<Waiting>; 2 * MOST]);

/// The most children that a node has.
const MOST: usize = 16;

impl Children {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self([MaybeUninit::uninit(); 2 * MOST])
    }
}

impl WideTree {
    /// Builds over `boxes`, at least one, all finite, with at most `most` of them in a leaf.
    pub(super) fn build(boxes: &[Aabb], most: u32, options: AccelOptions) -> (Self, Leaves) {
        let options = options.supported();
        match options.kernel {
            #[cfg(target_arch = "x86_64")]
            Choice::Avx512 => Self::of(boxes, most, options, Nodes::Sixteen),
            _ => Self::of(boxes, most, options, Nodes::Eight),
        }
    }

    fn of<const N: usize>(
        boxes: &[Aabb],
        most: u32,
        options: AccelOptions,
        hold: impl Fn(Pages<Node<N>>) -> Nodes,
    ) -> (Self, Leaves) {
        let collapsed = build::binary(boxes, options.quality, |bvh| {
            collapse::collapse::<N>(bvh, most)
        });
        let tree = Self {
            nodes: hold(Pages::new(collapsed.nodes.len(), |i| collapsed.nodes[i])),
            root: collapsed.root,
            kernel: options.kernel,
        };
        let leaves = Leaves {
            starts: collapsed.starts,
            order: collapsed.order,
        };
        (tree, leaves)
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        match &self.nodes {
            Nodes::Eight(nodes) => size_of_val(&**nodes),
            Nodes::Sixteen(nodes) => size_of_val(&**nodes),
        }
    }

    /// Runs the task with the tree's kernel.
    #[inline]
    pub(super) fn run<T: Task>(&self, task: T) -> T::Output {
        match (&self.nodes, self.kernel) {
            // SAFETY: `build` takes only kernels that the processor has.
            #[cfg(target_arch = "x86_64")]
            (Nodes::Sixteen(nodes), Choice::Avx512) => unsafe {
                run_avx512(task, self.walk(nodes))
            },
            #[cfg(target_arch = "x86_64")]
            (Nodes::Eight(nodes), Choice::Avx2) => unsafe { run_avx2(task, self.walk(nodes)) },
            _ => self.run_portable(task),
        }
    }

    /// Runs the task with the portable kernel, which takes every ray.
    #[inline(never)]
    pub(super) fn run_portable<T: Task>(&self, task: T) -> T::Output {
        match &self.nodes {
            Nodes::Eight(nodes) => task.run(Portable, self.walk(nodes)),
            Nodes::Sixteen(nodes) => task.run(Portable, self.walk(nodes)),
        }
    }

    /// Visits the leaves whose boxes hold `p`, in no particular order.
    pub(super) fn around(&self, p: DVec3, visit: impl FnMut(u32)) {
        match &self.nodes {
            Nodes::Eight(nodes) => around(self.walk(nodes), p, visit),
            Nodes::Sixteen(nodes) => around(self.walk(nodes), p, visit),
        }
    }

    /// The nodes, for work with the same kernel on another tree.
    ///
    /// # Panics
    /// Where `N` is that of another kernel.
    #[inline(always)]
    pub(super) fn nodes<const N: usize>(&self) -> Walk<'_, N> {
        let nodes: &dyn Any = match &self.nodes {
            Nodes::Eight(nodes) => nodes,
            Nodes::Sixteen(nodes) => nodes,
        };
        let nodes: &Pages<Node<N>> = nodes.downcast_ref().expect("one kernel for all trees");
        self.walk(nodes)
    }

    fn walk<'a, const N: usize>(&self, nodes: &'a [Node<N>]) -> Walk<'a, N> {
        Walk {
            nodes,
            root: self.root,
        }
    }
}

fn around<const N: usize>(walk: Walk<'_, N>, p: DVec3, mut visit: impl FnMut(u32)) {
    let p = p.to_array();
    let mut waiting = vec![walk.root];
    while let Some(link) = waiting.pop() {
        if link & LEAF != 0 {
            visit(link & !LEAF);
            continue;
        }
        // SAFETY: links of a tree lead to its nodes.
        let node = unsafe { walk.node(link) };
        let holds = |lane: usize, axis: usize| {
            let [min, max] = [0, 1].map(|side| f64::from(node.planes[side][axis][lane]));
            min <= p[axis] && p[axis] <= max
        };
        let lanes = (0..N).filter(|&lane| (0..3).all(|axis| holds(lane, axis)));
        waiting.extend(lanes.map(|lane| node.children[lane]));
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn run_avx512<T: Task>(task: T, walk: Walk<'_, 16>) -> T::Output {
    task.run(unsafe { Avx512::new() }, walk)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn run_avx2<T: Task>(task: T, walk: Walk<'_, 8>) -> T::Output {
    task.run(unsafe { Avx2::new() }, walk)
}

use std::sync::atomic::{AtomicU64, Ordering};

use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

use crate::accel::build::MAX_DEPTH;

use super::kernel::MOST_WAITING;
use super::node::{LEAF, Node};

/// What a step into a node costs beside one into a leaf, which tests all its primitives at once.
const NODE_COST: f32 = 5.0;

/// Below this depth subtrees are too small to be worth a task.
const PARALLEL_DEPTH: usize = 10;

/// Of a choice: at most 15 children come after the first.
const BITS: usize = 4;
const CHOICE: u64 = (1 << BITS) - 1;

/// The nodes of a wide tree, and what its leaves hold: leaf `i` has the primitives
/// `order[starts[i]..starts[i + 1]]`.
pub(super) struct Collapsed<const N: usize> {
    pub nodes: Vec<Node<N>>,
    pub root: u32,
    pub starts: Vec<u32>,
    pub order: Vec<u32>,
}

/// Makes of a binary tree the cheapest one with up to `N` children a node and up to `most` primitives a leaf, by the
/// dynamic program of Ylitie, Karras and Laine 2017, section 4.1. `None` where the binary tree is deeper than
/// [`MAX_DEPTH`], or more than [`MOST_WAITING`] subtrees could have to wait for a ray.
pub(super) fn collapse<const N: usize>(bvh: &Bvh2, most: u32) -> Option<Collapsed<N>> {
    const { assert!(N * BITS <= u64::BITS as usize) };
    let program = Program {
        bvh,
        most,
        choices: (0..bvh.nodes.len() / 2)
            .map(|_| AtomicU64::new(0))
            .collect(),
    };
    program.solve(0, 0)?;
    let mut out = Collapsed {
        nodes: Vec::with_capacity(bvh.primitive_indices.len() / (N * 3)),
        root: 0,
        starts: Vec::with_capacity(bvh.primitive_indices.len() / 4),
        order: Vec::with_capacity(bvh.primitive_indices.len()),
    };
    let waiting;
    (out.root, waiting) = program.emit(0, &mut out);
    out.starts.push(out.order.len() as u32);
    (waiting <= MOST_WAITING).then_some(out)
}

struct Program<'a, const N: usize> {
    bvh: &'a Bvh2,
    most: u32,
    /// For each pair of children, four bits a choice, the lowest first. At 0: how many children after the first their
    /// parent gets as a node, or 0 where it becomes a leaf. At `i`: if it becomes `i + 1` subtrees, how many of them come
    /// from the first child, or 0 where one fewer is cheaper.
    choices: Vec<AtomicU64>,
}

/// What a subtree costs if it becomes at most `i + 1` subtrees, for each `i` below `len`.
struct Solved<const N: usize> {
    costs: [f32; N],
    len: usize,
    primitives: u32,
}

impl<const N: usize> Program<'_, N> {
    fn solve(&self, index: u32, depth: usize) -> Option<Solved<N>> {
        let node = &self.bvh.nodes[index as usize];
        let area = node.aabb.half_area();
        let mut costs = [area; N];
        if node.is_leaf() {
            return Some(Solved {
                costs,
                len: 1,
                primitives: node.prim_count,
            });
        }
        if depth >= MAX_DEPTH {
            return None;
        }
        let [left, right] = [node.first_index, node.first_index + 1];
        let (left, right) = if depth < PARALLEL_DEPTH {
            rayon::join(
                || self.solve(left, depth + 1),
                || self.solve(right, depth + 1),
            )
        } else {
            (self.solve(left, depth + 1), self.solve(right, depth + 1))
        };
        let (left, right) = (left?, right?);
        let primitives = left.primitives + right.primitives;
        let len = (left.len + right.len).min(N);
        let mut choices = 0;
        let (mut least, mut more) = (f32::INFINITY, 0);
        for i in 2..=len {
            let (mut cost, mut share) = (f32::INFINITY, 0);
            for k in i.saturating_sub(right.len).max(1)..=left.len.min(i - 1) {
                let sum = left.costs[k - 1] + right.costs[i - k - 1];
                if sum < cost {
                    (cost, share) = (sum, k);
                }
            }
            if cost <= least {
                (least, more) = (cost, i - 1);
            }
            costs[i - 1] = cost;
            choices |= (share as u64) << (BITS * (i - 1));
        }
        costs[0] = least + NODE_COST * area;
        if primitives <= self.most && area <= costs[0] {
            (costs[0], more) = (area, 0);
        }
        choices |= more as u64;
        for i in 1..len {
            if costs[i - 1] < costs[i] {
                costs[i] = costs[i - 1];
                choices &= !(CHOICE << (BITS * i));
            }
        }
        self.choices[pair(node)].store(choices, Ordering::Relaxed);
        Some(Solved {
            costs,
            len,
            primitives,
        })
    }

    /// Writes the subtree at `index` behind what is there; returns the link to it, and how many subtrees may have to
    /// wait for a ray in it.
    fn emit(&self, index: u32, out: &mut Collapsed<N>) -> (u32, usize) {
        let node = &self.bvh.nodes[index as usize];
        let more = if node.is_leaf() {
            0
        } else {
            self.choice(node, 0)
        };
        if more == 0 {
            out.starts.push(out.order.len() as u32);
            self.primitives(node, &mut out.order);
            return (LEAF | (out.starts.len() - 1) as u32, 0);
        }
        let mut parts = [0; N];
        let mut len = 0;
        self.parts(index, 1 + more, &mut parts, &mut len);
        let place = out.nodes.len();
        out.nodes.push(Node::EMPTY);
        let mut waiting = 0;
        for (lane, &part) in parts[..len].iter().enumerate() {
            let (link, below) = self.emit(part, out);
            waiting = waiting.max(below);
            out.nodes[place].set(lane, &self.bvh.nodes[part as usize].aabb, link);
        }
        (Node::<N>::link(place), waiting + len - 1)
    }

    /// Adds the subtrees, at most `count`, that the one at `index` becomes.
    fn parts(&self, index: u32, count: usize, parts: &mut [u32; N], len: &mut usize) {
        let node = &self.bvh.nodes[index as usize];
        let mut i = count - 1;
        while i > 0 && !node.is_leaf() && self.choice(node, i) == 0 {
            i -= 1;
        }
        if i == 0 || node.is_leaf() {
            parts[*len] = index;
            *len += 1;
            return;
        }
        let first = self.choice(node, i);
        self.parts(node.first_index, first, parts, len);
        self.parts(node.first_index + 1, i + 1 - first, parts, len);
    }

    fn choice(&self, node: &Bvh2Node, i: usize) -> usize {
        let choices = self.choices[pair(node)].load(Ordering::Relaxed);
        (choices >> (BITS * i) & CHOICE) as usize
    }

    /// All primitives below `node`.
    fn primitives(&self, node: &Bvh2Node, order: &mut Vec<u32>) {
        if node.is_leaf() {
            let first = node.first_index as usize;
            let range = first..first + node.prim_count as usize;
            order.extend_from_slice(&self.bvh.primitive_indices[range]);
        } else {
            for child in [node.first_index, node.first_index + 1] {
                self.primitives(&self.bvh.nodes[child as usize], order);
            }
        }
    }
}

/// Children stand in pairs behind the root.
fn pair(node: &Bvh2Node) -> usize {
    (node.first_index as usize - 1) / 2
}

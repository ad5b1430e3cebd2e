use std::ops::{ControlFlow, Range};

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

use crate::math::Bounds;

use super::build::{self, Link, MAX_DEPTH};
use super::ray::TreeRay;

/// A binary tree of boxes around `center`; what its leaves hold is the caller's affair.
#[derive(Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    root: Link,
    /// Boxes are stored relative to this point.
    pub center: DVec3,
    /// Largest half size.
    pub extent: f32,
}

/// The boxes of both children: planes `[axis][min, max][child]`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Node {
    planes: [[[f32; 2]; 2]; 3],
    children: [Link; 2],
}

impl Tree {
    /// Builds over `bounds`, at least one, all finite, at most `leaf` of them in a leaf. Returns the leaf order as well:
    /// position in the leaves to index in `bounds`.
    pub(super) fn build(bounds: &[Bounds], leaf: u32) -> (Self, Vec<u32>) {
        let whole = bounds.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        let center = exact_center(&whole);
        let boxes: Vec<Aabb> = bounds
            .iter()
            .map(|b| {
                let (min, max) = Bounds {
                    min: b.min - center,
                    max: b.max - center,
                }
                .outward_f32();
                Aabb::new(min.into(), max.into())
            })
            .collect();
        let topology = build::build(&boxes, leaf);
        let mut nodes = vec![
            Node {
                planes: [[[0.0; 2]; 2]; 3],
                children: [topology.root; 2],
            };
            topology.children.len()
        ];
        // Children stand behind their parents, so a backward pass sees them first.
        let mut around = vec![Aabb::INVALID; nodes.len()];
        for index in (0..nodes.len()).rev() {
            let children = topology.children[index];
            nodes[index].children = children;
            for (side, child) in children.into_iter().enumerate() {
                let aabb = if child.count == 0 {
                    around[child.first as usize]
                } else {
                    let leaf = child.first as usize..(child.first + child.count) as usize;
                    (topology.order[leaf].iter())
                        .fold(Aabb::INVALID, |sum, &i| sum.union(&boxes[i as usize]))
                };
                around[index] = around[index].union(&aabb);
                for axis in 0..3 {
                    nodes[index].planes[axis][0][side] = aabb.min[axis];
                    nodes[index].planes[axis][1][side] = aabb.max[axis];
                }
            }
        }
        let reach = (boxes.iter()).fold(Vec3A::ZERO, |r, b| r.max(b.min.abs()).max(b.max.abs()));
        let tree = Self {
            nodes,
            root: topology.root,
            center,
            extent: reach.max_element(),
        };
        (tree, topology.order)
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }

    /// Where to start from.
    pub(super) fn root(&self) -> Link {
        self.root
    }

    /// How many inner nodes there are.
    pub(super) fn inner_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// What lies below an inner node: inner nodes stand behind it.
    pub(super) fn below(&self, node: u32) -> [Link; 2] {
        self.nodes[node as usize].children
    }

    /// The children of the inner node `link`, and where the ray enters their boxes, if it does between `tmin` and
    /// `tmax`.
    #[inline]
    pub(super) fn children(
        &self,
        link: Link,
        ray: &TreeRay,
        tmin: f32,
        tmax: f32,
    ) -> ([Option<f32>; 2], [Link; 2]) {
        let node = &self.nodes[link.first as usize];
        (node.entry(ray, tmin, tmax), node.children)
    }

    /// Visits the leaves whose boxes hold the point `p`, in no particular order.
    pub(super) fn around(&self, p: DVec3, mut visit: impl FnMut(Range<u32>)) {
        let p = (p - self.center).to_array();
        let mut stack = vec![self.root];
        while let Some(link) = stack.pop() {
            if link.count > 0 {
                visit(link.first..link.first + link.count);
                continue;
            }
            let node = &self.nodes[link.first as usize];
            for side in 0..2 {
                let inside = |axis: usize| {
                    let [min, max] = node.planes[axis].map(|planes| f64::from(planes[side]));
                    p[axis] >= min && p[axis] <= max
                };
                if (0..3).all(inside) {
                    stack.push(node.children[side]);
                }
            }
        }
    }

    /// Visits the leaves whose boxes the ray meets before `tmax`, nearest first as far as boxes tell.
    /// `visit` gets the leaf's positions and answers with the new `tmax`, or breaks.
    pub(super) fn traverse(
        &self,
        ray: &TreeRay,
        tmin: f32,
        mut tmax: f32,
        mut visit: impl FnMut(Range<u32>) -> ControlFlow<(), f32>,
    ) -> ControlFlow<()> {
        let mut stack = [(self.root, 0.0_f32); MAX_DEPTH + 1];
        let mut height = 0;
        let mut current = self.root;
        loop {
            let next = if current.count > 0 {
                tmax = visit(current.first..current.first + current.count)?;
                None
            } else {
                let node = &self.nodes[current.first as usize];
                let [a, b] = node.entry(ray, tmin, tmax);
                match (a, b) {
                    (Some(a), Some(b)) => {
                        let (near, far, t) = if a <= b { (0, 1, b) } else { (1, 0, a) };
                        stack[height] = (node.children[far], t);
                        height += 1;
                        Some(node.children[near])
                    }
                    (Some(_), None) => Some(node.children[0]),
                    (None, Some(_)) => Some(node.children[1]),
                    (None, None) => None,
                }
            };
            current = match next {
                Some(link) => link,
                None => loop {
                    if height == 0 {
                        return ControlFlow::Continue(());
                    }
                    height -= 1;
                    let (link, t) = stack[height];
                    if t <= tmax {
                        break link;
                    }
                },
            };
        }
    }
}

/// A point to measure from so that the difference to every f32 coordinate in `bounds` is an f32 again.
/// Where an axis lies far from 0 against its length that is its middle, by Sterbenz's lemma (within a
/// factor of two, differences are exact); elsewhere 0, and coordinates are of the size of the box.
pub(super) fn exact_center(bounds: &Bounds) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| {
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        let middle = f64::from((0.5 * (min + max)) as f32);
        let (near, far) = (min.abs().min(max.abs()), min.abs().max(max.abs()));
        let exact = min * max > 0.0 && 2.0 * near >= middle.abs() && far <= 2.0 * middle.abs();
        if exact { middle } else { 0.0 }
    }))
}

impl Node {
    /// Where the ray enters each child's box, if it does before `tmax`.
    #[inline]
    fn entry(&self, ray: &TreeRay, tmin: f32, tmax: f32) -> [Option<f32>; 2] {
        let mut enter = [tmin; 2];
        let mut leave = [tmax; 2];
        for axis in 0..3 {
            let near = self.planes[axis][ray.sign[axis]];
            let far = self.planes[axis][1 - ray.sign[axis]];
            for side in 0..2 {
                enter[side] = enter[side].max(near[side] * ray.inverse[axis] - ray.near[axis]);
                leave[side] = leave[side].min(far[side] * ray.inverse[axis] - ray.far[axis]);
            }
        }
        [0, 1].map(|side| (enter[side] <= leave[side]).then_some(enter[side]))
    }
}

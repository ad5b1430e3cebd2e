use std::ops::ControlFlow;

use glam::DVec3;
use rayon::join;

use crate::math::{Bounds, Ray};

/// Items found by their boxes: halved at the median again and again. Simple, in f64, and of nobody else's code.
#[derive(Debug)]
pub(super) struct BoxIndex {
    /// Each before its two halves.
    nodes: Vec<Node>,
    order: Vec<u32>,
    /// The largest coordinate of any box.
    extent: f64,
}

#[derive(Debug)]
struct Node {
    bounds: Bounds,
    /// The number of nodes in its part of the list, itself included.
    size: u32,
    /// Of a leaf: where its items start and how many they are.
    start: u32,
    count: u32,
}

/// Most items of a leaf.
const LEAF: usize = 4;

/// From so many items on, both halves are worth a thread.
const PARALLEL: usize = 1 << 14;

impl BoxIndex {
    pub(super) fn new(boxes: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let nodes = split(boxes, &mut order, 0);
        let root = nodes.first().map_or(Bounds::EMPTY, |node| node.bounds);
        Self {
            nodes,
            order,
            extent: root.min.abs().max(root.max.abs()).max_element(),
        }
    }

    /// Shows `visit` every item whose box meets `ray` between its ends, and some whose box nearly does, in no order.
    /// `visit` says how far the ray still matters, or that it has seen enough.
    pub(super) fn visit(
        &self,
        ray: &Ray,
        mut visit: impl FnMut(u32) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        // Far above the rounding of the planes' distances. Where a component is 0 its planes are at most 0 or as good
        // as infinitely far away, and never no number.
        let reach = self.extent + ray.origin.abs().max_element();
        let pad = DVec3::splat(2.0_f64.powi(-40) * reach);
        let inverse = (ray.direction.recip()).clamp(DVec3::splat(-1e300), DVec3::splat(1e300));
        let mut end = ray.tmax;
        let mut next = 0;
        while let Some(node) = self.nodes.get(next) {
            let a = (node.bounds.min - pad - ray.origin) * inverse;
            let b = (node.bounds.max + pad - ray.origin) * inverse;
            let enter = a.min(b).max_element().max(ray.tmin);
            let leave = a.max(b).min_element().min(end);
            if enter > leave {
                next += node.size as usize;
                continue;
            }
            next += 1;
            for &item in &self.order[node.start as usize..][..node.count as usize] {
                end = end.min(visit(item)?);
            }
        }
        ControlFlow::Continue(())
    }
}

/// The nodes over `order`, which starts at `start` in the whole list.
fn split(boxes: &[Bounds], order: &mut [u32], start: u32) -> Vec<Node> {
    let of = |item: &u32| boxes[*item as usize];
    let bounds = order.iter().map(of).fold(Bounds::EMPTY, Bounds::union);
    let mut node = Node {
        bounds,
        size: 1,
        start,
        count: order.len() as u32,
    };
    if order.len() <= LEAF {
        return vec![node];
    }
    let centers = Bounds::of_points(order.iter().map(|item| of(item).center()));
    let axis = centers.size().max_position();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |a, b| {
        of(a).center()[axis].total_cmp(&of(b).center()[axis])
    });
    let parallel = order.len() > PARALLEL;
    let (low, high) = order.split_at_mut(half);
    let mut low = || split(boxes, low, start);
    let mut high = || split(boxes, high, start + half as u32);
    let (low, high) = if parallel {
        join(low, high)
    } else {
        (low(), high())
    };
    node.count = 0;
    node.size += (low.len() + high.len()) as u32;
    let mut nodes = Vec::with_capacity(node.size as usize);
    nodes.push(node);
    nodes.extend(low);
    nodes.extend(high);
    nodes
}

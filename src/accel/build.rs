use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;

use super::options::Quality;

/// Good trees in time linear in the input. Pre-splits are off: they gain nothing on scans.
const fn params(quality: Quality, leaf: u32) -> BvhBuildParams {
    let preset = match quality {
        Quality::Fast => BvhBuildParams::fastest_build(),
        Quality::Balanced => BvhBuildParams::medium_build(),
        Quality::Best => BvhBuildParams::very_slow_build(),
    };
    BvhBuildParams {
        pre_split: false,
        max_prims_per_leaf: leaf,
        ..preset
    }
}

/// Builds a binary tree with one primitive a leaf over `boxes`, at least one, all finite, and makes `T` of it; of another one where
/// the tree is too deep for that.
pub(super) fn binary<T>(boxes: &[Aabb], quality: Quality, make: impl Fn(&Bvh2) -> Option<T>) -> T {
    let bvh = build_bvh2(
        boxes,
        params(quality, 1),
        &mut std::time::Duration::default(),
    );
    make(&bvh).unwrap_or_else(|| make(&halved(boxes)).expect("depth log2(n)"))
}

/// Halves the primitives at the median of the widest axis of their centres: not the fastest rays, but depth log2(n)
/// whatever the input.
fn halved(boxes: &[Aabb]) -> Bvh2 {
    let center = |i: u32| boxes[i as usize].min + boxes[i as usize].max;
    let around =
        |part: &[u32]| (part.iter()).fold(Aabb::INVALID, |sum, &i| sum.union(&boxes[i as usize]));
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::new(around(&order), 0, 0)];
    let mut todo = vec![(0, order.len(), 0)];
    while let Some((start, len, node)) = todo.pop() {
        if len == 1 {
            nodes[node] = Bvh2Node::new(*nodes[node].aabb(), 1, start as u32);
            continue;
        }
        let part = &mut order[start..start + len];
        let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for &i in part.iter() {
            low = low.min(center(i));
            high = high.max(center(i));
        }
        let axis = (high - low).max_position();
        let half = len / 2;
        part.select_nth_unstable_by(half, |&a, &b| {
            center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(&b))
        });
        nodes[node].first_index = nodes.len() as u32;
        for (offset, part) in [(0, &part[..half]), (half, &part[half..])] {
            todo.push((start + offset, part.len(), nodes.len()));
            nodes.push(Bvh2Node::new(around(part), 0, 0));
        }
    }
    Bvh2 {
        nodes,
        primitive_indices: order,
        ..Bvh2::default()
    }
}

/// A reference from one node to what lies below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Link {
    /// Inner: index of the node. Leaf: first position in the primitive order.
    pub first: u32,
    /// 0 for an inner node, else the number of primitives in the leaf.
    pub count: u32,
}

/// A binary tree in a form that does not depend on who built it.
#[derive(Debug)]
pub(super) struct Topology {
    /// The two children of each inner node.
    pub children: Vec<[Link; 2]>,
    /// Where traversal starts.
    pub root: Link,
    /// Leaf order: position to primitive.
    pub order: Vec<u32>,
}

/// No path from the root is longer; traversal stacks rely on it.
pub(super) const MAX_DEPTH: usize = 64;

/// Builds a tree over `boxes`, at least one, all finite, with at most `leaf` of them in a leaf.
pub(super) fn build(boxes: &[Aabb], leaf: u32) -> Topology {
    if boxes.len() == 1 {
        return Topology {
            children: Vec::new(),
            root: Link { first: 0, count: 1 },
            order: vec![0],
        };
    }
    let bvh = build_bvh2(
        boxes,
        params(Quality::Balanced, leaf),
        &mut std::time::Duration::default(),
    );
    from_obvhs(&bvh)
        .or_else(|| from_obvhs(&halved(boxes)))
        .expect("depth log2(n)")
}

/// Renumbers obvhs's nodes depth first; `None` where the tree is deeper than [`MAX_DEPTH`].
fn from_obvhs(bvh: &Bvh2) -> Option<Topology> {
    let link = |index: u32| -> Link {
        let node = &bvh.nodes[index as usize];
        Link {
            first: node.first_index,
            count: node.prim_count,
        }
    };
    let mut children = Vec::with_capacity(bvh.nodes.len() / 2);
    let root = link(0);
    if root.count == 0 {
        // (obvhs index of the first child, our node that waits for them, depth)
        children.push([root; 2]);
        let mut todo = vec![(root.first, 0_usize, 1_usize)];
        while let Some((pair, node, depth)) = todo.pop() {
            if depth > MAX_DEPTH {
                return None;
            }
            for side in 0..2 {
                let mut child = link(pair + side);
                if child.count == 0 {
                    let below = child.first;
                    child.first = children.len() as u32;
                    children.push([child; 2]);
                    todo.push((below, child.first as usize, depth + 1));
                }
                children[node][side as usize] = child;
            }
        }
    }
    Some(Topology {
        root: Link {
            first: 0,
            count: root.count,
        },
        children,
        order: bvh.primitive_indices.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(topology: &Topology, link: Link) -> usize {
        if link.count > 0 {
            return 0;
        }
        let [a, b] = topology.children[link.first as usize];
        1 + depth(topology, a).max(depth(topology, b))
    }

    #[test]
    fn equal_boxes_do_not_make_a_deep_tree() {
        let boxes = vec![Aabb::new(Vec3A::ZERO, Vec3A::ONE); 3000];
        let topology = build(&boxes, 4);
        assert!(depth(&topology, topology.root) <= MAX_DEPTH);
        let mut order = topology.order.clone();
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..3000));
    }
}

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

/// Good trees in time linear in the input. Pre-splits are off: they gain nothing on scans.
const fn params(leaf: u32) -> BvhBuildParams {
    BvhBuildParams {
        pre_split: false,
        max_prims_per_leaf: leaf,
        ..BvhBuildParams::medium_build()
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
    let bvh = build_bvh2(boxes, params(leaf), &mut std::time::Duration::default());
    from_obvhs(&bvh).unwrap_or_else(|| balanced(boxes))
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

/// Halves the primitives at the median of the widest axis of their centres: not the fastest rays,
/// but depth log2(n) whatever the input.
fn balanced(boxes: &[Aabb]) -> Topology {
    const LEAF: usize = 4;
    let center = |i: u32| boxes[i as usize].min + boxes[i as usize].max;
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut children: Vec<[Link; 2]> = Vec::new();
    let whole = |first: usize, len: usize| Link {
        first: first as u32,
        count: if len <= LEAF { len as u32 } else { 0 },
    };
    let root = whole(0, order.len());
    if root.count == 0 {
        children.push([root; 2]);
        let mut todo = vec![(0_usize, order.len(), 0_usize)];
        while let Some((start, len, node)) = todo.pop() {
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
            for (side, (first, count)) in [(start, half), (start + half, len - half)]
                .into_iter()
                .enumerate()
            {
                let mut child = whole(first, count);
                if child.count == 0 {
                    child.first = children.len() as u32;
                    children.push([child; 2]);
                    todo.push((first, count, child.first as usize));
                }
                children[node][side] = child;
            }
        }
    }
    Topology {
        children,
        root,
        order,
    }
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

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;

use super::alike::{alike, mix};
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

/// Builds a binary tree with one primitive a leaf over `boxes`, at least one, all finite, and makes `T` of it; of
/// another one where the tree is too deep for that.
pub(super) fn binary<T>(boxes: &[Aabb], quality: Quality, make: impl Fn(&Bvh2) -> Option<T>) -> T {
    let params = params(quality, 1);
    let outlook = look(boxes);
    let plain = || make(&build_bvh2(boxes, params, &mut Duration::default()));
    let grouped = || make(&build_grouped(boxes, params));
    (outlook == Outlook::Good)
        .then(plain)
        .flatten()
        .or_else(|| (outlook != Outlook::Chain).then(grouped).flatten())
        .unwrap_or_else(|| make(&halved(boxes)).expect("depth log2(n)"))
}

/// Builds over boxes of which many may be equal: obvhs would make a chain of those, in quadratic time.
fn build_grouped(boxes: &[Aabb], params: BvhBuildParams) -> Bvh2 {
    let mut time = Duration::default();
    let groups = equal_boxes(boxes);
    if groups.is_empty() {
        return build_bvh2(boxes, params, &mut time);
    }
    // Each group is built as its first member.
    let mut members: Vec<&[u32]> = vec![&[]; boxes.len()];
    let mut later = vec![false; boxes.len()];
    for group in &groups {
        members[group[0] as usize] = group;
        for &i in &group[1..] {
            later[i as usize] = true;
        }
    }
    let distinct: Vec<u32> = (0..boxes.len() as u32)
        .filter(|&i| !later[i as usize])
        .collect();
    let few: Vec<Aabb> = distinct.iter().map(|&i| boxes[i as usize]).collect();
    let params = BvhBuildParams {
        max_prims_per_leaf: 1,
        ..params
    };
    let mut bvh = build_bvh2(&few, params, &mut time);
    for i in &mut bvh.primitive_indices {
        *i = distinct[*i as usize];
    }
    // A leaf of a group becomes a balanced tree over its members.
    for leaf in 0..bvh.nodes.len() {
        let node = bvh.nodes[leaf];
        if !node.is_leaf() {
            continue;
        }
        let group = members[bvh.primitive_indices[node.first_index as usize] as usize];
        let mut todo = vec![(leaf, group)];
        while let Some((place, group)) = todo.pop() {
            if let [] | [_] = group {
                if let [i] = group {
                    bvh.nodes[place].first_index = bvh.primitive_indices.len() as u32;
                    bvh.primitive_indices.push(*i);
                }
                continue;
            }
            let first = bvh.nodes.len();
            bvh.nodes[place].prim_count = 0;
            bvh.nodes[place].first_index = first as u32;
            bvh.nodes.extend([node; 2]);
            let (a, b) = group.split_at(group.len() / 2);
            todo.extend([(first, a), (first + 1, b)]);
        }
    }
    // The slots of the groups' first members are left over.
    let mut order = Vec::with_capacity(boxes.len());
    for leaf in bvh.nodes.iter_mut().filter(|node| node.is_leaf()) {
        let slot = std::mem::replace(&mut leaf.first_index, order.len() as u32);
        order.push(bvh.primitive_indices[slot as usize]);
    }
    bvh.primitive_indices = order;
    bvh
}

/// What obvhs will make of boxes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outlook {
    /// A good tree.
    Good,
    /// Some may be equal.
    Equal,
    /// A chain, in quadratic time: they are mostly nested in one another.
    Chain,
}

/// Judges by a sample, which is like the whole in this, and by the balanced tree: the fast one may become a chain only
/// where there are many.
fn look(boxes: &[Aabb]) -> Outlook {
    if boxes.len() < 2 * SAMPLE[0] {
        return Outlook::Equal;
    }
    let count = (boxes.len() / 128).clamp(SAMPLE[0], SAMPLE[1]);
    let step = boxes.len() as f64 / count as f64;
    let sample: Vec<Aabb> = (0..count)
        .map(|i| boxes[(i as f64 * step) as usize])
        .collect();
    let equal: usize = equal_boxes(&sample)
        .iter()
        .map(|group| group.len() - 1)
        .sum();
    if equal > count / 2 {
        return Outlook::Equal;
    }
    let params = params(Quality::Balanced, 1);
    let bvh = build_bvh2(&sample, params, &mut Duration::default());
    // (node, depth)
    let mut todo = vec![(0_u32, 0_usize)];
    let mut deepest = 0;
    while let Some((index, depth)) = todo.pop() {
        deepest = deepest.max(depth);
        let node = &bvh.nodes[index as usize];
        if !node.is_leaf() {
            todo.extend([
                (node.first_index, depth + 1),
                (node.first_index + 1, depth + 1),
            ]);
        }
    }
    if deepest > MAX_DEPTH + equal {
        Outlook::Chain
    } else if equal > 0 {
        Outlook::Equal
    } else {
        Outlook::Good
    }
}

/// So many boxes, at least and at most, show what the others are like. The more there are, the longer a chain takes that
/// the sample does not show, and the less the sample itself.
const SAMPLE: [usize; 2] = [512, 4096];

/// Groups of boxes that are equal, of at least two each.
fn equal_boxes(boxes: &[Aabb]) -> Vec<Vec<u32>> {
    let bits = |b: &Aabb| [b.min, b.max].map(|p| p.to_array().map(f32::to_bits));
    let hashes: Vec<u64> = (boxes.par_iter())
        .map(|b| {
            let [min, max] = bits(b).map(mix);
            min ^ max.rotate_left(23)
        })
        .collect();
    let mut suspects: Vec<([[u32; 3]; 2], u32)> = (alike(&hashes).into_par_iter())
        .map(|i| (bits(&boxes[i as usize]), i))
        .collect();
    suspects.par_sort_unstable();
    (suspects.chunk_by(|a, b| a.0 == b.0))
        .filter(|same| same.len() > 1)
        .map(|same| same.iter().map(|(_, i)| *i).collect())
        .collect()
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
    let params = params(Quality::Balanced, leaf);
    let bvh = match look(boxes) {
        Outlook::Chain => halved(boxes),
        _ => build_grouped(boxes, params),
    };
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
    fn a_tree_over_boxes_of_which_some_are_equal_holds_each_once() {
        let boxes: Vec<Aabb> = (0..5000_u32)
            .map(|i| {
                let at =
                    Vec3A::splat((i % 7 * (i % 3)) as f32 + if i > 4000 { i as f32 } else { 0.0 });
                Aabb::new(at, at + 1.0)
            })
            .collect();
        let topology = build(&boxes, 4);
        assert!(depth(&topology, topology.root) <= MAX_DEPTH);
        let mut order = topology.order.clone();
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..5000));
        let mut links = vec![topology.root];
        let mut held = 0;
        while let Some(link) = links.pop() {
            held += link.count;
            if link.count == 0 {
                links.extend(topology.children[link.first as usize]);
            }
        }
        assert_eq!(held, 5000);
    }

    #[test]
    fn a_sample_tells_chains_from_good_trees() {
        for count in [5_000_u32, 70_000, 300_000] {
            let nested: Vec<Aabb> = (0..count)
                .map(|i| {
                    let size = 2_f32.powi(i as i32 % 100 - 50) * (1.0 + (i / 100) as f32 * 1e-6);
                    Aabb::new(Vec3A::splat(-size), Vec3A::splat(size))
                })
                .collect();
            let row: Vec<Aabb> = (0..count)
                .map(|i| Aabb::new(Vec3A::splat(i as f32), Vec3A::splat(i as f32 + 1.0)))
                .collect();
            assert!(look(&nested) == Outlook::Chain, "{count}");
            assert!(look(&row) == Outlook::Good, "{count}");
        }
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

//! The laws of sets hold hit for hit, with random trees for the sets.

use rand::seq::SliceRandom;
use rayon::prelude::*;
use solidtrace::geometry::CsgOp;

use super::normal;
use super::oracle::{Tree, random_ray, rng};

fn or(a: &Tree, b: &Tree) -> Tree {
    Tree::union([a.clone(), b.clone()])
}

fn and(a: &Tree, b: &Tree) -> Tree {
    Tree::intersection([a.clone(), b.clone()])
}

fn minus(a: &Tree, b: &Tree) -> Tree {
    Tree::difference([a.clone(), b.clone()])
}

/// Both sides are crossed at the same places, in the same sense, and with the same normals.
fn assert_same(name: &str, seed: u64, sides: impl Fn([&Tree; 3]) -> (Tree, Tree) + Sync) {
    let crossings: usize = (0..60_u64)
        .into_par_iter()
        .map(|i| {
            let mut rng = rng(1000 * seed + i);
            let [a, b, c] = std::array::from_fn(|_| Tree::random(&mut rng, 3));
            let (left, right) = sides([&a, &b, &c]);
            let (left_csg, right_csg) = (left.csg(), right.csg());
            let (left, right) = (left.build(), right.build());
            let mut count = 0;
            for _ in 0..200 {
                let ray = random_ray(&mut rng);
                let (l, r) = (left.crossings(&ray), right.crossings(&ray));
                assert_eq!(
                    l.len(),
                    r.len(),
                    "{name}, {ray:?}: {l:#?} {r:#?} of {a:#?} {b:#?} {c:#?}"
                );
                for (l, r) in l.iter().zip(&r) {
                    assert_eq!((l.t, l.enter), (r.t, r.enter), "{name}, {ray:?}");
                    let (m, n) = (normal(&left_csg, &ray, l), normal(&right_csg, &ray, r));
                    assert!(m.distance(n) < 1e-9, "{name}, {ray:?}: {m} {n}");
                    assert_eq!(n.dot(ray.direction) < 0.0, l.enter, "{name}, {ray:?}: {n}");
                }
                assert_eq!(left.intersect(&ray).map(|c| c.t), l.first().map(|c| c.t));
                count += l.len();
            }
            count
        })
        .sum();
    assert!(crossings > 500, "{name}: {crossings}");
}

#[test]
fn de_morgans_laws_hold_hit_for_hit() {
    assert_same("A - (B u C) = (A - B) n (A - C)", 1, |[a, b, c]| {
        (minus(a, &or(b, c)), and(&minus(a, b), &minus(a, c)))
    });
    assert_same("A - (B n C) = (A - B) u (A - C)", 2, |[a, b, c]| {
        (minus(a, &and(b, c)), or(&minus(a, b), &minus(a, c)))
    });
    assert_same("A - (B - C) = (A - B) u (A n C)", 3, |[a, b, c]| {
        (minus(a, &minus(b, c)), or(&minus(a, b), &and(a, c)))
    });
}

#[test]
fn absorption_holds_hit_for_hit() {
    assert_same("A u (A n B) = A", 4, |[a, b, _]| {
        (or(a, &and(a, b)), a.clone())
    });
    assert_same("A n (A u B) = A", 5, |[a, b, _]| {
        (and(a, &or(a, b)), a.clone())
    });
    assert_same("A - (B - A) = A", 6, |[a, b, _]| {
        (minus(a, &minus(b, a)), a.clone())
    });
}

#[test]
fn idempotence_holds_hit_for_hit() {
    assert_same("A u A = A", 7, |[a, _, _]| (or(a, a), a.clone()));
    assert_same("A n A = A", 8, |[a, _, _]| (and(a, a), a.clone()));
    assert_same("A of one operand", 9, |[a, _, _]| {
        (Tree::difference([Tree::union([a.clone()])]), a.clone())
    });
}

#[test]
fn distributivity_holds_hit_for_hit() {
    assert_same("A n (B u C) = (A n B) u (A n C)", 10, |[a, b, c]| {
        (and(a, &or(b, c)), or(&and(a, b), &and(a, c)))
    });
    assert_same("A u (B n C) = (A u B) n (A u C)", 11, |[a, b, c]| {
        (or(a, &and(b, c)), and(&or(a, b), &or(a, c)))
    });
    assert_same("(A u B) - C = (A - C) u (B - C)", 12, |[a, b, c]| {
        (minus(&or(a, b), c), or(&minus(a, c), &minus(b, c)))
    });
}

#[test]
fn a_difference_is_one_with_the_common_part() {
    assert_same("A - B = A - (A n B)", 13, |[a, b, _]| {
        (minus(a, b), minus(a, &and(a, b)))
    });
    assert_same("A - (A - B) = A n B", 14, |[a, b, _]| {
        (minus(a, &minus(a, b)), and(a, b))
    });
}

#[test]
fn parts_that_touch_make_a_whole_without_inner_faces() {
    assert_same("(A n B) u (A - B) = A", 15, |[a, b, _]| {
        (or(&and(a, b), &minus(a, b)), a.clone())
    });
    assert_same("A u (B - A) = A u B", 16, |[a, b, _]| {
        (or(a, &minus(b, a)), or(a, b))
    });
}

#[test]
fn operands_may_stand_in_any_order() {
    let shuffled = |tree: &Tree, seed: u64| {
        let mut rng = rng(seed);
        let Tree::Node(op, operands) = tree else {
            return tree.clone();
        };
        let mut operands = operands.clone();
        let first = usize::from(*op == CsgOp::Difference);
        operands[first..].shuffle(&mut rng);
        Tree::Node(*op, operands)
    };
    for (i, op) in [CsgOp::Union, CsgOp::Intersection, CsgOp::Difference]
        .into_iter()
        .enumerate()
    {
        assert_same("shuffled", 100 + i as u64, |[a, b, c]| {
            let tree = Tree::Node(op, vec![a.clone(), b.clone(), c.clone(), or(b, c)]);
            let other = shuffled(&tree, i as u64);
            (tree, other)
        });
    }
}

//! Trees 10,000 operators deep: the same solids as their flattenings, built in linear time, on a small stack.

use std::thread;
use std::time::{Duration, Instant};

use glam::{DAffine3, DVec3};
use rand::RngExt;
use solidtrace::accel::{CsgCrossing, CsgTree};
use solidtrace::geometry::{Csg, CsgOp, Operand, Solid};
use solidtrace::math::{Ray, Transform};

use super::oracle::{rng, unit};

const LEVELS: usize = 10_000;

/// Ball `i` of many that overlap here and there.
fn ball(csg: &mut Csg, i: usize) {
    let mut rng = rng(i as u64);
    let center = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
    let place = Transform::new(DAffine3::from_translation(center)).unwrap();
    let radius = rng.random_range(0.02..0.06);
    csg.push(Operand::Solid(Solid::Sphere { radius }), &place, 0..1);
}

fn block(csg: &mut Csg) {
    let half = DVec3::splat(0.9);
    csg.push(
        Operand::Solid(Solid::Box { half }),
        &Transform::IDENTITY,
        0..1,
    );
}

/// `first`, then balls, one operator over all.
fn flat(op: CsgOp, levels: usize, first: impl Fn(&mut Csg)) -> Csg {
    let mut csg = Csg::default();
    first(&mut csg);
    (1..=levels).for_each(|i| ball(&mut csg, i));
    csg.combine(op, levels + 1);
    csg
}

/// ((first op ball) op ball) ..., the operator given for each level.
fn left_deep(levels: usize, first: impl Fn(&mut Csg), op: impl Fn(usize) -> CsgOp) -> Csg {
    let mut csg = Csg::default();
    first(&mut csg);
    for i in 1..=levels {
        ball(&mut csg, i);
        csg.combine(op(i), 2);
    }
    csg
}

/// first op (ball op (ball ...)).
fn right_deep(levels: usize, op: CsgOp) -> Csg {
    let mut csg = Csg::default();
    (0..=levels).for_each(|i| ball(&mut csg, i));
    (0..levels).for_each(|_| csg.combine(op, 2));
    csg
}

fn rays(count: usize) -> Vec<Ray> {
    let mut rng = rng(7);
    let mut ray = || {
        let origin = 3.0 * rng.random::<f64>() * unit(&mut rng);
        Ray::new(origin, 0.7 * unit(&mut rng) - origin)
    };
    (0..count).map(|_| ray()).collect()
}

fn build(csg: &Csg) -> CsgTree {
    CsgTree::build(csg, &[]).unwrap()
}

fn assert_same(nest: &CsgTree, flat: &CsgTree) {
    let mut count = 0;
    for ray in rays(2000) {
        let (a, b) = (nest.crossings(&ray), flat.crossings(&ray));
        assert_eq!(a, b, "{ray:?}");
        assert_eq!(nest.intersect(&ray), b.first().copied());
        assert_eq!(nest.contains(ray.origin), flat.contains(ray.origin));
        count += a.len();
    }
    assert!(count > 2000, "{count}");
}

#[test]
fn differences_ten_thousand_deep_are_one_difference() {
    let nest = build(&left_deep(LEVELS, block, |_| CsgOp::Difference));
    assert_eq!(
        (nest.report().operators, nest.report().flattened),
        (LEVELS, 1)
    );
    assert_same(&nest, &build(&flat(CsgOp::Difference, LEVELS, block)));
}

#[test]
fn unions_ten_thousand_deep_on_either_side_are_one_union() {
    let first = |csg: &mut Csg| ball(csg, 0);
    let flat = build(&flat(CsgOp::Union, LEVELS, first));
    for nest in [
        left_deep(LEVELS, first, |_| CsgOp::Union),
        right_deep(LEVELS, CsgOp::Union),
    ] {
        let nest = build(&nest);
        assert_eq!((nest.report().depth, nest.report().flattened), (LEVELS, 1));
        assert_same(&nest, &flat);
    }
}

/// A half-space that bounds nothing, so that the nest stays deep.
fn half_space(csg: &mut Csg, i: usize) {
    let mut rng = rng(i as u64);
    let n = unit(&mut rng);
    let turn = DAffine3::from_quat(glam::DQuat::from_rotation_arc(DVec3::Z, n));
    let place = DAffine3::from_translation(rng.random_range(0.3..1.2) * n) * turn;
    csg.push(
        Operand::Solid(Solid::Plane),
        &Transform::new(place).unwrap(),
        0..1,
    );
}

/// Unions with a ball and intersections with a half-space by turns.
fn alternating(levels: usize) -> Csg {
    let mut csg = Csg::default();
    ball(&mut csg, 0);
    for i in 1..=levels {
        if i % 2 == 0 {
            half_space(&mut csg, i);
            csg.combine(CsgOp::Intersection, 2);
        } else {
            ball(&mut csg, i);
            csg.combine(CsgOp::Union, 2);
        }
    }
    csg
}

#[test]
fn operators_that_alternate_ten_thousand_deep_are_met_as_by_evaluating_each_level() {
    let csg = alternating(LEVELS);
    let nest = build(&csg);
    assert_eq!(nest.report().flattened, LEVELS);
    let leaves: Vec<(Solid, Transform)> = (0..csg.len() as u32)
        .map(|i| match csg.operand(i) {
            (Operand::Solid(solid), place) => (solid, place),
            _ => unreachable!("all operands are solids"),
        })
        .collect();
    // The outermost level that decides.
    let truth = |inside: &[bool]| {
        let decisive = (1..inside.len()).rev().find(|&i| inside[i] == (i % 2 == 1));
        inside[decisive.unwrap_or(0)]
    };
    let mut count = 0;
    for ray in rays(600) {
        let mut ends = Vec::new();
        for (i, (solid, place)) in leaves.iter().enumerate() {
            for span in solid.spans(&place.inverse_ray(&ray)).iter() {
                ends.extend([(span.enter.t, i, true), (span.exit.t, i, false)]);
            }
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let behind = ends.partition_point(|end| end.0 <= 0.0);
        let ahead = ends.partition_point(|end| end.0 < f64::INFINITY);
        let mut inside = vec![false; leaves.len()];
        for &(_, i, enter) in &ends[..behind] {
            inside[i] = enter;
        }
        let mut state = truth(&inside);
        let mut expected = Vec::new();
        for &(t, i, enter) in &ends[behind..ahead] {
            inside[i] = enter;
            if truth(&inside) != state {
                state = !state;
                expected.push((t, i as u32, state));
            }
        }
        let found = nest.crossings(&ray);
        let same = |(a, b): (&CsgCrossing, &(f64, u32, bool))| {
            (a.t - b.0).abs() < 1e-9 && (a.operand, a.enter) == (b.1, b.2)
        };
        assert_eq!(
            found.len(),
            expected.len(),
            "{ray:?}: {found:#?} {expected:#?}"
        );
        assert!(
            found.iter().zip(&expected).all(same),
            "{ray:?}: {found:#?} {expected:#?}"
        );
        count += found.len();
    }
    assert!(count > 200, "{count}");
}

#[test]
fn deep_trees_are_built_met_and_dropped_on_a_stack_of_256_kib() {
    let work = || {
        let union = |_: usize| CsgOp::Union;
        for csg in [
            left_deep(LEVELS, block, |_| CsgOp::Difference),
            left_deep(LEVELS, block, union),
            right_deep(LEVELS, CsgOp::Union),
            right_deep(LEVELS, CsgOp::Difference),
            alternating(LEVELS),
        ] {
            let tree = build(&csg.clone());
            for ray in rays(50) {
                assert_eq!(tree.occluded(&ray), tree.intersect(&ray).is_some());
                tree.contains(ray.origin);
            }
        }
    };
    let small = thread::Builder::new().stack_size(256 << 10);
    small.spawn(work).unwrap().join().unwrap();
}

#[test]
fn building_takes_time_in_proportion_to_depth() {
    let time = |levels: usize| {
        let csgs = [
            left_deep(levels, block, |_| CsgOp::Difference),
            right_deep(levels, CsgOp::Difference),
        ];
        let once = || {
            let start = Instant::now();
            for csg in &csgs {
                drop(build(csg));
            }
            start.elapsed()
        };
        (0..3).map(|_| once()).min().unwrap()
    };
    let (small, large) = (time(2_000), time(64_000));
    // 32 times as many levels; the square would be a thousand times as long.
    assert!(
        large < 200 * small + Duration::from_millis(100),
        "{small:?} {large:?}"
    );
}

//! Whose surface a crossing is where several are at one place, and what a tangent may not hide.

use std::f64::consts::FRAC_PI_2;

use glam::DAffine3;
use solidtrace::geometry::Solid;

use super::oracle::Tree;
use super::{at, block, ray, sphere};

const HERE: DAffine3 = DAffine3::IDENTITY;

/// The slab of a large block between two planes across the x axis.
fn slab(from: f64, to: f64) -> Tree {
    block([from, -2.0, -2.0], [to, 2.0, 2.0], HERE)
}

#[test]
fn of_coincident_surfaces_one_that_is_not_subtracted_is_met_and_the_lowest_of_them() {
    // At x = 0 begins the hole 3 in 2, and 4 and 5 end; 0 begins there as well, but is nowhere with 1.
    let tree = Tree::union([
        Tree::intersection([slab(0.0, 1.0), sphere(0.1, at(0.5, 1.0, 1.0))]),
        Tree::difference([slab(-3.0, 3.0), slab(0.0, 1.0)]),
        slab(-1.0, 0.0),
        slab(-1.5, 0.0),
    ])
    .build();
    let out = tree
        .intersect(&ray([-2.0, 0.0, 0.0], [1.0, 0.0, 0.0]))
        .unwrap();
    assert_eq!(
        (out.t, out.operand, out.enter, out.negated),
        (2.0, 4, false, false)
    );
    let into = tree
        .intersect(&ray([0.5, 0.0, 0.0], [-1.0, 0.0, 0.0]))
        .unwrap();
    assert_eq!(
        (into.t, into.operand, into.enter, into.negated),
        (0.5, 4, true, false)
    );
    let wall = tree
        .intersect(&ray([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]))
        .unwrap();
    assert_eq!(
        (wall.t, wall.operand, wall.enter, wall.negated),
        (0.5, 3, true, true)
    );
}

#[test]
fn where_only_pairs_of_coincident_surfaces_matter_the_first_that_turns_the_same_way_is_met() {
    // At x = 0 ends 0, which is nowhere with 1, and the pairs 2, 3 and 4, 5 begin.
    let pair = || Tree::intersection([slab(0.0, 1.0), slab(0.0, 2.0)]);
    let ring = Solid::Torus {
        major: 1.0,
        minor: 0.3,
    };
    let around = Tree::leaf(ring, DAffine3::from_rotation_y(FRAC_PI_2));
    let nothing = Tree::intersection([slab(-1.0, 0.0), around]);
    let tree = Tree::union([nothing, pair(), pair()]).build();
    let into = tree
        .intersect(&ray([-2.0, 0.0, 0.0], [1.0, 0.0, 0.0]))
        .unwrap();
    assert_eq!((into.t, into.operand, into.enter), (2.0, 2, true));
}

/// How far from the centre of the unit ball the greatest number below 1 lets a chord go.
const HALF_CHORD: f64 = 1.5e-8;

#[test]
fn a_tangent_neither_hides_a_wall_behind_it_nor_takes_its_place() {
    let graze = 1.0_f64.next_down();
    let ball = sphere(1.0, HERE);
    let ray = ray([-3.0, graze, 0.0], [1.0, 0.0, 0.0]);
    let chord = Tree::union([ball.clone()]).build().crossings(&ray);
    assert!(
        chord.iter().all(|c| (c.t - 3.0).abs() < HALF_CHORD),
        "{chord:?}"
    );
    // Two thirds of the chord thick, and as far from its end.
    let thin = slab(2.4e-8, 3.4e-8);
    for tree in [
        Tree::union([ball.clone(), thin.clone()]),
        Tree::union([thin.clone()]),
    ] {
        let wall = tree.leaves().len() as u32 - 1;
        let found: Vec<_> = tree.build().crossings(&ray);
        let found: Vec<_> = found.iter().filter(|c| c.operand == wall).collect();
        let close = |i: usize, t: f64| (found[i].t - 3.0 - t).abs() < 1e-14;
        assert!(
            found.len() == 2 && close(0, 2.4e-8) && close(1, 3.4e-8),
            "{found:?}"
        );
    }
    // The ball is touched where the block ends.
    let block = Tree::union([ball, slab(-1.0, 0.0)]).build();
    let ends: Vec<_> = (block.crossings(&ray).iter())
        .map(|c| (c.t, c.operand, c.enter))
        .collect();
    assert_eq!(ends, [(2.0, 1, true), (3.0, 1, false)]);
}

#[test]
fn operands_that_cannot_matter_are_dropped() {
    // Of the subtracted balls two are outside of the block, and so is one of a union that is subtracted.
    let tree = Tree::difference([
        slab(0.0, 1.0),
        sphere(0.5, at(3.0, 0.0, 0.0)),
        sphere(0.5, at(1.2, 0.0, 0.0)),
        sphere(0.5, at(-0.7, 0.0, 0.0)),
        Tree::union([
            sphere(0.1, at(0.5, 0.0, 0.0)),
            sphere(0.1, at(2.0, 0.0, 0.0)),
        ]),
    ]);
    let report = tree.build().report();
    assert_eq!((report.operands, report.dropped), (6, 3));
    assert_eq!(
        (report.operators, report.flattened, report.depth),
        (2, 1, 2)
    );
    // A union loses the parts of it that its neighbour does not reach.
    let tree = Tree::intersection([
        Tree::union([slab(0.0, 1.0), slab(-3.0, -2.0)]),
        Tree::union([slab(0.5, 2.0), slab(7.0, 8.0)]),
    ]);
    let judged = tree.build();
    assert_eq!(judged.report().dropped, 2);
    assert_eq!((judged.bounds().min.x, judged.bounds().max.x), (0.5, 1.0));
}

//! Solids of half-spaces alone: closed ones, open ones, and those that hold nearly everything.

use glam::{DAffine3, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use solidtrace::geometry::Solid;
use solidtrace::math::{Bounds, Ray};

use super::oracle::{Leaf, Naive, Tree, rng, unit};
use super::{block, half_space, point, rotation, times};

fn random_half_space(rng: &mut Pcg64Mcg) -> Tree {
    Tree::leaf(
        Solid::Plane,
        DAffine3::from_mat3_translation(rotation(rng), point(rng, 1.0)),
    )
}

fn any_ray(rng: &mut Pcg64Mcg) -> Ray {
    let origin = rng.random_range(0.0..4.0) * unit(rng);
    Ray::new(origin, point(rng, 1.2) - origin)
}

#[test]
fn six_half_spaces_make_a_cube() {
    let normals = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let cube = Tree::intersection(normals.map(|n| half_space(n, 1.0)).collect::<Vec<_>>()).build();
    let truth = block([-1.0; 3], [1.0; 3], DAffine3::IDENTITY).build();
    let mut rng = rng(1);
    for _ in 0..20_000 {
        let ray = any_ray(&mut rng);
        let (a, b) = (times(&cube.crossings(&ray)), times(&truth.crossings(&ray)));
        let close = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close, "{ray:?}: {a:?} for {b:?}");
        let p = point(&mut rng, 1.7);
        assert_eq!(cube.contains(p), p.abs().max_element() < 1.0, "{p}");
    }
}

#[test]
fn four_half_spaces_make_a_tetrahedron() {
    let corners = [
        [1.0; 3],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    let normals = corners.map(|corner| -DVec3::from_array(corner).normalize());
    let distance = 1.0 / 3.0_f64.sqrt();
    let tree = Tree::intersection(normals.map(|n| half_space(n, distance))).build();
    let mut rng = rng(2);
    for _ in 0..20_000 {
        let ray = any_ray(&mut rng);
        // Between the latest of the fronts and the first of the backs.
        let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for n in normals {
            let t = (distance - ray.origin.dot(n)) / ray.direction.dot(n);
            if ray.direction.dot(n) < 0.0 {
                enter = enter.max(t);
            } else {
                exit = exit.min(t);
            }
        }
        if (exit - enter).abs() < 1e-9 || enter.abs() < 1e-9 || exit.abs() < 1e-9 {
            continue;
        }
        let ends = [enter, exit]
            .into_iter()
            .filter(|t| *t > 0.0 && enter < exit);
        let truth: Vec<f64> = ends.collect();
        let found = times(&tree.crossings(&ray));
        let close = found.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(
            found.len() == truth.len() && close,
            "{ray:?}: {found:?} for {truth:?}"
        );
    }
}

#[test]
fn a_ray_that_starts_in_a_wedge_may_never_leave_it() {
    let wedge = Tree::intersection([half_space(DVec3::X, 1.0), half_space(DVec3::Y, 1.0)]).build();
    assert!(!wedge.bounds().is_finite() && !wedge.bounds().is_empty());
    let mut rng = rng(3);
    for _ in 0..5000 {
        let origin = DVec3::splat(-1.0) + point(&mut rng, 1.0);
        let d = unit(&mut rng);
        let found = wedge.crossings(&Ray::new(origin, d));
        let truth = ((1.0 - origin) / d).truncate();
        let ahead = truth.to_array().into_iter().filter(|t| *t > 0.0);
        match ahead.reduce(f64::min) {
            None => assert_eq!(found, [], "{origin} {d}"),
            Some(t) => {
                assert_eq!(found.len(), 1, "{origin} {d}: {found:?}");
                assert!(
                    !found[0].enter && (found[0].t - t).abs() < 1e-12 * t,
                    "{found:?}"
                );
            }
        }
        let far = origin - 1e6 * (DVec3::ONE + d.abs());
        assert!(wedge.contains(origin) && wedge.contains(far.with_z(1e9)));
    }
}

#[test]
fn all_but_a_ball_is_met_where_the_ball_is() {
    // Both sides of a plane are all of space.
    let n = DVec3::new(0.6, 0.0, 0.8);
    let ball = super::sphere(1.0, DAffine3::IDENTITY);
    let space = Tree::union([half_space(n, 0.2), half_space(-n, -0.2)]);
    let outside = Tree::difference([space.clone(), ball.clone()]).build();
    let space = space.build();
    let ball = ball.build();
    let mut rng = rng(4);
    for _ in 0..10_000 {
        let ray = any_ray(&mut rng);
        assert_eq!(
            space.crossings(&ray),
            [],
            "{ray:?}: both sides of the plane are inside"
        );
        let (a, b) = (outside.crossings(&ray), ball.crossings(&ray));
        assert_eq!(times(&a), times(&b), "{ray:?}");
        assert!(
            a.iter()
                .zip(&b)
                .all(|(a, b)| a.enter != b.enter && a.negated),
            "{ray:?}"
        );
    }
}

#[test]
fn what_is_empty_is_found_empty_or_never_met() {
    let apart = |x: f64| block([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0], DAffine3::IDENTITY);
    let empty = Tree::intersection([apart(0.0), apart(2.0), half_space(DVec3::X, 5.0)]).build();
    assert_eq!(empty.bounds(), Bounds::EMPTY);
    assert_eq!(empty.report().dropped, 3);
    let inner = Tree::intersection([half_space(DVec3::X, 0.0), half_space(-DVec3::X, -1.0)]);
    let mut rng = rng(5);
    let inner = inner.build();
    for _ in 0..2000 {
        let ray = any_ray(&mut rng);
        assert!(!empty.occluded(&ray) && !inner.occluded(&ray));
        assert!(!empty.contains(ray.origin) && !inner.contains(ray.origin));
    }
}

#[test]
fn random_trees_of_half_spaces_are_crossed_as_a_naive_boolean_says() {
    let mut rng = rng(6);
    let mut crossings = 0;
    for i in 0..200 {
        let group = |rng: &mut Pcg64Mcg, combine: fn(Vec<Tree>) -> Tree| {
            let count = rng.random_range(1..5);
            combine((0..count).map(|_| random_half_space(rng)).collect())
        };
        let parts = vec![
            group(&mut rng, Tree::union),
            group(&mut rng, Tree::intersection),
            group(&mut rng, Tree::difference),
        ];
        let tree = [Tree::union, Tree::intersection, Tree::difference][i % 3](parts);
        let leaves: Vec<Leaf> = tree.leaves();
        let judged = tree.build();
        for _ in 0..100 {
            let ray = any_ray(&mut rng);
            let naive = Naive::of(&tree, &leaves, &ray);
            let found = judged.crossings(&ray);
            assert!(
                naive.agrees(&found),
                "{ray:?}: {found:#?} for {naive:#?} of {tree:#?}"
            );
            crossings += found.len();
        }
    }
    assert!(crossings > 8000, "{crossings}");
}

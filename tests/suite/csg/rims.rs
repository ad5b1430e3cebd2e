//! Rays aimed at apices, rims, edges and corners.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};
use rand::RngExt;
use solidtrace::geometry::Solid;
use solidtrace::math::Ray;

use super::oracle::{Naive, Tree, random_place, rng, unit};
use super::{alternate, at, block, point, ray, times};

/// Around the origin's z axis, from the radius 1 at z = 0 to `to` at z = 1.
fn cone(to: f64, place: DAffine3) -> Tree {
    Tree::leaf(
        Solid::Cone {
            from_radius: 1.0,
            to_radius: to,
            height: 1.0,
        },
        place,
    )
}

fn cylinder(place: DAffine3) -> Tree {
    Tree::leaf(
        Solid::Cylinder {
            radius: 1.0,
            height: 1.0,
        },
        place,
    )
}

/// Upside down, from z = 1 to z = 0.
fn flipped() -> DAffine3 {
    at(0.0, 0.0, 1.0) * DAffine3::from_rotation_x(std::f64::consts::PI)
}

#[test]
fn a_ray_along_the_axis_of_an_hourglass_meets_no_inner_face() {
    // Cones that touch in their apices, and in their bases.
    let lower = cone(0.0, at(0.0, 0.0, -1.0));
    let upper = cone(0.0, flipped());
    let glass = Tree::union([lower, upper]).build();
    for sign in [1.0, -1.0] {
        let found = times(&glass.crossings(&ray([0.0, 0.0, -3.0 * sign], [0.0, 0.0, sign])));
        assert_eq!(found, [2.0, 4.0]);
    }
    let mirror = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let spindle = Tree::union([cone(0.0, DAffine3::IDENTITY), cone(0.0, mirror)]).build();
    let mut rng = rng(1);
    for _ in 0..2000 {
        let inside = point(&mut rng, 0.3);
        let d = unit(&mut rng);
        let found = spindle.crossings(&Ray::new(inside - 5.0 * d, d));
        assert!(
            alternate(&found) && found.len() == 2,
            "{inside} {d}: {found:#?}"
        );
    }
}

#[test]
fn rays_through_an_apex_meet_the_base_behind_it() {
    let mut rng = rng(2);
    for _ in 0..3000 {
        let place = random_place(&mut rng);
        let tree = Tree::union([cone(0.0, place)]).build();
        // From above, into the cone: its half angle is 45 degrees.
        let base = DVec3::new(
            rng.random_range(-0.6..0.6),
            rng.random_range(-0.6..0.6),
            0.0,
        );
        let apex = DVec3::Z;
        let local = Ray::new(apex - 3.0 * (base - apex), base - apex);
        let ray = Ray::new(
            place.transform_point3(local.origin),
            place.transform_vector3(local.direction),
        );
        let found = tree.crossings(&ray);
        let t = times(&found);
        let close = t.len() == 2 && (t[0] - 3.0).abs() < 1e-7 && (t[1] - 4.0).abs() < 1e-12;
        assert!(close && alternate(&found), "{ray:?}: {found:?}");
    }
}

#[test]
fn a_cone_in_the_cylinder_of_its_rim_leaves_what_is_beside_it() {
    let mut rng = rng(3);
    for i in 0..60 {
        let place = if i == 0 {
            DAffine3::IDENTITY
        } else {
            random_place(&mut rng)
        };
        let (cone, cylinder) = (cone(0.0, place), cylinder(place));
        let nothing = Tree::difference([cone.clone(), cylinder.clone()]).build();
        let same = Tree::union([cone.clone(), cylinder.clone()]).build();
        let beside = Tree::difference([cylinder.clone(), cone.clone()]);
        let (judged, leaves) = (beside.build(), beside.leaves());
        let alone = cylinder.build();
        for _ in 0..400 {
            // At the rim, the apex, or anywhere.
            let angle: f64 = rng.random_range(0.0..TAU);
            let target = match rng.random_range(0..3) {
                0 => DVec3::new(angle.cos(), angle.sin(), 0.0),
                1 => DVec3::Z,
                _ => DVec3::new(0.0, 0.0, 0.5) + point(&mut rng, 0.8),
            };
            let origin = DVec3::new(0.0, 0.0, 0.5) + 4.0 * unit(&mut rng);
            let ray = Ray::new(
                place.transform_point3(origin),
                place.transform_vector3(target - origin),
            );
            assert_eq!(nothing.crossings(&ray), [], "{ray:?} {place}");
            let (a, b) = (times(&same.crossings(&ray)), times(&alone.crossings(&ray)));
            let close = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(close, "{ray:?} {place}: {a:?} for {b:?}");
            let found = judged.crossings(&ray);
            assert!(alternate(&found), "{ray:?} {place}: {found:#?}");
            let naive = Naive::of(&beside, &leaves, &ray);
            assert!(
                naive.agrees(&found),
                "{ray:?} {place}: {found:#?} {naive:#?}"
            );
        }
    }
}

#[test]
fn rays_at_rims_edges_and_corners_go_in_and_out_by_turns() {
    let mut rng = rng(4);
    for i in 0..200 {
        let place = random_place(&mut rng);
        let other = random_place(&mut rng);
        let cube = block([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0], place);
        let trees = [
            Tree::difference([cube.clone(), cone(0.0, place)]),
            Tree::difference([cube.clone(), cylinder(place), cone(0.5, other)]),
            Tree::union([cylinder(place), cone(0.5, place * at(0.0, 0.0, 1.0))]),
            Tree::union([cube, cone(0.3, place * flipped()), cone(0.0, other)]),
        ];
        let tree = trees[i % 4].build();
        for _ in 0..300 {
            let angle: f64 = rng.random_range(0.0..TAU);
            let target = match rng.random_range(0..4) {
                0 => DVec3::new(angle.cos(), angle.sin(), f64::from(rng.random_range(0..2))),
                1 => DVec3::new(0.0, 0.0, f64::from(rng.random_range(0..2))),
                2 => DVec3::new(1.0, rng.random_range(-1.0..1.0), 1.0),
                _ => DVec3::new(-1.0, 1.0, f64::from(rng.random_range(0..2))),
            };
            let origin = point(&mut rng, 1.0) + 9.0 * unit(&mut rng);
            let ray = Ray::new(origin, place.transform_point3(target) - origin);
            let found = tree.crossings(&ray);
            assert!(
                alternate(&found),
                "{ray:?}: {found:#?} of {:#?}",
                trees[i % 4]
            );
            assert_eq!(tree.intersect(&ray), found.first().copied());
        }
    }
}

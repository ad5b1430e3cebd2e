//! Lengths inside along a grid of rays integrate to the volumes of closed forms.

use std::f64::consts::{PI, SQRT_2};

use glam::{DAffine3, DMat3, DVec3};
use rand::RngExt;
use rayon::prelude::*;
use solidtrace::geometry::Solid;
use solidtrace::math::Ray;

use super::oracle::{Tree, rng};
use super::{alternate, at, block, half_space, sphere};

/// Rays along each side of the grid.
const GRID: u32 = 1024;

fn cylinder(radius: f64, height: f64, axis: DVec3) -> Tree {
    let turn = glam::DQuat::from_rotation_arc(DVec3::Z, axis);
    let place = DAffine3::from_mat3_translation(DMat3::from_quat(turn), -0.5 * height * axis);
    Tree::leaf(Solid::Cylinder { radius, height }, place)
}

/// The volume by rays along `direction`, each of which must stay within the solid's bounds.
fn volume(tree: &Tree, direction: DVec3) -> f64 {
    let tree = tree.build();
    let bounds = tree.bounds();
    let (center, radius) = (bounds.center(), 0.5 * bounds.size().length());
    let d = direction.normalize();
    let (x, y) = d.any_orthonormal_pair();
    let cell = 2.0 * radius / f64::from(GRID);
    let row = |i: u32| {
        let mut rng = rng(u64::from(i));
        let mut place = |i: u32| cell * (f64::from(i) + rng.random::<f64>()) - radius;
        let mut sum = 0.0;
        for j in 0..GRID {
            let (u, v) = (place(i), place(j));
            // Of length 2, so that a length is no parameter.
            let ray = Ray::new(center - 2.0 * radius * d + u * x + v * y, 2.0 * d);
            let crossings = tree.crossings(&ray);
            assert!(alternate(&crossings), "{ray:?}: {crossings:?}");
            for pair in crossings.chunks(2) {
                sum += 2.0 * (pair[1].t - pair[0].t);
                for end in pair {
                    let p = ray.at(end.t);
                    let outside = (bounds.min - p).max(p - bounds.max).max_element();
                    assert!(outside <= 1e-12, "{p} is outside of {bounds:?}");
                }
            }
        }
        sum
    };
    (0..GRID).into_par_iter().map(row).sum::<f64>() * cell * cell
}

fn assert_volume(tree: &Tree, truth: f64) {
    let volume = volume(tree, DVec3::new(1.0, 2.0, 3.0));
    let off = volume / truth - 1.0;
    println!("{off:e}");
    assert!(off.abs() < 1e-4, "{volume} for {truth}: {off:e}");
}

#[test]
fn two_cylinders_meet_in_steinmetz_volume() {
    let r: f64 = 0.7;
    let tree = Tree::intersection([cylinder(r, 3.0, DVec3::X), cylinder(r, 3.0, DVec3::Y)]);
    assert_volume(&tree, 16.0 * r.powi(3) / 3.0);
}

#[test]
fn three_cylinders_meet_in_the_tricylinder_volume() {
    let r: f64 = 0.7;
    let tree = Tree::intersection(DVec3::AXES.map(|axis| cylinder(r, 3.0, axis)));
    assert_volume(&tree, 8.0 * (2.0 - SQRT_2) * r.powi(3));
}

#[test]
fn a_torus_in_two_halves_has_the_volume_of_the_whole() {
    let (major, minor) = (1.3, 0.4);
    let torus = Tree::leaf(Solid::Torus { major, minor }, at(0.2, 0.0, 0.1));
    let lower = Tree::intersection([torus.clone(), half_space(DVec3::new(0.6, 0.0, 0.8), 0.1)]);
    let upper = Tree::difference([torus, half_space(DVec3::new(0.6, 0.0, 0.8), 0.1)]);
    let truth = 2.0 * PI * PI * major * minor * minor;
    assert_volume(&Tree::union([lower, upper]), truth);
}

#[test]
fn a_half_space_cuts_the_volume_of_a_cap_off_a_ball() {
    let (r, h) = (1.1, 0.4);
    let n = DVec3::new(2.0, -1.0, 2.0) / 3.0;
    let ball = sphere(r, DAffine3::IDENTITY);
    let truth = PI * h * h * (3.0 * r - h) / 3.0;
    let cap = Tree::difference([ball.clone(), half_space(n, r - h)]);
    assert_volume(&cap, truth);
    let cap = Tree::intersection([ball.clone(), half_space(-n, h - r)]);
    assert_volume(&cap, truth);
    let rest = Tree::intersection([ball, half_space(n, r - h)]);
    assert_volume(&rest, 4.0 / 3.0 * PI * r.powi(3) - truth);
}

#[test]
fn a_drilled_ball_leaves_the_volume_of_a_napkin_ring() {
    let h: f64 = 1.0;
    for r in [0.55, 1.0] {
        let hole = cylinder((r * r - 0.25 * h * h).sqrt(), 3.0, DVec3::Z);
        let ring = Tree::difference([sphere(r, DAffine3::IDENTITY), hole]);
        assert_volume(&ring, PI * h.powi(3) / 6.0);
    }
}

#[test]
fn a_ball_that_pokes_out_of_a_block_on_all_sides_adds_its_caps() {
    let (r, a): (f64, f64) = (1.2, 1.0);
    let cap = PI * (r - a).powi(2) * (2.0 * r + a) / 3.0;
    let cube = block([-a; 3], [a; 3], DAffine3::IDENTITY);
    let ball = sphere(r, DAffine3::IDENTITY);
    let both = Tree::union([cube.clone(), ball.clone()]);
    assert_volume(&both, 8.0 * a.powi(3) + 6.0 * cap);
    let rounded = Tree::intersection([cube.clone(), ball.clone()]);
    assert_volume(&rounded, 4.0 / 3.0 * PI * r.powi(3) - 6.0 * cap);
    let corners = Tree::difference([cube, ball]);
    let truth = 8.0 * a.powi(3) - (4.0 / 3.0 * PI * r.powi(3) - 6.0 * cap);
    assert_volume(&corners, truth);
}

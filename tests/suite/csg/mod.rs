//! CSG objects against closed forms, truth tables, a naive boolean, and Embree.
//!
//! The cases that break naive solvers: flush pockets, boxes that touch, A - A, A n A and A u A (`coincident`); holes by
//! the hundred thousand (`swiss_cheese`); a thin torus far away, tangents to a torus, a shell (`thin`); apices and rims
//! (`rims`); vertices and edges of
//! meshes (`meshes`); deep nests (`nests`); half-spaces alone (`unbounded`); sheared, mirrored and scaled operands far from the
//! origin (`far_away`).

mod coincident;
mod far_away;
mod lattice;
mod laws;
mod meshes;
mod nests;
mod open_meshes;
pub mod oracle;
mod random;
mod rims;
mod swiss_cheese;
mod thin;
mod ties;
mod unbounded;
mod volumes;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::CsgCrossing;
use solidtrace::geometry::{Csg, Operand, Solid};
use solidtrace::math::Ray;

use oracle::{Tree, unit};

const SOLIDS: [Solid; 9] = [
    Solid::Sphere { radius: 0.8 },
    Solid::Box {
        half: DVec3::new(0.5, 0.7, 0.4),
    },
    Solid::Cylinder {
        radius: 0.5,
        height: 1.3,
    },
    Solid::Cone {
        from_radius: 0.7,
        to_radius: 0.0,
        height: 1.2,
    },
    Solid::Cone {
        from_radius: 0.4,
        to_radius: 0.9,
        height: 0.8,
    },
    Solid::Torus {
        major: 0.9,
        minor: 0.3,
    },
    Solid::Torus {
        major: 0.9,
        minor: 0.01,
    },
    Solid::Torus {
        major: 0.6,
        minor: 0.55,
    },
    Solid::Plane,
];

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

fn sphere(radius: f64, place: DAffine3) -> Tree {
    Tree::leaf(Solid::Sphere { radius }, place)
}

/// The box from `min` to `max`, then placed.
fn block(min: [f64; 3], max: [f64; 3], place: DAffine3) -> Tree {
    let (min, max) = (DVec3::from_array(min), DVec3::from_array(max));
    let middle = DAffine3::from_translation(0.5 * (min + max));
    Tree::leaf(
        Solid::Box {
            half: 0.5 * (max - min),
        },
        place * middle,
    )
}

/// The half-space against `normal`, through `normal * distance`.
fn half_space(normal: DVec3, distance: f64) -> Tree {
    let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, normal));
    Tree::leaf(
        Solid::Plane,
        DAffine3::from_mat3_translation(turn, distance * normal),
    )
}

fn rotation(rng: &mut Pcg64Mcg) -> DMat3 {
    DMat3::from_quat(DQuat::from_axis_angle(
        unit(rng),
        rng.random_range(0.0..6.3),
    ))
}

fn point(rng: &mut Pcg64Mcg, radius: f64) -> DVec3 {
    radius * rng.random::<f64>().cbrt() * unit(rng)
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray::new(DVec3::from_array(origin), DVec3::from_array(direction))
}

fn times(crossings: &[CsgCrossing]) -> Vec<f64> {
    crossings.iter().map(|crossing| crossing.t).collect()
}

/// Whether a ray that starts outside of a bounded solid goes in and out by turns, in order, and ends outside.
fn alternate(crossings: &[CsgCrossing]) -> bool {
    let turns = (crossings.iter().enumerate()).all(|(i, c)| c.enter == (i % 2 == 0));
    turns && crossings.len().is_multiple_of(2) && crossings.is_sorted_by(|a, b| a.t <= b.t)
}

/// The unit normal of the whole solid where `ray` crosses it, outward.
fn normal(csg: &Csg, ray: &Ray, crossing: &CsgCrossing) -> DVec3 {
    let (operand, place) = csg.operand(crossing.operand);
    let Operand::Solid(solid) = operand else {
        unreachable!("all operands are solids");
    };
    let p = solid.project(place.inverse_ray(ray).at(crossing.t), crossing.face);
    let n = place.normal(solid.normal(p, crossing.face));
    if crossing.negated { -n } else { n }
}

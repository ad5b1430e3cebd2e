//! Random points around things and rays at them, from all sides.

use glam::{DVec3, Vec2};
use rand::{Rng, RngExt};

use crate::math::{Bounds, Ray};

use super::uniform_sphere;

/// A unit vector, uniform over the sphere.
pub fn random_direction(rng: &mut impl Rng) -> DVec3 {
    uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3()
}

/// A point of the sphere around a box, `scale` times as large.
pub fn point_around(bounds: &Bounds, scale: f64, rng: &mut impl Rng) -> DVec3 {
    let radius = 0.5 * bounds.size().length();
    bounds.center() + scale * radius * random_direction(rng)
}

/// From one point of the sphere around a box, a tenth larger, to another; `t` is 1 there.
pub fn random_chord(bounds: &Bounds, rng: &mut impl Rng) -> Ray {
    let [a, b] = [(); 2].map(|()| point_around(bounds, 1.1, rng));
    Ray::new(a, b - a)
}

//! What the solids are, said a second time and in 32 digits; and rays that are hard on them.

use std::array::from_fn;
use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::geometry::Solid;
use solidtrace::math::Ray;

use super::double::Double;

pub(super) type Point = [Double; 3];

pub(super) const SOLIDS: [Solid; 14] = [
    Solid::Sphere { radius: 1.5 },
    Solid::Sphere { radius: 3e-3 },
    Solid::Box {
        half: DVec3::new(0.5, 1.0, 2.0),
    },
    Solid::Cylinder {
        radius: 0.75,
        height: 1.5,
    },
    Solid::Cylinder {
        radius: 0.01,
        height: 10.0,
    },
    Solid::Cone {
        from_radius: 3.0,
        to_radius: 1.0,
        height: 14.0,
    },
    Solid::Cone {
        from_radius: 1.0,
        to_radius: 0.0,
        height: 2.0,
    },
    Solid::Cone {
        from_radius: 0.0,
        to_radius: 0.1,
        height: 2.0,
    },
    Solid::Cone {
        from_radius: 2.0,
        to_radius: 1.9,
        height: 0.01,
    },
    Solid::Torus {
        major: 5.0,
        minor: 0.5,
    },
    Solid::Torus {
        major: 1.0,
        minor: 0.01,
    },
    Solid::Torus {
        major: 1.0,
        minor: 0.6,
    },
    Solid::Torus {
        major: 1.0,
        minor: 0.999,
    },
    Solid::Plane,
];

pub(super) fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// The greatest distance of the solid's points from the origin of its frame; 1 for a plane.
pub(super) fn size(solid: &Solid) -> f64 {
    match *solid {
        Solid::Sphere { radius } => radius,
        Solid::Box { half } => half.length(),
        Solid::Cylinder { radius, height } => radius.hypot(height),
        Solid::Cone {
            from_radius,
            to_radius,
            height,
        } => from_radius.max(to_radius).hypot(height),
        Solid::Torus { major, minor } => major + minor,
        Solid::Plane => 1.0,
        Solid::Rectangle { .. } | Solid::Disk { .. } => unreachable!("not closed"),
    }
}

/// The bound that the documentation of [`Solid::spans`] states.
pub(super) fn bound(solid: &Solid, ray: &Ray) -> f64 {
    let size = if *solid == Solid::Plane {
        0.0
    } else {
        size(solid)
    };
    8.0 * f64::EPSILON * (ray.origin.length() + size)
}

pub(super) fn exact(p: DVec3) -> Point {
    from_fn(|i| Double::from(p[i]))
}

/// The ray's point, without the rounding of [`Ray::at`].
pub(super) fn at(ray: &Ray, t: f64) -> Point {
    from_fn(|i| Double::from(ray.origin[i]) + Double::from(t) * Double::from(ray.direction[i]))
}

fn length(x: Double, y: Double) -> Double {
    (x * x + y * y).sqrt()
}

/// Signed distances from the (unlimited) surface of every face, negative inside.
pub(super) fn faces(solid: &Solid, [x, y, z]: Point) -> Vec<Double> {
    let real = Double::from;
    let cone = |from: f64, to: f64, height: f64| {
        let (width, height) = (real(to) - real(from), real(height));
        let side = ((length(x, y) - real(from)) * height - z * width) / length(width, height);
        vec![side, -z, z - height]
    };
    match *solid {
        Solid::Sphere { radius } => vec![length(length(x, y), z) - real(radius)],
        Solid::Box { half } => (0..6)
            .map(|face| {
                let v = [x, y, z][face / 2];
                (if face % 2 == 0 { -v } else { v }) - real(half[face / 2])
            })
            .collect(),
        Solid::Cylinder { radius, height } => cone(radius, radius, height),
        Solid::Cone {
            from_radius,
            to_radius,
            height,
        } => cone(from_radius, to_radius, height),
        Solid::Torus { major, minor } => {
            vec![length(length(x, y) - real(major), z) - real(minor)]
        }
        Solid::Plane => vec![z],
        Solid::Rectangle { .. } | Solid::Disk { .. } => unreachable!("not closed"),
    }
}

/// Negative inside, positive outside, and near the surface the distance from it.
pub(super) fn outside(solid: &Solid, p: Point) -> f64 {
    let distances = faces(solid, p);
    distances.into_iter().reduce(Double::max).unwrap().high
}

pub(super) fn unit(rng: &mut Pcg64Mcg) -> DVec3 {
    loop {
        let v = DVec3::from_array(from_fn(|_| rng.random_range(-1.0..1.0)));
        if v.length_squared() > 0.01 && v.length_squared() < 1.0 {
            return v.normalize();
        }
    }
}

/// A point in a box a little larger than the solid's.
pub(super) fn nearby(rng: &mut Pcg64Mcg, solid: &Solid) -> DVec3 {
    let bounds = solid.bounds();
    if !bounds.is_finite() {
        return 3.0 * unit(rng);
    }
    let u = DVec3::from_array(from_fn(|_| rng.random_range(-0.6..0.6)));
    bounds.center() + u * bounds.size()
}

/// How many faces the solid has.
pub(super) fn face_count(solid: &Solid) -> u32 {
    faces(solid, exact(DVec3::ZERO)).len() as u32
}

/// A ray at or near the solid: from inside or far away, tangent, through special points, along the axes,
/// with zero components and directions of any length.
pub(super) fn nasty_ray(rng: &mut Pcg64Mcg, solid: &Solid) -> Ray {
    let near = nearby(rng, solid);
    let face = rng.random_range(0..face_count(solid));
    let surface = solid.project(near, face);
    let normal = solid.normal(surface, face);
    let mut target = match rng.random_range(0..6) {
        0 => DVec3::ZERO,
        1 => solid.bounds().max.min(DVec3::splat(9.0)),
        2 => near,
        _ => surface,
    };
    let mut direction = match rng.random_range(0..5) {
        // Tangent, up to a small angle.
        0 => normal.cross(unit(rng)),
        1 => normal.cross(unit(rng)) + 10_f64.powf(rng.random_range(-16.0..0.0)) * normal,
        // Along an axis, up to a small angle.
        2 => {
            DVec3::AXES[rng.random_range(0..3)]
                + 10_f64.powf(rng.random_range(-18.0..0.0)) * unit(rng)
        }
        // In the half-plane through the z axis: generators, apices, meridians.
        3 => {
            let turned =
                DQuat::from_axis_angle(normal.cross(DVec3::Z).normalize_or(DVec3::X), FRAC_PI_2);
            turned * normal
        }
        _ => unit(rng),
    };
    for i in 0..3 {
        if rng.random_range(0..6) == 0 {
            direction[i] = 0.0;
        }
        if rng.random_range(0..12) == 0 {
            target[i] = 0.0;
        }
    }
    let direction = direction.try_normalize().unwrap_or(DVec3::X);
    let far = match rng.random_range(0..3) {
        0 => 0.0,
        1 => rng.random_range(-2.0..2.0),
        _ => 10_f64.powf(rng.random_range(0.0..7.0)),
    };
    Ray::new(
        target - far * size(solid) * direction,
        10_f64.powf(rng.random_range(-12.0..10.0)) * direction,
    )
}

/// The number of distinct places where the line of `ray` meets a torus, by Sturm's theorem.
pub(super) fn torus_crossings(major: f64, minor: f64, ray: &Ray) -> usize {
    let real = Double::from;
    // The same line from close by, with a direction of about unit length, and lengths in units of `major`.
    let d = ray.direction * (-ray.direction.length().log2().round()).exp2();
    let line = Ray::new(ray.origin, d);
    let p = at(&line, -ray.origin.dot(d) / d.length_squared()).map(|x| x / real(major));
    let d = exact(d);
    let minor = real(minor) / real(major);
    let dot =
        |a: &[Double], b: &[Double]| (a.iter().zip(b)).fold(real(0.0), |sum, (&x, &y)| sum + x * y);
    let two = real(2.0);
    let form = [
        dot(&p, &p) + real(1.0) - minor * minor,
        two * dot(&p, &d),
        dot(&d, &d),
    ];
    let flat = [
        dot(&p[..2], &p[..2]),
        two * dot(&p[..2], &d[..2]),
        dot(&d[..2], &d[..2]),
    ];
    let mut quartic = vec![real(0.0); 5];
    for i in 0..3 {
        for j in 0..3 {
            quartic[i + j] = quartic[i + j] + form[i] * form[j];
        }
        quartic[i] = quartic[i] - real(4.0) * flat[i];
    }
    sturm(quartic)
}

/// The number of distinct real roots of a polynomial, coefficients from the constant up.
fn sturm(polynomial: Vec<Double>) -> usize {
    let derivative = |p: &[Double]| -> Vec<Double> {
        (1..p.len())
            .map(|i| p[i] * Double::from(i as f64))
            .collect()
    };
    let mut chain = vec![derivative(&polynomial), polynomial];
    chain.reverse();
    while chain[chain.len() - 1].len() > 1 {
        let divisor = &chain[chain.len() - 1];
        let mut rest = chain[chain.len() - 2].clone();
        while rest.len() >= divisor.len() {
            let factor = rest[rest.len() - 1] / divisor[divisor.len() - 1];
            let shift = rest.len() - divisor.len();
            for (i, &c) in divisor.iter().enumerate() {
                rest[i + shift] = rest[i + shift] - factor * c;
            }
            rest.pop();
        }
        let scale = rest.iter().fold(Double::from(0.0), |m, c| m.max(c.abs()));
        // What is left is rounding: the last polynomial divides the first, at multiple roots.
        if scale.high < 1e-26 {
            break;
        }
        let mut rest: Vec<Double> = rest.into_iter().map(|c| -c / scale).collect();
        while rest.last().is_some_and(|c| c.abs().high < 1e-26) {
            rest.pop();
        }
        chain.push(rest);
    }
    let variations = |sign: &dyn Fn(&Vec<Double>) -> bool| {
        chain
            .windows(2)
            .filter(|w| sign(&w[0]) != sign(&w[1]))
            .count()
    };
    let lead = |p: &Vec<Double>| p[p.len() - 1].high > 0.0;
    let at_minus_infinity = |p: &Vec<Double>| lead(p) == (p.len() % 2 == 1);
    variations(&at_minus_infinity) - variations(&lead)
}

#[test]
fn sturm_counts_distinct_real_roots() {
    let polynomial = |c: &[f64]| c.iter().map(|&c| Double::from(c)).collect::<Vec<_>>();
    assert_eq!(sturm(polynomial(&[24.0, -50.0, 35.0, -10.0, 1.0])), 4);
    assert_eq!(sturm(polynomial(&[1.0, 0.0, 2.0, 0.0, 1.0])), 0);
    assert_eq!(sturm(polynomial(&[1.0, 0.0, -2.0, 0.0, 1.0])), 2);
    assert_eq!(sturm(polynomial(&[-1.0, 0.0, 0.0, 0.0, 1.0])), 2);
}

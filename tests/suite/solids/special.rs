//! Rays whose answers are known exactly.

use glam::DVec3;
use rand::RngExt;
use solidtrace::geometry::Solid;
use solidtrace::math::Ray;

use super::oracle::{at, bound, faces, outside, rng};
use super::{crossings, ray};

/// `(t, face)` of every crossing, for rays whose answer is exact.
fn hits(solid: &Solid, origin: [f64; 3], direction: [f64; 3]) -> Vec<(f64, u32)> {
    (crossings(solid, &ray(origin, direction)).iter())
        .map(|c| (c.t, c.face))
        .collect()
}

#[test]
fn a_half_space_reaches_to_infinity() {
    let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
    assert_eq!(
        hits(&Solid::Plane, [1.0, 2.0, 3.0], [0.0, 1.0, -2.0]),
        [(1.5, 0), (high, 0)]
    );
    assert_eq!(
        hits(&Solid::Plane, [1.0, 2.0, -3.0], [0.0, 1.0, 2.0]),
        [(low, 0), (1.5, 0)]
    );
    assert_eq!(
        hits(&Solid::Plane, [1.0, 2.0, 0.0], [0.0, 1.0, 0.0]),
        [(low, 0), (high, 0)]
    );
    assert_eq!(hits(&Solid::Plane, [1.0, 2.0, 1e-300], [0.0, 1.0, 0.0]), []);
    assert!(
        Solid::Plane
            .closest(&ray([0.0, 0.0, -1.0], [1.0, 0.0, 0.0]))
            .is_none()
    );
}

#[test]
fn a_ray_in_the_plane_of_a_face_counts_as_inside() {
    let cuboid = Solid::Box {
        half: DVec3::new(1.0, 2.0, 3.0),
    };
    assert_eq!(
        hits(&cuboid, [1.0, -5.0, 0.0], [0.0, 1.0, 0.0]),
        [(3.0, 2), (7.0, 3)]
    );
    assert_eq!(
        hits(&cuboid, [1.0, 2.0, 5.0], [0.0, -0.0, -1.0]),
        [(2.0, 5), (8.0, 4)]
    );
    assert_eq!(
        hits(&cuboid, [1.0_f64.next_up(), -5.0, 0.0], [0.0, 1.0, 0.0]),
        []
    );
    // Across an edge in a point.
    assert_eq!(
        hits(&cuboid, [0.0, 3.0, 0.0], [1.0, -1.0, 0.0]),
        [(1.0, 3), (1.0, 1)]
    );
    let cylinder = Solid::Cylinder {
        radius: 1.0,
        height: 2.0,
    };
    for z in [0.0, 2.0] {
        assert_eq!(
            hits(&cylinder, [-3.0, 0.0, z], [1.0, 0.0, 0.0]),
            [(2.0, 0), (4.0, 0)]
        );
    }
    assert_eq!(
        hits(&cylinder, [1.0, 0.0, 5.0], [0.0, 0.0, -1.0]),
        [(3.0, 2), (5.0, 1)]
    );
    assert_eq!(
        hits(&cylinder, [0.6, 0.0, -1.0], [0.0, 0.0, 2.0]),
        [(0.5, 1), (1.5, 2)]
    );
}

#[test]
fn a_cone_has_one_nappe_and_an_apex() {
    const CONE: Solid = Solid::Cone {
        from_radius: 1.0,
        to_radius: 0.0,
        height: 2.0,
    };
    // Through the apex into the solid, and past it where the other nappe would be.
    assert_eq!(
        hits(&CONE, [0.0, 0.0, 5.0], [0.0, 0.0, -1.0]),
        [(3.0, 0), (5.0, 1)]
    );
    assert_eq!(hits(&CONE, [-4.0, 0.0, 3.0], [1.0, 0.0, 0.0]), []);
    // Along a generator's direction inside: in by the cap, out by the side.
    let inside = hits(&CONE, [0.0, 0.0, 0.0], [-1.0, 0.0, 2.0]);
    assert_eq!(inside, [(0.0, 1), (0.5, 0)]);
    assert_eq!(hits(&CONE, [1.0, 0.0, 1.0], [-1.0, 0.0, 2.0]), []);
    // On a generator: anything even, on the surface.
    for c in crossings(&CONE, &ray([1.0, 0.0, 0.0], [-1.0, 0.0, 2.0])) {
        assert!((-1e-15..=1.0 + 1e-15).contains(&c.t));
    }
    // A hair's breadth from the apex the hit is as exact as elsewhere.
    for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
        let ray = ray([-4.0, 0.0, 2.0 - gap], [1.0, 0.0, 0.0]);
        let z = 2.0 - ray.origin.z;
        let found = crossings(&CONE, &ray);
        assert!((found[0].t - (4.0 - 0.5 * z)).abs() < 1e-15, "{found:?}");
        assert!((found[1].t - (4.0 + 0.5 * z)).abs() < 1e-15, "{found:?}");
    }
}

#[test]
fn rays_beside_a_generator_meet_the_cone_near_its_apex_as_exactly_as_elsewhere() {
    let cone = Solid::Cone {
        from_radius: 0.0,
        to_radius: 0.1,
        height: 2.0,
    };
    let mut rng = rng(15);
    for _ in 0..100_000 {
        let (sin, cos) = rng.random_range(0.0..7.0_f64).sin_cos();
        let generator = DVec3::new(0.1 * cos, 0.1 * sin, 2.0);
        let inward = DVec3::new(-cos, -sin, 0.0) * 10_f64.powf(rng.random_range(-16.0..-1.0));
        let ray = Ray::new(inward + rng.random_range(-2.0..2.0) * generator, generator);
        for c in crossings(&cone, &ray) {
            let p = at(&ray, c.t);
            let error = faces(&cone, p)[c.face as usize].abs().high;
            let worst = error.max(outside(&cone, p));
            assert!(
                worst <= bound(&cone, &ray),
                "{ray:?} {c:?} is {worst:e} off"
            );
        }
    }
}

#[test]
fn a_torus_is_touched_by_a_span_of_no_length_or_none() {
    for minor in [0.25, 0.01] {
        let torus = Solid::Torus { major: 1.0, minor };
        let ends = |origin, direction| crossings(&torus, &ray(origin, direction));
        // In the plane that rests on it, across both points of the circle of contact.
        for c in ends([-3.0, 0.0, minor], [1.0, 0.0, 0.0]) {
            assert!((c.t - 2.0).abs().min((c.t - 4.0).abs()) < 1e-7, "{c:?}");
        }
        assert!(ends([-3.0, 0.0, minor * (1.0 + 1e-14)], [1.0, 0.0, 0.0]).is_empty());
        // A little lower: four crossings at known places.
        let drop = minor * 2_f64.powi(-40);
        let z = minor - drop;
        let half = (drop * (minor + z)).sqrt();
        let found = ends([-3.0, 0.0, z], [1.0, 0.0, 0.0]);
        let truth = [2.0 - half, 2.0 + half, 4.0 - half, 4.0 + half];
        assert_eq!(found.len(), 4);
        for (c, t) in found.iter().zip(truth) {
            assert!((c.t - t).abs() < 1e-15 / half, "{found:?} {truth:?}");
        }
        // Upright through the hole along the inner equator.
        let inner = 1.0 - minor;
        assert!(ends([inner - 1e-14, 0.0, -5.0], [0.0, 0.0, 1.0]).is_empty());
        assert_eq!(ends([inner + 1e-14, 0.0, -5.0], [0.0, 0.0, 1.0]).len(), 2);
        // Across the hole, touching the inner equator from inside the tube: one span or two that meet.
        let found = ends([inner, -5.0, 0.0], [0.0, 1.0, 0.0]);
        let half = (4.0 * minor).sqrt();
        assert!((found[0].t - (5.0 - half)).abs() < 1e-14);
        assert!((found[found.len() - 1].t - (5.0 + half)).abs() < 1e-14);
    }
}

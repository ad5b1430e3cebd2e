//! Bounds, normals, surface coordinates and projection.

use glam::{DVec2, DVec3};
use rand::RngExt;
use solidtrace::geometry::Solid;

use super::oracle::{SOLIDS, exact, face_count, faces, nearby, outside, rng, size, unit};

#[test]
fn normals_are_the_slopes_of_the_distance() {
    let mut rng = rng(10);
    for solid in SOLIDS {
        for _ in 0..2_000 {
            let face = rng.random_range(0..face_count(&solid));
            let p = solid.project(nearby(&mut rng, &solid), face);
            let normal = solid.normal(p, face);
            assert!((normal.length() - 1.0).abs() < 4.0 * f64::EPSILON);
            // No slope at an apex.
            if p.truncate().length() < 1e-4 && matches!(solid, Solid::Cone { .. }) && face == 0 {
                continue;
            }
            let step = 1e-8 * size(&solid);
            let distance = |p: DVec3| faces(&solid, exact(p))[face as usize].high;
            let slope = DVec3::from_array(DVec3::AXES.map(|axis| {
                let (ahead, behind) = (p + step * axis, p - step * axis);
                (distance(ahead) - distance(behind)) / (ahead - behind).dot(axis)
            }));
            assert!(
                normal.distance(slope) < 1e-6,
                "{solid:?} {p} {face}: {normal} {slope}"
            );
        }
    }
}

#[test]
fn projection_lands_within_ulps_of_the_face_and_no_further_than_it_must() {
    let mut rng = rng(11);
    for solid in SOLIDS {
        let ulps = 4.0 * f64::EPSILON * size(&solid);
        for _ in 0..10_000 {
            let face = rng.random_range(0..face_count(&solid));
            let on = solid.project(nearby(&mut rng, &solid), face);
            let error = faces(&solid, exact(on))[face as usize].high.abs();
            assert!(
                error <= ulps && outside(&solid, exact(on)) <= ulps,
                "{solid:?} {on} {face}: {error:e}"
            );
            let off = 10_f64.powf(rng.random_range(-15.0..-3.0)) * size(&solid);
            let near = on + off * unit(&mut rng);
            let again = solid.project(near, face);
            assert!(
                again.distance(near) <= off + ulps,
                "{solid:?} {near} {face}: {again}"
            );
        }
    }
}

#[test]
fn surface_coordinates_stay_in_the_unit_square() {
    let mut rng = rng(12);
    for solid in SOLIDS.into_iter().filter(|&s| s != Solid::Plane) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for i in 0..20_000 {
            let mut p = nearby(&mut rng, &solid);
            p[i % 3] *= if i % 7 == 0 { -0.0 } else { 1.0 };
            let face = rng.random_range(0..face_count(&solid));
            let uv = solid.uv(solid.project(p, face), face);
            assert!(
                uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all(),
                "{solid:?} {p} {uv}"
            );
            (low, high) = (low.min(uv), high.max(uv));
        }
        // And they use all of it.
        assert!(
            low.max_element() < 0.1 && high.min_element() > 0.9,
            "{solid:?} {low} {high}"
        );
    }
}

#[test]
fn surface_coordinates_run_as_documented() {
    let uv = |solid: &Solid, p: [f64; 3], face| solid.uv(DVec3::from_array(p), face).to_array();
    let sphere = Solid::Sphere { radius: 2.0 };
    assert_eq!(uv(&sphere, [2.0, 0.0, 0.0], 0), [0.0, 0.5]);
    assert_eq!(uv(&sphere, [0.0, -2.0, 0.0], 0), [0.75, 0.5]);
    assert_eq!(uv(&sphere, [0.0, 0.0, 2.0], 0)[1], 1.0);
    let cuboid = Solid::Box {
        half: DVec3::new(1.0, 2.0, 3.0),
    };
    assert_eq!(uv(&cuboid, [1.0, 1.0, 0.0], 1), [0.75, 0.5]);
    assert_eq!(uv(&cuboid, [-1.0, 1.0, 0.0], 0), [0.25, 0.5]);
    let cone = Solid::Cone {
        from_radius: 1.0,
        to_radius: 0.0,
        height: 2.0,
    };
    assert_eq!(uv(&cone, [0.0, 0.5, 1.0], 0), [0.25, 0.5]);
    assert_eq!(uv(&cone, [-0.5, 0.0, 0.0], 1), [0.5, 0.5]);
    let torus = Solid::Torus {
        major: 2.0,
        minor: 1.0,
    };
    assert_eq!(uv(&torus, [0.0, 2.0, 1.0], 0), [0.25, 0.25]);
    assert_eq!(uv(&Solid::Plane, [7.0, -9.0, 0.0], 0), [7.0, -9.0]);
}

#[test]
fn bounds_hold_the_solid_and_touch_it_on_every_side() {
    let mut rng = rng(13);
    for solid in SOLIDS {
        let bounds = solid.bounds();
        let sides = if solid == Solid::Plane { 5..6 } else { 0..6 };
        for side in sides {
            let axis = DVec3::AXES[side % 3];
            let support = if side < 3 { bounds.min } else { bounds.max }[side % 3];
            let touch = (0..face_count(&solid)).any(|face| {
                // A torus is highest above its centre circle.
                let over = match solid {
                    Solid::Torus { major, .. } if axis == DVec3::Z => major * DVec3::X,
                    _ => DVec3::ZERO,
                };
                let middle = if bounds.is_finite() {
                    bounds.center()
                } else {
                    DVec3::ZERO
                };
                let out = if side < 3 { -1e3 } else { 1e3 };
                let far = middle + over + out * size(&solid) * axis;
                (solid.project(far, face).dot(axis) - support).abs()
                    <= 4.0 * f64::EPSILON * size(&solid)
            });
            assert!(touch, "{solid:?} side {side}");
        }
        for _ in 0..5_000 {
            let p = nearby(&mut rng, &solid);
            let held = p.cmpge(bounds.min).all() && p.cmple(bounds.max).all();
            assert!(held || !solid.contains(p), "{solid:?} {p}");
        }
    }
}

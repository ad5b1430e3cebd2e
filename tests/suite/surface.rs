//! Points, normals and sides of surfaces under transforms.

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::geometry::{Shape, Solid};
use solidtrace::material::{Metal, Roughness, Surface};
use solidtrace::math::Ray;

use crate::support::meshes::{moved, sphere_mesh};
use crate::support::{Build, diffuse, empty_scene};

/// Squashed, turned and moved; mirrored where `sign` is -1.
fn place(sign: f64) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 2.0, sign * 0.5),
        DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0),
        DVec3::new(3.0, -1.0, 2.0),
    )
}

/// Outward normal of the image of the unit sphere at `p`: the gradient of |place⁻¹ p|².
fn ellipsoid_normal(place: DAffine3, p: DVec3) -> DVec3 {
    let inverse = place.inverse();
    let local = inverse.transform_point3(p);
    (inverse.matrix3.transpose() * local).normalize()
}

fn rays(place: DAffine3) -> impl Iterator<Item = Ray> {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    std::iter::repeat_with(move || {
        let mut coordinate = || rng.random_range(-1.0..1.0);
        let (a, b) = (
            4.0 * DVec3::new(coordinate(), coordinate(), coordinate()),
            0.5 * DVec3::new(coordinate(), coordinate(), coordinate()),
        );
        let (from, to) = (place.transform_point3(a), place.transform_point3(b));
        Ray::new(from, to - from)
    })
    .take(2000)
}

#[test]
fn a_squashed_sphere_has_the_normals_of_its_ellipsoid() {
    for sign in [1.0, -1.0] {
        let mut scene = empty_scene();
        let grey = scene.material(diffuse(0.5), 0.0);
        scene.place(
            Shape::Solid(Solid::Sphere { radius: 1.0 }),
            grey,
            place(sign),
        );
        let world = scene.world();
        for ray in rays(place(sign)) {
            let hit = world.intersect(&ray).unwrap();
            let point = world.surface(&ray, &hit);
            assert!((point.p - ray.at(hit.t)).length() < 1e-12);
            let n = ellipsoid_normal(place(sign), point.p);
            assert!(
                (point.ng.as_dvec3() - n).length() < 1e-6,
                "{} {n}",
                point.ng
            );
            let entering = n.dot(ray.direction) < 0.0;
            assert_eq!(point.side, if entering { 1.0 } else { -1.0 });
        }
    }
}

#[test]
fn tangents_of_brushed_spheres_run_round_the_axis_under_transforms_too() {
    for sign in [1.0, -1.0] {
        let mut scene = empty_scene();
        let brushed = scene.material(
            Surface::Conductor {
                metal: Metal::named("iron").unwrap(),
                roughness: Roughness {
                    anisotropy: 0.5.into(),
                    ..0.2.into()
                },
            },
            0.0,
        );
        let sphere = Shape::Solid(Solid::Sphere { radius: 1.0 });
        scene.place(sphere, brushed, place(sign));
        let world = scene.world();
        for ray in rays(place(sign)) {
            let hit = world.intersect(&ray).unwrap();
            let point = world.surface(&ray, &hit);
            let local = place(sign).inverse().transform_point3(point.p);
            let around = place(sign).transform_vector3(DVec3::new(-local.y, local.x, 0.0));
            let found = point.tangent.as_dvec3().normalize();
            // By differences, which near the poles have fewer digits.
            let poles = local.x.hypot(local.y) < 0.01;
            assert!(poles || (found - around.normalize()).length() < 1e-5);
        }
    }
}

#[test]
fn meshes_have_outward_and_smooth_normals_under_transforms_too() {
    for sign in [1.0, -1.0] {
        let mut scene = empty_scene();
        let grey = scene.material(diffuse(0.5), 0.0);
        let mut mesh = moved(sphere_mesh(60, |_| 1.0), 1.0, Vec3::ZERO);
        mesh.normals = mesh.positions.clone();
        scene.mesh(mesh, grey);
        let shape = scene.instances.remove(0).shape;
        scene.place(shape, grey, place(sign));
        let world = scene.world();
        for ray in rays(place(sign)) {
            let hit = world.intersect(&ray).unwrap();
            let point = world.surface(&ray, &hit);
            let n = ellipsoid_normal(place(sign), point.p);
            // Faces of 3 degrees are up to a few degrees off where the squashing bends them most.
            assert!(point.ng.as_dvec3().dot(n) > 0.98, "{} {n}", point.ng);
            assert!(point.ns.as_dvec3().dot(n) > 0.9999, "{} {n}", point.ns);
        }
    }
}

#[test]
fn a_spawned_ray_does_not_meet_its_own_surface_again() {
    for (name, shape) in [
        ("sphere", Solid::Sphere { radius: 990.0 }),
        (
            "box",
            Solid::Box {
                half: DVec3::new(1e3, 1e-3, 5.0),
            },
        ),
        (
            "torus",
            Solid::Torus {
                major: 3.0,
                minor: 0.01,
            },
        ),
        (
            "cone",
            Solid::Cone {
                from_radius: 2.0,
                to_radius: 0.0,
                height: 3.0,
            },
        ),
    ] {
        let mut scene = empty_scene();
        let grey = scene.material(diffuse(0.5), 0.0);
        let far = DVec3::new(1e4, -2e4, 3e3);
        scene.solid(shape, grey, far);
        let world = scene.world();
        let mut rng = Pcg64Mcg::seed_from_u64(9);
        let size = shape.bounds().size();
        let mut hits = 0;
        for _ in 0..20_000 {
            let mut coordinate = || rng.random_range(-0.5..0.5);
            let inside = DVec3::new(coordinate(), coordinate(), coordinate()) * size;
            let away = DVec3::new(coordinate(), coordinate(), coordinate()).normalize();
            let origin = far + 3.0 * size.max_element() * away;
            let ray = Ray::new(origin, far + inside - origin);
            let Some(hit) = world.intersect(&ray) else {
                continue;
            };
            let point = world.surface(&ray, &hit);
            if point.side < 0.0 {
                continue;
            }
            hits += 1;
            // Straight out, and along the surface: a convex part has nothing there.
            for direction in [
                point.ng,
                (point.ng + 1e-3 * point.ng.any_orthonormal_vector()),
            ] {
                let again = world.intersect(&point.spawn(direction));
                let near = again.is_some_and(|h| h.t < 1e-6 * size.max_element());
                assert!(!near, "{name}: {again:?} from {}", point.p);
            }
        }
        assert!(hits > 500, "{name}: {hits}");
    }
}

#[test]
fn rectangles_and_disks_are_met_from_both_sides_and_have_no_inside() {
    let at = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.5, 0.5, -2.0),
        DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0),
        DVec3::new(3.0, -1.0, 2.0),
    );
    let half = DVec2::new(0.9, 0.6);
    for solid in [Solid::Rectangle { half }, Solid::Disk { radius: 0.8 }] {
        let mut scene = empty_scene();
        let grey = scene.material(diffuse(0.5), 0.0);
        scene.place(Shape::Solid(solid), grey, at);
        let world = scene.world();
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        let mut met = 0;
        for i in 0..2000 {
            let mut coordinate = || rng.random_range(-1.0..1.0);
            let target = DVec3::new(coordinate(), coordinate(), 0.0);
            let start = DVec3::new(coordinate(), coordinate(), coordinate());
            let inside = match solid {
                Solid::Rectangle { half } => target.truncate().abs().cmple(half).all(),
                _ => target.length() <= 0.8,
            };
            let [from, to] = [start, target].map(|p| at.transform_point3(p));
            let ray = Ray::new(from, to - from);
            assert_eq!(world.occluded(&ray), inside, "{solid:?} {i}");
            let hit = world.intersect(&ray);
            assert_eq!(hit.is_some(), inside, "{solid:?} {i}");
            let Some(hit) = hit else { continue };
            met += 1;
            let point = world.surface(&ray, &hit);
            assert!((hit.t - 1.0).abs() < 1e-9 && (point.p - to).length() < 1e-9);
            assert_eq!(point.side, if start.z > 0.0 { 1.0 } else { -1.0 });
            let up = at.transform_vector3(DVec3::Z).dot(point.ng.as_dvec3());
            assert!(up > 0.0);
            let uv = if let Solid::Rectangle { half } = solid {
                0.5 * (target.truncate() / half + 1.0)
            } else {
                let turn = target.y.atan2(target.x) / std::f64::consts::TAU;
                DVec2::new(turn.rem_euclid(1.0), target.length() / 0.8)
            };
            assert!(point.texture.uv.abs_diff_eq(uv.as_vec2(), 1e-5));
            // What leaves it on either side does not meet it again.
            for side in [-1.0, 1.0] {
                assert!(world.intersect(&point.spawn(side * point.ng)).is_none());
            }
        }
        assert!(met > 700, "{met}");
        let along = at.transform_vector3(DVec3::X);
        let edge = at.transform_point3(DVec3::NEG_X * 3.0);
        assert!(world.intersect(&Ray::new(edge, along)).is_none());
    }
}

//! The two-level tree against brute force.

mod ways;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::{Accel, AccelOptions, Hit, Kernel, Placed, Quality};
use solidtrace::geometry::{Mesh, MeshId, Shape, Solid};
use solidtrace::math::{Ray, Transform};
use solidtrace::sampling::uniform_sphere;

use crate::support::brute::{cases, compare, meet};
use crate::support::meshes::{box_mesh, bumpy_sphere, torus_mesh};

fn placed(shape: Shape, at: DAffine3) -> Placed {
    Placed {
        shape,
        world_from_object: Transform::new(at).unwrap(),
    }
}

fn random_direction(rng: &mut Pcg64Mcg) -> DVec3 {
    uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3()
}

/// A triangle hit, on corners in world space.
fn plain_triangle(ray: &Ray, corners: [DVec3; 3]) -> Option<f64> {
    let (t, inside) = meet(ray, corners);
    (inside >= 0.0 && t > ray.tmin && t < ray.tmax).then_some(t)
}

/// Meshes and solids in random places, sheared, mirrored, squashed.
fn crowd(rng: &mut Pcg64Mcg) -> (Vec<Mesh>, Vec<Placed>) {
    let meshes = vec![
        box_mesh(Vec3::NEG_ONE, Vec3::ONE),
        torus_mesh(20, 9, 1.0, 0.4),
        bumpy_sphere(9),
    ];
    let mut crowd: Vec<Placed> = (0..60)
        .map(|i| {
            let turn = DMat3::from_quat(DQuat::from_axis_angle(
                random_direction(rng),
                rng.random_range(0.0..6.0),
            ));
            let mut squash = DMat3::from_diagonal(DVec3::new(
                rng.random_range(0.1..1.5),
                rng.random_range(0.1..1.5),
                -rng.random_range(0.1..1.5),
            ));
            squash.y_axis.x = rng.random_range(-0.5..0.5);
            let at = 8.0 * rng.random::<f64>() * random_direction(rng);
            let shape = match i % 5 {
                0..3 => Shape::Mesh(MeshId(i % 5)),
                3 => Shape::Solid(Solid::Sphere { radius: 1.0 }),
                _ => Shape::Solid(Solid::Cylinder {
                    radius: 0.5,
                    height: 1.0,
                }),
            };
            placed(shape, DAffine3::from_mat3_translation(turn * squash, at))
        })
        .collect();
    crowd.push(placed(
        Shape::Solid(Solid::Plane),
        DAffine3::from_translation(DVec3::NEG_Z * 9.0),
    ));
    (meshes, crowd)
}

/// The same rays one by one and all at once, by each kernel and over trees of each quality.
fn in_every_way(
    meshes: &[Mesh],
    crowd: &[Placed],
    rays: &[Ray],
    mut check: impl FnMut(&str, &[Option<Hit>], &[bool]),
) {
    for kernel in Kernel::available() {
        for quality in [Quality::Fast, Quality::Balanced, Quality::Best] {
            let options = AccelOptions { quality, kernel };
            let accel = Accel::build_with(meshes, &[], crowd.to_vec(), options).unwrap();
            let name = format!("{} {quality:?}", kernel.name());
            let one_by_one: Vec<_> = rays.iter().map(|ray| accel.intersect(ray)).collect();
            let blocked: Vec<bool> = rays.iter().map(|ray| accel.occluded(ray)).collect();
            check(&name, &one_by_one, &blocked);
            let mut hits = vec![None; rays.len()];
            let mut blocked = vec![true; rays.len()];
            accel.intersect_batch(rays, &mut hits);
            accel.occluded_batch(rays, &mut blocked);
            check(&format!("{name} at once"), &hits, &blocked);
        }
    }
}

#[test]
fn closest_and_any_hit_equal_brute_force_over_everything() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let (meshes, crowd) = crowd(&mut rng);
    let accel = Accel::build(&meshes, &[], crowd.clone()).unwrap();
    let mut hits = 0;
    for _ in 0..20_000 {
        let mut ray = Ray::new(
            10.0 * random_direction(&mut rng),
            random_direction(&mut rng) * rng.random_range(0.1..10.0),
        );
        if rng.random() {
            ray.tmin = rng.random_range(0.0..2.0);
            ray.tmax = ray.tmin + rng.random_range(0.0..20.0);
        }
        let mut nearest = f64::INFINITY;
        for p in &crowd {
            let t = match p.shape {
                Shape::Mesh(id) => {
                    let mesh = &meshes[id.0 as usize];
                    (0..mesh.triangles.len() as u32)
                        .filter_map(|i| {
                            let world = |v: Vec3| p.world_from_object.point(v.as_dvec3());
                            plain_triangle(&ray, mesh.corners(i).map(world))
                        })
                        .fold(f64::INFINITY, f64::min)
                }
                Shape::Csg(_) => unreachable!("none in the crowd"),
                Shape::Solid(solid) => solid
                    .closest(&p.world_from_object.inverse_ray(&ray))
                    .map_or(f64::INFINITY, |(c, _)| c.t),
            };
            nearest = nearest.min(t);
        }
        let hit = accel.intersect(&ray);
        assert_eq!(hit.is_some(), nearest.is_finite(), "{ray:?}");
        assert_eq!(accel.occluded(&ray), nearest.is_finite(), "{ray:?}");
        if let Some(hit) = hit {
            hits += 1;
            assert!(
                (hit.t - nearest).abs() <= 1e-10 * nearest.max(1.0),
                "{} {nearest}",
                hit.t
            );
        }
    }
    assert!(hits > 5000, "{hits}");
}

#[test]
fn a_ray_that_ends_just_before_a_triangle_is_not_blocked_by_it() {
    let mut rng = Pcg64Mcg::seed_from_u64(8);
    let meshes = [bumpy_sphere(40)];
    let crowd = [placed(Shape::Mesh(MeshId(0)), DAffine3::IDENTITY)];
    let accel = Accel::build(&meshes, &[], crowd.to_vec()).unwrap();
    let (mut rays, mut expected) = (Vec::new(), Vec::new());
    while rays.len() < 6_000 {
        let ray = Ray::new(3.0 * random_direction(&mut rng), random_direction(&mut rng));
        let Some(Hit { t, .. }) = accel.intersect(&ray) else {
            continue;
        };
        for (part, blocked) in [(1.0 - 1e-9, false), (1.0, false), (1.0 + 1e-9, true)] {
            let tmax = part * t;
            rays.push(Ray { tmax, ..ray });
            expected.push(blocked);
        }
    }
    in_every_way(&meshes, &crowd, &rays, |name, hits, blocked| {
        assert_eq!(blocked, expected, "{name}");
        assert!(
            hits.iter()
                .zip(&expected)
                .all(|(hit, blocked)| hit.is_some() == *blocked)
        );
    });
}

#[test]
fn of_equal_distances_the_lowest_index_wins() {
    // The same square seven times over, as instances and as triangles.
    let square = |from: u32| [[from, from + 1, from + 2], [from, from + 2, from + 3]];
    let corners = [Vec3::ZERO, Vec3::X, Vec3::ONE - Vec3::Z, Vec3::Y];
    let mesh = Mesh {
        positions: [corners; 7].concat(),
        triangles: (0..7).flat_map(|i| square(4 * i)).collect(),
        ..Mesh::default()
    };
    let all = vec![placed(Shape::Mesh(MeshId(0)), DAffine3::IDENTITY); 5];
    let accel = Accel::build(&[mesh], &[], all).unwrap();
    // The last point lies on the diagonal that both triangles share.
    for (x, y, primitive) in [(0.7, 0.2, 0), (0.2, 0.7, 1), (0.5, 0.5, 0)] {
        let ray = Ray::new(DVec3::new(x, y, 1.0), DVec3::NEG_Z);
        let hit = accel.intersect(&ray).unwrap();
        assert_eq!((hit.t, hit.instance, hit.primitive), (1.0, 0, primitive));
    }
}

#[test]
fn degenerate_and_duplicate_triangles_are_counted_and_ids_stay() {
    let mut mesh = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    let whole = mesh.triangles.clone();
    // A point, a line, a turned copy of the first triangle and a flipped one of the second.
    mesh.triangles = vec![[0, 0, 0], [0, 1, 1]];
    mesh.triangles.extend(&whole);
    let ([a, b, c], [d, e, f]) = (whole[0], whole[1]);
    mesh.triangles.extend([[b, c, a], [e, d, f]]);
    let accel = Accel::build(
        &[mesh],
        &[],
        vec![placed(Shape::Mesh(MeshId(0)), DAffine3::IDENTITY)],
    )
    .unwrap();
    let report = accel.mesh_reports().next().unwrap();
    assert_eq!(
        (report.triangles, report.degenerate, report.duplicate),
        (12, 2, 2)
    );
    assert_eq!(accel.dropped(MeshId(0)), [0, 1, 14, 15]);
    let mut seen = [false; 16];
    for i in 0..4000 {
        let angle = f64::from(i) * 2.4;
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 4000.0;
        let r = (1.0 - z * z).sqrt();
        let direction = DVec3::new(r * angle.cos(), r * angle.sin(), z);
        seen[accel
            .intersect(&Ray::new(DVec3::ZERO, direction))
            .unwrap()
            .primitive as usize] = true;
    }
    assert!(seen[2..14].iter().all(|s| *s) && !seen[0] && !seen[1] && !seen[14] && !seen[15]);
}

#[test]
fn meshes_that_cannot_be_traced_are_errors() {
    let build = |mesh: Mesh| {
        Accel::build(&[mesh], &[], vec![])
            .unwrap_err()
            .message()
            .to_owned()
    };
    let flat = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    assert!(build(flat.clone()).contains("none of the mesh's 1 triangles"));
    assert!(build(Mesh::default()).contains("no triangles"));
    let huge = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X * 1e30, Vec3::Y],
        ..flat
    };
    assert!(build(huge).contains("beyond"));
}

#[test]
fn hits_before_tmin_and_beyond_tmax_do_not_count() {
    // Steep triangles, so that their boxes reach far beyond the hit at t = 1 on both sides.
    let steep = Mesh {
        positions: vec![
            Vec3::new(-9.0, -9.0, -9.0),
            Vec3::new(9.0, -9.0, 9.0),
            Vec3::new(0.0, 9.0, 0.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let sphere = Shape::Solid(Solid::Sphere { radius: 3.0 });
    for (mesh, shape) in [(vec![steep], Shape::Mesh(MeshId(0))), (vec![], sphere)] {
        let accel = Accel::build(&mesh, &[], vec![placed(shape, DAffine3::IDENTITY)]).unwrap();
        // The mesh is met at z = 0, the sphere at z = 3, both at t = 1.
        let z = if mesh.is_empty() { 5.0 } else { 2.0 };
        for (tmin, tmax, met) in [
            (0.0, 1.1, true),
            (0.9, 1.1, true),
            (1.1, 1.5, false),
            (0.0, 0.9, false),
        ] {
            let ray = Ray {
                tmin,
                tmax,
                ..Ray::new(DVec3::new(0.0, 0.0, z), DVec3::NEG_Z * 2.0)
            };
            assert_eq!(
                accel.intersect(&ray).is_some(),
                met,
                "{shape:?} {tmin}..{tmax}"
            );
            assert_eq!(accel.occluded(&ray), met, "{shape:?} {tmin}..{tmax}");
        }
    }
}

#[test]
fn hits_are_those_of_brute_force_over_all_triangles() {
    for (name, mesh) in cases() {
        let tally = compare(&mesh, 60_000, 3);
        println!("{name}: {tally:?}");
        assert_eq!(tally.wrong, 0, "{name}: {tally:?}");
        assert!(tally.hits > tally.rays / 10 && tally.ties < tally.rays / 10_000);
    }
}

//! The two-level tree against brute force.

use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::{Accel, AccelOptions, Hit, Kernel, Placed, Quality};
use solidtrace::geometry::{Mesh, MeshId, Shape, Solid};
use solidtrace::math::{Ray, Transform};
use solidtrace::sampling::uniform_sphere;
use solidtrace::scene::{Scene, SceneDescription};

use crate::support::brute::{cases, compare, meet};
use crate::support::meshes::{box_mesh, bumpy_sphere, moved, torus_mesh};

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

/// Rays of a camera at `eye` that looks at `to`: a square of `n` by `n`, a third as wide as it is far away.
fn camera_rays(eye: DVec3, to: DVec3, n: usize) -> Vec<Ray> {
    let along = to - eye;
    let across = along.any_orthogonal_vector().normalize() * along.length();
    let up = along.cross(across).normalize() * along.length();
    let offset = |i: usize| (i as f64 + 0.5) / n as f64 / 3.0 - 1.0 / 6.0;
    (0..n * n)
        .map(|i| Ray::new(eye, along + offset(i % n) * across + offset(i / n) * up))
        .collect()
}

#[test]
fn rays_from_one_point_meet_the_same_together_and_alone() {
    let mut rng = Pcg64Mcg::seed_from_u64(31);
    let (meshes, crowd) = crowd(&mut rng);
    let alone = |shape: Shape, at: DAffine3| vec![placed(shape, at)];
    let turned = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 1.0);
    let scenes = [
        crowd,
        alone(Shape::Mesh(MeshId(2)), DAffine3::IDENTITY),
        alone(Shape::Mesh(MeshId(1)), turned),
    ];
    let mut hit = 0;
    for placed in scenes {
        let corners = |rng: &mut Pcg64Mcg| {
            let Shape::Mesh(id) = placed[0].shape else {
                return DVec3::ZERO;
            };
            let mesh = &meshes[id.0 as usize];
            let p = mesh.positions[rng.random_range(0..mesh.positions.len())];
            placed[0].world_from_object.point(p.as_dvec3())
        };
        let kernels = Kernel::available().into_iter().map(|kernel| {
            let options = AccelOptions {
                kernel,
                ..AccelOptions::default()
            };
            Accel::build_with(&meshes, &[], placed.clone(), options).unwrap()
        });
        let kernels: Vec<Accel> = kernels.collect();
        for i in 0..210 {
            let accel = &kernels[i % kernels.len()];
            let eye = 10.0_f64.powf(rng.random_range(-1.0..3.0)) * random_direction(&mut rng);
            let to = if i % 2 == 0 {
                corners(&mut rng)
            } else {
                0.5 * random_direction(&mut rng)
            };
            let mut rays = camera_rays(eye, to, 16);
            if i % 3 == 0 {
                // At corners, straight.
                for ray in &mut rays {
                    *ray = Ray::new(eye, corners(&mut rng) - eye);
                }
            }
            for ray in &mut rays {
                ray.tmin = if i % 5 == 0 { 1.0 } else { 0.0 };
                if i % 7 == 0 {
                    ray.tmax = rng.random_range(0.5..1.5);
                }
            }
            let mut hits = vec![None; rays.len()];
            accel.intersect_batch(&rays, &mut hits);
            let mut blocked = vec![false; rays.len()];
            accel.occluded_batch(&rays, &mut blocked);
            for ((ray, found), blocked) in rays.iter().zip(&hits).zip(&blocked) {
                let expected = accel.intersect(ray);
                assert_eq!(*found, expected, "{ray:?}");
                assert_eq!(*blocked, expected.is_some(), "{ray:?}");
                hit += usize::from(expected.is_some());
            }
        }
    }
    assert!(hit > 30_000, "{hit}");
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

/// The hits, which every kernel, tree and way of asking must agree on to the bit.
fn same_in_every_way(meshes: &[Mesh], crowd: &[Placed], rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut first: Option<Vec<Option<Hit>>> = None;
    in_every_way(meshes, crowd, rays, |name, hits, blocked| {
        let expected = first.get_or_insert_with(|| hits.to_vec());
        for (i, (hit, blocked)) in hits.iter().zip(blocked).enumerate() {
            assert_eq!(hit, &expected[i], "{name}: {:?}", rays[i]);
            assert_eq!(hit.is_some(), *blocked, "{name}: {:?}", rays[i]);
        }
    });
    first.expect("there is a kernel")
}

#[test]
fn every_kernel_gives_the_same_hits_to_the_bit_one_by_one_and_in_batches() {
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let (meshes, crowd) = crowd(&mut rng);
    // With a tree of shapes; with few shapes; with one mesh.
    for (first, count) in [(0, 61), (0, 4), (2, 1)] {
        let crowd = &crowd[first..first + count];
        let around = |p: &Placed| p.world_from_object.point(DVec3::ZERO);
        let rays: Vec<Ray> = (0..4_000)
            .map(|i| {
                let to = around(&crowd[i % crowd.len()]) + random_direction(&mut rng);
                let origin = 10.0 * random_direction(&mut rng);
                let mut ray = Ray::new(origin, (to - origin) * rng.random_range(0.1..10.0));
                match i % 8 {
                    0 => ray.tmax = rng.random_range(0.0..1.0),
                    1 => ray.tmin = -rng.random_range(0.0..10.0),
                    2 => ray = Ray::new(origin + 1e20 * ray.direction, -ray.direction),
                    3 => ray.direction *= 1e-200,
                    4 => ray.direction = DVec3::AXES[i / 8 % 3],
                    _ => {}
                }
                ray
            })
            .collect();
        let hits = same_in_every_way(&meshes, crowd, &rays);
        let hits = hits.iter().flatten().count();
        assert!(hits > 600, "{hits}");
    }
}

/// The showcase: a mesh, solids, planes and CSG objects among one another.
#[test]
fn meshes_that_stand_where_they_were_made_are_met_in_batches_as_alone() {
    let ball = bumpy_sphere(12);
    // Around the origin, where rays serve the tree of all and the mesh alike; far off, with a centre of its own; and
    // too small to share.
    let meshes = [
        ball.clone(),
        moved(ball.clone(), 1.0, Vec3::new(7.0, 6.0, 5.0)),
        moved(ball.clone(), 0.05, Vec3::new(0.0, 2.0, 0.0)),
        moved(ball, 0.5, Vec3::new(-6.0, 0.1, 0.0)),
    ];
    let mut rng = Pcg64Mcg::seed_from_u64(11);
    let mut all: Vec<Placed> = (0..meshes.len() as u32)
        .map(|i| placed(Shape::Mesh(MeshId(i)), DAffine3::IDENTITY))
        .collect();
    for x in [-3.0, 3.0] {
        let half = DVec3::new(0.1, 9.0, 9.0);
        let wall = Shape::Solid(Solid::Box { half });
        all.push(placed(wall, DAffine3::from_translation(DVec3::X * x)));
    }
    let middles = meshes.each_ref().map(|mesh| mesh.bounds().center());
    let rays: Vec<Ray> = (0..4_000)
        .map(|i| {
            let reach = meshes[i % 4].bounds().size().max_element();
            let to = middles[i % 4] + 0.4 * reach * random_direction(&mut rng);
            let origin = to + rng.random_range(0.0..12.0) * random_direction(&mut rng);
            Ray::new(origin, to - origin)
        })
        .collect();
    let hits = same_in_every_way(&meshes, &all, &rays);
    for instance in 0..all.len() as u32 {
        let met = hits.iter().flatten().filter(|hit| hit.instance == instance);
        assert!(met.count() > 50, "{instance}");
    }
}

fn showcase() -> (Scene, Vec<Placed>) {
    let scene = SceneDescription::read(Path::new("scenes/showcase.ron")).unwrap();
    let scene = scene.load().unwrap();
    let placed = (scene.instances.iter())
        .map(|instance| placed(instance.shape, *instance.world_from_object.matrix()))
        .collect();
    (scene, placed)
}

#[test]
fn rays_that_leave_surfaces_meet_the_same_by_every_kernel_and_in_batches() {
    let (scene, crowd) = showcase();
    let accels = Kernel::available().into_iter().map(|kernel| {
        let options = AccelOptions {
            kernel,
            ..AccelOptions::default()
        };
        Accel::build_with(&scene.meshes, &scene.csgs, crowd.clone(), options).unwrap()
    });
    let accels: Vec<Accel> = accels.collect();
    let mut rng = Pcg64Mcg::seed_from_u64(9);
    let csgs: Vec<&Placed> = (crowd.iter())
        .filter(|p| matches!(p.shape, Shape::Csg(_)))
        .collect();
    let mut rays = Vec::new();
    while rays.len() < 200_000 {
        let at = csgs[rays.len() % csgs.len()]
            .world_from_object
            .point(DVec3::ZERO);
        let from = at + random_direction(&mut rng);
        let ray = Ray::new(from, at + 0.3 * random_direction(&mut rng) - from);
        let Some(hit) = accels[0].intersect(&ray) else {
            continue;
        };
        let p = ray.at(hit.t) + 1e-12 * random_direction(&mut rng);
        rays.push(Ray::new(p, random_direction(&mut rng)));
        let to = DVec3::new(-2.2, 3.5, 2.0) + 0.5 * random_direction(&mut rng);
        rays.push(Ray {
            tmax: 1.0,
            ..Ray::new(p, to - p)
        });
    }
    let hits: Vec<_> = rays.iter().map(|ray| accels[0].intersect(ray)).collect();
    for (accel, kernel) in accels.iter().zip(Kernel::available()) {
        let mut batch = vec![None; rays.len()];
        let mut blocked = vec![false; rays.len()];
        accel.intersect_batch(&rays, &mut batch);
        accel.occluded_batch(&rays, &mut blocked);
        for (i, ray) in rays.iter().enumerate() {
            let name = kernel.name();
            assert_eq!(accel.intersect(ray), hits[i], "{name}: {ray:?}");
            assert_eq!(accel.occluded(ray), hits[i].is_some(), "{name}: {ray:?}");
            assert_eq!(batch[i], hits[i], "{name}, batch: {ray:?}");
            assert_eq!(blocked[i], hits[i].is_some(), "{name}, batch: {ray:?}");
        }
    }
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

//! Rays meet the same by every kernel, one by one, in streams and in packets.

use std::path::Path;

use glam::{DAffine3, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::{Accel, AccelOptions, Hit, Kernel, Placed};
use solidtrace::geometry::{Csg, CsgId, CsgOp, Mesh, MeshId, Operand, Shape, Solid};
use solidtrace::math::{Ray, Transform};
use solidtrace::scene::{Scene, SceneDescription};

use super::{crowd, in_every_way, placed, random_direction};
use crate::support::meshes::{bumpy_sphere, moved};

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

#[test]
fn meshes_that_stand_where_they_were_made_are_met_in_batches_as_alone() {
    let ball = bumpy_sphere(12);
    // Around the origin, where rays serve the tree of all and the mesh alike; far off, with a centre of its own; and
    // too small to share.
    let meshes = [
        ball.clone(),
        moved(ball.clone(), 1.0, Vec3::new(17.0, 6.0, 5.0)),
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

/// The showcase: a mesh, solids, planes and CSG objects among one another.
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
fn rays_along_an_axis_meet_from_any_distance_what_they_meet_from_near() {
    let mesh = [bumpy_sphere(9)];
    let lone = vec![placed(Shape::Mesh(MeshId(0)), DAffine3::IDENTITY)];
    let mut rng = Pcg64Mcg::seed_from_u64(33);
    let mut near = Vec::new();
    for _ in 0..600 {
        let (x, y) = (rng.random_range(-1.2..1.2), rng.random_range(-1.2..1.2));
        near.push(Ray::new(DVec3::new(x, y, 16.0), DVec3::NEG_Z));
    }
    for kernel in Kernel::available() {
        let options = AccelOptions {
            kernel,
            ..AccelOptions::default()
        };
        let accel = Accel::build_with(&mesh, &[], lone.clone(), options).unwrap();
        let met = |ray: &Ray| accel.intersect(ray).is_some();
        assert!((150..500).contains(&near.iter().filter(|ray| met(ray)).count()));
        // Within what f32 holds, within what its products hold, and beyond either.
        for distance in [1e10, 3e18, 1e19, 1e25, 1e37, 1e39, 1e150, 1e300] {
            for ray in &near {
                let far = Ray::new(ray.origin.with_z(distance), ray.direction);
                let hit = accel.intersect(&far);
                assert_eq!(hit.is_some(), met(ray), "{kernel:?}, {far:?}");
                if let Some(hit) = hit {
                    assert!(
                        (hit.t - distance).abs() <= 2.0 + 1e-15 * distance,
                        "{hit:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_mesh_beside_an_empty_shape_keeps_its_number() {
    let mut nothing = Csg::default();
    for x in [-5.0, 5.0] {
        let place = Transform::new(DAffine3::from_translation(DVec3::X * x)).unwrap();
        nothing.push(Operand::Solid(Solid::Sphere { radius: 1.0 }), &place, 0..1);
    }
    nothing.combine(CsgOp::Intersection, 2);
    let crowd = [Shape::Csg(CsgId(0)), Shape::Mesh(MeshId(0))];
    let crowd = crowd
        .map(|shape| placed(shape, DAffine3::IDENTITY))
        .to_vec();
    let accel = Accel::build(&[bumpy_sphere(9)], &[nothing], crowd).unwrap();
    let ray = Ray::new(DVec3::Z * 9.0, DVec3::NEG_Z);
    let mut together = [None];
    accel.intersect_batch(&[ray], &mut together);
    for hit in [accel.intersect(&ray), together[0]] {
        assert_eq!(hit.map(|hit| hit.instance), Some(1));
    }
}

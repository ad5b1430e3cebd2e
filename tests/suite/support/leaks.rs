//! Rays from inside closed meshes: none may escape.

use glam::{DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use solidtrace::accel::{Accel, Placed};
use solidtrace::geometry::{Mesh, MeshId, Shape};
use solidtrace::math::{Ray, Transform};
use solidtrace::sampling::uniform_sphere;

use super::meshes::{box_mesh, bumpy_sphere, moved, slivers, torus_mesh};

/// A closed mesh with a point inside; the mesh is star-shaped around it or at least surrounds it.
pub struct Closed {
    pub mesh: Mesh,
    pub inside: DVec3,
}

/// Meshes of several kinds, sizes and places.
pub fn cases() -> Vec<(String, Closed)> {
    let tube = torus_mesh(180, 60, 1.0, 0.4);
    let forms: [(&str, Mesh, Vec3); 4] = [
        (
            "cube",
            box_mesh(Vec3::NEG_ONE, Vec3::ONE),
            Vec3::new(0.1, 0.2, -0.3),
        ),
        (
            "bumpy sphere",
            bumpy_sphere(100),
            Vec3::new(0.1, -0.1, 0.05),
        ),
        ("torus", tube, Vec3::new(1.0, 0.05, 0.1)),
        ("slivers", slivers(60), Vec3::new(0.01, 0.02, 1e-5)),
    ];
    let places = [
        ("", 1.0, Vec3::ZERO),
        (", 1e-6 as large", 1e-6, Vec3::ZERO),
        (", 1e6 as large", 1e6, Vec3::ZERO),
        // Exact moves: the corners stay on the lattice of f32 there, or close the mesh all the same.
        (", moved by 1e6", 64.0, Vec3::new(1e6, -1e6, 5e5)),
        (", moved by 1e7", 1024.0, Vec3::new(-1e7, 1e7, 5e6)),
    ];
    let mut all = Vec::new();
    for (name, mesh, inside) in &forms {
        for (place, scale, offset) in places {
            if *name == "slivers" && offset != Vec3::ZERO {
                continue;
            }
            let closed = Closed {
                mesh: moved(mesh.clone(), scale, offset),
                inside: (*inside * scale + offset).as_dvec3(),
            };
            all.push((format!("{name}{place}"), closed));
        }
    }
    all
}

/// Of `rays` rays from inside, some at random, most at vertices and at points of edges, how many meet
/// nothing. Directions have lengths from 1e-12 to 1e10. Half of the rays are asked one by one and half together; of
/// either half some share their origin and go to places that are close to one another.
pub fn escaped(case: &Closed, rays: u64, seed: u64) -> u64 {
    const CHUNK: u64 = 1 << 15;
    let placed = Placed {
        shape: Shape::Mesh(MeshId(0)),
        world_from_object: Transform::IDENTITY,
    };
    let accel = Accel::build(std::slice::from_ref(&case.mesh), &[], vec![placed]).unwrap();
    (0..rays.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut rng = Pcg64Mcg::seed_from_u64(seed << 32 | chunk);
            let count = CHUNK.min(rays - chunk * CHUNK) as usize;
            let mut rays = Vec::with_capacity(count);
            while rays.len() < count {
                let alike = rng.random_range(0..4) == 0;
                rays.extend(from_inside(case, alike, &mut rng));
            }
            rays.truncate(count);
            let (one_by_one, together) = rays.split_at(count / 2);
            let mut hits = vec![None; together.len()];
            accel.intersect_batch(together, &mut hits);
            let mut lost = hits.iter().filter(|hit| hit.is_none()).count();
            let some = &together[..together.len() / 8];
            let mut blocked = vec![false; some.len()];
            accel.occluded_batch(some, &mut blocked);
            lost += blocked.iter().filter(|blocked| !**blocked).count();
            for (i, ray) in one_by_one.iter().enumerate() {
                lost += usize::from(accel.intersect(ray).is_none());
                if i % 8 == 0 {
                    lost += usize::from(!accel.occluded(ray));
                }
            }
            lost as u64
        })
        .sum()
}

/// 64 rays from inside; if they are alike, from one point to triangles that stand next to one another in the file.
fn from_inside(case: &Closed, alike: bool, rng: &mut Pcg64Mcg) -> Vec<Ray> {
    let mesh = &case.mesh;
    let size = mesh.bounds().size().min_element();
    let direction =
        |rng: &mut Pcg64Mcg| uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3();
    let count = mesh.triangles.len() as u32;
    let (shared, start) = (direction(rng), rng.random_range(0..count));
    (0..64)
        .map(|_| {
            let (around, triangle) = if alike {
                (shared, (start + rng.random_range(0..12)) % count)
            } else {
                (
                    rng.random::<f64>() * direction(rng),
                    rng.random_range(0..count),
                )
            };
            let origin = case.inside + 0.01 * size * around;
            let [a, b, _] = mesh.corners(triangle).map(Vec3::as_dvec3);
            let to = match rng.random_range(0..10) {
                0..5 => a - origin,
                5..8 => a.lerp(b, rng.random()) - origin,
                _ if alike => b - origin,
                8 => direction(rng),
                _ => DVec3::AXES[rng.random_range(0..3)] * if rng.random() { 1.0 } else { -1.0 },
            };
            let length = 10.0_f64.powf(rng.random_range(-12.0..10.0));
            Ray::new(origin, to.normalize() * length)
        })
        .collect()
}

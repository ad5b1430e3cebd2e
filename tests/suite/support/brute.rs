//! Hits against brute force: every triangle, in f64, by a test of another kind.

use glam::{DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use solidtrace::accel::{Accel, Placed};
use solidtrace::geometry::{Mesh, MeshId, Shape};
use solidtrace::math::{Ray, Transform};
use solidtrace::sampling::uniform_sphere;

use super::meshes::{box_mesh, bumpy_sphere, moved, slivers, torus_mesh};

/// How rays compare.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub rays: u64,
    pub hits: u64,
    /// Answers that differ where brute force itself may be off: within [`EDGE`] of an edge, or two triangles
    /// within [`EDGE`] of one another.
    pub ties: u64,
    pub wrong: u64,
}

impl Tally {
    pub fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            ties: self.ties + other.ties,
            wrong: self.wrong + other.wrong,
        }
    }
}

/// Barycentric weights, and distances in units of the mesh's, that f64 cannot be trusted to tell apart.
pub const EDGE: f64 = 1e-9;

/// Small meshes, for which there is time for brute force.
pub fn cases() -> Vec<(&'static str, Mesh)> {
    let far = Vec3::new(1e5, -1e5, 5e4);
    vec![
        ("cube", box_mesh(Vec3::NEG_ONE, Vec3::ONE)),
        ("bumpy sphere", bumpy_sphere(12)),
        ("torus", torus_mesh(24, 10, 1.0, 0.4)),
        ("slivers", slivers(40)),
        (
            "torus moved by 1e5",
            moved(torus_mesh(24, 10, 1.0, 0.4), 64.0, far),
        ),
    ]
}

/// Where a ray meets a triangle's plane by Moeller and Trumbore's test, and the least of the barycentric weights there.
pub fn meet(ray: &Ray, [a, b, c]: [DVec3; 3]) -> (f64, f64) {
    let (e1, e2) = (b - a, c - a);
    let p = ray.direction.cross(e2);
    let s = ray.origin - a;
    let q = s.cross(e1);
    let det = e1.dot(p);
    let (u, v) = (s.dot(p) / det, ray.direction.dot(q) / det);
    (e2.dot(q) / det, u.min(v).min(1.0 - u - v))
}

/// Compares `rays` rays: chords, from a point to many, from outside and inside, one by one and together.
pub fn compare(mesh: &Mesh, rays: u64, seed: u64) -> Tally {
    const CHUNK: u64 = 1 << 14;
    let placed = Placed {
        shape: Shape::Mesh(MeshId(0)),
        world_from_object: Transform::IDENTITY,
    };
    let accel = Accel::build(std::slice::from_ref(mesh), &[], vec![placed]).unwrap();
    let bounds = mesh.bounds();
    let (center, radius) = (bounds.center(), bounds.size().length());
    let corners: Vec<[DVec3; 3]> = (0..mesh.triangles.len() as u32)
        .map(|i| mesh.corners(i).map(|p| p.as_dvec3() - center))
        .collect();
    let judge = |ray: &Ray, found: Option<(f64, u32)>| {
        let local = Ray {
            origin: ray.origin - center,
            ..*ray
        };
        let (mut best, mut doubtful) = (f64::INFINITY, false);
        let mut nearest = None;
        let slack = EDGE * radius / ray.direction.length();
        for (i, corners) in corners.iter().enumerate() {
            let (t, inside) = meet(&local, *corners);
            // In front, and not beyond what is certain already.
            if inside.is_finite() && t > -slack && t < best + slack && inside > -EDGE {
                doubtful |= inside < EDGE || t < slack || (t - best).abs() <= slack;
                if inside >= 0.0 && t > 0.0 && t < best {
                    (best, nearest) = (t, Some(i as u32));
                }
            }
        }
        let same = match (found, nearest) {
            (None, None) => true,
            (Some((t, id)), Some(nearest)) => id == nearest && (t - best).abs() <= slack,
            _ => false,
        };
        Tally {
            rays: 1,
            hits: u64::from(found.is_some()),
            ties: u64::from(!same && doubtful),
            wrong: u64::from(!same && !doubtful),
        }
    };
    (0..rays.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut rng = Pcg64Mcg::seed_from_u64(seed << 32 | chunk);
            let count = CHUNK.min(rays - chunk * CHUNK) as usize;
            let point = |rng: &mut Pcg64Mcg, far: f64| {
                let direction = uniform_sphere(Vec2::new(rng.random(), rng.random()));
                center + far * radius * direction.as_dvec3()
            };
            let mut rays: Vec<Ray> = Vec::with_capacity(count);
            while rays.len() < count {
                let (shared, near) = (rng.random(), rng.random_range(0.0..3.0));
                let eye = point(&mut rng, near);
                let middle = point(&mut rng, 0.3);
                rays.extend((0..64).map(|_| {
                    let from = if shared { eye } else { point(&mut rng, near) };
                    let to = if shared {
                        middle + 0.1 * (point(&mut rng, 1.0) - center)
                    } else {
                        point(&mut rng, 0.4)
                    };
                    Ray::new(from, to - from)
                }));
            }
            rays.truncate(count);
            let (one_by_one, together) = rays.split_at(count / 2);
            let mut hits = vec![None; together.len()];
            accel.intersect_batch(together, &mut hits);
            let singles = one_by_one.iter().map(|ray| (ray, accel.intersect(ray)));
            singles
                .chain(together.iter().zip(hits))
                .map(|(ray, hit)| judge(ray, hit.map(|hit| (hit.t, hit.primitive))))
                .fold(Tally::default(), Tally::plus)
        })
        .reduce(Tally::default, Tally::plus)
}

//! Closed meshes by formulas.

use std::f64::consts::{SQRT_2, TAU};

use glam::DVec3;
use solidtrace::geometry::Mesh;

/// The box of half size 1 around the origin, up to a height.
pub fn cuboid(top: f64) -> Mesh {
    let profile = [(0.0, -1.0), (SQRT_2, -1.0), (SQRT_2, top), (0.0, top)];
    lathe(&profile, 4, false)
}

/// A surface of revolution around z from its profile (radius, z), turned in `n` steps from half a step on; outward
/// where the profile ascends on the outside.
pub fn lathe(profile: &[(f64, f64)], n: u32, closed: bool) -> Mesh {
    let count = profile.len() as u32;
    let positions = (0..n).flat_map(|i| {
        let (sin, cos) = (TAU * (f64::from(i) + 0.5) / f64::from(n)).sin_cos();
        (profile.iter()).map(move |&(r, z)| DVec3::new(r * cos, r * sin, z).as_vec3())
    });
    let mut triangles = Vec::new();
    for i in 0..n {
        let next = (i + 1) % n;
        for j in 0..if closed { count } else { count - 1 } {
            let k = (j + 1) % count;
            let [a, b] = [i * count + j, next * count + j];
            let [c, d] = [next * count + k, i * count + k];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh {
        positions: positions.collect(),
        triangles,
        ..Mesh::default()
    }
}

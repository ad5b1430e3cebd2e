//! Trees of meshes that builders dread: seconds and depth beside those of an ordinary mesh of as many triangles.
//!
//! `cargo bench --bench builds [-- TRIANGLES]` (a million where none is given).

use std::time::Instant;

use glam::Vec3;
use solidtrace::accel::{Accel, AccelOptions, Placed, Quality};
use solidtrace::geometry::{Mesh, MeshId, Shape};
use solidtrace::math::Transform;

/// `count` triangles of which `corners` gives the corners.
fn mesh(count: u32, corners: impl Fn(u32) -> [Vec3; 3]) -> Mesh {
    Mesh {
        positions: (0..count).flat_map(corners).collect(),
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

/// A point of a wavy surface over the unit square.
fn surface(u: f32, v: f32) -> Vec3 {
    Vec3::new(u, v, 0.1 * (9.0 * u).sin() * (7.0 * v).cos())
}

fn cases(count: u32) -> Vec<(&'static str, Mesh)> {
    let rows = count.isqrt().max(1);
    let tile = move |i: u32| {
        let step = 1.0 / rows as f32;
        let (u, v) = ((i % rows) as f32 * step, (i / rows) as f32 * step);
        [surface(u, v), surface(u + step, v), surface(u, v + step)]
    };
    vec![
        ("a wavy surface", mesh(count, tile)),
        (
            "copies of one triangle",
            mesh(count, |_| [Vec3::ZERO, Vec3::X, Vec3::Y]),
        ),
        (
            "triangles in one box",
            mesh(count, |i| {
                let x = i as f32 / count as f32;
                [Vec3::ZERO, Vec3::ONE, Vec3::new(x, 1.0 - x, x * x)]
            }),
        ),
        (
            "slivers from one corner",
            mesh(count, |i| {
                let x = i as f32 / count as f32;
                [
                    Vec3::ZERO,
                    Vec3::new(1.0, x, 0.0),
                    Vec3::new(1.0, x + 1e-4, 1e-4),
                ]
            }),
        ),
        (
            "nested slivers",
            mesh(count, |i| {
                let size = 1.0 + i as f32 / count as f32;
                [
                    -size * Vec3::X,
                    size * Vec3::X,
                    size * Vec3::new(0.0, 1e-3, 1e-3),
                ]
            }),
        ),
        (
            "nested by powers of two",
            mesh(count, |i| {
                let size = 2.0_f32.powi(i as i32 % 100 - 50) * (1.0 + (i / 100) as f32 * 1e-6);
                [
                    -size * Vec3::ONE,
                    size * Vec3::X,
                    size * Vec3::new(0.0, 1.0, 1.0),
                ]
            }),
        ),
        (
            "a giant among the tiny",
            mesh(count, move |i| {
                if i == 0 {
                    [
                        Vec3::splat(-1e6),
                        Vec3::new(1e6, -1e6, 1e6),
                        Vec3::new(0.0, 1e6, 0.0),
                    ]
                } else {
                    tile(i)
                }
            }),
        ),
    ]
}

fn main() {
    let count = std::env::args()
        .find_map(|arg| arg.parse().ok())
        .unwrap_or(1_000_000);
    println!("{count} triangles; seconds to build, and how many times those of the first row");
    print!("{:>26}", "");
    for quality in ["fast", "balanced", "best"] {
        print!(" {quality:>16}");
    }
    println!();
    let mut usual = [0.0; 3];
    for (name, mesh) in cases(count) {
        print!("{name:>26}");
        for (i, quality) in [Quality::Fast, Quality::Balanced, Quality::Best]
            .into_iter()
            .enumerate()
        {
            let placed = Placed {
                shape: Shape::Mesh(MeshId(0)),
                world_from_object: Transform::IDENTITY,
            };
            let options = AccelOptions {
                quality,
                ..AccelOptions::default()
            };
            let start = Instant::now();
            let accel = Accel::build_with(std::slice::from_ref(&mesh), &[], vec![placed], options);
            let seconds = start.elapsed().as_secs_f64();
            accel.expect("a mesh with an area");
            if usual[i] == 0.0 {
                usual[i] = seconds;
            }
            print!(" {seconds:>8.2} {:>6.1}x", seconds / usual[i]);
        }
        println!();
    }
}

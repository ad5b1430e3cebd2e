//! Models made by formulas, by name: `sphere:2M`, `scan:70k`, `slivers:100k`, `instances:1000`.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::error::{Error, ErrorKind, Result, did_you_mean};
use crate::geometry::Mesh;
use crate::math::Transform;
use crate::sampling::random_direction;

use super::{Model, Part};

const NAMES: [&str; 4] = ["sphere", "scan", "slivers", "instances"];

/// Most triangles, or instances, that a name may ask for.
const MOST: f64 = 2e7;

/// Triangles of a mesh that is placed many times.
const INSTANCED: usize = 20_000;

/// The model that `name` asks for: a kind, and about how many triangles it shall have, or how many instances; `None`
/// where it is the name of something else.
///
/// # Errors
/// Where it has the form of such a name, but no such kind or number exists.
pub fn generated(name: &str) -> Option<Result<Model>> {
    let (kind, count) = name.split_once(':')?;
    let looks_so = kind.chars().all(char::is_alphabetic) && kind.len() > 1;
    looks_so.then(|| {
        let wrong = |message, help| Err(Error::new(ErrorKind::Usage, message).help(help));
        if !NAMES.contains(&kind) {
            let message = format!("there is no generated model `{kind}`");
            return wrong(message, did_you_mean(kind, NAMES));
        }
        let Some(count) = parse_count(count) else {
            let message = format!("`{count}` is not a count from 1 to {MOST:e}");
            return wrong(message, "write it as 70k, 2M or 1000".to_owned());
        };
        let (mesh, places) = match kind {
            "sphere" => (sphere(count), vec![Transform::IDENTITY]),
            "scan" => (scan(count), vec![Transform::IDENTITY]),
            "slivers" => (slivers(count), vec![Transform::IDENTITY]),
            _ => (scan(INSTANCED), scattered(count)),
        };
        let parts = places.into_iter().map(|place| Part {
            name: None,
            mesh: 0,
            materials: Vec::new(),
            model_from_mesh: place,
        });
        Ok(Model {
            parts: parts.collect(),
            meshes: vec![mesh],
            ..Model::default()
        })
    })
}

fn parse_count(text: &str) -> Option<usize> {
    let (number, unit) = match text.char_indices().last()? {
        (end, 'k') => (&text[..end], 1e3),
        (end, 'M') => (&text[..end], 1e6),
        _ => (text, 1.0),
    };
    let count = number.parse::<f64>().ok()? * unit;
    (1.0..=MOST).contains(&count).then_some(count as usize)
}

/// A sphere with waves.
fn sphere(triangles: usize) -> Mesh {
    octahedral(triangles, |d| {
        let waves = (9.0 * d.x).sin() * (11.0 * d.y).cos() + 0.3 * (31.0 * d.z + 17.0 * d.x).sin();
        d * (1.0 + 0.1 * waves)
    })
}

/// A body as scanners give it: lumpy, with ever finer detail, noise on it, and triangles of all shapes.
fn scan(triangles: usize) -> Mesh {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let step = (4.0 * TAU / triangles as f64).sqrt();
    octahedral(triangles, |d| {
        let mut jitter = || rng.random_range(-0.3..0.3) * step;
        let d = (d + DVec3::new(jitter(), jitter(), jitter())).normalize();
        let noise = 0.1 * jitter();
        let lumps = 0.3 * (3.0 * d.x + 1.0).sin() * (2.0 * d.y).cos() + 0.2 * (4.0 * d.z).sin();
        let folds = (1..6).map(|octave| {
            let f = f64::from(5 << octave);
            (f * d.x).sin() * (f * d.y + d.z).sin() * (f * d.z - 2.0 * d.x).cos() / f
        });
        d * (1.0 + lumps + folds.sum::<f64>() + noise) * DVec3::new(1.0, 1.4, 0.8)
    })
}

/// Sticks of three sides, a hundred times as long as they are thick, scattered in a ball.
fn slivers(triangles: usize) -> Mesh {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let mut mesh = Mesh::default();
    for _ in 0..triangles.div_ceil(8) {
        let middle = random_direction(&mut rng) * rng.random::<f64>().cbrt();
        let along = random_direction(&mut rng);
        let (x, y) = along.any_orthonormal_pair();
        let (half, thick) = (
            rng.random_range(0.03..0.15),
            rng.random_range(0.0005..0.0015),
        );
        let first = mesh.positions.len() as u32;
        for end in [-half, half] {
            for corner in 0..3 {
                let (sin, cos) = (TAU * f64::from(corner) / 3.0).sin_cos();
                let p = middle + end * along + thick * (cos * x + sin * y);
                mesh.positions.push(p.as_vec3());
            }
        }
        mesh.triangles.extend(
            [
                [0, 2, 1],
                [3, 4, 5],
                [0, 1, 4],
                [0, 4, 3],
                [1, 2, 5],
                [1, 5, 4],
                [2, 0, 3],
                [2, 3, 5],
            ]
            .map(|t| t.map(|i: u32| first + i)),
        );
    }
    mesh
}

/// Places in a cube that is as full for any count, turned in any way.
fn scattered(count: usize) -> Vec<Transform> {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let side = 3.0 * (count as f64).cbrt();
    let place = || {
        let mut along = || rng.random_range(0.0..side);
        let position = DVec3::new(along(), along(), along());
        let turn = DQuat::from_axis_angle(random_direction(&mut rng), rng.random_range(0.0..TAU));
        let matrix = DAffine3::from_rotation_translation(turn, position);
        Transform::new(matrix).expect("a rotation is invertible")
    };
    std::iter::repeat_with(place).take(count).collect()
}

/// A closed surface of about so many triangles: the faces of an octahedron cut into n² triangles each, a ring of
/// vertices after the other, and `place` asked where the vertex in a direction is.
fn octahedral(triangles: usize, mut place: impl FnMut(DVec3) -> DVec3) -> Mesh {
    let n = ((triangles as f64 / 8.0).sqrt().round() as u32).max(1);
    // Rings 0 and 2n are the poles; ring n, the equator, has 4n vertices.
    let width = |ring: u32| ring.min(2 * n - ring);
    let mut mesh = Mesh::default();
    let mut starts = Vec::new();
    for ring in 0..=2 * n {
        starts.push(mesh.positions.len() as u32);
        let y = f64::from(n) - f64::from(ring);
        for i in 0..(4 * width(ring)).max(1) {
            let (quarter, along) = (i / width(ring).max(1), f64::from(i % width(ring).max(1)));
            let rest = f64::from(width(ring)) - along;
            let (x, z) = match quarter {
                0 => (rest, -along),
                1 => (-along, -rest),
                2 => (-rest, along),
                _ => (along, rest),
            };
            let p = place(DVec3::new(x, y, z).normalize());
            mesh.positions.push(p.as_vec3());
        }
    }
    let at = |ring: u32, quarter: u32, along: u32| {
        let around = (4 * width(ring)).max(1);
        starts[ring as usize] + (quarter * width(ring) + along) % around
    };
    for ring in 0..n {
        // The band below `ring`, and its mirror image in the south with the other sense.
        let mirror = 2 * n - ring;
        for quarter in 0..4 {
            for i in 0..=ring {
                let corners =
                    |a: u32, b: u32| [at(a, quarter, i), at(b, quarter, i), at(b, quarter, i + 1)];
                mesh.triangles.push(corners(ring, ring + 1));
                let [a, b, c] = corners(mirror, mirror - 1);
                mesh.triangles.push([a, c, b]);
                if i < ring {
                    let between = |a: u32, b: u32| {
                        [
                            at(a, quarter, i),
                            at(b, quarter, i + 1),
                            at(a, quarter, i + 1),
                        ]
                    };
                    mesh.triangles.push(between(ring, ring + 1));
                    let [a, b, c] = between(mirror, mirror - 1);
                    mesh.triangles.push([a, c, b]);
                }
            }
        }
    }
    mesh
}

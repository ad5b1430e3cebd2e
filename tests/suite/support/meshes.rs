//! Closed meshes made by formulas.

use glam::{DVec3, Vec3};
use solidtrace::geometry::Mesh;

/// An axis-aligned box of twelve triangles, outward.
pub fn box_mesh(min: Vec3, max: Vec3) -> Mesh {
    let corner = |i: usize| {
        Vec3::new(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles,
        ..Mesh::default()
    }
}

/// A sphere of `rings` by `2 rings` quads around the origin, each vertex moved along its direction by
/// `shape(direction)`; closed, outward, with smooth normals only if it is a true sphere.
pub fn sphere_mesh(rings: u32, shape: impl Fn(Vec3) -> f32) -> Mesh {
    let columns = 2 * rings;
    let mut positions = vec![Vec3::Y * shape(Vec3::Y)];
    for ring in 1..rings {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for column in 0..columns {
            let phi = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            let d = DVec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                -theta.sin() * phi.sin(),
            )
            .as_vec3();
            positions.push(d * shape(d));
        }
    }
    positions.push(Vec3::NEG_Y * shape(Vec3::NEG_Y));
    let last = positions.len() as u32 - 1;
    let at = |ring: u32, column: u32| 1 + (ring - 1) * columns + column % columns;
    let mut triangles = Vec::new();
    for column in 0..columns {
        triangles.push([0, at(1, column), at(1, column + 1)]);
        triangles.push([last, at(rings - 1, column + 1), at(rings - 1, column)]);
        for ring in 1..rings - 1 {
            let (a, b) = (at(ring, column), at(ring, column + 1));
            let (c, d) = (at(ring + 1, column), at(ring + 1, column + 1));
            triangles.push([a, c, d]);
            triangles.push([a, d, b]);
        }
    }
    Mesh {
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A sphere with bumps: `rings` squared times four triangles, none of them like another.
pub fn bumpy_sphere(rings: u32) -> Mesh {
    sphere_mesh(rings, |d| {
        1.0 + 0.1 * (9.0 * d.x).sin() * (11.0 * d.y).cos() + 0.03 * (31.0 * d.z + 17.0 * d.x).sin()
    })
}

/// A torus of `around` by `across` quads.
pub fn torus_mesh(around: u32, across: u32, major: f64, minor: f64) -> Mesh {
    let point = |i: u32, j: u32| {
        let u = std::f64::consts::TAU * f64::from(i) / f64::from(around);
        let v = std::f64::consts::TAU * f64::from(j) / f64::from(across);
        let r = major + minor * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), minor * v.sin()).as_vec3()
    };
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    let quads = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    Mesh {
        positions: quads.clone().map(|(i, j)| point(i, j)).collect(),
        triangles: quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
        ..Mesh::default()
    }
}

/// A ball of needles: a sphere mesh squeezed to slivers of aspect 1 : 2000.
pub fn slivers(rings: u32) -> Mesh {
    let mut mesh = sphere_mesh(rings, |d| 1.0 + 0.2 * (7.0 * d.y).sin());
    for p in &mut mesh.positions {
        p.z *= 5e-4;
    }
    mesh
}

/// `mesh` scaled, then moved.
pub fn moved(mut mesh: Mesh, scale: f32, offset: Vec3) -> Mesh {
    for p in &mut mesh.positions {
        *p = *p * scale + offset;
    }
    mesh
}

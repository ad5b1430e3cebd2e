//! Wavefront OBJ and MTL text.

use std::f64::consts::TAU;
use std::fmt::Write;

use glam::{DVec2, DVec3};

use crate::surface_nets::Surface;

/// A named set of closed surfaces of one material.
pub(crate) struct Group<'a> {
    pub(crate) name: &'a str,
    pub(crate) surfaces: Vec<&'a Surface>,
}

/// A Phong-style MTL material: linear diffuse and specular colours and an exponent.
pub(crate) struct Material<'a> {
    pub(crate) name: &'a str,
    pub(crate) diffuse: [f64; 3],
    pub(crate) specular: f64,
    pub(crate) exponent: f64,
}

/// The OBJ text of the groups, each using the material of its own name.
pub(crate) fn obj(library: &str, groups: &[Group]) -> String {
    let mut text = format!(
        "# A figurine of a girl, sculpted by examples/sculpt_girl. MIT OR Apache-2.0.\nmtllib {library}\n"
    );
    let (mut vertices, mut coordinates) = (0, 0);
    for group in groups {
        writeln!(text, "g {0}\nusemtl {0}", group.name).expect("a string grows");
        for surface in &group.surfaces {
            append(&mut text, surface, &mut vertices, &mut coordinates);
        }
    }
    text
}

/// The MTL text of the materials.
pub(crate) fn mtl(materials: &[Material]) -> String {
    let mut text = String::from("# The girl's six materials. MIT OR Apache-2.0.\n");
    for Material {
        name,
        diffuse: [r, g, b],
        specular: s,
        exponent,
    } in materials
    {
        let lines = format!(
            "\nnewmtl {name}\nKa 0 0 0\nKd {r} {g} {b}\nKs {s} {s} {s}\nNs {exponent}\nd 1\nillum 2\n"
        );
        text.push_str(&lines);
    }
    text
}

fn append(text: &mut String, surface: &Surface, vertices: &mut usize, coordinates: &mut usize) {
    for &p in &surface.positions {
        line(text, "v", &p.to_array(), 5);
    }
    let mut uvs: Vec<DVec2> = cylindrical(&surface.positions);
    // Where a triangle spans the seam, its low corners get a second coordinate one turn further on; the positions
    // stay shared, so the surface stays closed.
    let mut past_seam = vec![None; uvs.len()];
    let mut faces = String::new();
    for triangle in &surface.triangles {
        let high = triangle.iter().map(|&i| uvs[i].x).fold(0.0, f64::max);
        faces.push('f');
        for &i in triangle {
            let uv = if high - uvs[i].x > 0.5 {
                let shifted = uvs[i] + DVec2::X;
                *past_seam[i].get_or_insert_with(|| {
                    uvs.push(shifted);
                    uvs.len() - 1
                })
            } else {
                i
            };
            let v = *vertices + i + 1;
            write!(faces, " {v}/{}/{v}", *coordinates + uv + 1).expect("a string grows");
        }
        faces.push('\n');
    }
    for uv in &uvs {
        line(text, "vt", &uv.to_array(), 4);
    }
    for &n in &surface.normals {
        line(text, "vn", &n.to_array(), 4);
    }
    text.push_str(&faces);
    *vertices += surface.positions.len();
    *coordinates += uvs.len();
}

/// Cylindrical coordinates in `[0, 1]` about the vertical axis of the surface's box; the seam is at the back.
fn cylindrical(positions: &[DVec3]) -> Vec<DVec2> {
    let lo = positions.iter().copied().reduce(DVec3::min);
    let hi = positions.iter().copied().reduce(DVec3::max);
    let (lo, hi) = (lo.unwrap_or_default(), hi.unwrap_or_default());
    let centre = 0.5 * (lo + hi);
    positions
        .iter()
        .map(|p| {
            let u = 0.5 + (p.x - centre.x).atan2(p.z - centre.z) / TAU;
            DVec2::new(u, (p.y - lo.y) / (hi.y - lo.y))
        })
        .collect()
}

fn line(text: &mut String, keyword: &str, numbers: &[f64], decimals: usize) {
    text.push_str(keyword);
    let unit = 10f64.powi(decimals as i32);
    for number in numbers {
        // Adding zero turns a rounded -0 into 0.
        let number = (number * unit).round() / unit + 0.0;
        write!(text, " {number:.decimals$}").expect("a string grows");
    }
    text.push('\n');
}

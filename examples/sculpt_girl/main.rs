//! Sculpts the girl of the gallery: `cargo run --release --example sculpt_girl [-- OUT_DIR]`.
//!
//! Every part of her is a signed distance field (`sdf`), meshed by surface nets (`surface_nets`) and written as
//! `girl.obj` and `girl.mtl` (`obj`). She stands on y = 0, looks along z and is 1.65 units tall.

mod dress;
mod hair;
mod head;
mod limbs;
mod obj;
mod part;
mod sdf;
mod surface_nets;

use std::path::PathBuf;
use std::time::Instant;

use glam::{DAffine3, DQuat, DVec3, EulerRot, dvec3};
use rayon::prelude::*;

use crate::part::{Group, Part};
use crate::surface_nets::Surface;

/// Colours are linear.
const GROUPS: [(Group, obj::Material); 6] = [
    (
        Group::Skin,
        material("skin", [0.80, 0.47, 0.32], 0.06, 30.0),
    ),
    (
        Group::Hair,
        material("hair", [0.50, 0.13, 0.025], 0.14, 60.0),
    ),
    (
        Group::Dress,
        material("dress", [0.03, 0.30, 0.34], 0.05, 30.0),
    ),
    (
        Group::Tights,
        material("tights", [0.86, 0.80, 0.70], 0.08, 40.0),
    ),
    (
        Group::Shoes,
        material("shoes", [0.085, 0.009, 0.015], 0.25, 120.0),
    ),
    (
        Group::Arms,
        material("arms", [0.80, 0.41, 0.28], 0.06, 30.0),
    ),
];

const fn material(
    name: &str,
    diffuse: [f64; 3],
    specular: f64,
    exponent: f64,
) -> obj::Material<'_> {
    obj::Material {
        name,
        diffuse,
        specular,
        exponent,
    }
}

fn girl() -> Vec<Part> {
    // She looks a little to her left, her head on one side.
    let tilt = DQuat::from_euler(EulerRot::YXZ, 0.24, 0.02, -0.1);
    let head = DAffine3::from_rotation_translation(tilt, dvec3(0.012, 1.365, 0.018));
    // Centred on the origin, and 1.65 tall.
    let stand = DAffine3::from_translation(dvec3(-0.025, 0.0, -0.014))
        * DAffine3::from_scale(DVec3::splat(1.024));
    let face = head::parts().into_iter().map(|part| part.placed(head));
    face.chain(hair::parts(head))
        .chain(dress::parts())
        .chain(limbs::parts())
        .map(|part| part.placed(stand))
        .collect()
}

fn main() -> std::io::Result<()> {
    let start = Instant::now();
    let out = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "assets".into()));
    let parts = girl();
    let surfaces: Vec<Surface> = parts.par_iter().map(Part::sculpt).collect();
    let groups: Vec<obj::Group> = GROUPS
        .iter()
        .map(|(group, material)| obj::Group {
            name: material.name,
            surfaces: parts
                .iter()
                .zip(&surfaces)
                .filter(|(part, _)| part.group == *group)
                .map(|(_, surface)| surface)
                .collect(),
        })
        .collect();
    let text = obj::obj("girl.mtl", &groups);
    std::fs::create_dir_all(&out)?;
    std::fs::write(out.join("girl.obj"), &text)?;
    let materials = GROUPS.map(|(_, material)| material);
    std::fs::write(out.join("girl.mtl"), obj::mtl(&materials))?;

    let mut total = 0;
    for group in &groups {
        let triangles: usize = group.surfaces.iter().map(|s| s.triangles.len()).sum();
        println!("{:>8}  {triangles:>6} triangles", group.name);
        total += triangles;
    }
    println!(
        "{}: {total} triangles, {:.1} MB, {:.1} s",
        out.join("girl.obj").display(),
        text.len() as f64 / 1e6,
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

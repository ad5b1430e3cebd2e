//! Compares hits with Embree's on meshes made by formulas, the project's figurine, and model files that
//! are named; an arbiter in f64 judges every difference. Exits with 1 if ours is ever wrong.
//!
//! `tests/with-embree.sh cargo run --release --features embree --example against_embree -- --rays 10000000 [MODEL...]`

#![allow(unreachable_pub)] // Two files are shared with the test suite.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use glam::Vec3;
use solidtrace::check::{Comparison, RayClass, Tally};
use solidtrace::{Result, io};

#[path = "../tests/suite/support/comparison.rs"]
mod comparison;
#[path = "../tests/suite/support/meshes.rs"]
mod meshes;

fn main() -> ExitCode {
    let mut rays: u64 = 1_000_000;
    let mut models = vec![PathBuf::from("assets/girl.obj")];
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        if arg == "--rays" {
            let Some(count) = args.next().and_then(|n| n.parse().ok()) else {
                eprintln!("usage: against_embree [--rays COUNT] [MODEL...]");
                return ExitCode::from(2);
            };
            rays = count;
        } else {
            models.push(arg.into());
        }
    }
    match compare(rays, &models) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Compares on every mesh; returns how often ours was wrong.
fn compare(rays: u64, models: &[PathBuf]) -> Result<u64> {
    let mut cases = comparison::comparison_cases();
    for path in models {
        for mesh in io::read_model(path)?.meshes {
            let name = Path::new(path)
                .file_name()
                .unwrap_or_default()
                .to_string_lossy();
            cases.push((
                format!("{name} moved by 1e6"),
                meshes::moved(mesh.clone(), 1.0, Vec3::splat(1e6)),
            ));
            cases.push((path.display().to_string(), mesh));
        }
    }
    let each = rays.div_ceil((cases.len() * RayClass::ALL.len()) as u64);
    println!(
        "{:>34} {:>7} {:>9} {:>9} {:>7} {:>7} {:>7} {:>9}",
        "mesh", "rays", "traced", "hits", "ours -", "embree -", "ties", "|dt|/bound"
    );
    let mut sum = Tally::default();
    for (name, mesh) in &cases {
        let comparison = Comparison::new(mesh, true)?;
        for class in RayClass::ALL {
            let tally = comparison.run(class, each, 1);
            row(name, &format!("{class:?}"), &tally);
            sum = sum.plus(tally);
        }
    }
    row("all", "", &sum);
    Ok(sum.ours_wrong)
}

fn row(name: &str, class: &str, t: &Tally) {
    println!(
        "{name:>34} {class:>7} {:>9} {:>9} {:>7} {:>7} {:>7} {:>9.3}",
        t.rays, t.hits, t.ours_wrong, t.embree_wrong, t.ties, t.worst_dt
    );
}

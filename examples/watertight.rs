//! Shoots rays from inside closed meshes and counts those that escape.
//!
//! `cargo run --release --example watertight -- --rays 100000000`

#![allow(unreachable_pub)] // Two files are shared with the test suite.

use std::process::ExitCode;
use std::time::Instant;

#[path = "../tests/suite/support/leaks.rs"]
mod leaks;
#[path = "../tests/suite/support/meshes.rs"]
mod meshes;

fn main() -> ExitCode {
    let rays: u64 = match std::env::args().skip(1).collect::<Vec<_>>().as_slice() {
        [] => 10_000_000,
        [flag, count] if flag == "--rays" && count.parse::<u64>().is_ok() => {
            count.parse().unwrap_or_default()
        }
        _ => {
            eprintln!("usage: watertight [--rays COUNT]");
            return ExitCode::from(2);
        }
    };
    let start = Instant::now();
    let cases = leaks::cases();
    let each = rays.div_ceil(cases.len() as u64);
    let mut lost = 0;
    for (name, mesh) in &cases {
        let escaped = leaks::escaped(mesh, each, 1);
        println!("{name:>32}  {each} rays, {escaped} escaped");
        lost += escaped;
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{} rays, {lost} escaped, {seconds:.1} s, {:.2} Mrays/s",
        each * cases.len() as u64,
        rays as f64 / seconds / 1e6
    );
    ExitCode::from(u8::from(lost > 0))
}

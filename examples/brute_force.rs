//! Compares hits with brute force in f64.
//!
//! `cargo run --release --example brute_force -- --rays 10000000`

#![allow(unreachable_pub)] // Two files are shared with the test suite.

use std::process::ExitCode;
use std::time::Instant;

#[path = "../tests/suite/support/brute.rs"]
mod brute;
#[path = "../tests/suite/support/meshes.rs"]
mod meshes;

fn main() -> ExitCode {
    let rays: u64 = match std::env::args().skip(1).collect::<Vec<_>>().as_slice() {
        [] => 1_000_000,
        [flag, count] if flag == "--rays" && count.parse::<u64>().is_ok() => {
            count.parse().unwrap_or_default()
        }
        _ => {
            eprintln!("usage: brute_force [--rays COUNT]");
            return ExitCode::from(2);
        }
    };
    let start = Instant::now();
    let cases = brute::cases();
    let each = rays.div_ceil(cases.len() as u64);
    let mut all = brute::Tally::default();
    for (name, mesh) in &cases {
        let tally = brute::compare(mesh, each, 1);
        println!("{name:>20}  {tally:?}");
        all = all.plus(tally);
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{} rays, {} hits, {} ties, {} wrong; {seconds:.1} s",
        all.rays, all.hits, all.ties, all.wrong
    );
    ExitCode::from(u8::from(all.wrong > 0))
}

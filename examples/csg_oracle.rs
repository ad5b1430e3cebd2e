//! Compares CSG objects with an oracle that shares no code with them: first and further hits with a naive boolean over
//! Embree's hits on tessellated operands, points with the truth table over implicit functions. Exits with 1 on a
//! difference, or where two rays of a hundred graze.
//!
//! `tests/with-embree.sh cargo run --release --features embree --example csg_oracle -- --trees 2000 --rays 10000
//! --points 10000000 --seed 1`

#![allow(unreachable_pub)] // The oracle is shared with the test suite.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use rayon::prelude::*;

#[allow(dead_code, unused_imports)]
#[path = "../tests/suite/csg/oracle/mod.rs"]
mod oracle;

use oracle::{Peer, PointTally, RayTally, Tree, compare_points, rng};

/// Compares random CSG trees with Embree and with truth tables.
#[derive(Parser)]
struct Args {
    /// Trees that rays are compared on.
    #[arg(long, default_value_t = 2000)]
    trees: u64,
    /// Rays for each of them.
    #[arg(long, default_value_t = 10_000)]
    rays: u64,
    /// Points in all, on 1,000 trees.
    #[arg(long, default_value_t = 10_000_000)]
    points: u64,
    /// Of the first tree; the others count on from there.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

const POINT_TREES: u64 = 1000;

fn main() -> ExitCode {
    let args = Args::parse();
    let start = Instant::now();
    let rays = compare_rays(&args);
    println!(
        "{} rays at {} trees: {} hit, {} crossings further on, {} graze ({:.3} %), {} wrong; {:.0} s",
        rays.rays,
        args.trees,
        rays.hits,
        rays.further,
        rays.grazing,
        100.0 * rays.grazing as f64 / rays.rays as f64,
        rays.wrong,
        start.elapsed().as_secs_f64()
    );
    if let Some(example) = &rays.example {
        println!("{example}");
    }
    let start = Instant::now();
    let points = points(&args);
    println!(
        "{} points in {POINT_TREES} trees: {} inside, {} too near to a surface, {} wrong; {:.0} s",
        points.points,
        points.inside,
        points.near,
        points.wrong,
        start.elapsed().as_secs_f64()
    );
    let few = rays.grazing * 50 <= rays.rays;
    ExitCode::from(u8::from(rays.wrong > 0 || points.wrong > 0 || !few))
}

fn compare_rays(args: &Args) -> RayTally {
    let peer = Peer::new();
    let of_tree = |i| {
        let mut rng = rng(args.seed + i);
        let tree = Tree::random(&mut rng, 6);
        // Boxes are meshes in every other tree.
        let judged = if i % 2 == 0 {
            tree.build()
        } else {
            tree.build_with_meshes()
        };
        peer.compare(&tree, &judged, args.rays, &mut rng)
    };
    (0..args.trees)
        .into_par_iter()
        .map(of_tree)
        .reduce(RayTally::default, RayTally::plus)
}

fn points(args: &Args) -> PointTally {
    let of_tree = |i| {
        let mut rng = rng(args.seed + args.trees + i);
        let tree = Tree::random(&mut rng, 6);
        let count = args.points.div_ceil(POINT_TREES);
        compare_points(&tree, &tree.build(), count, &mut rng)
    };
    (0..POINT_TREES)
        .into_par_iter()
        .map(of_tree)
        .reduce(PointTally::default, PointTally::plus)
}

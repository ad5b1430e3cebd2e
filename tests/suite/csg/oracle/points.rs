//! Points of space against the truth table.

use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::CsgTree;

use super::{Leaf, Tree, outside, unit};

/// What comparing points found.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointTally {
    pub points: u64,
    /// Of them, how many are inside by the truth table.
    pub inside: u64,
    /// Those so near the surface of an operand that they were not judged.
    pub near: u64,
    pub wrong: u64,
}

/// In the solids' own spaces, in which they are about 1 large.
const NEAR: f64 = 1e-9;

impl PointTally {
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            points: self.points + other.points,
            inside: self.inside + other.inside,
            near: self.near + other.near,
            wrong: self.wrong + other.wrong,
        }
    }
}

/// Compares `count` points, half of them anywhere around, half of them close to the surfaces of operands.
pub fn compare_points(tree: &Tree, judged: &CsgTree, count: u64, rng: &mut Pcg64Mcg) -> PointTally {
    let leaves = tree.leaves();
    let mut tally = PointTally {
        points: count,
        ..PointTally::default()
    };
    for i in 0..count {
        let p = if i % 2 == 0 {
            2.5 * rng.random::<f64>().cbrt() * unit(rng)
        } else {
            close_to(&leaves[rng.random_range(0..leaves.len())], rng)
        };
        let distances = (leaves.iter()).map(|l| outside(&l.solid, l.back.transform_point3(p)));
        let distances: Vec<f64> = distances.collect();
        if distances.iter().any(|d| d.abs() < NEAR) {
            tally.near += 1;
            continue;
        }
        let holding: Vec<Option<bool>> = distances.iter().map(|&d| Some(d < 0.0)).collect();
        let truth = tree.holds(&holding) == Some(true);
        tally.inside += u64::from(truth);
        tally.wrong += u64::from(judged.contains(p) != truth);
    }
    tally
}

/// A point 1e-8 to 0.1 off the surface.
fn close_to(leaf: &Leaf, rng: &mut Pcg64Mcg) -> DVec3 {
    let surface = leaf.solid.project(1.5 * unit(rng), rng.random_range(0..3));
    let off = 10_f64.powf(rng.random_range(-8.0..-1.0));
    leaf.place.transform_point3(surface + off * unit(rng))
}

//! Truths about CSG objects that share no code with the trees they judge: truth tables, implicit functions, a naive
//! boolean over all crossings, and Embree's hits on tessellated operands.

mod implicit;
mod lathe;
mod naive;
#[cfg(feature = "embree")]
mod peer;
mod points;
#[cfg(feature = "embree")]
mod tessellation;
mod tree;

#[cfg(feature = "embree")]
use naive::Stretches;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

pub use implicit::outside;
#[cfg(feature = "embree")]
pub use lathe::lathe;
pub use naive::{Expected, Naive};
#[cfg(feature = "embree")]
pub use peer::{Peer, RayTally};
pub use points::{PointTally, compare_points};
pub use tree::{Leaf, Tree, random_place, random_ray, unit};

/// The generator of a test, or of one tree of many.
pub fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

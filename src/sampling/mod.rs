//! Random numbers and what is made of them.

mod discrete;
mod mis;
mod sampler;
mod warp;

pub use discrete::Discrete;
pub use mis::power_heuristic;
pub use sampler::{Sampler, SamplerKind};
pub use warp::*;

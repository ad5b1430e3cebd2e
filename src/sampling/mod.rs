//! Random numbers and what is made of them.

mod around;
mod discrete;
mod mis;
mod sampler;
mod warp;

pub use around::{point_around, random_chord, random_direction};
pub use discrete::Discrete;
pub use mis::power_heuristic;
pub use sampler::{Sampler, SamplerKind};
pub use warp::*;

//! Random numbers and what is made of them.

mod around;
mod discrete;
mod mis;
mod sampler;
mod sobol;
mod spherical_rectangle;
mod spherical_triangle;
mod warp;

pub use around::{point_around, random_chord, random_direction};
pub use discrete::{Discrete, choose};
pub use mis::power_heuristic;
pub use sampler::{Sampler, SamplerKind};
pub use spherical_rectangle::SphericalRectangle;
pub use spherical_triangle::SphericalTriangle;
pub use warp::*;

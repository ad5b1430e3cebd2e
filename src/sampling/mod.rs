//! Random numbers and what is made of them.

mod warp;

pub use warp::*;

//! solidtrace renders triangle meshes and exact analytic solids with a path tracer.

pub mod accel;
pub mod bsdf;
pub mod camera;
#[cfg(feature = "embree")]
pub mod check;
pub mod cli;
pub mod color;
#[cfg(feature = "embree")]
pub mod embree;
pub mod error;
pub mod film;
pub mod geometry;
pub mod image;
pub mod integrator;
pub mod io;
pub mod light;
pub mod material;
pub mod math;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod texture;
pub mod world;

pub use error::{Error, ErrorKind, Result};

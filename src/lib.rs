//! solidtrace renders triangle meshes and exact analytic solids with a path tracer.
//!
//! Data takes one way through, and that way is the API:
//!
//! ```
//! use std::path::Path;
//! use solidtrace::render::{RenderSettings, render};
//! use solidtrace::{Result, integrator, io, scene::SceneDescription, world::World};
//!
//! fn picture(scene: &Path, output: &Path) -> Result<()> {
//!     let description = SceneDescription::read(scene)?; // as authored, every value checked
//!     let mut scene = description.load()?;              // files read, names resolved
//! #   scene.film.size = (16, 16);
//!     scene.film.spp = 4;
//!     let world = World::build(scene)?;                 // trees and lights; answers rays
//!     let scene = world.scene();
//!     let lens = scene.cameras[0].lens(scene.film.size)?;
//!     let integrator = integrator::integrator(&scene.integrator);
//!     let settings = RenderSettings::of(scene);
//!     let rendered = render(&world, &lens, integrator.as_ref(), &settings, &())?;
//!     io::write_image(output, &rendered.film.to_image(), &io::WriteOptions::default())
//! }
//! # let folder = tempfile::TempDir::new().unwrap();
//! # picture(Path::new("scenes/cornell.ron"), &folder.path().join("cornell.exr"))?;
//! # Ok::<(), solidtrace::Error>(())
//! ```

// Tests of private parts share what the tests from outside use.
#[cfg(test)]
extern crate self as solidtrace;

pub mod accel;
pub mod bench;
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
mod memory;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod texture;
pub mod world;

pub use error::{Error, ErrorKind, Result};

//! The one test binary: a module for each thing that must hold.

mod accel;
mod embree;
mod bare_model;
mod film;
mod furnace;
mod layering;
mod lights;
mod output;
mod random;
mod support;
mod watertight;
mod scene_errors;
mod scene_file;

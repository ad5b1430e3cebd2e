//! The one test binary: a module for each thing that must hold.

mod bare_model;
mod film;
mod output;
mod random;
mod scene_errors;
mod scene_file;

//! The one test binary: a module for each thing that must hold.

#![allow(unreachable_pub)] // Everything in a test binary is private to it.
mod accel;
mod adaptive;
mod agreement;
mod bare_model;
mod bench;
mod bsdf;
mod camera;
mod check;
mod cli;
mod closed;
mod csg;
mod csg_info;
mod csg_light;
mod csg_scene;
mod direct;
mod embree;
mod exr;
mod film;
mod furnace;
mod girl;
#[cfg(feature = "embree")]
mod hits;
mod infinity;
mod lamps;
mod layering;
mod layers;
mod lights;
mod loaders;
mod materials;
mod media;
mod output;
mod png;
mod probe;
mod random;
mod readme;
mod report;
mod scene_errors;
mod scene_file;
mod scenes;
mod solids;
mod support;
mod surface;
mod texture;
mod video;
mod watertight;

//! The one test binary: a module for each thing that must hold.

mod accel;
mod embree;
mod film;
mod furnace;
mod layering;
mod lights;
mod output;
mod random;
mod support;
mod watertight;

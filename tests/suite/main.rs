//! The one test binary: a module for each thing that must hold.

mod solids;

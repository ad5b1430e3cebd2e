//! Ray queries over meshes, solids and CSG objects: obvhs builds the trees, the traversal is ours and watertight.
//!
//! Two levels: a tree over the placed shapes, and under each mesh a tree over its triangles, under each CSG object
//! one over its operands.
//! Planes have no bounds and stand in a list beside the tree.

mod alike;
mod boxes;
mod build;
mod csg;
mod mesh;
mod options;
mod ray;
mod scene;
mod triangle;
#[allow(unsafe_code)]
#[allow(
    clippy::unused_self,
    reason = "having a kernel proves that its instructions are there"
)]
mod wide;
mod winding;

#[cfg(test)]
#[path = "../../tests/suite/support/meshes.rs"]
#[allow(
    dead_code,
    unreachable_pub,
    reason = "shared with the tests from outside"
)]
mod meshes;

pub use csg::{CsgCrossing, CsgReport, CsgTree, HOLE};
pub use mesh::MeshReport;
pub use options::{AccelOptions, Kernel, Quality};
pub use scene::{Accel, Hit, Placed};

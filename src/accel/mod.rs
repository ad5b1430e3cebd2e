//! Ray queries over meshes and solids: obvhs builds the trees, the traversal is ours and watertight.
//!
//! Two levels: a tree over the placed shapes, and under each mesh a tree over its triangles.
//! Planes have no bounds and stand in a list beside the tree.

mod build;
mod mesh;
mod ray;
mod scene;
mod tree;
mod triangle;

pub use mesh::MeshReport;
pub use scene::{Accel, Hit, Placed};

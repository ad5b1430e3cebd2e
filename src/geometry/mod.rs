//! Shapes without appearance: triangle meshes, analytic solids, and trees of set operations over both.

mod closed;
mod csg;
mod mesh;
mod polygon;
pub mod solid;
mod tangents;

pub use closed::{EdgeFault, OpenEdge, Openness};
pub use csg::{Csg, CsgId, CsgOp, Operand};
pub(crate) use csg::{CsgStep, LinearMap};
pub use mesh::Mesh;
pub use polygon::triangulate;
pub use solid::Solid;
pub use tangents::{Tangents, uv_axes};

/// Index into the scene's list of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshId(pub u32);

/// What an instance places into the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A triangle mesh, shared by its instances.
    Mesh(MeshId),
    /// An analytic solid in its canonical position.
    Solid(Solid),
    /// A CSG object, shared by its instances.
    Csg(CsgId),
}

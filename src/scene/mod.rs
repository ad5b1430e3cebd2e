//! What is to be rendered: as authored (`description`) and with every file read and name resolved (`Scene`).

pub mod description;
mod generated;
mod model;
mod repeat;

pub use description::SceneDescription;
pub use generated::generated;
pub use model::{Model, Part};
pub use repeat::Repeat;

use crate::camera::Camera;
use crate::color::{Rgb, Tonemap};
use crate::film::Filter;
use crate::geometry::{Csg, Mesh, Shape};
use crate::light::Light;
use crate::material::{Material, MaterialId};
use crate::math::Transform;

/// A scene with every file read and every name resolved to an index.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Size, sample count, filter and curve of the picture.
    pub film: FilmSettings,
    /// How light is transported.
    pub integrator: IntegratorSettings,
    /// At least one once loaded; the first is used unless another is asked for by name.
    pub cameras: Vec<Camera>,
    /// Radiance that comes from every direction in which a ray meets nothing, beside that of lights at infinity.
    pub environment: Rgb,
    /// Lights that are no object's surface.
    pub lights: Vec<Light>,
    /// All materials; a [`MaterialId`] indexes them.
    pub materials: Vec<Material>,
    /// All meshes; a [`crate::geometry::MeshId`] indexes them.
    pub meshes: Vec<Mesh>,
    /// All CSG objects; a [`crate::geometry::CsgId`] indexes them.
    pub csgs: Vec<Csg>,
    /// Shapes placed in the world.
    pub instances: Vec<Instance>,
    /// What the readers want the user to know.
    pub warnings: Vec<String>,
}

/// A shape with its place and its materials.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The object's name, if it has one.
    pub name: Option<String>,
    /// What is placed.
    pub shape: Shape,
    /// One material for each slot of the shape; a solid has one slot, the operands of a CSG object say which are theirs.
    pub materials: Vec<MaterialId>,
    /// Where.
    pub world_from_object: Transform,
    /// Whether normals are interpolated over a mesh's triangles.
    pub smooth: bool,
}

impl Instance {
    /// The material of a slot; the last one serves the slots beyond the list.
    pub fn material(&self, slot: u32) -> MaterialId {
        self.materials[(slot as usize).min(self.materials.len() - 1)]
    }
}

/// Settings of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Samples a pixel.
    pub spp: u32,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Curve of the PNG.
    pub tonemap: Tonemap,
}

impl Default for FilmSettings {
    fn default() -> Self {
        Self {
            size: (1280, 720),
            spp: 256,
            filter: Filter::Gaussian { radius: 1.5 },
            tonemap: Tonemap::Srgb,
        }
    }
}

/// Which integrator, with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum IntegratorSettings {
    /// Path tracing.
    Path {
        /// Most scattering events on a path; `None` is unlimited.
        max_depth: Option<u32>,
        /// Whether dim paths are ended at random.
        russian_roulette: bool,
    },
    /// Light straight from its sources, or over mirrors and clear glass.
    Direct {
        /// Most scattering events on a path.
        max_depth: u32,
    },
    /// Recursive ray tracing: direct light at diffuse surfaces, mirrors and refraction followed.
    Whitted {
        /// Most mirror reflections and refractions on a path.
        max_depth: u32,
        /// What is left of a light's contribution in shadow, 0..=1.
        shadow_factor: f32,
        /// Colour of rays that are lost or cut off by the limit; the environment where `None`.
        background: Option<Rgb>,
    },
    /// Shading normals as colours, `0.5 n + 0.5`.
    Normals,
    /// Distance from the camera.
    Depth,
    /// The surface's own colour, unlit.
    Flat,
    /// Ambient occlusion: the share of the cosine-weighted hemisphere that is open.
    Ao {
        /// How far away an occluder counts; `None` is a quarter of the diagonal of all but planes.
        radius: Option<f64>,
    },
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self::path()
    }
}

impl IntegratorSettings {
    /// Path tracing as it is where nothing else is said.
    pub fn path() -> Self {
        Self::Path {
            max_depth: Some(8),
            russian_roulette: true,
        }
    }

    /// Direct light as it is where nothing else is said.
    pub fn direct() -> Self {
        Self::Direct { max_depth: 8 }
    }

    /// Recursive ray tracing as it is where nothing else is said.
    pub fn whitted() -> Self {
        Self::Whitted {
            max_depth: 8,
            shadow_factor: 0.0,
            background: None,
        }
    }
}

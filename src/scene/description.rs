//! The scene as its author wrote it: every value checked on its own, names not yet looked up and files
//! not yet read.

use std::path::{Path, PathBuf};

use crate::camera::Camera;
use crate::color::Rgb;
use crate::error::Place;
use crate::geometry::Solid;
use crate::light::PointLight;
use crate::material::Fresnel;
use crate::math::Transform;

use super::{FilmSettings, IntegratorSettings};

/// A scene file's content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDescription {
    /// Where it was written.
    pub source: Source,
    /// Size, sample count, filter and curve of the picture.
    pub film: FilmSettings,
    /// How light is transported.
    pub integrator: IntegratorSettings,
    /// At least one; the first is used unless another is asked for by name.
    pub cameras: Vec<Camera>,
    /// Radiance that comes from every direction in which a ray meets nothing.
    pub environment: Rgb,
    /// Lights without extent.
    pub lights: Vec<PointLight>,
    /// The materials that objects name; no two of one name.
    pub materials: Vec<MaterialDescription>,
    /// What stands in the world.
    pub objects: Vec<ObjectDescription>,
    /// Objects that stand nowhere until an instance places them; no two of one name.
    pub definitions: Vec<(String, ObjectDescription)>,
}

/// The file that a description was read from; empty for one that a program made.
///
/// All sources are equal: two descriptions are the same when they say the same, wherever it is written.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// The scene file; what it refers to is found relative to its folder.
    pub file: PathBuf,
    /// Its text, to show the line of an error.
    pub text: String,
}

impl Source {
    /// The folder in which relative paths start.
    pub fn folder(&self) -> &Path {
        match self.file.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        }
    }

    /// The place `offset` bytes into the text.
    pub fn place(&self, offset: usize) -> Place {
        if self.text.is_empty() {
            return Place::file(&self.file);
        }
        Place::in_text(&self.file, &self.text, offset)
    }
}

impl PartialEq for Source {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The name of something else, or of a file, and where it is written. Equal when the names are.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    /// The name or path as written.
    pub name: String,
    /// Bytes from the start of the source's text.
    pub offset: usize,
}

impl PartialEq for Reference {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// A material under its name.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    /// What objects call it.
    pub name: String,
    /// How it scatters.
    pub surface: SurfaceDescription,
    /// Radiance that it emits, W/(m² sr) per channel.
    pub emission: Rgb,
}

/// How a surface scatters light; see [`crate::material::Surface`].
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceDescription {
    /// Lambert's.
    Diffuse {
        /// Albedo.
        color: ColorDescription,
    },
    /// Perfect reflection.
    Mirror {
        /// Reflectance.
        color: ColorDescription,
    },
    /// A smooth boundary between air and a clear medium.
    Dielectric {
        /// Index of refraction, above 0.
        ior: f32,
        /// How much is reflected.
        fresnel: Fresnel,
    },
}

/// A colour that may vary over a surface; see [`crate::texture::Texture`].
#[derive(Clone, Debug, PartialEq)]
pub enum ColorDescription {
    /// The same everywhere.
    Constant(Rgb),
    /// Alternating cubes.
    Checker {
        /// Colour of the cube at the origin's positive corner.
        a: Rgb,
        /// The other colour.
        b: Rgb,
        /// Edge length, above 0.
        step: f64,
    },
    /// A picture file.
    Image {
        /// The file.
        file: Reference,
    },
}

/// One object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDescription {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Its material; a mesh without one keeps its file's materials, all else is grey.
    pub material: Option<Reference>,
    /// Moves the shape from where its own numbers put it.
    pub transform: Transform,
    /// What it is.
    pub shape: ShapeDescription,
}

/// What an object is.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeDescription {
    /// An analytic solid.
    Solid {
        /// In its canonical position.
        solid: Solid,
        /// From there to where its numbers put it.
        placement: Transform,
    },
    /// All meshes of a model file.
    Mesh {
        /// The file.
        file: Reference,
        /// Whether normals are interpolated over triangles.
        smooth: bool,
    },
    /// One of the scene's definitions.
    Instance {
        /// Its name.
        of: Reference,
    },
}

//! The scene as its author wrote it: every value checked on its own, names not yet looked up and files
//! not yet read.

use std::path::{Path, PathBuf};

use crate::camera::Camera;
use crate::color::{Encoding, Rgb};
use crate::error::Place;
use crate::geometry::{CsgOp, Solid};
use crate::light::{Light, Sky};
use crate::material::Surface;
use crate::math::Transform;
use crate::texture::{Pattern, Ramp, Sampling};

use super::{FilmSettings, IntegratorSettings, Repeat};

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
    /// What comes from every direction in which a ray meets nothing.
    pub environment: EnvironmentDescription,
    /// Lights that are no object's surface.
    pub lights: Vec<Light>,
    /// The textures that materials and textures further down name; no two of one name.
    pub textures: Vec<(String, TextureDescription)>,
    /// The materials that objects name; no two of one name.
    pub materials: Vec<MaterialDescription>,
    /// What stands in the world.
    pub objects: Vec<ObjectTree>,
    /// Objects that stand nowhere until an instance places them; no two of one name.
    pub definitions: Vec<(String, ObjectTree)>,
}

/// Light from all directions.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentDescription {
    /// The same radiance everywhere.
    Constant(Rgb),
    /// An equirectangular picture; see [`crate::light::EnvironmentMap`].
    Image {
        /// The file.
        file: Reference,
        /// Turns it about the y axis, radians.
        rotate: f64,
        /// Multiplies its pixels.
        scale: f32,
    },
    /// A clear sky.
    Sky(Sky),
}

impl Default for EnvironmentDescription {
    /// Darkness.
    fn default() -> Self {
        Self::Constant(Rgb::ZERO)
    }
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

    /// The place of `offset` in the text.
    pub fn place(&self, offset: Offset) -> Place {
        if self.text.is_empty() {
            return Place::file(&self.file);
        }
        Place::in_text(&self.file, &self.text, offset.0)
    }
}

impl PartialEq for Source {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Where something is written: bytes from the start of the source's text. All offsets are equal, as sources are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Offset(pub usize);

impl PartialEq for Offset {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The name of something else, or of a file, and where it is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reference {
    /// The name or path as written.
    pub name: String,
    /// Where.
    pub offset: Offset,
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
    /// Multiplies the emission.
    pub emission_texture: Option<TextureDescription>,
    /// What bends its shading normal.
    pub relief: Option<ReliefDescription>,
}

/// Detail in shading; see [`crate::material::Relief`].
#[derive(Clone, Debug, PartialEq)]
pub enum ReliefDescription {
    /// Raises the surface.
    Bump {
        /// How far, in parts of the height.
        texture: TextureDescription,
        /// In the object's units.
        height: f64,
    },
    /// Normals in tangent space.
    NormalMap {
        /// The normals.
        texture: TextureDescription,
        /// Multiplies their slope.
        scale: f64,
    },
}

/// How a surface scatters light, its textures as written.
pub type SurfaceDescription = Surface<TextureDescription>;

/// A colour or number that may vary over a surface; see [`crate::texture::Texture`].
#[derive(Clone, Debug, PartialEq)]
pub enum TextureDescription {
    /// The same everywhere.
    Constant(Rgb),
    /// A pattern in colours.
    Pattern {
        /// A number for every point.
        pattern: Pattern,
        /// A colour for every number.
        colors: Ramp,
    },
    /// A picture file.
    Image {
        /// The file.
        file: Reference,
        /// How its integers are decoded; `None` is as sRGB for a colour, in proportion for all else.
        encoding: Option<Encoding>,
        /// How it is looked up.
        sampling: Sampling,
    },
    /// One of the scene's textures.
    Named(Reference),
    /// A texture times a colour.
    Scale {
        /// The texture.
        of: Box<TextureDescription>,
        /// Multiplies each channel.
        by: Rgb,
    },
    /// One channel of a texture as a grey.
    Channel {
        /// The texture.
        of: Box<TextureDescription>,
        /// Which one: 1 where that is, else 0.
        by: Rgb,
    },
    /// A texture moved as an object is.
    Transform {
        /// The texture.
        of: Box<TextureDescription>,
        /// From the texture's space to the object's.
        transform: Transform,
    },
    /// Two textures, mixed by a third.
    Mix {
        /// Where `by` is 0.
        a: Box<TextureDescription>,
        /// Where `by` is 1.
        b: Box<TextureDescription>,
        /// As a scalar.
        by: Box<TextureDescription>,
    },
}

impl From<f32> for TextureDescription {
    /// The same grey everywhere.
    fn from(value: f32) -> Self {
        Self::Constant(Rgb::splat(value))
    }
}

/// An object after all the objects that it is made of, in post-order: an operator follows its operands and takes
/// the last ones that no other has taken; the whole comes last. Nothing in it is recursive, so objects may be nested
/// to any depth.
///
/// ```
/// use solidtrace::geometry::{CsgOp, Solid};
/// use solidtrace::math::Transform;
/// use solidtrace::scene::description::{ObjectDescription, ObjectTree, Offset, ShapeDescription};
///
/// let object = |shape| ObjectDescription {
///     name: None,
///     material: None,
///     transform: Transform::IDENTITY,
///     shape,
///     offset: Offset::default(),
/// };
/// let ball = |radius| {
///     let solid = Solid::Sphere { radius };
///     object(ShapeDescription::Solid { solid, placement: Transform::IDENTITY })
/// };
/// let (op, operands) = (CsgOp::Difference, 2);
/// let shell = ObjectTree(vec![ball(2.0), ball(1.9), object(ShapeDescription::Csg { op, operands })]);
/// assert_eq!(shell.0[2].shape.operands(), 2);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectTree(pub Vec<ObjectDescription>);

/// One object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDescription {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Its material, which all that it is made of has then. A mesh without one keeps its file's materials; a solid
    /// is grey unless something that it is part of has one.
    pub material: Option<Reference>,
    /// Moves the shape from where its own numbers put it.
    pub transform: Transform,
    /// What it is.
    pub shape: ShapeDescription,
    /// Where it is written.
    pub offset: Offset,
}

/// What an object is.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeDescription {
    /// An analytic solid. The plane is a surface, and a half-space where it is an operand.
    Solid {
        /// In its canonical position.
        solid: Solid,
        /// From there to where its numbers put it.
        placement: Transform,
    },
    /// All meshes of a model file; their union where it is an operand, for which they must be closed.
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
    /// A set operation.
    Csg {
        /// Which one.
        op: CsgOp,
        /// How many objects it takes, at least one.
        operands: usize,
    },
    /// Copies of one object: each stands for itself, and where it is an operand their union does.
    Repeat(Repeat),
}

impl ShapeDescription {
    /// How many objects of its tree it takes.
    pub fn operands(&self) -> usize {
        match self {
            Self::Solid { .. } | Self::Mesh { .. } | Self::Instance { .. } => 0,
            Self::Csg { operands, .. } => *operands,
            Self::Repeat(_) => 1,
        }
    }
}

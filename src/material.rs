//! What a surface is made of: a way to scatter, and light of its own.

mod metal;
mod principled;
mod surface;

pub use metal::Metal;
pub use principled::Principled;
pub use surface::{Fresnel, Interior, Roughness, Surface, absorption};

use crate::color::Rgb;
use crate::texture::{Texture, TexturePoint};

/// Index into the scene's list of materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// A named material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name in the scene or model file.
    pub name: String,
    /// How it scatters.
    pub surface: Surface,
    /// Radiance that it emits from both sides, W/(m² sr) per channel.
    pub emission: Rgb,
    /// Multiplies the emission.
    pub emission_texture: Option<Texture>,
    /// What bends its shading normal.
    pub relief: Option<Relief>,
}

impl Material {
    /// Radiance emitted at a point.
    pub fn emitted(&self, point: &TexturePoint) -> Rgb {
        match &self.emission_texture {
            Some(texture) if self.emission != Rgb::ZERO => self.emission * texture.eval(point),
            _ => self.emission,
        }
    }
}

/// Detail of a surface that shows in its shading alone.
#[derive(Clone, Debug, PartialEq)]
pub enum Relief {
    /// The surface raised along its outward normal (Blinn 1978, "Simulation of Wrinkled Surfaces").
    Bump {
        /// As a scalar.
        texture: Texture,
        /// How far 1 in the texture raises the surface, in units of the object's space.
        height: f64,
    },
    /// Normals in the tangent space of the surface coordinates, x along u, y along v and z outward, each component c
    /// stored as (c + 1) / 2.
    NormalMap {
        /// As data.
        texture: Texture,
        /// Multiplies x and y.
        scale: f64,
    },
}

impl Default for Material {
    /// What an object without a material gets: matt, middle grey.
    fn default() -> Self {
        Self {
            name: "default".to_owned(),
            surface: Surface::Diffuse {
                color: Texture::Constant(Rgb::splat(0.7)),
            },
            emission: Rgb::ZERO,
            emission_texture: None,
            relief: None,
        }
    }
}

//! What a surface is made of: a way to scatter, and light of its own.

mod metal;
mod principled;
mod surface;

pub use metal::Metal;
pub use principled::Principled;
pub use surface::{Fresnel, Interior, Roughness, Surface, absorption};

use crate::color::Rgb;
use crate::texture::Texture;

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
        }
    }
}

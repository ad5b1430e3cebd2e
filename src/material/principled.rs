use crate::color::Rgb;
use crate::texture::Texture;

use super::{Interior, Roughness};

/// Parameters of the surface that glTF 2.0 and its extensions define (`KHR_materials_specular`, `_ior`,
/// `_transmission`, `_volume`, `_clearcoat`, `_sheen`, `_anisotropy`, `_iridescence`); dispersion is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled<C = Texture> {
    /// Colour of the matt base, of what shines through and of the metal.
    pub base_color: C,
    /// Share that is metal, 0..=1.
    pub metallic: f32,
    /// Of reflection and transmission alike.
    pub roughness: Roughness,
    /// Index of refraction of what is not metal, at least 1.
    pub ior: f32,
    /// Strength of the reflection of what is not metal, 0..=1.
    pub specular: f32,
    /// Its colour at normal incidence, 0 or more.
    pub specular_color: C,
    /// Share of the base that light goes through, 0..=1.
    pub transmission: f32,
    /// Whether light that goes through goes straight on: the surface is a sheet, not a body's boundary.
    pub thin: bool,
    /// What a body absorbs, per metre and channel.
    pub absorption: Rgb,
    /// Strength of a clear coat over it all, of index 1.5, 0..=1.
    pub clearcoat: f32,
    /// How rough the coat is, 0..=1.
    pub clearcoat_roughness: f32,
    /// Colour of the sheen of fibres that stand off the surface, 0..=1 per channel.
    pub sheen_color: C,
    /// How rough the sheen is, 0..=1.
    pub sheen_roughness: f32,
    /// Strength of a thin film's colours, 0..=1.
    pub iridescence: f32,
    /// Index of refraction of the film, at least 1.
    pub iridescence_ior: f32,
    /// Thickness of the film in nanometres.
    pub iridescence_thickness: f32,
}

impl<C> Principled<C> {
    /// Matt and fully rough, with glTF's defaults for all that is not the base; `constant` makes a colour.
    pub fn new(base_color: C, constant: impl Fn(Rgb) -> C) -> Self {
        Self {
            base_color,
            metallic: 0.0,
            roughness: 1.0.into(),
            ior: 1.5,
            specular: 1.0,
            specular_color: constant(Rgb::ONE),
            transmission: 0.0,
            thin: false,
            absorption: Rgb::ZERO,
            clearcoat: 0.0,
            clearcoat_roughness: 0.0,
            sheen_color: constant(Rgb::ZERO),
            sheen_roughness: 0.0,
            iridescence: 0.0,
            iridescence_ior: 1.3,
            iridescence_thickness: 400.0,
        }
    }

    /// What is behind it, where light goes through and the surface bounds a body.
    pub fn interior(&self) -> Option<Interior> {
        (self.transmission > 0.0 && self.metallic < 1.0 && !self.thin).then_some(Interior {
            ior: self.ior,
            absorption: self.absorption,
        })
    }

    /// The same with `color` made of each colour.
    ///
    /// # Errors
    /// Those of `color`.
    pub fn try_map<D, E>(
        &self,
        color: &mut impl FnMut(&C) -> Result<D, E>,
    ) -> Result<Principled<D>, E> {
        Ok(Principled {
            base_color: color(&self.base_color)?,
            specular_color: color(&self.specular_color)?,
            sheen_color: color(&self.sheen_color)?,
            metallic: self.metallic,
            roughness: self.roughness,
            ior: self.ior,
            specular: self.specular,
            transmission: self.transmission,
            thin: self.thin,
            absorption: self.absorption,
            clearcoat: self.clearcoat,
            clearcoat_roughness: self.clearcoat_roughness,
            sheen_roughness: self.sheen_roughness,
            iridescence: self.iridescence,
            iridescence_ior: self.iridescence_ior,
            iridescence_thickness: self.iridescence_thickness,
        })
    }
}

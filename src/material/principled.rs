use crate::color::{Encoding, Rgb};
use crate::texture::Texture;

use super::{Interior, Roughness};

/// Parameters of the surface that glTF 2.0 and its extensions define (`KHR_materials_specular`, `_ior`,
/// `_transmission`, `_volume`, `_clearcoat`, `_sheen`, `_anisotropy`, `_iridescence`); dispersion is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled<C = Texture> {
    /// Colour of the matt base, of what shines through and of the metal.
    pub base_color: C,
    /// Share that is metal, 0..=1.
    pub metallic: C,
    /// Of reflection and transmission alike.
    pub roughness: Roughness<C>,
    /// Index of refraction of what is not metal, at least 1.
    pub ior: f32,
    /// Strength of the reflection of what is not metal, 0..=1.
    pub specular: C,
    /// Its colour at normal incidence, 0 or more.
    pub specular_color: C,
    /// Share of the base that light goes through, 0..=1.
    pub transmission: C,
    /// Whether light that goes through goes straight on: the surface is a sheet, not a body's boundary.
    pub thin: bool,
    /// What a body absorbs, per metre and channel.
    pub absorption: Rgb,
    /// Strength of a clear coat over it all, of index 1.5, 0..=1.
    pub clearcoat: C,
    /// How rough the coat is, 0..=1.
    pub clearcoat_roughness: C,
    /// Colour of the sheen of fibres that stand off the surface, 0..=1 per channel.
    pub sheen_color: C,
    /// How rough the sheen is, 0..=1.
    pub sheen_roughness: C,
    /// Strength of a thin film's colours, 0..=1.
    pub iridescence: C,
    /// Index of refraction of the film, at least 1.
    pub iridescence_ior: f32,
    /// Thickness of the film in nanometres.
    pub iridescence_thickness: C,
}

impl<C: From<f32>> Principled<C> {
    /// Matt and fully rough, with glTF's defaults for all that is not the base.
    pub fn new(base_color: C) -> Self {
        Self {
            base_color,
            metallic: 0.0.into(),
            roughness: 1.0.into(),
            ior: 1.5,
            specular: 1.0.into(),
            specular_color: 1.0.into(),
            transmission: 0.0.into(),
            thin: false,
            absorption: Rgb::ZERO,
            clearcoat: 0.0.into(),
            clearcoat_roughness: 0.0.into(),
            sheen_color: 0.0.into(),
            sheen_roughness: 0.0.into(),
            iridescence: 0.0.into(),
            iridescence_ior: 1.3,
            iridescence_thickness: 400.0.into(),
        }
    }
}

impl Principled {
    /// What is behind it, where light may go through and the surface bounds a body.
    pub fn interior(&self) -> Option<Interior> {
        let may_transmit = !self.transmission.is(0.0) && !self.metallic.is(1.0);
        (may_transmit && !self.thin).then_some(Interior {
            ior: self.ior,
            absorption: self.absorption,
        })
    }
}

impl<C> Principled<C> {
    /// As [`super::Surface::try_map`].
    pub(super) fn try_map<'a, D, E>(
        &'a self,
        make: &mut impl FnMut(&'a C, Encoding) -> Result<D, E>,
    ) -> Result<Principled<D>, E> {
        Ok(Principled {
            base_color: make(&self.base_color, Encoding::Srgb)?,
            metallic: make(&self.metallic, Encoding::Linear)?,
            roughness: self.roughness.try_map(make)?,
            ior: self.ior,
            specular: make(&self.specular, Encoding::Linear)?,
            specular_color: make(&self.specular_color, Encoding::Srgb)?,
            transmission: make(&self.transmission, Encoding::Linear)?,
            thin: self.thin,
            absorption: self.absorption,
            clearcoat: make(&self.clearcoat, Encoding::Linear)?,
            clearcoat_roughness: make(&self.clearcoat_roughness, Encoding::Linear)?,
            sheen_color: make(&self.sheen_color, Encoding::Srgb)?,
            sheen_roughness: make(&self.sheen_roughness, Encoding::Linear)?,
            iridescence: make(&self.iridescence, Encoding::Linear)?,
            iridescence_ior: self.iridescence_ior,
            iridescence_thickness: make(&self.iridescence_thickness, Encoding::Linear)?,
        })
    }
}

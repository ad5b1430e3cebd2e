use crate::color::{Encoding, Rgb};
use crate::texture::{Texture, TexturePoint};

use super::{Metal, Principled};

/// How a surface scatters light. `C` is what a colour, or a number that may vary, is: a texture, or what a file says of
/// one. Of what is inside all numbers are the same everywhere.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface<C = Texture> {
    /// Lambert's; `color` is the albedo.
    Diffuse {
        /// Albedo, 0..=1 per channel.
        color: C,
    },
    /// Perfect reflection times `color`.
    Mirror {
        /// Reflectance, 0..=1 per channel.
        color: C,
    },
    /// A boundary between air and a clear medium.
    Dielectric {
        /// Index of refraction of the inside against the outside.
        ior: f32,
        /// How much is reflected.
        fresnel: Fresnel,
        /// How rough the boundary is, 0..=1.
        roughness: C,
        /// What the inside absorbs, per metre and channel.
        absorption: Rgb,
    },
    /// A clear sheet so thin that light goes straight on behind it.
    ThinDielectric {
        /// Index of refraction of the sheet against what is around it.
        ior: f32,
    },
    /// Bare metal.
    Conductor {
        /// Which.
        metal: Metal,
        /// How rough it is.
        roughness: Roughness<C>,
    },
    /// A rough reflector of the given colour.
    Glossy {
        /// Reflectance at normal incidence, 0..=1 per channel; 1 at grazing angles.
        color: C,
        /// How rough it is.
        roughness: Roughness<C>,
    },
    /// A matt base under a clear coat.
    Plastic {
        /// Albedo of the base by itself, 0..=1 per channel.
        color: C,
        /// Index of refraction of the coat against what is around it, 1..=3.
        ior: f32,
        /// How rough the coat is, 0..=1.
        roughness: C,
    },
    /// As glTF defines it.
    Principled(Box<Principled<C>>),
    /// Two surfaces at once.
    Mix {
        /// One of them.
        a: Box<Self>,
        /// The other.
        b: Box<Self>,
        /// Share of the other, 0..=1.
        weight: C,
    },
    /// Another surface from each side.
    TwoSided {
        /// On the side of the outward normal.
        front: Box<Self>,
        /// On the other.
        back: Box<Self>,
    },
}

/// Which reflectance a dielectric uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fresnel {
    /// All light is refracted; only total internal reflection reflects.
    None,
    /// Schlick's 1994 approximation.
    Schlick,
    /// Fresnel's equations for unpolarised light.
    #[default]
    Exact,
}

/// How rough a surface is, and whether more so one way than the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness<C = Texture> {
    /// As it is perceived, 0..=1: its square is the GGX distribution's width, alpha.
    pub value: C,
    /// 0..=1: `alpha` along the tangent is `mix(alpha, 1, anisotropy²)`, as `KHR_materials_anisotropy` has it.
    pub anisotropy: C,
    /// Angle in radians from the surface's tangent, along which the first surface coordinate grows, counter-clockwise.
    pub rotation: C,
}

impl<C: From<f32>> From<f32> for Roughness<C> {
    /// The same in all directions.
    fn from(value: f32) -> Self {
        Self {
            value: value.into(),
            anisotropy: 0.0.into(),
            rotation: 0.0.into(),
        }
    }
}

impl Roughness {
    /// Its numbers at a point.
    pub fn at(&self, point: &TexturePoint) -> Roughness<f32> {
        Roughness {
            value: self.value.eval_share(point),
            anisotropy: self.anisotropy.eval_share(point),
            rotation: self.rotation.eval_scalar(point),
        }
    }

    /// Whether it may look different when the surface is turned.
    pub(super) fn is_brushed(&self) -> bool {
        !self.anisotropy.is(0.0)
    }
}

impl<C> Roughness<C> {
    pub(super) fn try_map<'a, D, E>(
        &'a self,
        make: &mut impl FnMut(&'a C, Encoding) -> Result<D, E>,
    ) -> Result<Roughness<D>, E> {
        Ok(Roughness {
            value: make(&self.value, Encoding::Linear)?,
            anisotropy: make(&self.anisotropy, Encoding::Linear)?,
            rotation: make(&self.rotation, Encoding::Linear)?,
        })
    }
}

/// A clear medium behind a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior {
    /// Index of refraction against air.
    pub ior: f32,
    /// What is absorbed, per metre and channel.
    pub absorption: Rgb,
}

/// What a medium absorbs, per metre and channel, that leaves `color` of white light after `distance` metres (Beer's law).
/// Black counts as a millionth, for nothing absorbs all light.
pub fn absorption(color: Rgb, distance: f64) -> Rgb {
    let depth = color.clamp(Rgb::splat(1e-6), Rgb::ONE).to_array();
    Rgb::from_array(depth.map(|c| (-f64::from(c).ln() / distance) as f32))
}

impl<C: From<f32>> Surface<C> {
    /// Smooth clear glass, or water, or diamond.
    pub fn glass(ior: f32) -> Self {
        Self::Dielectric {
            ior,
            fresnel: Fresnel::Exact,
            roughness: 0.0.into(),
            absorption: Rgb::ZERO,
        }
    }
}

impl Surface {
    /// What is behind it, where light goes through. Of two surfaces the first one's counts.
    pub fn interior(&self) -> Option<Interior> {
        match self {
            &Self::Dielectric {
                ior, absorption, ..
            } => Some(Interior { ior, absorption }),
            Self::Principled(principled) => principled.interior(),
            Self::Mix { a, b, .. } => a.interior().or(b.interior()),
            Self::TwoSided { front, back } => front.interior().or(back.interior()),
            _ => None,
        }
    }

    /// Whether it may look different when it is turned, so that it needs a tangent.
    pub fn is_brushed(&self) -> bool {
        match self {
            Self::Conductor { roughness, .. } | Self::Glossy { roughness, .. } => {
                roughness.is_brushed()
            }
            Self::Principled(principled) => principled.roughness.is_brushed(),
            Self::Mix { a, b, .. } => a.is_brushed() || b.is_brushed(),
            Self::TwoSided { front, back } => front.is_brushed() || back.is_brushed(),
            Self::Diffuse { .. }
            | Self::Mirror { .. }
            | Self::Dielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::Plastic { .. } => false,
        }
    }
}

impl<C> Surface<C> {
    /// The same surface with what `make` makes of each colour ([`Encoding::Srgb`]) and number ([`Encoding::Linear`]).
    ///
    /// # Errors
    /// Those of `make`.
    pub fn try_map<'a, D, E>(
        &'a self,
        make: &mut impl FnMut(&'a C, Encoding) -> Result<D, E>,
    ) -> Result<Surface<D>, E> {
        Ok(match self {
            Self::Diffuse { color } => Surface::Diffuse {
                color: make(color, Encoding::Srgb)?,
            },
            Self::Mirror { color } => Surface::Mirror {
                color: make(color, Encoding::Srgb)?,
            },
            Self::Dielectric {
                ior,
                fresnel,
                roughness,
                absorption,
            } => Surface::Dielectric {
                ior: *ior,
                fresnel: *fresnel,
                roughness: make(roughness, Encoding::Linear)?,
                absorption: *absorption,
            },
            Self::ThinDielectric { ior } => Surface::ThinDielectric { ior: *ior },
            Self::Conductor { metal, roughness } => Surface::Conductor {
                metal: *metal,
                roughness: roughness.try_map(make)?,
            },
            Self::Glossy { color, roughness } => Surface::Glossy {
                color: make(color, Encoding::Srgb)?,
                roughness: roughness.try_map(make)?,
            },
            Self::Plastic {
                color,
                ior,
                roughness,
            } => Surface::Plastic {
                color: make(color, Encoding::Srgb)?,
                ior: *ior,
                roughness: make(roughness, Encoding::Linear)?,
            },
            Self::Principled(principled) => {
                Surface::Principled(Box::new(principled.try_map(make)?))
            }
            Self::Mix { a, b, weight } => Surface::Mix {
                a: Box::new(a.try_map(make)?),
                b: Box::new(b.try_map(make)?),
                weight: make(weight, Encoding::Linear)?,
            },
            Self::TwoSided { front, back } => Surface::TwoSided {
                front: Box::new(front.try_map(make)?),
                back: Box::new(back.try_map(make)?),
            },
        })
    }
}

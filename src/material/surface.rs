use crate::color::Rgb;
use crate::texture::Texture;

use super::{Metal, Principled};

/// How a surface scatters light. `C` is what a colour is: a texture, or what a file says of one.
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
        roughness: f32,
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
        roughness: Roughness,
    },
    /// A rough reflector of the given colour.
    Glossy {
        /// Reflectance at normal incidence, 0..=1 per channel; 1 at grazing angles.
        color: C,
        /// How rough it is.
        roughness: Roughness,
    },
    /// A matt base under a clear coat.
    Plastic {
        /// Albedo of the base by itself, 0..=1 per channel.
        color: C,
        /// Index of refraction of the coat against what is around it, 1..=3.
        ior: f32,
        /// How rough the coat is, 0..=1.
        roughness: f32,
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
        weight: f32,
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roughness {
    /// As it is perceived, 0..=1: its square is the GGX distribution's width, alpha.
    pub value: f32,
    /// 0..=1: `alpha` along the tangent is `mix(alpha, 1, anisotropy²)`, as `KHR_materials_anisotropy` has it.
    pub anisotropy: f32,
    /// Angle from the surface's tangent, along which the first surface coordinate grows, counter-clockwise.
    pub rotation: f32,
}

impl From<f32> for Roughness {
    /// The same in all directions.
    fn from(value: f32) -> Self {
        Self {
            value,
            ..Self::default()
        }
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

impl<C> Surface<C> {
    /// Smooth clear glass, or water, or diamond.
    pub fn glass(ior: f32) -> Self {
        Self::Dielectric {
            ior,
            fresnel: Fresnel::Exact,
            roughness: 0.0,
            absorption: Rgb::ZERO,
        }
    }

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

    /// The same surface with `color` made of each colour.
    ///
    /// # Errors
    /// Those of `color`.
    pub fn try_map<D, E>(
        &self,
        color: &mut impl FnMut(&C) -> Result<D, E>,
    ) -> Result<Surface<D>, E> {
        Ok(match self {
            Self::Diffuse { color: c } => Surface::Diffuse { color: color(c)? },
            Self::Mirror { color: c } => Surface::Mirror { color: color(c)? },
            &Self::Dielectric {
                ior,
                fresnel,
                roughness,
                absorption,
            } => Surface::Dielectric {
                ior,
                fresnel,
                roughness,
                absorption,
            },
            &Self::ThinDielectric { ior } => Surface::ThinDielectric { ior },
            &Self::Conductor { metal, roughness } => Surface::Conductor { metal, roughness },
            Self::Glossy {
                color: c,
                roughness,
            } => Surface::Glossy {
                color: color(c)?,
                roughness: *roughness,
            },
            Self::Plastic {
                color: c,
                ior,
                roughness,
            } => Surface::Plastic {
                color: color(c)?,
                ior: *ior,
                roughness: *roughness,
            },
            Self::Principled(principled) => {
                Surface::Principled(Box::new(principled.try_map(color)?))
            }
            Self::Mix { a, b, weight } => Surface::Mix {
                a: Box::new(a.try_map(color)?),
                b: Box::new(b.try_map(color)?),
                weight: *weight,
            },
            Self::TwoSided { front, back } => Surface::TwoSided {
                front: Box::new(front.try_map(color)?),
                back: Box::new(back.try_map(color)?),
            },
        })
    }
}

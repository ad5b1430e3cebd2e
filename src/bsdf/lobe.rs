//! The kinds of scattering, in the shading frame: z lies along the normal on the side of `wo`.

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::material::Surface;
use crate::texture::TexturePoint;

use super::BsdfSample;
use super::dielectric::Dielectric;
use super::diffuse::Diffuse;
use super::fresnel::Reflectance;
use super::microfacet::Microfacets;
use super::mix::Mix;
use super::plastic::Plastic;
use super::principled::Principled;
use super::reflection::Reflection;
use super::thin::Thin;

#[derive(Clone, Debug)]
pub(super) enum Lobe {
    Diffuse(Diffuse),
    Reflection(Reflection),
    Dielectric(Dielectric),
    Thin(Thin),
    Plastic(Plastic),
    Principled(Box<Principled>),
    Mix(Box<Mix>),
}

impl Lobe {
    /// See [`super::Bsdf::new`].
    #[inline(always)]
    pub(super) fn new(surface: &Surface, point: &TexturePoint, side: f32, eta: f32) -> Self {
        match surface {
            Surface::Diffuse { color } => Self::Diffuse(Diffuse {
                albedo: color.eval(point),
            }),
            Surface::Mirror { color } => {
                let reflectance = Reflectance::Constant(color.eval(point));
                Self::Reflection(Reflection::new(reflectance, None))
            }
            Surface::Dielectric {
                fresnel, roughness, ..
            } => {
                let facets = Microfacets::new(roughness.eval_share(point).into());
                Self::Dielectric(Dielectric::new(eta, *fresnel, facets))
            }
            &Surface::ThinDielectric { ior } => Self::Thin(Thin { ior }),
            Surface::Conductor { metal, roughness } => {
                let facets = Microfacets::new(roughness.at(point));
                Self::Reflection(Reflection::new(Reflectance::Metal(*metal), facets))
            }
            Surface::Glossy { color, roughness } => {
                let facets = Microfacets::new(roughness.at(point));
                let reflectance = Reflectance::Schlick(color.eval(point));
                Self::Reflection(Reflection::new(reflectance, facets))
            }
            Surface::Plastic {
                color,
                ior,
                roughness,
            } => {
                let roughness = roughness.eval_share(point);
                Self::Plastic(Plastic::new(color.eval(point), *ior, roughness))
            }
            Surface::Principled(of) => Self::Principled(Box::new(Principled::new(of, point, eta))),
            Surface::Mix { a, b, weight } => Self::Mix(Box::new(Mix {
                a: Self::new(a, point, side, eta),
                b: Self::new(b, point, side, eta),
                weight: weight.eval_share(point),
            })),
            Surface::TwoSided { front, back } => {
                let surface = if side > 0.0 { front } else { back };
                Self::new(surface, point, side, eta)
            }
        }
    }

    #[inline(always)]
    pub(super) fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        match self {
            Self::Diffuse(lobe) => Some(lobe.sample(u2)),
            Self::Reflection(lobe) => lobe.sample(wo, u, u2),
            Self::Dielectric(lobe) => lobe.sample(wo, u, u2),
            Self::Thin(lobe) => Some(lobe.sample(wo, u)),
            Self::Plastic(lobe) => lobe.sample(wo, u, u2),
            Self::Principled(lobe) => lobe.sample(wo, u, u2),
            Self::Mix(lobe) => lobe.sample(wo, u, u2),
        }
    }

    /// `f |cos|` and density of all but delta lobes.
    #[inline(always)]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        match self {
            Self::Diffuse(lobe) => lobe.eval(wi),
            Self::Reflection(lobe) => lobe.eval(wo, wi),
            Self::Dielectric(lobe) => lobe.eval(wo, wi),
            Self::Thin(_) => (Rgb::ZERO, 0.0),
            Self::Plastic(lobe) => lobe.eval(wo, wi),
            Self::Principled(lobe) => lobe.eval(wo, wi),
            Self::Mix(lobe) => lobe.eval(wo, wi),
        }
    }

    /// The colour to show for it.
    pub(super) fn albedo(&self) -> Rgb {
        match self {
            Self::Diffuse(lobe) => lobe.albedo,
            Self::Reflection(lobe) => lobe.reflectance.at(1.0),
            Self::Dielectric(_) | Self::Thin(_) => Rgb::ONE,
            Self::Plastic(lobe) => lobe.color,
            Self::Principled(lobe) => lobe.base_color,
            Self::Mix(mix) => mix.a.albedo().lerp(mix.b.albedo(), mix.weight),
        }
    }

    /// Whether any of it is not a delta lobe.
    pub(super) fn is_smooth(&self) -> bool {
        match self {
            Self::Diffuse(_) | Self::Plastic(_) => true,
            Self::Reflection(lobe) => lobe.facets().is_some(),
            Self::Dielectric(lobe) => lobe.is_smooth(),
            Self::Thin(_) => false,
            Self::Principled(lobe) => lobe.is_smooth(),
            Self::Mix(mix) => mix.a.is_smooth() || mix.b.is_smooth(),
        }
    }

    /// Whether light goes through.
    #[inline(always)]
    pub(super) fn transmits(&self) -> bool {
        match self {
            Self::Diffuse(_) | Self::Reflection(_) | Self::Plastic(_) => false,
            Self::Dielectric(_) | Self::Thin(_) => true,
            Self::Principled(lobe) => lobe.transmits(),
            Self::Mix(mix) => mix.a.transmits() || mix.b.transmits(),
        }
    }

    /// Whether it looks different when the surface is turned.
    #[inline(always)]
    pub(super) fn is_anisotropic(&self) -> bool {
        match self {
            Self::Reflection(lobe) => lobe.facets().is_some_and(|f| f.brush().is_some()),
            Self::Principled(lobe) => lobe.facets().is_some_and(|f| f.brush().is_some()),
            Self::Mix(mix) => mix.a.is_anisotropic() || mix.b.is_anisotropic(),
            Self::Diffuse(_) | Self::Dielectric(_) | Self::Thin(_) | Self::Plastic(_) => false,
        }
    }
}

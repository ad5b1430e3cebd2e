//! A boundary between two clear media, smooth or rough (Walter et al. 2007, with visible normals). `eta` is the index
//! on the far side over the near side's. What a rough boundary's facets send on to one another is lost.

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::material::Fresnel;

use super::BsdfSample;
use super::fresnel::{cos_refracted, dielectric};
use super::microfacet::{Microfacets, refract};
use super::mirror::reflect;

/// Facets between media as close as this would bend light by less than f32 can tell.
const LEAST_STEP: f32 = 0.01;

#[derive(Clone, Copy, Debug)]
pub(super) struct Dielectric {
    eta: f32,
    fresnel: Fresnel,
    facets: Option<Microfacets>,
}

impl Dielectric {
    pub(super) fn new(eta: f32, fresnel: Fresnel, facets: Option<Microfacets>) -> Self {
        Self {
            eta,
            fresnel,
            facets: facets.filter(|_| (eta - 1.0).abs() >= LEAST_STEP),
        }
    }

    pub(super) fn is_smooth(&self) -> bool {
        self.facets.is_some()
    }

    /// Reflects at a facet with the probability of its reflectance, else refracts.
    pub(super) fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        let h = match &self.facets {
            Some(facets) => facets.visible_normal(wo, u2),
            None => Vec3::Z,
        };
        let cos = wo.dot(h);
        let transmitted = u >= dielectric(self.fresnel, cos, self.eta);
        let wi = if transmitted {
            refract(wo, h, self.eta, cos_refracted(cos, self.eta)?)
        } else if self.facets.is_some() {
            (2.0 * cos * h - wo).normalize()
        } else {
            reflect(wo)
        };
        if (wi.z < 0.0) != transmitted {
            return None;
        }
        let eta2 = if transmitted {
            self.eta * self.eta
        } else {
            1.0
        };
        if self.facets.is_none() {
            let delta = BsdfSample::new(wi, Rgb::splat(1.0 / eta2), f32::INFINITY);
            return Some(BsdfSample { eta2, ..delta });
        }
        let sample = BsdfSample::of(wi, self.eval(wo, wi))?;
        Some(BsdfSample { eta2, ..sample })
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some(facets) = &self.facets else {
            return (Rgb::ZERO, 0.0);
        };
        if wi.z > 0.0 {
            let reflected = facets.reflected(wo, wi);
            let r = dielectric(self.fresnel, reflected.cos, self.eta);
            return (Rgb::splat(r * reflected.f_cos), r * reflected.pdf);
        }
        let Some(refracted) = facets.refracted(wo, wi, self.eta) else {
            return (Rgb::ZERO, 0.0);
        };
        let t = 1.0 - dielectric(self.fresnel, refracted.cos, self.eta);
        (Rgb::splat(t * refracted.f_cos), t * refracted.pdf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_obeys_snell() {
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let boundary = Dielectric::new(1.5, Fresnel::None, None);
        let out = boundary.sample(wo, 0.5, Vec2::ZERO).unwrap();
        assert!((-out.wi.x * 1.5 - wo.x).abs() < 1e-6 && out.wi.z < 0.0);
        assert_eq!(out.eta2, 2.25);
    }
}

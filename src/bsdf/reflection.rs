//! Mirror, bare metal and glossy colours: all that is not reflected is absorbed.
//!
//! Light that a facet throws at the next one is not lost but comes off the surface in the end, spread evenly: Kulla
//! and Conty 2017, "Revisiting Physically Based Shading at Imageworks", with the colour of the further reflections after
//! Hill 2018 ("A Multi-Faceted Exploration", part 2).

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};

use super::BsdfSample;
use super::albedo::Whole;
use super::fresnel::Reflectance;
use super::microfacet::Microfacets;
use super::mirror::reflect;

#[derive(Clone, Copy, Debug)]
pub(super) struct Reflection {
    pub(super) reflectance: Reflectance,
    rough: Option<Rough>,
}

/// Facets, and what they send on to one another.
#[derive(Clone, Copy, Debug)]
struct Rough {
    whole: Whole,
    /// Colour of what was reflected more than once.
    further: Rgb,
}

impl Reflection {
    pub(super) fn new(reflectance: Reflectance, facets: Option<Microfacets>) -> Self {
        let rough = facets.map(|facets| {
            let whole = Whole::new(facets);
            Rough {
                whole,
                further: whole.further(reflectance.average()),
            }
        });
        Self { reflectance, rough }
    }

    /// The facets, unless it is smooth.
    pub(super) fn facets(&self) -> Option<&Microfacets> {
        self.rough.as_ref().map(|rough| &rough.whole.facets)
    }

    pub(super) fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        let Some(rough) = &self.rough else {
            let weight = self.reflectance.at(wo.z);
            return Some(BsdfSample::new(reflect(wo), weight, f32::INFINITY));
        };
        let wi = if u < self.further_share(rough, wo) {
            cosine_hemisphere(u2)
        } else {
            rough.whole.facets.reflect(wo, u2)?
        };
        BsdfSample::of(wi, self.eval(wo, wi))
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some(rough) = self.rough.as_ref().filter(|_| wi.z > 0.0) else {
            return (Rgb::ZERO, 0.0);
        };
        let once = rough.whole.facets.reflected(wo, wi);
        let even = cosine_hemisphere_pdf(wi.z);
        let further = rough.further * rough.whole.missing(wo, wi) * even;
        let share = self.further_share(rough, wo);
        (
            self.reflectance.at(once.cos) * once.f_cos + further,
            (1.0 - share) * once.pdf + share * even,
        )
    }

    /// How much of the light comes from more than one reflection, for sampling.
    fn further_share(&self, rough: &Rough, wo: Vec3) -> f32 {
        let once = rough.whole.albedo(wo);
        let further = rough.further.element_sum() * (1.0 - once);
        let once = self.reflectance.at(wo.z).element_sum() * once;
        if further > 0.0 {
            further / (further + once)
        } else {
            0.0
        }
    }
}

//! A matt base under a clear coat. Light enters through the coat, is scattered by the base, and what the coat throws back
//! down is scattered again: `f` of the base is `T(wo) T(wi) / (pi T)` times what the base and the coat's underside leave
//! of it, with `T` the share that the coat lets through from one direction and on average (Kelemen and Szirmay-Kalos 2001;
//! Jakob's plastic in Mitsuba is the same under a smooth coat). Light is neither won nor lost over a white base.

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::material::Fresnel;
use crate::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};

use super::BsdfSample;
use super::albedo::Coat;
use super::fresnel::{dielectric, dielectric_average};
use super::microfacet::{Microfacets, reflect_at};

#[derive(Clone, Copy, Debug)]
pub(super) struct Plastic {
    /// Albedo of the base by itself.
    pub(super) color: Rgb,
    eta: f32,
    rough: Option<(Microfacets, Coat)>,
    /// What becomes of light that has entered, in the end, over the coat's average transmission.
    base: Rgb,
}

impl Plastic {
    pub(super) fn new(color: Rgb, eta: f32, roughness: f32) -> Self {
        let facets = Microfacets::new(roughness.into());
        let rough = facets.map(|facets| (facets, Coat::new(eta, roughness)));
        let reflected = match &rough {
            Some((_, coat)) => coat.average(),
            None => dielectric_average(eta),
        };
        let enters = 1.0 - reflected;
        // Of even light from below a boundary lets through as much, over the square of the index.
        let leaves = enters / (eta * eta);
        Self {
            color,
            eta,
            rough,
            base: color * leaves / (Rgb::ONE - color * (1.0 - leaves)) / enters,
        }
    }

    /// What the coat reflects of light from one direction.
    fn coat(&self, cos: f32) -> f32 {
        match &self.rough {
            Some((_, coat)) => coat.albedo(cos),
            None => dielectric(Fresnel::Exact, cos, self.eta),
        }
    }

    /// The share of samples that go to the coat.
    fn share(&self, coat: f32) -> f32 {
        let base = (1.0 - coat) * self.base.element_sum() / 3.0;
        coat / (coat + base).max(f32::MIN_POSITIVE)
    }

    pub(super) fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        let coat = self.coat(wo.z);
        let share = self.share(coat);
        let wi = if u >= share {
            cosine_hemisphere(u2)
        } else {
            let facets = self.rough.as_ref().map(|(facets, _)| facets);
            let wi = reflect_at(facets, wo, u2)?;
            if facets.is_none() {
                let weight = Rgb::splat(coat / share);
                return Some(BsdfSample::new(wi, weight, f32::INFINITY));
            }
            wi
        };
        BsdfSample::of(wi, self.eval(wo, wi))
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let coat = self.coat(wo.z);
        let share = self.share(coat);
        let even = cosine_hemisphere_pdf(wi.z);
        let base = self.base * (1.0 - coat) * (1.0 - self.coat(wi.z)) * even;
        let pdf = (1.0 - share) * even;
        let Some((facets, _)) = &self.rough else {
            return (base, pdf);
        };
        let reflected = facets.reflected(wo, wi);
        let f = dielectric(Fresnel::Exact, reflected.cos, self.eta);
        (base + f * reflected.f_cos, pdf + share * reflected.pdf)
    }
}

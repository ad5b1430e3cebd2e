//! The surface that glTF defines, from the top: sheen, a clear coat, then a mix of metal and of a dielectric over a base
//! that is matt or lets light through.
//!
//! Where glTF leaves the joints open they are made so that light is not won and every pair of directions sees the same
//! both ways: what a layer lets through is the lesser of its shares for the two directions (as `KHR_materials_sheen`
//! has it), and the matt base lies under the dielectric as in plastic.

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::material;
use crate::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::texture::TexturePoint;

use super::BsdfSample;
use super::albedo::{Schlick, Whole};
use super::film::Film;
use super::fresnel::{cos_refracted, normal};
use super::microfacet::{Microfacets, reflect_at, refract};
use super::mirror::reflect;
use super::sheen::Sheen;

/// Facets between media as close as this would bend light by less than f32 can tell.
const LEAST_STEP: f32 = 0.01;
/// The coat's reflectance: that of index 1.5.
const COAT: Schlick = Schlick {
    f0: Rgb::splat(0.04),
    f90: Rgb::ONE,
};

#[derive(Clone, Debug)]
pub(super) struct Principled {
    pub(super) base_color: Rgb,
    metallic: f32,
    metal: Schlick,
    dielectric: Schlick,
    film: Option<Film>,
    /// At least the dielectric's reflectance under the film.
    cover: Schlick,
    facets: Option<Whole>,
    /// Colour of what the metal's facets send on to one another.
    further: Rgb,
    /// The matt base's albedo, over what the dielectric lets through on average.
    matt: Rgb,
    through: Option<Through>,
    coat: f32,
    coat_roughness: f32,
    coat_facets: Option<Microfacets>,
    sheen: Option<Sheen>,
}

/// What goes on behind the surface.
#[derive(Clone, Copy, Debug)]
struct Through {
    color: Rgb,
    /// Index on the far side over the near side's; `None` for a sheet.
    eta: Option<f32>,
}

impl Through {
    /// Whether this is the surface of a body seen from within it.
    fn is_seen_from_within(&self) -> bool {
        self.eta.is_some_and(|eta| eta < 1.0)
    }
}

/// A choice among ways to draw a direction, each with its probability.
struct Shares {
    /// In proportion to the cosine.
    even: f32,
    /// At the facets of metal and dielectric.
    facets: f32,
    /// At the coat's.
    coat: f32,
}

impl Principled {
    pub(super) fn new(of: &material::Principled, point: &TexturePoint, eta: f32) -> Self {
        let base_color = of.base_color.eval(point);
        let metallic = of.metallic.eval_share(point);
        let specular = of.specular.eval_share(point);
        let transmission = of.transmission.eval_share(point);
        let coat_roughness = of.clearcoat_roughness.eval_share(point);
        let facets = Microfacets::new(of.roughness.at(point)).map(Whole::new);
        let bounds_body = of.interior().is_some();
        let f0 = normal(if bounds_body { eta } else { of.ior }) * of.specular_color.eval(point);
        let dielectric = Schlick {
            f0: f0.min(Rgb::ONE) * specular,
            f90: Rgb::splat(specular),
        };
        let metal = Schlick {
            f0: base_color,
            f90: Rgb::ONE,
        };
        let film = Film::new(
            of.iridescence.eval_share(point),
            of.iridescence_ior,
            of.iridescence_thickness.eval_scalar(point).max(0.0),
        );
        let cover = film.map_or(dielectric, |film| film.bound(&dielectric));
        let body = (1.0 - metallic) * base_color;
        let through = (transmission * body != Rgb::ZERO).then(|| Through {
            color: transmission * body,
            eta: bounds_body.then(|| match eta - 1.0 {
                step if facets.is_none() || step.abs() >= LEAST_STEP => eta,
                step => 1.0 + LEAST_STEP.copysign(step),
            }),
        });
        let average = cover.average(facets.map_or(0.0, |f| f.facets.roughness()));
        let mut this = Self {
            base_color,
            metallic,
            metal,
            dielectric,
            film,
            cover,
            facets,
            further: facets.map_or(Rgb::ZERO, |f| {
                metallic * f.further(metal.f0 + (Rgb::ONE - metal.f0) / 21.0)
            }),
            matt: (1.0 - transmission) * body / (Rgb::ONE - average).max(Rgb::splat(1e-4)),
            through,
            coat: of.clearcoat.eval_share(point),
            coat_roughness,
            coat_facets: Microfacets::new(coat_roughness.into()),
            sheen: Sheen::new(
                of.sheen_color.eval(point),
                of.sheen_roughness.eval_share(point),
            ),
        };
        if this.inside() {
            // The layers lie on the outside; what they take from light on its way out is in `lets_through`.
            this.matt = Rgb::ZERO;
        }
        this
    }

    fn inside(&self) -> bool {
        self.through
            .is_some_and(|through| through.is_seen_from_within())
    }

    pub(super) fn facets(&self) -> Option<&Microfacets> {
        self.facets.as_ref().map(|whole| &whole.facets)
    }

    pub(super) fn transmits(&self) -> bool {
        self.through.is_some()
    }

    pub(super) fn is_smooth(&self) -> bool {
        let layers = !self.inside()
            && (self.sheen.is_some() || self.coat > 0.0 && self.coat_facets.is_some());
        layers || self.facets.is_some() || self.matt != Rgb::ZERO
    }

    /// Reflectance of the dielectric for light that meets it from this side.
    fn at_dielectric(&self, cos: f32) -> Rgb {
        // Schlick's angle is that on the outside.
        let cos = match self.through.and_then(|through| through.eta) {
            Some(eta) if eta < 1.0 => match cos_refracted(cos, eta) {
                Some(cos_t) => cos_t,
                None => return Rgb::ONE,
            },
            _ => cos,
        };
        (self.film).map_or(self.dielectric.at(cos), |film| {
            film.over(&self.dielectric, cos)
        })
    }

    /// Reflectance of metal and dielectric.
    fn at_facet(&self, cos: f32, dielectric: Rgb) -> Rgb {
        if self.metallic == 0.0 {
            return dielectric;
        }
        let metal = (self.film).map_or(self.metal.at(cos), |film| film.over(&self.metal, cos));
        self.metallic * metal + (1.0 - self.metallic) * dielectric
    }

    /// Reflectance and transmittance of a facet, and the chance of reflection.
    fn fates(&self, cos: f32) -> (Rgb, Rgb, f32) {
        let dielectric = self.at_dielectric(cos);
        let reflected = self.at_facet(cos, dielectric);
        let through = self
            .through
            .map_or(Rgb::ZERO, |through| through.color * (Rgb::ONE - dielectric));
        let sum = (reflected + through).element_sum();
        (
            reflected,
            through,
            reflected.element_sum() / sum.max(f32::MIN_POSITIVE),
        )
    }

    /// What the dielectric leaves for the matt base.
    fn enters(&self, w: Vec3) -> Rgb {
        let roughness = self.facets().map_or(0.0, Microfacets::roughness);
        Rgb::ONE - self.cover.albedo(roughness, w.z)
    }

    /// What the coat reflects.
    fn coat_albedo(&self, cos: f32) -> f32 {
        if self.coat == 0.0 {
            return 0.0;
        }
        self.coat * COAT.albedo(self.coat_roughness, cos).x
    }

    /// What sheen, and sheen and coat, let through of light that comes from outside or leaves there.
    fn lets_through(&self, outside: f32) -> [f32; 2] {
        let sheen = (self.sheen).map_or(1.0, |sheen| sheen.lets_through(outside));
        [sheen, sheen * (1.0 - self.coat_albedo(outside))]
    }

    /// What sheen, and sheen and coat, let through of light from `wi` to `wo`.
    fn both_ways(&self, wo: Vec3, wi: Vec3) -> [f32; 2] {
        match (self.inside(), wi.z > 0.0) {
            (false, true) => {
                let (a, b) = (self.lets_through(wo.z), self.lets_through(wi.z));
                [a[0].min(b[0]), a[1].min(b[1])]
            }
            (false, false) => self.lets_through(wo.z),
            (true, true) => [1.0; 2],
            (true, false) => self.lets_through(-wi.z),
        }
    }

    fn shares(&self, wo: Vec3) -> Shares {
        let (reflected, through, _) = self.fates(wo.z);
        let once = self.facets.map_or(1.0, |facets| facets.albedo(wo));
        let [sheen, below] = self.lets_through(wo.z);
        let facets = below * (reflected * once + through).element_sum();
        let matt = (self.matt * self.enters(wo) + self.further * (1.0 - once)).element_sum();
        let fibres = self
            .sheen
            .map_or(0.0, |sheen| sheen.color.element_sum() * sheen.albedo(wo.z));
        let (even, coat) = if self.inside() {
            (self.further.element_sum() * (1.0 - once), 0.0)
        } else {
            (below * matt + fibres, 3.0 * sheen * self.coat_albedo(wo.z))
        };
        let sum = (even + facets + coat).max(f32::MIN_POSITIVE);
        Shares {
            even: even / sum,
            facets: facets / sum,
            coat: coat / sum,
        }
    }

    pub(super) fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        let shares = self.shares(wo);
        if u < shares.even {
            let wi = cosine_hemisphere(u2);
            return BsdfSample::of(wi, self.eval(wo, wi));
        }
        let u = u - shares.even;
        if u >= shares.facets {
            let wi = reflect_at(self.coat_facets.as_ref(), wo, u2)?;
            if self.coat_facets.is_some() {
                return BsdfSample::of(wi, self.eval(wo, wi));
            }
            let [sheen, _] = self.both_ways(wo, wi);
            let weight = sheen * self.coat * COAT.at(wo.z) / shares.coat;
            return (shares.coat > 0.0).then(|| BsdfSample::new(wi, weight, f32::INFINITY));
        }
        self.sample_facets(wo, u / shares.facets, u2, shares.facets)
    }

    /// A direction from the facets of metal and dielectric, which were chosen with the probability `share`.
    fn sample_facets(&self, wo: Vec3, u: f32, u2: Vec2, share: f32) -> Option<BsdfSample> {
        let facets = self.facets();
        let h = facets.map_or(Vec3::Z, |facets| facets.visible_normal(wo, u2));
        let cos = wo.dot(h);
        let (reflected, through, chance) = self.fates(cos);
        let mirrored = match facets {
            Some(_) => (2.0 * cos * h - wo).normalize(),
            None => reflect(wo),
        };
        let is_reflected = u < chance;
        let eta = self.through.and_then(|through| through.eta);
        let wi = match (is_reflected, eta) {
            (true, _) => mirrored,
            // A sheet's facets act as mirrors, and what they reflect comes out behind.
            (false, None) => reflect(-mirrored),
            (false, Some(eta)) => refract(wo, h, eta, cos_refracted(cos, eta)?),
        };
        if (wi.z > 0.0) != is_reflected {
            return None;
        }
        let eta2 = match eta {
            Some(eta) if !is_reflected => eta * eta,
            _ => 1.0,
        };
        if facets.is_some() {
            let sample = BsdfSample::of(wi, self.eval(wo, wi))?;
            return Some(BsdfSample { eta2, ..sample });
        }
        let [_, below] = self.both_ways(wo, wi);
        let weight = if is_reflected {
            reflected / (share * chance)
        } else {
            through / (share * (1.0 - chance) * eta2)
        };
        let delta = BsdfSample::new(wi, below * weight, f32::INFINITY);
        Some(BsdfSample { eta2, ..delta })
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let shares = self.shares(wo);
        let [sheen, below] = self.both_ways(wo, wi);
        if wi.z <= 0.0 {
            let (f_cos, pdf) = self.eval_through(wo, wi);
            return (below * f_cos, shares.facets * pdf);
        }
        let even = cosine_hemisphere_pdf(wi.z);
        let mut f_cos = Rgb::ZERO;
        if self.matt != Rgb::ZERO {
            f_cos += self.matt * self.enters(wo) * self.enters(wi) * even;
        }
        let mut pdf = shares.even * even;
        if let Some(facets) = &self.facets {
            let once = facets.facets.reflected(wo, wi);
            let (reflected, _, chance) = self.fates(once.cos);
            f_cos += reflected * once.f_cos;
            pdf += shares.facets * chance * once.pdf;
            if self.further != Rgb::ZERO {
                f_cos += self.further * facets.missing(wo, wi) * even;
            }
        }
        f_cos *= below;
        if self.inside() {
            return (f_cos, pdf);
        }
        if let Some(facets) = self.coat_facets.as_ref().filter(|_| self.coat > 0.0) {
            let once = facets.reflected(wo, wi);
            f_cos += sheen * self.coat * COAT.at(once.cos) * once.f_cos;
            pdf += shares.coat * once.pdf;
        }
        if let Some(sheen) = &self.sheen {
            f_cos += sheen.eval(wo, wi);
        }
        (f_cos, pdf)
    }

    /// Passage through rough facets, before the layers above; the density has the facets chosen already.
    fn eval_through(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let nothing = (Rgb::ZERO, 0.0);
        let (Some(through), Some(facets)) = (self.through, self.facets()) else {
            return nothing;
        };
        let (cos, f_cos, pdf) = match through.eta {
            None => {
                let once = facets.reflected(wo, reflect(-wi));
                (once.cos, once.f_cos, once.pdf)
            }
            Some(eta) => match facets.refracted(wo, wi, eta) {
                Some(bent) => (bent.cos, bent.f_cos, bent.pdf),
                None => return nothing,
            },
        };
        let (_, through, chance) = self.fates(cos);
        (through * f_cos, (1.0 - chance) * pdf)
    }
}

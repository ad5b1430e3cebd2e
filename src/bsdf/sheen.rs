//! The sheen of fibres that stand off a surface, as `KHR_materials_sheen` defines it: Estevez and Kulla 2017,
//! "Production Friendly Microfacet Sheen BRDF".

use std::f32::consts::TAU;
use std::sync::LazyLock;

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};

use super::albedo::Table;

/// Fibres that stand up straighter than this would be seen at the very rim alone.
const LEAST_ROUGHNESS: f32 = 0.15;

#[derive(Clone, Copy, Debug)]
pub(super) struct Sheen {
    pub(super) color: Rgb,
    roughness: f32,
}

impl Sheen {
    /// `None` where there is no sheen.
    pub(super) fn new(color: Rgb, roughness: f32) -> Option<Self> {
        (color != Rgb::ZERO).then(|| Self {
            color,
            roughness: roughness.max(LEAST_ROUGHNESS),
        })
    }

    /// `f cos`, drawn evenly: in proportion to the cosine.
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.color * white(wo, wi, self.roughness)
    }

    /// The share of light from a direction that white fibres would reflect.
    pub(super) fn albedo(&self, cos: f32) -> f32 {
        FIBRES.at(0, self.roughness, cos)
    }

    /// What is left for the surface below of light that comes from or leaves to a direction.
    pub(super) fn lets_through(&self, cos: f32) -> f32 {
        1.0 - self.color.max_element() * self.albedo(cos)
    }
}

static FIBRES: LazyLock<Table> = LazyLock::new(|| {
    Table::new(1, |roughness, cos| {
        const COUNT: usize = 1024;
        let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let parts = (0..COUNT).map(|i| {
            let u = (i as f32 + 0.5) / COUNT as f32;
            let v = (i as f32 * 0.618_034).fract();
            let wi = cosine_hemisphere(Vec2::new(u, v));
            white(wo, wi, roughness.max(LEAST_ROUGHNESS)) / cosine_hemisphere_pdf(wi.z)
        });
        vec![parts.sum::<f32>() / COUNT as f32]
    })
});

/// `f cos` of white fibres.
fn white(wo: Vec3, wi: Vec3, roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    let h = (wo + wi).normalize_or(Vec3::Z);
    // The distribution, equation 2.
    let sin = (1.0 - h.z * h.z).max(0.0).sqrt();
    let d = (2.0 + 1.0 / alpha) * sin.powf(1.0 / alpha) / TAU;
    let shadowed = 1.0 + lambda(wo.z, alpha) + lambda(wi.z, alpha);
    d / (4.0 * shadowed * wo.z.max(1e-4))
}

/// Masking, fitted by the authors for alpha 0 and 1 (equation 3 and table 1).
fn lambda(cos: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let between = |rough: f32, fine: f32| rough + t * (fine - rough);
    let fit = |x: f32| {
        let a = between(21.5473, 25.3245);
        let b = between(3.82987, 3.32435);
        let c = between(0.19823, 0.16801);
        let d = between(-1.97760, -1.27393);
        let e = between(-4.32054, -4.85967);
        a / (1.0 + b * x.powf(c)) + d * x + e
    };
    if cos < 0.5 {
        fit(cos).exp()
    } else {
        (2.0 * fit(0.5) - fit(1.0 - cos)).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fibres_never_reflect_more_than_they_get() {
        for r in 0..=20 {
            let sheen = Sheen::new(Rgb::ONE, r as f32 / 20.0).unwrap();
            for c in 0..=100 {
                let albedo = sheen.albedo(c as f32 / 100.0);
                assert!((0.0..=1.0).contains(&albedo), "{r} {c}: {albedo}");
            }
        }
    }
}

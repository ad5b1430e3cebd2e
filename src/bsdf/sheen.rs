//! The sheen of fibres that stand off a surface, as `KHR_materials_sheen` defines it: Estevez and Kulla 2017,
//! "Production Friendly Microfacet Sheen BRDF".

use std::f32::consts::TAU;
use std::sync::LazyLock;

use glam::{Mat2, Vec3};

use crate::color::Rgb;

use super::albedo::{Grid, from_root, lattice};

/// Fibres that stand up straighter than this would be seen at the very rim alone.
const LEAST_ROUGHNESS: f32 = 0.15;

/// Cosines below this count as this.
const FLATTEST: f32 = 0.01;

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

    /// `f cos`, smooth enough to be drawn in proportion to the cosine. The formula alone would give more light than it
    /// gets at grazing angles.
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let excess = self.formula(wo.z).max(self.formula(wi.z)).max(1.0);
        self.color * white(wo, wi, self.roughness) / excess
    }

    /// The share of light from a direction that white fibres reflect, at most.
    pub(super) fn albedo(&self, cos: f32) -> f32 {
        self.formula(cos).min(1.0)
    }

    fn formula(&self, cos: f32) -> f32 {
        FIBRES.at([self.roughness, cos.max(0.0).sqrt()])
    }

    /// What is left for the surface below of light that comes from or leaves to a direction.
    pub(super) fn lets_through(&self, cos: f32) -> f32 {
        1.0 - self.color.max_element() * self.albedo(cos)
    }
}

/// What the formula gives in all, over roughness and the root of the cosine.
static FIBRES: LazyLock<Grid<2>> = LazyLock::new(|| {
    Grid::new([24, 40], |[roughness, root]| {
        const COUNT: usize = 1024;
        let (wo, roughness) = (from_root(root), roughness.max(LEAST_ROUGHNESS));
        // Most of it is at grazing angles: cosines are drawn as squares.
        let parts = lattice(COUNT).map(|u2| {
            let wi = Mat2::from_angle(TAU * u2.x) * from_root(u2.y).truncate();
            2.0 * TAU * u2.y * white(wo, wi.extend(u2.y * u2.y), roughness)
        });
        parts.sum::<f32>() / COUNT as f32
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
    // Towards grazing angles this grows without bound.
    d * wi.z / (4.0 * shadowed * wo.z.max(FLATTEST) * wi.z.max(FLATTEST))
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
    use crate::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};

    use super::*;

    #[test]
    fn fibres_never_reflect_more_than_they_get() {
        for r in 0..=10 {
            let sheen = Sheen::new(Rgb::ONE, r as f32 / 10.0).unwrap();
            for c in 0..=50 {
                let wo = from_root(c as f32 / 50.0);
                let parts = lattice(1 << 16).map(|u2| {
                    let wi = cosine_hemisphere(u2);
                    sheen.eval(wo, wi).x / cosine_hemisphere_pdf(wi.z)
                });
                let albedo = parts.sum::<f32>() / 65_536.0;
                let most = sheen.albedo(wo.z);
                assert!(albedo < most + 0.02, "{r} {c}: {albedo} of {most}");
                // At angles that are not grazing it is the formula's.
                assert!(
                    wo.z < 0.2 || albedo > most - 0.04,
                    "{r} {c}: {albedo} of {most}"
                );
            }
        }
    }
}

//! Rough surfaces as many small mirrors: the GGX distribution of their normals with height-correlated Smith masking
//! (Walter et al. 2007; Heitz 2014), in the shading frame, with z along the surface's normal.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Mat2, Vec2, Vec3};

use crate::material::Roughness;

use super::mirror::reflect;

/// Below this `alpha` a surface is smooth: its highlight is narrower than a tenth of a degree.
const SMOOTH: f32 = 1e-3;

/// The distribution of facets. A facet's slopes are those of a GGX surface of width 1, mapped by a matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Microfacets {
    stretch: Mat2,
    inverse: Mat2,
    /// `alpha` along the brush and across.
    widths: Vec2,
    /// Along the greater width, where there is one.
    brush: Option<Vec2>,
}

/// A reflection at facets that reflect all light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflected {
    /// Of the angle between the directions and the facet.
    pub cos: f32,
    /// `f cos`.
    pub f_cos: f32,
    /// Of [`Microfacets::reflect`].
    pub pdf: f32,
}

/// A passage through facets that let all light through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refracted {
    /// Of the angle between `wo` and the facet.
    pub cos: f32,
    /// `f cos` for radiance.
    pub f_cos: f32,
    /// Of [`refract`] at a visible normal.
    pub pdf: f32,
}

impl Microfacets {
    /// The facets of a surface, unless it is smooth.
    pub(super) fn new(roughness: Roughness<f32>) -> Option<Self> {
        let alpha = roughness.value * roughness.value;
        let along = alpha + (1.0 - alpha) * roughness.anisotropy * roughness.anisotropy;
        if along < SMOOTH {
            return None;
        }
        let widths = Vec2::new(along, alpha).max(Vec2::splat(SMOOTH));
        Some(Self::stretched(widths, roughness.rotation))
    }

    /// The same in all directions, of width `alpha`.
    pub(super) fn isotropic(alpha: f32) -> Self {
        Self::stretched(Vec2::splat(alpha), 0.0)
    }

    /// Of the greater width in the direction of `rotation`, and of the lesser across.
    pub(super) fn stretched(widths: Vec2, rotation: f32) -> Self {
        let stretch = Mat2::from_angle(rotation) * Mat2::from_diagonal(widths);
        Self {
            stretch,
            inverse: stretch.inverse(),
            widths,
            brush: (widths.x != widths.y).then(|| Vec2::from_angle(rotation)),
        }
    }

    /// `alpha` one way and across.
    pub(super) fn widths(&self) -> Vec2 {
        self.widths
    }

    /// Along the greater width; `None` where the surface looks the same when it is turned.
    pub(super) fn brush(&self) -> Option<Vec2> {
        self.brush
    }

    /// The roughness of isotropic facets with as much slope.
    pub(super) fn roughness(&self) -> f32 {
        (0.5 * self.widths.length_squared()).powf(0.25)
    }

    /// The distribution of normals: area of facets per area of surface and solid angle around `h`.
    fn d(&self, h: Vec3) -> f32 {
        let slope = self.inverse * h.truncate();
        let k = slope.length_squared() + h.z * h.z;
        FRAC_1_PI / (self.widths.element_product() * k * k)
    }

    /// `|w.z| (1 + 2 lambda)` with Smith's lambda.
    fn spread(&self, w: Vec3) -> f32 {
        let slope = self.stretch.transpose() * w.truncate();
        (slope.length_squared() + w.z * w.z).sqrt()
    }

    /// The normal of a facet, drawn from those that are seen from `wo` (Dupuy and Benyoub 2023, algorithm 3).
    pub(super) fn visible_normal(&self, wo: Vec3, u2: Vec2) -> Vec3 {
        let standard = (self.stretch.transpose() * wo.truncate())
            .extend(wo.z)
            .normalize();
        // A point of the cap of the unit sphere that reflects `standard`.
        let below = u2.y * (1.0 + standard.z);
        let z = 1.0 - below;
        let r = (below * (2.0 - below)).max(0.0).sqrt();
        let (sin, cos) = (TAU * u2.x).sin_cos();
        let h = Vec3::new(r * cos, r * sin, z) + standard;
        (self.stretch * h.truncate()).extend(h.z).normalize()
    }

    /// A direction in which facets reflect `wo`; `None` where the next facet is in the way.
    pub(super) fn reflect(&self, wo: Vec3, u2: Vec2) -> Option<Vec3> {
        let h = self.visible_normal(wo, u2);
        let wi = 2.0 * wo.dot(h) * h - wo;
        (wi.z > 0.0).then(|| wi.normalize())
    }

    /// Reflection from `wi` to `wo`, both above the surface.
    pub(super) fn reflected(&self, wo: Vec3, wi: Vec3) -> Reflected {
        let h = (wo + wi).normalize_or(Vec3::Z);
        let (so, si) = (self.spread(wo), self.spread(wi));
        let d = self.d(h);
        Reflected {
            cos: wo.dot(h).clamp(0.0, 1.0),
            // D G2 / (4 cos) and D G1 / (4 cos), each with the fraction of G reduced.
            f_cos: 0.5 * d * wi.z / (so * wi.z + si * wo.z),
            pdf: 0.5 * d / (wo.z + so),
        }
    }

    /// Passage from `wi` below the surface, where the index is `eta` times as high, to `wo` above; `None` where
    /// no facet bends light that way. (Walter et al. 2007, sections 4.2 and 5.2.)
    pub(super) fn refracted(&self, wo: Vec3, wi: Vec3, eta: f32) -> Option<Refracted> {
        let h = (wo + eta * wi).try_normalize()?;
        let h = if h.z < 0.0 { -h } else { h };
        let (cos_o, cos_i) = (wo.dot(h), -wi.dot(h));
        if cos_o <= 0.0 || cos_i <= 0.0 {
            return None;
        }
        let (so, si) = (self.spread(wo), self.spread(wi));
        let jacobian = cos_i / (cos_o - eta * cos_i).powi(2);
        let d = 2.0 * self.d(h) * cos_o * jacobian;
        let below = -wi.z;
        Some(Refracted {
            cos: cos_o,
            f_cos: d * below / (so * below + si * wo.z),
            pdf: eta * eta * d / (wo.z + so),
        })
    }
}

/// `wo` bent at a facet `h` on its way to the far side, where the index is `eta` times as high.
pub(super) fn refract(wo: Vec3, h: Vec3, eta: f32, cos_t: f32) -> Vec3 {
    let cos = wo.dot(h);
    ((cos / eta - cos_t) * h - wo / eta).normalize()
}

/// Facets and a mirror alike: a direction in which `wo` is reflected.
pub(super) fn reflect_at(facets: Option<&Microfacets>, wo: Vec3, u2: Vec2) -> Option<Vec3> {
    match facets {
        Some(facets) => facets.reflect(wo, u2),
        None => Some(reflect(wo)),
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    fn all() -> Vec<Microfacets> {
        let rough = |value, anisotropy, rotation| {
            Microfacets::new(Roughness {
                value,
                anisotropy,
                rotation,
            })
            .unwrap()
        };
        vec![
            rough(0.3, 0.0, 0.0),
            rough(0.6, 0.0, 1.0),
            rough(0.4, 0.7, 0.5),
            rough(1.0, 0.0, 0.0),
        ]
    }

    /// Sum of `f` over the upper hemisphere by the midpoint rule.
    fn hemisphere(f: impl Fn(Vec3) -> f32) -> f64 {
        let (rows, columns) = (1000, 500);
        let mut sum = 0.0;
        for i in 0..rows {
            // Fine where a narrow distribution has its peak.
            let theta = 0.5 * PI * ((i as f32 + 0.5) / rows as f32).powi(2);
            let width = PI * (i as f32 + 0.5) / (rows * rows) as f32;
            for j in 0..columns {
                let phi = TAU * (j as f32 + 0.5) / columns as f32;
                let w = Vec3::new(
                    theta.sin() * phi.cos(),
                    theta.sin() * phi.sin(),
                    theta.cos(),
                );
                let cell = theta.sin() * width * TAU / columns as f32;
                sum += f64::from(f(w) * cell);
            }
        }
        sum
    }

    #[test]
    fn facets_cover_the_surface_once_seen_from_anywhere() {
        // Heitz 2014, equations 2 and 14: projected areas agree along the normal and along any direction.
        for facets in all() {
            let area = hemisphere(|h| facets.d(h) * h.z);
            assert!((area - 1.0).abs() < 1e-3, "{area}");
            for wo in [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.3, -0.9, 0.2)] {
                let wo = wo.normalize();
                let masking = 2.0 * wo.z / (wo.z + facets.spread(wo));
                let seen = hemisphere(|h| masking * facets.d(h) * wo.dot(h).max(0.0));
                let expected = f64::from(wo.z);
                assert!((seen - expected).abs() < 2e-3 * expected, "{seen}");
            }
        }
    }

    #[test]
    fn snell_and_fresnel_agree_on_the_facet() {
        let facets = Microfacets::isotropic(0.2);
        let wo = Vec3::new(0.5, 0.1, 0.7).normalize();
        for eta in [1.5, 1.0 / 1.5] {
            let h = facets.visible_normal(wo, Vec2::new(0.3, 0.4));
            let cos_t = super::super::fresnel::cos_refracted(wo.dot(h), eta).unwrap();
            let wi = refract(wo, h, eta, cos_t);
            assert!((wo.cross(h) + eta * wi.cross(h)).length() < 1e-6);
            let refracted = facets.refracted(wo, wi, eta).unwrap();
            assert!((refracted.cos - wo.dot(h)).abs() < 1e-5);
        }
    }
}

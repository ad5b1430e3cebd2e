//! How much light a boundary reflects. `eta` is the index on the far side over the near side's.

use crate::color::Rgb;
use crate::material::{Fresnel, Metal};

/// Cosine on the far side by Snell's law; `None` for total internal reflection.
pub(super) fn cos_refracted(cos_i: f32, eta: f32) -> Option<f32> {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    (sin2_t < 1.0).then(|| (1.0 - sin2_t).sqrt())
}

/// Reflectance of the boundary between two clear media; 1 for total internal reflection.
pub(super) fn dielectric(fresnel: Fresnel, cos_i: f32, eta: f32) -> f32 {
    let Some(cos_t) = cos_refracted(cos_i, eta) else {
        return 1.0;
    };
    match fresnel {
        // Between equal media there is no boundary; Schlick's formula has one.
        _ if eta == 1.0 => 0.0,
        Fresnel::None => 0.0,
        Fresnel::Schlick => {
            // Schlick 1994, equation 15; the angle is the one in the thinner medium.
            let cos = if eta > 1.0 { cos_i } else { cos_t };
            let k0 = normal(eta);
            k0 + (1.0 - k0) * edge(cos)
        }
        Fresnel::Exact => {
            // Fresnel's equations, the mean of both polarisations.
            let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
            let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
            0.5 * (parallel * parallel + perpendicular * perpendicular)
        }
    }
}

/// Reflectance of a dielectric at normal incidence.
pub(super) fn normal(eta: f32) -> f32 {
    ((1.0 - eta) / (1.0 + eta)).powi(2)
}

/// Fresnel's reflectance averaged over the hemisphere, weighted by the cosine, for `eta` of at least 1
/// (Duntley 1942; Egan and Hilgeman 1979, equation 5.1).
pub(super) fn dielectric_average(eta: f32) -> f32 {
    // Near 1 the terms are much larger than their sum, which is below 2e-3 there.
    if eta < 1.02 {
        return 0.0;
    }
    let n = f64::from(eta);
    let (n2, n4) = (n * n, n.powi(4));
    let sum = 0.5
        + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
        + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln();
    sum as f32
}

/// Schlick's falloff, `(1 - cos)^5`.
pub(super) fn edge(cos: f32) -> f32 {
    (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

/// The reflectance of what lets nothing through.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reflectance {
    /// The same under all angles.
    Constant(Rgb),
    /// Schlick's approximation: `f0` at normal incidence, 1 at grazing angles.
    Schlick(Rgb),
    /// Fresnel's equations.
    Metal(Metal),
}

impl Reflectance {
    /// For light that meets the surface, or a facet of it, under an angle of cosine `cos`.
    pub(super) fn at(&self, cos: f32) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            Self::Schlick(f0) => *f0 + (Rgb::ONE - *f0) * edge(cos),
            Self::Metal(metal) => metal.reflectance(cos),
        }
    }

    /// Averaged over the hemisphere, weighted by the cosine.
    pub(super) fn average(&self) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            // The falloff's average is 2 ∫ (1 - c)^5 c dc.
            Self::Schlick(f0) => *f0 + (Rgb::ONE - *f0) / 21.0,
            Self::Metal(metal) => metal.average(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectance_has_its_known_values() {
        // Normal incidence ((n-1)/(n+1))², Brewster's angle without the parallel part, grazing 1.
        for fresnel in [Fresnel::Exact, Fresnel::Schlick] {
            assert!((dielectric(fresnel, 1.0, 1.5) - 0.04).abs() < 1e-6);
            assert!((dielectric(fresnel, 1e-4, 1.5) - 1.0).abs() < 2e-3);
        }
        let brewster = 1.5_f32.atan().cos();
        let perpendicular = ((1.0 - 2.25) / (1.0 + 2.25_f32)).powi(2);
        let r = dielectric(Fresnel::Exact, brewster, 1.5);
        assert!((r - 0.5 * perpendicular).abs() < 1e-6);
        assert_eq!(cos_refracted(0.5, 1.0 / 1.5), None);
        assert_eq!(dielectric(Fresnel::Exact, 0.5, 1.0 / 1.5), 1.0);
        for fresnel in [Fresnel::Exact, Fresnel::Schlick] {
            assert_eq!(dielectric(fresnel, 1e-3, 1.0), 0.0, "no boundary");
        }
    }

    /// Twice the integral of `f` times the cosine.
    fn average(f: impl Fn(f32) -> f32) -> f32 {
        let count = 20_000;
        let parts = (0..count).map(|i| {
            let cos = (i as f32 + 0.5) / count as f32;
            f64::from(2.0 * cos * f(cos)) / f64::from(count)
        });
        parts.sum::<f64>() as f32
    }

    #[test]
    fn averages_are_the_integrals() {
        for eta in [1.021, 1.1, 1.33, 1.5, 2.4, 3.0] {
            let expected = average(|cos| dielectric(Fresnel::Exact, cos, eta));
            let found = dielectric_average(eta);
            assert!((found - expected).abs() < 2e-4, "{eta}: {found} {expected}");
        }
        let schlick = Reflectance::Schlick(Rgb::splat(0.2));
        let expected = average(|cos| schlick.at(cos).x);
        assert!((schlick.average().x - expected).abs() < 1e-5);
    }
}

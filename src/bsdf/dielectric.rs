//! A smooth boundary between two clear media. `eta` is the index on the far side over the near side's.

use glam::Vec3;

use crate::material::Fresnel;

use super::mirror::reflect;

/// One of the two directions that light takes at the boundary.
pub(super) struct Scattered {
    pub wi: Vec3,
    pub transmitted: bool,
}

/// Reflects with the probability of the reflectance, else refracts (`wo.z > 0`).
pub(super) fn sample(wo: Vec3, eta: f32, fresnel: Fresnel, u: f32) -> Scattered {
    let cos_t = cos_refracted(wo.z, eta);
    match cos_t {
        Some(cos_t) if u >= reflectance(wo.z, cos_t, eta, fresnel) => Scattered {
            wi: Vec3::new(-wo.x / eta, -wo.y / eta, -cos_t).normalize(),
            transmitted: true,
        },
        _ => Scattered {
            wi: reflect(wo),
            transmitted: false,
        },
    }
}

/// Cosine on the far side by Snell's law; `None` for total internal reflection.
fn cos_refracted(cos_i: f32, eta: f32) -> Option<f32> {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    (sin2_t < 1.0).then(|| (1.0 - sin2_t).sqrt())
}

fn reflectance(cos_i: f32, cos_t: f32, eta: f32, fresnel: Fresnel) -> f32 {
    match fresnel {
        // Between equal media there is no boundary; Schlick's formula has one.
        _ if eta == 1.0 => 0.0,
        Fresnel::None => 0.0,
        Fresnel::Schlick => {
            // Schlick 1994, equation 15; the angle is the one in the thinner medium.
            let k0 = ((1.0 - eta) / (1.0 + eta)).powi(2);
            let cos = if eta > 1.0 { cos_i } else { cos_t };
            k0 + (1.0 - k0) * (1.0 - cos).powi(5)
        }
        Fresnel::Exact => {
            // Fresnel's equations, the mean of both polarisations.
            let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
            let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
            0.5 * (parallel * parallel + perpendicular * perpendicular)
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
            assert!((reflectance(1.0, 1.0, 1.5, fresnel) - 0.04).abs() < 1e-6);
            let grazing = reflectance(1e-4, cos_refracted(1e-4, 1.5).unwrap(), 1.5, fresnel);
            assert!((grazing - 1.0).abs() < 2e-3);
        }
        let brewster = 1.5_f32.atan().cos();
        let perpendicular = ((1.0 - 2.25) / (1.0 + 2.25_f32)).powi(2);
        let r = reflectance(
            brewster,
            cos_refracted(brewster, 1.5).unwrap(),
            1.5,
            Fresnel::Exact,
        );
        assert!((r - 0.5 * perpendicular).abs() < 1e-6);
        assert_eq!(cos_refracted(0.5, 1.0 / 1.5), None);
        for fresnel in [Fresnel::Exact, Fresnel::Schlick] {
            assert_eq!(reflectance(1e-3, 1e-3, 1.0, fresnel), 0.0, "no boundary");
        }
    }

    #[test]
    fn refraction_obeys_snell() {
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let out = sample(wo, 1.5, Fresnel::None, 0.5);
        assert!(out.transmitted);
        assert!((-out.wi.x * 1.5 - wo.x).abs() < 1e-6 && out.wi.z < 0.0);
    }
}

//! A film about as thin as a wavelength: Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the
//! Modeling of Varying Iridescence", as `KHR_materials_iridescence` uses it.

use std::f32::consts::{PI, TAU};

use glam::{Mat3, Vec3};

use crate::color::Rgb;
use crate::material::Fresnel;

use super::albedo::Schlick;
use super::fresnel::{dielectric, edge, normal};

#[derive(Clone, Copy, Debug)]
pub(super) struct Film {
    /// How much of its reflectance replaces the base's.
    strength: f32,
    ior: f32,
    /// In metres.
    thickness: f32,
}

impl Film {
    /// A film of `thickness` nanometres; `None` where there is none.
    pub(super) fn new(strength: f32, ior: f32, thickness: f32) -> Option<Self> {
        // A film much thinner than any wavelength cannot be seen.
        let t = (thickness / 0.03).clamp(0.0, 1.0);
        let ior = 1.0 + (ior - 1.0) * t * t * (3.0 - 2.0 * t);
        (strength > 0.0).then_some(Self {
            strength,
            ior,
            thickness: 1e-9 * thickness,
        })
    }

    /// The reflectance of `base` under the film for light that comes under an angle of cosine `cos`.
    pub(super) fn over(&self, base: &Schlick, cos: f32) -> Rgb {
        let bare = base.at(cos);
        bare + self.strength * (self.reflectance(base.f0, cos) - bare)
    }

    /// A reflectance of Schlick's form that is nowhere below that of `base` under the film, by more than 0.03.
    pub(super) fn bound(&self, base: &Schlick) -> Schlick {
        let f90 = base.f90.max(Rgb::splat(self.strength));
        let f0 = (1..=10).map(|i| {
            let cos = i as f32 / 10.0;
            (self.over(base, cos) - f90 * edge(cos)) / (1.0 - edge(cos))
        });
        Schlick {
            f0: f0.fold(Rgb::ZERO, Rgb::max).min(f90),
            f90,
        }
    }

    /// Of a full film over a base that reflects `base` at normal incidence.
    fn reflectance(&self, base: Rgb, cos: f32) -> Rgb {
        let below = (1.0 - (1.0 - cos * cos) / (self.ior * self.ior)).sqrt();
        let schlick = |f0: f32, cos: f32| f0 + (1.0 - f0) * edge(cos);
        let first = dielectric(Fresnel::Exact, cos, self.ior);
        let through = 1.0 - first;
        // The base's index against air, and its reflectance and phase against the film.
        let root = base.clamp(Rgb::ZERO, Rgb::splat(0.9999)).powf(0.5);
        let index = (Rgb::ONE + root) / (Rgb::ONE - root);
        let second = Rgb::from_array(
            index
                .to_array()
                .map(|n| schlick(normal(n / self.ior), below)),
        );
        let turned = index
            .to_array()
            .map(|n| if n < self.ior { PI } else { 0.0 });
        let shift = Rgb::from_array(turned) + PI;
        let path = 2.0 * self.ior * self.thickness * below;
        // Reflections to and fro add up by their phase: the mean, and two orders of the wave.
        let both = (first * second).clamp(Rgb::splat(1e-5), Rgb::splat(0.9999));
        let mean = through * through * second / (Rgb::ONE - both);
        let order = both.powf(0.5);
        let mut amplitude = mean - through;
        let mut sum = first + mean;
        for m in [1.0, 2.0] {
            amplitude *= order;
            sum += 2.0 * amplitude * wave(m * path, m * shift);
        }
        sum.clamp(Rgb::ZERO, Rgb::ONE)
    }
}

/// What eyes make of `cos(2 pi path / wavelength + shift)`, as linear RGB (Belcour and Barla's supplemental material).
fn wave(path: f32, shift: Vec3) -> Rgb {
    const HEIGHT: Vec3 = Vec3::new(5.4856e-13, 4.4201e-13, 5.2481e-13);
    const CENTER: Vec3 = Vec3::new(1.6810e6, 1.7953e6, 2.2084e6);
    const VARIANCE: Vec3 = Vec3::new(4.3278e9, 9.3046e9, 6.6121e9);
    const WHITE: f32 = 1.0685e-7;
    let rgb_from_xyz = Mat3::from_cols(
        Vec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
        Vec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
        Vec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
    );
    let phase = TAU * path;
    let lobe = |height: f32, center: f32, variance: f32, shift: f32| {
        let fades = (-phase * phase * variance).exp();
        height * (TAU * variance).sqrt() * (center * phase + shift).cos() * fades
    };
    let mut xyz = Vec3::ZERO;
    for c in 0..3 {
        xyz[c] = lobe(HEIGHT[c], CENTER[c], VARIANCE[c], shift[c]);
    }
    // Red has a second response in the blue.
    xyz.x += lobe(9.7470e-14, 2.2399e6, 4.5282e9, shift.x);
    rgb_from_xyz * xyz / WHITE
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Airy's formula for one wavelength, at normal incidence.
    fn airy(wavelength: f64, ior: f64, thickness: f64, base: f64) -> f64 {
        let (a, b) = ((1.0 - ior) / (1.0 + ior), (ior - base) / (ior + base));
        let cos = (4.0 * std::f64::consts::PI * ior * thickness / wavelength).cos();
        (a * a + b * b + 2.0 * a * b * cos) / (1.0 + a * a * b * b + 2.0 * a * b * cos)
    }

    #[test]
    fn colours_are_those_of_interference() {
        // Against a spectrum of Airy's reflectances, each channel over a band: films up to a wavelength or so.
        let bands = [(600.0, 660.0), (520.0, 570.0), (440.0, 475.0)];
        let base = 2.2_f64;
        let f0 = Rgb::splat(((base - 1.0) / (base + 1.0)).powi(2) as f32);
        for thickness in [80.0, 150.0, 220.0, 300.0] {
            let film = Film::new(1.0, 1.4, thickness as f32).unwrap();
            let found = film.reflectance(f0, 1.0);
            for (c, (from, to)) in bands.into_iter().enumerate() {
                let values = (0..50).map(|i| {
                    let wavelength = from + (to - from) * f64::from(i) / 49.0;
                    airy(1e-9 * wavelength, 1.4, 1e-9 * thickness, base) / 50.0
                });
                let expected = values.sum::<f64>() as f32;
                println!("{thickness} {c}: {} {expected}", found[c]);
                assert!((found[c] - expected).abs() < 0.06, "{thickness} {c}");
            }
        }
    }

    #[test]
    fn a_film_of_no_thickness_changes_nothing() {
        let base = Schlick {
            f0: Rgb::new(0.04, 0.3, 0.9),
            f90: Rgb::ONE,
        };
        let film = Film::new(1.0, 1.8, 0.0).unwrap();
        for i in 0..=10 {
            let cos = i as f32 / 10.0;
            let (found, bare) = (film.over(&base, cos), base.at(cos));
            assert!((found - bare).abs().max_element() < 0.01, "{found} {bare}");
        }
    }

    #[test]
    fn the_bound_is_one() {
        for thickness in [100.0, 250.0, 400.0, 700.0] {
            for f0 in [0.02, 0.04, 0.2, 0.8] {
                let base = Schlick {
                    f0: Rgb::splat(f0),
                    f90: Rgb::ONE,
                };
                let film = Film::new(0.8, 1.5, thickness).unwrap();
                let bound = film.bound(&base);
                for i in 0..=100 {
                    let cos = i as f32 / 100.0;
                    let above = film.over(&base, cos) - bound.at(cos);
                    assert!(
                        above.max_element() < 0.03,
                        "{thickness} {f0} {cos}: {above}"
                    );
                }
            }
        }
    }
}

use crate::color::Rgb;

/// A metal's complex index of refraction `eta + i k` for each channel, against air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    eta: Rgb,
    k: Rgb,
    average: Rgb,
}

/// What is known by name. The spectra are Johnson and Christy's (gold, silver and copper: Phys. Rev. B 6, 4370, 1972;
/// chromium, iron, nickel and titanium: Phys. Rev. B 9, 5056, 1974) and Rakić's (aluminium: Appl. Opt. 34, 4755, 1995).
///
/// Fresnel's reflectance of each wavelength was integrated against linear sRGB's response to daylight D65 (colour
/// matching functions by Wyman, Sloan and Shirley 2013), at normal incidence and averaged over the hemisphere; a
/// channel's `eta` and `k` are those that reflect the same. Gold's red, which lies outside of sRGB, and silver, of which the
/// two hardly differ, have the average of the spectrum's `eta` and `k` over the response.
const KNOWN: [(&str, [f32; 3], [f32; 3]); 10] = [
    ("gold", [0.063, 0.490, 1.486], [3.601, 2.242, 1.781]),
    ("silver", [0.056, 0.055, 0.043], [4.354, 3.535, 2.567]),
    ("copper", [0.268, 1.045, 1.302], [3.687, 2.632, 2.366]),
    ("aluminium", ALUMINIUM[0], ALUMINIUM[1]),
    ("aluminum", ALUMINIUM[0], ALUMINIUM[1]),
    ("iron", [2.929, 2.929, 2.553], [3.076, 2.939, 2.751]),
    ("chromium", CHROMIUM[0], CHROMIUM[1]),
    ("chrome", CHROMIUM[0], CHROMIUM[1]),
    ("nickel", [2.052, 1.912, 1.736], [4.209, 3.580, 2.900]),
    ("titanium", [2.766, 2.516, 2.249], [3.847, 3.402, 3.018]),
];
const ALUMINIUM: [[f32; 3]; 2] = [[1.504, 0.991, 0.608], [7.666, 6.566, 5.360]];
const CHROMIUM: [[f32; 3]; 2] = [[3.250, 3.129, 2.292], [3.286, 3.338, 3.119]];

/// Gauss and Legendre's points and weights on 0..=1.
const POINTS: [(f32, f32); 4] = [
    (0.069_431_84, 0.173_927_42),
    (0.330_009_5, 0.326_072_58),
    (0.669_990_5, 0.326_072_58),
    (0.930_568_16, 0.173_927_42),
];

impl Metal {
    /// The metal of refractive index `eta` and extinction `k`.
    pub fn new(eta: Rgb, k: Rgb) -> Self {
        let unknown = Self {
            eta,
            k,
            average: Rgb::ZERO,
        };
        // The integral of 2 F cos.
        let parts = POINTS.map(|(cos, w)| 2.0 * w * cos * unknown.reflectance(cos));
        Self {
            average: parts.iter().sum(),
            ..unknown
        }
    }

    /// A metal by its English name.
    pub fn named(name: &str) -> Option<Self> {
        let found = KNOWN.iter().find(|(known, ..)| *known == name);
        found.map(|(_, eta, k)| Self::new(Rgb::from_array(*eta), Rgb::from_array(*k)))
    }

    /// The names of the metals that are known.
    pub fn names() -> impl Iterator<Item = &'static str> {
        KNOWN.iter().map(|(name, ..)| *name)
    }

    /// Fresnel's reflectance for unpolarised light that meets the metal under an angle of cosine `cos`
    /// (Born and Wolf, Principles of Optics, section 14.2).
    pub fn reflectance(&self, cos: f32) -> Rgb {
        let channel = |c: usize| reflectance(cos, self.eta[c], self.k[c]);
        Rgb::new(channel(0), channel(1), channel(2))
    }

    /// The reflectance averaged over the hemisphere, weighted by the cosine.
    pub fn average(&self) -> Rgb {
        self.average
    }
}

/// With `n² = eta² - k² - sin²` and `m = 2 eta k` the refracted ray's squared normal component is `n² + i m`.
fn reflectance(cos: f32, eta: f32, k: f32) -> f32 {
    let cos2 = cos * cos;
    let sin2 = 1.0 - cos2;
    let real = eta * eta - k * k - sin2;
    let size = real.hypot(2.0 * eta * k);
    let a = (0.5 * (size + real)).max(0.0).sqrt();
    let (sum, cross) = (size + cos2, 2.0 * a * cos);
    let perpendicular = (sum - cross) / (sum + cross);
    let (sum, cross) = (cos2 * size + sin2 * sin2, cross * sin2);
    let ratio = (sum - cross) / (sum + cross);
    // At grazing angles both are 0.
    0.5 * perpendicular * (1.0 + if ratio.is_nan() { 1.0 } else { ratio })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reflectance by complex arithmetic, straight from the definition.
    fn by_definition(cos: f64, eta: f64, k: f64) -> f64 {
        type C = (f64, f64);
        let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let abs2 = |a: C| a.0 * a.0 + a.1 * a.1;
        let n2 = mul((eta, k), (eta, k));
        let z2: C = (n2.0 - (1.0 - cos * cos), n2.1);
        let r = abs2(z2).sqrt();
        let z: C = ((0.5 * (r + z2.0)).sqrt(), (0.5 * (r - z2.0)).sqrt());
        let s = abs2((cos - z.0, -z.1)) / abs2((cos + z.0, z.1));
        let n2cos = (n2.0 * cos, n2.1 * cos);
        let p = abs2((n2cos.0 - z.0, n2cos.1 - z.1)) / abs2((n2cos.0 + z.0, n2cos.1 + z.1));
        0.5 * (s + p)
    }

    #[test]
    fn reflectance_is_that_of_complex_arithmetic() {
        for (_, eta, k) in KNOWN {
            let metal = Metal::new(Rgb::from_array(eta), Rgb::from_array(k));
            let mut average = 0.0;
            for i in 0..2000 {
                let cos = (f64::from(i) + 0.5) / 2000.0;
                let found = metal.reflectance(cos as f32);
                for c in 0..3 {
                    let expected = by_definition(cos, f64::from(eta[c]), f64::from(k[c]));
                    assert!((f64::from(found[c]) - expected).abs() < 1e-5);
                }
                average += 2.0 * cos * f64::from(found.x) / 2000.0;
            }
            assert!((average - f64::from(metal.average().x)).abs() < 2e-3);
        }
        assert!((Metal::named("gold").unwrap().reflectance(0.0) - 1.0).length() < 1e-6);
        // Without extinction it is a dielectric: 0.04 for glass.
        let glass = Metal::new(Rgb::splat(1.5), Rgb::ZERO).reflectance(1.0);
        assert!((glass - 0.04).length() < 1e-6);
    }

    #[test]
    fn metals_have_their_published_colours() {
        // Linear sRGB at normal incidence as tables for artists give it, from other measurements of the same metals:
        // these differ by a few hundredths, iron and titanium by more.
        let published = [
            ("gold", [1.000, 0.766, 0.336], 0.04),
            ("silver", [0.972, 0.960, 0.915], 0.07),
            ("copper", [0.955, 0.638, 0.538], 0.03),
            ("aluminium", [0.913, 0.921, 0.925], 0.01),
            ("iron", [0.560, 0.570, 0.580], 0.09),
            ("chrome", [0.550, 0.556, 0.554], 0.01),
            ("nickel", [0.660, 0.609, 0.526], 0.04),
            ("titanium", [0.542, 0.497, 0.449], 0.1),
        ];
        for (name, color, tolerance) in published {
            let found = Metal::named(name).unwrap().reflectance(1.0);
            let error = (found - Rgb::from_array(color)).abs().max_element();
            assert!(error < tolerance, "{name}: {found}");
        }
        assert_eq!(Metal::named("cheese"), None);
        assert!(Metal::names().all(|name| Metal::named(name).is_some()));
    }
}

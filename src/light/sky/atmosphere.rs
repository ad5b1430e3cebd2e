//! Light in the air around a planet: Hillaire 2020, "A Scalable and Production Ready Sky and Atmosphere Rendering
//! Technique", with Bruneton's air (2017, "Precomputed Atmospheric Scattering: a New Implementation"), at 680, 550 and
//! 440 nm for red, green and blue. Lengths are in km.

use std::f32::consts::PI;

use glam::DVec3;

use crate::color::Rgb;
use crate::sampling::uniform_sphere;
use crate::texture::{Bitmap, Wrap, bilinear};

/// Where the ground is, from the planet's middle.
pub(super) const GROUND: f64 = 6360.0;
/// Where the air ends.
const TOP: f64 = 6460.0;
/// From the horizon of the ground to the top.
const FARTHEST: f64 = 1132.254388;

/// What air scatters at the ground, by km.
const RAYLEIGH: Rgb = Rgb::new(5.802e-3, 13.558e-3, 33.1e-3);
/// What ozone absorbs where it is densest, by km.
const OZONE: Rgb = Rgb::new(0.650e-3, 1.881e-3, 0.085e-3);
/// Heights by which air and haze thin out to 1/e.
const AIR_HEIGHT: f64 = 8.0;
const HAZE_HEIGHT: f64 = 1.2;
/// The share of light that haze scatters and does not absorb, and the mean cosine by which it does.
const HAZE_ALBEDO: f32 = 0.9;
const HAZE_FORWARD: f32 = 0.8;

/// Steps of a ray, closer together near its start.
const STEPS: u32 = 64;
const TRANSMITTANCE_SIZE: (usize, usize) = (256, 64);
const SCATTERED_SIZE: (usize, usize) = (32, 16);

/// The air of one day, lit by a sun that would shed an irradiance of 1 if there were none.
pub(super) struct Atmosphere {
    /// What haze takes away at the ground, by km.
    haze: Rgb,
    ground: Rgb,
    /// What is left of light between a point and the top: by the distance to the top and by height.
    transmittance: Bitmap,
    /// Radiance that arrives from all sides, on average, after two scatterings or more: by the cosine of the sun's zenith
    /// angle and by height.
    scattered: Bitmap,
}

/// Air at some height; all by km.
struct Air {
    rayleigh: Rgb,
    haze: Rgb,
    extinction: Rgb,
}

/// What comes along a ray.
struct Gathered {
    light: Rgb,
    /// What is left of light from its end.
    left: Rgb,
    /// The point of the ground where it ends.
    ground: Option<DVec3>,
}

impl Atmosphere {
    /// `turbidity` is that of Preetham, Shirley and Smits 1999, whose appendix A.1 gives the optical depth of its haze.
    pub(super) fn new(turbidity: f64, ground: Rgb) -> Self {
        let depth = (0.046_08 * turbidity - 0.045_86).max(0.0);
        let of_wave = |micrometres: f64| (depth * micrometres.powf(-1.3) / HAZE_HEIGHT) as f32;
        let mut atmosphere = Self {
            haze: Rgb::new(of_wave(0.68), of_wave(0.55), of_wave(0.44)),
            ground,
            transmittance: table(TRANSMITTANCE_SIZE, |_, _| Rgb::ONE),
            scattered: table(SCATTERED_SIZE, |_, _| Rgb::ZERO),
        };
        let transmittance = table(TRANSMITTANCE_SIZE, |x, y| {
            let rho = y * FARTHEST;
            let r = rho.hypot(GROUND);
            let (nearest, farthest) = (TOP - r, rho + FARTHEST);
            let d = nearest + x * (farthest - nearest);
            let cos = (FARTHEST * FARTHEST - rho * rho - d * d) / (2.0 * r * d);
            let direction = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), cos.min(1.0), 0.0);
            atmosphere
                .along(r * DVec3::Y, direction, d, |_, _| Rgb::ZERO)
                .left
        });
        atmosphere.transmittance = transmittance;
        let scattered = table(SCATTERED_SIZE, |x, y| {
            let cos = 2.0 * x - 1.0;
            let sun = DVec3::new((1.0 - cos * cos).sqrt(), cos, 0.0);
            atmosphere.scattered_at((GROUND + y * y * (TOP - GROUND)) * DVec3::Y, sun)
        });
        atmosphere.scattered = scattered;
        atmosphere
    }

    fn air(&self, height: f64) -> Air {
        let density = |scale: f64| (-height / scale).exp() as f32;
        let (rayleigh, haze) = (
            RAYLEIGH * density(AIR_HEIGHT),
            self.haze * density(HAZE_HEIGHT),
        );
        let ozone = (1.0 - (height - 25.0).abs() / 15.0).max(0.0) as f32;
        Air {
            rayleigh,
            haze: HAZE_ALBEDO * haze,
            extinction: rayleigh + haze + OZONE * ozone,
        }
    }

    /// What is left of sunlight at `p`.
    pub(super) fn sunlight(&self, p: DVec3, sun: DVec3) -> Rgb {
        let r = p.length().max(GROUND);
        let along = p.dot(sun);
        let (rho2, beside2) = (r * r - GROUND * GROUND, r * r - along * along);
        if along < 0.0 && beside2 < GROUND * GROUND {
            return Rgb::ZERO;
        }
        let d = -along + (TOP * TOP - beside2).max(0.0).sqrt();
        let rho = rho2.sqrt();
        let nearest = TOP - r;
        let x = (d - nearest) / (rho + FARTHEST - nearest);
        look_up(&self.transmittance, x, rho / FARTHEST)
    }

    /// What air sends to `from` out of a unit direction, of the sun's light.
    pub(super) fn glow(&self, from: DVec3, direction: DVec3, sun: DVec3) -> Rgb {
        let cos = direction.dot(sun) as f32;
        let (rayleigh, haze) = (rayleigh_phase(cos), haze_phase(cos));
        self.until_its_end(from, direction, |p, air| {
            let once = air.rayleigh * rayleigh + air.haze * haze;
            let height = (p.length() - GROUND) / (TOP - GROUND);
            let x = 0.5 * (1.0 + p.dot(sun) / p.length());
            let scattered = look_up(&self.scattered, x, height.max(0.0).sqrt());
            once * self.sunlight(p, sun) + (air.rayleigh + air.haze) * scattered
        })
        .light
    }

    /// The light that ground at `p` sends out, of the sun's alone.
    fn bounced(&self, p: DVec3, sun: DVec3) -> Rgb {
        let cos = (p.dot(sun) / GROUND).max(0.0) as f32;
        self.ground * self.sunlight(p, sun) * cos / PI
    }

    /// Hillaire's closed form of all that is scattered more than once (section 5.5): the second time is integrated, and
    /// those after it have the same shape, each the share of the one before that a unit of light from everywhere has.
    fn scattered_at(&self, p: DVec3, sun: DVec3) -> Rgb {
        const SIDE: u16 = 8;
        let (mut second, mut share) = (Rgb::ZERO, Rgb::ZERO);
        for i in 0..SIDE * SIDE {
            let u2 = glam::Vec2::new(f32::from(i % SIDE) + 0.5, f32::from(i / SIDE) + 0.5);
            let direction = uniform_sphere(u2 / f32::from(SIDE)).as_dvec3().normalize();
            let once = self.until_its_end(p, direction, |p, air| {
                (air.rayleigh + air.haze) * self.sunlight(p, sun) / (4.0 * PI)
            });
            let bounced = once.ground.map_or(Rgb::ZERO, |p| self.bounced(p, sun));
            second += once.light + once.left * bounced;
            share += (self.until_its_end(p, direction, |_, air| air.rayleigh + air.haze)).light;
        }
        let count = f32::from(SIDE * SIDE);
        second / count / (1.0 - share / count)
    }

    /// [`Self::along`] a ray up to the ground or the top.
    fn until_its_end(
        &self,
        from: DVec3,
        direction: DVec3,
        source: impl Fn(DVec3, &Air) -> Rgb,
    ) -> Gathered {
        let middle = -from.dot(direction);
        let beside2 = from.length_squared() - middle * middle;
        let half_chord = |radius: f64| (radius * radius - beside2).max(0.0).sqrt();
        if middle > 0.0 && beside2 < GROUND * GROUND {
            let d = (middle - half_chord(GROUND)).max(0.0);
            let gathered = self.along(from, direction, d, source);
            return Gathered {
                ground: Some(from + d * direction),
                ..gathered
            };
        }
        self.along(from, direction, middle + half_chord(TOP), source)
    }

    /// What comes along a ray of which `source` says what each km adds at a point.
    fn along(
        &self,
        from: DVec3,
        direction: DVec3,
        distance: f64,
        source: impl Fn(DVec3, &Air) -> Rgb,
    ) -> Gathered {
        let (mut light, mut left) = (Rgb::ZERO, Rgb::ONE);
        let at = |i: u32| distance * (f64::from(i) / f64::from(STEPS)).powi(3);
        for i in 0..STEPS {
            let (start, end) = (at(i), at(i + 1));
            let p = from + 0.5 * (start + end) * direction;
            let air = self.air((p.length() - GROUND).max(0.0));
            let passes = (-air.extinction * (end - start) as f32).exp();
            light += left * source(p, &air) * (1.0 - passes) / air.extinction;
            left *= passes;
        }
        Gathered {
            light,
            left,
            ground: None,
        }
    }
}

/// Molecules scatter forwards and backwards alike.
fn rayleigh_phase(cos: f32) -> f32 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// Cornette and Shanks 1992.
fn haze_phase(cos: f32) -> f32 {
    let g = HAZE_FORWARD;
    let around = (1.0 + g * g - 2.0 * g * cos).powf(1.5);
    3.0 / (8.0 * PI) * (1.0 - g * g) * (1.0 + cos * cos) / ((2.0 + g * g) * around)
}

/// Values of `f` over the unit square.
fn table((width, height): (usize, usize), f: impl Fn(f64, f64) -> Rgb) -> Bitmap {
    let at = |i: usize, count: usize| i as f64 / (count - 1) as f64;
    let values = (0..width * height).map(|i| f(at(i % width, width), at(i / width, height)));
    Bitmap {
        width,
        height,
        pixels: values.collect(),
    }
}

/// The inverse of [`table`], interpolated.
fn look_up(table: &Bitmap, x: f64, y: f64) -> Rgb {
    let at = |x: f64, count: usize| 0.5 + x * (count - 1) as f64;
    let (x, y) = (at(x, table.width), at(y, table.height));
    let (pixels, between) = table.around(x, y, [Wrap::Clamp; 2]);
    bilinear(pixels.map(|i| table.pixels[i]), between)
}

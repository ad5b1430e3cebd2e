mod atmosphere;

use std::f32::consts::PI;
use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::color::Rgb;
use crate::texture::Bitmap;

use atmosphere::{Atmosphere, GROUND};

use super::{DistantLight, EnvironmentMap, Light};

/// A clear sky above level ground, computed for one place of the sun: air, haze and ozone that scatter light any number of times.
///
/// Outside of the air the sun is white and sheds an irradiance of pi, so that a white surface which faces it has a radiance of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Unit vector towards the sun; y is up.
    pub sun: DVec3,
    /// How hazy it is, after Preetham, Shirley and Smits 1999: 2 is very clear, 10 is misty.
    pub turbidity: f64,
    /// What the ground reflects, which is matt.
    pub ground: Rgb,
    /// Multiplies all light.
    pub scale: f32,
    /// Whether the sun itself shines.
    pub disk: bool,
}

/// Of the picture of the sky; it is smooth but for heights just above the horizon.
const WIDTH: usize = 256;
const HEIGHT: usize = 512;
/// The eye is on the ground.
const EYE: DVec3 = DVec3::new(0.0, GROUND, 0.0);

impl Sky {
    /// A picture of sky and ground, and the sun where it shines above the horizon.
    pub fn lights(&self) -> Vec<Light> {
        let atmosphere = Atmosphere::new(self.turbidity, self.ground);
        let sun = DistantLight {
            direction: self.sun,
            irradiance: self.scale * PI * atmosphere.sunlight(EYE, self.sun),
            angle: DistantLight::SUN_DEGREES.to_radians(),
        };
        let map = EnvironmentMap::new(self.picture(&atmosphere), -self.sun.x.atan2(-self.sun.z));
        let mut lights = vec![Light::Environment(Arc::new(map))];
        if self.disk && sun.irradiance != Rgb::ZERO {
            lights.push(Light::Distant(sun));
        }
        lights
    }

    /// The sun stands above the middle column, and what is left of it is the mirror image of what is right of it.
    fn picture(&self, atmosphere: &Atmosphere) -> Bitmap {
        let level = (1.0 - self.sun.y * self.sun.y).max(0.0).sqrt();
        let sun = DVec3::new(0.0, self.sun.y, -level);
        let right_half: Vec<Rgb> = (0..HEIGHT / 2 * WIDTH / 2)
            .into_par_iter()
            .map(|i| {
                let (row, column) = (2 * i / WIDTH, i % (WIDTH / 2));
                let (right, ahead) = ((column as f64 + 0.5) / WIDTH as f64 * TAU).sin_cos();
                let (level, rise) = polar_angle(row).sin_cos();
                let direction = DVec3::new(level * right, rise, -level * ahead);
                self.scale * PI * atmosphere.glow(EYE, direction, sun)
            })
            .collect();
        let rows = || right_half.chunks(WIDTH / 2);
        let pixel = PI / WIDTH as f32 * TAU as f32 / HEIGHT as f32;
        let shed = rows().enumerate().map(|(row, half)| {
            let (sin, cos) = polar_angle(row).sin_cos();
            2.0 * half.iter().sum::<Rgb>() * (sin * cos) as f32 * pixel
        });
        let of_sun = self.scale * PI * self.sun.y.max(0.0) as f32 * atmosphere.sunlight(EYE, sun);
        let ground = self.ground / PI * (of_sun + shed.sum::<Rgb>());
        let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
        for half in rows() {
            pixels.extend(half.iter().rev());
            pixels.extend(half);
        }
        pixels.resize(WIDTH * HEIGHT, ground);
        Bitmap {
            width: WIDTH,
            height: HEIGHT,
            pixels,
        }
    }
}

fn polar_angle(row: usize) -> f64 {
    (row as f64 + 0.5) / HEIGHT as f64 * 0.5 * TAU
}

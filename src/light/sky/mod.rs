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
const WIDTH: usize = 512;
const HEIGHT: usize = 512;
/// Of the eye above the ground, km.
const EYE: f64 = 0.002;

impl Sky {
    /// A picture of sky and ground, and the sun where it shines above the horizon.
    pub fn lights(&self) -> Vec<Light> {
        let atmosphere = Atmosphere::new(self.turbidity, self.ground);
        let eye = (GROUND + EYE) * DVec3::Y;
        let sun = DistantLight {
            direction: self.sun,
            irradiance: self.scale * PI * atmosphere.sunlight(eye, self.sun),
            angle: DistantLight::SUN_DEGREES.to_radians(),
        };
        let map = EnvironmentMap::new(
            self.picture(&atmosphere, eye),
            -self.sun.x.atan2(-self.sun.z),
        );
        let mut lights = vec![Light::Environment(Arc::new(map))];
        if self.disk && sun.irradiance != Rgb::ZERO {
            lights.push(Light::Distant(sun));
        }
        lights
    }

    fn picture(&self, atmosphere: &Atmosphere, eye: DVec3) -> Bitmap {
        // The sun stands above the middle column, and what is left of it is the mirror image of what is right of it.
        let level = (1.0 - self.sun.y * self.sun.y).max(0.0).sqrt();
        let sun = DVec3::new(0.0, self.sun.y, -level);
        let half: Vec<_> = (0..HEIGHT * WIDTH / 2)
            .into_par_iter()
            .map(|i| {
                let (row, column) = (2 * i / WIDTH, i % (WIDTH / 2));
                let (right, ahead) = ((column as f64 + 0.5) / WIDTH as f64 * TAU).sin_cos();
                let (level, rise) = polar_angle(row).sin_cos();
                let direction = DVec3::new(level * right, rise, -level * ahead);
                atmosphere.gather(eye, direction, sun)
            })
            .collect();
        let mut irradiance = atmosphere.sunlight(eye, sun) * sun.y.max(0.0) as f32;
        for (row, gathered) in half.chunks(WIDTH / 2).enumerate().take(HEIGHT / 2) {
            let (sin, cos) = polar_angle(row).sin_cos();
            let angle = TAU / WIDTH as f64 * 0.5 * TAU / HEIGHT as f64;
            let light: Rgb = gathered.iter().map(|g| g.light).sum();
            irradiance += 2.0 * light * (sin * cos * angle) as f32;
        }
        let bounced = self.ground * irradiance / PI;
        let pixel = |i: usize| {
            let (row, column) = (i / WIDTH, i % WIDTH);
            let beside = if column < WIDTH / 2 {
                WIDTH / 2 - 1 - column
            } else {
                column - WIDTH / 2
            };
            let gathered = &half[row * WIDTH / 2 + beside];
            let ground = gathered
                .ground
                .map_or(Rgb::ZERO, |_| gathered.left * bounced);
            self.scale * PI * (gathered.light + ground)
        };
        Bitmap {
            width: WIDTH,
            height: HEIGHT,
            pixels: (0..WIDTH * HEIGHT).map(pixel).collect(),
        }
    }
}

fn polar_angle(row: usize) -> f64 {
    (row as f64 + 0.5) / HEIGHT as f64 * 0.5 * TAU
}

//! Lights that are infinitely far away.

mod density;
mod image;
mod panorama;
mod sky;
mod sun;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::Vec2;
use solidtrace::color::Rgb;
use solidtrace::integrator::{CameraRay, Integrator};
use solidtrace::light::{EnvironmentMap, Light};
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::Scene;
use solidtrace::texture::Bitmap;
use solidtrace::world::{Media, World};

use crate::support::{Build, Shot, shoot_with};

/// A picture of these greys.
fn picture(width: usize, height: usize, grey: impl Fn(usize, usize) -> f32) -> Bitmap {
    let pixel = |i: usize| Rgb::splat(grey(i % width, i / width));
    Bitmap {
        width,
        height,
        pixels: (0..width * height).map(pixel).collect(),
    }
}

fn environment(bitmap: Bitmap) -> Light {
    Light::Environment(Arc::new(EnvironmentMap::new(bitmap, 0.0)))
}

/// What a white floor shows, times pi.
fn irradiance(scene: Scene, integrator: &dyn Integrator, spp: u32) -> f64 {
    let shot = Shot {
        spp,
        sampler: SamplerKind::Sobol,
        seed: 11,
    };
    let pixels = shoot_with(&scene.world(), integrator, shot);
    pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / pixels.len() as f64 * PI
}

/// Direct light by samples of lights alone; what is seen itself is black.
struct LightOnly;

impl Integrator for LightOnly {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        for (camera, out) in batch.iter().zip(radiance) {
            let of_lights = || {
                let hit = world.intersect(&camera.ray)?;
                let point = world.surface(&camera.ray, &hit);
                let [pick, u, v, _] = camera.sampler.set(2);
                let sample = world.sample_light(point.p, pick, Vec2::new(u, v))?;
                let (wi, _) = sample.source.seen_from(point.p)?;
                if world.occluded(&point.towards(sample.source)) {
                    return None;
                }
                let bsdf = world.bsdf(&point, &Media::default());
                let (f_cos, _) = bsdf.eval(-camera.ray.direction.as_vec3(), wi);
                Some(f_cos * sample.li / sample.divisor())
            };
            *out = of_lights().unwrap_or_default();
        }
        0
    }
}

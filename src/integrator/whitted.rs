use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::light::{Light, LightSample, Source};
use crate::math::Ray;
use crate::world::{Media, SurfacePoint, World};

use super::{CameraRay, Integrator, media};

/// Recursive ray tracing after Whitted 1980: matt and rough surfaces show direct light, mirrors and glass pass
/// the ray on, and so do smooth coats. Of several directions one is followed, by chance.
#[derive(Clone, Copy, Debug)]
pub struct WhittedIntegrator {
    /// Most reflections and refractions.
    pub max_depth: u32,
    /// What is left of a light's contribution in its shadow, 0..=1.
    pub shadow_factor: f32,
    /// Colour of rays that leave the scene or reach the limit; else the environment, and black.
    pub background: Option<Rgb>,
}

impl Integrator for WhittedIntegrator {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        let mut traced = 0;
        for ((camera, media), radiance) in batch.iter().zip(media(world, batch)).zip(radiance) {
            *radiance = self.follow(world, camera, media, &mut traced);
        }
        traced
    }
}

impl WhittedIntegrator {
    fn follow(&self, world: &World, camera: &CameraRay, mut media: Media, traced: &mut u64) -> Rgb {
        let mut ray = camera.ray;
        let mut beta = Rgb::ONE;
        let mut light = Rgb::ZERO;
        for depth in 0..=self.max_depth {
            *traced += 1;
            let hit = world.intersect(&ray);
            beta *= media.transmittance(hit.map_or(f64::INFINITY, |hit| hit.t));
            let Some(hit) = hit else {
                let beyond = || world.beyond(ray.direction, |_| 1.0);
                return light + beta * self.background.unwrap_or_else(beyond);
            };
            let point = world.surface(&ray, &hit);
            light += beta * world.material(&point).emitted(&point.texture);
            let bsdf = world.bsdf(&point, &media);
            let wo = -ray.direction.as_vec3();
            if bsdf.is_smooth() {
                let reflected = |wi, distance| {
                    let left = media.towards(&point, world.material(&point), wi, distance);
                    bsdf.eval(wo, wi).0 * left
                };
                light += beta * self.direct(world, &point, reflected, camera, depth, traced);
            }
            let [u, v, pick, _] = camera.sampler.set(2 * depth + 1);
            let sample = bsdf.sample(wo, pick, Vec2::new(u, v));
            let Some(sample) = sample.filter(|sample| sample.pdf.is_infinite()) else {
                return light;
            };
            beta *= sample.weight;
            media.follow(&point, world.material(&point), sample.wi);
            ray = point.spawn(sample.wi);
        }
        light + beta * self.background.unwrap_or(Rgb::ZERO)
    }

    /// Direct light from every point light and sun, and from one point of one of the lights that are surfaces, but none
    /// from the environment; `reflected` is what the surface reflects of light from a direction and a distance.
    fn direct(
        &self,
        world: &World,
        point: &SurfacePoint,
        reflected: impl Fn(Vec3, f64) -> Rgb,
        camera: &CameraRay,
        depth: u32,
        traced: &mut u64,
    ) -> Rgb {
        let mut add = |sample: LightSample| {
            let Some((wi, distance)) = sample.source.seen_from(point.p) else {
                return Rgb::ZERO;
            };
            let f_cos = reflected(wi, distance);
            if f_cos == Rgb::ZERO {
                return Rgb::ZERO;
            }
            *traced += 1;
            let shadow: Ray = point.towards(sample.source);
            let open = if world.occluded(&shadow) {
                self.shadow_factor
            } else {
                1.0
            };
            open * f_cos * sample.li / sample.divisor()
        };
        let [u, v, pick, _] = camera.sampler.set(2 * depth + 2);
        let u2 = Vec2::new(u, v);
        let mut sum = Rgb::ZERO;
        let mut surfaces = false;
        for light in world.lights().lights() {
            match light {
                Light::Point(_) | Light::Distant(_) => {
                    sum += light.sample(point.p, u2).map_or(Rgb::ZERO, &mut add);
                }
                Light::Surface(_) => surfaces = true,
                Light::Environment(_) => {}
            }
        }
        if surfaces {
            let of_surface = |sample: &LightSample| {
                matches!(sample.source, Source::Point(_)) && sample.pdf.is_finite()
            };
            let sample = world.sample_light(point.p, pick, u2).filter(of_surface);
            sum += sample.map_or(Rgb::ZERO, add);
        }
        sum
    }
}

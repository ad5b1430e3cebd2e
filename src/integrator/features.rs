use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::math::{Frame, Ray};
use crate::sampling::cosine_hemisphere;
use crate::world::{Media, SurfacePoint, World};

use super::{CameraRay, Integrator};

/// What the first surface that a ray meets looks like in itself. Rays that meet none show the
/// environment where colours are shown, and 0 elsewhere.
#[derive(Clone, Copy, Debug)]
pub enum FeatureIntegrator {
    /// The shading normal towards the camera, as the colour `0.5 n + 0.5`.
    Normals,
    /// Distance from the camera.
    Depth,
    /// Albedo and emission, unlit.
    Flat,
    /// The share of the cosine-weighted hemisphere that is open up to `radius`.
    Ao {
        /// How far away an occluder counts; `None` is a quarter of the diagonal of all but planes.
        radius: Option<f64>,
    },
}

impl Integrator for FeatureIntegrator {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        let rays: Vec<Ray> = batch.iter().map(|camera| camera.ray).collect();
        let mut hits = vec![None; rays.len()];
        world.intersect_batch(&rays, &mut hits);
        let mut traced = rays.len() as u64;
        for (i, camera) in batch.iter().enumerate() {
            radiance[i] = match &hits[i] {
                Some(hit) => {
                    let point = world.surface(&camera.ray, hit);
                    self.show(world, camera, hit.t, &point, &mut traced)
                }
                None => match self {
                    Self::Flat => world.beyond(camera.ray.direction, |_| 1.0),
                    Self::Ao { .. } => Rgb::ONE,
                    Self::Normals | Self::Depth => Rgb::ZERO,
                },
            };
        }
        traced
    }
}

impl FeatureIntegrator {
    fn show(
        self,
        world: &World,
        camera: &CameraRay,
        t: f64,
        point: &SurfacePoint,
        traced: &mut u64,
    ) -> Rgb {
        let facing = |n: Vec3| point.side * n;
        match self {
            Self::Normals => 0.5 * facing(point.ns) + 0.5,
            Self::Depth => Rgb::splat(t as f32),
            Self::Flat => {
                let emitted = world.material(point).emitted(&point.texture);
                world.bsdf(point, &Media::default()).albedo() + emitted
            }
            Self::Ao { radius } => {
                *traced += 1;
                let [u, v, ..] = camera.sampler.set(1);
                let local = cosine_hemisphere(Vec2::new(u, v));
                let direction = Frame::around(facing(point.ng)).to_world(local);
                let mut ray = point.spawn(direction);
                ray.tmax = radius.unwrap_or_else(|| 0.25 * world.bounds().size().length());
                Rgb::splat(if world.occluded(&ray) { 0.0 } else { 1.0 })
            }
        }
    }
}

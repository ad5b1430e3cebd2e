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

/// The first surface on a camera ray.
pub(super) struct FirstSurface {
    /// How far away.
    pub(super) t: f64,
    point: SurfacePoint,
}

/// What each camera ray meets first.
pub(super) fn first_surfaces(world: &World, batch: &[CameraRay]) -> Vec<Option<FirstSurface>> {
    let rays: Vec<Ray> = batch.iter().map(|camera| camera.ray).collect();
    let mut hits = vec![None; rays.len()];
    world.intersect_batch(&rays, &mut hits);
    (rays.iter().zip(&hits))
        .map(|(ray, hit)| {
            let hit = hit.as_ref()?;
            let (t, point) = (hit.t, world.surface(ray, hit));
            Some(FirstSurface { t, point })
        })
        .collect()
}

impl FirstSurface {
    /// The shading normal, towards the camera.
    pub(super) fn normal(&self) -> Vec3 {
        self.point.side * self.point.ns
    }

    /// Its colour, unlit.
    pub(super) fn albedo(&self, world: &World) -> Rgb {
        world.bsdf(&self.point, &Media::default()).albedo()
    }
}

impl Integrator for FeatureIntegrator {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        let mut traced = batch.len() as u64;
        let surfaces = first_surfaces(world, batch);
        for ((camera, surface), radiance) in batch.iter().zip(&surfaces).zip(radiance) {
            *radiance = match surface {
                Some(surface) => self.show(world, camera, surface, &mut traced),
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
        surface: &FirstSurface,
        traced: &mut u64,
    ) -> Rgb {
        let point = &surface.point;
        match self {
            Self::Normals => 0.5 * surface.normal() + 0.5,
            Self::Depth => Rgb::splat(surface.t as f32),
            Self::Flat => surface.albedo(world) + world.material(point).emitted(&point.texture),
            Self::Ao { radius } => {
                *traced += 1;
                let [u, v, ..] = camera.sampler.set(1);
                let local = cosine_hemisphere(Vec2::new(u, v));
                let normal = point.side * point.ng;
                let direction = Frame::around(normal).to_world(local);
                let mut ray = point.spawn(direction);
                ray.tmax = radius.unwrap_or_else(|| 0.25 * world.bounds().size().length());
                Rgb::splat(if world.occluded(&ray) { 0.0 } else { 1.0 })
            }
        }
    }
}

//! From camera rays to radiance. Integrators take batches, so that the rays of many paths go to the
//! world together.

mod features;
mod layers;
mod path;
mod whitted;

pub use features::FeatureIntegrator;
pub use layers::{LayerKind, layered_integrator};
pub use path::{DirectIntegrator, PathIntegrator, Probe, Strategy};
pub use whitted::WhittedIntegrator;

use glam::DVec3;

use crate::color::Rgb;
use crate::film::Layer;
use crate::math::Ray;
use crate::sampling::Sampler;
use crate::scene::IntegratorSettings;
use crate::world::{Media, World};

/// A ray from the camera with the canonical samples of its path. Set 0 is the camera's.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// The ray, of unit direction.
    pub ray: Ray,
    /// Its samples.
    pub sampler: Sampler,
}

/// Estimates the radiance that camera rays carry.
pub trait Integrator: Sync {
    /// Writes one estimate for each ray of the batch into `radiance`, of the same length; returns how
    /// many rays were traced. An estimate depends on its own ray and samples alone.
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64;

    /// What [`Self::radiance_and_layers`] tells beside the radiance.
    fn layers(&self) -> &[Layer] {
        &[]
    }

    /// [`Self::radiance`], and for each ray in turn all its layers into `layers`.
    fn radiance_and_layers(
        &self,
        world: &World,
        batch: &[CameraRay],
        radiance: &mut [Rgb],
        _layers: &mut [Rgb],
    ) -> u64 {
        self.radiance(world, batch, radiance)
    }
}

/// The media in which the rays of a batch start; mostly they have one origin.
fn media(world: &World, batch: &[CameraRay]) -> impl Iterator<Item = Media> {
    let mut last: Option<(DVec3, Media)> = None;
    batch.iter().map(move |camera| {
        let origin = camera.ray.origin;
        let known = last.take().filter(|(at, _)| *at == origin);
        let (_, media) = last.insert(known.unwrap_or_else(|| (origin, world.media_at(origin))));
        media.clone()
    })
}

/// The integrator that `settings` describe.
pub fn integrator(settings: &IntegratorSettings) -> Box<dyn Integrator> {
    match *settings {
        IntegratorSettings::Path {
            max_depth,
            russian_roulette,
        } => Box::new(PathIntegrator {
            max_depth,
            russian_roulette,
        }),
        IntegratorSettings::Direct { max_depth } => Box::new(DirectIntegrator { max_depth }),
        IntegratorSettings::Whitted {
            max_depth,
            shadow_factor,
            background,
        } => Box::new(WhittedIntegrator {
            max_depth,
            shadow_factor,
            background,
        }),
        IntegratorSettings::Normals => Box::new(FeatureIntegrator::Normals),
        IntegratorSettings::Depth => Box::new(FeatureIntegrator::Depth),
        IntegratorSettings::Flat => Box::new(FeatureIntegrator::Flat),
        IntegratorSettings::Ao { radius } => Box::new(FeatureIntegrator::Ao { radius }),
    }
}

use crate::color::Rgb;
use crate::error::{Error, ErrorKind, Result};
use crate::film::Layer;
use crate::scene::IntegratorSettings;
use crate::world::World;

use super::features::first_surfaces;
use super::path::Tracer;
use super::{CameraRay, DirectIntegrator, Integrator, PathIntegrator, Probe, Strategy, integrator};

/// Layers that stand beside a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LayerKind {
    /// `bounce0`, `bounce1` and so on: light by how often it was scattered. There is one for each bounce that paths
    /// may have, or 17, the last of which has all the rest. Their sum is the picture.
    Bounces,
    /// `emitted`, `light` and `bsdf`: light by how it was found, see [`Strategy`]. Their sum is the picture.
    Strategies,
    /// `albedo`: the colour of the first surface, unlit and without what it emits; 0 where there is none.
    Albedo,
    /// `normal`: the shading normal of the first surface, towards the camera; 0 where there is none.
    Normal,
    /// `depth`: how far away the first surface is; 0 where there is none.
    Depth,
}

/// The largest number of bounces that has its own layer, with all above it.
const LAST_BOUNCE: u32 = 16;

/// The integrator that `settings` describe, with layers beside its picture, which stays as it is.
///
/// # Errors
/// Where light is to be split and the integrator is neither the path tracer nor the one for direct light.
pub fn layered_integrator(
    settings: &IntegratorSettings,
    kinds: &[LayerKind],
) -> Result<Box<dyn Integrator>> {
    let mut kinds = kinds.to_vec();
    kinds.sort_unstable();
    kinds.dedup();
    if kinds.is_empty() {
        return Ok(integrator(settings));
    }
    let tracer = match *settings {
        IntegratorSettings::Path {
            max_depth,
            russian_roulette,
        } => Some(Tracer::from(PathIntegrator {
            max_depth,
            russian_roulette,
        })),
        IntegratorSettings::Direct { max_depth } => {
            Some(Tracer::from(DirectIntegrator { max_depth }))
        }
        _ => None,
    };
    let has = |kind| kinds.contains(&kind);
    let picture = if has(LayerKind::Bounces) || has(LayerKind::Strategies) {
        Picture::Split(tracer.ok_or_else(|| {
            Error::new(
                ErrorKind::Usage,
                "this integrator does not tell bounces or strategies apart",
            )
            .help("use the integrator path or direct, or the layers albedo, normal and depth alone")
        })?)
    } else {
        Picture::Whole(integrator(settings))
    };
    let last = tracer.map_or(0, |tracer| tracer.most.min(LAST_BOUNCE));
    let mut layered = LayeredIntegrator {
        picture,
        bounces: has(LayerKind::Bounces).then_some(last),
        strategies: None,
        features: Vec::new(),
        layers: Vec::new(),
    };
    for kind in kinds {
        layered.add(kind);
    }
    Ok(Box::new(layered))
}

struct LayeredIntegrator {
    picture: Picture,
    /// The last bounce that has its own layer; that of bounce 0 is the first of all.
    bounces: Option<u32>,
    /// The first layer of the strategies.
    strategies: Option<usize>,
    /// What the last layers show.
    features: Vec<LayerKind>,
    layers: Vec<Layer>,
}

enum Picture {
    Whole(Box<dyn Integrator>),
    Split(Tracer),
}

impl LayeredIntegrator {
    fn add(&mut self, kind: LayerKind) {
        let mut add = |name: &str, channels| {
            let name = name.to_owned();
            self.layers.push(Layer { name, channels });
        };
        match kind {
            LayerKind::Bounces => {
                for bounce in 0..=self.bounces.unwrap_or(0) {
                    add(&format!("bounce{bounce}"), "RGB");
                }
            }
            LayerKind::Strategies => {
                for name in ["emitted", "light", "bsdf"] {
                    add(name, "RGB");
                }
                self.strategies = Some(self.layers.len() - 3);
            }
            LayerKind::Albedo => add("albedo", "RGB"),
            LayerKind::Normal => add("normal", "XYZ"),
            LayerKind::Depth => add("depth", "Z"),
        }
        if kind >= LayerKind::Albedo {
            self.features.push(kind);
        }
    }

    /// Fills in the last layers; returns how many rays were traced.
    fn show_features(&self, world: &World, batch: &[CameraRay], layers: &mut [Rgb]) -> u64 {
        if self.features.is_empty() {
            return 0;
        }
        let first = self.layers.len() - self.features.len();
        let rows = layers.chunks_mut(self.layers.len());
        for (surface, row) in first_surfaces(world, batch).iter().zip(rows) {
            let Some(surface) = surface else { continue };
            for (layer, kind) in row[first..].iter_mut().zip(&self.features) {
                *layer = match kind {
                    LayerKind::Normal => surface.normal(),
                    LayerKind::Depth => Rgb::new(surface.t as f32, 0.0, 0.0),
                    _ => surface.albedo(world),
                };
            }
        }
        batch.len() as u64
    }
}

impl Integrator for LayeredIntegrator {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        match &self.picture {
            Picture::Whole(integrator) => integrator.radiance(world, batch, radiance),
            Picture::Split(tracer) => tracer.trace(world, batch, radiance, &mut ()),
        }
    }

    fn layers(&self) -> &[Layer] {
        &self.layers
    }

    fn radiance_and_layers(
        &self,
        world: &World,
        batch: &[CameraRay],
        radiance: &mut [Rgb],
        layers: &mut [Rgb],
    ) -> u64 {
        layers.fill(Rgb::ZERO);
        let traced = match &self.picture {
            Picture::Whole(integrator) => integrator.radiance(world, batch, radiance),
            Picture::Split(tracer) => {
                let integrator = self;
                let mut splitter = Splitter { integrator, layers };
                tracer.trace(world, batch, radiance, &mut splitter)
            }
        };
        traced + self.show_features(world, batch, layers)
    }
}

/// Adds light to the layers it belongs to.
struct Splitter<'a> {
    integrator: &'a LayeredIntegrator,
    layers: &'a mut [Rgb],
}

impl Probe for Splitter<'_> {
    fn light(&mut self, index: usize, bounces: u32, strategy: Strategy, light: Rgb) {
        let row = index * self.integrator.layers.len();
        if let Some(last) = self.integrator.bounces {
            self.layers[row + bounces.min(last) as usize] += light;
        }
        if let Some(first) = self.integrator.strategies {
            self.layers[row + first + strategy as usize] += light;
        }
    }
}

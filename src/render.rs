//! From a world to a film: tiles, passes, threads.

mod adaptive;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use glam::Vec2;
use rayon::prelude::*;

use crate::camera::Lens;
use crate::color::Rgb;
use crate::error::{Error, ErrorKind, Result};
use crate::film::{Film, Filter, Layer, PixelSum, Rect};
use crate::image::{Channel, Image};
use crate::integrator::{CameraRay, Integrator};
use crate::sampling::{Sampler, SamplerKind};
use crate::scene::Scene;
use crate::world::World;

use adaptive::Adaptive;

/// What to render. The picture is a function of these (and the scene) except for `threads` and
/// `tile_size`, which only say how the work is split.
#[derive(Clone, Debug)]
pub struct RenderSettings {
    /// Width and height of the picture.
    pub size: (u32, u32),
    /// The pixels to render, inside of the picture; the others stay empty.
    pub area: Rect,
    /// Which samples of each pixel.
    pub samples: Range<u32>,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Kind of canonical samples.
    pub sampler: SamplerKind,
    /// Another seed, another noise.
    pub seed: u64,
    /// Pixels get no more samples where the relative standard error is estimated to be at most this; `None` is all
    /// samples everywhere.
    pub noise: Option<f64>,
    /// 0 is one for each core.
    pub threads: usize,
    /// Edge of the square tiles that workers take, in pixels.
    pub tile_size: u32,
}

impl RenderSettings {
    /// The whole picture as `scene` asks for it, on all cores.
    pub fn of(scene: &Scene) -> Self {
        Self {
            size: scene.film.size,
            area: Rect::of_size(scene.film.size),
            samples: 0..scene.film.spp,
            filter: scene.film.filter,
            sampler: SamplerKind::default(),
            seed: 0,
            noise: None,
            threads: 0,
            tile_size: 32,
        }
    }
}

/// Watches a render, and may end it early.
pub trait Observer: Sync {
    /// `samples` more pixel samples are done, or found to be needless, for which `rays` rays were traced.
    fn advance(&self, _samples: u64, _rays: u64) {}

    /// Asked before each tile: whether to stop with what there is.
    fn stop(&self) -> bool {
        false
    }
}

/// Watches nothing.
impl Observer for () {}

/// A pixel sample whose radiance was no finite number; it is not in the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadSample {
    /// Column and row.
    pub pixel: (u32, u32),
    /// Number of the sample.
    pub index: u32,
}

/// The outcome of a render.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The sums.
    pub film: Film,
    /// Rays traced.
    pub rays: u64,
    /// Wall time.
    pub time: Duration,
    /// Whether the render came to its end.
    pub complete: bool,
    /// The film's layers.
    pub layers: Vec<Layer>,
    /// Where the settings name a noise: how many pixels need no more samples.
    pub converged: Option<u64>,
    /// Samples left out, by pixel.
    pub bad: Vec<BadSample>,
}

impl Rendered {
    /// The picture with its layers, and with the number of samples of each pixel as channel `samples` where it may differ.
    pub fn to_image(&self) -> Image {
        let mut image = self.film.to_image();
        let layers = self.film.layer_channels(&self.layers);
        image.channels.extend(layers);
        if self.converged.is_some() {
            let counts = self.film.pixels().par_iter().map(PixelSum::count);
            image.channels.push(Channel {
                name: "samples".to_owned(),
                values: counts.map(|count| count as f32).collect(),
            });
        }
        image
    }
}

/// The largest film, in bytes.
const LARGEST: u64 = 1 << 33;

/// Renders. The film's bits depend on neither threads nor tiles: each sample has its own random
/// numbers, and sums are exact.
///
/// # Errors
/// Where the picture is too large, or the threads cannot be started.
pub fn render(
    world: &World,
    lens: &Lens,
    integrator: &dyn Integrator,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Result<Rendered> {
    let (width, height) = settings.size;
    let layers = integrator.layers();
    let most = LARGEST / Film::bytes_per_pixel(layers.len()) as u64;
    if u64::from(width) * u64::from(height) > most {
        let message = match layers.len() {
            0 => format!("{width}x{height} are more than {most} pixels"),
            count => format!("{width}x{height} are more than {most} pixels with {count} layers"),
        };
        return Err(Error::new(ErrorKind::Usage, message).help("render a smaller size"));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .map_err(|e| {
            let threads = settings.threads;
            Error::new(
                ErrorKind::Usage,
                format!("cannot start {threads} threads: {e}"),
            )
        })?;
    let start = Instant::now();
    let mut rendered = Rendered {
        film: pool.install(|| Film::with_layers(Rect::of_size(settings.size), layers.len())),
        rays: 0,
        time: Duration::ZERO,
        complete: true,
        layers: layers.to_vec(),
        converged: None,
        bad: Vec::new(),
    };
    let mut tiles: Vec<Rect> = settings.area.tiles(settings.tile_size.max(1)).collect();
    let mut adaptive = (settings.noise).map(|noise| Adaptive::new(noise, settings.area));
    for pass in passes(settings.samples.clone()) {
        let stopped = AtomicBool::new(false);
        let needs = |pixel: &(u32, u32)| adaptive.as_ref().is_none_or(|a| a.needs(*pixel));
        let shared = Mutex::new(&mut rendered);
        pool.install(|| {
            tiles.par_iter().for_each(|&rect| {
                if observer.stop() {
                    stopped.store(true, Ordering::Relaxed);
                    return;
                }
                let pixels: Vec<(u32, u32)> = rect.blocks().filter(needs).collect();
                let tile = render_tile(world, lens, integrator, settings, rect, &pixels, &pass);
                let count = pixels.len() as u64;
                observer.advance(count * u64::from(pass.end - pass.start), tile.rays);
                // Sums are exact: the order in which tiles come cannot show.
                let mut rendered = shared.lock().unwrap_or_else(PoisonError::into_inner);
                rendered.film.add(&tile.film);
                rendered.rays += tile.rays;
                rendered.bad.extend(tile.bad);
            });
        });
        if stopped.into_inner() {
            rendered.complete = false;
            break;
        }
        if let Some(adaptive) = &mut adaptive {
            let before = adaptive.converged();
            adaptive.judge(&rendered.film, pass.end - settings.samples.start);
            let saved = adaptive.converged() - before;
            observer.advance(saved * u64::from(settings.samples.end - pass.end), 0);
            tiles.retain(|tile| tile.pixels().any(|pixel| adaptive.needs(pixel)));
        }
    }
    rendered.converged = adaptive.map(|adaptive| adaptive.converged());
    rendered
        .bad
        .sort_unstable_by_key(|b| (b.pixel.1, b.pixel.0, b.index));
    rendered.time = start.elapsed();
    Ok(rendered)
}

/// Splits samples into passes over the whole picture, short at first, so that an early stop leaves an
/// even picture soon: up to the first, 2nd, 4th, 8th, 16th, 32nd, 48th, and so on.
fn passes(samples: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    let mut start = samples.start;
    std::iter::from_fn(move || {
        let length = (start - samples.start).clamp(1, 16);
        let pass = start..samples.end.min(start.saturating_add(length));
        start = pass.end;
        (!pass.is_empty()).then_some(pass)
    })
}

struct Tile {
    film: Film,
    rays: u64,
    bad: Vec<BadSample>,
}

fn render_tile(
    world: &World,
    lens: &Lens,
    integrator: &dyn Integrator,
    settings: &RenderSettings,
    rect: Rect,
    pixels: &[(u32, u32)],
    samples: &Range<u32>,
) -> Tile {
    let keys: Vec<((u32, u32), u32)> = (pixels.iter())
        .flat_map(|&pixel| samples.clone().map(move |index| (pixel, index)))
        .collect();
    let batch: Vec<CameraRay> = keys
        .iter()
        .map(|&(pixel, index)| {
            let sampler = Sampler::new(settings.sampler, settings.seed, pixel, index);
            let [u, v, lens_u, lens_v] = sampler.set(0);
            let (dx, dy) = settings.filter.sample(Vec2::new(u, v));
            let x = f64::from(pixel.0) + 0.5 + dx;
            let y = f64::from(pixel.1) + 0.5 + dy;
            CameraRay {
                ray: lens.ray(x, y, Vec2::new(lens_u, lens_v)),
                sampler,
            }
        })
        .collect();
    let depth = integrator.layers().len();
    let mut radiance = vec![Rgb::ZERO; batch.len()];
    let mut layers = vec![Rgb::ZERO; batch.len() * depth];
    let mut tile = Tile {
        rays: integrator.radiance_and_layers(world, &batch, &mut radiance, &mut layers),
        film: Film::with_layers(rect, depth),
        bad: Vec::new(),
    };
    for (i, (&(pixel, index), &value)) in keys.iter().zip(&radiance).enumerate() {
        let layers = &layers[i * depth..][..depth];
        if !tile.film.add_sample(pixel.0, pixel.1, value, layers) {
            tile.bad.push(BadSample { pixel, index });
        }
    }
    tile
}

//! From a world to a film: tiles, passes, threads.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use glam::Vec2;
use rayon::prelude::*;

use crate::camera::Lens;
use crate::color::Rgb;
use crate::error::{Error, ErrorKind, Result};
use crate::film::{Film, Filter, Rect};
use crate::integrator::{CameraRay, Integrator};
use crate::sampling::{Sampler, SamplerKind};
use crate::scene::Scene;
use crate::world::World;

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
            threads: 0,
            tile_size: 32,
        }
    }
}

/// Watches a render, and may end it early.
pub trait Observer: Sync {
    /// `samples` more pixel samples are done, for which `rays` rays were traced.
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
    /// Whether every sample that was asked for was taken.
    pub complete: bool,
    /// Samples left out, by pixel.
    pub bad: Vec<BadSample>,
}

/// More pixels would take the film beyond 8 GiB.
const MOST_PIXELS: u64 = 1 << 27;

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
    if u64::from(width) * u64::from(height) > MOST_PIXELS {
        let message = format!("{width}x{height} are more than {MOST_PIXELS} pixels");
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
        film: pool.install(|| Film::new(Rect::of_size(settings.size))),
        rays: 0,
        time: Duration::ZERO,
        complete: true,
        bad: Vec::new(),
    };
    let tiles: Vec<Rect> = settings.area.tiles(settings.tile_size.max(1)).collect();
    let mut complete = true;
    let shared = Mutex::new(&mut rendered);
    for pass in passes(settings.samples.clone()) {
        let stopped = AtomicBool::new(false);
        pool.install(|| {
            tiles.par_iter().for_each(|&rect| {
                if observer.stop() {
                    stopped.store(true, Ordering::Relaxed);
                    return;
                }
                let tile = render_tile(world, lens, integrator, settings, rect, &pass);
                let pixels = u64::from(rect.width) * u64::from(rect.height);
                observer.advance(pixels * u64::from(pass.end - pass.start), tile.rays);
                // Sums are exact: the order in which tiles come cannot show.
                let mut rendered = shared.lock().unwrap_or_else(PoisonError::into_inner);
                rendered.film.add(&tile.film);
                rendered.rays += tile.rays;
                rendered.bad.extend(tile.bad);
            });
        });
        if stopped.into_inner() {
            complete = false;
            break;
        }
    }
    rendered.complete = complete;
    rendered
        .bad
        .sort_unstable_by_key(|b| (b.pixel.1, b.pixel.0, b.index));
    rendered.time = start.elapsed();
    Ok(rendered)
}

/// Splits samples into passes over the whole picture, short at first, so that an early stop leaves an
/// even picture soon.
fn passes(samples: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    let (mut start, mut length) = (samples.start, 1);
    std::iter::from_fn(move || {
        let end = samples.end.min(start.saturating_add(length));
        let pass = start..end;
        (start, length) = (end, (2 * length).min(16));
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
    samples: &Range<u32>,
) -> Tile {
    let keys: Vec<((u32, u32), u32)> = (rect.pixels())
        .flat_map(|pixel| samples.clone().map(move |index| (pixel, index)))
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
    let mut radiance = vec![Rgb::ZERO; batch.len()];
    let mut tile = Tile {
        rays: integrator.radiance(world, &batch, &mut radiance),
        film: Film::new(rect),
        bad: Vec::new(),
    };
    for (&(pixel, index), &value) in keys.iter().zip(&radiance) {
        if !tile.film.pixel_mut(pixel.0, pixel.1).add(value) {
            tile.bad.push(BadSample { pixel, index });
        }
    }
    tile
}

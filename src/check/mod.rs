//! Ray hits of a scene's meshes against Embree's, every difference judged by an arbiter.
//!
//! ```
//! use std::path::Path;
//! use solidtrace::check::{CheckSettings, Checker};
//! use solidtrace::io::{ReadOptions, read_scene};
//! use solidtrace::world::World;
//!
//! let scene = read_scene(Path::new("assets/quad.obj"), &ReadOptions::default())?;
//! let world = World::build(scene)?;
//! let settings = CheckSettings { rays: 1000, ..CheckSettings::default() };
//! let report = Checker::new(&world)?.run(&settings, &());
//! assert_eq!(report.sum().ours_wrong, 0);
//! # Ok::<(), solidtrace::Error>(())
//! ```

mod arbiter;
mod exact;
mod heat;
mod index;
mod judge;
mod meshes;
mod rays;
mod tally;

pub use arbiter::{Answer, Arbiter, Claim, Rounding, Verdict};
pub use heat::HeatMap;
pub use meshes::{Meshes, Spot};
pub use rays::{Query, RayClass};
pub use tally::{Outcome, Reason, Tally};

use rayon::prelude::*;

use crate::accel::{Accel, AccelOptions, Hit, Kernel, Placed};
use crate::camera::Lens;
use crate::embree::{EmbreeOptions, EmbreeScene};
use crate::error::{Error, Result};
use crate::geometry::{MeshId, Shape};
use crate::math::Ray;
use crate::render::Observer;
use crate::world::World;

use rays::{Chunk, RayMaker};

/// What to trace.
#[derive(Clone, Copy, Debug)]
pub struct CheckSettings {
    /// Rays, shared out evenly to the classes.
    pub rays: u64,
    /// Another seed, other rays.
    pub seed: u64,
    /// Whether to count by pixel what camera rays show; then there is at least one a pixel.
    pub heat_map: bool,
}

impl Default for CheckSettings {
    fn default() -> Self {
        Self {
            rays: 1_000_000,
            seed: 0,
            heat_map: false,
        }
    }
}

impl CheckSettings {
    /// Rays of a class, for a picture of `size` pixels.
    pub fn rays_of(&self, class: RayClass, size: (u32, u32)) -> u64 {
        let classes = RayClass::ALL.len() as u64;
        let share = self.rays / classes + u64::from((class as u64) < self.rays % classes);
        if self.heat_map && class == RayClass::Camera {
            share.max(u64::from(size.0) * u64::from(size.1))
        } else {
            share
        }
    }
}

/// What a run found.
#[derive(Clone, Debug)]
pub struct Report {
    /// By class, in the order of [`RayClass::ALL`].
    pub classes: Vec<(RayClass, Tally)>,
    /// Where one was asked for.
    pub heat_map: Option<HeatMap>,
    /// Rays that we answered wrong; of very many some.
    pub wrong: Vec<(Query, Answers)>,
    /// Whether all rays were traced that were asked for and exist.
    pub complete: bool,
}

impl Report {
    /// Over all classes.
    pub fn sum(&self) -> Tally {
        let mut sum = Tally::default();
        for (_, tally) in &self.classes {
            sum += *tally;
        }
        sum
    }
}

/// What all engines say of one ray.
#[derive(Clone, Copy, Debug)]
pub struct Answers {
    /// Ours.
    pub ours: Answer,
    /// The first kernel of which a query of this ray, single or in a batch, for the closest hit or any, says something
    /// else.
    pub dissent: Option<Kernel>,
    /// Embree's: fast, then robust.
    pub embree: [Answer; 2],
}

/// A scene's meshes in our trees, one for each kernel, in two scenes of Embree, and before the arbiter.
pub struct Checker<'a> {
    world: &'a World,
    lens: Lens,
    ours: Vec<(Kernel, Accel)>,
    /// Fast, then robust.
    embree: [EmbreeScene; 2],
    arbiter: Arbiter<'a>,
}

/// What a chunk's rays show.
#[derive(Default)]
struct Found {
    tally: Tally,
    /// Of those of the camera, each with its pixel.
    pixels: Vec<((u32, u32), Outcome)>,
    wrong: Vec<(Query, Answers)>,
}

/// More wrong answers are only counted.
const SHOWN: usize = 10;

/// Rays traced together.
const CHUNK: u64 = 1 << 14;

impl<'a> Checker<'a> {
    /// Builds all trees over the meshes of `world`; its other shapes are left out, see [`Meshes::left_out`].
    ///
    /// # Errors
    /// Where there is no mesh, the first camera looks nowhere, or Embree fails.
    pub fn new(world: &'a World) -> Result<Self> {
        let meshes = Meshes::of(world.scene());
        if meshes.is_empty() {
            return Err(Error::input(
                "there are no meshes to check, and Embree knows nothing else",
            )
            .help("check a model or a scene with a `Mesh`"));
        }
        let placed: Vec<Placed> = (0..meshes.len() as u32)
            .map(|instance| {
                let (mesh, transform) = meshes.placed(instance);
                Placed {
                    shape: Shape::Mesh(MeshId(mesh as u32)),
                    world_from_object: *transform,
                }
            })
            .collect();
        let ours = Kernel::available().into_iter().map(|kernel| {
            let options = AccelOptions {
                kernel,
                ..AccelOptions::default()
            };
            let accel = Accel::build_with(meshes.meshes(), &[], placed.clone(), options);
            Ok((kernel, accel?))
        });
        let ours = ours.collect::<Result<_>>()?;
        let list: Vec<_> = meshes.iter().collect();
        let embree = |robust| {
            let options = EmbreeOptions {
                robust,
                ..EmbreeOptions::default()
            };
            EmbreeScene::new(&list, options)
        };
        let scene = world.scene();
        Ok(Self {
            world,
            lens: scene.cameras[0].lens(scene.film.size)?,
            ours,
            embree: [embree(false)?, embree(true)?],
            arbiter: Arbiter::new(meshes),
        })
    }

    /// What judges.
    pub fn arbiter(&self) -> &Arbiter<'a> {
        &self.arbiter
    }

    /// Our kernels that are compared, all that this processor has.
    pub fn kernels(&self) -> impl Iterator<Item = Kernel> {
        self.ours.iter().map(|(kernel, _)| *kernel)
    }

    /// Traces rays of all classes on all threads and judges every difference.
    pub fn run(&self, settings: &CheckSettings, observer: &dyn Observer) -> Report {
        let size = self.world.scene().film.size;
        let meshes = self.arbiter.meshes();
        let maker = RayMaker::new(self.world, meshes, self.lens, self.ours[0].1.bounds());
        let mut report = Report {
            classes: Vec::new(),
            heat_map: settings.heat_map.then(|| HeatMap::new(size)),
            wrong: Vec::new(),
            complete: true,
        };
        for class in RayClass::ALL {
            let total = settings.rays_of(class, size);
            let chunks = (0..total.div_ceil(CHUNK)).into_par_iter().map(|chunk| {
                let first = chunk * CHUNK;
                let chunk = Chunk {
                    class,
                    first,
                    count: CHUNK.min(total - first) as usize,
                    total,
                    seed: settings.seed,
                };
                (!observer.stop()).then(|| {
                    let found = self.chunk(&maker, &chunk, settings.heat_map);
                    observer.advance(chunk.count as u64, found.tally.rays);
                    found
                })
            });
            let chunks: Vec<Option<Found>> = chunks.collect();
            let mut sum = Tally::default();
            report.complete &= chunks.iter().all(Option::is_some);
            for found in chunks.into_iter().flatten() {
                sum += found.tally;
                let room = SHOWN - report.wrong.len();
                report.wrong.extend(found.wrong.into_iter().take(room));
                if let Some(map) = &mut report.heat_map {
                    for (pixel, outcome) in &found.pixels {
                        map.add(*pixel, outcome);
                    }
                }
            }
            report.classes.push((class, sum));
        }
        report
    }

    /// What the rays of a chunk show.
    fn chunk(&self, maker: &RayMaker, chunk: &Chunk, by_pixel: bool) -> Found {
        let queries = maker.queries(chunk);
        let rays: Vec<Ray> = queries.iter().map(|query| query.ray).collect();
        let (hits, dissents) = self.trace(&rays);
        let mut found = Found::default();
        for (i, query) in queries.iter().enumerate() {
            let ours = hits[i].as_ref().map(Claim::from);
            let embree = self.embree.each_ref();
            let (ours, embree) = if chunk.class == RayClass::Shadow {
                let theirs = |embree: &EmbreeScene| Answer::Any(embree.occluded(&query.peer));
                (Answer::Any(ours.is_some()), embree.map(theirs))
            } else {
                let theirs = |embree: &EmbreeScene| {
                    let hit = embree.intersect(&query.peer);
                    Answer::Closest(hit.as_ref().map(Claim::from))
                };
                (Answer::Closest(ours), embree.map(theirs))
            };
            let answers = Answers {
                ours,
                dissent: dissents[i],
                embree,
            };
            let outcome = self.judge(query, &answers);
            found.tally += &outcome;
            if let Some(pixel) = query.pixel.filter(|_| by_pixel) {
                found.pixels.push((pixel, outcome));
            }
            if outcome.ours_wrong && found.wrong.len() < SHOWN {
                found.wrong.push((*query, answers));
            }
        }
        found
    }

    /// Our closest hits, and of each the first kernel that gives another in any way of asking.
    fn trace(&self, rays: &[Ray]) -> (Vec<Option<Hit>>, Vec<Option<Kernel>>) {
        let first = &self.ours[0].1;
        let hits: Vec<Option<Hit>> = rays.iter().map(|ray| first.intersect(ray)).collect();
        let mut dissents = vec![None; rays.len()];
        let mut batch = vec![None; rays.len()];
        let mut blocked = vec![false; rays.len()];
        for (kernel, accel) in &self.ours {
            accel.intersect_batch(rays, &mut batch);
            accel.occluded_batch(rays, &mut blocked);
            for (i, ray) in rays.iter().enumerate() {
                let any = hits[i].is_some();
                let agrees = batch[i] == hits[i]
                    && accel.intersect(ray) == hits[i]
                    && blocked[i] == any
                    && accel.occluded(ray) == any;
                if !agrees && dissents[i].is_none() {
                    dissents[i] = Some(*kernel);
                }
            }
        }
        (hits, dissents)
    }
}

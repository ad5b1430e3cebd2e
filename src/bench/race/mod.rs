//! The race: engines are built and asked the same rays in turn, round after round, so that what else the machine
//! does meets all of them alike.

mod bvh;
mod embree;
mod engine;
mod entrants;
mod memory;
mod obvhs;
mod ours;
mod parry;
mod plot;
mod report;

use std::time::{Duration, Instant};

use rayon::ThreadPool;

use crate::error::{Error, ErrorKind, Result};
use crate::math::Ray;

use super::{RayKind, RaySets, Subject};

pub use engine::{Answers, Engine};
use engine::{Blocks, Lap};
pub use entrants::Build;
use entrants::{Entrant, Field};
pub use plot::plot;
use report::Run;
pub use report::{KindReport, REFERENCE, Report, Row};

/// How to race.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RaceOptions {
    /// Threads that build and ask; 0 is one a core.
    pub threads: usize,
    /// How often each engine is timed on each kind of rays.
    pub rounds: usize,
    /// Width and height of the picture that camera rays are for.
    pub size: (u32, u32),
}

/// About how long an engine is timed at a time.
const LAP: Duration = Duration::from_millis(80);

/// Builds all engines over `subject` and races them on all kinds of rays; `tell` hears what is going on.
///
/// # Errors
/// Where a tree cannot be built, or hardly any camera ray meets a triangle.
pub fn race(subject: &Subject, options: RaceOptions, tell: &dyn Fn(&str)) -> Result<Report> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads)
        .build()
        .map_err(|e| Error::new(ErrorKind::Usage, format!("cannot start the threads: {e}")))?;
    let field = Field::build(subject, &pool, tell)?;
    tell("choosing rays");
    let rays = RaySets::new(subject, &field.accel, options.size)?;
    let kinds = RayKind::ALL.map(|kind| {
        let report = |round: usize| {
            tell(&format!(
                "{} rays, round {} of {}",
                kind.name(),
                round + 1,
                options.rounds
            ));
        };
        race_kind(
            kind,
            rays.of(kind),
            &field.entrants,
            options.rounds,
            &pool,
            report,
        )
    });
    Ok(Report {
        triangles: subject.triangles(),
        instances: subject.instances.len(),
        threads: pool.current_num_threads(),
        builds: field.builds,
        kinds: kinds.into(),
        notes: field.notes,
    })
}

/// An engine on its rays: all of them a few times, or where that takes too long some of them.
struct Runner<'a> {
    name: &'a str,
    lap: Lap<'a>,
    blocks: Blocks,
    passes: usize,
    rates: Vec<f64>,
    /// Rays of a pass, and what they came to.
    answers: (usize, Answers),
}

impl<'a> Runner<'a> {
    fn new(entrant: &'a Entrant, kind: RayKind, rays: &[Ray], pool: &ThreadPool) -> Self {
        let lap = entrant.racer.lap(rays, kind.any_hit());
        let start = Instant::now();
        let (probed, _) = pool.install(|| lap(Blocks::some(rays.len(), 0.01)));
        let seconds = start.elapsed().as_secs_f64() * rays.len() as f64 / probed as f64;
        let laps = LAP.as_secs_f64() / seconds.max(1e-6);
        let blocks = if laps < 0.5 {
            Blocks::some(rays.len(), laps)
        } else {
            Blocks::ALL
        };
        Self {
            name: &entrant.name,
            lap,
            blocks,
            passes: laps.round().max(1.0) as usize,
            rates: Vec::new(),
            answers: Default::default(),
        }
    }

    fn time(&mut self, pool: &ThreadPool) {
        let start = Instant::now();
        for _ in 0..self.passes {
            self.answers = pool.install(|| (self.lap)(self.blocks));
        }
        let rays = self.passes * self.answers.0;
        self.rates
            .push(rays as f64 / start.elapsed().as_secs_f64() / 1e6);
    }
}

fn race_kind(
    kind: RayKind,
    rays: &[Ray],
    entrants: &[Entrant],
    rounds: usize,
    pool: &ThreadPool,
    tell: impl Fn(usize),
) -> KindReport {
    let mut runners: Vec<Runner> = (entrants.iter())
        .filter(|entrant| entrant.kinds.contains(&kind))
        .map(|entrant| Runner::new(entrant, kind, rays, pool))
        .collect();
    for round in 0..rounds {
        tell(round);
        let first = round % runners.len();
        runners.rotate_left(first);
        for runner in &mut runners {
            runner.time(pool);
        }
        runners.rotate_right(first);
    }
    // The first engine answers what the others were asked, to compare.
    let first = entrants[0].racer.lap(rays, kind.any_hit());
    let mut expected: Vec<(Blocks, Answers)> = Vec::new();
    let runs = runners.into_iter().map(|runner| {
        let known = expected.iter().find(|(blocks, _)| *blocks == runner.blocks);
        let answers = known.map_or_else(|| pool.install(|| first(runner.blocks)).1, |(_, a)| *a);
        expected.push((runner.blocks, answers));
        Run {
            engine: runner.name.to_owned(),
            rates: runner.rates,
            rays: runner.answers.0,
            answers: runner.answers.1,
            expected: answers,
        }
    });
    KindReport::new(kind, rays.len(), runs.collect())
}

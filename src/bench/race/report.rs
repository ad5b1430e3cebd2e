use crate::bench::RayKind;

use super::Answers;
use super::entrants::Build;

/// How a race went.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Triangles of all meshes, each mesh counted once.
    pub triangles: usize,
    /// Instances of meshes.
    pub instances: usize,
    /// Threads that built and asked.
    pub threads: usize,
    /// Trees.
    pub builds: Vec<Build>,
    /// Rays.
    pub kinds: Vec<KindReport>,
    /// What one should know.
    pub notes: Vec<String>,
}

/// How one kind of rays went.
#[derive(Clone, Debug, PartialEq)]
pub struct KindReport {
    /// Which.
    pub kind: RayKind,
    /// Rays in the set.
    pub rays: usize,
    /// One an engine.
    pub rows: Vec<Row>,
}

/// How an engine did. Speeds are millions of rays a second.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its name.
    pub engine: String,
    /// Of all rounds.
    pub median: f64,
    /// The slowest round.
    pub min: f64,
    /// The fastest round.
    pub max: f64,
    /// Median over the rounds of the speed as a multiple of Embree's in the same round.
    pub ratio: f64,
    /// Rays that it was asked: all, or where it is slow some.
    pub rays: usize,
    /// Those of them that hit.
    pub hits: u64,
    /// Those of them that hit for the first engine, which is ours.
    pub expected: u64,
    /// Whether hits and distances are those of the first engine, to a part in a thousand.
    pub agrees: bool,
}

/// What was measured.
pub(super) struct Run {
    pub engine: String,
    /// Millions of rays a second, a round after the other.
    pub rates: Vec<f64>,
    pub rays: usize,
    pub answers: Answers,
    /// The first engine's answers to the same rays.
    pub expected: Answers,
}

/// The engine that ratios are to.
pub const REFERENCE: &str = "embree";

impl KindReport {
    pub(super) fn new(kind: RayKind, rays: usize, runs: Vec<Run>) -> Self {
        let reference = runs.iter().find(|run| run.engine == REFERENCE);
        let reference = reference.map_or_else(Vec::new, |run| run.rates.clone());
        let row = |mut run: Run| {
            let ratios = (run.rates.iter().zip(&reference)).map(|(rate, embree)| rate / embree);
            Row {
                ratio: median(&mut ratios.collect::<Vec<_>>()),
                median: median(&mut run.rates),
                min: run.rates[0],
                max: run.rates[run.rates.len() - 1],
                engine: run.engine,
                rays: run.rays,
                hits: run.answers.hits,
                expected: run.expected.hits,
                agrees: run.answers.agrees(&run.expected),
            }
        };
        Self {
            kind,
            rays,
            rows: runs.into_iter().map(row).collect(),
        }
    }
}

/// Sorts `values`, of which there is at least one.
fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

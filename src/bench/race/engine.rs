use rayon::prelude::*;

use crate::math::Ray;

/// What many rays came to; engines must agree on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answers {
    /// Rays that hit.
    pub hits: u64,
    /// Their distances to the closest hit added up; 0 where any hit was asked for.
    pub distance: f64,
}

impl Answers {
    /// Of distances, infinite where there is no hit.
    pub fn of_distances(distances: &[f32]) -> Self {
        let found = distances.iter().filter(|t| t.is_finite());
        found.fold(Self::default(), |sum, &t| sum.with(f64::from(t)))
    }

    /// Of any-hit queries.
    pub fn of_blocked(blocked: impl Iterator<Item = bool>) -> Self {
        Self {
            hits: blocked.map(u64::from).sum(),
            distance: 0.0,
        }
    }

    /// One hit more.
    #[must_use]
    pub fn with(self, distance: f64) -> Self {
        Self {
            hits: self.hits + 1,
            distance: self.distance + distance,
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            distance: self.distance + other.distance,
        }
    }

    /// Whether both are the same to a part in a thousand.
    pub fn agrees(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a.abs().max(b.abs());
        near(self.hits as f64, other.hits as f64) && near(self.distance, other.distance)
    }
}

/// An engine in the race. To add one, implement this beside the others and give it a line in `entrants`.
pub trait Engine: Send + Sync {
    /// A ray, or a packet of rays, as the engine wants it; made before the clock starts.
    type Ray: Send + Sync;

    /// `rays` in that form; their number is a multiple of 16.
    fn load(&self, rays: &[Ray]) -> Vec<Self::Ray>;

    /// The closest hit of each, with its distance and its triangle.
    fn closest(&self, rays: &[Self::Ray]) -> Answers;

    /// Whether each hits anything.
    fn any(&self, rays: &[Self::Ray]) -> Answers;
}

/// Which rays are asked: blocks of so many, one after the other, of which every so many-th.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Blocks {
    pub rays: usize,
    pub every: usize,
}

impl Blocks {
    /// All rays.
    pub(super) const ALL: Self = Self {
        rays: 4096,
        every: 1,
    };

    /// About the part `share` of `count` rays, from all over the set, and not too few.
    pub(super) fn some(count: usize, share: f64) -> Self {
        const RAYS: usize = 1024;
        const LEAST: usize = 16;
        let most = count.div_ceil(RAYS).div_ceil(LEAST);
        Self {
            rays: RAYS,
            every: (share.recip() as usize).clamp(1, most),
        }
    }
}

/// Answers some of the rays that it was made for, on the threads of the pool that it is called in; returns how many
/// they were.
pub(super) type Lap<'a> = Box<dyn Fn(Blocks) -> (usize, Answers) + Sync + 'a>;

/// An [`Engine`] whose kind of ray is its own affair.
pub(super) trait Racer: Send + Sync {
    fn lap(&self, rays: &[Ray], any_hit: bool) -> Lap<'_>;
}

impl<E: Engine> Racer for E {
    fn lap(&self, rays: &[Ray], any_hit: bool) -> Lap<'_> {
        let loaded = self.load(rays);
        let packet = rays.len() / loaded.len();
        Box::new(move |blocks| {
            let answer = |block: &[E::Ray]| {
                let answers = if any_hit {
                    self.any(block)
                } else {
                    self.closest(block)
                };
                (packet * block.len(), answers)
            };
            let sum = |(rays, a): (usize, Answers), (more, b)| (rays + more, a.plus(b));
            (loaded.par_chunks(blocks.rays / packet))
                .step_by(blocks.every)
                .map(answer)
                .reduce(Default::default, sum)
        })
    }
}

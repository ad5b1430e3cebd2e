//! A boolean over all crossings of all operands, in order, that knows how far each of them can be trusted.

use solidtrace::accel::CsgCrossing;
use solidtrace::math::{Interval, Ray};

use super::{Leaf, Tree};

/// Where a line is inside one operand, each list in order and disjoint: in the `certain` stretches; and outside of
/// all the `possible` ones, each of which may hold certain ones.
#[derive(Clone, Debug, Default)]
pub struct Stretches {
    pub certain: Vec<Interval>,
    pub possible: Vec<Interval>,
}

/// A crossing of the whole that must be there.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    pub within: Interval,
    pub operand: u32,
    pub enter: bool,
}

/// The crossings of one ray in order, up to the first place that is in doubt.
#[derive(Clone, Debug, Default)]
pub struct Naive {
    pub crossings: Vec<Expected>,
    /// Whether there is no such place.
    pub complete: bool,
}

/// Relative to a crossing's `t`, and to 1: more than a well-conditioned crossing loses to rounding.
const ROUNDING: f64 = 1e-9;

/// What a ray spends less time in than this it may as well miss.
const SHALLOW: f64 = 1e-4;

impl Stretches {
    /// By the solid's own spans.
    pub fn of(leaf: &Leaf, ray: &Ray) -> Self {
        let local = leaf.ray(ray);
        let length = 1.0 / ray.direction.length();
        let mut stretches = Self::default();
        for span in leaf.solid.spans(&local).iter() {
            let (enter, exit) = (span.enter.t, span.exit.t);
            let [a, b] = [enter, exit].map(|t| {
                let slack = ROUNDING * (t.abs() + length);
                if t.is_finite() { slack } else { 0.0 }
            });
            stretches.possible(enter - a, exit + b);
            if exit - enter > SHALLOW * length {
                stretches.certain.push(Interval {
                    min: enter + a,
                    max: exit - b,
                });
            }
        }
        stretches
    }

    /// Adds a stretch, which becomes one with the last if they touch.
    pub fn possible(&mut self, min: f64, max: f64) {
        match self.possible.last_mut() {
            Some(last) if last.max >= min => last.max = last.max.max(max),
            _ => self.possible.push(Interval { min, max }),
        }
    }
}

/// From `t` on a leaf is known to hold the ray, or not to, or that is in doubt.
struct Change {
    t: f64,
    leaf: usize,
    inside: Option<bool>,
}

impl Naive {
    /// By the spans of the leaves' solids.
    pub fn of(tree: &Tree, leaves: &[Leaf], ray: &Ray) -> Self {
        let stretches: Vec<Stretches> =
            leaves.iter().map(|leaf| Stretches::of(leaf, ray)).collect();
        Self::combine(tree, &stretches, ray)
    }

    /// The whole by the truth table. A crossing is certain if one leaf alone is in doubt from before it until after.
    pub fn combine(tree: &Tree, stretches: &[Stretches], ray: &Ray) -> Self {
        let mut changes = Vec::new();
        for (leaf, stretches) in stretches.iter().enumerate() {
            let mut change = |t, inside| changes.push(Change { t, leaf, inside });
            for possible in &stretches.possible {
                change(possible.min, None);
                change(possible.max, Some(false));
            }
            for certain in &stretches.certain {
                change(certain.min, Some(true));
                change(certain.max, None);
            }
        }
        changes.sort_by(|a, b| a.t.total_cmp(&b.t));
        let mut state = vec![Some(false); stretches.len()];
        let start = changes.partition_point(|change| change.t <= ray.tmin);
        let end = changes.partition_point(|change| change.t < ray.tmax);
        for change in &changes[..start] {
            state[change.leaf] = change.inside;
        }
        let mut naive = Self::default();
        let Some(mut inside) = tree.holds(&state) else {
            return naive;
        };
        // Since when the whole is in doubt, and the leaf that makes it so.
        let mut doubt: Option<(f64, usize)> = None;
        for change in &changes[start..end] {
            state[change.leaf] = change.inside;
            match (tree.holds(&state), doubt) {
                (Some(now), None) if now == inside => {}
                (None, _) => {
                    let (_, leaf) = *doubt.get_or_insert((change.t, change.leaf));
                    let alone = |(i, inside): (usize, &Option<bool>)| inside.is_some() || i == leaf;
                    if !state.iter().enumerate().all(alone) {
                        return naive;
                    }
                }
                (Some(now), Some((since, leaf))) if now != inside => {
                    inside = now;
                    doubt = None;
                    naive.crossings.push(Expected {
                        within: Interval {
                            min: since,
                            max: change.t,
                        },
                        operand: leaf as u32,
                        enter: now,
                    });
                }
                _ => return naive,
            }
        }
        naive.complete = doubt.is_none();
        naive
    }

    /// Whether `crossings` are these, as far as these go.
    pub fn agrees(&self, crossings: &[CsgCrossing]) -> bool {
        let enough = if self.complete {
            crossings.len() == self.crossings.len()
        } else {
            crossings.len() >= self.crossings.len()
        };
        let same = |(a, b): (&Expected, &CsgCrossing)| {
            (a.within.min..=a.within.max).contains(&b.t)
                && (a.operand, a.enter) == (b.operand, b.enter)
        };
        enough && self.crossings.iter().zip(crossings).all(same)
    }
}

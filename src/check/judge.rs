//! What the answers to one ray come to.

use crate::accel::Hit;
use crate::embree::EmbreeHit;
use crate::math::Ray;

use super::arbiter::{Answer, Claim, Rounding, Verdict};
use super::meshes::Spot;
use super::rays::Query;
use super::tally::{Outcome, Reason};
use super::{Answers, Checker};

/// The longest side's square over twice the area from which on a triangle counts as a sliver.
const SLIVER: f64 = 1000.0;

/// The sine of the angle below which a ray grazes.
const GRAZING: f64 = 0.0175;

impl Checker<'_> {
    /// Compares the answers to one ray, and asks the arbiter where they differ.
    pub fn judge(&self, query: &Query, answers: &Answers) -> Outcome {
        let mut outcome = Outcome {
            hit: !matches!(answers.ours, Answer::Closest(None) | Answer::Any(false)),
            ours_wrong: answers.dissent.is_some(),
            ..Outcome::default()
        };
        for (i, theirs) in answers.embree.iter().enumerate() {
            outcome.differs[i] = match (&answers.ours, theirs) {
                (Answer::Closest(Some(a)), Answer::Closest(Some(b))) => {
                    let bound = self
                        .dt_bound(query, a.spot)
                        .max(self.dt_bound(query, b.spot));
                    let dt = (a.t - b.t).abs();
                    if dt <= bound {
                        outcome.tie |= a.spot != b.spot;
                        let same = a.spot == b.spot && bound > 0.0;
                        outcome.dt = outcome.dt.max(if same { dt / bound } else { 0.0 });
                    }
                    dt > bound
                }
                (a, b) => a != b,
            };
        }
        if !outcome.differs.contains(&true) {
            return outcome;
        }
        let named = self.named(query, answers);
        let spots: Vec<Spot> = named.iter().map(|claim| claim.spot).collect();
        let wrong = |ray: &Ray, answer: &Answer, rounding: Rounding| {
            self.arbiter.judge(ray, answer, &spots, rounding) == Verdict::Wrong
        };
        outcome.ours_wrong |= wrong(&query.ray, &answers.ours, Rounding::F64);
        for (i, theirs) in answers.embree.iter().enumerate() {
            outcome.embree_wrong[i] =
                outcome.differs[i] && wrong(&query.peer, theirs, Rounding::F32);
        }
        if !outcome.ours_wrong && !outcome.embree_wrong.contains(&true) {
            outcome.reason = Some(self.reason(query, &named));
        }
        outcome
    }

    /// How far Embree's `t` may be from ours on a triangle: its rounding of corners and ray.
    fn dt_bound(&self, query: &Query, spot: Spot) -> f64 {
        let bound = self.arbiter.bound(&query.peer, spot, Rounding::F32);
        if query.ray == query.peer {
            return bound;
        }
        // Rounding the origin moves the ray as rounding the corners would move the triangle.
        let moved = query.ray.origin.distance(query.peer.origin);
        let [a, b, c] = self.arbiter.meshes().corners(spot);
        let normal = (b - a).cross(c - a);
        bound + moved * normal.length() / normal.dot(query.ray.direction).abs()
    }

    /// The hits that the answers speak of; where they only say whether there is any, the closest.
    fn named(&self, query: &Query, answers: &Answers) -> Vec<Claim> {
        let all = std::iter::once(&answers.ours).chain(&answers.embree);
        let mut named: Vec<Claim> = all
            .filter_map(|answer| match answer {
                Answer::Closest(claim) => *claim,
                Answer::Any(_) => None,
            })
            .collect();
        if matches!(answers.ours, Answer::Any(_)) {
            named.extend(
                self.ours[0]
                    .1
                    .intersect(&query.ray)
                    .as_ref()
                    .map(Claim::from),
            );
            let theirs = self.embree.iter().filter_map(|e| e.intersect(&query.peer));
            named.extend(theirs.map(|hit| Claim::from(&hit)));
        }
        named
    }

    /// Why answers differ, none of which is wrong.
    fn reason(&self, query: &Query, named: &[Claim]) -> Reason {
        let at_an_end = |claim: &Claim| {
            let slack = self.dt_bound(query, claim.spot);
            claim.t < query.peer.tmin + slack || claim.t > query.peer.tmax - slack
        };
        let shape = |claim: &Claim| {
            let [a, b, c] = self.arbiter.meshes().corners(claim.spot);
            let longest = (b - a).length_squared().max((c - a).length_squared());
            let normal = (b - a).cross(c - a);
            let sine = normal.dot(query.ray.direction) / query.ray.direction.length();
            (
                longest.max((c - b).length_squared()) / normal.length(),
                sine.abs() / normal.length(),
            )
        };
        if named.iter().any(|claim| shape(claim).0 > SLIVER) {
            Reason::Sliver
        } else if named.iter().any(|claim| shape(claim).1 < GRAZING) {
            Reason::Grazing
        } else if named.iter().any(at_an_end) {
            Reason::End
        } else {
            Reason::Edge
        }
    }
}

impl From<&Hit> for Claim {
    fn from(hit: &Hit) -> Self {
        Self {
            t: hit.t,
            spot: Spot {
                instance: hit.instance,
                primitive: hit.primitive,
            },
        }
    }
}

impl From<&EmbreeHit> for Claim {
    fn from(hit: &EmbreeHit) -> Self {
        Self {
            t: f64::from(hit.t),
            spot: Spot {
                instance: hit.geometry,
                primitive: hit.primitive,
            },
        }
    }
}

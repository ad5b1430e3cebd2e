use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::math::{Bounds, Ray};

use super::exact::volume_sign;
use super::index::BoxIndex;
use super::meshes::{Meshes, Spot};

/// What an engine says of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The closest hit.
    Closest(Option<Claim>),
    /// Whether there is any.
    Any(bool),
}

/// A hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Ray parameter.
    pub t: f64,
    /// The triangle.
    pub spot: Spot,
}

/// In which arithmetic an engine computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Ours.
    F64,
    /// Embree's.
    F32,
}

/// What the arbiter says of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is the answer to the ray, or to one that rounding cannot tell from it.
    Right,
    /// No ray near by has this answer.
    Wrong,
}

/// Knows the true hits: sides of edges are decided in exact arithmetic, so that of triangles around an edge or a
/// corner at least one is met. Shares no code with the traversal, but for the map of a ray to an instance's space.
#[derive(Debug)]
pub struct Arbiter<'a> {
    meshes: Meshes<'a>,
    /// Of each mesh's triangles, in object space.
    triangles: Vec<BoxIndex>,
    /// Of the placed meshes.
    instances: BoxIndex,
    /// The largest coordinate of anything.
    extent: f64,
}

impl<'a> Arbiter<'a> {
    /// Makes its index.
    pub fn new(meshes: Meshes<'a>) -> Self {
        let triangles = (meshes.meshes().iter()).map(|mesh| {
            let boxes: Vec<Bounds> = (0..mesh.triangles.len() as u32)
                .into_par_iter()
                .map(|i| Bounds::of_points(mesh.corners(i).map(Vec3::as_dvec3)))
                .collect();
            BoxIndex::new(&boxes)
        });
        let triangles = triangles.collect();
        let boxes: Vec<Bounds> = (meshes.iter())
            .map(|(mesh, transform)| transform.bounds(&mesh.bounds()))
            .collect();
        let all = boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        Self {
            triangles,
            instances: BoxIndex::new(&boxes),
            extent: all.min.abs().max(all.max.abs()).max_element(),
            meshes,
        }
    }

    /// What it judges by.
    pub fn meshes(&self) -> &Meshes<'a> {
        &self.meshes
    }

    /// The nearest hit between the ray's ends.
    pub fn nearest(&self, ray: &Ray) -> Option<Claim> {
        let mut best: Option<Claim> = None;
        let _ = self.visit(ray, |claim| {
            let end = best.map_or(ray.tmax, |best| best.t);
            if claim.t > ray.tmin && claim.t < end {
                best = Some(claim);
            }
            ControlFlow::Continue(best.map_or(ray.tmax, |best| best.t))
        });
        best
    }

    /// Where `ray` meets a triangle, its edges included, at whatever `t`; never one that it sees edge-on.
    pub fn meet(&self, ray: &Ray, spot: Spot) -> Option<f64> {
        let (_, transform) = self.meshes.placed(spot.instance);
        meet(
            &transform.inverse_ray(ray),
            self.meshes.object_corners(spot),
        )
    }

    /// Judges an answer by what the ray itself and some around it meet, as near as the engine's rounding may have moved
    /// it. A miss is wrong where all of them are blocked; a hit where its triangle is farther away than that, its `t`
    /// is off, or all of them are blocked before it; that there is any hit, where none of them has one. `named` are the triangles that anybody's answer to this ray speaks
    /// of: the farther and larger they are, the more is rounded.
    pub fn judge(&self, ray: &Ray, answer: &Answer, named: &[Spot], rounding: Rounding) -> Verdict {
        let blurs = named.iter().map(|&spot| self.blur(ray, spot, rounding));
        let blur = (blurs.reduce(f64::max))
            .unwrap_or_else(|| rounding.unit() * (self.extent + ray.origin.abs().max_element()));
        let allowed = match *answer {
            Answer::Closest(None) | Answer::Any(false) => {
                around(ray, blur).any(|near| !self.certainly_blocked(&near, near.tmax, rounding))
            }
            Answer::Closest(Some(claim)) => {
                let slack = self.bound(ray, claim.spot, rounding);
                let at = self.plane(ray, claim.spot);
                let off = (at - claim.t).abs() > slack;
                let beyond = claim.t < ray.tmin - slack || claim.t > ray.tmax + slack;
                !off && !beyond
                    && self.passes(ray, claim.spot, blur)
                    && around(ray, blur)
                        .any(|near| !self.certainly_blocked(&near, claim.t - slack, rounding))
            }
            Answer::Any(true) => {
                let touches = |&spot: &Spot| {
                    let slack = self.bound(ray, spot, rounding);
                    let at = self.plane(ray, spot);
                    at > ray.tmin - slack && at < ray.tmax + slack && self.passes(ray, spot, blur)
                };
                named.iter().any(touches)
                    || around(ray, blur).any(|near| self.nearest(&near).is_some())
            }
        };
        if allowed {
            Verdict::Right
        } else {
            Verdict::Wrong
        }
    }

    /// How far from the truth an engine's `t` may be on a triangle: what was rounded, at the angle at which the ray
    /// meets it. The edge functions of a sliver cancel, so their error counts against its area.
    pub fn bound(&self, ray: &Ray, spot: Spot, rounding: Rounding) -> f64 {
        let [a, b, c] = self.meshes.corners(spot);
        let longest = (b - a).length_squared().max((c - a).length_squared());
        let longest = longest.max((c - b).length_squared());
        let facing = (b - a).cross(c - a).dot(ray.direction).abs();
        self.blur(ray, spot, rounding) * longest / facing
    }

    /// How far, in world units, the corners of a triangle may be off as seen from the ray's origin.
    fn blur(&self, ray: &Ray, spot: Spot, rounding: Rounding) -> f64 {
        let corners = self.meshes.corners(spot);
        let largest = |points: [DVec3; 3]| {
            let sizes = points.map(|p| p.abs().max_element());
            sizes.into_iter().fold(0.0, f64::max)
        };
        let reach = largest(corners.map(|p| p - ray.origin));
        let position = largest(corners);
        let both = position + ray.origin.abs().max_element();
        let exact = Rounding::F64.unit() * (reach + both * self.meshes.condition(spot.instance));
        let (_, transform) = self.meshes.placed(spot.instance);
        match rounding {
            Rounding::F64 => exact,
            Rounding::F32 if transform.is_identity() => exact + rounding.unit() * reach,
            // Embree is given corners in world space.
            Rounding::F32 => exact + rounding.unit() * (reach + 0.25 * position),
        }
    }

    /// Whether a triangle is met after the ray's start and before `end`, both by more than rounding.
    fn certainly_blocked(&self, ray: &Ray, end: f64, rounding: Rounding) -> bool {
        let ray = Ray { tmax: end, ..*ray };
        let found = self.visit(&ray, |claim| {
            let slack = self.bound(&ray, claim.spot, rounding);
            if claim.t - slack > ray.tmin && claim.t + slack < ray.tmax {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(ray.tmax)
            }
        });
        found.is_break()
    }

    /// Where the ray goes through a triangle's plane.
    fn plane(&self, ray: &Ray, spot: Spot) -> f64 {
        let [a, b, c] = self.meshes.corners(spot);
        let normal = (b - a).cross(c - a);
        normal.dot(a - ray.origin) / normal.dot(ray.direction)
    }

    /// Whether the ray's line meets a triangle or passes it within `blur`.
    fn passes(&self, ray: &Ray, spot: Spot, blur: f64) -> bool {
        if self.meet(ray, spot).is_some() {
            return true;
        }
        let d = ray.direction.normalize();
        let seen = self.meshes.corners(spot).map(|p| {
            let p = p - ray.origin;
            p - p.dot(d) * d
        });
        let distance = |a: DVec3, b: DVec3| {
            let along = b - a;
            let nearest =
                (-a.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (a + nearest * along).length()
        };
        (0..3).any(|i| distance(seen[i], seen[(i + 1) % 3]) <= blur)
    }

    /// Shows `visit` every hit on the line of `ray` that is not clearly outside of its ends; `visit` says how far the
    /// ray still matters, or that it has seen enough.
    fn visit(
        &self,
        ray: &Ray,
        mut visit: impl FnMut(Claim) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let mut end = ray.tmax;
        self.instances.visit(ray, |instance| {
            let (mesh, transform) = self.meshes.placed(instance);
            let local = transform.inverse_ray(&Ray { tmax: end, ..*ray });
            self.triangles[mesh].visit(&local, |primitive| {
                let spot = Spot {
                    instance,
                    primitive,
                };
                if let Some(t) = meet(&local, self.meshes.object_corners(spot)) {
                    end = visit(Claim { t, spot })?;
                }
                ControlFlow::Continue(end)
            })?;
            ControlFlow::Continue(end)
        })
    }
}

impl Rounding {
    /// Relative to distances: some sixteen roundings of f32, some five hundred of f64.
    fn unit(self) -> f64 {
        2.0_f64.powi(match self {
            Self::F32 => -20,
            Self::F64 => -44,
        })
    }
}

/// `ray`, and parallel rays that fill a disk around it evenly, from the middle outward (Vogel 1979).
fn around(ray: &Ray, radius: f64) -> impl Iterator<Item = Ray> {
    const COUNT: u32 = 400;
    let (x, y) = ray.direction.normalize().any_orthonormal_pair();
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    (0..=COUNT).map(move |i| {
        let (sin, cos) = (golden_angle * f64::from(i)).sin_cos();
        let distance = radius * (f64::from(i) / f64::from(COUNT)).sqrt();
        Ray {
            origin: ray.origin + distance * (cos * x + sin * y),
            ..*ray
        }
    })
}

fn meet(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (o, d) = (ray.origin, ray.direction);
    let u = volume_sign(o, d, b, c);
    let v = volume_sign(o, d, c, a);
    if u * v < 0.0 {
        return None;
    }
    let w = volume_sign(o, d, a, b);
    let inside = u.min(v).min(w) >= 0.0 || u.max(v).max(w) <= 0.0;
    if !inside || (u, v, w) == (0.0, 0.0, 0.0) {
        return None;
    }
    let normal = (b - a).cross(c - a);
    let t = normal.dot(a - o) / normal.dot(d);
    // Rounding can take all of a sliver's normal.
    Some(if t.is_finite() {
        t
    } else {
        d.dot(a - o) / d.length_squared()
    })
}

use glam::{DVec3, Vec3};

use crate::geometry::Mesh;
use crate::math::Ray;

/// What the arbiter says of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is right, or the difference is within the arbiter's own rounding.
    Right,
    /// It is certainly wrong.
    Wrong,
}

/// Tests a ray against every triangle in f64 by signed volumes, each with a bound on its own rounding:
/// what is not certain does not count against anybody. Shares no code with the traversal.
#[derive(Debug)]
pub struct Arbiter<'a> {
    mesh: &'a Mesh,
}

/// One triangle's answer.
#[derive(Clone, Copy, PartialEq)]
enum Answer {
    Miss,
    /// Within rounding of an edge.
    Perhaps(f64),
    Hit(f64),
}

impl<'a> Arbiter<'a> {
    /// Judges rays against `mesh`.
    pub fn new(mesh: &'a Mesh) -> Self {
        Self { mesh }
    }

    /// Judges the answer `(t, primitive)`, or a miss. A hit is wrong where its triangle is certainly
    /// not met, its `t` differs by more than the part `tolerance`, or a certain hit lies before it by
    /// more than that; a miss is wrong where there is a certain hit.
    pub fn judge(&self, ray: &Ray, answer: Option<(f64, u32)>, tolerance: f64) -> Verdict {
        let mut nearest = f64::INFINITY;
        for primitive in 0..self.mesh.triangles.len() as u32 {
            if let Answer::Hit(t) = self.test(ray, primitive)
                && t > ray.tmin
                && t < ray.tmax
            {
                nearest = nearest.min(t);
            }
        }
        let Some((t, primitive)) = answer else {
            return if nearest.is_finite() {
                Verdict::Wrong
            } else {
                Verdict::Right
            };
        };
        let wrong = match self.test(ray, primitive) {
            Answer::Miss => true,
            Answer::Perhaps(_) => nearest < t * (1.0 - tolerance),
            Answer::Hit(own) => {
                (own - t).abs() > tolerance * t.abs() || nearest < t * (1.0 - tolerance)
            }
        };
        if wrong {
            Verdict::Wrong
        } else {
            Verdict::Right
        }
    }

    fn test(&self, ray: &Ray, primitive: u32) -> Answer {
        let corners = self.mesh.corners(primitive).map(Vec3::as_dvec3);
        let [a, b, c] = corners.map(|p| p - ray.origin);
        let d = ray.direction;
        // Six times the volume of the origin, an edge and the direction: which side the edge passes.
        let volume = |p: DVec3, q: DVec3| d.dot(p.cross(q));
        let volumes = [volume(b, c), volume(c, a), volume(a, b)];
        // Each is a sum of six triple products; every product and sum rounds by 2^-53 at most.
        let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
        let doubt = 64.0 * f64::EPSILON * reach * reach * d.abs().max_element();
        let certain = |sign: f64| volumes.iter().all(|v| sign * v > doubt);
        let possible = |sign: f64| volumes.iter().all(|v| sign * v >= -doubt);
        if !possible(1.0) && !possible(-1.0) {
            return Answer::Miss;
        }
        let normal = (b - a).cross(c - a);
        let t = normal.dot(a) / normal.dot(d);
        if t.is_finite() && (certain(1.0) || certain(-1.0)) {
            Answer::Hit(t)
        } else {
            Answer::Perhaps(t)
        }
    }
}

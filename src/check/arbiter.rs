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
    /// A sphere around each triangle: centre and squared radius, generously rounded up.
    spheres: Vec<(DVec3, f64)>,
}

/// One triangle's answer.
#[derive(Clone, Copy, PartialEq)]
enum Answer {
    Miss,
    /// Within rounding of an edge.
    Perhaps,
    Hit(f64),
}

impl<'a> Arbiter<'a> {
    /// Judges rays against `mesh`.
    pub fn new(mesh: &'a Mesh) -> Self {
        let spheres = (0..mesh.triangles.len() as u32).map(|i| {
            let corners = mesh.corners(i).map(Vec3::as_dvec3);
            let center = (corners[0] + corners[1] + corners[2]) / 3.0;
            let radius2 = corners.map(|p| p.distance_squared(center));
            (center, 1.001 * radius2.into_iter().fold(0.0, f64::max))
        });
        Self {
            mesh,
            spheres: spheres.collect(),
        }
    }

    /// The nearest certain hit in `tmin..tmax`; infinite where there is none.
    pub fn nearest(&self, ray: &Ray) -> f64 {
        let d2 = ray.direction.length_squared();
        let near = |(center, radius2): &(DVec3, f64)| {
            let off = (*center - ray.origin).cross(ray.direction);
            off.length_squared() <= radius2 * d2
        };
        (self.spheres.iter().zip(0_u32..))
            .filter(|(sphere, _)| near(sphere))
            .filter_map(|(_, primitive)| match self.test(ray, primitive) {
                Answer::Hit(t) if t > ray.tmin && t < ray.tmax => Some(t),
                _ => None,
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Judges the answer `(t, primitive)`, or a miss, knowing the [`Arbiter::nearest`] certain hit. A hit
    /// is wrong where its triangle is certainly not met, its `t` differs by more than the part
    /// `tolerance`, or a certain hit lies before it by more than that; a miss is wrong where there is a
    /// certain hit.
    pub fn judge(
        &self,
        ray: &Ray,
        nearest: f64,
        answer: Option<(f64, u32)>,
        tolerance: f64,
    ) -> Verdict {
        let Some((t, primitive)) = answer else {
            return if nearest.is_finite() {
                Verdict::Wrong
            } else {
                Verdict::Right
            };
        };
        let wrong = match self.test(ray, primitive) {
            Answer::Miss => true,
            Answer::Perhaps => nearest < t * (1.0 - tolerance),
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
            Answer::Perhaps
        }
    }
}

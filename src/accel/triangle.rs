use glam::{DVec3, Vec3};

use super::ray::TreeRay;

/// A triangle's corners relative to its tree's centre, exact, with its index in the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub corners: [Vec3; 3],
    pub primitive: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleHit {
    /// Ray parameter.
    pub t: f64,
    /// Barycentric weights of the second and third corner.
    pub u: f64,
    pub v: f64,
    /// Whether the ray comes from the side that the triangle faces away from.
    pub inside: bool,
}

impl Triangle {
    /// The watertight test of Woop, Benthin and Wald 2013: corners are sheared into the ray's frame by
    /// operations that depend on the corner alone, and the sign of an edge function of rounded products
    /// is right or 0, so triangles that share an edge or a corner leave no gap.
    ///
    /// f32 turns away what certainly misses; what is left is decided in f64.
    #[inline]
    pub(super) fn intersect(&self, ray: &TreeRay) -> Option<TriangleHit> {
        let [x, y, z] = ray.axes;
        let mut p = [Vec3::ZERO; 3];
        let mut size = 0.0_f32;
        for (p, corner) in p.iter_mut().zip(&self.corners) {
            let relative = *corner - ray.origin;
            p.x = relative[x] - relative[z] * ray.shear[0];
            p.y = relative[y] - relative[z] * ray.shear[1];
            size = size.max(p.x.abs()).max(p.y.abs());
        }
        let [a, b, c] = p;
        let edge = |p: Vec3, q: Vec3| q.x * p.y - q.y * p.x;
        let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
        // Each coordinate is within `slack` of its true value: see `TreeRay`.
        let doubt = ray.slack * (5.0 * size + 2.0 * ray.slack);
        let missed = u.min(v).min(w) < -doubt && u.max(v).max(w) > doubt;
        if missed { None } else { self.decide(ray) }
    }

    fn decide(&self, ray: &TreeRay) -> Option<TriangleHit> {
        let [x, y, z] = ray.axes;
        let [a, b, c] = self.corners.map(|corner| {
            let relative = corner.as_dvec3() - ray.exact_origin;
            DVec3::new(
                relative[x] - relative[z] * ray.exact_shear[0],
                relative[y] - relative[z] * ray.exact_shear[1],
                relative[z],
            )
        });
        let edge = |p: DVec3, q: DVec3| q.x * p.y - q.y * p.x;
        let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        (det != 0.0).then(|| TriangleHit {
            t: (u * a.z + v * b.z + w * c.z) / (det * ray.length),
            u: v / det,
            v: w / det,
            inside: (det < 0.0) == (ray.length > 0.0),
        })
    }
}

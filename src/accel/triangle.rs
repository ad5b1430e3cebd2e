use glam::{DVec3, Vec3};

use super::ray::TreeRay;

/// A triangle's corners relative to its tree's centre, with its index in the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub corners: [Vec3; 3],
    pub primitive: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleHit {
    /// In units of the tree ray.
    pub t: f64,
    /// Barycentric weights of the second and third corner.
    pub u: f64,
    pub v: f64,
}

impl Triangle {
    /// The watertight test of Woop, Benthin and Wald 2013: corners are sheared into the ray's frame by
    /// operations that depend on the corner alone, and the signs of the edge functions are exact, so
    /// triangles that share an edge or a corner leave no gap.
    #[inline]
    pub(super) fn intersect(&self, ray: &TreeRay) -> Option<TriangleHit> {
        let [x, y, z] = ray.axes;
        let mut p = [Vec3::ZERO; 3];
        for (p, corner) in p.iter_mut().zip(&self.corners) {
            let relative = *corner - ray.origin;
            p.z = relative[z];
            p.x = relative[x] - p.z * ray.shear[0];
            p.y = relative[y] - p.z * ray.shear[1];
        }
        let [a, b, c] = p;
        // Rounding is monotonic, so each difference of two rounded products has the right sign or is 0.
        let edge = |p: Vec3, q: Vec3| q.x * p.y - q.y * p.x;
        let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
        let outside = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        if outside {
            None
        } else {
            exact(a.into(), b.into(), c.into(), ray)
        }
    }
}

/// Decides the lanes that f32 let through: products of f32 are exact in f64, so the signs are exact
/// here, and slivers keep an accurate `t`.
fn exact(a: DVec3, b: DVec3, c: DVec3, ray: &TreeRay) -> Option<TriangleHit> {
    let edge = |p: DVec3, q: DVec3| q.x * p.y - q.y * p.x;
    let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = u + v + w;
    if det == 0.0 {
        return None;
    }
    Some(TriangleHit {
        t: (u * a.z + v * b.z + w * c.z) / (det * ray.length),
        u: v / det,
        v: w / det,
    })
}

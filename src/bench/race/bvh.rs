use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::Bvh;
use bvh::ray::Ray as BvhRay;
use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::Mesh;
use crate::math::Ray;

use super::engine::{Answers, Engine};

/// A tree of the crate `bvh`, walked by its iterator from near to far: the others keep 32 entries at most, which
/// the trees of large meshes exceed.
pub(super) struct BvhCrate {
    tree: Bvh<f32, 3>,
    triangles: Vec<Triangle>,
}

/// Seen from both sides, which the crate's own test is not.
struct Triangle {
    corner: Vec3,
    edges: [Vec3; 2],
    node: usize,
}

impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        let corners = [
            self.corner,
            self.corner + self.edges[0],
            self.corner + self.edges[1],
        ];
        let min = corners.into_iter().fold(Vec3::INFINITY, Vec3::min);
        let max = corners.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
        Aabb::with_bounds(min.to_array().into(), max.to_array().into())
    }
}

impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Triangle {
    /// Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
    fn intersect(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        let [e1, e2] = self.edges;
        let p = direction.cross(e2);
        let inverse = 1.0 / e1.dot(p);
        let to_origin = origin - self.corner;
        let u = to_origin.dot(p) * inverse;
        let q = to_origin.cross(e1);
        let v = direction.dot(q) * inverse;
        let t = e2.dot(q) * inverse;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
    }
}

/// The crate's rays have no end.
pub(super) struct Segment {
    ray: BvhRay<f32, 3>,
    tmax: f32,
}

impl BvhCrate {
    pub(super) fn build(mesh: &Mesh) -> Self {
        let corners = (0..mesh.triangles.len() as u32)
            .into_par_iter()
            .map(|i| mesh.corners(i));
        let mut triangles: Vec<Triangle> = corners
            .map(|[a, b, c]| Triangle {
                corner: a,
                edges: [b - a, c - a],
                node: 0,
            })
            .collect();
        Self {
            tree: Bvh::build_par(&mut triangles),
            triangles,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.tree.nodes) + size_of_val(&*self.triangles)
    }

    /// The closest hit, or the first that is found.
    fn hit(&self, segment: &Segment, any: bool) -> Option<f32> {
        let Segment { ray, tmax } = segment;
        let (origin, direction) = (
            Vec3::from_array(ray.origin.into()),
            Vec3::from_array(ray.direction.into()),
        );
        let mut best = None;
        let mut limit = *tmax;
        for triangle in self.tree.nearest_traverse_iterator(ray, &self.triangles) {
            if let Some(t) = triangle.intersect(origin, direction)
                && t < limit
            {
                (best, limit) = (Some(t), t);
                if any {
                    break;
                }
            }
            // Boxes come in order: what follows starts no nearer than this one.
            let span = ray.intersection_slice_for_aabb(&triangle.aabb());
            if span.is_some_and(|(near, _)| near > limit) {
                break;
            }
        }
        best
    }
}

impl Engine for BvhCrate {
    type Ray = Segment;

    fn load(&self, rays: &[Ray]) -> Vec<Segment> {
        let load = |ray: &Ray| Segment {
            ray: BvhRay::new(
                ray.origin.as_vec3().to_array().into(),
                ray.direction.as_vec3().to_array().into(),
            ),
            tmax: ray.tmax as f32,
        };
        rays.iter().map(load).collect()
    }

    fn closest(&self, rays: &[Segment]) -> Answers {
        let hits = rays.iter().filter_map(|ray| self.hit(ray, false));
        hits.fold(Answers::default(), |sum, t| sum.with(f64::from(t)))
    }

    fn any(&self, rays: &[Segment]) -> Answers {
        Answers::of_blocked(rays.iter().map(|ray| self.hit(ray, true).is_some()))
    }
}

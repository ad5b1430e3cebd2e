use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use crate::geometry::Mesh;
use crate::math::Ray;

use super::engine::{Answers, Engine};

/// A tree of the crate `obvhs`, walked by its own code; triangles lie in the order of the leaves.
pub(super) struct Obvhs<Tree> {
    tree: Tree,
    triangles: Vec<RtTriangle>,
}

fn triangles(mesh: &Mesh) -> Vec<Triangle> {
    let corners = (0..mesh.triangles.len() as u32).map(|i| mesh.corners(i));
    corners
        .map(|[v0, v1, v2]| Triangle {
            v0: v0.into(),
            v1: v1.into(),
            v2: v2.into(),
        })
        .collect()
}

fn in_order(triangles: &[Triangle], order: &[u32]) -> Vec<RtTriangle> {
    order
        .iter()
        .map(|&i| RtTriangle::from(&triangles[i as usize]))
        .collect()
}

impl Obvhs<Bvh2> {
    pub(super) fn build(mesh: &Mesh) -> Self {
        let triangles = triangles(mesh);
        let parameters = BvhBuildParams::medium_build();
        let tree = build_bvh2_from_tris(&triangles, parameters, &mut Duration::default());
        Self {
            triangles: in_order(&triangles, &tree.primitive_indices),
            tree,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.tree.nodes) + size_of_val(&*self.triangles)
    }
}

impl Obvhs<CwBvh> {
    pub(super) fn build(mesh: &Mesh) -> Self {
        let triangles = triangles(mesh);
        let parameters = BvhBuildParams::medium_build();
        let tree = build_cwbvh_from_tris(&triangles, parameters, &mut Duration::default());
        Self {
            triangles: in_order(&triangles, &tree.primitive_indices),
            tree,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.tree.nodes) + size_of_val(&*self.triangles)
    }
}

/// The two trees have the same queries, but no trait for them.
macro_rules! engine {
    ($tree:ty) => {
        impl Engine for Obvhs<$tree> {
            type Ray = ObvhsRay;

            fn load(&self, rays: &[Ray]) -> Vec<ObvhsRay> {
                rays.iter().map(to_obvhs).collect()
            }

            fn closest(&self, rays: &[ObvhsRay]) -> Answers {
                let answer = |sum: Answers, ray: &ObvhsRay| {
                    let mut hit = RayHit::none();
                    let test = |ray: &ObvhsRay, id: usize| self.triangles[id].intersect(ray);
                    self.tree.ray_traverse(*ray, &mut hit, test);
                    let is_hit = std::hint::black_box(hit).primitive_id != u32::MAX;
                    if is_hit {
                        sum.with(f64::from(hit.t))
                    } else {
                        sum
                    }
                };
                rays.iter().fold(Answers::default(), answer)
            }

            fn any(&self, rays: &[ObvhsRay]) -> Answers {
                let test = |ray: &ObvhsRay, id: usize| self.triangles[id].intersect(ray);
                let blocked = |ray: &ObvhsRay| !self.tree.ray_traverse_miss(*ray, test);
                Answers::of_blocked(rays.iter().map(blocked))
            }
        }
    };
}

engine!(Bvh2);
engine!(CwBvh);

fn to_obvhs(ray: &Ray) -> ObvhsRay {
    ObvhsRay::new(
        ray.origin.as_vec3a(),
        ray.direction.as_vec3a(),
        ray.tmin as f32,
        ray.tmax as f32,
    )
}

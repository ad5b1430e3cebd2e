use parry3d::math::Vector;
use parry3d::query::{Ray as ParryRay, RayCast};
use parry3d::shape::TriMesh;

use crate::error::{Error, Result};
use crate::geometry::Mesh;
use crate::math::Ray;

use super::engine::{Answers, Engine};

/// The triangle mesh of the crate `parry3d`.
pub(super) struct Parry(TriMesh);

/// The crate's rays have no end.
pub(super) struct Segment {
    ray: ParryRay,
    tmax: f32,
}

impl Parry {
    pub(super) fn build(mesh: &Mesh) -> Result<Self> {
        let vertices = mesh
            .positions
            .iter()
            .map(|p| Vector::from_array(p.to_array()));
        TriMesh::new(vertices.collect(), mesh.triangles.clone())
            .map(Self)
            .map_err(|e| Error::input(format!("parry3d does not take the mesh: {e}")))
    }
}

impl Engine for Parry {
    type Ray = Segment;

    fn load(&self, rays: &[Ray]) -> Vec<Segment> {
        let vector = |v: glam::DVec3| Vector::from_array(v.as_vec3().to_array());
        let load = |ray: &Ray| Segment {
            ray: ParryRay::new(vector(ray.origin), vector(ray.direction)),
            tmax: ray.tmax as f32,
        };
        rays.iter().map(load).collect()
    }

    fn closest(&self, rays: &[Segment]) -> Answers {
        let hits = rays
            .iter()
            .filter_map(|s| self.0.cast_local_ray(&s.ray, s.tmax, false));
        hits.fold(Answers::default(), |sum, t| sum.with(f64::from(t)))
    }

    fn any(&self, rays: &[Segment]) -> Answers {
        let blocked = |s: &Segment| self.0.intersects_local_ray(&s.ray, s.tmax);
        Answers::of_blocked(rays.iter().map(blocked))
    }
}

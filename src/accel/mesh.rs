use std::ops::{ControlFlow, Range};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::Mesh;
use crate::math::{Bounds, Ray};

use super::ray::TreeRay;
use super::tree::Tree;
use super::triangle::{Triangle, TriangleHit};

/// What building a mesh's tree found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// Triangles in the tree.
    pub triangles: usize,
    /// Triangles left out because they have no area.
    pub degenerate: usize,
    /// Triangles left out because an earlier one has the same corners.
    pub duplicate: usize,
    /// Bytes of the tree and its triangles.
    pub bytes: usize,
}

/// A tree over a mesh's triangles.
#[derive(Debug)]
pub(super) struct MeshTree {
    tree: Tree,
    triangles: Vec<Triangle>,
    pub bounds: Bounds,
    pub report: MeshReport,
    /// Triangles left out, ascending.
    pub dropped: Vec<u32>,
}

/// Squares of distances beyond this leave the range of f32.
const LARGEST: f64 = 1e18;

impl MeshTree {
    /// # Errors
    /// Where no triangle has an area, or coordinates lie beyond ±1e18.
    pub(super) fn build(mesh: &Mesh) -> Result<Self> {
        mesh.validate()?;
        let bounds = mesh.bounds();
        if bounds.min.abs().max(bounds.max.abs()).max_element() > LARGEST {
            return Err(Error::input(format!(
                "the mesh reaches from {} to {}, beyond ±{LARGEST:e}",
                bounds.min, bounds.max
            ))
            .help("scale the model down"));
        }
        let (kept, mut report) = distinct(mesh);
        if kept.is_empty() {
            return Err(Error::input(format!(
                "none of the mesh's {} triangles has an area",
                mesh.triangles.len()
            ))
            .help("check that the model's vertices are not all in one place or on one line"));
        }
        let boxes: Vec<Bounds> = kept
            .par_iter()
            .map(|&i| Bounds::of_points(mesh.corners(i).map(Vec3::as_dvec3)))
            .collect();
        let (tree, order) = Tree::build(&boxes);
        let center = tree.center;
        let triangles: Vec<Triangle> = order
            .par_iter()
            .map(|&position| {
                let primitive = kept[position as usize];
                Triangle {
                    corners: mesh
                        .corners(primitive)
                        .map(|p| (p.as_dvec3() - center).as_vec3()),
                    primitive,
                }
            })
            .collect();
        report.bytes = tree.bytes() + size_of_val(triangles.as_slice());
        Ok(Self {
            tree,
            triangles,
            bounds,
            report,
            dropped: (0..mesh.triangles.len() as u32)
                .filter(|i| kept.binary_search(i).is_err())
                .collect(),
        })
    }

    /// The closest hit in `ray.tmin..ray.tmax`; of equal `t` the lowest primitive, whatever the tree
    /// looks like.
    pub(super) fn intersect(&self, ray: &Ray) -> Option<(TriangleHit, u32)> {
        let local = TreeRay::new(ray, self.tree.center, self.tree.extent);
        let start = local.box_start(ray.tmin);
        let mut limit = ray.tmax;
        let mut best: Option<(TriangleHit, u32)> = None;
        let _ = self
            .tree
            .traverse(&local, start, local.box_limit(limit), |leaf| {
                for triangle in self.leaf(leaf) {
                    let Some(hit) = triangle.intersect(&local) else {
                        continue;
                    };
                    let tie = best.is_some_and(|(b, id)| hit.t == b.t && triangle.primitive < id);
                    if hit.t > ray.tmin && (hit.t < limit || tie) {
                        limit = hit.t;
                        best = Some((hit, triangle.primitive));
                    }
                }
                ControlFlow::Continue(local.box_limit(limit))
            });
        best
    }

    /// Whether any triangle lies in `ray.tmin..ray.tmax`.
    pub(super) fn occluded(&self, ray: &Ray) -> bool {
        let local = TreeRay::new(ray, self.tree.center, self.tree.extent);
        let limit = local.box_limit(ray.tmax);
        (self.tree)
            .traverse(&local, local.box_start(ray.tmin), limit, |leaf| {
                let blocked = (self.leaf(leaf).iter())
                    .filter_map(|triangle| triangle.intersect(&local))
                    .any(|hit| hit.t > ray.tmin && hit.t < ray.tmax);
                if blocked {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(limit)
                }
            })
            .is_break()
    }

    fn leaf(&self, positions: Range<u32>) -> &[Triangle] {
        &self.triangles[positions.start as usize..positions.end as usize]
    }
}

/// The triangles with an area, the first of each set with equal corners, in order.
fn distinct(mesh: &Mesh) -> (Vec<u32>, MeshReport) {
    let with_area: Vec<u32> = (0..mesh.triangles.len() as u32)
        .into_par_iter()
        .filter(|&i| {
            let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
            (b - a).cross(c - a) != DVec3::ZERO
        })
        .collect();
    // Equal corners in any order: sorted, they are equal keys, and the lowest index comes first.
    let mut keys: Vec<([[u32; 3]; 3], u32)> = with_area
        .par_iter()
        .map(|&i| {
            // Adding 0 makes -0 and 0 one.
            let mut key = mesh
                .corners(i)
                .map(|p| (p + Vec3::ZERO).to_array().map(f32::to_bits));
            key.sort_unstable();
            (key, i)
        })
        .collect();
    keys.par_sort_unstable();
    keys.dedup_by(|later, earlier| later.0 == earlier.0);
    let mut kept: Vec<u32> = keys.into_iter().map(|(_, i)| i).collect();
    kept.par_sort_unstable();
    let report = MeshReport {
        triangles: kept.len(),
        degenerate: mesh.triangles.len() - with_area.len(),
        duplicate: with_area.len() - kept.len(),
        bytes: 0,
    };
    (kept, report)
}

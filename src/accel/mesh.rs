use std::ops::{ControlFlow, Range};

use glam::{DVec2, DVec3, Vec3};
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

/// Where a ray goes through a mesh's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshCrossing {
    /// Ray parameter.
    pub t: f64,
    /// The triangle's index in its file.
    pub primitive: u32,
    /// Whether it comes from the outer side of the triangle.
    pub enter: bool,
    /// The triangle's outward normal, of any length.
    pub n: DVec3,
}

/// A tree over a mesh's triangles.
#[derive(Debug)]
pub(super) struct MeshTree {
    pub tree: Tree,
    triangles: Vec<Triangle>,
    pub bounds: Bounds,
    pub report: MeshReport,
    /// Triangles left out, ascending.
    pub dropped: Vec<u32>,
}

/// A box costs as much as a few triangles.
const TRIANGLES: u32 = 4;

/// Squares of distances beyond this leave the range of f32.
const LARGEST: f64 = 1e18;

impl MeshTree {
    /// For the closest hit and for any.
    ///
    /// # Errors
    /// Where no triangle has an area, or coordinates lie beyond ±1e18.
    pub(super) fn build(mesh: &Mesh) -> Result<Self> {
        Self::over(mesh, distinct)
    }

    /// For all crossings along a ray: only triangles with two equal corners are left out, because without others a
    /// closed mesh would be open.
    ///
    /// # Errors
    /// Where all triangles are left out, or coordinates lie beyond ±1e18.
    pub(super) fn build_operand(mesh: &Mesh) -> Result<Self> {
        Self::over(mesh, cornered)
    }

    /// Over the triangles that `choose` names, in order.
    fn over(mesh: &Mesh, choose: impl Fn(&Mesh) -> (Vec<u32>, MeshReport)) -> Result<Self> {
        mesh.validate()?;
        let bounds = mesh.bounds();
        if bounds.min.abs().max(bounds.max.abs()).max_element() > LARGEST {
            return Err(Error::input(format!(
                "the mesh reaches from {} to {}, beyond ±{LARGEST:e}",
                bounds.min, bounds.max
            ))
            .help("scale the model down"));
        }
        let (kept, mut report) = choose(mesh);
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
        let (tree, order) = Tree::build(&boxes, TRIANGLES);
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

    /// Every crossing with `t > ray.tmin`, in no order. A closed mesh is entered as often as it is left along a whole
    /// line, and in order of `t` the count tells how often the mesh winds around the points between.
    pub(super) fn crossings(&self, ray: &Ray, mut visit: impl FnMut(MeshCrossing)) {
        let local = TreeRay::new(ray, self.tree.center, self.tree.extent);
        let start = local.box_start(ray.tmin);
        let _ = (self.tree).traverse(&local, start, f32::INFINITY, |leaf| {
            for triangle in self.leaf(leaf) {
                if let Some(hit) = triangle.crossing(&local)
                    && hit.t > ray.tmin
                {
                    visit(MeshCrossing {
                        t: hit.t,
                        primitive: triangle.primitive,
                        enter: !hit.inside,
                        n: triangle.normal(),
                    });
                }
            }
            ControlFlow::Continue(f32::INFINITY)
        });
    }

    /// Barycentric weights of the second and third corner of `primitive`, which `ray` crosses at `t`.
    pub(super) fn barycentric(&self, ray: &Ray, t: f64, primitive: u32) -> DVec2 {
        let local = TreeRay::new(ray, self.tree.center, self.tree.extent);
        let (start, end) = (local.box_start(t), local.box_limit(t));
        let mut weights = DVec2::splat(1.0 / 3.0);
        let _ = self.tree.traverse(&local, start, end, |leaf| {
            match (self.leaf(leaf).iter()).find(|triangle| triangle.primitive == primitive) {
                Some(triangle) => {
                    weights = triangle.weights(&local);
                    ControlFlow::Break(())
                }
                None => ControlFlow::Continue(end),
            }
        });
        weights
    }

    /// How often a closed mesh winds around `p`: 1 inside and 0 outside of a simple one.
    pub(super) fn winding(&self, p: DVec3) -> i32 {
        let mut winding = 0;
        self.crossings(&Ray::new(p, DVec3::Z), |crossing| {
            winding += if crossing.enter { -1 } else { 1 };
        });
        winding
    }

    /// The triangles of a leaf.
    pub(super) fn leaf(&self, positions: Range<u32>) -> &[Triangle] {
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

/// The triangles whose corners differ.
fn cornered(mesh: &Mesh) -> (Vec<u32>, MeshReport) {
    let kept: Vec<u32> = (0..mesh.triangles.len() as u32)
        .filter(|&i| {
            let [a, b, c] = mesh.corners(i);
            a != b && b != c && c != a
        })
        .collect();
    let report = MeshReport {
        triangles: kept.len(),
        degenerate: mesh.triangles.len() - kept.len(),
        ..MeshReport::default()
    };
    (kept, report)
}

#[cfg(test)]
mod tests;

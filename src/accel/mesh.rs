mod choice;

use std::ops::ControlFlow;

use glam::{DVec2, DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::Mesh;
use crate::math::{Bounds, Ray};
use crate::memory::Pages;

use super::options::AccelOptions;
use super::ray::{TreeRay, fits_kernels};
use super::triangle::{Triangle, TriangleHit};
use choice::{cornered, distinct};

use super::wide::{Block, Entrant, Kernel, LANES, Task, Walk, WideTree};

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
    tree: WideTree,
    leaves: Pages<Block>,
    /// Corners are stored relative to this point.
    pub center: DVec3,
    /// The largest coordinate from there.
    pub extent: f32,
    pub bounds: Bounds,
    pub report: MeshReport,
    /// Triangles left out, ascending.
    pub dropped: Vec<u32>,
}

/// Squares of distances beyond this leave the range of f32.
const LARGEST: f64 = 1e18;

impl MeshTree {
    /// For the closest hit and for any.
    ///
    /// # Errors
    /// Where no triangle has an area, or coordinates lie beyond ±1e18.
    pub(super) fn build(mesh: &Mesh, options: AccelOptions) -> Result<Self> {
        Self::over(mesh, options, distinct)
    }

    /// For all crossings along a ray: only triangles with two equal corners are left out, because without others a
    /// closed mesh would be open.
    ///
    /// # Errors
    /// Where all triangles are left out, or coordinates lie beyond ±1e18.
    pub(super) fn build_operand(mesh: &Mesh, options: AccelOptions) -> Result<Self> {
        Self::over(mesh, options, cornered)
    }

    /// Over the triangles that `choose` names, in order.
    fn over(
        mesh: &Mesh,
        options: AccelOptions,
        choose: impl Fn(&Mesh) -> (Vec<u32>, MeshReport),
    ) -> Result<Self> {
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
        let center = exact_center(&bounds);
        let local = |p: Vec3| (p.as_dvec3() - center).as_vec3();
        let boxes: Vec<Aabb> = kept
            .par_iter()
            .map(|&i| Aabb::from_points(&mesh.corners(i).map(|p| local(p).into())))
            .collect();
        let (tree, order) = WideTree::build(&boxes, LANES as u32, options);
        let extent = (boxes.par_iter())
            .map(|b| b.min.abs().max(b.max.abs()))
            .reduce(|| Vec3A::ZERO, Vec3A::max)
            .max_element();
        drop(boxes);
        let leaves = Pages::new(order.starts.len() - 1, |i| {
            let positions = &order.order[order.starts[i] as usize..order.starts[i + 1] as usize];
            Block::new(positions.iter().map(|&position| {
                let primitive = kept[position as usize];
                Triangle {
                    corners: mesh.corners(primitive).map(local),
                    primitive,
                }
            }))
        });
        report.bytes = tree.bytes() + size_of_val(&*leaves);
        Ok(Self {
            tree,
            leaves,
            center,
            extent,
            bounds,
            report,
            dropped: left_out(&kept, mesh.triangles.len() as u32),
        })
    }

    /// The closest hit in `ray.tmin..tmax`; of equal `t` the lowest primitive, whatever the tree looks like.
    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, tmax: f64) -> Option<(TriangleHit, u32)> {
        let task = Closest {
            mesh: self,
            ray,
            tmax,
        };
        if self.fits_kernels(ray) {
            self.tree.run(task)
        } else {
            self.tree.run_portable(task)
        }
    }

    /// Whether any triangle lies in `ray.tmin..ray.tmax`.
    #[inline]
    pub(super) fn occluded(&self, ray: &Ray) -> bool {
        let task = Any { mesh: self, ray };
        if self.fits_kernels(ray) {
            self.tree.run(task)
        } else {
            self.tree.run_portable(task)
        }
    }

    /// `ray`, of the mesh's space, at the root of the tree on its way to `tmax`.
    #[inline(always)]
    pub(super) fn entrant<const N: usize>(&self, ray: &Ray, tmax: f64) -> Entrant<'_, N> {
        let local = TreeRay::new(ray, self.center, self.extent);
        let far = size_of_val(&*self.leaves) > FAR;
        Entrant {
            walk: self.tree.nodes(),
            start: local.box_start(ray.tmin),
            limit: local.box_limit(tmax),
            ray: local,
            leaves: far.then(|| (self.leaves.as_ptr().cast(), size_of::<Block>())),
        }
    }

    /// Offers the hits of the ray, of the mesh's space, in a leaf at which it is as `entrant`.
    #[inline(always)]
    pub(super) fn visit<K: Kernel<N>, const N: usize>(
        &self,
        kernel: K,
        entrant: &Entrant<'_, N>,
        ray: &Ray,
        leaf: u32,
        mut offer: impl FnMut(TriangleHit, u32),
    ) {
        let local = &entrant.ray;
        let block = &self.leaves[leaf as usize];
        let corners = kernel.corners(local, entrant.start);
        let mask = kernel.candidates(block, &corners, entrant.limit);
        if mask == 0 {
            return;
        }
        let exact = local.exact(ray, self.center);
        for lane in ones(mask) {
            if let Some(hit) = Triangle::intersect(&exact, block.corners_along(lane, local.axes)) {
                offer(hit, block.primitives[lane]);
            }
        }
    }

    /// Whether a triangle of a leaf, at which the ray is as `entrant`, is in its way.
    #[inline(always)]
    pub(super) fn blocks<K: Kernel<N>, const N: usize>(
        &self,
        kernel: K,
        entrant: &Entrant<'_, N>,
        ray: &Ray,
        leaf: u32,
    ) -> bool {
        let local = &entrant.ray;
        let block = &self.leaves[leaf as usize];
        let corners = kernel.corners(local, entrant.start);
        let (certain, mask) = kernel.certain(block, &corners, entrant.limit);
        certain
            || ones(mask).any(|lane| {
                let exact = local.exact(ray, self.center);
                let corners = block.corners_along(lane, local.axes);
                Triangle::intersect(&exact, corners)
                    .is_some_and(|hit| hit.t > ray.tmin && hit.t < ray.tmax)
            })
    }

    /// Runs a task on the tree.
    #[inline]
    pub(super) fn run<T: Task>(&self, task: T) -> T::Output {
        self.tree.run(task)
    }

    /// Whether kernels take `ray`, of the mesh's space.
    #[inline]
    pub(super) fn fits_kernels(&self, ray: &Ray) -> bool {
        fits_kernels(ray, self.center, self.extent)
    }

    /// Every crossing with `t > ray.tmin`, in no order. A closed mesh is entered as often as it is left along a whole
    /// line, and in order of `t` the count tells how often the mesh winds around the points between.
    pub(super) fn crossings(&self, ray: &Ray, mut visit: impl FnMut(MeshCrossing)) {
        let local = TreeRay::new(ray, self.center, self.extent);
        let exact = local.exact(ray, self.center);
        self.tree.run_portable(Visit {
            local: &local,
            start: local.box_start(ray.tmin),
            end: f32::INFINITY,
            at_leaf: |leaf: u32| {
                for triangle in self.leaves[leaf as usize].triangles() {
                    if let Some(hit) = triangle.crossing(&local, &exact)
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
            },
        });
    }

    /// Barycentric weights of the second and third corner of `primitive`, which `ray` crosses at `t`.
    pub(super) fn barycentric(&self, ray: &Ray, t: f64, primitive: u32) -> DVec2 {
        let local = TreeRay::new(ray, self.center, self.extent);
        let exact = local.exact(ray, self.center);
        let mut weights = DVec2::splat(1.0 / 3.0);
        self.tree.run_portable(Visit {
            local: &local,
            start: local.box_start(t),
            end: local.box_limit(t),
            at_leaf: |leaf: u32| {
                let mut triangles = self.leaves[leaf as usize].triangles();
                if let Some(triangle) = triangles.find(|triangle| triangle.primitive == primitive) {
                    weights = triangle.weights(&local, &exact);
                }
            },
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

    /// All triangles, in the order of the leaves.
    pub(super) fn triangles(&self) -> impl Iterator<Item = Triangle> + '_ {
        self.leaves.iter().flat_map(Block::triangles)
    }
}

/// [`MeshTree::intersect`] for one ray.
struct Closest<'a> {
    mesh: &'a MeshTree,
    ray: &'a Ray,
    tmax: f64,
}

impl Task for Closest<'_> {
    type Output = Option<(TriangleHit, u32)>;

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, walk: Walk<'_, N>) -> Self::Output {
        let Self { mesh, ray, tmax } = self;
        let local = TreeRay::new(ray, mesh.center, mesh.extent);
        let (start, end) = (local.box_start(ray.tmin), local.box_limit(tmax));
        let mut limit = tmax;
        let mut end_now = end;
        let mut best: Option<(TriangleHit, u32)> = None;
        let corners = kernel.corners(&local, start);
        let _ = {
            walk.traverse(kernel, &local, start, end, |leaf| {
                let block = &mesh.leaves[leaf as usize];
                for lane in ones(kernel.candidates(block, &corners, end_now)) {
                    let Some(hit) = Triangle::intersect(
                        &local.exact(ray, mesh.center),
                        block.corners_along(lane, local.axes),
                    ) else {
                        continue;
                    };
                    let primitive = block.primitives[lane];
                    let tie = best.is_some_and(|(b, id)| hit.t == b.t && primitive < id);
                    if hit.t > ray.tmin && (hit.t < limit || tie) {
                        limit = hit.t;
                        end_now = local.box_limit(limit);
                        best = Some((hit, primitive));
                    }
                }
                ControlFlow::Continue(end_now)
            })
        };
        best
    }
}

/// [`MeshTree::occluded`] for one ray.
struct Any<'a> {
    mesh: &'a MeshTree,
    ray: &'a Ray,
}

impl Task for Any<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, walk: Walk<'_, N>) -> bool {
        let Self { mesh, ray } = self;
        let local = TreeRay::new(ray, mesh.center, mesh.extent);
        let (start, end) = (local.box_start(ray.tmin), local.box_limit(ray.tmax));
        let corners = kernel.corners(&local, start);
        let outcome = walk.traverse_any(kernel, &local, start, end, |leaf| {
            let block = &mesh.leaves[leaf as usize];
            let (certain, mask) = kernel.certain(block, &corners, end);
            let hit = |lane: usize| {
                let exact = local.exact(ray, mesh.center);
                let corners = block.corners_along(lane, local.axes);
                Triangle::intersect(&exact, corners)
                    .is_some_and(|hit| hit.t > ray.tmin && hit.t < ray.tmax)
            };
            if certain || ones(mask).any(hit) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        outcome.is_break()
    }
}

/// Calls `visit` for every leaf whose box a ray meets.
struct Visit<'a, F> {
    local: &'a TreeRay,
    start: f32,
    end: f32,
    at_leaf: F,
}

impl<F: FnMut(u32)> Task for Visit<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(mut self, kernel: K, walk: Walk<'_, N>) {
        let _ = {
            walk.traverse(kernel, self.local, self.start, self.end, |leaf| {
                (self.at_leaf)(leaf);
                ControlFlow::Continue(self.end)
            })
        };
    }
}

/// Trees of so many bytes are read from afar, and asking ahead pays.
const FAR: usize = 16 << 20;

/// The places of the bits that are set.
#[inline(always)]
fn ones(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        (mask != 0).then(|| {
            mask &= mask - 1;
            lane & (LANES - 1)
        })
    })
}

/// The numbers below `count` that are not in `kept`, which ascends.
fn left_out(kept: &[u32], count: u32) -> Vec<u32> {
    let mut kept = kept.iter().peekable();
    (0..count)
        .filter(|i| kept.next_if_eq(&i).is_none())
        .collect()
}

/// A point to measure from so that the difference to every f32 coordinate in `bounds` is an f32 again.
/// Where an axis lies far from 0 against its length that is its middle, by Sterbenz's lemma (within a
/// factor of two, differences are exact); elsewhere 0, and coordinates are of the size of the box.
fn exact_center(bounds: &Bounds) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| {
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        let middle = f64::from((0.5 * (min + max)) as f32);
        let (near, far) = (min.abs().min(max.abs()), min.abs().max(max.abs()));
        let exact = min * max > 0.0 && 2.0 * near >= middle.abs() && far <= 2.0 * middle.abs();
        if exact { middle } else { 0.0 }
    }))
}

#[cfg(test)]
mod tests;

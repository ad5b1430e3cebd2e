mod choice;
mod tasks;

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
use super::wide::{
    Block, Descent, GROUP, Kernel, LANES, Packet, Root, Seat, Task, Walk, WideTree, stack,
};
use choice::{cornered, distinct};
use tasks::{Any, Closest, Visit};

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
        (self.tree.run(task)).unwrap_or_else(|| self.tree.run_portable(task).flatten())
    }

    /// Whether any triangle lies in `ray.tmin..ray.tmax`.
    #[inline]
    pub(super) fn occluded(&self, ray: &Ray) -> bool {
        let task = Any { mesh: self, ray };
        (self.tree.run(task)).unwrap_or_else(|| self.tree.run_portable(task) == Some(true))
    }

    /// Where rays enter.
    #[inline(always)]
    pub(super) fn root<const N: usize>(&self) -> Root<'_, N> {
        let far = size_of_val(&*self.leaves) > FAR;
        Root {
            walk: self.tree.nodes(),
            leaves: far.then(|| (self.leaves.as_ptr().cast(), size_of::<Block>())),
            center: self.center,
            extent: self.extent,
        }
    }

    /// A bit for each triangle of a leaf that the ray may hit from `start` to `limit`, in units of the box test; and how far
    /// its farthest corner is.
    #[inline(always)]
    pub(super) fn look<K: Kernel<N>, const N: usize>(
        &self,
        kernel: K,
        local: &TreeRay,
        [start, limit]: [f32; 2],
        leaf: u32,
    ) -> (u32, [f32; LANES]) {
        kernel.candidates(&self.leaves[leaf as usize], local, start, limit)
    }

    /// Offers the hits of the ray, of the mesh's space, with the triangles in `mask` of a leaf.
    #[inline(always)]
    pub(super) fn visit(
        &self,
        ray: &Ray,
        local: &TreeRay,
        leaf: u32,
        mut mask: u32,
        mut offer: impl FnMut(TriangleHit, u32),
    ) {
        let block = &self.leaves[leaf as usize];
        let exact = local.exact(ray, self.center);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (LANES - 1);
            mask &= mask - 1;
            let corners = block.corners_along(lane, local.axes);
            if let Some(hit) = Triangle::intersect(&exact, corners)
                && hit.t > ray.tmin
            {
                offer(hit, block.primitives[lane]);
            }
        }
    }

    /// Takes the ray, of the mesh's space, through the tree or a part of it. `offer` gets its hits and answers with where
    /// there is still something to look for: before that, or [`ENOUGH`]. Whether the kernel takes the ray.
    #[inline(always)]
    pub(super) fn walk<K: Kernel<N>, const N: usize>(
        &self,
        kernel: K,
        walk: Walk<'_, N>,
        ray: &Ray,
        tmax: f64,
        mut offer: impl FnMut(TriangleHit, u32) -> f64,
    ) -> bool {
        let local = kernel.prepare_one(ray, self.center, self.extent);
        if !kernel.takes(ray, &local) {
            return false;
        }
        let start = local.box_start(ray.tmin);
        let (mut limit, mut end) = (tmax, local.box_limit(tmax));
        let mut stack = stack();
        let mut descent = Descent::new(kernel, walk, &local, start, &mut stack);
        while let Some(leaf) = descent.next(end) {
            let (mask, reach) = self.look(kernel, &local, [start, end], leaf);
            if mask == 0 {
                continue;
            }
            let before = limit;
            self.visit(ray, &local, leaf, mask, |hit, primitive| {
                limit = offer(hit, primitive);
            });
            if limit != before {
                if limit == ENOUGH {
                    break;
                }
                // A hit lies before its triangle's farthest corner: that is known long before where it lies.
                let last = if mask.is_power_of_two() {
                    local.box_end(reach[mask.trailing_zeros() as usize & (LANES - 1)])
                } else {
                    f32::INFINITY
                };
                end = if last < f32::INFINITY {
                    end.min(last)
                } else {
                    local.box_limit(limit)
                };
            }
        }
        true
    }

    /// As [`MeshTree::visit`] for the rays of a packet in `mask`; `offer` gets their numbers.
    #[inline(always)]
    pub(super) fn visit_packet<K: Kernel<N>, const N: usize>(
        &self,
        kernel: K,
        packet: &mut Packet,
        seat: &Seat,
        leaf: u32,
        mask: u64,
        mut offer: impl FnMut(&mut Packet, usize, TriangleHit, u32),
    ) {
        let block = &self.leaves[leaf as usize];
        let (windows, mut seen) = packet.triangle_windows(seat, &block.planes);
        while seen != 0 {
            let lane = seen.trailing_zeros() as usize & (LANES - 1);
            seen &= seen - 1;
            let mut inside = mask & kernel.within(&packet.points, &windows.at(lane));
            let corners = block.corners_along(lane, packet.axes);
            while inside != 0 {
                let first = inside.trailing_zeros() as usize / GROUP * GROUP;
                let group = (inside >> first) as u32 & ((1 << GROUP) - 1);
                inside &= !(u64::from(group) << first);
                let found = packet.decide(kernel, first, self.center, corners);
                let mut met = group & u32::from(found.mask);
                while met != 0 {
                    let i = met.trailing_zeros() as usize & (GROUP - 1);
                    met &= met - 1;
                    let hit = TriangleHit {
                        t: found.t[i],
                        u: found.u[i],
                        v: found.v[i],
                        inside: found.inside >> i & 1 == 1,
                    };
                    if hit.t > packet.tmin {
                        offer(packet, first + i, hit, block.primitives[lane]);
                    }
                }
            }
        }
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

/// The end of a ray for which nothing is left to look for.
pub(super) const ENOUGH: f64 = f64::NEG_INFINITY;

/// A mesh that reaches no more than so many times its size from 0 is measured from there.
const NEAR: f64 = 4.0;

/// Trees of so many bytes are read from afar, and asking ahead pays.
const FAR: usize = 2 << 20;

/// The numbers below `count` that are not in `kept`, which ascends.
fn left_out(kept: &[u32], count: u32) -> Vec<u32> {
    let mut kept = kept.iter().peekable();
    (0..count)
        .filter(|i| kept.next_if_eq(&i).is_none())
        .collect()
}

/// A point to measure from so that the difference to every f32 coordinate in `bounds` is an f32 again: 0 where a mesh is
/// near it for its size, so that many have the same.
/// Where an axis lies far from 0 against its length that is its middle, by Sterbenz's lemma (within a
/// factor of two, differences are exact); elsewhere 0, and coordinates are of the size of the box.
fn exact_center(bounds: &Bounds) -> DVec3 {
    if bounds.min.abs().max(bounds.max.abs()).max_element() <= NEAR * bounds.size().max_element() {
        return DVec3::ZERO;
    }
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

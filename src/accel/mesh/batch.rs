use glam::DVec3;

use crate::accel::ray::{TreeRay, fits_kernels};
use crate::accel::triangle::{Triangle, TriangleHit};
use crate::accel::wide::{Block, Entrant, Kernel, Next, RAYS, Task, Traffic, Walk};
use crate::math::Ray;

use super::{MeshTree, ones};

/// Rays in the mesh's space, and what becomes of their hits.
pub(in crate::accel) trait Rays {
    /// The next ray, with its number.
    fn next(&mut self) -> Option<(usize, Ray)>;

    /// The closest hit of ray `index`, and its primitive.
    fn hit(&mut self, index: usize, hit: TriangleHit, primitive: u32);
}

impl MeshTree {
    /// [`MeshTree::intersect`] for many rays; those without a hit are not heard of again.
    pub(in crate::accel) fn intersect_batch(&self, rays: &mut impl Rays) {
        self.tree.run(Stream {
            mesh: self,
            any: false,
            rays,
        });
    }

    /// [`MeshTree::occluded`] for many rays: of those that are, some hit is told.
    pub(in crate::accel) fn occluded_batch(&self, rays: &mut impl Rays) {
        self.tree.run(Stream {
            mesh: self,
            any: true,
            rays,
        });
    }
}

struct Stream<'a, R> {
    mesh: &'a MeshTree,
    any: bool,
    rays: &'a mut R,
}

impl<R: Rays> Task for Stream<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, walk: Walk<'_, N>) {
        let mut flights = Flights {
            mesh: self.mesh,
            any: self.any,
            rays: self.rays,
            slots: [Flight {
                index: 0,
                ray: Ray::new(DVec3::ZERO, DVec3::X),
                limit: 0.0,
                best: None,
            }; RAYS],
        };
        walk.stream(kernel, &mut flights);
    }
}

/// The rays under way.
struct Flights<'a, R> {
    mesh: &'a MeshTree,
    any: bool,
    rays: &'a mut R,
    slots: [Flight; RAYS],
}

#[derive(Clone, Copy)]
struct Flight {
    index: usize,
    ray: Ray,
    limit: f64,
    best: Option<(TriangleHit, u32)>,
}

impl<R: Rays> Traffic for Flights<'_, R> {
    #[inline(always)]
    fn enter(&mut self, slot: usize) -> Option<Entrant> {
        loop {
            let (index, ray) = self.rays.next()?;
            if !fits_kernels(&ray, self.mesh.center, self.mesh.extent) {
                if let Some((hit, primitive)) = self.mesh.intersect(&ray, ray.tmax) {
                    self.rays.hit(index, hit, primitive);
                }
                continue;
            }
            self.slots[slot] = Flight {
                index,
                ray,
                limit: ray.tmax,
                best: None,
            };
            let local = TreeRay::new(&ray, self.mesh.center, self.mesh.extent);
            return Some(Entrant {
                start: local.box_start(ray.tmin),
                limit: local.box_limit(ray.tmax),
                ray: local,
            });
        }
    }

    #[inline(always)]
    fn visit<K: Kernel<N>, const N: usize>(
        &mut self,
        kernel: K,
        slot: usize,
        entrant: &Entrant,
        leaf: u32,
    ) -> Next {
        let Entrant { ray, start, limit } = entrant;
        let block = &self.mesh.leaves[leaf as usize];
        let mask = kernel.candidates(block, &kernel.corners(ray, *start), *limit);
        if mask == 0 {
            return Next::On;
        }
        let flight = &mut self.slots[slot];
        let before = flight.limit;
        let exact = ray.exact(&flight.ray, self.mesh.center);
        for lane in ones(mask) {
            let Some(hit) = Triangle::intersect(&exact, block.corners_along(lane, ray.axes)) else {
                continue;
            };
            flight.offer(hit, block.primitives[lane]);
        }
        if flight.limit == before {
            Next::On
        } else if self.any {
            Next::Stop
        } else {
            Next::To(ray.box_limit(flight.limit))
        }
    }

    #[inline(always)]
    fn leaves(&self) -> (*const u8, usize, usize) {
        let leaves = &*self.mesh.leaves;
        (
            leaves.as_ptr().cast(),
            size_of::<Block>(),
            size_of_val(leaves),
        )
    }

    #[inline(always)]
    fn leave(&mut self, slot: usize) {
        let Flight { index, best, .. } = self.slots[slot];
        if let Some((hit, primitive)) = best {
            self.rays.hit(index, hit, primitive);
        }
    }
}

impl Flight {
    /// Takes the hit if it is closer, or as close and of a lower primitive.
    #[inline(always)]
    fn offer(&mut self, hit: TriangleHit, primitive: u32) {
        let tie = (self.best).is_some_and(|(best, id)| hit.t == best.t && primitive < id);
        if hit.t > self.ray.tmin && (hit.t < self.limit || tie) {
            self.limit = hit.t;
            self.best = Some((hit, primitive));
        }
    }
}

//! Queries of one ray, compiled for every kernel.

use crate::accel::ray::TreeRay;
use crate::accel::triangle::TriangleHit;
use crate::accel::wide::{Descent, Kernel, Task, Walk, stack};
use crate::math::Ray;

use super::{ENOUGH, MeshTree};

/// The closest hit before `tmax`, and its primitive; of equal distances the lowest. `None` where the kernel does not take
/// the ray.
#[derive(Clone, Copy)]
pub(super) struct Closest<'a> {
    pub mesh: &'a MeshTree,
    pub ray: &'a Ray,
    pub tmax: f64,
}

impl Task for Closest<'_> {
    type Output = Option<Option<(TriangleHit, u32)>>;

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, walk: Walk<'_, N>) -> Self::Output {
        let Self { mesh, ray, tmax } = self;
        let mut limit = tmax;
        let mut best: Option<(TriangleHit, u32)> = None;
        let taken = mesh.walk(kernel, walk, ray, tmax, |hit, primitive| {
            let tie = best.is_some_and(|(b, id)| hit.t == b.t && primitive < id);
            if hit.t < limit || tie {
                limit = hit.t;
                best = Some((hit, primitive));
            }
            limit
        });
        taken.then_some(best)
    }
}

/// Whether anything is in the ray's way. `None` where the kernel does not take the ray.
#[derive(Clone, Copy)]
pub(super) struct Any<'a> {
    pub mesh: &'a MeshTree,
    pub ray: &'a Ray,
}

impl Task for Any<'_> {
    type Output = Option<bool>;

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, walk: Walk<'_, N>) -> Self::Output {
        let Self { mesh, ray } = self;
        let mut limit = ray.tmax;
        let taken = mesh.walk(kernel, walk, ray, limit, |hit, _| {
            if hit.t < limit {
                limit = ENOUGH;
            }
            limit
        });
        taken.then_some(limit == ENOUGH)
    }
}

/// Calls `at_leaf` for every leaf whose box the ray meets.
pub(super) struct Visit<'a, F> {
    pub local: &'a TreeRay,
    pub start: f32,
    pub end: f32,
    pub at_leaf: F,
}

impl<F: FnMut(u32)> Task for Visit<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(mut self, kernel: K, walk: Walk<'_, N>) {
        let mut stack = stack();
        let mut descent = Descent::new(kernel, walk, self.local, self.start, &mut stack);
        while let Some(leaf) = descent.next(self.end) {
            (self.at_leaf)(leaf);
        }
    }
}

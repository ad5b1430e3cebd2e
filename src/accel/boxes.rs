use std::ops::ControlFlow;

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

use crate::math::{Bounds, Ray};

use super::options::AccelOptions;
use super::ray::{TreeRay, fits_kernels};
use super::wide::{Descent, Kernel, Root, Task, Walk, WideTree, stack};

/// A wide tree over boxes in f64, one a leaf.
#[derive(Debug)]
pub(super) struct BoxTree {
    tree: WideTree,
    /// Boxes are stored relative to this point.
    center: DVec3,
    /// The largest coordinate from there.
    extent: f32,
}

impl BoxTree {
    /// Builds over `bounds`, at least one, all finite, as seen from `center` or their middle. Returns the order of the
    /// leaves as well: leaf to index in `bounds`.
    pub(super) fn build(
        bounds: &[Bounds],
        center: Option<DVec3>,
        options: AccelOptions,
    ) -> (Self, Vec<u32>) {
        let whole = bounds.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        let center = center.unwrap_or_else(|| whole.center());
        let boxes: Vec<Aabb> = bounds
            .iter()
            .map(|b| {
                let (min, max) = Bounds {
                    min: b.min - center,
                    max: b.max - center,
                }
                .outward_f32();
                Aabb::new(min.into(), max.into())
            })
            .collect();
        let (tree, leaves) = WideTree::build(&boxes, 1, options);
        let reach = (boxes.iter()).fold(Vec3A::ZERO, |r, b| r.max(b.min.abs()).max(b.max.abs()));
        let tree = Self {
            tree,
            center,
            extent: reach.max_element(),
        };
        (tree, leaves.order)
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.tree.bytes()
    }

    /// Runs a task for `ray` with the tree's kernel, or the portable one where f32 cannot hold the ray.
    #[inline]
    pub(super) fn run<T: Task>(&self, ray: &Ray, task: T) -> T::Output {
        if self.fits_kernels(ray) {
            self.tree.run(task)
        } else {
            self.tree.run_portable(task)
        }
    }

    /// Runs a task for many rays, with the tree's kernel.
    pub(super) fn run_all<T: Task>(&self, task: T) -> T::Output {
        self.tree.run(task)
    }

    /// `ray` as this tree sees it.
    #[inline(always)]
    pub(super) fn local_ray<K: Kernel<N>, const N: usize>(&self, kernel: K, ray: &Ray) -> TreeRay {
        kernel.prepare_one(ray, self.center, self.extent)
    }

    /// Where rays enter.
    #[inline(always)]
    pub(super) fn root<const N: usize>(&self) -> Root<'_, N> {
        Root {
            walk: self.tree.nodes(),
            leaves: None,
            center: self.center,
            extent: self.extent,
        }
    }

    /// Whether kernels take `ray`.
    #[inline]
    pub(super) fn fits_kernels(&self, ray: &Ray) -> bool {
        fits_kernels(ray, self.center, self.extent)
    }

    /// Visits the leaves whose boxes the ray meets before `tmax`, nearest first as far as boxes tell. `visit` answers
    /// with the new `tmax`, or breaks.
    #[inline]
    pub(super) fn traverse(
        &self,
        ray: &Ray,
        tmax: f64,
        visit: impl FnMut(u32) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        self.run(
            ray,
            Leaves {
                boxes: self,
                ray,
                tmax,
                visit,
            },
        )
    }

    /// Visits the leaves whose boxes hold the point `p`, in no particular order.
    pub(super) fn around(&self, p: DVec3, visit: impl FnMut(u32)) {
        self.tree.around(p - self.center, visit);
    }
}

struct Leaves<'a, F> {
    boxes: &'a BoxTree,
    ray: &'a Ray,
    tmax: f64,
    visit: F,
}

impl<F: FnMut(u32) -> ControlFlow<(), f64>> Task for Leaves<'_, F> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(mut self, kernel: K, walk: Walk<'_, N>) -> Self::Output {
        let local = self.boxes.local_ray(kernel, self.ray);
        let (start, mut end) = (local.box_start(self.ray.tmin), local.box_limit(self.tmax));
        let mut stack = stack();
        let mut descent = Descent::new(kernel, walk, &local, start, &mut stack);
        while let Some(leaf) = descent.next(end) {
            end = local.box_limit((self.visit)(leaf)?);
        }
        ControlFlow::Continue(())
    }
}

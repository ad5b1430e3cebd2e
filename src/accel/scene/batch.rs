use crate::accel::mesh::{ENOUGH, MeshTree};
use crate::accel::wide::{
    Entrant, Group, Kernel, Next, PREPARED, RAYS, Root, Task, Traffic, Walk, stream,
};
use crate::geometry::Shape;
use crate::math::Ray;

use super::{Accel, Hit, Space};

impl Accel {
    /// The closest hit of each ray, as [`Accel::intersect`] finds it, into `hits` of the same length.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len());
        hits.fill(None);
        self.answer(rays, Closest(hits));
    }

    /// Whether each ray is blocked, as [`Accel::occluded`] says it, into `blocked` of the same length.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len());
        blocked.fill(false);
        self.answer(rays, Any(blocked));
    }

    fn answer(&self, rays: &[Ray], mut answers: impl Answers) {
        for &instance in &self.always {
            if let Some(mesh) = self.mesh_of(instance) {
                mesh.run(Stream {
                    accel: self,
                    mesh: Some((mesh, instance)),
                    rays,
                    answers: &mut answers,
                });
                continue;
            }
            for (index, ray) in rays.iter().enumerate() {
                if let Some(mut limit) = answers.limit(index, ray) {
                    answers.meet(self, instance, ray, index, &mut limit);
                }
            }
        }
        if let Some((tree, _)) = &self.tree {
            tree.run_all(Stream {
                accel: self,
                mesh: None,
                rays,
                answers: &mut answers,
            });
        }
    }

    /// The tree of `instance`, where that is a mesh.
    #[inline]
    pub(super) fn mesh_of(&self, instance: u32) -> Option<&MeshTree> {
        match self.placed[instance as usize].shape {
            Shape::Mesh(id) => Some(&self.meshes[id.0 as usize]),
            _ => None,
        }
    }
}

/// What is asked of each ray, and what was found so far.
pub(super) trait Answers {
    /// Where to look for more: before this; `None` where enough is known.
    fn limit(&self, index: usize, ray: &Ray) -> Option<f64>;

    /// Takes note of a hit after the ray's start, and of how far there is still something to look for.
    fn offer(&mut self, index: usize, hit: Hit, limit: &mut f64);

    /// Offers what a ray meets of one shape.
    fn meet(&mut self, accel: &Accel, instance: u32, ray: &Ray, index: usize, limit: &mut f64);

    /// Takes note of the answer to a ray that kernels cannot take.
    fn alone(&mut self, accel: &Accel, ray: &Ray, index: usize);
}

/// The closest hits.
struct Closest<'a>(&'a mut [Option<Hit>]);

/// Whether there is any hit. Then the limit is [`ENOUGH`].
struct Any<'a>(&'a mut [bool]);

impl Answers for Closest<'_> {
    #[inline(always)]
    fn limit(&self, index: usize, ray: &Ray) -> Option<f64> {
        Some(self.0[index].as_ref().map_or(ray.tmax, |hit| hit.t))
    }

    #[inline(always)]
    fn offer(&mut self, index: usize, hit: Hit, limit: &mut f64) {
        let best = &mut self.0[index];
        let place = |hit: &Hit| (hit.instance, hit.primitive);
        let tie = || (best.as_ref()).is_some_and(|best| place(&hit) < place(best));
        if hit.t < *limit || hit.t == *limit && tie() {
            *limit = hit.t;
            *best = Some(hit);
        }
    }

    #[inline(never)]
    fn meet(&mut self, accel: &Accel, instance: u32, ray: &Ray, index: usize, limit: &mut f64) {
        if let Some(hit) = accel.intersect_one(instance, ray, limit.next_up()) {
            self.offer(index, hit, limit);
        }
    }

    fn alone(&mut self, accel: &Accel, ray: &Ray, index: usize) {
        self.0[index] = accel.intersect(ray);
    }
}

impl Answers for Any<'_> {
    #[inline(always)]
    fn limit(&self, index: usize, ray: &Ray) -> Option<f64> {
        (!self.0[index]).then_some(ray.tmax)
    }

    #[inline(always)]
    fn offer(&mut self, index: usize, hit: Hit, limit: &mut f64) {
        if hit.t < *limit {
            *limit = ENOUGH;
            self.0[index] = true;
        }
    }

    #[inline(never)]
    fn meet(&mut self, accel: &Accel, instance: u32, ray: &Ray, index: usize, limit: &mut f64) {
        if accel.occludes(instance, ray) {
            *limit = ENOUGH;
            self.0[index] = true;
        }
    }

    fn alone(&mut self, accel: &Accel, ray: &Ray, index: usize) {
        self.0[index] = accel.occluded(ray);
    }
}

/// All rays through one mesh, or through the tree of all placed shapes.
pub(super) struct Stream<'a, 'f, A> {
    pub accel: &'a Accel,
    /// The one mesh, and whose.
    pub mesh: Option<(&'a MeshTree, u32)>,
    pub rays: &'a [Ray],
    pub answers: &'f mut A,
}

impl<A: Answers> Task for Stream<'_, '_, A> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, _: Walk<'_, N>) {
        let root = match (self.mesh, &self.accel.tree) {
            (Some((mesh, _)), _) => mesh.root(),
            (None, Some((tree, _))) => tree.root(),
            (None, None) => return,
        };
        let flight = Flight {
            index: 0,
            limit: 0.0,
            mesh: self.mesh,
            moved: None,
            shared: false,
        };
        let mut flights = Flights {
            end: self.rays.len(),
            stream: self,
            root,
            next: 0,
            slots: [flight; RAYS],
        };
        while flights.next < flights.stream.rays.len() {
            flights.packets(kernel);
            stream(kernel, &mut flights);
        }
    }
}

/// The rays, and those of them that are under way.
pub(super) struct Flights<'a, 'f, A, const N: usize> {
    pub stream: Stream<'a, 'f, A>,
    pub root: Root<'a, N>,
    /// The next ray to start.
    pub next: usize,
    /// Where a stream ends.
    pub end: usize,
    slots: [Flight<'a>; RAYS],
}

/// A ray under way.
#[derive(Clone, Copy)]
struct Flight<'a> {
    index: usize,
    limit: f64,
    /// The mesh that it is in, and whose; `None` in the tree of all.
    mesh: Option<(&'a MeshTree, u32)>,
    /// Itself in that one's space, where that is another one.
    moved: Option<Ray>,
    /// Whether it was made ready for the tree of all and the mesh alike.
    shared: bool,
}

impl<'a, A: Answers, const N: usize> Traffic<'a, N> for Flights<'a, '_, A, N> {
    #[inline(always)]
    fn root(&self) -> Root<'a, N> {
        self.root
    }

    #[inline(always)]
    fn enter(&mut self, slots: [usize; PREPARED], group: &mut Group) {
        let Stream {
            accel,
            mesh,
            rays,
            answers,
        } = &mut self.stream;
        group.len = 0;
        while group.len < PREPARED && self.next < self.end {
            let (index, ray) = (self.next, &rays[self.next]);
            self.next += 1;
            let Some(mut limit) = answers.limit(index, ray) else {
                continue;
            };
            let flight = &mut self.slots[slots[group.len]];
            (flight.index, flight.limit, flight.mesh) = (index, limit, *mesh);
            group.limits[group.len] = limit;
            flight.moved = None;
            if let &mut Some((mesh, instance)) = mesh {
                flight.moved = accel.moved_ray(instance, ray);
                if !mesh.fits_kernels(flight.moved.as_ref().unwrap_or(ray)) {
                    answers.meet(accel, instance, ray, index, &mut limit);
                    continue;
                }
            } else if let Some((tree, _)) = &accel.tree
                && !tree.fits_kernels(ray)
            {
                answers.alone(accel, ray, index);
                continue;
            }
            group.len += 1;
        }
    }

    #[inline(always)]
    fn ray(&self, slot: usize) -> &Ray {
        let Flight { index, moved, .. } = &self.slots[slot];
        moved.as_ref().unwrap_or(&self.stream.rays[*index])
    }

    #[inline(always)]
    fn look<K: Kernel<N>>(
        &self,
        kernel: K,
        slot: usize,
        entrant: &Entrant<'a, N>,
        leaf: u32,
    ) -> u32 {
        let Some((mesh, _)) = self.slots[slot].mesh else {
            return u32::MAX;
        };
        let ends = [entrant.start, entrant.limit];
        mesh.look(kernel, &entrant.ray, ends, leaf).0
    }

    #[inline(always)]
    fn visit<K: Kernel<N>>(
        &mut self,
        kernel: K,
        slot: usize,
        entrant: &Entrant<'a, N>,
        leaf: u32,
        found: u32,
    ) -> Next<'a, N> {
        let Stream {
            accel,
            rays,
            answers,
            ..
        } = &mut self.stream;
        let flight = &mut self.slots[slot];
        let (before, ray) = (flight.limit, &rays[flight.index]);
        if let Some((mesh, instance)) = flight.mesh {
            let local = flight.moved.as_ref().unwrap_or(ray);
            let mut met = false;
            mesh.visit(local, &entrant.ray, leaf, found, |hit, primitive| {
                let hit = Hit::of_triangle(&hit, primitive, instance);
                answers.offer(flight.index, hit, &mut flight.limit);
                met = true;
            });
            if !met {
                return Next::On;
            }
        } else {
            let (_, order) = accel.tree.as_ref().expect("it is in it");
            let instance = order[leaf as usize];
            if let Some(mesh) = accel.mesh_of(instance) {
                flight.shared = accel.spaces[instance as usize] == Space::Shared;
                if flight.shared {
                    (flight.mesh, flight.moved) = (Some((mesh, instance)), None);
                    return Next::Into(mesh.root());
                }
                let moved = accel.moved_ray(instance, ray);
                let local = moved.as_ref().unwrap_or(ray);
                if mesh.fits_kernels(local) {
                    let entrant = Entrant::new(kernel, local, flight.limit, mesh.root());
                    (flight.mesh, flight.moved) = (Some((mesh, instance)), moved);
                    return Next::Down(entrant);
                }
            }
            if accel.is_behind(instance, ray) {
                return Next::On;
            }
            answers.meet(accel, instance, ray, flight.index, &mut flight.limit);
        }
        if flight.limit == ENOUGH {
            Next::Stop
        } else if flight.limit == before {
            Next::On
        } else {
            Next::To(entrant.ray.box_limit(flight.limit))
        }
    }

    #[inline(always)]
    fn rise<K: Kernel<N>>(&mut self, kernel: K, slot: usize, entrant: &mut Entrant<'a, N>) {
        let flight = &mut self.slots[slot];
        flight.mesh = None;
        if flight.shared {
            entrant.root = self.root;
        } else {
            let ray = &self.stream.rays[flight.index];
            *entrant = Entrant::new(kernel, ray, flight.limit, self.root);
        }
    }
}

use glam::DVec3;

use crate::accel::mesh::MeshTree;
use crate::accel::wide::{Entrant, Kernel, Next, RAYS, Task, Traffic, Walk, stream};
use crate::geometry::Shape;
use crate::math::Ray;

use super::{Accel, Hit};

impl Accel {
    /// The closest hit of each ray, as [`Accel::intersect`] finds it, into `hits` of the same length.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len());
        hits.fill(None);
        for &instance in &self.always {
            if self.mesh_of(instance).is_some() {
                self.stream(Some(instance), rays, Found::Closest(hits));
                continue;
            }
            for (ray, hit) in rays.iter().zip(&mut *hits) {
                let limit = hit.map_or(ray.tmax, |hit| hit.t);
                *hit = self.intersect_one(instance, ray, limit).or(*hit);
            }
        }
        if self.tree.is_some() {
            self.stream(None, rays, Found::Closest(hits));
        }
    }

    /// Whether each ray is blocked, as [`Accel::occluded`] says it, into `blocked` of the same length.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len());
        blocked.fill(false);
        for &instance in &self.always {
            if self.mesh_of(instance).is_some() {
                self.stream(Some(instance), rays, Found::Any(blocked));
                continue;
            }
            for (ray, blocked) in rays.iter().zip(&mut *blocked) {
                *blocked = *blocked || self.occludes(instance, ray);
            }
        }
        if self.tree.is_some() {
            self.stream(None, rays, Found::Any(blocked));
        }
    }

    /// Takes all rays through one mesh, or through the tree of all placed shapes.
    fn stream(&self, instance: Option<u32>, rays: &[Ray], found: Found<'_>) {
        let stream = Stream {
            accel: self,
            instance,
            rays,
            found,
        };
        match (
            instance.and_then(|instance| self.mesh_of(instance)),
            &self.tree,
        ) {
            (Some(mesh), _) => mesh.run(stream),
            (None, Some((tree, _))) => tree.run_all(stream),
            (None, None) => {}
        }
    }

    /// The tree of `instance`, where that is a mesh.
    #[inline]
    fn mesh_of(&self, instance: u32) -> Option<&MeshTree> {
        match self.placed[instance as usize].shape {
            Shape::Mesh(id) => Some(&self.meshes[id.0 as usize]),
            _ => None,
        }
    }
}

/// Where answers go; what is there limits what is looked for.
enum Found<'a> {
    Closest(&'a mut [Option<Hit>]),
    Any(&'a mut [bool]),
}

struct Stream<'a> {
    accel: &'a Accel,
    instance: Option<u32>,
    rays: &'a [Ray],
    found: Found<'a>,
}

impl Task for Stream<'_> {
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, _: Walk<'_, N>) {
        let mut flights = Flights {
            accel: self.accel,
            instance: self.instance,
            rays: self.rays,
            next: 0,
            found: self.found,
            slots: [Flight {
                index: 0,
                mesh: None,
                instance: 0,
                local: Ray::new(DVec3::ZERO, DVec3::X),
                limit: 0.0,
                best: None,
                blocked: false,
            }; RAYS],
        };
        stream(kernel, &mut flights);
    }
}

/// The rays, and those of them that are under way.
struct Flights<'a, 'f> {
    accel: &'a Accel,
    instance: Option<u32>,
    rays: &'a [Ray],
    next: usize,
    found: Found<'f>,
    slots: [Flight<'a>; RAYS],
}

/// A ray under way.
#[derive(Clone, Copy)]
struct Flight<'a> {
    index: usize,
    /// The mesh that it is in, whose, and itself in that one's space; `None` in the tree of all.
    mesh: Option<&'a MeshTree>,
    instance: u32,
    local: Ray,
    limit: f64,
    best: Option<Hit>,
    /// Whether a shape without triangles is in its way, where only that is asked.
    blocked: bool,
}

impl<'a> Flights<'a, '_> {
    /// Sends number `slot` into the mesh of `instance`. Where that is none, or is none for kernels, it is done with at
    /// once.
    #[inline(always)]
    fn dive<const N: usize>(&mut self, slot: usize, instance: u32) -> Option<Entrant<'a, N>> {
        let flight = &mut self.slots[slot];
        let ray = &self.rays[flight.index];
        if let Some(mesh) = self.accel.mesh_of(instance) {
            let local = self.accel.local_ray(instance, ray);
            if mesh.fits_kernels(&local) {
                flight.mesh = Some(mesh);
                flight.instance = instance;
                flight.local = local;
                return Some(mesh.entrant(&local, flight.limit));
            }
        }
        self.meet(slot, instance);
        None
    }

    /// One ray and one shape.
    #[inline(never)]
    fn meet(&mut self, slot: usize, instance: u32) {
        let flight = &mut self.slots[slot];
        let ray = &self.rays[flight.index];
        if matches!(self.found, Found::Any(_)) {
            flight.blocked |= self.accel.occludes(instance, ray);
            return;
        }
        let limit = flight.limit.next_up();
        if let Some(hit) = self.accel.intersect_one(instance, ray, limit) {
            flight.offer(hit.t, (instance, hit.primitive), || hit);
        }
    }

    /// Writes down what number `slot` found.
    #[inline(always)]
    fn land(&mut self, slot: usize) {
        let flight = &self.slots[slot];
        match &mut self.found {
            Found::Closest(hits) => hits[flight.index] = flight.best,
            Found::Any(blocked) => {
                blocked[flight.index] = flight.blocked || flight.best.is_some();
            }
        }
    }
}

impl Flight<'_> {
    /// Takes a hit that is closer, or as close and of a lower instance and primitive.
    #[inline(always)]
    fn offer(&mut self, t: f64, place: (u32, u32), hit: impl FnOnce() -> Hit) {
        let tie = |best: Hit| t == self.limit && place < (best.instance, best.primitive);
        if t < self.limit || self.best.is_some_and(tie) {
            self.limit = t;
            self.best = Some(hit());
        }
    }
}

impl<'a, const N: usize> Traffic<'a, N> for Flights<'a, '_> {
    #[inline(always)]
    fn enter(&mut self, slot: usize) -> Option<Entrant<'a, N>> {
        loop {
            let index = self.next;
            let ray = self.rays.get(index)?;
            self.next += 1;
            let best = match &self.found {
                Found::Closest(hits) => hits[index],
                Found::Any(blocked) if blocked[index] => continue,
                Found::Any(_) => None,
            };
            let flight = &mut self.slots[slot];
            flight.index = index;
            flight.mesh = None;
            flight.limit = best.map_or(ray.tmax, |hit| hit.t);
            flight.best = best;
            flight.blocked = false;
            let entrant = match (self.instance, &self.accel.tree) {
                (Some(instance), _) => self.dive(slot, instance),
                (None, Some((tree, _))) if tree.fits_kernels(ray) => {
                    Some(tree.entrant(ray, flight.limit))
                }
                (None, _) => {
                    let any = matches!(self.found, Found::Any(_));
                    flight.blocked = any && self.accel.occluded(ray);
                    flight.best = if any { None } else { self.accel.intersect(ray) };
                    None
                }
            };
            if entrant.is_some() {
                return entrant;
            }
            self.land(slot);
        }
    }

    #[inline(always)]
    fn visit<K: Kernel<N>>(
        &mut self,
        kernel: K,
        slot: usize,
        entrant: &Entrant<'a, N>,
        leaf: u32,
    ) -> Next<'a, N> {
        let flight = &mut self.slots[slot];
        let before = flight.limit;
        if let Some(mesh) = flight.mesh {
            let (local, instance) = (flight.local, flight.instance);
            mesh.visit(kernel, entrant, &local, leaf, |hit, primitive| {
                if hit.t > local.tmin {
                    flight.offer(hit.t, (instance, primitive), || {
                        Hit::of_triangle(&hit, primitive, instance)
                    });
                }
            });
        } else {
            let (_, order) = self.accel.tree.as_ref().expect("it is in it");
            if let Some(entrant) = self.dive(slot, order[leaf as usize]) {
                return Next::Down(entrant);
            }
        }
        let flight = &self.slots[slot];
        if flight.limit == before && !flight.blocked {
            Next::On
        } else if matches!(self.found, Found::Any(_)) {
            Next::Stop
        } else {
            Next::To(entrant.ray.box_limit(flight.limit))
        }
    }

    #[inline(always)]
    fn rise(&mut self, slot: usize) -> Entrant<'a, N> {
        let (tree, _) = self.accel.tree.as_ref().expect("it came from there");
        let flight = &mut self.slots[slot];
        flight.mesh = None;
        tree.entrant(&self.rays[flight.index], flight.limit)
    }

    #[inline(always)]
    fn leave(&mut self, slot: usize) {
        self.land(slot);
    }
}

use crate::accel::mesh::{AtLeaf, MeshTree};
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
                limit: 0.0,
                blocked: false,
                mesh: None,
                instance: 0,
                moved: None,
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
    limit: f64,
    /// Whether something is in its way, where only that is asked.
    blocked: bool,
    /// The mesh that it is in, and whose; `None` in the tree of all.
    mesh: Option<&'a MeshTree>,
    instance: u32,
    /// Itself in that one's space, where that is another one.
    moved: Option<Ray>,
}

impl<'a> Flights<'a, '_> {
    /// Sends number `slot` into the mesh of `instance`. Where that is none, or is none for kernels, it is done with at
    /// once.
    #[inline(always)]
    fn dive<const N: usize>(&mut self, slot: usize, instance: u32) -> Option<Entrant<'a, N>> {
        let flight = &mut self.slots[slot];
        if let Some(mesh) = self.accel.mesh_of(instance) {
            let ray = &self.rays[flight.index];
            flight.moved = self.accel.moved_ray(instance, ray);
            let local = flight.moved.as_ref().unwrap_or(ray);
            if mesh.fits_kernels(local) {
                flight.mesh = Some(mesh);
                flight.instance = instance;
                return Some(mesh.entrant(local, flight.limit));
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
        match &mut self.found {
            Found::Any(_) => flight.blocked |= self.accel.occludes(instance, ray),
            Found::Closest(hits) => {
                let limit = flight.limit.next_up();
                if let Some(hit) = self.accel.intersect_one(instance, ray, limit)
                    && is_nearer(&hit, flight.limit, hits[flight.index].as_ref())
                {
                    flight.limit = hit.t;
                    hits[flight.index] = Some(hit);
                }
            }
        }
    }
}

impl Flights<'_, '_> {
    /// Writes down what number `slot` found.
    #[inline(always)]
    fn land(&mut self, slot: usize) {
        if let Found::Any(blocked) = &mut self.found {
            let flight = &self.slots[slot];
            blocked[flight.index] = flight.blocked;
        }
    }
}

/// Whether `hit` is before the limit, or there and of a lower instance or primitive than the best so far.
#[inline(always)]
fn is_nearer(hit: &Hit, limit: f64, best: Option<&Hit>) -> bool {
    let place = |hit: &Hit| (hit.instance, hit.primitive);
    hit.t < limit || hit.t == limit && best.is_some_and(|best| place(hit) < place(best))
}

impl<'a, const N: usize> Traffic<'a, N> for Flights<'a, '_> {
    #[inline(always)]
    fn enter(&mut self, slot: usize) -> Option<Entrant<'a, N>> {
        loop {
            let index = self.next;
            let ray = self.rays.get(index)?;
            self.next += 1;
            let flight = &mut self.slots[slot];
            flight.index = index;
            flight.mesh = None;
            flight.blocked = false;
            flight.limit = match &self.found {
                Found::Closest(hits) => hits[index].as_ref().map_or(ray.tmax, |hit| hit.t),
                Found::Any(blocked) if blocked[index] => continue,
                Found::Any(_) => ray.tmax,
            };
            let entrant = match (self.instance, &self.accel.tree) {
                (Some(instance), _) => self.dive(slot, instance),
                (None, Some((tree, _))) if tree.fits_kernels(ray) => {
                    Some(tree.entrant(ray, flight.limit))
                }
                (None, _) => {
                    match &mut self.found {
                        Found::Closest(hits) => hits[index] = self.accel.intersect(ray),
                        Found::Any(_) => flight.blocked = self.accel.occluded(ray),
                    }
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
            let ray = flight.moved.as_ref().unwrap_or(&self.rays[flight.index]);
            let at = AtLeaf {
                ray,
                local: &entrant.ray,
                corners: kernel.corners(&entrant.ray, entrant.start),
                limit: entrant.limit,
            };
            let limit = &mut flight.limit;
            match &mut self.found {
                Found::Any(_) => mesh.visit(kernel, &at, leaf, |hit, _| {
                    flight.blocked |= hit.t < *limit;
                }),
                Found::Closest(hits) => {
                    let best = &mut hits[flight.index];
                    mesh.visit(kernel, &at, leaf, |hit, primitive| {
                        let hit = Hit::of_triangle(&hit, primitive, flight.instance);
                        if is_nearer(&hit, *limit, best.as_ref()) {
                            *limit = hit.t;
                            *best = Some(hit);
                        }
                    });
                }
            }
        } else {
            let (_, order) = self.accel.tree.as_ref().expect("it is in it");
            if let Some(entrant) = self.dive(slot, order[leaf as usize]) {
                return Next::Down(entrant);
            }
        }
        let flight = &self.slots[slot];
        if flight.blocked {
            Next::Stop
        } else if flight.limit == before {
            Next::On
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

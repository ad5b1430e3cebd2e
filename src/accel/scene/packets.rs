//! Batches of rays from one origin.

use std::array::from_fn;

use crate::accel::mesh::{ENOUGH, MeshTree};
use crate::accel::wide::{Catch, Kernel, LEAF, PACKET, Packet, Root, Seat, walk_packet};
use crate::math::Ray;
use crate::memory::fetch;

use super::batch::{Answers, Flights, Stream};
use super::{Accel, Hit};

/// Packets with fewer rays left go on one by one.
const FEW: u32 = 3;

/// Where fewer rays of a packet than this meet at a leaf, on average, streams are faster.
const FULL: u32 = 4;

/// After such packets, as many rays as would make so many of them are a stream.
const SPARSE: usize = 15;

impl<A: Answers, const N: usize> Flights<'_, '_, A, N> {
    /// Takes packets as long as the next rays make some, and looks how far the next ones do not.
    #[inline(always)]
    pub(super) fn packets<K: Kernel<N>>(&mut self, kernel: K) {
        let Stream {
            accel,
            mesh,
            rays,
            answers,
        } = &mut self.stream;
        self.end = rays.len();
        let place = mesh
            .filter(|(_, instance)| accel.is_moved(*instance))
            .map(|(_, instance)| &accel.placed[instance as usize].world_from_object);
        let mut fill = Fill::default();
        while let Some(some) = rays[self.next..].first_chunk() {
            let mut limits = from_fn(|i| answers.limit(self.next + i, &some[i]).unwrap_or(ENOUGH));
            let local = place.map(|place| some.each_ref().map(|ray| place.inverse_ray(ray)));
            let local = local.as_ref().unwrap_or(some);
            let Some((mut packet, seat)) = Packet::new(local, &limits)
                .and_then(|packet| Some((packet, packet.seat(&self.root)?)))
            else {
                self.end = self.next + PACKET;
                while let Some(some) = rays[self.end..].first_chunk()
                    && Packet::new(some, &limits).is_none()
                {
                    self.end += PACKET;
                }
                return;
            };
            for ray in rays[self.next + PACKET..].iter().take(PACKET) {
                fetch(ray);
            }
            let mut party = Party {
                rays: local,
                first: self.next,
                limits: &mut limits,
                answers: &mut **answers,
                fill: &mut fill,
            };
            if let Some((mesh, instance)) = *mesh {
                party.walk::<K, N>(kernel, &mut packet, &seat, u64::MAX, mesh, instance);
            } else {
                let mut catch = InScene { accel, party };
                walk_packet(kernel, &self.root, &seat, &mut packet, u64::MAX, &mut catch);
            }
            self.next += PACKET;
            if fill.is_low() {
                self.end = rays.len().min(self.next + SPARSE * PACKET);
                return;
            }
        }
    }
}

/// How often rays were at a leaf, together and each for itself.
#[derive(Default)]
struct Fill {
    leaves: u32,
    rays: u32,
}

impl Fill {
    fn is_low(&self) -> bool {
        self.rays < FULL * self.leaves
    }

    fn count(&mut self, rays: u32) {
        self.leaves += 1;
        self.rays += rays;
    }
}

/// The rays of a packet, and what is known of them.
struct Party<'f, A> {
    rays: &'f [Ray; PACKET],
    /// The index of the first.
    first: usize,
    limits: &'f mut [f64; PACKET],
    answers: &'f mut A,
    fill: &'f mut Fill,
}

impl<A: Answers> Party<'_, A> {
    /// The rays in `mask` go through a mesh, in whose space they and the packet are.
    #[inline(always)]
    fn walk<K: Kernel<N>, const N: usize>(
        &mut self,
        kernel: K,
        packet: &mut Packet,
        seat: &Seat,
        mask: u64,
        mesh: &MeshTree,
        instance: u32,
    ) {
        let root = mesh.root();
        let mut catch = InMesh {
            mesh,
            instance,
            root: &root,
            seat,
            party: self,
        };
        walk_packet(kernel, &root, seat, packet, mask, &mut catch);
    }
}

/// A packet in a mesh.
struct InMesh<'a, 'p, 'f, A, const N: usize> {
    mesh: &'a MeshTree,
    instance: u32,
    root: &'a Root<'a, N>,
    seat: &'a Seat,
    party: &'p mut Party<'f, A>,
}

impl<A: Answers, const N: usize> Catch<N> for InMesh<'_, '_, '_, A, N> {
    #[inline(always)]
    fn take<K: Kernel<N>>(&mut self, kernel: K, packet: &mut Packet, link: u32, mask: u64) -> bool {
        if mask.count_ones() < FEW {
            for i in bits(mask) {
                self.alone(kernel, link, i);
                packet.shorten(i, self.party.limits[i]);
            }
            return true;
        }
        if link & LEAF == 0 {
            return false;
        }
        let Party {
            first,
            limits,
            answers,
            fill,
            ..
        } = &mut *self.party;
        fill.count(mask.count_ones());
        let (mesh, instance, leaf) = (self.mesh, self.instance, link & !LEAF);
        let offer = |packet: &mut Packet, i: usize, hit, primitive| {
            let hit = Hit::of_triangle(&hit, primitive, instance);
            answers.offer(*first + i, hit, &mut limits[i]);
            packet.shorten(i, limits[i]);
        };
        mesh.visit_packet(kernel, packet, self.seat, leaf, mask, offer);
        true
    }
}

impl<A: Answers, const N: usize> InMesh<'_, '_, '_, A, N> {
    /// Ray number `i` goes on from `link`.
    #[inline(always)]
    fn alone<K: Kernel<N>>(&mut self, kernel: K, link: u32, i: usize) {
        let Party {
            rays,
            first,
            limits,
            answers,
            fill,
        } = &mut *self.party;
        fill.count(1);
        let (walk, limit) = (self.root.walk.below(link), &mut limits[i]);
        // The kernel takes it: the packet would have no seat before the tree otherwise.
        (self.mesh).walk(kernel, walk, &rays[i], *limit, |hit, primitive| {
            let hit = Hit::of_triangle(&hit, primitive, self.instance);
            answers.offer(*first + i, hit, limit);
            *limit
        });
    }
}

/// A packet in the tree of all placed shapes.
struct InScene<'a, 'f, A> {
    accel: &'a Accel,
    party: Party<'f, A>,
}

impl<A: Answers, const N: usize> Catch<N> for InScene<'_, '_, A> {
    #[inline(always)]
    fn take<K: Kernel<N>>(&mut self, kernel: K, packet: &mut Packet, link: u32, mask: u64) -> bool {
        if link & LEAF == 0 {
            return false;
        }
        let (_, order) = self.accel.tree.as_ref().expect("it is in it");
        let instance = order[(link & !LEAF) as usize];
        if !self.dive(kernel, packet, instance, mask) {
            let party = &mut self.party;
            party.fill.count(mask.count_ones());
            for i in bits(mask) {
                let (index, limit) = (party.first + i, &mut party.limits[i]);
                (party.answers).meet(self.accel, instance, &party.rays[i], index, limit);
            }
        }
        for i in bits(mask) {
            packet.shorten(i, self.party.limits[i]);
        }
        true
    }
}

impl<A: Answers> InScene<'_, '_, A> {
    /// Takes the rays in `mask` through the mesh of `instance`; not where that is none, or they are no packet there.
    #[inline(always)]
    fn dive<K: Kernel<N>, const N: usize>(
        &mut self,
        kernel: K,
        packet: &mut Packet,
        instance: u32,
        mask: u64,
    ) -> bool {
        let (accel, party) = (self.accel, &mut self.party);
        let Some(mesh) = accel.mesh_of(instance) else {
            return false;
        };
        let root: Root<'_, N> = mesh.root();
        if !accel.is_moved(instance) {
            let seat = packet.seat(&root);
            if let Some(seat) = &seat {
                party.walk::<K, N>(kernel, packet, seat, mask, mesh, instance);
            }
            return seat.is_some();
        }
        let place = &accel.placed[instance as usize].world_from_object;
        // Where a ray is not wanted, one that is stands for it.
        let some = mask.trailing_zeros() as usize & (PACKET - 1);
        let mut rays = [place.inverse_ray(&party.rays[some]); PACKET];
        for i in bits(mask) {
            rays[i] = place.inverse_ray(&party.rays[i]);
        }
        let Some((mut packet, seat)) =
            Packet::new(&rays, party.limits).and_then(|packet| Some((packet, packet.seat(&root)?)))
        else {
            return false;
        };
        let mut party = Party {
            rays: &rays,
            first: party.first,
            limits: &mut *party.limits,
            answers: &mut *party.answers,
            fill: &mut *party.fill,
        };
        party.walk::<K, N>(kernel, &mut packet, &seat, mask, mesh, instance);
        true
    }
}

/// The numbers of the bits that are set.
#[inline(always)]
fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = mask.trailing_zeros() as usize & (PACKET - 1);
        let more = mask != 0;
        mask &= mask.wrapping_sub(1);
        more.then_some(i)
    })
}

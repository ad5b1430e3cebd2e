use std::array::from_fn;
use std::mem::MaybeUninit;

use glam::DVec3;

use crate::accel::ray::TreeRay;
use crate::math::Ray;
use crate::memory::fetch;

use super::Walk;
use super::kernel::{Kernel, PREPARED, STACK, Waiting, is_near, limit_bits};
use super::node::{LEAF, STEP};

/// Rays under way at once: while one waits for memory or for its own last result, others go on. New ones start when
/// [`PREPARED`] slots are free.
pub(in crate::accel) const RAYS: usize = 24;

/// The link below all that waits in a tree.
const DONE: u32 = u32::MAX;

/// A tree as rays enter it.
#[derive(Clone, Copy)]
pub(in crate::accel) struct Root<'a, const N: usize> {
    pub walk: Walk<'a, N>,
    /// Where the leaves stand and how far apart, for a tree so large that they are fetched ahead.
    pub leaves: Option<(*const u8, usize)>,
    /// What [`TreeRay::new`] asks for.
    pub center: DVec3,
    pub extent: f32,
}

/// A ray under way in a tree.
pub(in crate::accel) struct Entrant<'a, const N: usize> {
    pub ray: TreeRay,
    /// In units of the box test.
    pub start: f32,
    pub limit: f32,
    pub root: Root<'a, N>,
}

impl<'a, const N: usize> Entrant<'a, N> {
    #[inline(always)]
    pub(in crate::accel) fn new<K: Kernel<N>>(
        kernel: K,
        ray: &Ray,
        tmax: f64,
        root: Root<'a, N>,
    ) -> Self {
        let local = kernel.prepare_one(ray, root.center, root.extent);
        Self {
            start: local.box_start(ray.tmin),
            limit: local.box_limit(tmax),
            ray: local,
            root,
        }
    }
}

/// Rays that start at once.
pub(in crate::accel) struct Group {
    pub len: usize,
    pub rays: [Ray; PREPARED],
    /// Where they end.
    pub limits: [f64; PREPARED],
}

/// What a ray does after a leaf.
#[allow(clippy::large_enum_variant, reason = "it is used at once")]
pub(in crate::accel) enum Next<'a, const N: usize> {
    /// It goes on.
    On,
    /// It goes on to this limit.
    To(f32),
    /// It goes through a tree in this leaf first.
    Down(Entrant<'a, N>),
    /// So it does, ready for that tree too.
    Into(Root<'a, N>),
    /// It has seen enough.
    Stop,
}

/// Many rays, and what they find in a tree, or in a tree of trees.
pub(in crate::accel) trait Traffic<'a, const N: usize> {
    /// Where all rays start.
    fn root(&self) -> Root<'a, N>;

    /// Fills `group` with the next rays, which are to be those with the numbers in `slots`.
    fn enter(&mut self, slots: [usize; PREPARED], group: &mut Group);

    /// Number `slot` is at a leaf.
    fn visit<K: Kernel<N>>(
        &mut self,
        kernel: K,
        slot: usize,
        entrant: &Entrant<'a, N>,
        leaf: u32,
    ) -> Next<'a, N>;

    /// Number `slot` comes back from a tree in a leaf.
    fn rise<K: Kernel<N>>(&mut self, kernel: K, slot: usize, entrant: &mut Entrant<'a, N>);
}

struct Slot<'a, const N: usize> {
    entrant: Entrant<'a, N>,
    link: u32,
    /// Entries on the stack below `link`: behind [`DONE`] at `floor` those of the tree that the ray is in.
    len: usize,
    floor: usize,
    stack: [MaybeUninit<Waiting>; STACK],
}

/// The slots at a node, those at a leaf, and those without a ray.
struct Turns {
    at_node: [u8; RAYS + 1],
    nodes: usize,
    at_leaf: [u8; RAYS + 1],
    leaves: usize,
    free: [u8; RAYS],
    idle: usize,
}

impl Turns {
    /// Written to both lists, of which one grows: rays go either way at random, and a branch would cost more.
    ///
    /// # Safety
    /// No more than [`RAYS`] slots have turns.
    #[inline(always)]
    unsafe fn put(&mut self, slot: u8, link: u32) {
        let leaf = (link >> 31) as usize;
        unsafe {
            *self.at_node.get_unchecked_mut(self.nodes) = slot;
            *self.at_leaf.get_unchecked_mut(self.leaves) = slot;
        }
        self.nodes += 1 - leaf;
        self.leaves += leaf;
    }
}

impl<const N: usize> Slot<'_, N> {
    /// Starts at the root of another tree than the one that waits.
    ///
    /// # Safety
    /// There is room on the stack.
    #[inline(always)]
    unsafe fn descend(&mut self) {
        self.len += 1;
        self.floor = self.len;
        unsafe { *self.top().add(self.len) = u64::from(DONE) };
        self.link = self.entrant.root.walk.root;
    }

    #[inline(always)]
    fn top(&mut self) -> *mut Waiting {
        self.stack.as_mut_ptr().cast()
    }

    /// Takes the nearest of what waits.
    ///
    /// # Safety
    /// Entries from `floor` to `len` have been written.
    #[inline(always)]
    unsafe fn pop(&mut self) {
        unsafe { self.link = *self.top().add(self.len) as u32 };
        self.len = self.len.wrapping_sub(1);
    }

    /// Forgets what waits beyond the limit in the tree that the ray is in.
    ///
    /// # Safety
    /// As [`Slot::pop`].
    #[inline(always)]
    unsafe fn cut(&mut self) {
        let bits = limit_bits(self.entrant.limit);
        let stack = self.top();
        let mut kept = self.floor;
        for i in self.floor + 1..=self.len {
            unsafe {
                let waiting = *stack.add(i);
                *stack.add(kept + 1) = waiting;
                kept += usize::from(is_near(waiting, bits));
            }
        }
        self.len = kept;
    }

    /// Asks for the cache lines of where the ray goes next, which need not be there.
    #[inline(always)]
    fn fetch(&self) {
        let Some(leaves) = self.entrant.root.leaves else {
            return;
        };
        let nodes = (self.entrant.root.walk.nodes.as_ptr().cast::<u8>(), STEP);
        let (base, size) = [nodes, leaves][(self.link >> 31) as usize];
        let place = base.wrapping_add((self.link & !LEAF) as usize * size);
        for line in 0..LINES {
            fetch(place.wrapping_add(64 * line));
        }
    }
}

/// Cache lines that a step reads: 5 of a leaf, 7 of a node of 16.
const LINES: usize = 6;

/// Walks many rays through trees, [`RAYS`] at a time: in turns, those at a node take a step and those at a leaf visit
/// it.
#[inline(always)]
#[allow(
    clippy::large_stack_arrays,
    reason = "200 KiB, of which few pages are used, for batches of thousands"
)]
pub(in crate::accel) fn stream<'a, K: Kernel<N>, const N: usize>(
    kernel: K,
    traffic: &mut impl Traffic<'a, N>,
) {
    let mut slots = [const { MaybeUninit::<Slot<'a, N>>::uninit() }; RAYS];
    let slots = slots.as_mut_ptr().cast::<Slot<'a, N>>();
    let mut turns = Turns {
        at_node: [0; RAYS + 1],
        nodes: 0,
        at_leaf: [0; RAYS + 1],
        leaves: 0,
        free: std::array::from_fn(|i| i as u8),
        idle: RAYS,
    };
    let root = traffic.root();
    let mut group = Group {
        len: PREPARED,
        rays: [Ray::new(DVec3::ZERO, DVec3::X); PREPARED],
        limits: [0.0; PREPARED],
    };
    loop {
        while group.len == PREPARED && turns.idle >= PREPARED {
            let ids: [usize; PREPARED] = from_fn(|i| usize::from(turns.free[turns.idle - 1 - i]));
            traffic.enter(ids, &mut group);
            turns.idle -= group.len;
            // SAFETY: ids are those of slots without rays. Their fields are written here, but for the stack's other
            // entries, which are written before they are read.
            unsafe {
                let into = ids.map(|i| &raw mut (*slots.add(i)).entrant.ray);
                kernel.prepare(&group.rays, root.center, root.extent, &into);
                for (i, &id) in ids[..group.len].iter().enumerate() {
                    let slot = slots.add(id);
                    let ray = &(*slot).entrant.ray;
                    let (start, limit) = (
                        ray.box_start(group.rays[i].tmin),
                        ray.box_limit(group.limits[i]),
                    );
                    (&raw mut (*slot).entrant.start).write(start);
                    (&raw mut (*slot).entrant.limit).write(limit);
                    (&raw mut (*slot).entrant.root).write(root);
                    (&raw mut (*slot).link).write(root.walk.root);
                    (&raw mut (*slot).len).write(0);
                    (&raw mut (*slot).floor).write(0);
                    (*slot).stack[0].write(u64::from(DONE));
                    turns.put(id as u8, root.walk.root);
                }
            }
        }
        if turns.nodes + turns.leaves == 0 {
            return;
        }
        for k in 0..std::mem::take(&mut turns.nodes) {
            // SAFETY: only slots with rays have turns, one each. Links lead to nodes of the slot's tree, and stacks are never
            // fuller than trees are built for.
            unsafe {
                let i = *turns.at_node.get_unchecked(k);
                let slot = &mut *slots.add(i as usize);
                let Entrant {
                    ray,
                    start,
                    limit,
                    root,
                } = &slot.entrant;
                let node = root.walk.node(slot.link);
                let boxes = kernel.boxes(ray, *start);
                let limit = *limit;
                let len = slot.len;
                let top = slot.top().add(len + 1);
                let len = len + kernel.push(node, &boxes, limit, top);
                slot.link = *slot.top().add(len) as u32;
                slot.len = len.wrapping_sub(1);
                slot.fetch();
                turns.put(i, slot.link);
            }
        }
        for k in 0..std::mem::take(&mut turns.leaves) {
            // SAFETY: as above; all entries up to `len` were written.
            unsafe {
                let i = *turns.at_leaf.get_unchecked(k);
                let slot = &mut *slots.add(i as usize);
                loop {
                    if slot.link == DONE && slot.floor == 0 {
                        turns.free[turns.idle] = i;
                        turns.idle += 1;
                        break;
                    }
                    if slot.link == DONE {
                        slot.floor = 0;
                        traffic.rise(kernel, i as usize, &mut slot.entrant);
                        slot.cut();
                        slot.pop();
                    } else {
                        let leaf = slot.link & !LEAF;
                        match traffic.visit(kernel, i as usize, &slot.entrant, leaf) {
                            Next::On => slot.pop(),
                            Next::To(limit) => {
                                slot.entrant.limit = limit;
                                slot.cut();
                                slot.pop();
                            }
                            Next::Down(entrant) => {
                                slot.entrant = entrant;
                                slot.descend();
                            }
                            Next::Into(root) => {
                                slot.entrant.root = root;
                                slot.descend();
                            }
                            Next::Stop => {
                                slot.len = 0;
                                slot.floor = 0;
                                slot.pop();
                            }
                        }
                    }
                    // What follows at a leaf of a small tree, or at none, is in the caches: no other ray need go first.
                    if slot.link & LEAF == 0 || slot.entrant.root.leaves.is_some() {
                        slot.fetch();
                        turns.put(i, slot.link);
                        break;
                    }
                }
            }
        }
    }
}

use std::array::from_fn;
use std::mem::MaybeUninit;

use glam::DVec3;

use crate::accel::ray::TreeRay;
use crate::math::Ray;
use crate::memory::fetch;

use super::Walk;
use super::kernel::{Aligned, Kernel, PREPARED, STACK, Waiting, is_near, limit_bits};
use super::node::{LEAF, STEP};

/// Rays under way at once: while one waits for memory or for its own last result, others go on. New ones start when
/// [`PREPARED`] slots are free.
pub(in crate::accel) const RAYS: usize = 32;

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
    /// How many they are.
    pub len: usize,
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

    /// Takes the next rays, which are to be those with the numbers in `slots`, and says of them what `group` asks.
    fn enter(&mut self, slots: [usize; PREPARED], group: &mut Group);

    /// Number `slot` as it is to be made ready for the tree that it starts in; any ray where none has that number.
    fn ray(&self, slot: usize) -> &Ray;

    /// Number `slot` is at a leaf: what may be hit there, in bits; [`Traffic::visit`] is for those that find any.
    fn look<K: Kernel<N>>(
        &self,
        kernel: K,
        slot: usize,
        entrant: &Entrant<'a, N>,
        leaf: u32,
    ) -> u32;

    /// Number `slot` has `found` something at a leaf.
    fn visit<K: Kernel<N>>(
        &mut self,
        kernel: K,
        slot: usize,
        entrant: &Entrant<'a, N>,
        leaf: u32,
        found: u32,
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

/// The slots with rays, each once, by what their turn is.
struct Turns {
    /// `[kind][..len]`.
    slots: [[u8; RAYS]; KINDS],
    lens: [usize; KINDS],
}

// Kinds of turns: at a node, at a leaf, and where a tree is done.
const NODES: usize = 0;
const LEAVES: usize = 1;
const ENDS: usize = 2;
const KINDS: usize = 3;

impl Turns {
    const NONE: Self = Self {
        slots: [[0; RAYS]; KINDS],
        lens: [0; KINDS],
    };

    /// Rays go either way at random: a branch would cost more.
    ///
    /// # Safety
    /// Slots have one turn each.
    #[inline(always)]
    unsafe fn put(&mut self, slot: u8, link: u32) {
        let kind = (link >> 31) as usize + usize::from(link == DONE);
        unsafe {
            let len = self.lens.get_unchecked_mut(kind);
            *(self.slots.get_unchecked_mut(kind)).get_unchecked_mut(*len) = slot;
            *len += 1;
        }
    }

    #[inline(always)]
    fn of(&self, kind: usize) -> &[u8] {
        &self.slots[kind][..self.lens[kind]]
    }
}

impl<'a, const N: usize> Slot<'a, N> {
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

    /// After a leaf.
    ///
    /// # Safety
    /// As [`Slot::pop`], and there is room on the stack.
    #[inline(always)]
    unsafe fn go_on(&mut self, next: Next<'a, N>) {
        unsafe {
            match next {
                Next::On => self.pop(),
                Next::To(limit) => {
                    self.entrant.limit = limit;
                    self.cut();
                    self.pop();
                }
                Next::Down(entrant) => {
                    self.entrant = entrant;
                    self.descend();
                }
                Next::Into(root) => {
                    self.entrant.root = root;
                    self.descend();
                }
                Next::Stop => {
                    self.len = 0;
                    self.floor = 0;
                    self.pop();
                }
            }
        }
    }

    /// Asks for the cache lines of where the ray goes next, which need not be there.
    #[inline(always)]
    fn fetch(&self) {
        let Some(leaves) = self.entrant.root.leaves else {
            return;
        };
        let nodes = (self.entrant.root.walk.nodes.as_ptr().cast::<u8>(), STEP);
        // Not a branch, which would be guessed wrong too often.
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
    reason = "270 KiB, of which few pages are used, for batches of thousands"
)]
pub(in crate::accel) fn stream<'a, K: Kernel<N>, const N: usize>(
    kernel: K,
    traffic: &mut impl Traffic<'a, N>,
) {
    let mut slots = [const { MaybeUninit::<Slot<'a, N>>::uninit() }; RAYS];
    let slots = slots.as_mut_ptr().cast::<Slot<'a, N>>();
    let (mut free, mut idle): ([u8; RAYS], _) = (from_fn(|i| i as u8), RAYS);
    let (mut some, mut others) = (Turns::NONE, Turns::NONE);
    let (mut turns, mut next) = (&mut some, &mut others);
    let mut found = [0; RAYS];
    let mut met = [Aligned([0.0; N]); RAYS];
    let root = traffic.root();
    let mut group = Group {
        len: PREPARED,
        limits: [0.0; PREPARED],
    };
    loop {
        while group.len == PREPARED && idle >= PREPARED {
            let ids: [usize; PREPARED] = from_fn(|i| usize::from(free[idle - 1 - i]));
            traffic.enter(ids, &mut group);
            idle -= group.len;
            // SAFETY: ids are those of slots without rays. Their fields are written here, but for the stack's other
            // entries, which are written before they are read.
            unsafe {
                let into = ids.map(|i| &raw mut (*slots.add(i)).entrant.ray);
                // Where they stand: what was just copied in parts would not be ready to be loaded as a whole.
                let rays = ids.map(|i| traffic.ray(i));
                kernel.prepare(&rays, root.center, root.extent, &into);
                for (i, &id) in ids[..group.len].iter().enumerate() {
                    let slot = slots.add(id);
                    let ray = &(*slot).entrant.ray;
                    let (start, limit) =
                        (ray.box_start(rays[i].tmin), ray.box_limit(group.limits[i]));
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
        if turns.lens == [0; KINDS] {
            return;
        }
        next.lens = [0; KINDS];
        // Turns are taken in two loops: what the second one waits for or branches on is known by then, and does not keep
        // the first one waiting.
        let nodes = turns.of(NODES);
        for ((&i, found), met) in nodes.iter().zip(&mut found).zip(&mut met) {
            // SAFETY: only slots with rays have turns, one each. Links lead to nodes of the slot's tree.
            unsafe {
                let slot = &*slots.add(usize::from(i));
                let Entrant {
                    ray,
                    start,
                    limit,
                    root,
                } = &slot.entrant;
                let boxes = kernel.boxes(ray, *start);
                *found = kernel.meet(root.walk.node(slot.link), &boxes, *limit, met);
            }
        }
        for ((&i, found), met) in nodes.iter().zip(&found).zip(&met) {
            // SAFETY: as above; stacks are never fuller than trees are built for.
            unsafe {
                let slot = &mut *slots.add(usize::from(i));
                let node = slot.entrant.root.walk.node(slot.link);
                let top = slot.top().add(slot.len + 1);
                slot.len += kernel.sort(node, met, *found, top);
                slot.pop();
                slot.fetch();
                next.put(i, slot.link);
            }
        }
        let leaves = turns.of(LEAVES);
        for (&i, found) in leaves.iter().zip(&mut found) {
            // SAFETY: as above.
            let slot = unsafe { &*slots.add(usize::from(i)) };
            *found = traffic.look(kernel, usize::from(i), &slot.entrant, slot.link & !LEAF);
        }
        for (&i, &found) in leaves.iter().zip(&found) {
            // SAFETY: as above; all entries up to `len` were written.
            unsafe {
                let slot = &mut *slots.add(usize::from(i));
                if found == 0 {
                    slot.pop();
                } else {
                    let leaf = slot.link & !LEAF;
                    let then = traffic.visit(kernel, usize::from(i), &slot.entrant, leaf, found);
                    slot.go_on(then);
                }
                slot.fetch();
                next.put(i, slot.link);
            }
        }
        for &i in turns.of(ENDS) {
            // SAFETY: as above.
            unsafe {
                let slot = &mut *slots.add(usize::from(i));
                if slot.floor == 0 {
                    free[idle] = i;
                    idle += 1;
                    continue;
                }
                slot.floor = 0;
                traffic.rise(kernel, usize::from(i), &mut slot.entrant);
                slot.cut();
                slot.pop();
                slot.fetch();
                next.put(i, slot.link);
            }
        }
        std::mem::swap(&mut turns, &mut next);
    }
}

use std::mem::MaybeUninit;

use crate::accel::ray::TreeRay;

use super::Walk;
use super::kernel::{Kernel, STACK, Waiting};
use super::node::{LEAF, Node};

/// Rays under way at once: while one waits for memory or for its own last result, others go on.
pub(in crate::accel) const RAYS: usize = 16;

/// The link at the bottom of each stack.
const DONE: u32 = u32::MAX;

/// A ray made ready for a tree, with the part of it that matters in units of the box test.
pub(in crate::accel) struct Entrant {
    pub ray: TreeRay,
    pub start: f32,
    pub limit: f32,
}

/// What a ray does after a leaf.
pub(in crate::accel) enum Next {
    /// It goes on.
    On,
    /// It goes on to this limit.
    To(f32),
    /// It has seen enough.
    Stop,
}

/// Many rays, and what they find.
pub(in crate::accel) trait Traffic {
    /// The next ray, which is to be number `slot` of those under way.
    fn enter(&mut self, slot: usize) -> Option<Entrant>;

    /// Number `slot` is at a leaf.
    fn visit<K: Kernel<N>, const N: usize>(
        &mut self,
        kernel: K,
        slot: usize,
        entrant: &Entrant,
        leaf: u32,
    ) -> Next;

    /// Where the leaves stand, how far apart, and how many bytes they take.
    fn leaves(&self) -> (*const u8, usize, usize);

    /// Number `slot` has seen all that it meets, and its place is free.
    fn leave(&mut self, slot: usize);
}

struct Slot {
    entrant: Entrant,
    link: u32,
    /// Entries on the stack below `link`.
    len: u32,
    stack: [MaybeUninit<Waiting>; STACK],
}

/// Walks many rays through a tree, [`RAYS`] at a time: in turns, those at a node take a step and those at a leaf visit it.
#[inline(always)]
#[allow(
    clippy::large_stack_arrays,
    reason = "128 KiB, of which few pages are used, for batches of thousands"
)]
pub(super) fn stream<K: Kernel<N>, const N: usize>(
    kernel: K,
    walk: Walk<'_, N>,
    traffic: &mut impl Traffic,
) {
    let mut slots = [const { MaybeUninit::<Slot>::uninit() }; RAYS];
    let slots = slots.as_mut_ptr().cast::<Slot>();
    let (mut at_node, mut nodes) = ([0_u8; RAYS + 1], 0);
    let (mut at_leaf, mut leaves) = ([0_u8; RAYS + 1], 0);
    let (leaves_at, leaf_size, leaf_bytes) = traffic.leaves();
    let far = leaf_bytes > FAR;
    let places = [
        (walk.nodes.as_ptr().cast::<u8>(), size_of::<Node<N>>()),
        (leaves_at, leaf_size),
    ];
    // SAFETY: slots below `RAYS` are only read after `admit` has written them; `push` has the room of a stack that is
    // never fuller than the tree's depth allows, above the `len` entries written before.
    unsafe {
        let admit = |traffic: &mut _, i: usize| -> bool {
            let Some(entrant) = Traffic::enter(traffic, i) else {
                return false;
            };
            let slot = slots.add(i);
            (&raw mut (*slot).entrant).write(entrant);
            (*slot).link = walk.root;
            (*slot).len = 0;
            // For when nothing is left.
            (*slot).stack[0].write(u64::from(DONE));
            true
        };
        for i in 0..RAYS {
            if !admit(traffic, i) {
                break;
            }
            let leaf = usize::from(walk.root & LEAF != 0);
            at_node[nodes] = i as u8;
            nodes += 1 - leaf;
            at_leaf[leaves] = i as u8;
            leaves += leaf;
        }
        while nodes + leaves > 0 {
            let waiting = std::mem::take(&mut nodes);
            for k in 0..waiting {
                let i = at_node[k];
                let slot = &mut *slots.add(i as usize);
                let Entrant { ray, start, limit } = &slot.entrant;
                let boxes = kernel.boxes(ray, *start);
                let node = walk.nodes.get_unchecked(slot.link as usize);
                let stack = slot.stack.as_mut_ptr().cast::<Waiting>();
                let count = kernel.push(node, &boxes, *limit, stack.add(slot.len as usize + 1));
                let top = slot.len as usize + count;
                slot.link = *stack.add(top) as u32;
                slot.len = top.wrapping_sub(1) as u32;
                let leaf = (slot.link >> 31) as usize;
                if far {
                    fetch(places[leaf], slot.link & !LEAF);
                }
                at_node[nodes] = i;
                nodes += 1 - leaf;
                at_leaf[leaves] = i;
                leaves += leaf;
            }
            let waiting = std::mem::take(&mut leaves);
            for k in 0..waiting {
                let i = at_leaf[k];
                let slot = &mut *slots.add(i as usize);
                let stack = slot.stack.as_mut_ptr().cast::<Waiting>();
                if slot.link == DONE {
                    traffic.leave(i as usize);
                    if !admit(traffic, i as usize) {
                        continue;
                    }
                } else {
                    match traffic.visit(kernel, i as usize, &slot.entrant, slot.link & !LEAF) {
                        Next::On => {}
                        Next::To(limit) => {
                            slot.entrant.limit = limit;
                            let bits = limit.max(0.0).to_bits();
                            let mut kept = 0;
                            for at in 1..=slot.len as usize {
                                let waiting = *stack.add(at);
                                stack.add(kept + 1).write(waiting);
                                kept += usize::from((waiting >> 32) as u32 <= bits);
                            }
                            slot.len = kept as u32;
                        }
                        Next::Stop => slot.len = 0,
                    }
                    let top = slot.len as usize;
                    slot.link = *stack.add(top) as u32;
                    slot.len = top.wrapping_sub(1) as u32;
                }
                let leaf = (slot.link >> 31) as usize;
                if far {
                    fetch(places[leaf], slot.link & !LEAF);
                }
                at_node[nodes] = i;
                nodes += 1 - leaf;
                at_leaf[leaves] = i;
                leaves += leaf;
            }
        }
    }
}

/// Trees of so many bytes are read from afar, and asking ahead pays.
const FAR: usize = 16 << 20;

/// Asks for the cache lines of element `index` of an array, which need not be there.
#[inline(always)]
fn fetch((base, size): (*const u8, usize), index: u32) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..LINES {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let place = base.wrapping_add(index as usize * size + 64 * line);
        // SAFETY: a prefetch of any address does no harm.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(place.cast()) };
    }
}

/// Cache lines that a step reads: 5 of a leaf, 7 of a node of 16.
const LINES: usize = 6;

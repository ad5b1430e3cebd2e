//! One pass along a ray: operands are found in order of distance, their crossings taken in order, and a count an
//! operator tells where the ray enters and leaves the solid.

use std::cell::RefCell;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

use crate::accel::boxes::BoxTree;
use crate::accel::ray::TreeRay;
use crate::accel::wide::{Children, Kernel, LEAF, Task, Waiting, Walk, is_near, limit_bits};
use crate::math::Ray;

use super::CsgTree;
use super::operand::Event;

/// Where a ray crosses the surface of the whole solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flip {
    pub(super) t: f64,
    /// Position of the leaf whose surface it is.
    pub(super) leaf: u32,
    pub(super) face: u32,
    /// Whether the ray goes in.
    pub(super) enter: bool,
}

/// What a thread keeps between rays.
#[derive(Default)]
struct Scratch {
    counts: Vec<Count>,
    /// Counts of other epochs are those of a point outside of all operands.
    epoch: u32,
    /// Subtrees that wait, nearest first.
    frontier: BinaryHeap<Reverse<Waiting>>,
    events: BinaryHeap<Pending>,
    cluster: Vec<Event>,
}

#[derive(Clone, Copy, Default)]
struct Count {
    epoch: u32,
    value: i32,
}

/// An event that waits, the one that may be earliest first.
struct Pending(Event);

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The boxes' side of a pass, with the ray's ends in the units of the box test.
struct Front<'a, K: Kernel<N>, const N: usize> {
    kernel: K,
    walk: Walk<'a, N>,
    ray: TreeRay,
    boxes: K::Boxes,
    start: f32,
    end: f32,
}

/// A pass over an object with boxes.
struct Pass<'a, V> {
    sweep: Sweep<'a>,
    boxes: &'a BoxTree,
    visit: V,
}

impl<B, V: FnMut(Flip) -> ControlFlow<B>> Task for Pass<'_, V> {
    type Output = ControlFlow<B>;

    #[inline(always)]
    fn run<K: Kernel<N>, const N: usize>(self, kernel: K, walk: Walk<'_, N>) -> ControlFlow<B> {
        let Self {
            sweep,
            boxes,
            visit,
        } = self;
        let local = boxes.local_ray(kernel, sweep.ray);
        let start = local.box_start(sweep.ray.tmin);
        let front = Front {
            kernel,
            walk,
            boxes: kernel.boxes(&local, start),
            start: start.max(0.0),
            end: local.box_limit(sweep.ray.tmax),
            ray: local,
        };
        (sweep.scratch.frontier).push(Reverse(Waiting::from(walk.root())));
        sweep.run(visit, |sweep| sweep.advance(&front))
    }
}

/// The state of one pass.
struct Sweep<'a> {
    tree: &'a CsgTree,
    ray: &'a Ray,
    scratch: &'a mut Scratch,
    /// Whether the ray is inside the solid.
    inside: bool,
}

impl CsgTree {
    /// Calls `visit` where the ray goes into or out of the solid, in order, with `tmin < t < tmax`, until it breaks.
    ///
    /// Crossings that are closer to one another than their uncertainty are one event, after which the state is
    /// looked at: where faces coincide there is neither a skin nor a crack.
    pub(super) fn sweep<B>(
        &self,
        ray: &Ray,
        visit: impl FnMut(Flip) -> ControlFlow<B>,
    ) -> Option<B> {
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.begin(self.operators.len());
            let mut sweep = Sweep {
                tree: self,
                ray,
                scratch,
                inside: self.inside_at_nothing(),
            };
            for position in 0..self.unbounded {
                sweep.load(position);
            }
            match &self.tree {
                None => sweep.run(visit, |_| {}),
                Some(boxes) => boxes.run(
                    ray,
                    Pass {
                        sweep,
                        boxes,
                        visit,
                    },
                ),
            }
            .break_value()
        })
    }

    /// Whether the solid holds a point that the leaves at `holding` hold and no others.
    pub(super) fn holds(&self, holding: impl Iterator<Item = u32>) -> bool {
        SCRATCH.with_borrow_mut(|scratch| {
            scratch.begin(self.operators.len());
            let mut sweep = Sweep {
                tree: self,
                ray: &Ray::new(glam::DVec3::ZERO, glam::DVec3::X),
                scratch,
                inside: self.inside_at_nothing(),
            };
            for leaf in holding {
                sweep.toggle(leaf, true);
            }
            sweep.inside
        })
    }

    fn inside_at_nothing(&self) -> bool {
        let root = self.operators[0];
        (root.count > 0) == root.or
    }
}

impl Scratch {
    fn begin(&mut self, operators: usize) {
        if self.counts.len() < operators {
            self.counts.resize(operators, Count::default());
        }
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.counts.fill(Count::default());
            self.epoch = 1;
        }
        self.frontier.clear();
        self.events.clear();
    }
}

impl Sweep<'_> {
    /// `advance` loads every leaf that may have an event before the next one ends.
    #[inline(always)]
    fn run<B>(
        mut self,
        mut visit: impl FnMut(Flip) -> ControlFlow<B>,
        advance: impl Fn(&mut Self),
    ) -> ControlFlow<B> {
        loop {
            advance(&mut self);
            let Some(Pending(first)) = self.scratch.events.pop() else {
                return ControlFlow::Continue(());
            };
            if first.earliest() >= self.ray.tmax {
                return ControlFlow::Continue(());
            }
            if let Some(flip) = self.cross(first)
                && flip.t > self.ray.tmin
                && flip.t < self.ray.tmax
            {
                visit(flip)?;
            }
        }
    }

    #[inline(always)]
    fn advance<K: Kernel<N>, const N: usize>(&mut self, front: &Front<'_, K, N>) {
        let mut limit = self.limit(front);
        while let Some(&Reverse(next)) = self.scratch.frontier.peek()
            && is_near(next, limit)
        {
            self.scratch.frontier.pop();
            let mut link = next as u32;
            loop {
                if link & LEAF != 0 {
                    self.load(self.tree.unbounded + (link & !LEAF));
                    limit = self.limit(front);
                    break;
                }
                let mut room = Children::new();
                let children =
                    (front.walk).children(front.kernel, link, &front.boxes, front.end, &mut room);
                let Some((&nearest, others)) = children.split_last() else {
                    break;
                };
                (self.scratch.frontier).extend(others.iter().map(|&child| Reverse(child)));
                if !is_near(nearest, limit) {
                    self.scratch.frontier.push(Reverse(nearest));
                    break;
                }
                link = nearest as u32;
            }
        }
    }

    /// What lies behind cannot belong to the next event; but whatever holds the start comes before everything else.
    /// In the bits that [`is_near`] takes.
    #[inline(always)]
    fn limit<K: Kernel<N>, const N: usize>(&self, front: &Front<'_, K, N>) -> u32 {
        let limit = (self.scratch.events.peek())
            .map_or(f32::INFINITY, |next| front.ray.box_limit(next.0.latest()));
        limit_bits(limit.max(front.start))
    }

    #[inline(always)]
    fn load(&mut self, position: u32) {
        let tree = self.tree;
        let leaf = &tree.leaves[position as usize];
        let (form, map) = (
            &tree.forms[leaf.form as usize],
            &tree.maps[leaf.map as usize],
        );
        let events = &mut self.scratch.events;
        leaf.events(position, form, map, self.ray, |event| {
            events.push(Pending(event));
        });
    }

    /// Takes `first` and all events that cannot be told from it; says whether the state changed.
    #[inline(always)]
    fn cross(&mut self, first: Event) -> Option<Flip> {
        let before = self.inside;
        let alone =
            (self.scratch.events.peek()).is_none_or(|next| next.0.earliest() > first.latest());
        if alone {
            self.toggle(first.leaf, first.enter);
            return (self.inside != before).then(|| self.flip(&first));
        }
        let mut cluster = std::mem::take(&mut self.scratch.cluster);
        cluster.clear();
        cluster.push(first);
        while let Some(next) = self.scratch.events.peek()
            && next.0.earliest() <= first.latest()
        {
            cluster.push(next.0);
            self.scratch.events.pop();
        }
        for event in &cluster {
            self.toggle(event.leaf, event.enter);
        }
        let flip = (self.inside != before).then(|| self.surface_of(&mut cluster));
        self.scratch.cluster = cluster;
        flip
    }

    fn flip(&self, event: &Event) -> Flip {
        Flip {
            t: event.t,
            leaf: event.leaf,
            face: event.face,
            enter: self.inside,
        }
    }

    /// Whose surface it is that the cluster, just taken, crosses: that of an operand whose change alone makes the
    /// difference, before all others or after them; of several a positive one, then the lowest.
    fn surface_of(&mut self, cluster: &mut [Event]) -> Flip {
        let leaves = &self.tree.leaves;
        let rank = |event: &Event| {
            let leaf = &leaves[event.leaf as usize];
            (leaf.negated(), leaf.id)
        };
        cluster.sort_unstable_by(|a, b| {
            rank(a)
                .cmp(&rank(b))
                .then(a.t.total_cmp(&b.t))
                .then(a.enter.cmp(&b.enter))
        });
        // An operand that is crossed an even number of times is where it was.
        let after = self.inside;
        let changed = || {
            (cluster.chunk_by(|a, b| a.leaf == b.leaf))
                .filter(|events| events.len() % 2 == 1)
                .map(|events| &events[events.len() - 1])
                .filter(|last| (last.enter != leaves[last.leaf as usize].negated()) == after)
        };
        for event in changed() {
            self.toggle(event.leaf, !event.enter);
            let decides = self.inside != after;
            self.toggle(event.leaf, event.enter);
            if decides {
                return self.flip(event);
            }
        }
        for event in cluster.iter() {
            self.toggle(event.leaf, !event.enter);
        }
        let mut decisive = None;
        for event in changed() {
            self.toggle(event.leaf, event.enter);
            let decides = self.inside == after;
            self.toggle(event.leaf, !event.enter);
            if decides {
                decisive = Some(event);
                break;
            }
        }
        for event in cluster.iter() {
            self.toggle(event.leaf, event.enter);
        }
        self.flip(decisive.or_else(|| changed().next()).unwrap_or(&cluster[0]))
    }

    /// The leaf at `position` is now inside or outside; operators hear of it as far as it makes a difference.
    #[inline(always)]
    fn toggle(&mut self, position: u32, inside: bool) {
        let leaf = &self.tree.leaves[position as usize];
        let mut truth = inside != leaf.negated();
        let mut index = leaf.parent();
        loop {
            let operator = &self.tree.operators[index as usize];
            let count = &mut self.scratch.counts[index as usize];
            if count.epoch != self.scratch.epoch {
                *count = Count {
                    epoch: self.scratch.epoch,
                    value: operator.count,
                };
            }
            let was = (count.value > 0) == operator.or;
            count.value += if truth == operator.or { 1 } else { -1 };
            let is = (count.value > 0) == operator.or;
            if is == was {
                return;
            }
            if index == 0 {
                self.inside = is;
                return;
            }
            truth = is;
            index = operator.parent;
        }
    }
}

// The greatest of a heap is to be the earliest.
impl Ord for Pending {
    fn cmp(&self, other: &Self) -> Ordering {
        let (a, b) = (&self.0, &other.0);
        (b.earliest().total_cmp(&a.earliest())).then(a.latest().total_cmp(&b.latest()))
    }
}

/// Heaps ask for these beside [`Ord`].
macro_rules! ordered_by_cmp {
    ($($name:ty),*) => {$(
        impl PartialOrd for $name {
            fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
                Some(self.cmp(other))
            }
        }
        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                self.cmp(other).is_eq()
            }
        }
        impl Eq for $name {}
    )*};
}
ordered_by_cmp!(Pending);

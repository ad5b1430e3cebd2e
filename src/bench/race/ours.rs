use std::cell::RefCell;
use std::sync::Arc;

use crate::accel::{Accel, Hit};
use crate::math::Ray;

use super::engine::{Answers, Engine};

/// Our trees, asked ray by ray.
pub(super) struct Single(pub Arc<Accel>);

impl Engine for Single {
    type Ray = Ray;

    fn load(&self, rays: &[Ray]) -> Vec<Ray> {
        rays.to_vec()
    }

    fn closest(&self, rays: &[Ray]) -> Answers {
        let hits = rays.iter().filter_map(|ray| self.0.intersect(ray));
        hits.fold(Answers::default(), |sum, hit| sum.with(hit.t))
    }

    fn any(&self, rays: &[Ray]) -> Answers {
        Answers::of_blocked(rays.iter().map(|ray| self.0.occluded(ray)))
    }
}

/// Our trees, asked for many rays at once.
pub(super) struct Batch(pub Arc<Accel>);

thread_local! {
    /// Where a thread's answers go, as in any program that asks again and again.
    static HITS: RefCell<Vec<Option<Hit>>> = const { RefCell::new(Vec::new()) };
    static BLOCKED: RefCell<Vec<bool>> = const { RefCell::new(Vec::new()) };
}

impl Engine for Batch {
    type Ray = Ray;

    fn load(&self, rays: &[Ray]) -> Vec<Ray> {
        rays.to_vec()
    }

    fn closest(&self, rays: &[Ray]) -> Answers {
        HITS.with_borrow_mut(|hits| {
            hits.resize(rays.len(), None);
            self.0.intersect_batch(rays, hits);
            let found = hits.iter().flatten();
            found.fold(Answers::default(), |sum, hit| sum.with(hit.t))
        })
    }

    fn any(&self, rays: &[Ray]) -> Answers {
        BLOCKED.with_borrow_mut(|blocked| {
            blocked.resize(rays.len(), false);
            self.0.occluded_batch(rays, blocked);
            Answers::of_blocked(blocked.iter().copied())
        })
    }
}

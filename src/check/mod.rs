//! Hits of a mesh against Embree's, every difference judged by an arbiter in f64.

mod arbiter;
mod rays;

pub use arbiter::{Arbiter, Verdict};
pub use rays::{RayClass, RayMaker};

use rayon::prelude::*;

use crate::accel::{Accel, Hit, Placed};
use crate::embree::{EmbreeHit, EmbreeOptions, EmbreeScene};
use crate::error::Result;
use crate::geometry::{Mesh, MeshId, Shape};
use crate::math::{Ray, Transform};

/// What comparing one class of rays found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Rays traced.
    pub rays: u64,
    /// Of them, how many we say hit.
    pub hits: u64,
    /// Differences in which the arbiter finds us wrong.
    pub ours_wrong: u64,
    /// Differences in which the arbiter finds Embree wrong.
    pub embree_wrong: u64,
    /// Different primitives at the same distance, and differences too close for the arbiter.
    pub ties: u64,
    /// The largest `|dt|` of agreeing hits, as a part of [`dt_bound`].
    pub worst_dt: f64,
}

impl Tally {
    /// The sums of both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            ours_wrong: self.ours_wrong + other.ours_wrong,
            embree_wrong: self.embree_wrong + other.embree_wrong,
            ties: self.ties + other.ties,
            worst_dt: self.worst_dt.max(other.worst_dt),
        }
    }
}

/// How far Embree's f32 `t` may be from the truth before it counts as another hit: roundings of the
/// origin, of the corners relative to it and of the edge functions, `reach` being the largest distance
/// among them, seen at the angle at which the ray meets the triangle.
pub fn dt_bound(ray: &Ray, hit: &Hit, mesh: &Mesh) -> f64 {
    let [a, b, c] = mesh.corners(hit.primitive).map(glam::Vec3::as_dvec3);
    let cross = (b - a).cross(c - a);
    let reach = [a, b, c]
        .into_iter()
        .map(|p| (p - ray.origin).abs().max_element())
        .fold(0.0, f64::max);
    // A sliver's edge functions cancel: their error counts against its area.
    let longest = (b - a).length().max((c - a).length()).max((c - b).length());
    let shape = (longest * longest / cross.length()).max(1.0);
    let facing = (cross.normalize().dot(ray.direction)).abs();
    2.0_f64.powi(-20) * reach * shape / facing
}

/// A mesh in our tree, in Embree's robust scene, and before the arbiter.
pub struct Comparison<'a> {
    mesh: &'a Mesh,
    ours: Accel,
    embree: EmbreeScene,
    arbiter: Arbiter<'a>,
}

impl<'a> Comparison<'a> {
    /// Builds both trees.
    ///
    /// # Errors
    /// Where the mesh is invalid or Embree fails.
    pub fn new(mesh: &'a Mesh, robust: bool) -> Result<Self> {
        let placed = Placed {
            shape: Shape::Mesh(MeshId(0)),
            world_from_object: Transform::IDENTITY,
        };
        let options = EmbreeOptions {
            robust,
            ..EmbreeOptions::default()
        };
        Ok(Self {
            ours: Accel::build(std::slice::from_ref(mesh), &[], vec![placed])?,
            embree: EmbreeScene::new(&[(mesh, &Transform::IDENTITY)], options)?,
            arbiter: Arbiter::new(mesh),
            mesh,
        })
    }

    /// Traces `count` rays of one class on all threads and judges every difference.
    pub fn run(&self, class: RayClass, count: u64, seed: u64) -> Tally {
        const CHUNK: u64 = 1 << 14;
        let maker = RayMaker::new(self.mesh, &self.ours);
        (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let rays = CHUNK.min(count - chunk * CHUNK) as usize;
                (maker.rays(class, seed, chunk).take(rays))
                    .map(|ray| self.compare(&ray))
                    .fold(Tally::default(), Tally::plus)
            })
            .reduce(Tally::default, Tally::plus)
    }

    fn compare(&self, ray: &Ray) -> Tally {
        let ours = self.ours.intersect(ray);
        let theirs = self.embree.intersect(ray);
        let mut tally = Tally {
            rays: 1,
            hits: u64::from(ours.is_some()),
            ..Tally::default()
        };
        assert_eq!(
            self.ours.occluded(ray),
            ours.is_some(),
            "closest and any hit differ for {ray:?}"
        );
        match (&ours, &theirs) {
            (None, None) => {}
            (Some(a), Some(b)) if self.same_distance(ray, a, b) => {
                tally.ties = u64::from(a.primitive != b.primitive);
                if tally.ties == 0 {
                    tally.worst_dt = (a.t - f64::from(b.t)).abs() / dt_bound(ray, a, self.mesh);
                }
            }
            _ => self.judge(ray, ours.as_ref(), theirs.as_ref(), &mut tally),
        }
        tally
    }

    fn same_distance(&self, ray: &Ray, ours: &Hit, theirs: &EmbreeHit) -> bool {
        let dt = (ours.t - f64::from(theirs.t)).abs();
        let other = Hit {
            primitive: theirs.primitive,
            ..*ours
        };
        dt <= dt_bound(ray, ours, self.mesh).max(dt_bound(ray, &other, self.mesh))
    }

    fn judge(&self, ray: &Ray, ours: Option<&Hit>, theirs: Option<&EmbreeHit>, tally: &mut Tally) {
        let nearest = self.arbiter.nearest(ray);
        let our_hit = ours.map(|h| (h.t, h.primitive));
        let a = self.arbiter.judge(ray, nearest, our_hit, 1e-9);
        let their_hit = theirs.map(|h| (f64::from(h.t), h.primitive));
        let b = self.arbiter.judge(ray, nearest, their_hit, 1e-3);
        tally.ours_wrong += u64::from(a == Verdict::Wrong);
        tally.embree_wrong += u64::from(b == Verdict::Wrong);
        tally.ties += u64::from(a != Verdict::Wrong && b != Verdict::Wrong);
    }
}

//! Rays against the naive boolean over Embree's hits on tessellated operands.

use glam::DVec3;
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::CsgTree;
use solidtrace::geometry::Solid;
use solidtrace::math::Ray;

use super::tessellation::Sandwich;
use super::tree::{CONES, TORI};
use super::{Leaf, Naive, Stretches, Tree, random_ray};

/// Tessellations of all that random trees are made of.
pub struct Peer {
    sandwiches: Vec<Sandwich>,
}

/// What comparing rays found.
#[derive(Clone, Debug, Default)]
pub struct RayTally {
    pub rays: u64,
    /// Of them, how many hit by the peer.
    pub hits: u64,
    /// Those whose first hit the peer cannot tell: where the whole is in doubt, more than one operand is, or it is as
    /// it was before. An operand is in doubt between its two meshes, and as near to them as f32 rounds.
    pub grazing: u64,
    /// Crossings beyond the first that were compared as well.
    pub further: u64,
    pub wrong: u64,
    /// The first that was wrong.
    pub example: Option<String>,
}

/// Half-spaces end here, and rays do.
const WORLD: f64 = 8.0;

impl RayTally {
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            grazing: self.grazing + other.grazing,
            further: self.further + other.further,
            wrong: self.wrong + other.wrong,
            example: self.example.or(other.example),
        }
    }
}

impl Peer {
    pub fn new() -> Self {
        let cones = CONES.map(|(from_radius, to_radius)| Solid::Cone {
            from_radius,
            to_radius,
            height: 1.0,
        });
        let tori = TORI.map(|minor| Solid::Torus { major: 1.0, minor });
        let others = [
            Solid::Sphere { radius: 1.0 },
            Solid::Box { half: DVec3::ONE },
            Solid::Cylinder {
                radius: 1.0,
                height: 1.0,
            },
            Solid::Plane,
        ];
        let all = cones.iter().chain(&tori).chain(&others);
        Self {
            sandwiches: all.map(Sandwich::new).collect(),
        }
    }

    /// Compares `count` rays.
    pub fn compare(
        &self,
        tree: &Tree,
        judged: &CsgTree,
        count: u64,
        rng: &mut Pcg64Mcg,
    ) -> RayTally {
        let leaves = tree.leaves();
        let mut tally = RayTally {
            rays: count,
            ..RayTally::default()
        };
        for _ in 0..count {
            let mut ray = random_ray(rng);
            ray.tmax = end(&ray);
            let naive = self.naive(tree, &leaves, &ray);
            if !naive.complete && naive.crossings.is_empty() {
                tally.grazing += 1;
                continue;
            }
            let first = judged.intersect(&ray);
            let all = judged.crossings(&ray);
            tally.hits += u64::from(!naive.crossings.is_empty());
            tally.further += naive.crossings.len().saturating_sub(1) as u64;
            if !naive.agrees(&all) || first.as_ref() != all.first() {
                tally.wrong += 1;
                tally.example.get_or_insert_with(|| {
                    format!("{ray:?} meets {tree:#?}\nin {first:?}\nof {all:#?}\nfor {naive:#?}")
                });
            }
        }
        tally
    }

    fn naive(&self, tree: &Tree, leaves: &[Leaf], ray: &Ray) -> Naive {
        let stretches = |leaf: &Leaf| {
            let sandwich = self.sandwiches.iter().find(|s| s.fits(&leaf.solid));
            let sandwich = sandwich.expect("all proportions are there");
            sandwich.stretches(leaf, ray, WORLD)
        };
        let stretches: Vec<Stretches> = leaves.iter().map(stretches).collect();
        Naive::combine(tree, &stretches, ray)
    }
}

/// Where a ray from within the ball of radius [`WORLD`] leaves it.
fn end(ray: &Ray) -> f64 {
    let (o, d) = (ray.origin, ray.direction);
    let (a, b) = (d.length_squared(), o.dot(d));
    let c = o.length_squared() - WORLD * WORLD;
    ((b * b - a * c).sqrt() - b) / a
}

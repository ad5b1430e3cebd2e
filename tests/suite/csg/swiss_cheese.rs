//! A block with 100,000 spherical holes, the eye in one of them, against a test of every sphere.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};
use rand::RngExt;
use solidtrace::accel::{CsgCrossing, CsgTree};
use solidtrace::geometry::{Csg, CsgOp, Operand, Solid};
use solidtrace::math::{Ray, Transform};

use super::oracle::{rng, unit};

const HOLES: usize = 100_000;

struct Cheese {
    tree: CsgTree,
    centers: Vec<DVec3>,
    radius: f64,
}

/// The unit cube minus spheres whose volumes sum up to `fill`.
fn cheese(fill: f64) -> Cheese {
    let mut rng = rng(HOLES as u64);
    let radius = (fill / HOLES as f64 * 0.75 / PI).cbrt();
    let mut csg = Csg::default();
    let half = DVec3::splat(0.5);
    csg.push(
        Operand::Solid(Solid::Box { half }),
        &Transform::IDENTITY,
        0..1,
    );
    let mut center = || DVec3::from_array(std::array::from_fn(|_| rng.random_range(-0.5..0.5)));
    let centers: Vec<DVec3> = (0..HOLES).map(|_| center()).collect();
    for &center in &centers {
        let place = Transform::new(DAffine3::from_translation(center)).unwrap();
        csg.push(Operand::Solid(Solid::Sphere { radius }), &place, 0..1);
    }
    csg.combine(CsgOp::Difference, HOLES + 1);
    Cheese {
        tree: CsgTree::build(&csg, &[]).unwrap(),
        centers,
        radius,
    }
}

impl Cheese {
    /// (t, operand, whether it is entered) of all crossings in front of a ray of unit direction.
    fn brute_force(&self, ray: &Ray) -> Vec<(f64, u32, bool)> {
        let (o, d) = (ray.origin, ray.direction);
        let mut ends = Vec::new();
        for (center, operand) in self.centers.iter().zip(1..) {
            let t = (center - o).dot(d);
            let room = self.radius * self.radius - (o + t * d - center).length_squared();
            if room > 0.0 {
                ends.extend([
                    (t - room.sqrt(), operand, 1),
                    (t + room.sqrt(), operand, -1),
                ]);
            }
        }
        let (a, b) = ((-0.5 - o) / d, (0.5 - o) / d);
        let (enter, exit) = (a.min(b).max_element(), a.max(b).min_element());
        if enter < exit {
            ends.extend([(enter, 0, 0), (exit, 0, 0)]);
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut block, mut holes) = (false, 0);
        let mut inside = false;
        let mut crossings = Vec::new();
        for (t, operand, step) in ends {
            holes += step;
            block ^= operand == 0;
            let now = block && holes == 0;
            if now != inside && t > 0.0 {
                crossings.push((t, operand, now));
            }
            inside = now;
        }
        crossings
    }
}

fn assert_like_brute_force(fill: f64) {
    let cheese = cheese(fill);
    let mut rng = rng(1);
    let mut count = 0;
    for i in 0..600 {
        let d = unit(&mut rng);
        let origin = match i % 3 {
            // In a hole.
            0 | 1 => {
                cheese.centers[rng.random_range(0..HOLES)] + 0.3 * cheese.radius * unit(&mut rng)
            }
            _ => -1.5 * d + 0.4 * unit(&mut rng),
        };
        let ray = Ray::new(origin, d);
        let truth = cheese.brute_force(&ray);
        let found = cheese.tree.crossings(&ray);
        let same = |(a, b): (&CsgCrossing, &(f64, u32, bool))| {
            (a.t - b.0).abs() < 1e-9 && (a.operand, a.enter, a.negated) == (b.1, b.2, b.1 != 0)
        };
        assert_eq!(found.len(), truth.len(), "{ray:?}");
        assert!(
            found.iter().zip(&truth).all(same),
            "{ray:?}: {found:#?} for {truth:#?}"
        );
        assert_eq!(
            cheese.tree.intersect(&ray),
            found.first().copied(),
            "{ray:?}"
        );
        assert_eq!(
            cheese.tree.contains(origin),
            i % 3 == 2 && starts_inside(&truth),
            "{ray:?}"
        );
        count += truth.len();
    }
    println!("{count} crossings of 600 rays at {fill}");
    assert!(count > 1000, "{count}");
}

fn starts_inside(truth: &[(f64, u32, bool)]) -> bool {
    truth.first().is_some_and(|first| !first.2)
}

#[test]
fn a_hundred_thousand_holes_of_a_fifth_of_a_block_are_met_as_by_brute_force() {
    assert_like_brute_force(0.2);
}

#[test]
fn a_hundred_thousand_holes_three_times_as_large_as_their_block_are_met_as_by_brute_force() {
    assert_like_brute_force(3.0);
}

//! Random trees against truth tables: points, rays, and both with Embree as the judge.
//!
//! The long run: `tests/with-embree.sh cargo run --release --features embree --example csg_oracle`

use glam::DAffine3;
use rand::RngExt;
use rayon::prelude::*;
use solidtrace::accel::{CsgCrossing, CsgTree};
use solidtrace::math::Ray;

use super::oracle::{
    Expected, Leaf, Naive, PointTally, Tree, compare_points, outside, random_ray, rng, unit,
};
use super::{block, point, sphere};

/// The tree of a seed, and rays at it.
fn tree_and_rays(seed: u64, rays: usize) -> (Tree, Vec<Ray>) {
    let mut rng = rng(seed);
    let tree = Tree::random(&mut rng, 6);
    let rays = (0..rays).map(|_| random_ray(&mut rng)).collect();
    (tree, rays)
}

#[test]
fn points_are_inside_as_the_truth_table_says() {
    let tally = (0..100_u64)
        .into_par_iter()
        .map(|seed| {
            let mut rng = rng(seed);
            let tree = Tree::random(&mut rng, 6);
            compare_points(&tree, &tree.build(), 2000, &mut rng)
        })
        .reduce(PointTally::default, PointTally::plus);
    println!("{tally:?}");
    assert_eq!(tally.wrong, 0, "{tally:?}");
    assert!(tally.inside > tally.points / 5 && tally.near < tally.points / 100);
}

#[test]
fn crossings_are_those_of_a_naive_boolean_over_all_operands() {
    let counts = (0..400_u64).into_par_iter().map(|seed| {
        let (tree, rays) = tree_and_rays(1000 + seed, 500);
        let (judged, leaves) = (tree.build(), tree.leaves());
        let (mut crossings, mut doubtful) = (0, 0);
        for ray in &rays {
            let naive = Naive::of(&tree, &leaves, ray);
            let all = judged.crossings(ray);
            assert!(
                naive.agrees(&all),
                "{ray:?} meets {tree:#?} in {all:#?} for {naive:#?}"
            );
            crossings += naive.crossings.len();
            doubtful += usize::from(!naive.complete);
        }
        (crossings, doubtful)
    });
    let (crossings, doubtful) = counts.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    println!("{crossings} crossings agree, {doubtful} rays graze");
    assert!(
        crossings > 100_000 && doubtful < 200,
        "{crossings} {doubtful}"
    );
}

#[test]
fn the_naive_boolean_is_the_truth_table_of_points_between_crossings() {
    for seed in 0..100 {
        let (tree, rays) = tree_and_rays(2000 + seed, 100);
        let leaves = tree.leaves();
        for ray in &rays {
            let naive = Naive::of(&tree, &leaves, ray);
            if !naive.complete {
                continue;
            }
            let middle = |c: &Expected| 0.5 * (c.within.min + c.within.max);
            let mut stops: Vec<f64> = naive.crossings.iter().map(middle).collect();
            stops.insert(0, 0.0);
            stops.push(stops[stops.len() - 1] + 9.0);
            let inside = |t: f64| {
                let p = ray.at(t);
                let holds = |leaf: &Leaf| outside(&leaf.solid, leaf.back.transform_point3(p)) < 0.0;
                let holding: Vec<Option<bool>> = leaves.iter().map(|l| Some(holds(l))).collect();
                tree.holds(&holding) == Some(true)
            };
            let mut truth = (naive.crossings.first()).map_or_else(|| inside(1.0), |c| !c.enter);
            for gap in stops.windows(2) {
                for part in [0.01, 0.3, 0.5, 0.8, 0.99] {
                    let t = gap[0] + part * (gap[1] - gap[0]);
                    assert_eq!(inside(t), truth, "{ray:?} at {t} of {stops:?}: {tree:#?}");
                }
                truth = !truth;
            }
        }
    }
}

/// All that `intersect` finds if each search goes on from the last hit.
fn one_by_one(tree: &CsgTree, ray: &Ray) -> Vec<CsgCrossing> {
    let mut rest = *ray;
    let mut found = Vec::new();
    while let Some(crossing) = tree.intersect(&rest) {
        rest.tmin = crossing.t;
        found.push(crossing);
    }
    found
}

#[test]
fn the_first_crossing_and_whether_there_is_one_are_those_of_the_list_for_any_ends() {
    for seed in 0..150 {
        let (tree, rays) = tree_and_rays(3000 + seed, 100);
        let judged = tree.build();
        let mut rng = rng(seed);
        for ray in &rays {
            let all = judged.crossings(ray);
            assert!(all.is_sorted_by(|a, b| a.t <= b.t), "{ray:?} {tree:#?}");
            assert!(
                all.windows(2).all(|w| w[0].enter != w[1].enter),
                "{ray:?} {tree:#?}"
            );
            assert_eq!(one_by_one(&judged, ray), all, "{ray:?} {tree:#?}");
            let mut end = || match (rng.random_range(0..4), all.as_slice()) {
                (0, [.., last]) => last.t,
                (1, [first, ..]) => first.t,
                _ => rng.random_range(0.0..12.0) / ray.direction.length(),
            };
            let (a, b) = (end(), end());
            let piece = Ray {
                tmin: a.min(b),
                tmax: a.max(b),
                ..*ray
            };
            let inside = |c: &&CsgCrossing| c.t > piece.tmin && c.t < piece.tmax;
            let some: Vec<CsgCrossing> = all.iter().filter(inside).copied().collect();
            assert_eq!(judged.crossings(&piece), some, "{piece:?} {tree:#?}");
            assert_eq!(judged.intersect(&piece), some.first().copied(), "{piece:?}");
            assert_eq!(judged.occluded(&piece), !some.is_empty(), "{piece:?}");
        }
    }
}

#[test]
fn a_ray_that_starts_between_crossings_meets_those_behind_its_start() {
    for seed in 0..150 {
        let (tree, rays) = tree_and_rays(4000 + seed, 60);
        let judged = tree.build();
        for ray in &rays {
            let all = judged.crossings(ray);
            let gaps = all.windows(2).enumerate();
            for (i, gap) in gaps.filter(|(_, w)| w[1].t - w[0].t > 1e-3 / ray.direction.length()) {
                let t = 0.5 * (gap[0].t + gap[1].t);
                let rest = judged.crossings(&Ray::new(ray.at(t), ray.direction));
                let same = rest.len() == all.len() - i - 1
                    && (rest.iter().zip(&all[i + 1..])).all(|(a, b)| {
                        (a.t + t - b.t).abs() < 1e-9 * b.t
                            && (a.operand, a.face, a.enter) == (b.operand, b.face, b.enter)
                    });
                // Grazing crossings may be there or not.
                let decided = Naive::of(&tree, &tree.leaves(), ray).complete;
                assert!(
                    same || !decided,
                    "{ray:?} from {t}: {rest:?} for {all:?} of {tree:#?}"
                );
                assert_eq!(judged.contains(ray.at(t)), gap[0].enter, "{ray:?} at {t}");
            }
        }
    }
}

#[cfg(feature = "embree")]
#[test]
fn crossings_are_those_of_embree_on_tessellated_operands() {
    use super::oracle::{Peer, RayTally};

    let peer = Peer::new();
    let tally = (0..200_u64)
        .into_par_iter()
        .map(|seed| {
            let mut rng = rng(seed);
            let tree = Tree::random(&mut rng, 6);
            // Boxes are meshes in every other tree.
            let judged = if seed % 2 == 0 {
                tree.build()
            } else {
                tree.build_with_meshes()
            };
            peer.compare(&tree, &judged, 2000, &mut rng)
        })
        .reduce(RayTally::default, RayTally::plus);
    if let Some(example) = &tally.example {
        println!("{example}");
    }
    assert_eq!(tally.wrong, 0, "{} of {}", tally.wrong, tally.rays);
    println!(
        "{} rays, {} hits, {} crossings further on, {} graze",
        tally.rays, tally.hits, tally.further, tally.grazing
    );
    assert!(tally.hits > tally.rays / 4 && tally.grazing < tally.rays / 50);
}

#[test]
fn faces_that_lie_in_the_boxes_of_other_operands_are_met_by_rays_from_afar() {
    let crossings: usize = (0..60_u64)
        .into_par_iter()
        .map(|seed| {
            let mut rng = rng(5000 + seed);
            // The box's faces are where all the others can matter at most.
            let half = point(&mut rng, 0.2).abs() + 0.3;
            let block = block((-half).to_array(), half.to_array(), DAffine3::IDENTITY);
            let ball = sphere(half.max_element() * 1.3, DAffine3::IDENTITY);
            let pips = (0..rng.random_range(0..40)).map(|_| {
                let place = DAffine3::from_translation(half * unit(&mut rng));
                sphere(rng.random_range(0.02..0.2), place)
            });
            let tree = Tree::intersection([ball, block]);
            let tree = Tree::difference([vec![tree], pips.collect()].concat());
            let (judged, leaves) = (tree.build(), tree.leaves());
            let mut crossings = 0;
            for i in 0..2000 {
                let origin = 4.0_f64.powi(i % 12 - 1) * unit(&mut rng);
                let to = half * point(&mut rng, 1.2);
                let ray = Ray::new(origin, (to - origin).normalize());
                let naive = Naive::of(&tree, &leaves, &ray);
                let found = judged.crossings(&ray);
                assert!(naive.agrees(&found), "{ray:?}: {found:#?} for {naive:#?}");
                crossings += found.len();
            }
            crossings
        })
        .sum();
    assert!(crossings > 100_000, "{crossings}");
}

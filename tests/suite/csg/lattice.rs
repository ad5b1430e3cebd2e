//! Random trees of blocks on a lattice: most of their faces coincide, and still the truth is known exactly.

use glam::{DAffine3, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::CsgCrossing;
use solidtrace::geometry::CsgOp;
use solidtrace::math::Ray;

use super::coincident::two_places;
use super::oracle::{Tree, rng};
use super::{block, half_space};

/// Blocks have corners from 0 to this.
const SIZE: u32 = 4;

/// What a leaf holds on the lattice: the box between two corners.
struct Cells {
    min: DVec3,
    max: DVec3,
}

/// A tree of blocks, some of them endless, each in one of two places that differ by rounding.
fn grow(rng: &mut Pcg64Mcg, depth: u32, places: &[DAffine3; 2], cells: &mut Vec<Cells>) -> Tree {
    if depth == 0 {
        let place = places[rng.random_range(0..2)];
        let pairs = [0; 3].map(|_| {
            let (low, high) = (rng.random_range(0..SIZE), rng.random_range(0..SIZE));
            [low.min(high), low.max(high) + 1].map(f64::from)
        });
        let (mut min, mut max) = (
            DVec3::from_array(pairs.map(|pair| pair[0])),
            DVec3::from_array(pairs.map(|pair| pair[1])),
        );
        let tree = if rng.random_range(0..6) == 0 {
            let axis = rng.random_range(0..3);
            let top = max[axis];
            (min, max) = (DVec3::NEG_INFINITY, DVec3::INFINITY);
            max[axis] = top;
            let Tree::Leaf(leaf) = half_space(DVec3::AXES[axis], top) else {
                unreachable!("a half-space is a leaf");
            };
            Tree::leaf(leaf.solid, place * leaf.place)
        } else {
            block(min.to_array(), max.to_array(), place)
        };
        cells.push(Cells { min, max });
        return tree;
    }
    let op = [CsgOp::Union, CsgOp::Intersection, CsgOp::Difference][rng.random_range(0..3)];
    let operands = (0..rng.random_range(2..5)).map(|_| {
        let shallower = rng.random_range(0..depth);
        grow(rng, shallower, places, cells)
    });
    Tree::Node(op, operands.collect())
}

/// The crossings of a ray of lattice space, or `None` where it comes close to an edge.
fn truth(tree: &Tree, cells: &[Cells], ray: &Ray) -> Option<Vec<(f64, bool)>> {
    let mut stops = vec![0.0];
    for axis in 0..3 {
        let plane = |k: u32| (f64::from(k) - ray.origin[axis]) / ray.direction[axis];
        stops.extend((0..=SIZE).map(plane).filter(|t| *t > 0.0));
    }
    stops.sort_by(f64::total_cmp);
    stops.push(stops[stops.len() - 1] + 1.0);
    if stops.windows(2).any(|gap| gap[1] - gap[0] < 1e-5) {
        return None;
    }
    let inside = |gap: &[f64]| {
        let p = ray.at(0.5 * (gap[0] + gap[1]));
        let holds = |c: &Cells| p.cmpgt(c.min).all() && p.cmplt(c.max).all();
        let holding: Vec<Option<bool>> = cells.iter().map(|c| Some(holds(c))).collect();
        tree.holds(&holding) == Some(true)
    };
    let mut state = inside(&stops[..2]);
    let mut crossings = Vec::new();
    for gap in stops.windows(2) {
        if inside(gap) != state {
            state = !state;
            crossings.push((gap[0], state));
        }
    }
    Some(crossings)
}

#[test]
fn trees_whose_faces_coincide_are_crossed_where_the_truth_changes() {
    let mut rng = rng(1);
    let mut crossings = 0;
    for i in 0..1500 {
        let offset = [0.0, 1.0, 30.0, 1e5][i % 4];
        let places = two_places(&mut rng, offset);
        let mut cells = Vec::new();
        let depth = rng.random_range(1..6);
        let tree = grow(&mut rng, depth, &places, &mut cells);
        let judged = [tree.build(), tree.build_with_meshes()];
        for _ in 0..20 {
            let mut point = |low: f64, high: f64| {
                DVec3::from_array(std::array::from_fn(|_| rng.random_range(low..high)))
            };
            let origin = point(-3.0, 7.0);
            let ray = Ray::new(origin, point(0.0, 4.0) - origin);
            let Some(truth) = truth(&tree, &cells, &ray) else {
                continue;
            };
            let world = Ray::new(
                places[0].transform_point3(ray.origin),
                places[0].transform_vector3(ray.direction),
            );
            for judged in &judged {
                let found = judged.crossings(&world);
                let same = |(a, b): (&CsgCrossing, &(f64, bool))| {
                    (a.t - b.0).abs() < 1e-6 && a.enter == b.1
                };
                assert!(
                    found.len() == truth.len() && found.iter().zip(&truth).all(same),
                    "{world:?}: {found:#?} for {truth:?} of {tree:#?}"
                );
                assert_eq!(judged.intersect(&world), found.first().copied());
            }
            crossings += truth.len();
        }
    }
    assert!(crossings > 15_000, "{crossings}");
}

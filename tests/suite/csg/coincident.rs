//! Faces that coincide: no skins, no cracks, no inner faces.

use glam::{DAffine3, DMat3, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::CsgTree;
use solidtrace::geometry::{Csg, CsgOp, Operand, Solid};
use solidtrace::math::{Ray, Transform};

use super::oracle::{Leaf, Naive, Tree, outside, random_place, random_ray, rng, unit};
use super::{SOLIDS, alternate, block, point, rotation, times};

/// A place of the whole, said in two ways that differ by their roundings.
pub fn two_places(rng: &mut Pcg64Mcg, offset: f64) -> [DAffine3; 2] {
    let [a, b, c] = std::array::from_fn(|_| rng.random_range(-3.0..3.0));
    let origin = offset * unit(rng);
    let turn = DMat3::from_rotation_z(a) * DMat3::from_rotation_y(b) * DMat3::from_rotation_x(c);
    let first = DAffine3::from_mat3_translation(turn, origin);
    let second = DAffine3::from_translation(origin)
        * DAffine3::from_rotation_z(a)
        * DAffine3::from_quat(glam::DQuat::from_rotation_y(b) * glam::DQuat::from_rotation_x(c));
    [first, second]
}

/// Pockets in the cube of half size 1, each flush with it at z = 1; the last two at its edge and at its corner as well.
const POCKETS: [([f64; 3], [f64; 3]); 3] = [
    ([-0.5, -0.5, 0.0], [0.5, 0.5, 1.0]),
    ([0.2, -0.5, -0.3], [1.0, 0.6, 1.0]),
    ([-1.0, 0.1, 0.1], [-0.3, 1.0, 1.0]),
];

/// The parameter at which a ray from inside of a box leaves it.
fn leaves_box(ray: &Ray, min: [f64; 3], max: [f64; 3]) -> f64 {
    let (min, max) = (DVec3::from_array(min), DVec3::from_array(max));
    let (a, b) = (
        (min - ray.origin) / ray.direction,
        (max - ray.origin) / ray.direction,
    );
    a.max(b).min_element()
}

/// Rays through the mouth of a flush pocket find its walls, from outside and from inside.
fn assert_no_skin(rng: &mut Pcg64Mcg, places: [DAffine3; 2], pocket: usize, tolerance: f64) {
    let (min, max) = POCKETS[pocket];
    let tree = Tree::difference([
        block([-1.0; 3], [1.0; 3], places[0]),
        block(min, max, places[1]),
    ])
    .build();
    for _ in 0..20 {
        let mut between = |i: usize| {
            let (a, b) = (min[i], max[i]);
            let margin = 1e-6 + tolerance;
            rng.random_range(a + margin..b - margin)
        };
        let mouth = DVec3::new(between(0), between(1), 1.0);
        let floor = DVec3::new(between(0), between(1), between(2).min(0.9));
        // The ray through both in the pocket's own space.
        let local = Ray::new(mouth, floor - mouth);
        let truth = leaves_box(&Ray::new(floor, local.direction), min, max) + 1.0;
        let ray = Ray::new(local.at(-2.5), local.direction);
        let world = Ray::new(
            places[0].transform_point3(ray.origin),
            places[0].transform_vector3(ray.direction),
        );
        let hit = tree.intersect(&world);
        let wall = hit.filter(|hit| hit.operand == 1 && hit.negated && hit.enter);
        // Where it leaves through a flush side there is no wall.
        let p = local.at(truth);
        let open = p.x > 1.0 - 1e-9 || p.x < -1.0 + 1e-9 || p.y > 1.0 - 1e-9;
        if open {
            assert!(hit.is_none(), "{world:?}: {hit:?} in an open side");
        } else {
            let close = wall.is_some_and(|hit| (hit.t - truth - 2.5).abs() < tolerance);
            assert!(close, "{world:?}: {hit:?} for the wall at {}", truth + 2.5);
        }
        let out = Ray::new(world.at(3.5), -world.direction);
        assert!(
            !tree.occluded(&out),
            "{out:?}: {:?} in the mouth",
            tree.intersect(&out)
        );
    }
}

#[test]
fn a_flush_pocket_has_no_skin_under_a_thousand_rotations() {
    let mut rng = rng(1);
    for i in 0..1000 {
        let [place, _] = two_places(&mut rng, f64::from(i % 3));
        assert_no_skin(&mut rng, [place; 2], i as usize % 3, 1e-9);
    }
}

#[test]
fn a_flush_pocket_has_no_skin_where_each_operand_is_rotated_by_itself() {
    let mut rng = rng(2);
    for i in 0..1000 {
        let places = two_places(&mut rng, f64::from(i % 3));
        assert_no_skin(&mut rng, places, i as usize % 3, 1e-9);
    }
}

#[test]
fn a_flush_pocket_has_no_skin_far_from_the_origin() {
    let mut rng = rng(3);
    for i in 0..300 {
        let places = two_places(&mut rng, 1e5);
        assert_no_skin(&mut rng, places, i as usize % 3, 1e-7);
    }
}

#[test]
fn a_pocket_filled_with_an_insert_that_fits_is_a_whole_block() {
    let mut rng = rng(4);
    for i in 0..300 {
        let places = two_places(&mut rng, [0.0, 1.0, 1e5][i % 3]);
        let (min, max) = POCKETS[i % 2];
        let whole = block([-1.0; 3], [1.0; 3], places[0]);
        let rest = Tree::difference([whole.clone(), block(min, max, places[1])]);
        let filled = Tree::union([rest, block(min, max, places[i / 3 % 2])]).build();
        let whole = whole.build();
        for _ in 0..30 {
            let origin = 4.0 * unit(&mut rng);
            let ray = Ray::new(
                places[0].transform_point3(origin),
                places[0].transform_vector3(point(&mut rng, 0.99) - origin),
            );
            let (a, b) = (filled.crossings(&ray), whole.crossings(&ray));
            let close = a.iter().zip(&b).all(|(a, b)| (a.t - b.t).abs() < 1e-7);
            assert!(a.len() == b.len() && close, "{ray:?}: {a:#?} for {b:#?}");
        }
    }
}

#[test]
fn boxes_that_touch_have_no_inner_face() {
    let mut rng = rng(5);
    for i in 0..1000 {
        let offset = [0.0, 1.0, 1e5][i % 3];
        let places = two_places(&mut rng, offset);
        // They share the part of x = 0 with y in -0.5..1 and z in -0.8..0.4.
        let (a, b) = (
            ([-1.0, -1.0, -1.0], [0.0, 1.0, 1.0]),
            ([0.0, -0.5, -0.8], [0.7, 1.3, 0.4]),
        );
        let glass = Tree::union([
            block(a.0, a.1, places[0]),
            block(b.0, b.1, places[i / 3 % 2]),
        ])
        .build();
        for _ in 0..30 {
            let margin = 1e-5;
            let shared = DVec3::new(
                0.0,
                rng.random_range(-0.5 + margin..1.0 - margin),
                rng.random_range(-0.8 + margin..0.4 - margin),
            );
            let mut d = unit(&mut rng);
            d.x = 0.01 + d.x.abs();
            let out = leaves_box(&Ray::new(shared, d), b.0, b.1);
            let back = leaves_box(&Ray::new(shared, -d), a.0, a.1);
            let world = |p: DVec3| places[0].transform_point3(p);
            let start = world(shared - 4.0 * d);
            for (ray, truth) in [
                (
                    Ray::new(start, places[0].transform_vector3(d)),
                    [4.0 - back, 4.0 + out],
                ),
                (
                    Ray::new(world(shared + 4.0 * d), -places[0].transform_vector3(d)),
                    [4.0 - out, 4.0 + back],
                ),
            ] {
                let t = times(&glass.crossings(&ray));
                let close = t
                    .iter()
                    .zip(truth)
                    .all(|(t, truth)| (t - truth).abs() < 1e-7);
                assert!(t.len() == 2 && close, "{ray:?}: {t:?} for {truth:?}");
            }
        }
    }
}

/// Two copies of `leaf`, combined.
fn twice(op: CsgOp, solid: Solid, places: [&Transform; 2]) -> CsgTree {
    let mut csg = Csg::default();
    for place in places {
        csg.push(Operand::Solid(solid), place, 0..1);
    }
    csg.combine(op, 2);
    CsgTree::build(&csg, &[]).unwrap()
}

/// Rays of all kinds, among them tangents and rays at edges and apices.
fn rays(rng: &mut Pcg64Mcg, leaf: &Leaf) -> Vec<Ray> {
    let special = |rng: &mut Pcg64Mcg| {
        let face = rng.random_range(0..3);
        let p = leaf.solid.project(1.5 * unit(rng), face);
        let tangent = leaf.solid.normal(p, face).cross(unit(rng));
        let p = match rng.random_range(0..4) {
            0 => leaf.solid.bounds().max.min(DVec3::splat(2.0)),
            _ => p,
        };
        let off = 10_f64.powf(rng.random_range(-17.0..-3.0)) * unit(rng);
        let d = leaf.place.transform_vector3(tangent + off);
        let far = 10_f64.powf(rng.random_range(0.5..4.0));
        Ray::new(leaf.place.transform_point3(p) - far * d, d)
    };
    let mut rays: Vec<Ray> = (0..100).map(|_| random_ray(rng)).collect();
    rays.extend((0..100).map(|_| special(rng)));
    rays
}

#[test]
fn a_solid_and_its_copy_make_nothing_or_itself() {
    let mut rng = rng(6);
    for i in 0..180 {
        let solid = SOLIDS[i % SOLIDS.len()];
        let leaf = Leaf::new(solid, random_place(&mut rng));
        let place = Transform::new(leaf.place).unwrap();
        let [nothing, common, both] = [CsgOp::Difference, CsgOp::Intersection, CsgOp::Union]
            .map(|op| twice(op, solid, [&place; 2]));
        let one = Tree::Leaf(leaf).build();
        for ray in rays(&mut rng, &leaf) {
            let truth = one.crossings(&ray);
            assert_eq!(nothing.crossings(&ray), [], "{ray:?} {leaf:?}");
            assert_eq!(common.crossings(&ray), truth, "{ray:?} {leaf:?}");
            assert_eq!(both.crossings(&ray), truth, "{ray:?} {leaf:?}");
        }
    }
}

/// Whether a shift by less than nothing makes a difference: of two copies such a ray may meet one alone.
fn grazes(one: &Tree, leaf: &Leaf, ray: &Ray) -> bool {
    let mut counts = DVec3::AXES
        .into_iter()
        .flat_map(|axis| [-1e-10, 1e-10].map(|x| x * axis))
        .map(|shift| {
            let moved = Ray::new(ray.origin + shift, ray.direction);
            let naive = Naive::of(one, &[*leaf], &moved);
            let starts_inside =
                outside(&leaf.solid, leaf.back.transform_point3(moved.origin)) < 0.0;
            naive
                .complete
                .then_some((naive.crossings.len(), starts_inside))
        });
    let first = counts.next().flatten();
    first.is_none() || counts.any(|count| count != first)
}

#[test]
fn a_solid_and_its_copy_under_a_transform_composed_otherwise_make_nothing_or_itself() {
    let mut rng = rng(7);
    let mut compared = 0;
    for i in 0..180 {
        let solid = SOLIDS[i % SOLIDS.len()];
        let outer = random_place(&mut rng);
        let inner = DAffine3::from_mat3_translation(rotation(&mut rng), point(&mut rng, 0.5));
        let leaf = Leaf::new(solid, outer * inner);
        let place = Transform::new(leaf.place).unwrap();
        let other = Transform::new(outer)
            .unwrap()
            .after(&Transform::new(inner).unwrap());
        let [nothing, common, both] = [CsgOp::Difference, CsgOp::Intersection, CsgOp::Union]
            .map(|op| twice(op, solid, [&place, &other]));
        let one = Tree::Leaf(leaf);
        let judged = one.build();
        for ray in rays(&mut rng, &leaf) {
            if grazes(&one, &leaf, &ray) {
                continue;
            }
            compared += 1;
            let truth = judged.crossings(&ray);
            assert_eq!(nothing.crossings(&ray), [], "{ray:?} {leaf:?}");
            for tree in [&common, &both] {
                let crossings = tree.crossings(&ray);
                let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9 * b;
                let same = crossings.len() == truth.len()
                    && times(&crossings).iter().zip(&times(&truth)).all(close);
                assert!(same, "{ray:?} {leaf:?}: {crossings:#?} for {truth:#?}");
            }
        }
    }
    assert!(compared > 18_000, "{compared}");
}

#[test]
fn rays_at_the_rim_of_a_flush_pocket_go_in_and_out_by_turns() {
    let mut rng = rng(8);
    for i in 0..300 {
        let places = two_places(&mut rng, f64::from(i % 2));
        let (min, max) = POCKETS[i as usize % 3];
        let tree = Tree::difference([
            block([-1.0; 3], [1.0; 3], places[0]),
            block(min, max, places[i as usize % 2]),
        ])
        .build();
        for _ in 0..50 {
            let mut rim = DVec3::from_array(max);
            rim[rng.random_range(0..2)] = min[0];
            rim.y = rng.random_range(min[1]..max[1]);
            let origin = DVec3::new(0.0, 0.0, 3.0) + point(&mut rng, 2.0);
            let ray = Ray::new(
                places[0].transform_point3(origin),
                places[0].transform_vector3(rim - origin),
            );
            let crossings = tree.crossings(&ray);
            assert!(alternate(&crossings), "{ray:?}: {crossings:#?}");
        }
    }
}

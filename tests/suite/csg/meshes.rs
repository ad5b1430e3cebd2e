//! Meshes as operands: the same as the solids whose shape they have, and never lost at vertices and edges.

use glam::{DAffine3, DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use solidtrace::accel::{CsgCrossing, CsgTree};
use solidtrace::geometry::{Csg, CsgOp, Mesh, MeshId, Operand, Solid};
use solidtrace::math::{Ray, Transform};

use super::oracle::{Naive, PointTally, Tree, compare_points, random_place, random_ray, rng, unit};
use super::{alternate, point, times};
use crate::support::meshes::{box_mesh, bumpy_sphere, torus_mesh};

#[test]
fn random_trees_with_meshes_for_boxes_are_crossed_as_a_naive_boolean_says() {
    let counts = (0..200_u64).into_par_iter().map(|seed| {
        let mut rng = rng(5000 + seed);
        let tree = Tree::random(&mut rng, 6);
        let (judged, leaves) = (tree.build_with_meshes(), tree.leaves());
        let mut count = 0;
        for _ in 0..300 {
            let ray = random_ray(&mut rng);
            let naive = Naive::of(&tree, &leaves, &ray);
            let found = judged.crossings(&ray);
            assert!(
                naive.agrees(&found),
                "{ray:?}: {found:#?} for {naive:#?} of {tree:#?}"
            );
            assert_eq!(judged.intersect(&ray), found.first().copied());
            count += found.len();
        }
        count
    });
    let count: usize = counts.sum();
    assert!(count > 20_000, "{count}");
}

#[test]
fn points_are_inside_trees_with_meshes_for_boxes_as_the_truth_table_says() {
    let tally = (0..100_u64)
        .into_par_iter()
        .map(|seed| {
            let mut rng = rng(6000 + seed);
            let tree = Tree::random(&mut rng, 6);
            compare_points(&tree, &tree.build_with_meshes(), 500, &mut rng)
        })
        .reduce(PointTally::default, PointTally::plus);
    assert_eq!(tally.wrong, 0, "{tally:?}");
}

/// A mesh and another operand, both in one place.
fn pair(op: CsgOp, mesh: &Mesh, other: Operand, place: DAffine3) -> CsgTree {
    let mut csg = Csg::default();
    let place = Transform::new(place).unwrap();
    csg.push(Operand::Mesh(MeshId(0)), &place, 0..1);
    csg.push(other, &place, 0..1);
    csg.combine(op, 2);
    CsgTree::build(&csg, std::slice::from_ref(mesh)).unwrap()
}

fn alone(mesh: &Mesh) -> CsgTree {
    let mut csg = Csg::default();
    csg.push(Operand::Mesh(MeshId(0)), &Transform::IDENTITY, 0..1);
    CsgTree::build(&csg, std::slice::from_ref(mesh)).unwrap()
}

/// From outside at a vertex, a point of an edge, or a point of a face.
fn aimed(rng: &mut Pcg64Mcg, mesh: &Mesh) -> Ray {
    let i = rng.random_range(0..mesh.triangles.len() as u32);
    let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
    let target = match rng.random_range(0..4) {
        0 => a,
        1 => a.lerp(b, rng.random()),
        2 => 0.5 * (a + b),
        _ => a.lerp(b, rng.random()).lerp(c, rng.random()),
    };
    let origin = match rng.random_range(0..4) {
        // Along an axis, so that nothing rounds.
        0 => target - 4.0 * DVec3::AXES[rng.random_range(0..3)],
        _ => 4.0 * unit(rng),
    };
    Ray::new(origin, target - origin)
}

/// How often the mesh winds around `p`: the solid angles of its triangles (Van Oosterom and Strackee 1983, "The Solid
/// Angle of a Plane Triangle").
fn winding(mesh: &Mesh, p: DVec3) -> f64 {
    let angle = |i: u32| {
        let [a, b, c] = mesh.corners(i).map(|q| q.as_dvec3() - p);
        let [x, y, z] = [a, b, c].map(DVec3::length);
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    (0..mesh.triangles.len() as u32).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[test]
fn rays_at_vertices_and_edges_of_a_mesh_go_in_and_out_where_it_winds() {
    let meshes = [
        box_mesh(Vec3::NEG_ONE, Vec3::ONE),
        torus_mesh(24, 12, 1.0, 0.4),
        bumpy_sphere(10),
    ];
    let mut rng = rng(1);
    let mut judged = 0;
    for mesh in &meshes {
        let tree = alone(mesh);
        for _ in 0..1000 {
            let ray = aimed(&mut rng, mesh);
            let found = tree.crossings(&ray);
            assert!(alternate(&found), "{ray:?}: {found:#?}");
            assert_eq!(tree.occluded(&ray), !found.is_empty());
            let mut stops = times(&found);
            stops.insert(0, 0.0);
            stops.push(2.5);
            for (i, gap) in stops.windows(2).enumerate() {
                let p = ray.at(0.5 * (gap[0] + gap[1]));
                let aside = 1e-6 * DVec3::new(1.0, 0.7, 0.3);
                let [a, b] = [p - aside, p + aside].map(|p| winding(mesh, p) > 0.5);
                // In a face it is neither.
                if a == b && gap[1] - gap[0] > 1e-5 {
                    assert_eq!(a, i % 2 == 1, "{ray:?} at {p}: {found:#?}");
                    judged += 1;
                }
            }
        }
    }
    assert!(judged > 8000, "{judged}");
}

#[test]
fn rays_at_vertices_and_edges_of_a_mesh_with_a_hole_go_in_and_out_by_turns() {
    let mesh = bumpy_sphere(12);
    let mut rng = rng(2);
    for _ in 0..20 {
        let at = mesh.positions[rng.random_range(0..mesh.positions.len())].as_dvec3();
        // A ball around a vertex, and a box with a corner in it.
        let half = DVec3::splat(0.5);
        let solids = [
            (Solid::Sphere { radius: 0.4 }, at),
            (Solid::Box { half }, at + half),
        ];
        let mut csg = Csg::default();
        csg.push(Operand::Mesh(MeshId(0)), &Transform::IDENTITY, 0..1);
        for (solid, center) in solids {
            let place = Transform::new(DAffine3::from_translation(center)).unwrap();
            csg.push(Operand::Solid(solid), &place, 0..1);
        }
        csg.combine(CsgOp::Difference, 3);
        let tree = CsgTree::build(&csg, std::slice::from_ref(&mesh)).unwrap();
        for _ in 0..300 {
            let ray = aimed(&mut rng, &mesh);
            let found = tree.crossings(&ray);
            assert!(alternate(&found), "{ray:?}: {found:#?}");
            let mut rest = ray;
            for crossing in &found {
                assert_eq!(tree.intersect(&rest), Some(*crossing), "{rest:?}");
                rest.tmin = crossing.t;
            }
        }
    }
}

/// Equal but for rounding, and for which face it is.
fn same(a: &[CsgCrossing], b: &[CsgCrossing]) -> bool {
    let close =
        |(a, b): (&CsgCrossing, &CsgCrossing)| (a.t - b.t).abs() < 1e-9 * b.t && a.enter == b.enter;
    a.len() == b.len() && a.iter().zip(b).all(close)
}

#[test]
fn a_mesh_and_the_solid_of_its_shape_make_nothing_or_itself() {
    let cube = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    let solid = Operand::Solid(Solid::Box { half: DVec3::ONE });
    let mut rng = rng(3);
    for _ in 0..60 {
        let place = random_place(&mut rng);
        let tree = |op| pair(op, &cube, solid, place);
        let [nothing, common, both] =
            [CsgOp::Difference, CsgOp::Intersection, CsgOp::Union].map(tree);
        let truth = Tree::leaf(Solid::Box { half: DVec3::ONE }, place).build();
        for _ in 0..200 {
            let target = place.transform_point3(point(&mut rng, 1.0));
            let origin = 7.0 * unit(&mut rng);
            let ray = Ray::new(origin, target - origin);
            let truth = truth.crossings(&ray);
            assert_eq!(nothing.crossings(&ray), [], "{ray:?} {place}");
            assert!(same(&common.crossings(&ray), &truth), "{ray:?} {place}");
            assert!(same(&both.crossings(&ray), &truth), "{ray:?} {place}");
        }
    }
}

#[test]
fn a_mesh_and_its_copy_make_nothing_or_itself_at_vertices_and_edges_too() {
    let mut rng = rng(4);
    for mesh in [torus_mesh(24, 12, 1.0, 0.4), bumpy_sphere(10)] {
        let copy = Operand::Mesh(MeshId(0));
        let tree = |op| pair(op, &mesh, copy, DAffine3::IDENTITY);
        let [nothing, common, both] =
            [CsgOp::Difference, CsgOp::Intersection, CsgOp::Union].map(tree);
        let one = alone(&mesh);
        for _ in 0..3000 {
            let ray = aimed(&mut rng, &mesh);
            let truth = one.crossings(&ray);
            assert_eq!(nothing.crossings(&ray), [], "{ray:?}");
            // At an edge either of its triangles will do.
            assert!(same(&common.crossings(&ray), &truth), "{ray:?}");
            assert!(same(&both.crossings(&ray), &truth), "{ray:?}");
        }
    }
}

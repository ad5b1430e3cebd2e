use std::f64::consts::TAU;

use glam::{DVec3, Vec2, Vec3, Vec3Swizzles};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{MeshCrossing, MeshTree};
use crate::accel::meshes::{box_mesh, bumpy_sphere, moved, slivers, sphere_mesh, torus_mesh};
use crate::accel::options::AccelOptions;
use crate::accel::ray::TreeRay;
use crate::geometry::Mesh;
use crate::math::Ray;
use crate::sampling::uniform_sphere;

fn both(a: &Mesh, b: &Mesh) -> Mesh {
    let first = a.positions.len() as u32;
    let shifted = b.triangles.iter().map(|t| t.map(|v| v + first));
    Mesh {
        positions: [a.positions.clone(), b.positions.clone()].concat(),
        triangles: a.triangles.iter().copied().chain(shifted).collect(),
        ..Mesh::default()
    }
}

/// A cube one of whose edges is cut in its middle on one side only; a triangle without area closes the slit.
fn slit_cube() -> Mesh {
    let mut mesh = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    let [a, b, c] = mesh.triangles.remove(0);
    let middle = mesh.positions.len() as u32;
    let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
    mesh.positions.push(0.5 * (p + q));
    (mesh.triangles).extend([[a, middle, c], [middle, b, c], [a, b, middle]]);
    mesh
}

/// Closed meshes of several kinds in several places.
fn operands() -> Vec<(String, Mesh)> {
    let cube = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    let forms = [
        ("cube", cube.clone()),
        ("slit cube", slit_cube()),
        ("cube at the origin", box_mesh(Vec3::ZERO, Vec3::ONE)),
        (
            "two cubes that share an edge",
            both(&cube, &moved(cube.clone(), 1.0, Vec3::new(2.0, 2.0, 0.0))),
        ),
        ("a cube twice", both(&cube, &cube)),
        ("bumpy sphere", bumpy_sphere(12)),
        ("torus", torus_mesh(24, 12, 1.0, 0.4)),
        ("slivers", slivers(12)),
    ];
    let places = [
        ("", 1.0, Vec3::ZERO),
        (" 1e-6 as large", 1e-6, Vec3::ZERO),
        (" 5e-21 as large", 5e-21, Vec3::ZERO),
        (" 1e6 as large", 1e6, Vec3::ZERO),
        (" moved by 1e5", 1.0, Vec3::new(1e5, -1e5, 7e4)),
    ];
    let mut all = Vec::new();
    for (name, mesh) in &forms {
        for (place, scale, offset) in places {
            all.push((format!("{name}{place}"), moved(mesh.clone(), scale, offset)));
        }
    }
    all
}

/// Lines through vertices and points of edges, along edges, in the planes of faces, along axes.
fn hard_line(mesh: &Mesh, rng: &mut Pcg64Mcg) -> Ray {
    let mut corners = || {
        let triangle = rng.random_range(0..mesh.triangles.len() as u32);
        mesh.corners(triangle).map(Vec3::as_dvec3)
    };
    let ([a, b, c], [other, ..]) = (corners(), corners());
    let bounds = mesh.bounds();
    let around = uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3();
    let size = bounds.size().max_element();
    let away = bounds.center() + rng.random_range(0.0..3.0) * size * around;
    let (s, t) = (rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0));
    let axis = DVec3::AXES[rng.random_range(0..3)];
    let tiny = (10.0_f64.powi(rng.random_range(-200..-60)) * around).with_z(0.0);
    let (origin, direction) = match rng.random_range(0..10) {
        0 => (away, a - away),
        1 => (away, a.lerp(b, rng.random()) - away),
        2 => (a - s * (b - a), b - a),
        3 => (
            a + s * (b - a) + t * (c - a),
            (b - a).lerp(c - a, rng.random()),
        ),
        4 => (a, other - a),
        5 => (a - s * (other - a), other - a),
        6 => (a + s * size * axis, axis),
        // Almost in line with the origin cube's edge.
        7 => (tiny.yxz() - s * size * DVec3::Z, tiny + DVec3::Z),
        8 => (a.lerp(b, 0.5) + s * size * axis, -axis),
        _ => (away, around),
    };
    let direction = direction.try_normalize().unwrap_or(axis);
    Ray {
        tmin: f64::NEG_INFINITY,
        ..Ray::new(
            origin,
            direction * 10.0_f64.powf(rng.random_range(-12.0..10.0)),
        )
    }
}

fn crossings(tree: &MeshTree, ray: &Ray) -> Vec<MeshCrossing> {
    let mut found = Vec::new();
    tree.crossings(ray, |crossing| found.push(crossing));
    found.sort_by(|a, b| a.t.total_cmp(&b.t));
    found
}

fn balance(crossings: &[MeshCrossing]) -> i32 {
    (crossings.iter())
        .map(|crossing| if crossing.enter { 1 } else { -1 })
        .sum()
}

/// By the solid angles of the triangles (van Oosterom and Strackee 1983); `None` on the surface.
fn winding_number(mesh: &Mesh, p: DVec3) -> Option<f64> {
    let mut sum = 0.0;
    for i in 0..mesh.triangles.len() as u32 {
        let [a, b, c] = mesh.corners(i).map(|v| v.as_dvec3() - p);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let volume = a.dot(b.cross(c));
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        if volume.abs().max(below) <= 1e-9 * la * lb * lc {
            return None;
        }
        sum += 2.0 * volume.atan2(below);
    }
    Some(sum / (2.0 * TAU))
}

#[test]
fn along_a_line_a_closed_mesh_is_entered_as_often_as_it_is_left() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut met = 0;
    for (name, mesh) in operands() {
        let tree = MeshTree::build_operand(&mesh, AccelOptions::default()).unwrap();
        for _ in 0..10_000 {
            let ray = hard_line(&mesh, &mut rng);
            let found = crossings(&tree, &ray);
            met += found.len();
            assert_eq!(balance(&found), 0, "{name}: {ray:?}: {found:?}");
        }
    }
    assert!(met > 700_000, "{met}");
}

#[test]
fn neither_boxes_nor_the_filter_turn_a_crossing_away() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    for (name, mesh) in operands() {
        let tree = MeshTree::build_operand(&mesh, AccelOptions::default()).unwrap();
        for _ in 0..300 {
            let ray = hard_line(&mesh, &mut rng);
            let local = TreeRay::new(&ray, tree.center, tree.extent);
            let exact = local.exact(&ray, tree.center);
            let all = (tree.triangles())
                .filter(|triangle| triangle.decide_crossing(&local, &exact).is_some());
            assert_eq!(all.count(), crossings(&tree, &ray).len(), "{name}: {ray:?}");
        }
    }
}

#[test]
fn the_count_of_crossings_is_the_winding_number_between_them() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let (mut inside, mut places) = (0, 0);
    for (name, mesh) in operands() {
        let tree = MeshTree::build_operand(&mesh, AccelOptions::default()).unwrap();
        let size = mesh.bounds().size().max_element();
        for _ in 0..100 {
            let ray = hard_line(&mesh, &mut rng);
            let found = crossings(&tree, &ray);
            for (i, pair) in found.windows(2).enumerate() {
                let width = (pair[1].t - pair[0].t) * ray.direction.length();
                let p = ray.at(0.5 * (pair[0].t + pair[1].t));
                let truth = winding_number(&mesh, p).filter(|_| width > 1e-3 * size);
                let Some(truth) = truth else { continue };
                let count = balance(&found[..=i]);
                assert!(
                    (f64::from(count) - truth).abs() < 1e-3,
                    "{name}: {ray:?} at {p}"
                );
                assert_eq!(tree.winding(p), count, "{name} at {p}");
                inside += usize::from(count > 0);
                places += 1;
            }
        }
    }
    assert!(inside > 1000 && places > inside, "{inside} of {places}");
}

#[test]
fn winding_tells_inside_from_outside_of_boxes_and_spheres() {
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let cube =
        MeshTree::build_operand(&box_mesh(Vec3::NEG_ONE, Vec3::ONE), AccelOptions::default())
            .unwrap();
    let sphere =
        MeshTree::build_operand(&sphere_mesh(60, |_| 1.0), AccelOptions::default()).unwrap();
    for _ in 0..20_000 {
        // A third of the coordinates are those of edges and diagonals, or just beside them.
        let p = DVec3::from_array([0; 3].map(|_| match rng.random_range(0..9) {
            0 => 1.0_f64.next_up(),
            1 => (-1.0_f64).next_up(),
            2 => 0.0,
            _ => rng.random_range(-1.5..1.5),
        }));
        let within = p.abs().max_element() < 1.0;
        assert_eq!(cube.winding(p), i32::from(within), "{p}");
        // The flat triangles of the sphere lie between these radii.
        if p.length() < 0.998 || p.length() > 1.000_001 {
            assert_eq!(sphere.winding(p), i32::from(p.length() < 1.0), "{p}");
        }
    }
    let cube = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    let inner = moved(cube.clone(), 0.5, Vec3::ZERO);
    let nested = MeshTree::build_operand(&both(&cube, &inner), AccelOptions::default()).unwrap();
    for (x, winding) in [(0.3, 2), (0.7, 1), (1.3, 0)] {
        assert_eq!(nested.winding(DVec3::splat(x)), winding);
    }
}

#[test]
fn the_first_crossing_is_the_closest_hit_and_its_weights_give_its_point() {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let mut hits = 0;
    for (name, mesh) in operands() {
        let (tree, plain) = (
            MeshTree::build_operand(&mesh, AccelOptions::default()).unwrap(),
            MeshTree::build(&mesh, AccelOptions::default()).unwrap(),
        );
        let bounds = mesh.bounds();
        for _ in 0..300 {
            let around = uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3();
            let to = bounds.min + bounds.size() * DVec3::from_array([0; 3].map(|_| rng.random()));
            let ray = Ray::new(bounds.center() + 2.0 * bounds.size() * around, DVec3::ZERO);
            let ray = Ray {
                direction: to - ray.origin,
                ..ray
            };
            let found = crossings(&tree, &ray);
            let closest = plain.intersect(&ray, ray.tmax).map(|(hit, _)| hit.t);
            assert_eq!(found.first().map(|c| c.t), closest, "{name}: {ray:?}");
            for crossing in &found {
                let weights = tree.barycentric(&ray, crossing.t, crossing.primitive);
                let [a, b, c] = mesh.corners(crossing.primitive).map(Vec3::as_dvec3);
                let p = a + weights.x * (b - a) + weights.y * (c - a);
                let scale = bounds.size().max_element() + ray.origin.abs().max_element();
                assert!(
                    p.distance(ray.at(crossing.t)) < 1e-12 * scale,
                    "{name}: {ray:?}"
                );
                hits += 1;
            }
            let first = found.first().map_or(0.0, |c| c.t);
            let beyond = crossings(&tree, &Ray { tmin: first, ..ray });
            assert!(beyond.iter().eq(found.iter().filter(|c| c.t > first)));
        }
    }
    assert!(hits > 10_000, "{hits}");
}

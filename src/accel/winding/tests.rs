use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{OpenCrossing, WindingNumber, solid_angle};
use crate::accel::mesh::MeshTree;
use crate::accel::meshes::{box_mesh, bumpy_sphere, moved, slivers, sphere_mesh, torus_mesh};
use crate::accel::options::AccelOptions;
use crate::geometry::Mesh;
use crate::math::Ray;
use crate::sampling::uniform_sphere;

fn build(mesh: &Mesh) -> WindingNumber {
    WindingNumber::new(Arc::new(
        MeshTree::build_operand(mesh, AccelOptions::default()).unwrap(),
    ))
}

fn direction(rng: &mut Pcg64Mcg) -> DVec3 {
    uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3()
}

/// The lower half of a sphere, open at y = 0.
fn bowl(rings: u32) -> Mesh {
    let mut mesh = sphere_mesh(rings, |_| 1.0);
    let low = |v: u32| mesh.positions[v as usize].y < 1e-6;
    mesh.triangles.retain(|t| t.iter().all(|&v| low(v)));
    mesh
}

/// A third of the triangles is gone, and a tenth is turned over.
fn tattered(mut mesh: Mesh, rng: &mut Pcg64Mcg) -> Mesh {
    mesh.triangles.retain(|_| rng.random_range(0..3) > 0);
    for triangle in &mut mesh.triangles {
        if rng.random_range(0..10) == 0 {
            triangle.swap(0, 1);
        }
    }
    mesh
}

fn crossings(winding: &WindingNumber, ray: &Ray) -> Vec<OpenCrossing> {
    let mut found = Vec::new();
    winding.open_crossings(ray, |crossing| found.push(crossing));
    found
}

/// The solid angle of the rectangle from `low` to `high` in the plane z = 0, seen from `p` above it.
fn rectangle(low: f64, high: f64, p: DVec3) -> f64 {
    let corner = |x: f64, y: f64| (x * y / (p.z * DVec3::new(x, y, p.z).length())).atan();
    let [x0, x1] = [low - p.x, high - p.x];
    let [y0, y1] = [low - p.y, high - p.y];
    corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
}

#[test]
fn a_closed_mesh_has_1_inside_and_0_outside() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for (scale, offset) in [
        (1.0, Vec3::ZERO),
        (1e-6, Vec3::ZERO),
        (8.0, Vec3::splat(1e5)),
    ] {
        let place = |mesh: Mesh| build(&moved(mesh, scale, offset));
        let (sphere, cube) = (
            place(sphere_mesh(60, |_| 1.0)),
            place(box_mesh(Vec3::NEG_ONE, Vec3::ONE)),
        );
        for _ in 0..10_000 {
            let p = rng.random_range(0.0..3.0) * direction(&mut rng);
            let placed = p * f64::from(scale) + offset.as_dvec3();
            let inside = f64::from(u8::from(p.length() < 1.0));
            if (p.length() - 1.0).abs() > 0.02 {
                assert!((sphere.at(placed) - inside).abs() < 2e-3, "{p}");
            }
            let inside = f64::from(u8::from(p.abs().max_element() < 1.0));
            if (p.abs().max_element() - 1.0).abs() > 0.02 {
                assert!((cube.at(placed) - inside).abs() < 2e-3, "{p}");
            }
        }
    }
}

#[test]
fn a_box_without_a_lid_misses_the_solid_angle_of_the_lid() {
    let mut mesh = box_mesh(Vec3::new(-1.0, -1.0, -2.0), Vec3::new(1.0, 1.0, 0.0));
    mesh.triangles
        .retain(|t| t.iter().any(|&v| mesh.positions[v as usize].z < 0.0));
    assert_eq!(mesh.triangles.len(), 10);
    let winding = build(&mesh);
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    for _ in 0..10_000 {
        let p = DVec3::from_array([0; 3].map(|_| rng.random_range(-2.5..2.5)));
        let inside = p.x.abs() < 1.0 && p.y.abs() < 1.0 && p.z > -2.0 && p.z < 0.0;
        let lid = rectangle(-1.0, 1.0, p) / (2.0 * TAU);
        let number = f64::from(u8::from(inside)) + lid;
        assert!((winding.at(p) - number).abs() < 2e-3, "{p}: {number}");
    }
}

#[test]
fn a_bowl_misses_the_solid_angle_of_its_rim() {
    let winding = build(&bowl(200));
    for i in 1..100 {
        let y = f64::from(i) / 50.0 - 1.01;
        let disc = 0.5 * (1.0 - y.abs() / y.hypot(1.0));
        let number = if y < 0.0 { 1.0 - disc } else { disc };
        let found = winding.at(y * DVec3::Y);
        assert!((found - number).abs() < 2e-3, "{y}: {found} {number}");
    }
}

#[test]
fn groups_taken_together_change_the_number_by_less_than_0_002() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    for mesh in [bumpy_sphere(60), torus_mesh(90, 40, 1.0, 0.4), slivers(40)] {
        for mesh in [mesh.clone(), tattered(mesh, &mut rng)] {
            let winding = build(&mesh);
            let bounds = mesh.bounds();
            let (mut worst, mut total) = (0.0_f64, 0.0);
            for _ in 0..2000 {
                let share = DVec3::from_array([0; 3].map(|_| rng.random_range(-0.7..0.7)));
                let p = bounds.center() + share * bounds.size();
                let local = p - winding.mesh.center;
                let exact: f64 = (winding.triangles.iter())
                    .map(|triangle| solid_angle(triangle, local) / (2.0 * TAU))
                    .sum();
                let error = (winding.at(p) - exact).abs();
                worst = worst.max(error);
                total += error;
            }
            assert!(worst < 2e-3 && total < 1.0, "{worst} {total}");
        }
    }
}

#[test]
fn a_ray_through_the_mouth_of_a_bowl_enters_at_the_plane_of_its_rim() {
    let winding = build(&bowl(100));
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    for _ in 0..500 {
        let to = DVec3::new(
            rng.random_range(-0.6..0.6),
            0.0,
            rng.random_range(-0.6..0.6),
        );
        let mut away = direction(&mut rng);
        away.y = away.y.abs() + 0.3;
        let ray = Ray::new(to + 2.0 * away, -away);
        let found = crossings(&winding, &ray);
        let [mouth, wall] = found[..] else {
            panic!("{ray:?}: {found:?}");
        };
        assert!(
            mouth.enter && mouth.primitive.is_none() && !wall.enter,
            "{found:?}"
        );
        assert!(ray.at(mouth.t).y.abs() < 5e-3, "{ray:?}: {found:?}");
        assert!((ray.at(wall.t).length() - 1.0).abs() < 1e-3 && wall.primitive.is_some());
        assert!(winding.fall(ray.at(mouth.t)).normalize().dot(DVec3::Y) > 0.999);
        // From within the bowl, only the wall is left.
        let inner = Ray {
            tmin: mouth.t + 1e-3 * (wall.t - mouth.t),
            ..ray
        };
        assert_eq!(crossings(&winding, &inner), [wall]);
    }
    // Past the rim there is nothing.
    assert_eq!(
        crossings(&winding, &Ray::new(DVec3::new(2.0, 0.5, 0.0), DVec3::NEG_X)),
        []
    );
}

#[test]
fn an_open_tube_is_entered_and_left_through_its_ends() {
    let mut tube = box_mesh(Vec3::new(-1.0, -1.0, -3.0), Vec3::new(1.0, 1.0, 3.0));
    tube.triangles.retain(|t| {
        let [a, b, c] = t.map(|v| tube.positions[v as usize].z);
        a != b || b != c
    });
    let winding = build(&tube);
    let ray = Ray::new(DVec3::new(0.1, 0.2, -9.0), 3.0 * DVec3::Z);
    let found = crossings(&winding, &ray);
    let [enter, exit] = found[..] else {
        panic!("{found:?}");
    };
    assert!(enter.enter && !exit.enter && enter.primitive.is_none() && exit.primitive.is_none());
    // The other end is seen as well, so the number passes 1/2 a little inside of the tube.
    for (crossing, end) in [(enter, -3.0), (exit, 3.0)] {
        let p = ray.at(crossing.t);
        assert!(
            (winding.at(p) - 0.5).abs() < 1e-9 && (p.z - end).abs() < 0.1,
            "{p}"
        );
        assert!(winding.fall(p).normalize().z * end.signum() > 0.99);
    }
}

#[test]
fn a_closed_mesh_has_the_crossings_of_its_surface() {
    let mesh = torus_mesh(30, 20, 1.0, 0.4);
    let winding = build(&mesh);
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let mut met = 0;
    for _ in 0..2000 {
        let origin = 3.0 * direction(&mut rng);
        let ray = Ray::new(origin, 0.9 * direction(&mut rng) - origin);
        let mut truth = Vec::new();
        winding
            .mesh
            .crossings(&ray, |crossing| truth.push(crossing));
        truth.sort_by(|a, b| a.t.total_cmp(&b.t));
        let truth = truth.iter().map(|c| (c.t, Some(c.primitive), c.enter));
        let found = crossings(&winding, &ray);
        met += found.len();
        assert!(
            found.iter().map(|c| (c.t, c.primitive, c.enter)).eq(truth),
            "{ray:?}"
        );
    }
    assert!(met > 3000, "{met}");
}

#[test]
fn rays_through_tattered_meshes_enter_and_leave_in_turn() {
    let mut rng = Pcg64Mcg::seed_from_u64(6);
    let (mut walls, mut holes, mut started) = (0, 0, 0);
    for mesh in [bumpy_sphere(20), torus_mesh(30, 12, 1.0, 0.4), slivers(15)] {
        let mesh = tattered(mesh, &mut rng);
        let winding = build(&mesh);
        let bounds = mesh.bounds();
        for i in 0..700 {
            let origin = bounds.center() + bounds.size() * 1.5 * direction(&mut rng);
            let [a, b, _] = mesh.corners(rng.random_range(0..mesh.triangles.len() as u32));
            let to = a
                .lerp(b, if i % 2 == 0 { 0.0 } else { rng.random() })
                .as_dvec3();
            let ray = Ray::new(origin, to - origin);
            let found = crossings(&winding, &ray);
            for (i, crossing) in found.iter().enumerate() {
                assert_eq!(crossing.enter, i % 2 == 0, "{ray:?}: {found:?}");
                assert!(i == 0 || crossing.t > found[i - 1].t, "{ray:?}: {found:?}");
                let place = if crossing.primitive.is_some() {
                    &mut walls
                } else {
                    &mut holes
                };
                *place += 1;
            }
            assert_eq!(found.len() % 2, 0);
            let inner = Ray {
                tmin: rng.random_range(0.5..1.5),
                ..ray
            };
            let rest = crossings(&winding, &inner);
            if let Some(last) = rest.last() {
                assert!(!last.enter && rest.windows(2).all(|pair| pair[0].enter != pair[1].enter));
                started += usize::from(!rest[0].enter);
                assert_eq!(!rest[0].enter, winding.contains(inner.at(inner.tmin)));
            }
        }
    }
    assert!(
        walls > 1000 && holes > 300 && started > 100,
        "{walls} {holes} {started}"
    );
}

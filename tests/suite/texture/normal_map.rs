//! Normal maps in the tangent space of the surface coordinates.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};

use solidtrace::geometry::{Csg, CsgOp, Mesh, Operand, Shape, Solid};
use solidtrace::material::Relief;
use solidtrace::math::{Ray, Transform};
use solidtrace::texture::Texture;
use solidtrace::world::World;

use super::relief::{surfaces, with_relief};
use crate::support::meshes::sphere_mesh;
use crate::support::{Build, empty_scene};

/// Towards growing u, growing v and outward.
const MAPPED: DVec3 = DVec3::new(0.48, 0.36, 0.8);

fn map() -> Relief {
    let texel = 0.5 * MAPPED + 0.5;
    Relief::NormalMap {
        texture: Texture::Constant(texel.as_vec3()),
        scale: 1.0,
    }
}

fn mapped(tangent: DVec3, bitangent: DVec3, n: DVec3) -> DVec3 {
    MAPPED.x * tangent + MAPPED.y * bitangent + MAPPED.z * n
}

fn assert_near(found: Vec3, expected: DVec3, tolerance: f64) {
    let found = found.as_dvec3();
    assert!(
        (found - expected).length() < tolerance,
        "{found} for {expected}"
    );
}

/// A mesh under a normal map.
fn world(mesh: Mesh, relief: Relief) -> World {
    let mut scene = empty_scene();
    let material = with_relief(&mut scene, relief);
    scene.mesh(mesh, material);
    scene.world()
}

/// The shading normal that a ray along -z meets at (x, y).
fn normal_at(world: &World, x: f64, y: f64) -> Vec3 {
    let ray = Ray::new(DVec3::new(x, y, 5.0), DVec3::NEG_Z);
    world.surface(&ray, &world.intersect(&ray).unwrap()).ns
}

/// The square from (-1, -1) to (1, 1) in the plane z = 0, facing up, with surface coordinates by position.
fn square(uv: impl Fn(Vec2) -> Vec2, smooth: bool) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(Vec2::from);
    Mesh {
        positions: corners.map(|p| p.extend(0.0)).to_vec(),
        normals: if smooth { vec![Vec3::Z; 4] } else { Vec::new() },
        uvs: corners.map(uv).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        slots: Vec::new(),
    }
}

#[test]
fn a_constant_texel_is_turned_by_the_surface_coordinates() {
    let turn = |degrees: f32| move |p: Vec2| Vec2::from_angle(degrees.to_radians()).rotate(3.0 * p);
    for smooth in [false, true] {
        // Turned coordinates: u grows along the turn back.
        for degrees in [0.0_f32, 90.0, 200.0] {
            let world = world(square(turn(degrees), smooth), map());
            let back = DQuat::from_rotation_z(-f64::from(degrees).to_radians());
            let expected = mapped(back * DVec3::X, back * DVec3::Y, DVec3::Z);
            for (x, y) in [(0.5, -0.3), (-0.5, 0.3)] {
                assert_near(normal_at(&world, x, y), expected, 1e-5);
            }
        }
        // Mirrored ones, in which the picture is seen from behind: v grows the other way round.
        let world = world(square(|p| Vec2::new(-p.x, p.y), smooth), map());
        let expected = mapped(DVec3::NEG_X, DVec3::Y, DVec3::Z);
        assert_near(normal_at(&world, 0.5, -0.3), expected, 1e-5);
    }
}

#[test]
fn halves_that_mirror_each_other_keep_their_own_sides_where_they_meet() {
    // u = |x|: one picture for both halves, which share the corners in the middle; the left half is the larger part of
    // the angle there.
    let corners: Vec<Vec2> = [(-1.0, 3.0), (0.0, 1.0), (1.0, 1.0)]
        .into_iter()
        .flat_map(|(x, y)| [Vec2::new(x, -y), Vec2::new(x, y)])
        .collect();
    let mesh = Mesh {
        positions: corners.iter().map(|p| p.extend(0.0)).collect(),
        normals: vec![Vec3::Z; 6],
        uvs: corners.iter().map(|p| Vec2::new(p.x.abs(), p.y)).collect(),
        triangles: vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
        slots: Vec::new(),
    };
    let world = world(mesh, map());
    for (x, y) in [(0.01, 0.2), (0.6, -0.5), (0.99, 0.9)] {
        let right = mapped(DVec3::X, DVec3::Y, DVec3::Z);
        assert_near(normal_at(&world, x, y), right, 1e-5);
        let left = mapped(DVec3::NEG_X, DVec3::Y, DVec3::Z);
        assert_near(normal_at(&world, -x, y), left, 1e-5);
    }
}

#[test]
fn a_maps_scale_multiplies_its_slope() {
    let Relief::NormalMap { texture, .. } = map() else {
        unreachable!()
    };
    let scale = 0.5;
    let world = world(square(|p| p, true), Relief::NormalMap { texture, scale });
    let expected = MAPPED * DVec3::new(scale, scale, 1.0);
    assert_near(normal_at(&world, 0.1, 0.4), expected.normalize(), 1e-5);
}

#[test]
fn on_spheres_east_and_north_are_those_of_the_globe() {
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 2.0, -0.5),
        DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0),
        DVec3::new(3.0, -1.0, 2.0),
    );
    let globe = |p: DVec3| {
        let n = p.normalize();
        let east = DVec3::Z.cross(n).normalize();
        mapped(east, n.cross(east), n)
    };
    for place in [DAffine3::IDENTITY, place] {
        let mut scene = empty_scene();
        let material = with_relief(&mut scene, map());
        scene.place(Shape::Solid(Solid::Sphere { radius: 1.2 }), material, place);
        let transform = Transform::new(place).unwrap();
        let world = scene.world();
        // Among them one on the date line, where u ends and begins.
        let from = place.transform_point3(5.0 * DVec3::X);
        let ray = Ray::new(from, place.translation - from);
        let date_line = world.surface(&ray, &world.intersect(&ray).unwrap());
        assert!(date_line.texture.p.y.abs() < 1e-9);
        for point in surfaces(&world, place).into_iter().chain([date_line]) {
            let expected = transform.normal(globe(point.texture.p));
            assert_near(point.ns, expected, 1e-5);
        }
    }

    // A mesh of the same, except near its poles and its date line.
    let mut mesh = sphere_mesh(90, |_| 1.0);
    mesh.normals = mesh.positions.clone();
    let uv = |p: &Vec3| Vec2::new(p.y.atan2(p.x), p.z.asin());
    mesh.uvs = mesh.positions.iter().map(uv).collect();
    let mut seen = 0;
    for point in surfaces(&world(mesh, map()), DAffine3::IDENTITY) {
        let p = point.p;
        if p.z.abs() < 0.9 && (p.x > 0.0 || p.y.abs() > 0.2) {
            seen += 1;
            assert_near(point.ns, globe(p), 2e-3);
        }
    }
    assert!(seen > 100);
}

#[test]
fn in_a_pit_the_map_lies_as_on_the_solid_that_was_cut_out() {
    let mut csg = Csg::default();
    let half = DVec3::splat(1.0);
    csg.push(
        Operand::Solid(Solid::Box { half }),
        &Transform::IDENTITY,
        0..1,
    );
    let center = DVec3::new(0.2, -0.1, 1.0);
    let turned = DQuat::from_rotation_x(0.8);
    let place = Transform::new(DAffine3::from_rotation_translation(turned, center)).unwrap();
    csg.push(Operand::Solid(Solid::Sphere { radius: 0.8 }), &place, 0..1);
    csg.combine(CsgOp::Difference, 2);
    let mut scene = empty_scene();
    let material = with_relief(&mut scene, map());
    scene.csg(csg, &[material], DAffine3::IDENTITY);
    let mut inside = 0;
    for point in surfaces(&scene.world(), DAffine3::IDENTITY) {
        let outward = point.p - center;
        if (outward.length() - 0.8).abs() < 1e-9 {
            inside += 1;
            let outward = outward.normalize();
            let east = (turned * DVec3::Z).cross(outward).normalize();
            let expected = mapped(east, outward.cross(east), -outward);
            assert_near(point.ns, expected, 1e-5);
        }
    }
    assert!(inside > 20, "{inside}");
}

#[test]
fn without_surface_coordinates_to_go_by_a_map_leaves_the_normal() {
    let world = world(square(|_| Vec2::splat(0.3), true), map());
    assert_eq!(normal_at(&world, 0.3, 0.2), Vec3::Z);
}

//! A model without a scene around it is stood up, framed and lit.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use solidtrace::camera::{Camera, Projection};
use solidtrace::geometry::{Mesh, Shape, Solid};
use solidtrace::io::bare_scene;
use solidtrace::light::{Light, PointLight};
use solidtrace::math::Transform;
use solidtrace::scene::{Instance, Model, Part, Scene};

use crate::support::meshes::box_mesh;

/// A box of `size` whose lowest corner is `min`, as a mesh.
fn block(min: [f32; 3], size: [f32; 3]) -> Mesh {
    box_mesh(min.into(), Vec3::from(min) + Vec3::from(size))
}

fn model(mesh: Mesh) -> Model {
    Model {
        meshes: vec![mesh],
        parts: vec![Part {
            name: None,
            mesh: 0,
            materials: vec![None],
            model_from_mesh: Transform::IDENTITY,
        }],
        ..Model::default()
    }
}

fn shapes() -> Vec<Mesh> {
    vec![
        block([-1.0, 0.0, -1.0], [2.0, 2.0, 2.0]),
        block([3.0, -7.0, 9.0], [1.0, 8.0, 1.0]),
        block([-50.0, 2.0, -1.0], [100.0, 1.0, 2.0]),
        block([0.0, 0.0, -40.0], [1.0, 1.0, 80.0]),
        block([1e4, 1e4, 1e4], [1.0, 2.0, 3.0]),
    ]
}

/// Picture coordinates of `p`, -1..=1 from edge to edge, and its depth.
fn project(scene: &Scene, p: DVec3) -> (f64, f64, f64) {
    let camera = &scene.cameras[0];
    let forward = (camera.look_at - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let v = p - camera.eye;
    let depth = v.dot(forward);
    let half = depth * (0.5 * camera.projection.field().unwrap()).tan();
    let aspect = f64::from(scene.film.size.0) / f64::from(scene.film.size.1);
    (v.dot(right) / (half * aspect), v.dot(up) / half, depth)
}

fn corners(scene: &Scene) -> Vec<DVec3> {
    let instance = &scene.instances[0];
    let positions = scene.meshes[0].positions.iter();
    positions
        .map(|p| instance.world_from_object.point(p.as_dvec3()))
        .collect()
}

fn lamps(scene: &Scene) -> Vec<(&Instance, f64)> {
    let sphere = |i: usize| match scene.instances[i].shape {
        Shape::Solid(Solid::Sphere { radius }) => Some((&scene.instances[i], radius)),
        _ => None,
    };
    (0..scene.instances.len()).filter_map(sphere).collect()
}

#[test]
fn a_framed_model_fills_the_picture_up_to_the_margin() {
    for mesh in shapes() {
        let scene = bare_scene(model(mesh), false).unwrap();
        let seen: Vec<_> = corners(&scene)
            .into_iter()
            .map(|p| project(&scene, p))
            .collect();
        assert!(seen.iter().all(|s| s.2 > 0.0));
        let edge = |f: fn(&(f64, f64, f64)) -> f64| seen.iter().map(f).fold(f64::MIN, f64::max);
        let (right, left) = (edge(|s| s.0), edge(|s| -s.0));
        let (top, bottom) = (edge(|s| s.1), edge(|s| -s.1));
        let ((less, more), other) = if right.max(left) > top.max(bottom) {
            ((left, right), top.max(bottom))
        } else {
            ((bottom, top), right.max(left))
        };
        assert!((less - 0.92).abs() < 1e-6 && (more - 0.92).abs() < 1e-6);
        assert!(other < 0.92);
    }
}

#[test]
fn the_camera_stands_front_right_and_above() {
    let scene = bare_scene(model(shapes().remove(0)), false).unwrap();
    let camera = &scene.cameras[0];
    let from = (camera.eye - camera.look_at).normalize();
    assert!((from.x.atan2(from.z).to_degrees() - 30.0).abs() < 1e-9);
    assert!(from.y > 0.2 && from.y < 0.4);
}

#[test]
fn a_tall_model_gets_a_tall_picture() {
    let sizes: Vec<_> = shapes()
        .into_iter()
        .map(|m| bare_scene(model(m), false).unwrap().film.size)
        .collect();
    assert_eq!(sizes[0], (1280, 720));
    assert_eq!(sizes[1], (720, 1280));
    assert_eq!(sizes[2], (1280, 720));
}

#[test]
fn the_studio_scales_with_the_model() {
    let scaled = |factor: f32| {
        let mesh = block([0.0; 3], [factor, 2.0 * factor, factor]);
        bare_scene(model(mesh), false).unwrap()
    };
    let one = scaled(1.0);
    for factor in [1.0 / 1024.0, 1024.0] {
        let other = scaled(factor);
        let factor = f64::from(factor);
        assert!((other.cameras[0].eye / factor - one.cameras[0].eye).length() < 1e-9);
        assert_eq!(other.materials, one.materials);
        assert_eq!(other.environment, one.environment);
        for ((a, ra), (b, rb)) in lamps(&other).into_iter().zip(lamps(&one)) {
            assert!((ra / factor - rb).abs() < 1e-9);
            let centers = [a, b].map(|i| i.world_from_object.point(DVec3::ZERO));
            assert!((centers[0] / factor - centers[1]).length() < 1e-9);
        }
    }
}

#[test]
fn no_lamp_shows_in_the_picture_or_touches_the_model() {
    for mesh in shapes() {
        let scene = bare_scene(model(mesh), false).unwrap();
        assert_eq!(lamps(&scene).len(), 3);
        // Nor while a turntable turns.
        let views = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|i| {
            let camera = scene.cameras[0].turned(f64::from(i) * TAU / 9.0);
            let film = scene.film.clone();
            Scene {
                film,
                cameras: vec![camera],
                ..Scene::default()
            }
        });
        for (lamp, radius) in lamps(&scene) {
            for i in 0..40 {
                for j in 0..80 {
                    let (theta, phi) = (f64::from(i) * 0.0786, f64::from(j) * 0.0786);
                    let n = DVec3::new(
                        theta.sin() * phi.cos(),
                        theta.cos(),
                        theta.sin() * phi.sin(),
                    );
                    let p = lamp.world_from_object.point(radius * n);
                    for view in &views {
                        let (x, y, depth) = project(view, p);
                        assert!(
                            depth < 0.0 || x.abs() > 1.0 || y.abs() > 1.0,
                            "lamp at {x}, {y}"
                        );
                    }
                }
            }
            let center = lamp.world_from_object.point(DVec3::ZERO);
            assert!(
                corners(&scene)
                    .iter()
                    .all(|p| p.distance(center) > 1.5 * radius)
            );
        }
    }
}

#[test]
fn the_floor_is_level_and_just_under_the_model() {
    let scene = bare_scene(model(shapes().remove(1)), false).unwrap();
    let floor = (scene.instances.iter())
        .find(|i| i.shape == Shape::Solid(Solid::Plane))
        .unwrap();
    let (point, up) = (
        floor.world_from_object.point(DVec3::ZERO),
        floor.world_from_object.normal(DVec3::Z),
    );
    assert!((up - DVec3::Y).length() < 1e-12);
    assert!(point.y < -7.0 && point.y > -7.01, "{point}");
}

/// Which of the model's directions become the world's y and z.
fn up_and_front(mesh: Mesh) -> (DVec3, DVec3) {
    let scene = bare_scene(model(mesh), true).unwrap();
    let upright = scene.instances[0]
        .world_from_object
        .matrix()
        .matrix3
        .transpose();
    assert!((upright.determinant() - 1.0).abs() < 1e-12);
    (upright.y_axis, upright.z_axis)
}

#[test]
fn a_model_that_stands_on_the_xy_plane_is_stood_up() {
    let standing = block([-0.3, -0.2, -0.003], [0.6, 0.3, 1.7]);
    assert_eq!(up_and_front(standing), (DVec3::Z, DVec3::NEG_Y));
}

#[test]
fn the_side_with_more_triangles_is_the_front() {
    let mut figure = block([-0.3, -0.2, 0.0], [0.6, 0.3, 1.7]);
    let first = figure.positions.len() as u32;
    let face = [[0.0, 0.11, 1.5], [0.0, 0.11, 1.6], [0.1, 0.11, 1.5]];
    figure.positions.extend(face.map(Vec3::from));
    figure.triangles.extend([[first, first + 1, first + 2]; 4]);
    assert_eq!(up_and_front(figure.clone()), (DVec3::Z, DVec3::Y));
    for t in figure.triangles.iter_mut().skip(12) {
        t.swap(1, 2);
    }
    assert_eq!(up_and_front(figure), (DVec3::Z, DVec3::NEG_Y));
}

#[test]
fn other_models_stay_as_they_are() {
    let upright = (DVec3::Y, DVec3::Z);
    // On the ground and tallest along y; floating; low; standing on both planes.
    assert_eq!(
        up_and_front(block([-1.0, 0.0, -1.0], [2.0, 5.0, 2.0])),
        upright
    );
    assert_eq!(
        up_and_front(block([-1.0, -1.0, -3.0], [2.0, 2.0, 5.0])),
        upright
    );
    assert_eq!(
        up_and_front(block([-1.0, -1.0, 0.0], [2.0, 2.0, 1.0])),
        upright
    );
    assert_eq!(
        up_and_front(block([0.0, 0.0, 0.0], [1.0, 1.0, 5.0])),
        upright
    );
    let z_up = block([-0.3, -0.2, 0.0], [0.6, 0.3, 1.7]);
    let scene = bare_scene(model(z_up), false).unwrap();
    assert!(scene.instances[0].world_from_object.is_identity());
}

#[test]
fn own_cameras_and_lights_are_kept() {
    let camera = Camera {
        name: Some("door".to_owned()),
        eye: DVec3::new(0.0, 1.0, 9.0),
        look_at: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::pinhole(0.5),
        motion: None,
    };
    let light = Light::Point(PointLight {
        position: DVec3::Y,
        intensity: Vec3::ONE,
        cone: None,
    });
    let mut own = model(shapes().remove(0));
    own.cameras = vec![camera.clone()];
    let scene = bare_scene(own.clone(), false).unwrap();
    assert_eq!(scene.cameras, [camera]);
    assert_eq!(lamps(&scene).len(), 3);
    assert!(
        scene
            .instances
            .iter()
            .all(|i| i.shape != Shape::Solid(Solid::Plane))
    );

    own.lights = vec![light.clone()];
    let scene = bare_scene(own, false).unwrap();
    assert_eq!(scene.lights, [light]);
    assert_eq!(scene.instances.len(), 1);
    assert_eq!(scene.environment, Vec3::ZERO);
}

#[test]
fn a_model_without_extent_is_an_error() {
    assert!(bare_scene(Model::default(), true).is_err());
    let point = Mesh {
        positions: vec![Vec3::ONE; 3],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let error = bare_scene(model(point), true).unwrap_err();
    assert!(error.message().contains("nothing to show"));
}

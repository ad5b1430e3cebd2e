//! Surfaces that emit by a texture.

use glam::{DVec3, Vec2};
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::geometry::{Mesh, Shape, Solid};
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::{Pattern, Ramp, Texture};

use crate::support::{Build, SAMPLERS, Shot, camera, diffuse, empty_scene, shoot, statistics};

/// A grey floor under a panel, seen from beside the panel.
fn lit_floor(radiance: f32, texture: Option<Texture>) -> Scene {
    let mut scene = empty_scene();
    let floor = scene.material(diffuse(0.5), 0.0);
    let lamp = scene.material(diffuse(0.0), radiance);
    scene.materials[lamp.0 as usize].emission_texture = texture;
    scene.solid(Solid::Plane, floor, DVec3::ZERO);
    let corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(Vec2::from);
    let panel = Mesh {
        positions: corners.map(|p| p.extend(1.5)).to_vec(),
        uvs: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    scene.mesh(panel, lamp);
    scene.cameras = vec![camera(DVec3::new(6.0, 0.0, 1.0), DVec3::new(0.5, 0.0, 0.0))];
    scene.cameras[0].up = DVec3::Z;
    scene.cameras[0].projection = Projection::pinhole(0.1);
    scene
}

#[test]
fn a_textured_lamp_sheds_the_light_of_its_texture() {
    let means: Vec<f64> = [
        lit_floor(2.0, None),
        lit_floor(8.0, Some(Texture::Constant(Rgb::splat(0.25)))),
    ]
    .into_iter()
    .map(|scene| {
        let world = scene.world();
        let shot = Shot {
            spp: 4096,
            sampler: SAMPLERS[0],
            seed: 1,
        };
        let pixels = shoot(&world, shot);
        let values: Vec<f64> = pixels.iter().map(|p| f64::from(p.x)).collect();
        statistics(&values).0
    })
    .collect();
    assert!(means[0] > 0.1);
    assert!((means[1] / means[0] - 1.0).abs() < 0.01, "{means:?}");
}

#[test]
fn the_camera_sees_the_texture_on_the_lamp() {
    let squares = Texture::Pattern {
        pattern: Pattern::Checker { step: 1.0 },
        colors: Ramp::between(Rgb::X, Rgb::Y),
    };
    for integrator in [
        IntegratorSettings::path(),
        IntegratorSettings::whitted(),
        IntegratorSettings::Flat,
    ] {
        let mut scene = empty_scene();
        scene.integrator = integrator;
        let lamp = scene.material(diffuse(0.0), 3.0);
        scene.materials[lamp.0 as usize].emission_texture = Some(squares.clone());
        let at = glam::DAffine3::from_translation(DVec3::new(0.0, 0.0, -4.0));
        let half = DVec3::splat(3.0);
        scene.place(Shape::Solid(Solid::Box { half }), lamp, at);
        let world = scene.world();
        let shot = Shot {
            spp: 4,
            sampler: SAMPLERS[1],
            seed: 0,
        };
        let pixels = shoot(&world, shot);
        let colors = [3.0 * Rgb::X, 3.0 * Rgb::Y];
        assert!(pixels.iter().any(|p| p.abs_diff_eq(colors[0], 1e-6)));
        assert!(pixels.iter().any(|p| p.abs_diff_eq(colors[1], 1e-6)));
        assert!(pixels.iter().all(|p| (p.element_sum() - 3.0).abs() < 1e-5));
    }
}

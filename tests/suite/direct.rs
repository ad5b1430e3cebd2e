//! The integrator for direct light against closed forms and against the path tracer.

use glam::{DVec3, Vec3};
use solidtrace::color::Rgb;
use solidtrace::geometry::Solid;
use solidtrace::material::{Fresnel, Surface};
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::Texture;

use crate::support::meshes::box_mesh;
use crate::support::{Build, SAMPLERS, Shot, dielectric, diffuse, empty_scene, shoot};

const DIRECT: IntegratorSettings = IntegratorSettings::Direct { max_depth: 20 };

fn pixels(scene: Scene, spp: u32) -> Vec<Rgb> {
    let sampler = SAMPLERS[0];
    shoot(
        &scene.world(),
        Shot {
            spp,
            sampler,
            seed: 2,
        },
    )
}

fn assert_all(scene: Scene, expected: f32, tolerance: f32, what: &str) {
    for pixel in pixels(scene, 256) {
        let error = (pixel - expected).abs().max_element();
        assert!(error <= tolerance, "{what}: {pixel}, not {expected}");
    }
}

fn mirror(color: f32) -> Surface {
    Surface::Mirror {
        color: Texture::Constant(Rgb::splat(color)),
    }
}

/// Inside of a room whose walls send out 2 and reflect half. Nothing aims at a box: there is no noise.
fn room() -> Scene {
    let mut scene = empty_scene();
    scene.integrator = DIRECT;
    let wall = scene.material(diffuse(0.5), 2.0);
    scene.solid(
        Solid::Box {
            half: DVec3::splat(5.0),
        },
        wall,
        DVec3::ZERO,
    );
    scene
}

#[test]
fn a_glowing_room_shows_what_its_walls_send_out_and_reflect_once() {
    assert_all(room(), 2.0 + 0.5 * 2.0, 1e-5, "room");
}

#[test]
fn mirrors_and_glass_pass_direct_light_on() {
    // They fill the picture and are too small to keep light from the walls.
    let ball = Solid::Sphere { radius: 1e-3 };
    let ahead = DVec3::new(0.0, 0.0, -2e-3);
    for (surface, expected) in [
        (mirror(0.5), 0.5 * 3.0),
        (dielectric(1.5, Fresnel::Exact), 3.0),
    ] {
        let mut scene = room();
        let material = scene.material(surface.clone(), 0.0);
        scene.solid(ball, material, ahead);
        assert_all(scene, expected, 1e-4, &format!("{surface:?}"));
    }
}

#[test]
fn a_path_over_mirrors_is_cut_where_the_limit_says() {
    for depth in [0, 1, 4] {
        let mut scene = empty_scene();
        scene.integrator = IntegratorSettings::Direct { max_depth: depth };
        let half = scene.material(mirror(0.5), 0.5);
        scene.solid(Solid::Box { half: DVec3::ONE }, half, DVec3::ZERO);
        let expected = 1.0 - 0.5_f32.powi(depth as i32 + 1);
        assert_all(scene, expected, 1e-5, &format!("depth {depth}"));
    }
}

#[test]
fn without_mirrors_it_is_the_path_tracer_with_one_bounce() {
    let scene = |integrator| {
        let mut scene = empty_scene();
        scene.environment = Rgb::new(0.1, 0.2, 0.3);
        scene.integrator = integrator;
        let white = scene.material(diffuse(0.7), 0.0);
        let lamp = scene.material(diffuse(0.2), 4.0);
        scene
            .solid(
                Solid::Sphere { radius: 1.0 },
                white,
                DVec3::new(0.0, 0.0, -4.0),
            )
            .solid(
                Solid::Sphere { radius: 0.5 },
                lamp,
                DVec3::new(1.5, 1.5, -3.0),
            )
            .mesh(
                box_mesh(Vec3::new(-2.0, 1.0, -4.0), Vec3::new(-1.0, 1.5, -3.0)),
                lamp,
            )
            .point_light(DVec3::new(-1.0, 3.0, 0.0), 5.0);
        scene
    };
    let path = |max_depth| IntegratorSettings::Path {
        max_depth,
        russian_roulette: false,
    };
    let direct = pixels(scene(DIRECT), 16);
    assert_eq!(direct, pixels(scene(path(Some(1))), 16));
    assert_ne!(
        direct,
        pixels(scene(path(None)), 16),
        "there is more light than that"
    );
}

#[test]
fn a_scene_file_names_it_and_its_limit() {
    let read = |integrator: &str| {
        let text = format!(
            "(camera: Perspective(eye: (0, 0, 1), look_at: (0, 0, 0), vfov: 45), objects: [], integrator: {integrator})"
        );
        let description = solidtrace::scene::SceneDescription::from_text("a.ron", &text);
        description.map(|description| description.integrator)
    };
    assert_eq!(
        read("Direct").unwrap(),
        IntegratorSettings::Direct { max_depth: 8 }
    );
    assert_eq!(
        read("Direct(max_depth: 3)").unwrap(),
        IntegratorSettings::Direct { max_depth: 3 }
    );
    let error = read("Direct(russian_roulette: true)").unwrap_err();
    assert!(error.to_string().contains("a.ron:1:"), "{error}");
    assert!(error.to_string().contains("russian_roulette"), "{error}");
}

//! The sun against closed forms.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use solidtrace::color::Rgb;
use solidtrace::geometry::{Mesh, Solid};
use solidtrace::light::{DistantLight, Light};
use solidtrace::material::Surface;
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::Texture;

use crate::agreement::{OneWay, assert_agreement, mixed};
use crate::lights::{assert_irradiance, floor};
use crate::support::{Build, Shot, camera, diffuse, empty_scene, shoot, shoot_with};

/// A sun of one colour `elevation` degrees above the horizon, `angle` degrees across.
fn sun(elevation: f64, irradiance: f32, angle: f64) -> Light {
    let (rise, level) = elevation.to_radians().sin_cos();
    Light::Distant(DistantLight {
        direction: DVec3::new(0.6 * level, rise, -0.8 * level),
        irradiance: Rgb::splat(irradiance),
        angle: angle.to_radians(),
    })
}

#[test]
fn irradiance_under_the_sun_is_its_own_times_the_sine_of_its_height() {
    for (elevation, angle) in [
        (90.0, 0.0),
        (20.0, 0.0),
        (35.0, 0.53),
        (90.0, 170.0),
        (50.0, 60.0),
    ] {
        let mut scene = floor(1.0);
        scene.lights = vec![sun(elevation, 3.0, angle)];
        let expected = 3.0 * elevation.to_radians().sin();
        assert_irradiance(
            scene,
            expected,
            &format!("{elevation} degrees, {angle} across"),
        );
    }
}

#[test]
fn the_whitted_integrator_shows_every_sun() {
    for angle in [0.0, 0.53] {
        let mut scene = floor(1.0);
        scene.integrator = IntegratorSettings::whitted();
        scene.lights = vec![sun(90.0, 3.0, angle), sun(30.0, 2.0, angle)];
        assert_irradiance(scene, 4.0, &format!("{angle} degrees across"));
    }
}

/// What is free of a disk whose middle is `s` radii above a straight edge.
fn share_of_disk(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    1.0 - (s.acos() - s * (1.0 - s * s).sqrt()) / PI
}

#[test]
fn the_penumbra_of_an_edge_is_its_height_times_the_suns_angle_wide() {
    let (height, angle) = (2.0, 4_f64);
    let radius = height * (0.5 * angle.to_radians()).tan();
    for s in [-1.02, -0.6, 0.0, 0.3, 0.9, 1.02] {
        let mut scene = floor(s * radius);
        scene.lights = vec![sun(90.0, 1.0, angle)];
        // A roof over everything at x < 0.
        let black = scene.material(diffuse(0.0), 0.0);
        let corner = |x: f32, z: f32| Vec3::new(x, height as f32, z);
        let roof = Mesh {
            positions: vec![
                corner(-9.0, -9.0),
                corner(0.0, -9.0),
                corner(0.0, 9.0),
                corner(-9.0, 9.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        scene.mesh(roof, black);
        let shot = Shot {
            spp: 1 << 13,
            sampler: SamplerKind::Sobol,
            seed: 3,
        };
        let shown = f64::from(shoot(&scene.world(), shot)[0].x) * PI;
        let expected = share_of_disk(s);
        assert!(
            (shown - expected).abs() < 0.004,
            "at {s} radii: {shown}, not {expected}"
        );
        if s.abs() > 1.0 {
            assert!((shown - expected).abs() < 1e-3, "at {s} radii: {shown}");
        }
    }
}

#[test]
fn a_mirror_and_the_camera_show_the_sun_as_a_disk_of_its_radiance() {
    let mirror = |scene: &mut Scene| {
        let white = Texture::Constant(Rgb::ONE);
        scene.material(Surface::Mirror { color: white }, 0.0)
    };
    let angle = 10_f64;
    let radiance = 3.0 / (PI * (0.5 * angle).to_radians().sin().powi(2)) as f32;
    for (off_axis, expected) in [(0.0, radiance), (4.9, radiance), (5.1, 0.0)] {
        let to_sun = DVec3::Y;
        let (x, y) = f64::to_radians(off_axis).sin_cos();
        for reflected in [false, true] {
            let mut scene = empty_scene();
            scene.film.size = (1, 1);
            scene.lights = vec![sun(90.0, 3.0, angle)];
            let aim = if reflected {
                DVec3::new(x, -y, 0.0)
            } else {
                DVec3::new(x, y, 0.0)
            };
            scene.cameras = vec![camera(to_sun * 3.0, to_sun * 3.0 + aim)];
            scene.cameras[0].up = DVec3::Z;
            scene.cameras[0].projection = solidtrace::camera::Projection::pinhole(1e-6);
            let shiny = mirror(&mut scene);
            let half = DVec3::new(9.0, 1.0, 9.0);
            scene.solid(Solid::Box { half }, shiny, DVec3::NEG_Y);
            let world = scene.world();
            let shot = Shot {
                spp: 4,
                sampler: SamplerKind::Sobol,
                seed: 0,
            };
            let whitted = solidtrace::integrator::integrator(&IntegratorSettings::whitted());
            for shown in [
                shoot(&world, shot)[0].x,
                shoot_with(&world, whitted.as_ref(), shot)[0].x,
            ] {
                assert!(
                    (shown - expected).abs() <= 1e-5 * radiance,
                    "{off_axis} off: {shown}"
                );
            }
        }
    }
}

#[test]
fn aiming_at_a_wide_sun_agrees_with_paths_that_find_it_by_themselves() {
    let mut scene = mixed();
    scene.lights = vec![sun(40.0, 2.0, 50.0)];
    assert_agreement(scene);
    // Alone, so that nothing else hides an error.
    let mut scene = floor(0.5);
    scene.lights = vec![sun(60.0, 2.0, 50.0)];
    let shot = Shot {
        spp: 1 << 15,
        sampler: SamplerKind::Sobol,
        seed: 1,
    };
    let shown = shoot_with(&scene.world(), &OneWay::Bsdf, shot)[0].x * std::f32::consts::PI;
    assert!(
        (shown / (2.0 * 60_f32.to_radians().sin()) - 1.0).abs() < 0.01,
        "{shown}"
    );
}

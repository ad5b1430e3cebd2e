//! Light from pictures against closed forms, by each strategy alone and by both together.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use solidtrace::color::Rgb;
use solidtrace::geometry::Solid;
use solidtrace::integrator::{FeatureIntegrator, Integrator, integrator};
use solidtrace::light::EnvironmentMap;
use solidtrace::material::{Principled, Surface};
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::IntegratorSettings;
use solidtrace::texture::{Bitmap, Texture};

use crate::agreement::{OneWay, assert_agreement, mixed};
use crate::lights::floor;
use crate::support::{Build, Shot, camera, diffuse, empty_scene, shoot, shoot_with};

use super::{LightOnly, environment, irradiance, picture};

/// What a picture sheds on a level floor by light sampling, by surfaces that find it, and by both.
fn assert_irradiance(bitmap: &Bitmap, expected: f64, what: &str) {
    let scene = || {
        let mut scene = floor(0.0);
        scene.lights = vec![environment(bitmap.clone())];
        scene
    };
    let path = integrator(&scene().integrator);
    // Light sampling alone finds what there is where nothing but what it aims at is bright.
    if bitmap.pixels.iter().any(|p| p.x == 0.0) {
        let found = irradiance(scene(), &LightOnly, 1 << 14) / expected;
        assert!(
            (found - 1.0).abs() < 0.005,
            "{what}, lights: {found} of the closed form"
        );
    }
    for (name, integrator, spp, tolerance) in [
        ("surfaces", &OneWay::Bsdf as &dyn Integrator, 1 << 16, 0.015),
        ("both", path.as_ref(), 1 << 14, 0.005),
    ] {
        let found = irradiance(scene(), integrator, spp) / expected;
        assert!(
            (found - 1.0).abs() < tolerance,
            "{what}, {name}: {found} of the closed form"
        );
    }
}

/// On a level floor, of a pixel of radiance 1: interpolation makes it a tent, whose integral with sin cos is that of their
/// Fourier transform. The tent must not reach the zenith nor the horizon.
fn irradiance_of_pixel(width: usize, height: usize, row: usize) -> f64 {
    let (across, down) = (TAU / width as f64, PI / height as f64);
    let theta = (row as f64 + 0.5) * down;
    across * 0.5 * (2.0 * theta).sin() * down.sin().powi(2) / down
}

#[test]
fn irradiance_under_an_even_picture_is_pi() {
    assert_irradiance(&picture(16, 8, |_, _| 1.0), PI, "white");
    // A picture of one pixel is one as well.
    assert_irradiance(&picture(1, 1, |_, _| 2.0), TAU, "one pixel");
}

#[test]
fn irradiance_under_half_a_sky_is_half_of_pi() {
    for first in 0..3 {
        let half = |x: usize, _| f32::from(u8::from((x + 16 - first) % 16 < 8));
        assert_irradiance(
            &picture(16, 8, half),
            0.5 * PI,
            &format!("half from {first}"),
        );
    }
    // The horizon is a slope from the last white row to the first black one, so a floor sees half a row less: what is left of
    // 1 from theta to the horizon is the integral of cos² over that.
    let upper = picture(16, 8, |_, y| f32::from(u8::from(y < 4)));
    let row = PI / 8.0;
    // The slope: 1 down to 1/2 over the half row above the horizon.
    let expected = PI - TAU * slope(0.5 * row, row);
    assert_irradiance(&upper, expected, "upper half");
}

/// The integral of `x / row` sin(theta) cos(theta) from `width` above the horizon to it, with x from 0 to `width`.
fn slope(width: f64, row: f64) -> f64 {
    // With e = width - x the height above the horizon: sin cos = sin(2 e) / 2.
    let n = 10_000;
    let step = width / f64::from(n);
    let at = |i: u32| {
        let e = (f64::from(i) + 0.5) * step;
        (width - e) / row * 0.5 * (2.0 * e).sin()
    };
    (0..n).map(at).sum::<f64>() * step
}

#[test]
fn irradiance_of_a_bright_pixel_is_that_of_its_tent() {
    for (x, y) in [(0, 1), (15, 2), (7, 1), (8, 2)] {
        let bitmap = picture(16, 8, |i, j| if (i, j) == (x, y) { 5.0 } else { 0.0 });
        assert_irradiance(
            &bitmap,
            5.0 * irradiance_of_pixel(16, 8, y),
            &format!("({x}, {y})"),
        );
        // On even light the sum is what both shed.
        let bitmap = picture(16, 8, |i, j| if (i, j) == (x, y) { 11.0 } else { 1.0 });
        let expected = PI + 10.0 * irradiance_of_pixel(16, 8, y);
        assert_irradiance(&bitmap, expected, &format!("({x}, {y}) on white"));
    }
}

#[test]
fn a_bright_pixel_makes_no_noise_on_a_floor_that_sees_it_whole() {
    let mut scene = floor(0.0);
    scene.lights = vec![environment(picture(256, 128, |i, j| {
        if (i, j) == (40, 30) { 1e4 } else { 0.0 }
    }))];
    let shot = Shot {
        spp: 1,
        sampler: SamplerKind::Independent,
        seed: 5,
    };
    let shown = shoot_with(&scene.world(), &LightOnly, shot);
    let expected = 1e4 * irradiance_of_pixel(256, 128, 30) / PI;
    for pixel in shown {
        // A single sample: what varies is the cosine and the sine over two pixels.
        assert!(
            (f64::from(pixel.x) / expected - 1.0).abs() < 0.06,
            "{pixel} of {expected}"
        );
    }
}

#[test]
fn aiming_at_a_picture_agrees_with_paths_that_find_it_by_themselves() {
    let bitmap = picture(16, 8, |x, y| {
        if (x, y) == (3, 1) {
            20.0
        } else {
            0.1 * ((x * y) % 5) as f32
        }
    });
    let mut scene = mixed();
    scene.lights = vec![environment(bitmap)];
    assert_agreement(scene);
}

#[test]
fn white_things_vanish_in_a_white_picture_as_they_do_in_a_white_environment() {
    let metal = Principled {
        metallic: 1.0.into(),
        roughness: 0.6.into(),
        ..Principled::new(Texture::Constant(Rgb::ONE))
    };
    for (name, surface) in [
        ("diffuse", diffuse(1.0)),
        ("glass", Surface::glass(1.5)),
        ("rough metal", Surface::Principled(Box::new(metal))),
    ] {
        let mut scene = empty_scene();
        scene.lights = vec![environment(picture(8, 4, |_, _| 1.0))];
        scene.cameras = vec![camera(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO)];
        let material = scene.material(surface, 0.0);
        scene.solid(
            Solid::Torus {
                major: 0.8,
                minor: 0.3,
            },
            material,
            DVec3::ZERO,
        );
        let shot = Shot {
            spp: 4096,
            sampler: SamplerKind::Sobol,
            seed: 2,
        };
        for pixel in shoot(&scene.world(), shot) {
            assert!((pixel - 1.0).abs().max_element() < 0.02, "{name}: {pixel}");
        }
    }
}

#[test]
fn a_picture_is_turned_about_y_as_objects_are() {
    let bitmap = picture(16, 8, |x, y| (1 + (7 * x + 3 * y) % 11) as f32);
    let still = EnvironmentMap::new(bitmap.clone(), 0.0);
    for degrees in [-400.0, 30.0, 90.0, 200.0] {
        let angle = f64::to_radians(degrees);
        let turned = EnvironmentMap::new(bitmap.clone(), angle);
        for i in 1..50 {
            let (polar, azimuth) = (0.06 * f64::from(i), 0.7 * f64::from(i));
            let direction = DVec3::new(
                polar.sin() * azimuth.cos(),
                polar.cos(),
                polar.sin() * azimuth.sin(),
            );
            let (a, pdf_a) = still.beyond(direction);
            let (b, pdf_b) = turned.beyond(DQuat::from_rotation_y(angle) * direction);
            assert!(
                (a - b).abs().max_element() < 1e-3,
                "{degrees}, {direction}: {a}, {b}"
            );
            assert!(
                (pdf_a / pdf_b - 1.0).abs() < 1e-3,
                "{degrees}, {direction}: {pdf_a}, {pdf_b}"
            );
        }
    }
}

#[test]
fn every_integrator_that_shows_colours_shows_the_picture_behind_the_scene() {
    let mut scene = empty_scene();
    // The camera looks along -z, where the middle column is.
    scene.lights = vec![environment(picture(64, 32, |x, _| {
        if (24..40).contains(&x) { 3.0 } else { 0.0 }
    }))];
    scene.cameras[0].projection = solidtrace::camera::Projection::pinhole(0.2);
    let world = scene.world();
    let shot = Shot {
        spp: 1,
        sampler: SamplerKind::Sobol,
        seed: 0,
    };
    let whitted = integrator(&IntegratorSettings::whitted());
    for pixels in [
        shoot(&world, shot),
        shoot_with(&world, whitted.as_ref(), shot),
        shoot_with(&world, &FeatureIntegrator::Flat, shot),
    ] {
        assert!(
            pixels.iter().all(|p| (p - 3.0).abs().max_element() < 1e-5),
            "{pixels:?}"
        );
    }
}

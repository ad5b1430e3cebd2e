//! Spot lights: how they fall off, and how much they shed in all.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2};
use solidtrace::color::Rgb;
use solidtrace::light::{Cone, Light, PointLight};

fn spot(inner: f64, outer: f64) -> Light {
    let axis = DVec3::new(2.0, -1.0, 0.5).normalize();
    Light::Point(PointLight {
        position: DVec3::new(1.0, 2.0, 3.0),
        intensity: Rgb::new(3.0, 2.0, 1.0),
        cone: Some(Cone::new(
            axis,
            f64::to_radians(inner),
            f64::to_radians(outer),
        )),
    })
}

/// The intensity at an angle from the axis, seen from a distance of 2.
fn red_at(light: &Light, degrees: f64) -> f64 {
    let axis = DVec3::new(2.0, -1.0, 0.5).normalize();
    let (sin, cos) = degrees.to_radians().sin_cos();
    let w = cos * axis + sin * axis.any_orthonormal_vector();
    let sample = light.sample(DVec3::new(1.0, 2.0, 3.0) + 2.0 * w, Vec2::ZERO);
    sample.map_or(0.0, |sample| {
        assert!(sample.pdf.is_infinite());
        4.0 * f64::from(sample.li.x)
    })
}

#[test]
fn a_spot_falls_off_as_khr_lights_punctual_recommends() {
    // Section "Inner and Outer Cone Angles" of the extension: saturate(cos * scale + offset) squared.
    for (inner, outer) in [(0.0, 45.0), (20.0, 30.0), (0.0, 90.0)] {
        let light = spot(inner, outer);
        let [cos_inner, cos_outer] = [inner, outer].map(|d| f64::to_radians(d).cos());
        let scale = 1.0 / f64::max(0.001, cos_inner - cos_outer);
        let offset = -cos_outer * scale;
        for degrees in [0.0, 10.0, 19.9, 25.0, 29.0, 44.0, 60.0, 89.0, 120.0, 180.0] {
            let cos = f64::to_radians(degrees).cos();
            let expected = 3.0 * (cos * scale + offset).clamp(0.0, 1.0).powi(2);
            let found = red_at(&light, degrees);
            assert!(
                (found - expected).abs() < 1e-6,
                "{degrees} of {inner} to {outer}: {found} for {expected}"
            );
        }
    }
    // Without a penumbra it ends at once.
    let hard = spot(30.0, 30.0);
    assert_eq!([red_at(&hard, 29.999), red_at(&hard, 30.001)], [3.0, 0.0]);
}

#[test]
fn a_spots_power_is_the_integral_of_its_intensity() {
    for (inner, outer) in [(0.0, 45.0), (20.0, 30.0), (30.0, 30.0), (60.0, 180.0)] {
        let light = spot(inner, outer);
        let n = 20_000;
        let sum: f64 = (0..n)
            .map(|i| {
                let theta = PI * (f64::from(i) + 0.5) / f64::from(n);
                TAU * theta.sin() * red_at(&light, theta.to_degrees()) * PI / f64::from(n)
            })
            .sum();
        let power = light.power();
        // Red is half of all.
        assert!((2.0 * sum / power - 1.0).abs() < 5e-4, "{sum} of {power}");
    }
}

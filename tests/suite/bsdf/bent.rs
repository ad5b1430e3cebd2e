//! Shading normals that are not the surface's.

use glam::{Vec2, Vec3};
use solidtrace::color::Rgb;
use solidtrace::material::Surface;
use solidtrace::sampling::{Sampler, uniform_sphere};
use solidtrace::texture::Texture;

use super::{NG, bsdf};
use crate::support::{SAMPLERS, diffuse};

/// Shading normals up to 80 degrees from the geometric one.
fn bent_normals() -> impl Iterator<Item = Vec3> {
    [0.0_f32, 20.0, 50.0, 80.0].into_iter().map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(0.6 * sin, 0.8 * sin, cos)
    })
}

/// Directions spread evenly over the sphere by a lattice, each for the same solid angle.
fn sphere(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let u = (f64::from(i) + 0.5) / f64::from(count);
        let v = (f64::from(i) * 0.618_033_988_749_894_9).fract();
        uniform_sphere(Vec2::new(u as f32, v as f32))
    })
}

#[test]
fn a_density_integrates_to_one_over_its_side_however_the_normal_is_bent() {
    for ns in bent_normals() {
        for side in [1.0, -1.0] {
            let bsdf = bsdf(&diffuse(0.5), ns, side);
            let count = 200_000;
            let mut sum = 0.0;
            for wi in sphere(count) {
                let (f_cos, pdf) = bsdf.eval(Vec3::Z, wi);
                assert!((f_cos - 0.5 * pdf).abs().max_element() <= 1e-6);
                assert!(
                    pdf == 0.0 || side * wi.dot(NG) > 0.0,
                    "light through the surface"
                );
                sum += f64::from(pdf);
            }
            let integral = sum * 4.0 * std::f64::consts::PI / f64::from(count);
            assert!((integral - 1.0).abs() < 1e-3, "{ns} {side}: {integral}");
        }
    }
}

#[test]
fn directions_come_with_the_density_that_is_said() {
    // Averages of smooth functions of the direction, drawn and integrated.
    for ns in bent_normals() {
        let bsdf = bsdf(&diffuse(0.5), ns, 1.0);
        let functions: [fn(Vec3) -> f32; 4] =
            [|w| w.x, |w| w.y, |w| w.z, |w| w.x * w.z + w.y * w.y];
        let count = 1 << 16;
        for f in functions {
            let drawn = (0..count).map(|i| {
                let [u, v, pick, _] = Sampler::new(SAMPLERS[0], 4, (0, 0), i).set(0);
                let sample = bsdf.sample(Vec3::Z, pick, Vec2::new(u, v)).unwrap();
                let (f_cos, pdf) = bsdf.eval(Vec3::Z, sample.wi);
                assert!((sample.pdf - pdf).abs() <= 1e-5 * pdf);
                assert!((f_cos - sample.weight * pdf).abs().max_element() <= 1e-6);
                f64::from(f(sample.wi))
            });
            let drawn = drawn.sum::<f64>() / f64::from(count);
            let integral: f64 = sphere(400_000)
                .map(|w| f64::from(f(w) * bsdf.eval(Vec3::Z, w).1))
                .sum();
            let integral = integral * 4.0 * std::f64::consts::PI / 400_000.0;
            assert!((drawn - integral).abs() < 2e-3, "{ns}: {drawn} {integral}");
        }
    }
}

#[test]
fn a_mirror_reflects_at_the_normal_and_never_through_the_surface() {
    let mirror = Surface::Mirror {
        color: Texture::Constant(Rgb::splat(0.9)),
    };
    let wo = Vec3::new(0.48, 0.6, 0.64);
    for side in [1.0, -1.0] {
        let sample = bsdf(&mirror, NG, side)
            .sample(side * wo, 0.5, Vec2::ZERO)
            .unwrap();
        let expected = side * Vec3::new(-0.48, -0.6, 0.64);
        assert!((sample.wi - expected).length() < 1e-6, "{}", sample.wi);
        assert_eq!(
            (sample.weight, sample.pdf),
            (Rgb::splat(0.9), f32::INFINITY)
        );
        for ns in bent_normals() {
            let sample = bsdf(&mirror, ns, side)
                .sample(side * wo, 0.5, Vec2::ZERO)
                .unwrap();
            assert!(side * sample.wi.dot(NG) >= 0.0);
            assert!((sample.wi.length() - 1.0).abs() < 1e-5);
        }
    }
}

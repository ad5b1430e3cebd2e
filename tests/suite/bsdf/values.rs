//! Values of rough surfaces against the published formulas, worked out in f64 on their own.

use glam::{DVec3, Vec3};
use solidtrace::color::Rgb;
use solidtrace::material::{Fresnel, Metal, Principled, Roughness, Surface};
use solidtrace::texture::Texture;

use super::{bsdf, direction};

/// Walter et al. 2007, equation 33.
fn d(h: DVec3, alpha: f64) -> f64 {
    let cos2 = h.z * h.z;
    let tan2 = (1.0 - cos2) / cos2;
    alpha.powi(2) / (std::f64::consts::PI * cos2 * cos2 * (alpha.powi(2) + tan2).powi(2))
}

/// Smith's lambda of GGX, Heitz 2014, equation 72.
fn lambda(w: DVec3, alpha: f64) -> f64 {
    let tan2 = (1.0 - w.z * w.z) / (w.z * w.z);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// Height-correlated masking and shadowing, Heitz 2014, equation 99.
fn g(a: DVec3, b: DVec3, alpha: f64) -> f64 {
    1.0 / (1.0 + lambda(a, alpha) + lambda(b, alpha))
}

fn fresnel(cos: f64, eta: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
    if cos_t.is_nan() {
        return 1.0;
    }
    let s = (cos - eta * cos_t) / (cos + eta * cos_t);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t);
    0.5 * (s * s + p * p)
}

fn pairs() -> Vec<(Vec3, Vec3)> {
    let mut pairs = Vec::new();
    for a in [3.0, 40.0, 75.0, 87.0] {
        for b in [8.0, 50.0, 70.0, 110.0, 140.0, 175.0] {
            for azimuth in [0.0, 60.0, 150.0, 180.0] {
                pairs.push((direction(a, 20.0), direction(b, 20.0 + azimuth)));
            }
        }
    }
    pairs
}

fn assert_close(found: f32, expected: f64, what: &str) {
    let error = (f64::from(found) - expected).abs();
    assert!(
        error <= 2e-3 * expected + 1e-7,
        "{what}: {found}, expected {expected}"
    );
}

#[test]
fn rough_glass_is_walters_formula() {
    for r in [0.2_f32, 0.5, 0.9] {
        let alpha = f64::from(r).powi(2);
        let surface = Surface::Dielectric {
            ior: 1.5,
            fresnel: Fresnel::Exact,
            roughness: r.into(),
            absorption: Rgb::ZERO,
        };
        let mut through = 0;
        for (side, eta) in [(1.0_f32, 1.5), (-1.0, 1.0 / 1.5)] {
            for (wo, wi) in pairs() {
                let (f_cos, _) = bsdf(&surface, Vec3::Z, side).eval(side * wo, side * wi);
                let (o, i) = (wo.as_dvec3(), wi.as_dvec3());
                let what = format!("{wo} {wi} {eta} {alpha}");
                if i.z > 0.0 {
                    let h = (o + i).normalize();
                    let value = fresnel(o.dot(h), eta) * g(o, i, alpha) * d(h, alpha) / (4.0 * o.z);
                    assert_close(f_cos.x, value, &what);
                    continue;
                }
                // Equation 21 with light from i to o: the index where it goes is 1, where it comes from eta.
                let h = -(eta * i + o).normalize();
                let h = if h.z < 0.0 { -h } else { h };
                let value = if o.dot(h) > 0.0 && i.dot(h) < 0.0 {
                    through += 1;
                    let below = DVec3::new(i.x, i.y, -i.z);
                    let factor = (i.dot(h) * o.dot(h)).abs() / o.z;
                    factor * (1.0 - fresnel(o.dot(h), eta)) * g(o, below, alpha) * d(h, alpha)
                        / (eta * i.dot(h) + o.dot(h)).powi(2)
                } else {
                    0.0
                };
                assert_close(f_cos.x, value, &what);
            }
        }
        assert!(through > 30, "{through}");
    }
}

#[test]
fn smooth_metal_reflects_as_fresnel_says_and_nearly_smooth_metal_as_much() {
    let metal = Metal::named("copper").unwrap();
    let conductor = |r: f32| Surface::Conductor {
        metal,
        roughness: r.into(),
    };
    for degrees in [0.0, 45.0, 75.0] {
        let wo = direction(degrees, 30.0);
        let expected = metal.reflectance(wo.z);
        let smooth = bsdf(&conductor(0.02), Vec3::Z, 1.0);
        assert!(!smooth.is_smooth());
        let sample = smooth.sample(wo, 0.5, glam::Vec2::splat(0.5)).unwrap();
        assert!((sample.weight - expected).length() < 1e-5);
        assert!(sample.pdf.is_infinite());
        let rough = bsdf(&conductor(0.06), Vec3::Z, 1.0);
        assert!(rough.is_smooth());
        let mut mean = Rgb::ZERO;
        for i in 0..4096 {
            let (u, u2) = super::canonical(1, i);
            mean += rough.sample(wo, u, u2).map_or(Rgb::ZERO, |s| s.weight) / 4096.0;
        }
        assert!((mean - expected).length() < 5e-3, "{mean} {expected}");
    }
}

#[test]
fn brushed_facets_scatter_further_along_their_tangent() {
    let brushed = |rotation: f32| Surface::Glossy {
        color: Texture::Constant(Rgb::ONE),
        roughness: Roughness {
            value: 0.3.into(),
            anisotropy: 0.7.into(),
            rotation: rotation.into(),
        },
    };
    let value = |surface: &Surface, azimuth: f32| {
        bsdf(surface, Vec3::Z, 1.0)
            .eval(Vec3::Z, direction(30.0, azimuth))
            .0
            .x
    };
    let straight = brushed(0.0);
    assert!(value(&straight, 0.0) > 10.0 * value(&straight, 90.0));
    // Turning the brush turns the highlight with it, counter-clockwise.
    let turned = brushed(30_f32.to_radians());
    for azimuth in [0.0, 30.0, 75.0, 120.0] {
        let (a, b) = (value(&turned, azimuth + 30.0), value(&straight, azimuth));
        assert!((a - b).abs() < 1e-4 * b.max(1.0), "{a} {b}");
    }
    assert!((value(&turned, 30.0) - value(&turned, -30.0)).abs() > 0.1);
}

#[test]
fn a_window_reflects_and_passes_on_what_two_faces_do() {
    let window = Surface::ThinDielectric { ior: 1.5 };
    let bsdf = bsdf(&window, Vec3::Z, 1.0);
    let mut mirrored = 0;
    for i in 0..4000 {
        let u = (i as f32 + 0.5) / 4000.0;
        let sample = bsdf.sample(Vec3::Z, u, glam::Vec2::ZERO).unwrap();
        assert_eq!((sample.eta2, sample.weight), (1.0, Rgb::ONE));
        mirrored += u32::from(sample.wi.z > 0.0);
    }
    // 2 R / (1 + R) with R = 0.04.
    let share = f64::from(mirrored) / 4000.0;
    assert!((share - 0.08 / 1.04).abs() < 1e-3, "{share}");
    let slanted = direction(50.0, 70.0);
    let through = bsdf.sample(slanted, 0.99, glam::Vec2::ZERO).unwrap();
    assert!((through.wi + slanted).length() < 1e-6);
}

#[test]
fn smooth_plastic_is_its_closed_form() {
    // The matt base seen through a smooth boundary, with what that throws back down (Mitsuba's manual, "plastic"): its
    // underside reflects 0.5964 of even light at an index of 1.5.
    let inner = (0..100_000)
        .map(|i| {
            let cos = (f64::from(i) + 0.5) / 1e5;
            2e-5 * cos * fresnel(cos, 1.0 / 1.5)
        })
        .sum::<f64>();
    assert!((inner - 0.5964).abs() < 1e-3, "{inner}");
    let color = 0.6;
    let surface = Surface::Plastic {
        color: Texture::Constant(Rgb::splat(color as f32)),
        ior: 1.5,
        roughness: 0.0.into(),
    };
    for (wo, wi) in pairs() {
        let (f_cos, _) = bsdf(&surface, Vec3::Z, 1.0).eval(wo, wi);
        let (o, i) = (f64::from(wo.z), f64::from(wi.z));
        let passes = |cos| 1.0 - fresnel(cos, 1.5);
        let value = if i > 0.0 {
            let base = color / (std::f64::consts::PI * (1.0 - color * inner));
            passes(o) * passes(i) * base * i / 2.25
        } else {
            0.0
        };
        assert_close(f_cos.x, value, &format!("{wo} {wi}"));
    }
}

#[test]
fn a_principled_surface_reflects_as_gltf_says() {
    // F D G2 / (4 cos) with Schlick's F: 0.04 times the specular colour and strength.
    let mut black = Principled::new(Texture::Constant(Rgb::ZERO));
    black.roughness = 0.5.into();
    black.specular = 0.5.into();
    black.specular_color = Texture::Constant(Rgb::new(1.0, 2.0, 30.0));
    let surface = Surface::Principled(Box::new(black));
    for (wo, wi) in pairs() {
        let (f_cos, _) = bsdf(&surface, Vec3::Z, 1.0).eval(wo, wi);
        let (o, i) = (wo.as_dvec3(), wi.as_dvec3());
        let h = (o + i).normalize();
        let facets = if i.z > 0.0 {
            g(o, i, 0.25) * d(h, 0.25) / (4.0 * o.z)
        } else {
            0.0
        };
        for (channel, f0) in [(0, 0.02), (1, 0.04), (2, 0.5)] {
            let schlick = f0 + (0.5 - f0) * (1.0 - o.dot(h)).powi(5);
            assert_close(f_cos[channel], schlick * facets, &format!("{wo} {wi}"));
        }
    }
}

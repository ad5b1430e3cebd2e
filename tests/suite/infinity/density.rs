//! Directions of pictures come with the density that is said.

use glam::{DVec3, Vec2, Vec3};
use solidtrace::light::{LightSampler, Source};
use solidtrace::sampling::{Sampler, SamplerKind, random_direction};
use solidtrace::texture::Bitmap;

use crate::bsdf::drawing::chance;
use crate::bsdf::quadrature::Cell;

use super::{environment, picture};

const ROWS: usize = 24;
const COLUMNS: usize = 32;
const COUNT: u32 = 100_000;

fn pictures() -> Vec<(&'static str, Bitmap)> {
    vec![
        ("one row", picture(7, 1, |x, _| x as f32)),
        ("one column", picture(1, 5, |_, y| y as f32)),
        (
            "uneven",
            picture(13, 7, |x, y| (1 + (5 * x + 3 * y) % 7) as f32),
        ),
        (
            "zenith",
            picture(16, 8, |x, y| f32::from(u8::from(y == 0 && x < 5))),
        ),
        (
            "nadir",
            picture(16, 8, |x, y| f32::from(u8::from(y == 7 && x > 5))),
        ),
        (
            "lamp over the seam",
            picture(16, 8, |x, y| if (x, y) == (15, 3) { 1e6 } else { 0.01 }),
        ),
    ]
}

/// From the picture's axes, y up, to those of [`Cell`], z up.
fn upright(wi: DVec3) -> Vec3 {
    Vec3::new(wi.x as f32, wi.z as f32, wi.y as f32)
}

#[test]
fn directions_come_with_the_density_that_is_said_and_that_integrates_to_one() {
    let level = 0.01 / pictures().len() as f64;
    for (seed, (name, bitmap)) in pictures().into_iter().enumerate() {
        let lights = LightSampler::new(vec![environment(bitmap)]);
        let density = |w: Vec3| {
            let wi = DVec3::new(f64::from(w.x), f64::from(w.z), f64::from(w.y));
            lights
                .beyond(wi)
                .map(|(_, pdf)| f64::from(pdf))
                .sum::<f64>()
        };
        let cells = Cell::all(ROWS, COLUMNS);
        let expected: Vec<f64> = cells
            .iter()
            .map(|cell| cell.integral(1e-6, &density))
            .collect();
        let integral: f64 = expected.iter().sum();
        assert!((integral - 1.0).abs() < 1e-3, "{name}: {integral}");
        let mut counts = vec![0_u32; cells.len()];
        for i in 0..COUNT {
            let sampler = Sampler::new(SamplerKind::Independent, seed as u64, (0, 0), i);
            let [pick, u, v, _] = sampler.set(0);
            let (_, sample) = lights.sample(DVec3::ZERO, pick, Vec2::new(u, v)).unwrap();
            let Source::Direction(wi) = sample.source else {
                panic!("{sample:?}");
            };
            let (radiance, pdf) = lights.beyond(wi).next().unwrap();
            assert_eq!((radiance, pdf), (sample.li, sample.pdf), "{name}");
            counts[Cell::index(upright(wi), ROWS, COLUMNS)] += 1;
        }
        let all =
            (expected.iter().zip(&counts)).map(|(p, &n)| (p * f64::from(COUNT), f64::from(n)));
        let chance = chance(all.collect());
        assert!(chance > level, "{name}: {chance}");
    }
}

#[test]
fn what_is_brighter_than_the_mean_is_aimed_at_and_the_darkest_of_a_picture_is_not() {
    let mut rng = rand::SeedableRng::seed_from_u64(4);
    let rng: &mut rand_pcg::Pcg32 = &mut rng;
    for (name, bitmap) in pictures() {
        let least = bitmap
            .pixels
            .iter()
            .fold(f32::INFINITY, |least, p| least.min(p.x));
        let lights = LightSampler::new(vec![environment(bitmap)]);
        let around: Vec<(f32, f32)> = (0..20_000)
            .map(|_| {
                let (radiance, pdf) = lights.beyond(random_direction(rng)).next().unwrap();
                (radiance.x, pdf)
            })
            .collect();
        let mean = around.iter().map(|(radiance, _)| radiance).sum::<f32>() / around.len() as f32;
        for (radiance, pdf) in around {
            if radiance > 1.1 * mean {
                assert!(pdf > 0.0, "{name}: {radiance}");
            } else if radiance <= least {
                assert_eq!(pdf, 0.0, "{name}: {radiance}");
            }
        }
    }
}

#[test]
fn even_and_black_pictures_are_no_lights_to_aim_at() {
    for (grey, width, height) in [(0.0, 4, 2), (0.3, 8, 4), (7.0, 1, 1)] {
        let lights = LightSampler::new(vec![environment(picture(width, height, |_, _| grey))]);
        assert_eq!(lights.sample(DVec3::ZERO, 0.5, Vec2::splat(0.5)), None);
        let seen = lights.beyond(DVec3::X).next();
        assert_eq!(seen, Some((Vec3::splat(grey), 0.0)));
    }
}

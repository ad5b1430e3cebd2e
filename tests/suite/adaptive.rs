//! Adaptive sampling: it stops where the error is as small as was asked, not before and not much later.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec3, Vec3};
use solidtrace::color::{Rgb, luminance};
use solidtrace::film::{PixelSum, Rect};
use solidtrace::geometry::Solid;
use solidtrace::integrator::{CameraRay, Integrator, PathIntegrator};
use solidtrace::material::Fresnel;
use solidtrace::render::{Observer, RenderSettings, Rendered, render};
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::Scene;
use solidtrace::world::World;

use crate::support::{Build, camera, dielectric, diffuse, empty_scene};

/// Shows to each pixel sample what the function says, from the direction of the ray and two random numbers.
struct Synthetic<F>(F);

impl<F: Fn(Vec3, [f32; 2]) -> f32 + Sync> Integrator for Synthetic<F> {
    fn radiance(&self, _: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        for (camera, radiance) in batch.iter().zip(radiance) {
            let [u, v, ..] = camera.sampler.set(1);
            *radiance = Rgb::splat((self.0)(camera.ray.direction.as_vec3(), [u, v]));
        }
        batch.len() as u64
    }
}

const SIZE: (u32, u32) = (48, 40);

fn settings(noise: f64, most: u32) -> RenderSettings {
    RenderSettings {
        size: SIZE,
        area: Rect::of_size(SIZE),
        samples: 0..most,
        sampler: SamplerKind::Independent,
        noise: Some(noise),
        ..RenderSettings::of(&empty_scene())
    }
}

fn synthetic(settings: &RenderSettings, value: impl Fn(Vec3, [f32; 2]) -> f32 + Sync) -> Rendered {
    shoot(&empty_scene().world(), &Synthetic(value), settings, &())
}

fn shoot(
    world: &World,
    integrator: &dyn Integrator,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Rendered {
    let lens = world.scene().cameras[0].lens(settings.size).unwrap();
    render(world, &lens, integrator, settings, observer).unwrap()
}

fn counts(rendered: &Rendered) -> Vec<u32> {
    rendered.film.pixels().iter().map(PixelSum::count).collect()
}

/// 1 in the mean with the given standard deviation.
fn noisy(deviation: f32, u: f32) -> f32 {
    if u < 0.5 {
        1.0 - deviation
    } else {
        1.0 + deviation
    }
}

#[test]
fn a_picture_of_even_noise_gets_the_samples_that_its_deviation_asks_for() {
    for (deviation, noise) in [(0.5_f32, 0.05), (0.3, 0.02), (0.9, 0.05)] {
        let rendered = synthetic(&settings(noise, 1 << 12), |_, [u, _]| noisy(deviation, u));
        let needed = (f64::from(deviation) / noise).powi(2);
        let counts = counts(&rendered);
        let mean = counts.iter().map(|&n| f64::from(n)).sum::<f64>() / counts.len() as f64;
        println!("{deviation} to {noise}: {mean} of {needed}");
        // All of nine blocks must be good, each known to about a tenth: some more than needed, and not less.
        assert!(
            mean > needed && mean < 1.4 * needed + 16.0,
            "{mean} where {needed} would do"
        );
        assert!(counts.iter().all(|&n| f64::from(n) > 0.85 * needed));
        assert_eq!(rendered.converged, Some(counts.len() as u64));
        assert!(rendered.complete);
    }
}

#[test]
fn black_and_constant_pictures_end_after_32_samples() {
    for value in [0.0, 1e-9, 0.5, 1e9] {
        let rendered = synthetic(&settings(1e-3, 1 << 20), |_, _| value);
        assert!(counts(&rendered).iter().all(|&n| n == 32), "{value}");
        assert_eq!(rendered.converged, Some(48 * 40));
    }
}

#[test]
fn noise_in_the_dark_is_measured_against_a_thirtieth_of_white() {
    // A deviation of 3e-4 over 0.032 is 1 %: 16 samples have four times less.
    let taken = |noise| {
        let rendered = synthetic(&settings(noise, 1 << 12), |_, [u, _]| 3e-4 * noisy(1.0, u));
        counts(&rendered)
    };
    assert!(taken(0.01).iter().all(|&n| n == 32));
    assert!(taken(0.0005).iter().all(|&n| n > 300 && n < 640));
}

#[test]
fn only_what_is_noisy_and_its_neighbours_go_on() {
    let render = |area: Rect| {
        let settings = RenderSettings {
            area,
            ..settings(0.02, 160)
        };
        // Noise on the left half, 24 columns and three blocks of eight.
        let value = |d: Vec3, [u, _]: [f32; 2]| if d.x < 0.0 { noisy(0.9, u) } else { 1.0 };
        synthetic(&settings, value)
    };
    let rendered = render(Rect::of_size(SIZE));
    for (i, count) in counts(&rendered).into_iter().enumerate() {
        let expected = if i % 48 < 32 { 160 } else { 32 };
        assert_eq!(count, expected, "pixel {i}");
    }
    assert_eq!(rendered.converged, Some(16 * 40));
    // Blocks lie on the picture's grid, wherever a part of it starts.
    let part = Rect {
        x: 13,
        y: 3,
        width: 30,
        height: 9,
    };
    let cut = render(part);
    for (i, (whole, count)) in counts(&rendered).into_iter().zip(counts(&cut)).enumerate() {
        let inside = (13..43).contains(&(i % 48)) && (3..12).contains(&(i / 48));
        assert_eq!(count, if inside { whole } else { 0 }, "pixel {i}");
    }
    assert_eq!(cut.converged, Some(11 * 9));
}

#[test]
fn pixels_that_have_not_met_a_rare_light_yet_wait_for_their_neighbours() {
    // One sample in 4,000 is a thousand times as bright: within 32 samples, half of the blocks have none.
    let value = |_: Vec3, [u, _]: [f32; 2]| if u < 1.0 / 4000.0 { 1000.0 } else { 1.0 };
    let rendered = synthetic(&settings(0.1, 128), value);
    let early = counts(&rendered).iter().filter(|&&n| n < 128).count();
    assert_eq!(early, 0);
}

#[test]
fn any_first_sample_and_any_limit_will_do() {
    for (samples, expected) in [(1000..1003, 3), (5..36, 31), (7..200, 32), (0..33, 32)] {
        let settings = RenderSettings {
            samples: samples.clone(),
            ..settings(0.5, 1)
        };
        let rendered = synthetic(&settings, |_, [u, _]| noisy(0.5, u));
        assert!(
            counts(&rendered).iter().all(|&n| n == expected),
            "{samples:?}"
        );
        let done = if expected < 32 { 0 } else { 48 * 40 };
        assert_eq!(rendered.converged, Some(done), "{samples:?}");
    }
}

#[test]
fn samples_are_those_of_a_plain_render_up_to_where_a_pixel_stops() {
    let value = |d: Vec3, [u, v]: [f32; 2]| noisy(0.2 + 0.5 * d.x.abs(), u) + v;
    let adaptive = synthetic(&settings(0.03, 256), value);
    let counts = counts(&adaptive);
    let mut kinds = counts.clone();
    kinds.sort_unstable();
    kinds.dedup();
    assert!(kinds.len() > 3, "{kinds:?}");
    for count in kinds {
        let plain = RenderSettings {
            noise: None,
            ..settings(0.03, count)
        };
        let plain = synthetic(&plain, value);
        for (i, &of_pixel) in counts.iter().enumerate() {
            if of_pixel == count {
                assert_eq!(adaptive.film.pixels()[i], plain.film.pixels()[i]);
            }
        }
    }
}

/// Sky and an even floor, easy; a glass ball and a small lamp, hard.
fn easy_and_hard() -> Scene {
    let mut scene = empty_scene();
    scene.environment = Rgb::new(0.5, 0.6, 0.8);
    scene.cameras = vec![camera(DVec3::new(0.0, 1.0, 6.0), DVec3::new(0.0, 0.9, 0.0))];
    let white = scene.material(diffuse(0.7), 0.0);
    let glass = scene.material(dielectric(1.5, Fresnel::Exact), 0.0);
    let lamp = scene.material(diffuse(0.0), 30.0);
    scene
        .solid(
            Solid::Box {
                half: DVec3::new(6.0, 0.1, 3.0),
            },
            white,
            DVec3::new(0.0, -0.1, 0.0),
        )
        .solid(
            Solid::Sphere { radius: 0.4 },
            glass,
            DVec3::new(-1.0, 0.4, 1.0),
        )
        .solid(
            Solid::Sphere { radius: 0.2 },
            lamp,
            DVec3::new(-1.5, 1.5, 0.5),
        );
    scene
}

const PATH: PathIntegrator = PathIntegrator {
    max_depth: Some(6),
    russian_roulette: true,
};

fn of_scene(noise: Option<f64>, samples: Range<u32>, seed: u64) -> RenderSettings {
    RenderSettings {
        size: (96, 64),
        area: Rect::of_size((96, 64)),
        samples,
        seed,
        noise,
        sampler: SamplerKind::Sobol,
        ..RenderSettings::of(&easy_and_hard())
    }
}

/// The error of each block of 8 by 8 against the truth, as adaptive sampling defines it.
fn block_errors(rendered: &Rendered, truth: &Rendered) -> Vec<f64> {
    let luminances = |rendered: &Rendered| -> Vec<f64> {
        let pixels = rendered.film.pixels().iter();
        pixels
            .map(|pixel| f64::from(luminance(pixel.mean())))
            .collect()
    };
    let (found, truth) = (luminances(rendered), luminances(truth));
    let error = |block: Rect| {
        let squares = block.pixels().map(|(x, y)| {
            let i = (y * 96 + x) as usize;
            (found[i] - truth[i]).powi(2) / (truth[i] * truth[i] + 1e-3)
        });
        (squares.sum::<f64>() / 64.0).sqrt()
    };
    Rect::of_size((96, 64)).tiles(8).map(error).collect()
}

#[test]
fn true_errors_are_as_small_as_asked_with_fewer_samples_than_everywhere_the_same() {
    let world = easy_and_hard().world();
    let truth = shoot(&world, &PATH, &of_scene(None, 0..4096, 99), &());
    let noise = 0.04;
    let kept = |errors: &[f64]| {
        let good = errors.iter().filter(|&&error| error <= noise).count();
        good as f64 / errors.len() as f64
    };
    let worst = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
    // Of adaptive sampling, and of as many samples everywhere and twice as many: the blocks of three pictures.
    let mut errors = [const { Vec::new() }; 3];
    for seed in 0..3 {
        let adaptive = shoot(&world, &PATH, &of_scene(Some(noise), 0..2048, seed), &());
        let counts = counts(&adaptive);
        assert_eq!(adaptive.converged, Some(counts.len() as u64));
        errors[0].extend(block_errors(&adaptive, &truth));
        let mean = counts.iter().map(|&n| f64::from(n)).sum::<f64>() / counts.len() as f64;
        for (errors, factor) in errors[1..].iter_mut().zip([1.0, 2.0]) {
            let uniform = of_scene(None, 0..(factor * mean) as u32, seed);
            errors.extend(block_errors(&shoot(&world, &PATH, &uniform, &()), &truth));
        }
    }
    for errors in &errors {
        println!("{} kept, worst {}", kept(errors), worst(errors));
    }
    let [adaptive, uniform @ ..] = errors;
    assert!(kept(&adaptive) >= 0.95);
    assert!(worst(&adaptive) < 1.5 * noise);
    // Either leaves more of the picture too noisy.
    for errors in uniform {
        assert!(kept(&errors) < kept(&adaptive) && worst(&errors) > worst(&adaptive));
    }
}

#[test]
fn neither_threads_nor_tiles_show() {
    let world = easy_and_hard().world();
    let split = |threads, tile_size| {
        let settings = RenderSettings {
            threads,
            tile_size,
            ..of_scene(Some(0.1), 0..256, 0)
        };
        shoot(&world, &PATH, &settings, &())
    };
    let first = split(1, 32);
    let few = counts(&first).iter().filter(|&&n| n < 256).count();
    assert!(few > 1000, "{few} pixels stop early");
    for (threads, tile_size) in [(2, 5), (3, 64), (2, 1)] {
        let other = split(threads, tile_size);
        assert_eq!(other.film, first.film, "{threads} {tile_size}");
        assert_eq!(other.converged, first.converged);
        assert_eq!(other.rays, first.rays);
    }
}

/// Counts, and stops a render after so many samples.
struct Counter {
    seen: AtomicU64,
    most: u64,
}

impl Observer for Counter {
    fn advance(&self, samples: u64, _rays: u64) {
        self.seen.fetch_add(samples, Ordering::Relaxed);
    }

    fn stop(&self) -> bool {
        self.seen.load(Ordering::Relaxed) >= self.most
    }
}

#[test]
fn progress_reaches_all_samples_and_an_early_end_leaves_a_whole_picture() {
    let value = |d: Vec3, [u, _]: [f32; 2]| if d.x < 0.0 { noisy(0.9, u) } else { 1.0 };
    let world = empty_scene().world();
    let counter = |most| Counter {
        seen: AtomicU64::new(0),
        most,
    };
    let all = counter(u64::MAX);
    let rendered = shoot(&world, &Synthetic(value), &settings(0.05, 1 << 10), &all);
    assert!(rendered.complete);
    assert_eq!(all.seen.into_inner(), 48 * 40 * 1024);
    let some = counter(48 * 40 * 100);
    let rendered = shoot(&world, &Synthetic(value), &settings(1e-4, 1 << 10), &some);
    assert!(!rendered.complete);
    assert!(counts(&rendered).iter().all(|&n| n >= 32));
}

//! The film adds exactly, and its filters sample what they promise.

use glam::Vec2;
use solidtrace::color::Rgb;
use solidtrace::film::{Film, Filter, MAX_SAMPLE, PixelSum, Rect};

use crate::random::SplitMix;

/// An f32 as mantissa and power of two, from its bits.
fn parts(x: f32) -> (i128, i32) {
    let bits = x.to_bits();
    let biased = (bits >> 23 & 255) as i32;
    let hidden = i128::from(biased != 0) << 23;
    let mantissa = hidden | i128::from(bits & 0x007f_ffff);
    let sign = if x.is_sign_negative() { -1 } else { 1 };
    (sign * mantissa, biased.max(1) - 150)
}

/// `a / b` to the nearest f32, the even one in a tie, by integer arithmetic alone; `a` in units of 2^-48.
fn nearest_f32(a: i128, b: u32) -> f32 {
    let (negative, a, b) = (a < 0, a.unsigned_abs(), u128::from(b));
    if a == 0 {
        return 0.0;
    }
    // A quotient of 24 bits: scale by 2^shift, then divide with the remainder.
    let mut shift = 0_i32;
    let scaled = |shift: i32| {
        if shift >= 0 {
            (a << shift, b)
        } else {
            (a, b << -shift)
        }
    };
    while scaled(shift).0 / scaled(shift).1 >= 1 << 24 {
        shift -= 1;
    }
    while scaled(shift).0 / scaled(shift).1 < 1 << 23 {
        shift += 1;
    }
    let (top, bottom) = scaled(shift);
    let (mut quotient, rest) = (top / bottom, top % bottom);
    if 2 * rest > bottom || (2 * rest == bottom && quotient % 2 == 1) {
        quotient += 1;
    }
    let magnitude = quotient as f64 * 2_f64.powi(-48 - shift);
    (if negative { -magnitude } else { magnitude }) as f32
}

#[test]
fn means_equal_rational_arithmetic() {
    let mut random = SplitMix(1);
    for round in 0..2000 {
        // From samples that all enter exactly to those of which only a bit is left, or none.
        let (low, high) = [
            (-25, 47),
            (-25, -20),
            (20, 46),
            (-3, 3),
            (-67, -40),
            (-67, 47),
        ][round % 6];
        let count = 1 + (random.next() % 40) as u32;
        let mut pixel = PixelSum::default();
        let mut exact = [0_i128; 3];
        for _ in 0..count {
            let sample = random.rgb(low, high);
            assert!(pixel.add(sample));
            for (sum, c) in exact.iter_mut().zip(sample.to_array()) {
                let (mantissa, exponent) = parts(c);
                let shift = exponent + 48;
                *sum += if shift >= 0 {
                    mantissa << shift
                } else if shift < -60 {
                    0
                } else {
                    // To the nearest unit, half away from zero.
                    let half = 1_i128 << (-shift - 1);
                    mantissa.signum() * ((mantissa.abs() + half) >> -shift)
                };
            }
        }
        assert_eq!(pixel.count(), count);
        assert_eq!(
            pixel.mean().to_array().map(f32::to_bits),
            exact.map(|sum| nearest_f32(sum, count).to_bits()),
            "{low} {high} {count}"
        );
    }
}

#[test]
fn a_tiny_sample_among_huge_ones_is_not_lost() {
    let mut pixel = PixelSum::default();
    for c in [MAX_SAMPLE, 2_f32.powi(-40), -MAX_SAMPLE, 2_f32.powi(-40)] {
        assert!(pixel.add(Rgb::splat(c)));
    }
    assert_eq!(pixel.mean(), Rgb::splat(2_f32.powi(-41)));
}

#[test]
fn the_order_of_samples_cannot_show() {
    let mut random = SplitMix(2);
    let mut samples: Vec<Rgb> = (0..1000).map(|_| random.rgb(-60, 46)).collect();
    let sum = |samples: &[Rgb]| {
        let mut pixel = PixelSum::default();
        assert!(samples.iter().all(|&s| pixel.add(s)));
        pixel
    };
    let first = sum(&samples);
    for _ in 0..50 {
        random.shuffle(&mut samples);
        assert_eq!(sum(&samples), first);
    }
}

#[test]
fn tiles_of_any_size_and_order_give_the_same_film() {
    const SIZE: (u32, u32) = (37, 23);
    let whole = Rect::of_size(SIZE);
    let sample =
        |x: u32, y: u32, i: u32| SplitMix(u64::from((y * SIZE.0 + x) * 64 + i)).rgb(-40, 40);
    let fill = |rect: Rect, samples: std::ops::Range<u32>| {
        let mut tile = Film::new(rect);
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                for i in samples.clone() {
                    assert!(tile.pixel_mut(x, y).add(sample(x, y, i)));
                }
            }
        }
        tile
    };
    let at_once = fill(whole, 0..8);
    let mut random = SplitMix(3);
    for edge in [1, 5, 16, 23, 64] {
        let mut parts: Vec<Film> = (whole.tiles(edge))
            .flat_map(|rect| [fill(rect, 0..3), fill(rect, 3..8)])
            .collect();
        random.shuffle(&mut parts);
        let mut film = Film::new(whole);
        for part in &parts {
            film.add(part);
        }
        assert_eq!(film, at_once, "tiles of {edge}");
    }
    let mut halves = fill(whole, 4..8);
    halves.add(&fill(whole, 0..4));
    assert_eq!(halves, at_once);
}

#[test]
fn tiles_cover_every_pixel_once() {
    for (width, height, edge) in [(1, 1, 1), (7, 3, 2), (64, 64, 16), (5, 9, 100), (0, 4, 2)] {
        let rect = Rect {
            x: 3,
            y: 11,
            width,
            height,
        };
        let mut seen: Vec<(u32, u32)> = (rect.tiles(edge))
            .inspect(|tile| {
                assert!(rect.contains(*tile) && tile.width <= edge && tile.height <= edge);
            })
            .flat_map(Rect::pixels)
            .collect();
        let mut in_blocks: Vec<(u32, u32)> = rect.blocks().collect();
        let all: Vec<_> = (3..3 + width)
            .flat_map(|x| (11..11 + height).map(move |y| (x, y)))
            .collect();
        for pixels in [&mut seen, &mut in_blocks] {
            pixels.sort_unstable();
            assert_eq!(*pixels, all);
        }
    }
}

#[test]
fn pixels_that_follow_each_other_in_blocks_are_rectangles() {
    let blocks: Vec<(u32, u32)> = Rect::of_size((40, 24)).blocks().collect();
    for (width, height) in [(2, 2), (4, 2), (4, 4), (8, 8)] {
        for block in blocks.chunks((width * height) as usize) {
            let (x, y) = block[0];
            assert!(x.is_multiple_of(width) && y.is_multiple_of(height));
            assert!(
                block.iter().all(|p| p.0 - x < width && p.1 - y < height),
                "{block:?}"
            );
        }
    }
}

#[test]
#[should_panic(expected = "is not inside of")]
fn a_tile_beyond_the_film_is_a_bug() {
    let mut film = Film::new(Rect::of_size((4, 4)));
    film.add(&Film::new(Rect {
        x: 3,
        y: 0,
        width: 2,
        height: 1,
    }));
}

#[test]
fn what_is_no_finite_number_in_range_is_refused_and_leaves_no_trace() {
    let mut pixel = PixelSum::default();
    assert!(pixel.add(Rgb::new(1.0, 2.0, 3.0)));
    let before = pixel;
    for bad in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        MAX_SAMPLE.next_up(),
        f32::MIN,
    ] {
        for channel in 0..3 {
            let mut sample = Rgb::ONE;
            sample[channel] = bad;
            assert!(!pixel.add(sample), "{bad} was taken");
            assert_eq!(pixel, before);
        }
    }
    assert!(pixel.add(Rgb::splat(MAX_SAMPLE)));
    assert!(pixel.add(Rgb::splat(-MAX_SAMPLE)));
    assert_eq!(pixel.mean(), Rgb::new(1.0, 2.0, 3.0) / 3.0);
}

#[test]
fn an_interrupted_film_divides_each_pixel_by_its_own_count() {
    let mut film = Film::new(Rect::of_size((3, 1)));
    for (x, count) in [(0, 0), (1, 1), (2, 3)] {
        for i in 0..count {
            assert!(film.pixel_mut(x, 0).add(Rgb::new(1.0, i as f32, -6.0)));
        }
    }
    let image = film.to_image();
    assert_eq!((image.width, image.height), (3, 1));
    assert_eq!(image.channel("R").unwrap(), [0.0, 1.0, 1.0]);
    assert_eq!(image.channel("G").unwrap(), [0.0, 0.0, 1.0]);
    assert_eq!(image.channel("B").unwrap(), [0.0, -6.0, -6.0]);
    assert_eq!(film.pixels()[0].count(), 0);
}

const FILTERS: [Filter; 6] = [
    Filter::Box { radius: 0.5 },
    Filter::Box { radius: 2.0 },
    Filter::Tent { radius: 1.0 },
    Filter::Tent { radius: 0.25 },
    Filter::Gaussian { radius: 1.5 },
    Filter::Gaussian { radius: 3.0 },
];

/// erf by its series of positive terms (Abramowitz and Stegun 7.1.6).
fn erf(x: f64) -> f64 {
    let mut term = x;
    let mut sum = x;
    for n in 1..200 {
        term *= 2.0 * x * x / f64::from(2 * n + 1);
        sum += term;
    }
    sum * std::f64::consts::FRAC_2_SQRT_PI * (-x * x).exp()
}

/// Radius, the share of the filter left of `x`, and the variance, in closed form.
fn truth(filter: Filter) -> (f64, impl Fn(f64) -> f64, f64) {
    let radius = match filter {
        Filter::Box { radius } | Filter::Tent { radius } | Filter::Gaussian { radius } => radius,
    };
    let cdf = move |x: f64| {
        let t = x / radius;
        match filter {
            Filter::Box { .. } => 0.5 * (1.0 + t),
            Filter::Tent { .. } => 0.5 + t - 0.5 * t * t.abs(),
            Filter::Gaussian { .. } => {
                0.5 + 0.5 * erf(3.0 * t / 2_f64.sqrt()) / erf(3.0 / 2_f64.sqrt())
            }
        }
    };
    let variance = match filter {
        Filter::Box { .. } => radius * radius / 3.0,
        Filter::Tent { .. } => radius * radius / 6.0,
        Filter::Gaussian { .. } => {
            let density = (-4.5_f64).exp() / std::f64::consts::TAU.sqrt();
            let inside = erf(3.0 / 2_f64.sqrt());
            (radius / 3.0).powi(2) * (1.0 - 6.0 * density / inside)
        }
    };
    (radius, cdf, variance)
}

#[test]
fn filter_samples_invert_the_distribution_function() {
    for filter in FILTERS {
        let (radius, cdf, _) = truth(filter);
        let mut last = f64::NEG_INFINITY;
        for i in 0..=4000 {
            let u = (i as f32 / 4000.0).min(1.0_f32.next_down());
            let (x, y) = filter.sample(Vec2::new(u, 0.5));
            assert!((cdf(x) - f64::from(u)).abs() < 3e-9, "{filter:?} {u}: {x}");
            assert!(x.abs() <= radius && x >= last, "{filter:?} {u}: {x}");
            assert!(y.abs() < 1e-12);
            assert_eq!(filter.sample(Vec2::new(0.25, u)).1, x);
            last = x;
        }
    }
}

#[test]
fn filter_samples_have_the_filters_variance() {
    for filter in FILTERS {
        let (radius, _, variance) = truth(filter);
        let count = 1 << 16;
        let (mut mean, mut square) = (0.0, 0.0);
        for i in 0..count {
            let u = (i as f32 + 0.5) / count as f32;
            let (x, _) = filter.sample(Vec2::new(u, u));
            mean += x / f64::from(count);
            square += x * x / f64::from(count);
        }
        assert!(mean.abs() < 1e-9 * radius, "{filter:?}: mean {mean}");
        assert!(
            (square / variance - 1.0).abs() < 1e-5,
            "{filter:?}: {square} {variance}"
        );
    }
}

#[test]
fn filter_samples_are_symmetric() {
    for filter in FILTERS {
        for i in 1..1024 {
            let u = i as f32 / 1024.0;
            let (x, y) = filter.sample(Vec2::new(u, 1.0 - u));
            assert!((x + y).abs() <= 1e-12, "{filter:?} {u}: {x} {y}");
        }
    }
}

#[test]
fn filter_samples_fill_a_histogram_by_chi_squared() {
    const BINS: usize = 50;
    const COUNT: usize = 200_000;
    for (seed, filter) in FILTERS.into_iter().enumerate() {
        let (radius, cdf, _) = truth(filter);
        let mut random = SplitMix(seed as u64 + 10);
        let mut counts = [0_u32; BINS];
        for _ in 0..COUNT {
            let u = (random.next() >> 40) as f32 / (1 << 24) as f32;
            let (_, y) = filter.sample(Vec2::new(0.1, u));
            let bin = ((y / radius + 1.0) * 0.5 * BINS as f64) as usize;
            counts[bin.min(BINS - 1)] += 1;
        }
        let edge = |bin: usize| cdf(radius * (2.0 * bin as f64 / BINS as f64 - 1.0));
        let chi_squared: f64 = (counts.iter().enumerate())
            .map(|(bin, &seen)| {
                let expected = COUNT as f64 * (edge(bin + 1) - edge(bin));
                (f64::from(seen) - expected).powi(2) / expected
            })
            .sum();
        // 49 degrees of freedom: 1 in 100,000 lies above 101.
        assert!(chi_squared < 101.0, "{filter:?}: {chi_squared}");
    }
}

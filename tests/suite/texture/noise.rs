//! Perlin's improved noise.

use glam::{DVec3, IVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::texture::{fbm, harmonics, noise, turbulence};

/// Values of the improved noise with the published table. They are those of another program, `ImprovedNoise` of
/// three.js 0.170; the first four are also what ports of the Java reference implementation are commonly checked against,
/// the very first being Rosetta Code's.
#[expect(
    clippy::approx_constant,
    reason = "the first point is where it was published"
)]
const REFERENCE: [([f64; 3], f64); 20] = [
    ([3.14, 42.0, 7.0], 0.13691995878400012),
    ([-4.2, 10.0, 6.0], 0.14208000000000043),
    ([0.5, 0.5, 0.5], -0.25),
    ([0.1, 0.1, 0.1], 0.1861607143544832),
    ([-0.5, -1.25, -2.75], -0.10498714447021484),
    ([1.5, 2.5, 3.5], 0.125),
    ([0.25, 0.75, 0.125], -0.07060389698017389),
    ([12.34, 56.78, 90.12], 0.07834384344217528),
    ([-12.34, 56.78, -90.12], -0.2732695059957284),
    ([127.9, 128.1, -128.3], -0.1440691943147585),
    ([255.5, 255.25, 255.75], -0.5544366836547852),
    ([-255.5, -255.25, -255.75], -0.20627880096435547),
    ([256.1, 0.2, 511.3], 0.17649698716508866),
    ([1000.001, -2000.002, 3000.003], -0.001999920618508286),
    ([0.999, 0.001, 0.5], -0.5009999850025203),
    ([7.7, -3.3, 0.0], 0.39793213823999984),
    ([0.0, 5.05, -9.95], 0.05196519111550766),
    ([100.625, 200.375, 50.0625], -0.08388369856660693),
    ([-0.001, -0.001, -0.001], -0.0020000199300733825),
    ([12345.678, -98765.432, 24680.135], -0.20189228782996865),
];

fn points(count: usize, extent: f64) -> impl Iterator<Item = DVec3> {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    std::iter::repeat_with(move || {
        DVec3::from_array(std::array::from_fn(|_| rng.random_range(-extent..extent)))
    })
    .take(count)
}

/// Central differences.
fn gradient(p: DVec3, step: f64) -> DVec3 {
    let along = |axis: DVec3| (noise(p + step * axis) - noise(p - step * axis)) / (2.0 * step);
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

#[test]
fn noise_has_the_published_values() {
    for (p, value) in REFERENCE {
        let found = noise(DVec3::from_array(p));
        assert!((found - value).abs() < 1e-15, "{p:?}: {found} for {value}");
    }
}

#[test]
fn noise_is_zero_at_whole_coordinates_and_repeats_every_256() {
    for p in points(1000, 1e4).chain([DVec3::splat(1e15), DVec3::splat(-3e300)]) {
        assert_eq!(noise(p.floor()), 0.0, "{}", p.floor());
    }
    for p in points(1000, 8.0) {
        // On a grid that both sums are on.
        let p = (p * 1024.0).round() / 1024.0;
        for shift in [DVec3::X, DVec3::Y, DVec3::Z] {
            assert_eq!(noise(p), noise(p + 256.0 * shift));
            assert_eq!(noise(p), noise(p - 2560.0 * shift));
        }
    }
    assert!(noise(DVec3::NAN).is_nan() && noise(DVec3::INFINITY).is_nan());
}

#[test]
fn noise_has_one_of_the_twelve_gradients_at_whole_coordinates() {
    let mut seen = std::collections::HashSet::new();
    for p in points(2000, 300.0) {
        let g = gradient(p.floor(), 1e-4);
        let whole = g.round();
        assert!((g - whole).length() < 1e-6, "{g}");
        assert_eq!(whole.abs().element_sum(), 2.0, "{g}");
        assert_eq!(whole.abs().max_element(), 1.0, "{g}");
        let whole: IVec3 = whole.as_ivec3();
        seen.insert(whole);
    }
    assert_eq!(seen.len(), 12);
}

#[test]
fn noise_bends_without_a_break_where_cells_meet() {
    // The second derivative from either side of x = whole; a cubic blend would jump by up to 12.
    let step = 1e-4;
    let mut bent = 0.0_f64;
    for p in points(2000, 50.0) {
        let p = p.with_x(p.x.floor());
        let second = |side: f64| {
            let f = |k: f64| noise(p + side * k * step * DVec3::X);
            (f(0.0) - 2.0 * f(1.0) + f(2.0)) / (step * step)
        };
        let (left, right) = (second(-1.0), second(1.0));
        assert!((left - right).abs() < 0.05, "{p}: {left} {right}");
        bent = bent.max(gradient(p, step).length());
    }
    assert!(bent > 1.0);
}

#[test]
fn noise_stays_in_its_range_and_its_slope_in_its_bound() {
    let (mut least, mut most, mut steepest) = (0.0_f64, 0.0_f64, 0.0_f64);
    for p in points(200_000, 128.0) {
        let value = noise(p);
        (least, most) = (least.min(value), most.max(value));
        steepest = steepest.max(gradient(p, 1e-5).abs().max_element());
    }
    // Each corner's part of a derivative is at most its gradient's, 1, and the blend's slope, at most 15/8, times the
    // difference of two corners' values, each at most 2.
    assert!(
        steepest < 1.0 + 15.0 / 8.0 * 4.0 && steepest > 1.5,
        "{steepest}"
    );
    assert!(least > -1.04 && most < 1.04, "{least} {most}");
    assert!(least < -0.8 && most > 0.8, "{least} {most}");
}

#[test]
fn sums_of_noise_are_the_sums_that_they_say() {
    for p in points(100, 20.0) {
        let [one, two, four] = [1.0, 2.0, 4.0].map(|f| noise(f * p));
        assert_eq!(fbm(p, 1), one);
        assert!((fbm(p, 3) - (one + two / 2.0 + four / 4.0)).abs() < 1e-15);
        assert_eq!(turbulence(p, 1), one.abs());
        let sum = one.abs() + two.abs() / 2.0 + four.abs() / 4.0;
        assert!((turbulence(p, 3) - sum).abs() < 1e-15);
        // Levels have the frequencies 1, 2, 3, 4 and not powers of 2.
        let levels = (1..=3).map(|l| noise(f64::from(l) * p).abs() / f64::from(l));
        assert!((harmonics(20.0 * p, 3) - levels.sum::<f64>()).abs() < 1e-12);
    }
    let (p, value) = REFERENCE[0];
    let scaled = 20.0 * DVec3::from_array(p);
    assert!((harmonics(scaled, 1) - value).abs() < 1e-13);
}

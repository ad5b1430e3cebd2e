//! Directions come with the density that is said: Pearson's chi-squared test of counts in cells of the sphere against the
//! integral of the density over them.

use glam::Vec3;

use super::quadrature::Cell;
use super::{Case, canonical, cases};

const ROWS: usize = 16;
const COLUMNS: usize = 24;
const COUNT: u32 = 20_000;
/// Chance that a right sampler fails the whole test, were the seed drawn anew.
const FAMILY_ERROR: f64 = 0.01;

/// `ln Γ(x)` by Stirling's series after shifting `x` above 10.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 10.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let series = 1.0 / (12.0 * x) - 1.0 / (360.0 * x.powi(3)) + 1.0 / (1260.0 * x.powi(5));
    shift + (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series
}

/// The chance of a chi-squared variable of `freedom` degrees above `x`: 1 - P(freedom/2, x/2) by its series (Abramowitz
/// and Stegun 6.5.29), which converges for all that occurs here.
pub fn chance_above(x: f64, freedom: usize) -> f64 {
    let (a, x) = (0.5 * freedom as f64, 0.5 * x);
    if x > 20.0 * a + 200.0 {
        return 0.0;
    }
    let mut term = 1.0 / a;
    let mut sum = term;
    let mut n = a;
    while term > 1e-17 * sum {
        n += 1.0;
        term *= x / n;
        sum += term;
    }
    1.0 - (a * x.ln() - x - ln_gamma(a)).exp() * sum
}

#[test]
fn chances_are_those_of_tables() {
    // Abramowitz and Stegun, table 26.8.
    for (x, freedom, chance) in [
        (3.841_46, 1, 0.05),
        (18.3070, 10, 0.05),
        (23.2093, 10, 0.01),
        (124.342, 100, 0.05),
        (149.449, 100, 0.001),
    ] {
        let found = chance_above(x, freedom);
        assert!((found - chance).abs() < 1e-5, "{x}: {found}");
    }
}

/// The chance of counts at least as far off, and the integral of the density.
fn test(case: &Case, wo: Vec3, seed: u64) -> (f64, f64) {
    let bsdf = case.bsdf();
    let mut counts = vec![0_u32; ROWS * COLUMNS];
    let mut others = COUNT;
    for i in 0..COUNT {
        let (u, u2) = canonical(seed, i);
        if let Some(sample) = bsdf.sample(wo, u, u2).filter(|s| s.pdf.is_finite()) {
            counts[Cell::index(sample.wi, ROWS, COLUMNS)] += 1;
            others -= 1;
        }
    }
    let density = |wi: Vec3| f64::from(bsdf.eval(wo, wi).1);
    let cells = Cell::all(ROWS, COLUMNS);
    let expected = cells.iter().map(|cell| cell.integral(2e-5, &density));
    let expected: Vec<f64> = expected.collect();
    let integral: f64 = expected.iter().sum();
    // What is absorbed, and delta lobes, are a cell as well.
    let all = (expected.iter().zip(&counts))
        .map(|(p, n)| (p * f64::from(COUNT), f64::from(*n)))
        .chain([((1.0 - integral) * f64::from(COUNT), f64::from(others))]);
    (chance(all.collect()), integral)
}

/// The chance of counts at least as far off, of pairs of an expected count and one that was found. Cells with few counts
/// are put together.
pub fn chance(mut all: Vec<(f64, f64)>) -> f64 {
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut statistic = 0.0;
    let mut pooled = (0.0, 0.0);
    let mut groups = 0;
    for (i, (p, n)) in all.iter().enumerate() {
        pooled = (pooled.0 + p, pooled.1 + n);
        let rest: f64 = all[i + 1..].iter().map(|(p, _)| p).sum();
        if pooled.0 >= 5.0 && (rest >= 5.0 || i + 1 == all.len()) {
            statistic += (pooled.1 - pooled.0).powi(2) / pooled.0;
            groups += 1;
            pooled = (0.0, 0.0);
        }
    }
    if groups > 1 {
        chance_above(statistic, groups - 1)
    } else {
        1.0
    }
}

#[test]
fn directions_come_with_the_density_that_is_said_and_that_is_no_more_than_one() {
    let tests: Vec<(Case, Vec3)> = (cases().into_iter())
        .filter(|case| case.bsdf().is_smooth())
        .flat_map(|case| {
            case.views()
                .map(move |wo| (case.clone(), wo))
                .collect::<Vec<_>>()
        })
        .collect();
    // Šidák's correction.
    let level = 1.0 - (1.0 - FAMILY_ERROR).powf(1.0 / tests.len() as f64);
    let mut failed = Vec::new();
    for (i, (case, wo)) in tests.iter().enumerate() {
        let (chance, integral) = test(case, *wo, i as u64);
        if chance < level || integral > 1.001 {
            failed.push(format!(
                "{case} towards {wo}: {chance:.1e}, density {integral}"
            ));
        }
    }
    assert!(tests.len() > 400, "{}", tests.len());
    assert!(
        failed.is_empty(),
        "{} of {}:\n{}",
        failed.len(),
        tests.len(),
        failed.join("\n")
    );
}

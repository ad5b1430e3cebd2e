//! Points of lamps come with the density that is said, and that rays which hit them are told as well.

use glam::DVec3;
use solidtrace::math::{Bounds, Frame, Ray};
use solidtrace::sampling::{SamplerKind, uniform_cone};
use solidtrace::world::World;

use super::{VIEWERS, canonical, lamps, place};
use crate::bsdf::drawing::chance_above;

const ROWS: usize = 8;
const COLUMNS: usize = 12;
const DRAWN: u32 = 30_000;
const TRACED: u32 = 120_000;
/// Chance that a right sampler fails the whole test, were the seed drawn anew.
const FAMILY_ERROR: f64 = 0.01;

/// The cone, or sphere, of directions in which a lamp is seen.
struct Window {
    frame: Frame,
    one_minus_cos: f32,
}

impl Window {
    fn of(bounds: &Bounds, from: DVec3) -> Self {
        let axis = bounds.center() - from;
        let sin = 0.5 * bounds.size().length() / axis.length();
        Self {
            frame: Frame::around(axis.normalize().as_vec3()),
            one_minus_cos: if sin < 1.0 {
                (1.0 - (1.0 - sin * sin).sqrt()) as f32 * 1.001
            } else {
                2.0
            },
        }
    }

    fn solid_angle(&self) -> f64 {
        std::f64::consts::TAU * f64::from(self.one_minus_cos)
    }

    fn cell(&self, w: DVec3) -> usize {
        let local = self.frame.to_local(w.as_vec3());
        let share = (1.0 - local.z) / self.one_minus_cos;
        let row = ((share * ROWS as f32) as usize).min(ROWS - 1);
        let turn = (local.y.atan2(local.x) / std::f32::consts::TAU).rem_euclid(1.0);
        row * COLUMNS + ((turn * COLUMNS as f32) as usize).min(COLUMNS - 1)
    }
}

/// The density with which a direction is drawn: that of every point of the lamp along it, hidden or not.
fn density(world: &World, from: DVec3, w: DVec3, all: bool) -> f64 {
    let mut ray = Ray::new(from, w);
    let mut sum = 0.0;
    while let Some(hit) = world.intersect(&ray) {
        let point = world.surface(&ray, &hit);
        sum += f64::from(world.light_pdf(from, &hit, point.p));
        if !all {
            break;
        }
        ray.tmin = hit.t + 1e-9;
    }
    sum
}

/// The chance of counts as far from the density's integrals over cells, and its integral over all with its error.
fn test(world: &World, from: DVec3, all: bool, seed: u64) -> (f64, f64, f64) {
    let window = Window::of(&world.bounds(), from);
    let mut counts = vec![0.0; ROWS * COLUMNS];
    for i in 0..DRAWN {
        let (pick, u2) = canonical(SamplerKind::Independent, seed, i);
        if let Some(sample) = world.sample_light(from, pick, u2) {
            counts[window.cell((place(&sample) - from).normalize())] += 1.0;
        }
    }
    // Sums of the density and of its square.
    let mut sums = vec![[0.0; 2]; counts.len()];
    for i in 0..TRACED {
        let (_, u2) = canonical(SamplerKind::Independent, !seed, i);
        let local = uniform_cone(u2, window.one_minus_cos);
        let w = window.frame.to_world(local).as_dvec3().normalize();
        let density = density(world, from, w, all) * window.solid_angle();
        let sum = &mut sums[window.cell(w)];
        *sum = [sum[0] + density, sum[1] + density * density];
    }
    let traced = f64::from(TRACED);
    let spread = |[sum, squares]: [f64; 2]| (squares - sum * sum / traced).max(0.0).sqrt() / traced;
    let (mut statistic, mut groups) = (0.0, 0);
    let (mut few, mut total) = ([0.0; 3], [0.0; 2]);
    let mut compare = |count: f64, expected: f64, error: f64| {
        statistic += (count - expected).powi(2) / (expected + error * error);
        groups += 1;
    };
    for (count, sum) in counts.iter().zip(&sums) {
        let expected = sum[0] / traced * f64::from(DRAWN);
        let error = spread(*sum) * f64::from(DRAWN);
        if expected > 10.0 {
            compare(*count, expected, error);
        } else {
            few = [few[0] + count, few[1] + expected, few[2].hypot(error)];
        }
        total = [total[0] + sum[0], total[1] + sum[1]];
    }
    if few[1] > 10.0 {
        compare(few[0], few[1], few[2]);
    }
    (
        chance_above(statistic, groups),
        total[0] / traced,
        spread(total),
    )
}

#[test]
fn points_come_with_the_density_that_is_said_and_that_integrates_to_one() {
    let lamps = lamps();
    let tests = lamps.len() * VIEWERS.len();
    let level = 1.0 - (1.0 - FAMILY_ERROR).powf(1.0 / tests as f64);
    let mut failed = Vec::new();
    for (i, (name, world)) in lamps.iter().enumerate() {
        for (j, from) in VIEWERS.into_iter().enumerate() {
            // Those that do not leave out what is behind themselves.
            let all = name.starts_with("torus") || name.starts_with("box of");
            let seed = (10 * i + j) as u64;
            let (chance, integral, error) = test(world, from, all, seed);
            if chance < level || (integral - 1.0).abs() > 5.0 * error + 1e-3 {
                failed.push(format!(
                    "{name} from {from}: {chance:.1e}, density {integral} ± {error}"
                ));
            }
        }
    }
    assert!(tests > 80);
    assert!(failed.is_empty(), "of {tests}:\n{}", failed.join("\n"));
}

#[test]
fn a_ray_to_a_drawn_point_hits_the_lamp_there_and_is_told_the_same_density() {
    for (name, world) in lamps() {
        for from in VIEWERS {
            let (mut drawn, mut hidden, mut different) = (0, 0, 0);
            for i in 0..2000 {
                let (pick, u2) = canonical(SamplerKind::Sobol, 1, i);
                let Some(sample) = world.sample_light(from, pick, u2) else {
                    continue;
                };
                drawn += 1;
                let to = place(&sample) - from;
                let segment = Ray {
                    tmax: 1.0,
                    ..Ray::new(from, to)
                };
                if world.occluded(&segment) {
                    hidden += 1;
                    continue;
                }
                let ray = Ray::new(from, to);
                let Some(hit) = world.intersect(&ray) else {
                    // Past an edge by a rounding.
                    hidden += 1;
                    continue;
                };
                let point = world.surface(&ray, &hit);
                let told = world.light_pdf(from, &hit, point.p);
                if (hit.t - 1.0).abs() > 1e-6 || (told / sample.pdf - 1.0).abs() > 1e-4 {
                    different += 1;
                }
            }
            // On the horizon of the surface the gap before it can be seen.
            assert!(different <= 4, "{name} from {from}: {different} of {drawn}");
            assert!(drawn > 1900, "{name} from {from}: {drawn} drawn");
            // A torus hides a part of itself, and of a box of triangles one side hides the other.
            let convex = !name.starts_with("torus") && !name.starts_with("box of");
            assert!(
                !convex || hidden <= 4,
                "{name} from {from}: {hidden} hidden"
            );
        }
    }
}

//! The analytic solids against closed forms, brute force and arithmetic of 32 digits.

mod double;
mod oracle;
mod special;
mod surface;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec3};
use rand::RngExt;
use solidtrace::geometry::Solid;
use solidtrace::geometry::solid::{Crossing, Span};
use solidtrace::math::{Ray, Transform};

use double::Double;
use oracle::{
    SOLIDS, at, bound, face_count, faces, nasty_ray, nearby, outside, rng, size, torus_crossings,
    unit,
};

fn spans(solid: &Solid, ray: &Ray) -> Vec<Span> {
    solid.spans(ray).iter().copied().collect()
}

fn crossings(solid: &Solid, ray: &Ray) -> Vec<Crossing> {
    (spans(solid, ray).iter())
        .flat_map(|span| [span.enter, span.exit])
        .collect()
}

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray::new(DVec3::from_array(origin), DVec3::from_array(direction))
}

#[test]
fn lengths_of_spans_integrate_to_the_volumes_of_closed_forms() {
    let cone = |a: f64, b: f64, h: f64| PI * h * (a * a + a * b + b * b) / 3.0;
    let mut rng = rng(1);
    for solid in SOLIDS {
        let truth = match solid {
            Solid::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Solid::Box { half } => 8.0 * half.element_product(),
            Solid::Cylinder { radius, height } => PI * radius * radius * height,
            Solid::Cone {
                from_radius,
                to_radius,
                height,
            } => cone(from_radius, to_radius, height),
            Solid::Torus { major, minor } => 2.0 * PI * PI * major * minor * minor,
            Solid::Plane | Solid::Rectangle { .. } | Solid::Disk { .. } => continue,
        };
        // Along x, so that no solid of revolution is seen from its own axis.
        let (bounds, n) = (solid.bounds(), 1000);
        let cell = bounds.size() / f64::from(n);
        let mut sum = 0.0;
        for j in 0..n {
            for k in 0..n {
                let y = bounds.min.y + cell.y * (f64::from(j) + rng.random_range(0.0..1.0));
                let z = bounds.min.z + cell.z * (f64::from(k) + rng.random_range(0.0..1.0));
                let ray = ray([-7.0, y, z], [2.0, 0.0, 0.0]);
                for span in solid.spans(&ray).iter() {
                    sum += 2.0 * (span.exit.t - span.enter.t);
                }
            }
        }
        let volume = sum * cell.y * cell.z;
        assert!(
            (volume / truth - 1.0).abs() < 1e-4,
            "{solid:?}: {volume} for {truth}"
        );
    }
}

#[test]
fn every_crossing_lies_on_its_face_within_the_stated_bound() {
    let mut rng = rng(2);
    for solid in SOLIDS {
        for _ in 0..40_000 {
            let ray = nasty_ray(&mut rng, &solid);
            for c in crossings(&solid, &ray).iter().filter(|c| c.t.is_finite()) {
                let p = at(&ray, c.t);
                let distances = faces(&solid, p);
                let error = distances[c.face as usize]
                    .abs()
                    .high
                    .max(outside(&solid, p));
                assert!(
                    error <= bound(&solid, &ray),
                    "{solid:?} {ray:?} {c:?} is {error:e} off"
                );
            }
        }
    }
}

#[test]
fn spans_are_inside_in_order_and_apart() {
    let mut rng = rng(3);
    for solid in SOLIDS {
        for _ in 0..40_000 {
            let ray = nasty_ray(&mut rng, &solid);
            let spans = spans(&solid, &ray);
            let slack = bound(&solid, &ray);
            let middle = |a: f64, b: f64| match (a.is_finite(), b.is_finite()) {
                (true, true) => 0.5 * (a + b),
                (true, false) => a + 1.0,
                _ => b.min(9.0) - 1.0,
            };
            for span in &spans {
                assert!(span.enter.t <= span.exit.t, "{solid:?} {ray:?} {span:?}");
                let p = at(&ray, middle(span.enter.t, span.exit.t));
                assert!(outside(&solid, p) <= slack, "{solid:?} {ray:?} {span:?}");
            }
            for pair in spans.windows(2) {
                let (a, b) = (pair[0].exit.t, pair[1].enter.t);
                assert!(a < b, "{solid:?} {ray:?} {pair:?}");
                assert!(
                    outside(&solid, at(&ray, middle(a, b))) >= -slack,
                    "{solid:?} {ray:?}"
                );
            }
        }
    }
}

#[test]
fn marching_along_a_ray_finds_the_same_spans() {
    let mut rng = rng(4);
    for solid in SOLIDS {
        for _ in 0..25 {
            let (from, to) = (
                3.0 * size(&solid) * unit(&mut rng),
                nearby(&mut rng, &solid),
            );
            let ray = Ray::new(from, to - from);
            let spans = spans(&solid, &ray);
            for i in 0..10_000 {
                let t = 3.0 * (f64::from(i) + 0.5) / 10_000.0;
                let distance = outside(&solid, at(&ray, t));
                if distance.abs() > bound(&solid, &ray) {
                    let inside = spans.iter().any(|s| s.enter.t <= t && t <= s.exit.t);
                    assert_eq!(inside, distance < 0.0, "{solid:?} {ray:?} at {t}");
                    assert_eq!(
                        inside,
                        solid.contains(ray.at(t)),
                        "{solid:?} {ray:?} at {t}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_torus_is_crossed_as_often_as_sturm_says_of_one_that_differs_by_the_bound() {
    let mut rng = rng(5);
    let (mut counts, mut close) = ([0; 3], 0);
    for solid in SOLIDS {
        let Solid::Torus { major, minor } = solid else {
            continue;
        };
        for _ in 0..20_000 {
            let ray = nasty_ray(&mut rng, &solid);
            let count = crossings(&solid, &ray).len();
            let slack = bound(&solid, &ray);
            if slack >= 0.1 * minor {
                continue;
            }
            let thin = torus_crossings(major, minor - slack, &ray);
            let thick = torus_crossings(major, minor + slack, &ray);
            if thin == thick {
                // What does not reach deeper than the bound may be there or not: a line that is
                // displaced by it can cross where the radius alone decides nothing.
                let ends = crossings(&solid, &ray);
                let deep = |a: Crossing, b: Crossing| {
                    outside(&solid, at(&ray, 0.5 * (a.t + b.t))).abs() > slack
                };
                let shallow = ends.windows(2).any(|w| !deep(w[0], w[1]));
                assert!(
                    count == thin || shallow,
                    "{solid:?} {ray:?}: {count} for {thin}"
                );
                counts[count / 2] += 1;
            } else {
                close += 1;
            }
        }
    }
    assert!(
        counts.iter().all(|&n| n > 2000) && close > 2000,
        "{counts:?} {close}"
    );
}

#[test]
fn a_convex_solid_is_missed_only_where_the_line_is_nowhere_inside() {
    let mut rng = rng(6);
    for solid in SOLIDS {
        if matches!(solid, Solid::Torus { .. } | Solid::Plane) {
            continue;
        }
        for _ in 0..2_000 {
            let ray = nasty_ray(&mut rng, &solid);
            // The distance is convex along the line: search for its least value.
            let speed = ray.direction.length();
            let middle = -ray.origin.dot(ray.direction) / (speed * speed);
            let reach = 4.0 * size(&solid) / speed;
            let (mut low, mut high) = (middle - reach, middle + reach);
            for _ in 0..100 {
                let (a, b) = (low + 0.4 * (high - low), low + 0.6 * (high - low));
                let depth = |t: f64| faces(&solid, at(&ray, t)).into_iter().reduce(Double::max);
                if depth(a) < depth(b) {
                    high = b;
                } else {
                    low = a;
                }
            }
            let depth = outside(&solid, at(&ray, low));
            if depth.abs() > bound(&solid, &ray) {
                let hit = !spans(&solid, &ray).is_empty();
                assert_eq!(hit, depth < 0.0, "{solid:?} {ray:?} comes to {depth:e}");
            }
        }
    }
}

#[test]
fn no_ray_gives_nan() {
    let mut rng = rng(7);
    for i in 0..1_000_000 {
        let solid = SOLIDS[i % SOLIDS.len()];
        let ray = nasty_ray(&mut rng, &solid);
        for c in crossings(&solid, &ray) {
            let numbers = !c.t.is_nan() && (c.t.is_finite() || solid == Solid::Plane);
            assert!(
                numbers && c.face < face_count(&solid),
                "{solid:?} {ray:?} {c:?}"
            );
        }
    }
}

#[test]
fn a_direction_times_a_power_of_two_divides_t_exactly() {
    let mut rng = rng(8);
    for solid in SOLIDS {
        for _ in 0..5_000 {
            let ray = nasty_ray(&mut rng, &solid);
            let scale = f64::from(rng.random_range(-30..30)).exp2();
            let scaled = Ray::new(ray.origin, scale * ray.direction);
            let (a, b) = (crossings(&solid, &ray), crossings(&solid, &scaled));
            assert_eq!(a.len(), b.len(), "{solid:?} {ray:?}");
            for (a, b) in a.iter().zip(&b) {
                assert_eq!((a.t, a.face), (b.t * scale, b.face), "{solid:?} {ray:?}");
            }
        }
    }
}

#[test]
fn turning_solid_and_ray_together_changes_nothing() {
    let mut rng = rng(9);
    for solid in SOLIDS {
        let quarter = |n: i32| DMat3::from_rotation_z(f64::from(n) * FRAC_PI_2);
        let axes = match solid {
            Solid::Sphere { .. } => DMat3::from_axis_angle(unit(&mut rng), 1.0),
            // A half turn is the only one about z that every box keeps.
            Solid::Box { .. } => quarter(2),
            Solid::Torus { .. } => DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(PI),
            _ => DMat3::from_rotation_z(rng.random_range(0.0..TAU)),
        };
        let transform = Transform::rigid(axes, DVec3::ZERO);
        for _ in 0..5_000 {
            let ray = nasty_ray(&mut rng, &solid);
            let turned = transform.inverse_ray(&ray);
            let (a, b) = (crossings(&solid, &ray), crossings(&solid, &turned));
            // Grazing rays may fall on either side, and slide as far as rounding lets them.
            let slant = |c: &Crossing| {
                let n = solid.normal(solid.project(ray.at(c.t), c.face), c.face);
                n.dot(ray.direction).abs()
            };
            let steep = |c: &&Crossing| slant(c) > 1e-3 * ray.direction.length() && c.t.is_finite();
            for c in a.iter().filter(steep) {
                let slack = 8.0 * bound(&solid, &ray) / slant(c);
                let found = b.iter().any(|d| (d.t - c.t).abs() <= slack);
                // At a rim the other face may take over.
                let p = at(&ray, c.t);
                let on = faces(&solid, p)
                    .iter()
                    .filter(|d| d.abs().high <= 1e3 * bound(&solid, &ray))
                    .count();
                assert!(found || on > 1, "{solid:?} {ray:?} {c:?} {b:?}");
            }
        }
    }
}

#[test]
fn closest_is_the_first_crossing_strictly_between_tmin_and_tmax() {
    let mut rng = rng(14);
    for solid in SOLIDS {
        for _ in 0..5_000 {
            let line = nasty_ray(&mut rng, &solid);
            let all = crossings(&solid, &line);
            let mut ends: Vec<f64> = all.iter().map(|c| c.t).filter(|t| *t >= 0.0).collect();
            ends.extend([0.0, f64::INFINITY]);
            ends.extend(all.iter().map(|c| c.t.next_down()).filter(|t| *t >= 0.0));
            for &tmin in &ends {
                for &tmax in &ends {
                    let ray = Ray { tmin, tmax, ..line };
                    let truth = all.iter().find(|c| tmin < c.t && c.t < tmax);
                    assert_eq!(
                        solid.closest(&ray).map(|(c, _)| c).as_ref(),
                        truth,
                        "{solid:?} {ray:?}"
                    );
                }
            }
        }
    }
}

/// Kernels ask no more of a solid that is behind, which would otherwise be a hole in walls.
#[test]
fn what_is_behind_is_not_met() {
    let mut rng = rng(31);
    for solid in SOLIDS {
        let (mut behind, mut met) = (0, 0);
        for _ in 0..200_000 {
            let ray = nasty_ray(&mut rng, &solid);
            // On the surface, or a few ulps and more off it.
            let face = rng.random_range(0..face_count(&solid));
            let on = solid.project(nearby(&mut rng, &solid), face);
            let off = rng.random_range(-3..=3) as f64 * f64::EPSILON * size(&solid);
            let leaving = Ray {
                origin: on + off * solid.normal(on, face),
                ..ray
            };
            for ray in [ray, leaving] {
                let closest = solid.closest(&ray);
                let is_behind = solid.is_behind(&ray);
                assert!(!is_behind || closest.is_none(), "{solid:?} {ray:?}");
                behind += u32::from(is_behind);
                met += u32::from(closest.is_some());
            }
        }
        assert!(met > 10_000);
        assert_eq!(behind > 10_000, matches!(solid, Solid::Box { .. }));
    }
}

//! The analytic solids against closed forms, brute force and arithmetic of 32 digits.

mod double;
mod oracle;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec2, DVec3};
use oracle::{
    SOLIDS, at, bound, exact, face_count, faces, nasty_ray, nearby, outside, rng, size, unit,
};
use rand::RngExt;
use solidtrace::geometry::Solid;
use solidtrace::geometry::solid::{Crossing, Span};
use solidtrace::math::{Ray, Transform};

const APEX: Solid = Solid::Cone {
    from_radius: 1.0,
    to_radius: 0.0,
    height: 2.0,
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

/// `(t, face)` of every crossing, for rays whose answer is exact.
fn hits(solid: &Solid, origin: [f64; 3], direction: [f64; 3]) -> Vec<(f64, u32)> {
    (crossings(solid, &ray(origin, direction)).iter())
        .map(|c| (c.t, c.face))
        .collect()
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
            Solid::Plane => continue,
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
        let mut worst = 0.0_f64;
        for _ in 0..40_000 {
            let ray = nasty_ray(&mut rng, &solid);
            for c in crossings(&solid, &ray).iter().filter(|c| c.t.is_finite()) {
                let p = at(&ray, c.t);
                let distances = faces(&solid, p);
                let error = distances[c.face as usize]
                    .abs()
                    .high
                    .max(outside(&solid, p));
                worst = worst.max(error / bound(&solid, &ray));
                assert!(
                    error <= bound(&solid, &ray),
                    "{solid:?} {ray:?} {c:?} is {error:e} off"
                );
            }
        }
        println!("{solid:?}: {worst} of the bound");
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
            let thin = oracle::torus_crossings(major, minor - slack, &ray);
            let thick = oracle::torus_crossings(major, minor + slack, &ray);
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
                let depth = |t: f64| {
                    faces(&solid, at(&ray, t))
                        .into_iter()
                        .reduce(double::Double::max)
                };
                if depth(a) < depth(b) {
                    high = b
                } else {
                    low = a
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
fn normals_are_the_slopes_of_the_distance() {
    let mut rng = rng(10);
    for solid in SOLIDS {
        for _ in 0..2_000 {
            let face = rng.random_range(0..face_count(&solid));
            let p = solid.project(nearby(&mut rng, &solid), face);
            let normal = solid.normal(p, face);
            assert!((normal.length() - 1.0).abs() < 4.0 * f64::EPSILON);
            // No slope at an apex.
            if p.truncate().length() < 1e-4 && matches!(solid, Solid::Cone { .. }) && face == 0 {
                continue;
            }
            let step = 1e-8 * size(&solid);
            let distance = |p: DVec3| faces(&solid, exact(p))[face as usize].high;
            let slope = DVec3::from_array(DVec3::AXES.map(|axis| {
                let (ahead, behind) = (p + step * axis, p - step * axis);
                (distance(ahead) - distance(behind)) / (ahead - behind).dot(axis)
            }));
            assert!(
                normal.distance(slope) < 1e-6,
                "{solid:?} {p} {face}: {normal} {slope}"
            );
        }
    }
}

#[test]
fn projection_lands_within_ulps_of_the_face_and_no_further_than_it_must() {
    let mut rng = rng(11);
    for solid in SOLIDS {
        let ulps = 4.0 * f64::EPSILON * size(&solid);
        for _ in 0..10_000 {
            let face = rng.random_range(0..face_count(&solid));
            let on = solid.project(nearby(&mut rng, &solid), face);
            let error = faces(&solid, exact(on))[face as usize].high.abs();
            assert!(
                error <= ulps && outside(&solid, exact(on)) <= ulps,
                "{solid:?} {on} {face}: {error:e}"
            );
            let off = 10_f64.powf(rng.random_range(-15.0..-3.0)) * size(&solid);
            let near = on + off * unit(&mut rng);
            let again = solid.project(near, face);
            assert!(
                again.distance(near) <= off + ulps,
                "{solid:?} {near} {face}: {again}"
            );
        }
    }
}

#[test]
fn surface_coordinates_stay_in_the_unit_square() {
    let mut rng = rng(12);
    for solid in SOLIDS.into_iter().filter(|&s| s != Solid::Plane) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for i in 0..20_000 {
            let mut p = nearby(&mut rng, &solid);
            p[i % 3] *= if i % 7 == 0 { -0.0 } else { 1.0 };
            let face = rng.random_range(0..face_count(&solid));
            let uv = solid.uv(solid.project(p, face), face);
            assert!(
                uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all(),
                "{solid:?} {p} {uv}"
            );
            (low, high) = (low.min(uv), high.max(uv));
        }
        // And they use all of it.
        assert!(
            low.max_element() < 0.1 && high.min_element() > 0.9,
            "{solid:?} {low} {high}"
        );
    }
}

#[test]
fn surface_coordinates_run_as_documented() {
    let uv = |solid: &Solid, p: [f64; 3], face| solid.uv(DVec3::from_array(p), face).to_array();
    let sphere = Solid::Sphere { radius: 2.0 };
    assert_eq!(uv(&sphere, [2.0, 0.0, 0.0], 0), [0.0, 0.5]);
    assert_eq!(uv(&sphere, [0.0, -2.0, 0.0], 0), [0.75, 0.5]);
    assert_eq!(uv(&sphere, [0.0, 0.0, 2.0], 0)[1], 1.0);
    let cuboid = Solid::Box {
        half: DVec3::new(1.0, 2.0, 3.0),
    };
    assert_eq!(uv(&cuboid, [1.0, 1.0, 0.0], 1), [0.75, 0.5]);
    assert_eq!(uv(&cuboid, [-1.0, 1.0, 0.0], 0), [0.25, 0.5]);
    assert_eq!(uv(&APEX, [0.0, 0.5, 1.0], 0), [0.25, 0.5]);
    assert_eq!(uv(&APEX, [-0.5, 0.0, 0.0], 1), [0.5, 0.5]);
    let torus = Solid::Torus {
        major: 2.0,
        minor: 1.0,
    };
    assert_eq!(uv(&torus, [0.0, 2.0, 1.0], 0), [0.25, 0.25]);
    assert_eq!(uv(&Solid::Plane, [7.0, -9.0, 0.0], 0), [7.0, -9.0]);
}

#[test]
fn bounds_hold_the_solid_and_touch_it_on_every_side() {
    let mut rng = rng(13);
    for solid in SOLIDS {
        let bounds = solid.bounds();
        let sides = if solid == Solid::Plane { 5..6 } else { 0..6 };
        for side in sides {
            let axis = DVec3::AXES[side % 3];
            let support = if side < 3 { bounds.min } else { bounds.max }[side % 3];
            let touch = (0..face_count(&solid)).any(|face| {
                // A torus is highest above its centre circle.
                let over = match solid {
                    Solid::Torus { major, .. } if axis == DVec3::Z => major * DVec3::X,
                    _ => DVec3::ZERO,
                };
                let middle = if bounds.is_finite() {
                    bounds.center()
                } else {
                    DVec3::ZERO
                };
                let out = if side < 3 { -1e3 } else { 1e3 };
                let far = middle + over + out * size(&solid) * axis;
                (solid.project(far, face).dot(axis) - support).abs()
                    <= 4.0 * f64::EPSILON * size(&solid)
            });
            assert!(touch, "{solid:?} side {side}");
        }
        for _ in 0..5_000 {
            let p = nearby(&mut rng, &solid);
            let held = p.cmpge(bounds.min).all() && p.cmple(bounds.max).all();
            assert!(held || !solid.contains(p), "{solid:?} {p}");
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
                    assert_eq!(solid.closest(&ray).as_ref(), truth, "{solid:?} {ray:?}");
                }
            }
        }
    }
}

#[test]
fn a_half_space_reaches_to_infinity() {
    let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
    assert_eq!(
        hits(&Solid::Plane, [1.0, 2.0, 3.0], [0.0, 1.0, -2.0]),
        [(1.5, 0), (high, 0)]
    );
    assert_eq!(
        hits(&Solid::Plane, [1.0, 2.0, -3.0], [0.0, 1.0, 2.0]),
        [(low, 0), (1.5, 0)]
    );
    assert_eq!(
        hits(&Solid::Plane, [1.0, 2.0, 0.0], [0.0, 1.0, 0.0]),
        [(low, 0), (high, 0)]
    );
    assert_eq!(hits(&Solid::Plane, [1.0, 2.0, 1e-300], [0.0, 1.0, 0.0]), []);
    assert!(
        Solid::Plane
            .closest(&ray([0.0, 0.0, -1.0], [1.0, 0.0, 0.0]))
            .is_none()
    );
}

#[test]
fn a_ray_in_the_plane_of_a_face_counts_as_inside() {
    let cuboid = Solid::Box {
        half: DVec3::new(1.0, 2.0, 3.0),
    };
    assert_eq!(
        hits(&cuboid, [1.0, -5.0, 0.0], [0.0, 1.0, 0.0]),
        [(3.0, 2), (7.0, 3)]
    );
    assert_eq!(
        hits(&cuboid, [1.0, 2.0, 5.0], [0.0, -0.0, -1.0]),
        [(2.0, 5), (8.0, 4)]
    );
    assert_eq!(
        hits(&cuboid, [1.0_f64.next_up(), -5.0, 0.0], [0.0, 1.0, 0.0]),
        []
    );
    // Across an edge in a point.
    assert_eq!(
        hits(&cuboid, [0.0, 3.0, 0.0], [1.0, -1.0, 0.0]),
        [(1.0, 3), (1.0, 1)]
    );
    let cylinder = Solid::Cylinder {
        radius: 1.0,
        height: 2.0,
    };
    for z in [0.0, 2.0] {
        assert_eq!(
            hits(&cylinder, [-3.0, 0.0, z], [1.0, 0.0, 0.0]),
            [(2.0, 0), (4.0, 0)]
        );
    }
    assert_eq!(
        hits(&cylinder, [1.0, 0.0, 5.0], [0.0, 0.0, -1.0]),
        [(3.0, 2), (5.0, 1)]
    );
    assert_eq!(
        hits(&cylinder, [0.6, 0.0, -1.0], [0.0, 0.0, 2.0]),
        [(0.5, 1), (1.5, 2)]
    );
}

#[test]
fn a_cone_has_one_nappe_and_an_apex() {
    // Through the apex into the solid, and past it where the other nappe would be.
    assert_eq!(
        hits(&APEX, [0.0, 0.0, 5.0], [0.0, 0.0, -1.0]),
        [(3.0, 0), (5.0, 1)]
    );
    assert_eq!(hits(&APEX, [-4.0, 0.0, 3.0], [1.0, 0.0, 0.0]), []);
    // Along a generator's direction inside: in by the cap, out by the side.
    let inside = hits(&APEX, [0.0, 0.0, 0.0], [-1.0, 0.0, 2.0]);
    assert_eq!(inside, [(0.0, 1), (0.5, 0)]);
    assert_eq!(hits(&APEX, [1.0, 0.0, 1.0], [-1.0, 0.0, 2.0]), []);
    // On a generator: anything even, on the surface.
    for c in crossings(&APEX, &ray([1.0, 0.0, 0.0], [-1.0, 0.0, 2.0])) {
        assert!((-1e-15..=1.0 + 1e-15).contains(&c.t));
    }
    // A hair's breadth from the apex the hit is as exact as elsewhere.
    for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
        let ray = ray([-4.0, 0.0, 2.0 - gap], [1.0, 0.0, 0.0]);
        let z = 2.0 - ray.origin.z;
        let found = crossings(&APEX, &ray);
        assert!((found[0].t - (4.0 - 0.5 * z)).abs() < 1e-15, "{found:?}");
        assert!((found[1].t - (4.0 + 0.5 * z)).abs() < 1e-15, "{found:?}");
    }
}

#[test]
fn a_torus_is_touched_by_a_span_of_no_length_or_none() {
    for minor in [0.25, 0.01] {
        let torus = Solid::Torus { major: 1.0, minor };
        let ends = |origin, direction| crossings(&torus, &ray(origin, direction));
        // In the plane that rests on it, across both points of the circle of contact.
        for c in ends([-3.0, 0.0, minor], [1.0, 0.0, 0.0]) {
            assert!((c.t - 2.0).abs().min((c.t - 4.0).abs()) < 1e-7, "{c:?}");
        }
        assert!(ends([-3.0, 0.0, minor * (1.0 + 1e-14)], [1.0, 0.0, 0.0]).is_empty());
        // A little lower: four crossings at known places.
        let drop = minor * 2_f64.powi(-40);
        let z = minor - drop;
        let half = (drop * (minor + z)).sqrt();
        let found = ends([-3.0, 0.0, z], [1.0, 0.0, 0.0]);
        let truth = [2.0 - half, 2.0 + half, 4.0 - half, 4.0 + half];
        assert_eq!(found.len(), 4);
        for (c, t) in found.iter().zip(truth) {
            assert!((c.t - t).abs() < 1e-15 / half, "{found:?} {truth:?}");
        }
        // Upright through the hole along the inner equator.
        let inner = 1.0 - minor;
        assert!(ends([inner - 1e-14, 0.0, -5.0], [0.0, 0.0, 1.0]).is_empty());
        assert_eq!(ends([inner + 1e-14, 0.0, -5.0], [0.0, 0.0, 1.0]).len(), 2);
        // Across the hole, touching the inner equator from inside the tube: one span or two that meet.
        let found = ends([inner, -5.0, 0.0], [0.0, 1.0, 0.0]);
        let half = (4.0 * minor).sqrt();
        assert!((found[0].t - (5.0 - half)).abs() < 1e-14);
        assert!((found[found.len() - 1].t - (5.0 + half)).abs() < 1e-14);
    }
}

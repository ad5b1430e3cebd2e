use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use solidtrace::accel::Kernel;
use solidtrace::check::{
    Answer, Answers, Arbiter, Checker, Claim, Meshes, Outcome, Query, Reason, Rounding, Spot,
    Verdict,
};
use solidtrace::math::{Ray, Transform};
use solidtrace::sampling::uniform_sphere;
use solidtrace::scene::Scene;

use crate::support::Build;
use crate::support::comparison::framed;
use crate::support::meshes::{box_mesh, bumpy_sphere, torus_mesh};

/// A torus as it is, sheared, and mirrored; a sphere, small.
pub fn places() -> Vec<(usize, DAffine3)> {
    let sheared = DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.7, 1.2, 0.1),
        DVec3::new(0.0, 0.4, 0.9),
    );
    let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 0.5, 1.5));
    vec![
        (0, DAffine3::IDENTITY),
        (
            0,
            DAffine3::from_mat3_translation(sheared, DVec3::new(2.0, 0.3, -0.4)),
        ),
        (
            0,
            DAffine3::from_mat3_translation(mirrored, DVec3::new(-1.0, 1.0, 0.5)),
        ),
        (1, DAffine3::from_scale(DVec3::splat(0.3))),
    ]
}

fn scene() -> Scene {
    framed(
        vec![torus_mesh(30, 20, 1.0, 0.4), bumpy_sphere(8)],
        &places(),
    )
}

fn cube() -> Scene {
    let cube = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    framed(vec![cube], &[(0, DAffine3::IDENTITY)])
}

fn rays(meshes: &Meshes, count: usize, rng: &mut Pcg64Mcg) -> Vec<Ray> {
    let mut point =
        |scale: f64| scale * uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3();
    let mut rays = Vec::new();
    for i in 0..count {
        let (mesh, place) = meshes.iter().nth(i % meshes.len()).unwrap();
        let [a, b, _] = mesh.corners((i * 7 % mesh.triangles.len()) as u32);
        let place = |p: Vec3| place.point(p.as_dvec3());
        let to = match i % 3 {
            0 => place(a),
            1 => place(a.midpoint(b)),
            _ => point(2.0),
        };
        let origin = point(5.0);
        let mut ray = Ray::new(origin, to - origin);
        if i % 4 == 0 {
            (ray.tmin, ray.tmax) = (0.9, 1.2);
        }
        if i % 5 == 0 {
            ray.direction.x = 0.0;
        }
        rays.push(ray);
    }
    rays
}

fn all(meshes: &Meshes) -> Vec<Spot> {
    let spots = meshes.iter().enumerate().flat_map(|(i, (mesh, _))| {
        (0..mesh.triangles.len() as u32).map(move |primitive| Spot {
            instance: i as u32,
            primitive,
        })
    });
    spots.collect()
}

#[test]
fn the_arbiter_finds_what_a_look_at_every_triangle_finds() {
    let scene = scene();
    let arbiter = Arbiter::new(Meshes::of(&scene));
    let spots = all(arbiter.meshes());
    assert_eq!(spots.len() as u64, arbiter.meshes().triangles());
    let mut hits = 0;
    for ray in rays(arbiter.meshes(), 6000, &mut Pcg64Mcg::seed_from_u64(1)) {
        let among_all = (spots.iter())
            .filter_map(|&spot| arbiter.meet(&ray, spot))
            .filter(|&t| t > ray.tmin && t < ray.tmax)
            .reduce(f64::min);
        let nearest = arbiter.nearest(&ray);
        assert_eq!(nearest.map(|claim| claim.t), among_all, "{ray:?}");
        hits += u32::from(nearest.is_some());
    }
    assert!(hits > 2000, "{hits}");
}

/// Moeller and Trumbore 1997 in world space: `t`, and how far inside of the edges.
fn solve(ray: &Ray, [a, b, c]: [DVec3; 3]) -> (f64, f64) {
    let across = ray.direction.cross(c - a);
    let det = (b - a).dot(across);
    let u = (ray.origin - a).dot(across) / det;
    let q = (ray.origin - a).cross(b - a);
    let v = ray.direction.dot(q) / det;
    ((c - a).dot(q) / det, u.min(v).min(1.0 - u - v))
}

#[test]
fn triangles_are_met_where_another_formula_meets_them() {
    let scene = scene();
    let arbiter = Arbiter::new(Meshes::of(&scene));
    let meshes = arbiter.meshes();
    let (mut met, mut missed) = (0, 0);
    for ray in rays(meshes, 300, &mut Pcg64Mcg::seed_from_u64(2)) {
        for spot in all(meshes) {
            let (mesh, place) = meshes.iter().nth(spot.instance as usize).unwrap();
            let corners = mesh
                .corners(spot.primitive)
                .map(|p| place.point(p.as_dvec3()));
            let (t, inside) = solve(&ray, corners);
            if let Some(own) = arbiter.meet(&ray, spot) {
                met += 1;
                assert!(inside > -1e-9, "{ray:?} {spot:?} {inside}");
                let near = (own - t).abs() < 1e-9 * t.abs();
                assert!(inside < 1e-9 || near, "{own} {t}");
            } else {
                missed += 1;
                let outside = inside.is_nan() || inside < 1e-9;
                assert!(outside, "{ray:?} {spot:?} {inside}");
            }
        }
    }
    assert!(met > 300 && missed > 10_000, "{met} {missed}");
}

/// Judged with all triangles that the true hits name.
fn judge(scene: &Scene, ray: &Ray, answer: Answer, rounding: Rounding) -> Verdict {
    let arbiter = Arbiter::new(Meshes::of(scene));
    let named = [Spot {
        instance: 0,
        primitive: 0,
    }];
    arbiter.judge(ray, &answer, &named, rounding)
}

#[test]
fn no_rounding_excuses_a_leak_through_an_edge_or_a_corner() {
    // Through a corner, an edge and a face's diagonal of the cube, along no axis.
    for target in [
        DVec3::ONE,
        DVec3::new(1.0, 1.0, 0.3),
        DVec3::new(1.0, 0.3, 0.3),
    ] {
        // Leads on into the cube, not past it.
        let ray = Ray::new(3.0 * target, -target);
        for rounding in [Rounding::F64, Rounding::F32] {
            for answer in [Answer::Closest(None), Answer::Any(false)] {
                assert_eq!(judge(&cube(), &ray, answer, rounding), Verdict::Wrong);
            }
            assert_eq!(
                judge(&cube(), &ray, Answer::Any(true), rounding),
                Verdict::Right
            );
        }
    }
}

#[test]
fn past_a_silhouette_both_answers_are_right_within_rounding_and_one_is_beyond() {
    let past = |distance: f64| Ray::new(DVec3::new(1.0 + distance, 0.2, 9.0), DVec3::NEG_Z);
    for (rounding, within, beyond) in [(Rounding::F32, 1e-6, 1e-4), (Rounding::F64, 1e-14, 1e-11)] {
        for side in [-1.0, 1.0] {
            let say = |distance: f64, blocked| {
                judge(
                    &cube(),
                    &past(side * distance),
                    Answer::Any(blocked),
                    rounding,
                )
            };
            assert_eq!(say(within, true), Verdict::Right);
            assert_eq!(say(within, false), Verdict::Right);
            let truth = side < 0.0;
            assert_eq!(say(beyond, truth), Verdict::Right);
            assert_eq!(say(beyond, !truth), Verdict::Wrong);
        }
    }
}

#[test]
fn a_hit_before_the_start_or_beyond_the_end_is_wrong() {
    let down = Ray::new(DVec3::new(0.3, 0.2, 9.0), DVec3::NEG_Z);
    for (tmin, tmax, blocked) in [(0.0, 7.9, false), (0.0, 8.1, true), (8.1, 9.9, false)] {
        let ray = Ray { tmin, tmax, ..down };
        for rounding in [Rounding::F64, Rounding::F32] {
            let say = |answer| judge(&cube(), &ray, Answer::Any(answer), rounding);
            assert_eq!(say(blocked), Verdict::Right, "{tmin} {tmax}");
            assert_eq!(say(!blocked), Verdict::Wrong, "{tmin} {tmax}");
        }
    }
}

/// The outcome of a ray onto the mirrored torus where one engine's answer is replaced.
fn planted(change: impl Fn(&mut Answers, Claim)) -> Outcome {
    let world = scene().world();
    let checker = Checker::new(&world).unwrap();
    let at = Transform::new(places()[2].1).unwrap();
    let target = at.point(DVec3::new(0.98, 0.07, 0.39));
    let ray = Ray::new(target.as_vec3().as_dvec3() + DVec3::new(0.5, 0.25, 8.0), {
        DVec3::new(-0.5, -0.25, -8.0)
    });
    let truth = checker.arbiter().nearest(&ray).expect("a hit");
    assert_eq!(truth.spot.instance, 2);
    let answer = Answer::Closest(Some(truth));
    let mut answers = Answers {
        ours: answer,
        dissent: None,
        embree: [answer; 2],
    };
    change(&mut answers, truth);
    let query = Query {
        ray,
        peer: ray,
        pixel: None,
    };
    checker.judge(&query, &answers)
}

fn other(claim: Claim, t: f64, triangles: u32) -> Answer {
    Answer::Closest(Some(Claim {
        t: claim.t * t,
        spot: Spot {
            primitive: claim.spot.primitive + triangles,
            ..claim.spot
        },
    }))
}

#[test]
fn a_planted_wrong_answer_is_found_whoever_gives_it() {
    let right = planted(|_, _| {});
    assert!(right.hit && !right.ours_wrong && right.differs == [false; 2]);
    for plant in [
        |_| Answer::Closest(None),
        |claim| other(claim, 1.001, 0),
        |claim| other(claim, 0.999, 0),
        |claim| other(claim, 1.001, 400),
    ] {
        let ours = planted(|answers, truth| answers.ours = plant(truth));
        assert!(ours.ours_wrong, "{ours:?}");
        assert_eq!((ours.differs, ours.embree_wrong), ([true; 2], [false; 2]));
        for i in 0..2 {
            let theirs = planted(|answers, truth| answers.embree[i] = plant(truth));
            assert!(!theirs.ours_wrong && theirs.embree_wrong[i], "{theirs:?}");
            assert!(!theirs.embree_wrong[1 - i], "{theirs:?}");
        }
    }
    let torn = planted(|answers, _| answers.dissent = Some(Kernel::Portable));
    assert!(torn.ours_wrong);
}

#[test]
fn what_f32_cannot_tell_is_nobodys_fault() {
    let world = cube().world();
    let checker = Checker::new(&world).unwrap();
    let outcome = |ray: Ray, theirs: Answer| {
        let ours = Answer::Closest(checker.arbiter().nearest(&ray));
        let query = Query {
            ray,
            peer: ray,
            pixel: None,
        };
        let answers = Answers {
            ours,
            dissent: None,
            embree: [ours, theirs],
        };
        checker.judge(&query, &answers)
    };
    let past = Ray::new(DVec3::new(1.0 - 1e-6, 0.2, 9.0), DVec3::NEG_Z);
    let silhouette = outcome(past, Answer::Closest(None));
    assert_eq!(silhouette.reason, Some(Reason::Edge), "{silhouette:?}");
    let start = Ray::new(DVec3::new(0.3, 0.2, 1.0 + 1e-8), DVec3::NEG_Z);
    let far_side = checker.arbiter().nearest(&Ray { tmin: 1.0, ..start });
    let skipped = outcome(start, Answer::Closest(far_side));
    assert_eq!(skipped.reason, Some(Reason::End), "{skipped:?}");
    let grazing = Ray::new(
        DVec3::new(0.0, 1.0 + 9e-7, 9.0),
        DVec3::new(0.0, -1e-7, -1.0),
    );
    let grazed = outcome(grazing, Answer::Closest(None));
    assert_eq!(grazed.reason, Some(Reason::Grazing), "{grazed:?}");
}

//! What is thin or barely touched: far away thin tori, tangents, shells.

use glam::DAffine3;
use rand::RngExt;
use solidtrace::geometry::{CsgId, Shape, Solid};
use solidtrace::math::Ray;

use super::oracle::{Leaf, Naive, Tree, rng, unit};
use super::{alternate, at, block, half_space, point, ray, rotation, sphere, times};
use crate::support::{Build, diffuse, empty_scene};

#[test]
fn a_torus_a_hundred_times_thinner_than_wide_is_exact_from_ten_thousand_away() {
    let (major, minor) = (1.0, 0.01);
    let torus = Tree::leaf(Solid::Torus { major, minor }, DAffine3::IDENTITY);
    // What is left of it, and what is left out.
    let half = block([-2.0, -2.0, -1.0], [0.0, 2.0, 1.0], DAffine3::IDENTITY);
    let rest = Tree::difference([torus.clone(), half.clone()]).build();
    let part = Tree::intersection([torus.clone(), half.clone()]).build();
    let both = Tree::union([torus, half]).build();
    let mut rng = rng(1);
    for _ in 0..20_000 {
        // In a plane through the axis its section is two circles.
        let z = rng.random_range(-0.0102..0.0102);
        let ray = ray([1e4, 0.0, z], [-1.0, 0.0, 0.0]);
        let chord = ((minor - z) * (minor + z)).max(0.0).sqrt();
        let near = [1e4 - (major + chord), 1e4 - (major - chord)];
        let far = [1e4 + (major - chord), 1e4 + (major + chord)];
        let (near, far) = if z.abs() < minor {
            (&near[..], &far[..])
        } else {
            (&[][..], &[][..])
        };
        let block = [1e4, 1e4 + 2.0];
        for (tree, truth) in [
            (&rest, near.to_vec()),
            (&part, far.to_vec()),
            (&both, [near, &block].concat()),
        ] {
            let found = tree.crossings(&ray);
            assert!(alternate(&found), "{ray:?}: {found:?}");
            // 8 ulps of the distance, seen at the angle of the tube.
            let slack = 8.0 * f64::EPSILON * 1e4 * (minor / chord.max(1e-9));
            if chord < 1e-5 {
                continue;
            }
            let close = times(&found)
                .iter()
                .zip(&truth)
                .all(|(a, b)| (a - b).abs() < slack);
            assert!(
                found.len() == truth.len() && close,
                "{ray:?}: {found:?} for {truth:?}"
            );
        }
    }
}

#[test]
fn far_rays_at_a_thin_torus_meet_it_where_the_solid_alone_is_met() {
    let mut rng = rng(2);
    for _ in 0..200 {
        let place = DAffine3::from_mat3_translation(rotation(&mut rng), point(&mut rng, 1.0));
        let torus = Leaf::new(
            Solid::Torus {
                major: 1.0,
                minor: 0.01,
            },
            place,
        );
        let tree = Tree::difference([Tree::Leaf(torus), block([0.1; 3], [1.5; 3], place)]);
        let (judged, leaves) = (tree.build(), tree.leaves());
        for _ in 0..100 {
            let rim = torus.solid.project(unit(&mut rng), 0) + point(&mut rng, 0.003);
            let origin = 1e4 * unit(&mut rng);
            let ray = Ray::new(origin, (place.transform_point3(rim) - origin).normalize());
            let naive = Naive::of(&tree, &leaves, &ray);
            let found = judged.crossings(&ray);
            assert!(
                naive.agrees(&found),
                "{ray:?}: {found:#?} for {naive:#?} of {tree:#?}"
            );
        }
    }
}

#[test]
fn rays_tangent_to_a_torus_go_in_and_out_by_turns() {
    let mut rng = rng(3);
    for minor in [0.001, 0.01, 0.3, 0.6, 0.95] {
        let solid = Solid::Torus { major: 1.0, minor };
        for _ in 0..20 {
            let place = DAffine3::from_mat3_translation(rotation(&mut rng), point(&mut rng, 3.0));
            let torus = Tree::leaf(solid, place);
            let ball = sphere(0.5, place * at(1.0, 0.0, 0.0));
            let wedge = block([-2.0, 0.0, -1.0], [0.0, 2.0, 1.0], place);
            let trees = [
                Tree::union([torus.clone()]),
                Tree::difference([torus.clone(), ball.clone()]),
                Tree::union([wedge.clone(), torus.clone()]),
                Tree::difference([Tree::intersection([torus.clone(), wedge]), ball]),
                Tree::difference([block([-3.0; 3], [3.0; 3], place), torus]),
            ]
            .map(|tree| tree.build());
            for _ in 0..100 {
                let p = solid.project(2.0 * unit(&mut rng), 0);
                let n = solid.normal(p, 0);
                let tangent = n.cross(unit(&mut rng)).normalize();
                // Nearer and nearer, to either side of it.
                let off = match rng.random_range(0..3) {
                    0 => 0.0,
                    sign => (f64::from(sign) - 1.5) * 10_f64.powf(rng.random_range(-17.0..-3.0)),
                };
                let origin = p + off * n - 6.0 * tangent;
                let ray = Ray::new(
                    place.transform_point3(origin),
                    place.transform_vector3(tangent),
                );
                for tree in &trees {
                    let found = tree.crossings(&ray);
                    assert!(alternate(&found), "{ray:?} {minor}: {found:#?}");
                    assert_eq!(tree.occluded(&ray), !found.is_empty());
                }
            }
        }
    }
}

const INNER: f64 = 1.0 - 1e-6;

fn shell(place: DAffine3) -> Tree {
    Tree::difference([sphere(1.0, place), sphere(INNER, place)])
}

#[test]
fn a_shell_a_millionth_thick_is_met_by_every_ray_as_the_closed_form_says() {
    let mut rng = rng(4);
    for _ in 0..300 {
        let center = point(&mut rng, 2.0);
        let place = DAffine3::from_mat3_translation(rotation(&mut rng), center);
        let shell = shell(place).build();
        for i in 0..200 {
            // Impact parameters anywhere, and about the inner and the outer radius.
            let near = 10_f64.powf(rng.random_range(-9.0..-5.5)) * [-1.0, 1.0][i % 2];
            let b = [
                rng.random_range(0.0..1.1),
                INNER + near,
                1.0 + near,
                INNER + 5e-7,
            ][i % 4];
            let d = unit(&mut rng);
            let (x, y) = d.any_orthonormal_pair();
            let angle = rng.random_range(0.0..6.3_f64);
            let start = center + b * (angle.cos() * x + angle.sin() * y) - 3.0 * d;
            let ray = Ray::new(start, d);
            let half = |r: f64| (r > b).then(|| ((r - b) * (r + b)).sqrt());
            let truth: Vec<f64> = match (half(1.0), half(INNER)) {
                (Some(a), Some(b)) => vec![3.0 - a, 3.0 - b, 3.0 + b, 3.0 + a],
                (Some(a), None) => vec![3.0 - a, 3.0 + a],
                _ => vec![],
            };
            let found = shell.crossings(&ray);
            assert!(alternate(&found), "{ray:?}: {found:?}");
            let close = |(a, b): (&f64, &f64)| {
                // The impact parameter is only as exact as the ray: 1e-15 of it, seen at the crossing's angle.
                (a - b).abs() * (b - 3.0).abs() < 1e-14
            };
            let same = found.len() == truth.len() && times(&found).iter().zip(&truth).all(close);
            assert!(same, "{ray:?}, {b}: {found:?} for {truth:?}");
        }
    }
}

#[test]
fn no_path_inside_a_shell_a_millionth_thick_jumps_its_wall() {
    let mut rng = rng(5);
    for i in 0..60 {
        let place = DAffine3::from_mat3_translation(
            rotation(&mut rng),
            [0.0, 2.0, 100.0][i % 3] * unit(&mut rng),
        );
        let mut scene = empty_scene();
        let material = scene.material(diffuse(0.5), 0.0);
        scene.csgs.push(shell(DAffine3::IDENTITY).csg());
        scene.place(Shape::Csg(CsgId(0)), material, place);
        let world = scene.world();
        let center = place.translation;
        // In the cavity, from wall to wall.
        let mut ray = Ray::new(center + point(&mut rng, 0.9), unit(&mut rng));
        for _ in 0..300 {
            let hit = world.intersect(&ray).expect("the wall is closed");
            let surface = world.surface(&ray, &hit);
            assert_eq!((hit.primitive, hit.inside), (1, false), "{ray:?}: {hit:?}");
            assert!((surface.p.distance(center) - INNER).abs() < 1e-12);
            // Through the wall from there, at any angle.
            let normal = -surface.ng.as_dvec3();
            let across = normal.cross(unit(&mut rng)).normalize();
            let cosine = rng.random_range(0.02..1.0_f64);
            let d = (cosine * normal + (1.0 - cosine * cosine).sqrt() * across).as_vec3();
            let through = surface.spawn(d);
            let out = world.intersect(&through).expect("the wall is solid");
            assert_eq!(
                (out.primitive, out.inside),
                (0, true),
                "{through:?}: {out:?}"
            );
            assert!(world.occluded(&through));
            // From the outer face back into the wall.
            let outer = world.surface(&through, &out);
            let back = outer.spawn(-normal.as_vec3());
            let hit = world.intersect(&back).expect("the wall is solid");
            assert_eq!((hit.primitive, hit.inside), (1, true), "{back:?}: {hit:?}");
            // And outward.
            assert!(!world.occluded(&outer.spawn(outer.ng)));
            // On across the cavity, almost along the wall too.
            let slant = 10_f64.powf(rng.random_range(-3.0..0.0));
            ray = surface.spawn((across - slant * normal).as_vec3());
        }
    }
}

#[test]
fn a_slab_between_half_spaces_is_never_too_thin_to_be_met() {
    let mut rng = rng(6);
    for exponent in 1..12 {
        let thickness = 10_f64.powi(-exponent);
        for _ in 0..100 {
            let n = unit(&mut rng);
            let slab =
                Tree::difference([half_space(n, 0.5 + thickness), half_space(n, 0.5)]).build();
            let target = point(&mut rng, 1.0);
            let p = target + (0.5 - target.dot(n)) * n;
            let d = unit(&mut rng);
            if d.dot(n).abs() < 0.05 {
                continue;
            }
            let ray = Ray::new(p - 3.0 * d, d);
            let behind = 3.0 + thickness / d.dot(n);
            let truth = [behind.min(3.0), behind.max(3.0)];
            let found = times(&slab.crossings(&ray));
            let slack = 1e-14 / d.dot(n).abs();
            let close = found.iter().zip(truth).all(|(a, b)| (a - b).abs() < slack);
            assert!(
                found.len() == 2 && close,
                "{thickness:e} {ray:?}: {found:?} for {truth:?}"
            );
        }
    }
}

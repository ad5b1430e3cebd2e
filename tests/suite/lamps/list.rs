//! Which surfaces become lights, and the choice among them.

use glam::{DVec3, Vec2, Vec3};
use solidtrace::color::Rgb;
use solidtrace::geometry::{Csg, Mesh, Operand, Shape, Solid};
use solidtrace::light::{Light, LightSampler, PointLight, SurfaceLight};
use solidtrace::math::Transform;
use solidtrace::sampling::SamplerKind;
use solidtrace::texture::{Pattern, Ramp, Texture};
use solidtrace::world::World;

use super::{SOLIDS, alone, alone_mesh, askew, canonical, mesh, sheared};
use crate::random::SplitMix;
use crate::support::meshes::box_mesh;
use crate::support::{Build, diffuse, empty_scene};

fn kinds(world: &World) -> (usize, usize) {
    let lights = world.lights().lights();
    let quads = lights
        .iter()
        .filter(|l| matches!(l, Light::Surface(SurfaceLight::Quad(_))));
    let triangles = lights
        .iter()
        .filter(|l| matches!(l, Light::Surface(SurfaceLight::Triangle(_))));
    assert_eq!(
        quads.clone().count() + triangles.clone().count(),
        lights.len()
    );
    (quads.count(), triangles.count())
}

const SQUARE: [[f32; 3]; 4] = [
    [-1.0, 0.0, -1.0],
    [1.0, 0.0, -1.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
];

#[test]
fn two_triangles_that_are_a_rectangle_are_one_light() {
    for triangles in [
        [[0, 1, 2], [0, 2, 3]],
        [[1, 2, 0], [3, 0, 2]],
        // They may face either way.
        [[0, 1, 3], [3, 1, 2]],
        [[0, 1, 3], [1, 3, 2]],
    ] {
        assert_eq!(kinds(&alone_mesh(mesh(&SQUARE, &triangles))), (1, 0));
    }
    // Rounded to f32 after a turn, it is a rectangle no longer to the last digit.
    let turned = SQUARE.map(|p| {
        let p = askew().transform_point3(Vec3::from(p).as_dvec3());
        p.as_vec3().to_array()
    });
    let halves = [[0, 1, 2], [0, 2, 3]];
    assert_eq!(kinds(&alone_mesh(mesh(&turned, &halves))), (1, 0));
    let cube = box_mesh(Vec3::NEG_ONE, Vec3::ONE);
    assert_eq!(kinds(&alone_mesh(cube)), (6, 0));
}

#[test]
fn triangles_that_are_no_rectangle_stay_two_lights() {
    let halves = [[0, 1, 2], [0, 2, 3]];
    let mut kite = SQUARE;
    kite[3] = [-1.0, 0.0, 1.2];
    let mut bent = SQUARE;
    bent[3] = [-1.0, 0.1, 1.0];
    let skewed = SQUARE.map(|[x, y, z]| [x + 0.3 * z, y, z]);
    for corners in [kite, bent, skewed] {
        assert_eq!(kinds(&alone_mesh(mesh(&corners, &halves))), (0, 2));
    }
    let folded = mesh(&SQUARE, &[[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
    // Of a repeated triangle one is left out.
    assert_eq!(kinds(&alone_mesh(folded)).1, 2);
    // Coordinates that a texture is laid over may bend along the diagonal.
    let mut scene = empty_scene();
    let lamp = scene.material(diffuse(0.0), 1.0);
    scene.materials[lamp.0 as usize].emission_texture = Some(Texture::Pattern {
        pattern: Pattern::UvChecker { step: 0.5 },
        colors: Ramp::between(Rgb::ZERO, Rgb::ONE),
    });
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, 2.0 * Vec2::Y];
    scene.mesh(
        Mesh {
            uvs: uvs.to_vec(),
            ..mesh(&SQUARE, &halves)
        },
        lamp,
    );
    assert_eq!(kinds(&scene.world()), (0, 2));
}

#[test]
fn every_bounded_solid_that_emits_is_one_light_and_planes_and_csg_are_none() {
    for (name, solid) in SOLIDS {
        for at in [askew(), sheared()] {
            assert_eq!(alone(solid, at).lights().lights().len(), 1, "{name}");
        }
    }
    assert!(alone(Solid::Plane, askew()).lights().lights().is_empty());
    let mut scene = empty_scene();
    let lamp = scene.material(diffuse(0.0), 1.0);
    let mut csg = Csg::default();
    let ball = Operand::Solid(Solid::Sphere { radius: 1.0 });
    csg.push(ball, &Transform::IDENTITY, 0..1);
    scene.csg(csg, &[lamp], askew());
    assert!(scene.world().lights().lights().is_empty());
}

#[test]
fn what_has_no_inside_is_no_operand() {
    for solid in [SOLIDS[1].1, SOLIDS[2].1] {
        let mut scene = empty_scene();
        let white = scene.material(diffuse(0.5), 0.0);
        let mut csg = Csg::default();
        csg.push(Operand::Solid(solid), &Transform::IDENTITY, 0..1);
        scene.csg(csg, &[white], askew());
        let error = World::build(scene).expect_err("it has no inside");
        assert!(error.to_string().contains("no inside"), "{error}");
    }
}

/// Closed forms of areas, and 4 times as much for a square that is scaled by 2.
#[test]
fn a_lamps_power_is_pi_times_its_area_and_sides() {
    use std::f64::consts::PI;
    let double = glam::DAffine3::from_scale(DVec3::splat(2.0));
    for (solid, area, sides) in [
        (SOLIDS[1].1, 1.6, 2.0),
        (SOLIDS[2].1, PI * 0.81, 2.0),
        (SOLIDS[3].1, 8.0 * (0.28 + 0.35 + 0.2), 1.0),
        (SOLIDS[4].1, 2.0 * PI * 0.4 * (0.4 + 1.1), 1.0),
        (SOLIDS[7].1, 4.0 * PI * PI * 0.7 * 0.3, 1.0),
    ] {
        let world = alone(solid, double);
        let power = world.lights().lights()[0].power();
        let expected = 3.0 * sides * PI * 4.0 * area;
        assert!((power / expected - 1.0).abs() < 1e-5, "{solid:?}: {power}");
    }
    // A disk stretched along one axis.
    let wide = glam::DAffine3::from_scale(DVec3::new(3.0, 1.0, 1.0));
    let power = alone(SOLIDS[2].1, wide).lights().lights()[0].power();
    let expected = 3.0 * 2.0 * PI * PI * 0.81 * 3.0;
    assert!((power / expected - 1.0).abs() < 1e-5, "{power}");
}

#[test]
fn the_power_of_a_textured_lamp_is_that_of_its_mean() {
    let mut scene = empty_scene();
    let lamp = scene.material(diffuse(0.0), 2.0);
    scene.materials[lamp.0 as usize].emission_texture = Some(Texture::Pattern {
        pattern: Pattern::UvChecker { step: 0.5 },
        colors: Ramp::between(Rgb::ZERO, Rgb::splat(3.0)),
    });
    scene.place(Shape::Solid(SOLIDS[1].1), lamp, askew());
    let world = scene.world();
    let plain = alone(SOLIDS[1].1, askew());
    let [textured, plain] = [&world, &plain].map(|world| world.lights().lights()[0].power());
    assert!((textured / plain - 3.0).abs() < 1e-5, "{textured} {plain}");
}

#[test]
fn of_ten_thousand_lights_each_is_chosen_in_proportion_to_its_power() {
    let mut rng = SplitMix(3);
    let mut unit = || (rng.next() >> 40) as f32 / 16_777_216.0;
    let lights: Vec<Light> = (0..10_000)
        .map(|_| {
            let position = Vec3::new(unit(), unit(), unit()).as_dvec3() * 4.0;
            Light::Point(PointLight {
                position,
                intensity: Rgb::splat(0.01 + unit().powi(4)),
                cone: None,
            })
        })
        .collect();
    let from = DVec3::new(-3.0, -2.0, -5.0);
    let exact: f64 = (lights.iter())
        .filter_map(|light| light.sample(from, Vec2::ZERO))
        .map(|sample| f64::from(sample.li.x))
        .sum();
    let sampler = LightSampler::new(lights);
    let total: f64 = sampler.lights().iter().map(Light::power).sum();
    let count = 1 << 18;
    let mut sum = 0.0;
    let mut counts = vec![0.0; 10_000];
    for i in 0..count {
        let (pick, u2) = canonical(SamplerKind::Sobol, 9, i);
        let (light, sample) = sampler.sample(from, pick, u2).unwrap();
        sum += f64::from(sample.li.x);
        counts[light as usize] += 1.0;
    }
    let mean = sum / f64::from(count);
    assert!((mean / exact - 1.0).abs() < 0.002, "{mean} for {exact}");
    for (light, found) in sampler.lights().iter().zip(counts) {
        let expected = light.power() / total * f64::from(count);
        // Of 65,536 of Sobol's points as many as belong fall into any interval, to within one at either end.
        assert!((found - expected).abs() < 8.0, "{found} for {expected}");
    }
}

//! Light on CSG objects where its amount is known: nothing leaks, nothing shades itself.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::geometry::{Csg, CsgOp, Operand, Solid};
use solidtrace::material::{MaterialId, Surface};
use solidtrace::math::Transform;
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::Texture;

use crate::support::{Build, Shot, camera, diffuse, empty_scene, shoot};

/// Paths end by chance alone.
const ENDLESS: IntegratorSettings = IntegratorSettings::Path {
    max_depth: None,
    russian_roulette: true,
};

fn push(csg: &mut Csg, solid: Solid, at: DVec3) {
    let place = Transform::new(DAffine3::from_translation(at)).unwrap();
    csg.push(Operand::Solid(solid), &place, 0..1);
}

fn cube(half: f64) -> Solid {
    Solid::Box {
        half: DVec3::splat(half),
    }
}

/// A hollow cube with a pillar, a niche and a round alcove cut into the walls.
fn room() -> Csg {
    let mut csg = Csg::default();
    push(&mut csg, cube(5.0), DVec3::ZERO);
    push(&mut csg, cube(4.0), DVec3::ZERO);
    let pillar = Solid::Cylinder {
        radius: 0.6,
        height: 10.0,
    };
    push(&mut csg, pillar, DVec3::new(-2.0, -2.0, -5.0));
    csg.combine(CsgOp::Difference, 2);
    push(&mut csg, cube(0.8), DVec3::new(4.0, 0.5, -1.0));
    push(
        &mut csg,
        Solid::Sphere { radius: 1.2 },
        DVec3::new(0.0, -3.5, -3.0),
    );
    csg.combine(CsgOp::Difference, 4);
    csg
}

/// A die with round corners, a bore and dimples.
fn die() -> Csg {
    let mut csg = Csg::default();
    push(&mut csg, cube(0.8), DVec3::ZERO);
    push(&mut csg, Solid::Sphere { radius: 1.1 }, DVec3::ZERO);
    csg.combine(CsgOp::Intersection, 2);
    let bore = Solid::Cylinder {
        radius: 0.3,
        height: 4.0,
    };
    push(&mut csg, bore, DVec3::new(0.0, 0.0, -2.0));
    for x in [-0.4, 0.4] {
        push(
            &mut csg,
            Solid::Sphere { radius: 0.25 },
            DVec3::new(x, 0.8, x),
        );
    }
    let ring = Solid::Torus {
        major: 0.5,
        minor: 0.12,
    };
    push(&mut csg, ring, DVec3::new(0.0, 0.0, 0.8));
    csg.combine(CsgOp::Difference, 5);
    csg
}

/// The room with a white, a mirror and a glass die in it; its walls have `albedo` and `emission`.
fn furnished(albedo: f32, emission: f32, environment: f32) -> Scene {
    let mut scene = empty_scene();
    scene.environment = Rgb::splat(environment);
    scene.integrator = ENDLESS;
    scene.cameras = vec![camera(
        DVec3::new(0.2, 0.3, 3.4),
        DVec3::new(0.0, 0.0, -1.0),
    )];
    scene.cameras[0].projection = Projection::pinhole(75_f64.to_radians());
    scene.film.size = (12, 12);
    let wall = scene.material(diffuse(albedo), emission);
    scene.csg(room(), &[wall], DAffine3::IDENTITY);
    let white = Texture::Constant(Rgb::ONE);
    let surfaces = [
        diffuse(1.0),
        Surface::Mirror { color: white },
        Surface::glass(1.5),
    ];
    for (i, surface) in surfaces.into_iter().enumerate() {
        let material = scene.material(surface, 0.0);
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.7 * i as f64);
        let at = DVec3::new(2.0 * i as f64 - 2.0, 0.2 * i as f64, -1.5);
        scene.csg(
            die(),
            &[material],
            DAffine3::from_mat3_translation(turn, at),
        );
    }
    scene
}

fn shot(spp: u32) -> Shot {
    Shot {
        spp,
        sampler: SamplerKind::Sobol,
        seed: 3,
    }
}

#[test]
fn no_light_leaks_into_a_closed_room() {
    // Bright outside, dark inside: a single ray that slips through a wall would show.
    let world = furnished(0.7, 0.0, 1e6).world();
    for (i, pixel) in shoot(&world, shot(1024)).iter().enumerate() {
        assert_eq!(*pixel, Rgb::ZERO, "pixel {i}");
    }
}

#[test]
fn in_a_closed_glowing_room_everything_is_as_bright() {
    // Emission 1/2 and albedo 1/2 sum to radiance 1 everywhere; whatever shades itself would be darker.
    // Every path gathers 1/2 + 1/4 + ..., so there is no noise to hide behind; but glass may keep one to its end.
    let mut scene = furnished(0.5, 0.5, 0.0);
    scene.integrator = IntegratorSettings::Path {
        max_depth: Some(80),
        russian_roulette: false,
    };
    let world = scene.world();
    for (i, pixel) in shoot(&world, shot(1024)).iter().enumerate() {
        assert!(
            (*pixel - Rgb::ONE).abs().max_element() < 1e-3,
            "pixel {i}: {pixel}"
        );
    }
}

#[test]
fn a_lit_box_has_no_shadow_bands() {
    // A cube from six half-spaces, one from three slabs, one as a difference, each under a light near its top: the
    // radiance at each pixel is albedo / pi * I cos / d^2, whatever the distance.
    let mut half_spaces = Csg::default();
    for axis in DVec3::AXES {
        for n in [axis, -axis] {
            let (x, y) = n.any_orthonormal_pair();
            let place = Transform::rigid(DMat3::from_cols(x, y, n), n);
            half_spaces.push(Operand::Solid(Solid::Plane), &place, 0..1);
        }
    }
    half_spaces.combine(CsgOp::Intersection, 6);
    let mut slabs = Csg::default();
    for axis in DVec3::AXES {
        let half = DVec3::splat(9.0) - 8.0 * axis;
        push(&mut slabs, Solid::Box { half }, DVec3::ZERO);
    }
    slabs.combine(CsgOp::Intersection, 3);
    let mut difference = Csg::default();
    push(&mut difference, cube(3.0), DVec3::new(0.0, -2.0, 0.0));
    for sign in [-1.0, 1.0] {
        for axis in [DVec3::X, DVec3::Z] {
            push(&mut difference, cube(3.0), sign * 4.0 * axis);
        }
    }
    difference.combine(CsgOp::Difference, 5);
    for csg in [half_spaces, slabs, difference] {
        let mut scene = empty_scene();
        let light = DVec3::new(0.7, 1.05, -0.2);
        scene.point_light(light, 1.0);
        scene.cameras = vec![camera(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO)];
        scene.film.size = (64, 64);
        scene.integrator = IntegratorSettings::Path {
            max_depth: Some(1),
            russian_roulette: false,
        };
        let matt = scene.material(diffuse(0.6), 0.0);
        scene.csg(csg, &[matt], DAffine3::IDENTITY);
        let world = scene.world();
        let lens = world.scene().cameras[0].lens((64, 64)).unwrap();
        for (i, pixel) in shoot(&world, shot(256)).iter().enumerate() {
            // The mean over the pixel, by a grid of points of its own.
            let mut truth = 0.0;
            for j in 0..256 {
                let (x, y) = (i % 64, i / 64);
                let (u, v) = (
                    (f64::from(j % 16) + 0.5) / 16.0,
                    (f64::from(j / 16) + 0.5) / 16.0,
                );
                let ray = lens.ray(x as f64 + u, y as f64 + v, glam::Vec2::ZERO);
                let p = ray.at((1.0 - ray.origin.y) / ray.direction.y);
                let d = light - p;
                truth += 0.6 / PI * d.y / d.length().powi(3) / 256.0;
            }
            let relative = f64::from(pixel.x) / truth - 1.0;
            assert!(
                relative.abs() < 0.02,
                "pixel {i}: {} against {truth}",
                pixel.x
            );
        }
    }
}

#[test]
fn shells_of_any_thickness_hold_light() {
    // The walls of nested glowing shells, down to a thickness of 1e-11, hide what is behind them.
    for thickness in [1e-1, 1e-3, 1e-6, 1e-9, 1e-11] {
        let mut csg = Csg::default();
        push(&mut csg, Solid::Sphere { radius: 1.0 }, DVec3::ZERO);
        let inner = Solid::Sphere {
            radius: 1.0 - thickness,
        };
        push(&mut csg, inner, DVec3::ZERO);
        csg.combine(CsgOp::Difference, 2);
        let mut scene = empty_scene();
        scene.environment = Rgb::splat(1e6);
        scene.integrator = ENDLESS;
        let dark: MaterialId = scene.material(diffuse(0.8), 0.0);
        scene.csg(csg, &[dark], DAffine3::from_translation(DVec3::splat(0.1)));
        for (i, pixel) in shoot(&scene.world(), shot(256)).iter().enumerate() {
            assert_eq!(*pixel, Rgb::ZERO, "thickness {thickness}, pixel {i}");
        }
    }
}

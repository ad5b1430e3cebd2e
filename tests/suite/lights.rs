//! Light sources against closed forms, and light sampling against plain path tracing.

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3};
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::geometry::{Mesh, Shape, Solid};
use solidtrace::integrator::{CameraRay, Integrator};
use solidtrace::material::Surface;
use solidtrace::sampling::{SamplerKind, uniform_sphere};
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::world::World;

use crate::support::{
    Build, SAMPLERS, Shot, camera, diffuse, empty_scene, shoot, shoot_with, statistics,
};

/// A white floor at y = 0, seen at `x` through a pinhole so narrow that a picture is one point.
pub fn floor(x: f64) -> Scene {
    let mut scene = empty_scene();
    scene.film.size = (2, 2);
    let target = DVec3::new(x, 0.0, 0.0);
    let mut camera = camera(target + DVec3::new(3.0, 1.0, 4.0), target);
    camera.projection = Projection::pinhole(1e-6);
    scene.cameras = vec![camera];
    scene.integrator = IntegratorSettings::Path {
        max_depth: Some(1),
        russian_roulette: false,
    };
    let white = scene.material(diffuse(1.0), 0.0);
    let up = glam::DAffine3::from_axis_angle(DVec3::X, -PI / 2.0);
    scene.place(Shape::Solid(Solid::Plane), white, up);
    scene
}

/// A white floor shows irradiance over pi.
pub fn assert_irradiance(scene: Scene, expected: f64, what: &str) {
    let world = scene.world();
    for sampler in SAMPLERS {
        let pixels = shoot(
            &world,
            Shot {
                spp: 1 << 14,
                sampler,
                seed: 7,
            },
        );
        let mean = pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / pixels.len() as f64;
        let ratio = mean * PI / expected;
        assert!(
            (ratio - 1.0).abs() < 0.005,
            "{what}, {sampler:?}: {ratio} of the closed form"
        );
    }
}

#[test]
fn irradiance_under_a_point_light_is_intensity_cos_over_distance_squared() {
    for x in [0.0, 1.5, 6.0] {
        let mut scene = floor(x);
        scene.point_light(DVec3::new(0.0, 2.0, 0.0), 5.0);
        let d2 = 4.0 + x * x;
        assert_irradiance(scene, 5.0 * (2.0 / d2.sqrt()) / d2, &format!("x = {x}"));
    }
}

#[test]
fn irradiance_under_a_sphere_light_is_pi_radiance_times_its_share() {
    for (x, radius) in [(0.0, 1.0), (1.5, 1.0), (6.0, 0.5), (0.5, 1.9)] {
        let mut scene = floor(x);
        let lamp = scene.material(diffuse(0.0), 3.0);
        scene.solid(Solid::Sphere { radius }, lamp, DVec3::new(0.0, 2.0, 0.0));
        let d2: f64 = 4.0 + x * x;
        let expected = PI * 3.0 * radius * radius / d2 * (2.0 / d2.sqrt());
        assert_irradiance(scene, expected, &format!("x = {x}, radius {radius}"));
    }
}

/// From a point to a parallel rectangle with a corner straight above it (the classic view factor,
/// Howell's catalogue B-3), `a` and `b` the sides over the height.
fn corner_factor(a: f64, b: f64) -> f64 {
    let part = |a: f64, b: f64| {
        let s = (1.0 + a * a).sqrt();
        a / s * (b / s).atan()
    };
    (part(a, b) + part(b, a)) / (2.0 * PI)
}

#[test]
fn irradiance_under_a_rectangle_is_pi_radiance_times_the_view_factor() {
    // The rectangle spans x in -1..2 and z in -0.5..1.5 at height 1.2.
    let (h, z0, z1) = (1.2, 0.5, 1.5);
    for x in [-0.5, 0.0, 1.0] {
        let mut scene = floor(x);
        let lamp = scene.material(diffuse(0.0), 2.0);
        let corner = |x: f32, z: f32| Vec3::new(x, 1.2, z);
        let mesh = Mesh {
            positions: vec![
                corner(-1.0, -0.5),
                corner(2.0, -0.5),
                corner(2.0, 1.5),
                corner(-1.0, 1.5),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        scene.mesh(mesh, lamp);
        let factor: f64 = [1.0 + x, 2.0 - x]
            .into_iter()
            .flat_map(|a| [z0, z1].map(|b| corner_factor(a / h, b / h)))
            .sum();
        // The camera sits beyond the edge of the lamp and sees the floor under it.
        scene.cameras[0].eye = DVec3::new(x, 0.5, 6.0);
        assert_irradiance(scene, PI * 2.0 * factor, &format!("x = {x}"));
    }
}

/// Path tracing that draws every direction uniformly from the hemisphere and aims at no light: an
/// independent and obviously correct estimator, if a noisy one. Diffuse surfaces only.
struct UniformHemisphere {
    max_depth: u32,
}

impl Integrator for UniformHemisphere {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        for (camera, out) in batch.iter().zip(radiance) {
            let (mut ray, mut beta) = (camera.ray, Rgb::ONE);
            *out = Rgb::ZERO;
            for depth in 0..=self.max_depth {
                let Some(hit) = world.intersect(&ray) else {
                    *out += beta * world.beyond(ray.direction, |_| 1.0);
                    break;
                };
                let point = world.surface(&ray, &hit);
                *out += beta * world.material(&point).emission;
                let Surface::Diffuse { color } = &world.material(&point).surface else {
                    panic!("diffuse surfaces only");
                };
                let wo = -ray.direction.as_vec3();
                let n = if wo.dot(point.ng) < 0.0 {
                    -point.ng
                } else {
                    point.ng
                };
                let [u, v, ..] = camera.sampler.set(depth + 1);
                let d = uniform_sphere(Vec2::new(u, v));
                let wi = if d.dot(n) < 0.0 { -d } else { d };
                // (albedo / pi) cos / (1 / 2 pi)
                beta *= color.eval(&point.texture) * 2.0 * wi.dot(n);
                ray = point.spawn(wi);
            }
        }
        0
    }
}

/// The report's room: a sphere of radius 10 between six planes, lit by a sphere of radius 3 above.
fn room() -> Scene {
    let mut scene = empty_scene();
    scene.film.size = (12, 12);
    let mut camera = camera(DVec3::new(0.0, 0.0, 55.0), DVec3::ZERO);
    camera.projection = Projection::pinhole(60_f64.to_radians());
    scene.cameras = vec![camera];
    let white = scene.material(diffuse(0.7), 0.0);
    let lamp = scene.material(diffuse(0.0), 20.0);
    scene.solid(Solid::Sphere { radius: 10.0 }, white, DVec3::ZERO);
    scene.solid(
        Solid::Sphere { radius: 3.0 },
        lamp,
        DVec3::new(-10.0, 20.0, 40.0),
    );
    scene.solid(
        Solid::Box {
            half: DVec3::new(40.0, 25.0, 60.0),
        },
        white,
        DVec3::new(0.0, 15.0, 0.0),
    );
    scene
}

#[test]
fn a_sphere_light_has_a_twentieth_of_the_variance_of_hemisphere_sampling_and_its_mean() {
    let depth = 5;
    let mut scene = room();
    scene.integrator = IntegratorSettings::Path {
        max_depth: Some(depth),
        russian_roulette: false,
    };
    let world = scene.world();
    let runs = 24;
    let renders = |plain: bool| -> Vec<Vec<Rgb>> {
        (0..runs)
            .map(|run| {
                let shot = Shot {
                    spp: 64,
                    sampler: SamplerKind::Independent,
                    seed: 100 + run + if plain { 1000 } else { 0 },
                };
                if plain {
                    shoot_with(&world, &UniformHemisphere { max_depth: depth }, shot)
                } else {
                    shoot(&world, shot)
                }
            })
            .collect()
    };
    let of_pixels = |renders: &[Vec<Rgb>]| {
        let pixels = renders[0].len();
        let (mut mean, mut variance) = (0.0, 0.0);
        for i in 0..pixels {
            let values: Vec<f64> = renders.iter().map(|r| f64::from(r[i].x)).collect();
            let (m, s) = statistics(&values);
            mean += m / pixels as f64;
            variance += s * s / pixels as f64;
        }
        (mean, variance)
    };
    let (mean, variance) = of_pixels(&renders(false));
    let (plain_mean, plain_variance) = of_pixels(&renders(true));
    println!(
        "variance {variance:.3e} against {plain_variance:.3e}: 1/{:.0}",
        plain_variance / variance
    );
    assert!(variance < plain_variance / 20.0);
    let error = ((variance + plain_variance) / (runs as f64 * 144.0)).sqrt();
    assert!(
        (mean - plain_mean).abs() < 4.0 * error,
        "{mean} against {plain_mean} ± {error}"
    );
}

#[test]
fn a_lamp_sheds_no_light_on_itself_unless_it_is_bent() {
    let shot = Shot {
        spp: 16,
        sampler: SamplerKind::Independent,
        seed: 1,
    };
    for solid in [
        Solid::Sphere { radius: 1.0 },
        Solid::Box { half: DVec3::ONE },
        Solid::Cylinder {
            radius: 1.0,
            height: 1.0,
        },
        Solid::Disk { radius: 1.0 },
    ] {
        for stretch in [1.0, 1.5] {
            let mut scene = empty_scene();
            scene.cameras = vec![camera(DVec3::new(0.5, 0.4, 6.0), DVec3::ZERO)];
            let lamp = scene.material(diffuse(0.9), 2.0);
            let turn = glam::DMat3::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), 0.5);
            let scale = glam::DMat3::from_diagonal(DVec3::new(stretch, 1.0, 1.0));
            let shape = Shape::Solid(solid);
            scene.place(shape, lamp, glam::DAffine3::from_mat3(turn * scale));
            for pixel in shoot(&scene.world(), shot) {
                assert!(pixel.x <= 2.0001, "{solid:?} by {stretch}: {pixel}");
            }
        }
    }
}

//! Light sources against closed forms, and light sampling against plain path tracing.

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3};
use solidtrace::bsdf::Bsdf;
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::geometry::{Mesh, Shape, Solid};
use solidtrace::integrator::{CameraRay, Integrator};
use solidtrace::material::{Fresnel, Metal, Principled, Surface};
use solidtrace::sampling::{SamplerKind, uniform_sphere};
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::Texture;
use solidtrace::world::{Media, SurfacePoint, World};

use crate::lamps::showroom;
use crate::support::meshes::{box_mesh, moved, sphere_mesh};
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

/// Glass, a mirror, emitting meshes and spheres, an environment: everything at once.
pub fn mixed() -> Scene {
    let mut scene = empty_scene();
    scene.film.size = (10, 10);
    scene.cameras = vec![camera(DVec3::new(0.0, 1.5, 6.0), DVec3::new(0.0, 0.8, 0.0))];
    scene.environment = Rgb::new(0.1, 0.2, 0.3);
    let white = scene.material(diffuse(0.8), 0.0);
    let lamp = scene.material(diffuse(0.3), 4.0);
    let glass = scene.material(Surface::glass(1.5), 0.0);
    let mirror = scene.material(
        Surface::Mirror {
            color: Texture::Constant(Rgb::splat(0.9)),
        },
        0.0,
    );
    scene.solid(
        Solid::Box {
            half: DVec3::new(5.0, 0.5, 5.0),
        },
        white,
        DVec3::NEG_Y * 0.5,
    );
    scene.solid(
        Solid::Sphere { radius: 0.7 },
        mirror,
        DVec3::new(-1.4, 0.7, 0.0),
    );
    scene.solid(
        Solid::Sphere { radius: 0.6 },
        glass,
        DVec3::new(0.2, 0.6, 1.0),
    );
    scene.solid(
        Solid::Sphere { radius: 0.4 },
        lamp,
        DVec3::new(1.6, 1.2, -0.5),
    );
    // Few faces under smooth normals: both strategies must fold directions back alike.
    let mut bent = moved(sphere_mesh(5, |_| 1.0), 0.5, Vec3::new(-0.4, 0.5, 2.0));
    bent.normals = sphere_mesh(5, |_| 1.0).positions;
    scene.mesh(bent, white);
    scene.mesh(
        box_mesh(Vec3::new(-0.5, 2.4, -0.5), Vec3::new(0.8, 2.5, 0.6)),
        lamp,
    );
    scene
}

/// The path integrator with one of its two ways of sampling alone.
pub enum OneWay {
    /// Rays find the lights by themselves.
    Bsdf,
    /// But for what the camera sees, lamps that are come upon do not count.
    Light,
}

impl Integrator for OneWay {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        for (camera, out) in batch.iter().zip(radiance) {
            let (mut ray, mut beta) = (camera.ray, Rgb::ONE);
            *out = Rgb::ZERO;
            for depth in 0..12 {
                let counts = depth == 0 || matches!(self, Self::Bsdf);
                let Some(hit) = world.intersect(&ray) else {
                    *out += beta * world.beyond(ray.direction, |_| f32::from(counts));
                    break;
                };
                let point = world.surface(&ray, &hit);
                if counts {
                    *out += beta * world.material(&point).emitted(&point.texture);
                }
                let bsdf = world.bsdf(&point, &Media::default());
                let wo = -ray.direction.as_vec3();
                if matches!(self, Self::Light) && depth < 11 {
                    let [pick, u, v, _] = camera.sampler.set(2 * depth + 2);
                    *out += beta * aimed(world, &point, &bsdf, wo, pick, Vec2::new(u, v));
                }
                let [pick, u, v, _] = camera.sampler.set(2 * depth + 1);
                let Some(sample) = bsdf.sample(wo, pick, Vec2::new(u, v)) else {
                    break;
                };
                beta *= sample.weight;
                ray = point.spawn(sample.wi);
            }
        }
        0
    }
}

/// Light from one sample of the lights, without a weight.
fn aimed(world: &World, point: &SurfacePoint, bsdf: &Bsdf, wo: Vec3, pick: f32, u2: Vec2) -> Rgb {
    let Some(light) = world.sample_light(point.p, pick, u2) else {
        return Rgb::ZERO;
    };
    let (wi, _) = light.source.seen_from(point.p).unwrap();
    let f_cos = bsdf.eval(wo, wi).0;
    if f_cos == Rgb::ZERO || world.occluded(&point.towards(light.source)) {
        return Rgb::ZERO;
    }
    f_cos * light.li / light.divisor()
}

/// Checks that the path integrator renders the scene as [`OneWay::Bsdf`] does.
pub fn assert_agreement(scene: Scene) {
    assert_agreement_with(scene, &OneWay::Bsdf);
}

/// Checks that the path integrator renders the scene as the `other` does.
fn assert_agreement_with(mut scene: Scene, other: &dyn Integrator) {
    scene.integrator = IntegratorSettings::Path {
        max_depth: Some(11),
        russian_roulette: true,
    };
    let world = scene.world();
    let shots = |plain: bool| -> Vec<Vec<Rgb>> {
        (0..16)
            .map(|seed| {
                let shot = Shot {
                    spp: 256,
                    sampler: SamplerKind::Independent,
                    seed,
                };
                if plain {
                    shoot_with(&world, other, shot)
                } else {
                    shoot(&world, shot)
                }
            })
            .collect()
    };
    let (ours, plain) = (shots(false), shots(true));
    let (mut squares, mut count) = (0.0, 0.0);
    for i in 0..ours[0].len() {
        for channel in 0..3 {
            let values = |renders: &[Vec<Rgb>]| -> Vec<f64> {
                renders.iter().map(|r| f64::from(r[i][channel])).collect()
            };
            let ((m, s), (pm, ps)) = (statistics(&values(&ours)), statistics(&values(&plain)));
            let error = ((s * s + ps * ps) / 16.0).sqrt();
            // A pixel that sees nothing but the sky is the same in every run.
            if error == 0.0 {
                assert_eq!(m, pm);
                continue;
            }
            count += 1.0;
            squares += ((m - pm) / error).powi(2);
        }
    }
    // Squared deviations in units of their error have mean 1; channels share their noise, and an error
    // that is itself estimated from 16 runs adds a little. A bias of half an error would give 1.25.
    let mean = squares / count;
    println!("mean squared deviation {mean:.3} of {count} values");
    assert!(count > 150.0 && mean < 1.35, "{mean}");
}

#[test]
fn light_sampling_agrees_with_paths_that_find_the_lights_by_themselves() {
    assert_agreement(mixed());
}

#[test]
fn light_sampling_agrees_on_rough_and_layered_surfaces() {
    let color = |r, g, b| Texture::Constant(Rgb::new(r, g, b));
    let mut scene = mixed();
    // In place of white, the lamp, glass and the mirror.
    let metal = Metal::named("copper").unwrap();
    let coated = Principled {
        metallic: 0.3.into(),
        roughness: 0.5.into(),
        clearcoat: 1.0.into(),
        sheen_color: color(0.3, 0.5, 0.3),
        sheen_roughness: 0.5.into(),
        ..Principled::new(color(0.7, 0.3, 0.2))
    };
    let surfaces = [
        Surface::Principled(Box::new(coated)),
        Surface::Plastic {
            color: color(0.3, 0.3, 0.3),
            ior: 1.5,
            roughness: 0.5.into(),
        },
        Surface::Dielectric {
            ior: 1.5,
            fresnel: Fresnel::Exact,
            roughness: 0.5.into(),
            absorption: Rgb::ZERO,
        },
        Surface::Mix {
            a: Box::new(Surface::Conductor {
                metal,
                roughness: 0.4.into(),
            }),
            b: Box::new(diffuse(0.5)),
            weight: 0.5.into(),
        },
    ];
    for (material, surface) in scene.materials.iter_mut().zip(surfaces) {
        material.surface = surface;
    }
    assert_agreement(scene);
}

#[test]
fn lamps_of_all_kinds_give_the_same_picture_by_either_way_of_sampling_alone_and_by_both() {
    assert_agreement_with(showroom(), &OneWay::Bsdf);
    assert_agreement_with(showroom(), &OneWay::Light);
}

#[test]
fn lamps_of_frosted_glass_are_seen_from_inside_as_well() {
    let mut scene = showroom();
    for material in &mut scene.materials {
        if material.emission != Rgb::ZERO {
            material.surface = Surface::Dielectric {
                ior: 1.3,
                fresnel: Fresnel::Exact,
                roughness: 0.6.into(),
                absorption: Rgb::ZERO,
            };
        }
    }
    // Of two dimensions there is no inside.
    scene.instances.retain(|instance| {
        !matches!(
            instance.shape,
            Shape::Solid(Solid::Rectangle { .. } | Solid::Disk { .. }) | Shape::Mesh(_)
        )
    });
    scene.cameras[0].projection = Projection::pinhole(0.5);
    assert_agreement(scene);
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

//! Aiming at lights, coming upon them and both give the same picture.

use glam::{DVec3, Vec2, Vec3};
use solidtrace::bsdf::Bsdf;
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::geometry::{Shape, Solid};
use solidtrace::integrator::{CameraRay, Integrator};
use solidtrace::material::{Fresnel, Metal, Principled, Surface};
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::Texture;
use solidtrace::world::{Media, SurfacePoint, World};

use crate::lamps::showroom;
use crate::support::meshes::{box_mesh, moved, sphere_mesh};
use crate::support::{Build, Shot, camera, diffuse, empty_scene, shoot, shoot_with, statistics};

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

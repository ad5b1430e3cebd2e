//! Layers of one render: they add up, and each holds what its name says.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use solidtrace::ErrorKind;
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::geometry::Solid;
use solidtrace::image::{Channel, Image};
use solidtrace::integrator::{LayerKind, integrator, layered_integrator};
use solidtrace::io::{Precision, decode_exr, encode_exr};
use solidtrace::material::{Fresnel, Surface};
use solidtrace::render::{RenderSettings, render};
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::Texture;
use solidtrace::world::World;

use crate::support::meshes::{box_mesh, moved};
use crate::support::{Build, camera, dielectric, diffuse, empty_scene};

const LIGHT: [LayerKind; 2] = [LayerKind::Bounces, LayerKind::Strategies];
const FEATURES: [LayerKind; 3] = [LayerKind::Albedo, LayerKind::Normal, LayerKind::Depth];

fn picture(world: &World, kinds: &[LayerKind], settings: &RenderSettings) -> Image {
    let scene = world.scene();
    let integrator = layered_integrator(&scene.integrator, kinds).unwrap();
    let lens = scene.cameras[0].lens(settings.size).unwrap();
    let rendered = render(world, &lens, integrator.as_ref(), settings, &()).unwrap();
    assert_eq!(rendered.bad, []);
    rendered.to_image()
}

fn shoot(world: &World, kinds: &[LayerKind]) -> Image {
    picture(world, kinds, &RenderSettings::of(world.scene()))
}

/// One layer as colours.
fn layer(image: &Image, name: &str) -> Vec<Rgb> {
    let dot = if name.is_empty() { "" } else { "." };
    let [r, g, b] = ["R", "G", "B"].map(|c| image.channel(&format!("{name}{dot}{c}")).unwrap());
    (0..r.len()).map(|i| Rgb::new(r[i], g[i], b[i])).collect()
}

/// Layers whose names start with `prefix`, in all.
fn count(image: &Image, prefix: &str) -> usize {
    let named = |c: &&Channel| c.name.starts_with(prefix);
    image.channels.iter().filter(named).count() / 3
}

fn direct() -> IntegratorSettings {
    IntegratorSettings::Direct { max_depth: 8 }
}

/// Everything that light can meet: lights of all kinds, an environment, glass, a mirror, gloss over matt.
fn varied() -> Scene {
    let mut scene = empty_scene();
    scene.film.size = (33, 21);
    scene.environment = Rgb::new(0.1, 0.2, 0.4);
    scene.cameras = vec![camera(DVec3::new(0.0, 1.5, 5.0), DVec3::new(0.0, 0.3, 0.0))];
    let white = scene.material(diffuse(0.8), 0.0);
    let lamp = scene.material(diffuse(0.3), 7.0);
    let glass = scene.material(dielectric(1.5, Fresnel::Exact), 0.0);
    let mirror = Surface::Mirror {
        color: Texture::Constant(Rgb::new(0.9, 0.8, 0.7)),
    };
    let mirror = scene.material(mirror, 0.0);
    let plastic = Surface::Plastic {
        color: Texture::Constant(Rgb::new(0.2, 0.5, 0.7)),
        ior: 1.5,
        roughness: 0.0.into(),
    };
    let plastic = scene.material(plastic, 0.0);
    let ball = Solid::Sphere { radius: 0.5 };
    scene
        .solid(
            Solid::Box {
                half: DVec3::new(3.0, 0.1, 3.0),
            },
            white,
            DVec3::new(0.0, -0.1, 0.0),
        )
        .solid(ball, glass, DVec3::new(-1.2, 0.5, 0.3))
        .solid(ball, mirror, DVec3::new(0.0, 0.5, -0.4))
        .solid(ball, plastic, DVec3::new(1.2, 0.5, 0.3))
        .solid(
            Solid::Sphere { radius: 0.3 },
            lamp,
            DVec3::new(1.0, 2.0, 0.0),
        )
        .mesh(
            moved(
                box_mesh(Vec3::splat(-0.2), Vec3::splat(0.2)),
                1.0,
                Vec3::new(-1.0, 2.0, -0.5),
            ),
            lamp,
        )
        .point_light(DVec3::new(0.0, 3.0, 2.0), 4.0);
    scene
}

fn varied_with(integrator: IntegratorSettings) -> World {
    let mut scene = varied();
    scene.integrator = integrator;
    scene.world()
}

#[test]
fn layers_add_up_to_the_picture_and_leave_it_as_it_is() {
    for (settings, bounces) in [
        (IntegratorSettings::path(), 9),
        (direct(), 9),
        (
            IntegratorSettings::Path {
                max_depth: Some(2),
                russian_roulette: false,
            },
            3,
        ),
        (
            IntegratorSettings::Path {
                max_depth: None,
                russian_roulette: true,
            },
            17,
        ),
    ] {
        let world = varied_with(settings);
        let plain = shoot(&world, &[]);
        let image = shoot(&world, &[LIGHT.as_slice(), &FEATURES].concat());
        let colors = layer(&image, "");
        assert_eq!(layer(&plain, ""), colors);
        assert_eq!(count(&image, "bounce"), bounces);
        let names: Vec<String> = (0..bounces).map(|i| format!("bounce{i}")).collect();
        let by_bounce: Vec<Vec<Rgb>> = names.iter().map(|name| layer(&image, name)).collect();
        let by_strategy = ["emitted", "light", "bsdf"].map(|name| layer(&image, name));
        for (i, &color) in colors.iter().enumerate() {
            for parts in [&by_bounce[..], &by_strategy] {
                let sum: Rgb = parts.iter().map(|part| part[i]).sum();
                // Up to 25 contributions a sample, each rounded to f32 where it is added.
                let error = (sum - color).abs().max_element();
                assert!(
                    error <= 2e-6 * color.max_element(),
                    "pixel {i}: {sum} is not {color}"
                );
            }
        }
        assert_eq!(
            by_bounce[0], by_strategy[0],
            "only bounce 0 is seen directly"
        );
        for part in by_bounce[..3].iter().chain(&by_strategy) {
            assert!(part.iter().any(|c| c.max_element() > 0.01));
        }
    }
}

#[test]
fn layers_do_not_depend_on_how_the_work_is_split() {
    let world = varied_with(IntegratorSettings::path());
    let kinds = [LIGHT.as_slice(), &FEATURES].concat();
    let split = |threads, tile_size, noise| {
        let settings = RenderSettings {
            threads,
            tile_size,
            noise,
            samples: 0..80,
            ..RenderSettings::of(world.scene())
        };
        picture(&world, &kinds, &settings)
    };
    for noise in [None, Some(0.1)] {
        let first = split(1, 32, noise);
        assert_eq!(first.channel("samples").is_some(), noise.is_some());
        for (threads, tile_size) in [(2, 7), (3, 1), (2, 64)] {
            assert_eq!(
                split(threads, tile_size, noise),
                first,
                "{threads} {tile_size}"
            );
        }
    }
}

#[test]
fn each_bounce_of_a_glowing_room_brings_half_of_the_one_before() {
    let mut scene = empty_scene();
    let wall = scene.material(diffuse(0.5), 0.5);
    scene.solid(Solid::Box { half: DVec3::ONE }, wall, DVec3::ZERO);
    scene.integrator = IntegratorSettings::Path {
        max_depth: Some(40),
        russian_roulette: false,
    };
    let image = shoot(&scene.world(), &LIGHT);
    let all = |name: &str, expected: f32| {
        for color in layer(&image, name) {
            assert!(
                (color - expected).abs().max_element() <= 1e-6,
                "{name}: {color}"
            );
        }
    };
    for bounce in 0..16 {
        all(&format!("bounce{bounce}"), 0.5_f32.powi(bounce + 1));
    }
    assert_eq!(count(&image, "bounce"), 17);
    // The rest of the series. Nothing aims at a box.
    all("bounce16", 0.5_f32.powi(16) - 0.5_f32.powi(41));
    all("emitted", 0.5);
    all("light", 0.0);
    all("bsdf", 0.5);
}

/// A white floor at one point, with the lamp of radius `radius` 2 above.
fn under_a_lamp(radius: f64) -> Scene {
    let mut scene = empty_scene();
    scene.film.size = (4, 4);
    scene.film.spp = 4096;
    let mut camera = camera(DVec3::new(3.0, 1.0, 4.0), DVec3::ZERO);
    camera.projection = Projection::pinhole(1e-6);
    scene.cameras = vec![camera];
    let white = scene.material(diffuse(1.0), 0.0);
    let lamp = scene.material(diffuse(0.0), 3.0);
    scene
        .solid(
            Solid::Box {
                half: DVec3::new(9.0, 1.0, 9.0),
            },
            white,
            DVec3::new(0.0, -1.0, 0.0),
        )
        .solid(Solid::Sphere { radius }, lamp, DVec3::new(0.0, 2.0, 0.0));
    scene
}

#[test]
fn strategies_have_the_shares_that_the_power_heuristic_gives_them() {
    for radius in [0.3_f64, 1.0, 1.9] {
        // By angle from the vertical: the lamp is drawn evenly over its cone, the floor by cosine over pi.
        let edge = (1.0 - (radius / 2.0).powi(2)).sqrt();
        let lamp = 1.0 / (2.0 * PI * (1.0 - edge));
        let steps = 100_000;
        let (mut by_light, mut by_bsdf) = (0.0, 0.0);
        for i in 0..steps {
            let cosine = edge + (1.0 - edge) * (f64::from(i) + 0.5) / f64::from(steps);
            let floor = cosine / PI;
            let weight = lamp * lamp / (lamp * lamp + floor * floor);
            let light = 3.0 * floor * 2.0 * PI * (1.0 - edge) / f64::from(steps);
            by_light += light * weight;
            by_bsdf += light * (1.0 - weight);
        }
        let mut scene = under_a_lamp(radius);
        scene.integrator = direct();
        let image = shoot(&scene.world(), &LIGHT);
        for (name, expected) in [("emitted", 0.0), ("light", by_light), ("bsdf", by_bsdf)] {
            let colors = layer(&image, name);
            let mean = colors.iter().map(|c| f64::from(c.x)).sum::<f64>() / colors.len() as f64;
            let error = (mean - expected).abs();
            // Of the smallest lamp 1,500 rays tell; independent ones would have a standard error of 2.6 %.
            assert!(
                error <= 0.01 * expected,
                "{radius} {name}: {mean}, not {expected}"
            );
        }
    }
}

#[test]
fn features_are_what_the_integrators_of_that_name_show() {
    let world = varied_with(IntegratorSettings::whitted());
    let image = shoot(&world, &FEATURES);
    let shown = |settings: &IntegratorSettings| {
        let scene = world.scene();
        let lens = scene.cameras[0].lens(scene.film.size).unwrap();
        let integrator = integrator(settings);
        let settings = RenderSettings::of(scene);
        let film = render(&world, &lens, integrator.as_ref(), &settings, &());
        layer(&film.unwrap().film.to_image(), "")
    };
    let depth = shown(&IntegratorSettings::Depth);
    let z = image.channel("depth.Z").unwrap();
    assert!(depth.iter().zip(z).all(|(a, b)| a.x == *b));
    assert!(image.channel("depth.R").is_none());
    let normals = shown(&IntegratorSettings::Normals);
    let flat = shown(&IntegratorSettings::Flat);
    let albedo = layer(&image, "albedo");
    let [x, y, z] = ["X", "Y", "Z"].map(|c| image.channel(&format!("normal.{c}")).unwrap());
    let (mut floor, mut sky) = (0, 0);
    for i in 0..depth.len() {
        if depth[i].x == 0.0 {
            sky += 1;
            assert_eq!((albedo[i], x[i], y[i], z[i]), (Rgb::ZERO, 0.0, 0.0, 0.0));
        } else if albedo[i] == Rgb::splat(0.8) {
            floor += 1;
            assert_eq!(flat[i], albedo[i]);
            let error = normals[i] - (0.5 * Vec3::new(x[i], y[i], z[i]) + 0.5);
            assert!(error.abs().max_element() < 1e-6, "{i}: {error}");
        }
    }
    assert!(floor > 50 && sky > 50, "{floor} {sky}");
}

#[test]
fn an_exr_has_the_layers_under_their_names() {
    let world = varied_with(IntegratorSettings::path());
    let settings = RenderSettings {
        noise: Some(0.5),
        ..RenderSettings::of(world.scene())
    };
    let image = picture(&world, &[LIGHT.as_slice(), &FEATURES].concat(), &settings);
    let read = decode_exr(&encode_exr(&image, Precision::Float).unwrap()).unwrap();
    let mut names: Vec<String> = ["R", "G", "B", "samples", "depth.Z"]
        .map(String::from)
        .to_vec();
    names.extend(["X", "Y", "Z"].map(|c| format!("normal.{c}")));
    let layers = (0..=8).map(|i| format!("bounce{i}"));
    for name in layers.chain(["emitted", "light", "bsdf", "albedo"].map(String::from)) {
        names.extend(["R", "G", "B"].map(|c| format!("{name}.{c}")));
    }
    names.sort();
    let found: Vec<&str> = read.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(found, names);
    for channel in &image.channels {
        assert_eq!(read.channel(&channel.name), Some(channel.values.as_slice()));
    }
}

#[test]
fn integrators_that_know_no_bounces_refuse_to_split_light() {
    for kind in LIGHT {
        let refused = layered_integrator(&IntegratorSettings::whitted(), &[kind]);
        let error = refused.err().unwrap();
        assert_eq!(error.kind(), ErrorKind::Usage);
        assert!(error.to_string().contains("path or direct"), "{error}");
    }
    assert!(layered_integrator(&IntegratorSettings::Depth, &FEATURES).is_ok());
}

//! The report's figures have scenes and pictures, and the four faults that it admits are absent.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::film::Filter;
use solidtrace::geometry::{Shape, Solid};
use solidtrace::integrator::{CameraRay, integrator};
use solidtrace::material::Surface;
use solidtrace::math::Transform;
use solidtrace::sampling::{Sampler, SamplerKind};
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::Texture;

use crate::scenes::{folder, load, picture, scenes};
use crate::support::meshes::{moved, sphere_mesh};
use crate::support::{Build, Shot, camera, diffuse, empty_scene, shoot, statistics};

/// Every figure of the report that is a rendering.
const FIGURES: &str = "1 2 4 5 6 8 10a 10b 11a 11b 11c 12a 12b 12c 14a 14b 14c 14d 14e 15a 15b 15c 15d 15e 15f 15g \
    16a 16b 17 18a 18b 18c 18d 18e 19a 19b 19c 19d 19e 19f 19g 21a 21b 21c 21d 23a 23b 24a 24b 25a 25b 26a 26b \
    27a 27b 27c 27d 33 34a 34b 35a 35b 35c 35d 36a 36b 37 38a 38b 38c 39 40 41 42a 42b 43 44 45a 45b 46 49";

fn stem(figure: &str) -> String {
    let digits = figure.chars().filter(char::is_ascii_digit).count();
    format!("figure_{}{figure}", &"0"[(digits - 1).min(1)..])
}

#[test]
fn every_figure_of_the_report_has_a_scene_that_renders() {
    assert_eq!(
        scenes(&folder().join("report")).len(),
        FIGURES.split_whitespace().count()
    );
    for figure in FIGURES.split_whitespace() {
        let scene = load(&format!("report/{}.ron", stem(figure)));
        assert_eq!(scene.warnings, [""; 0], "{figure}");
        let (_, pixels) = picture(scene);
        let brightness = |p: &Rgb| p.element_sum();
        let least = pixels.iter().map(brightness).fold(f32::INFINITY, f32::min);
        let most = pixels.iter().map(brightness).fold(0.0, f32::max);
        assert!(most - least > 0.1, "{figure}: {least} to {most}");
        let lit = pixels.iter().filter(|p| brightness(p) > 0.05).count();
        assert!(lit > pixels.len() / 20, "{figure}: {lit} pixels");
    }
}

#[test]
fn every_figure_of_the_report_is_in_the_gallery() {
    let page = std::fs::read_to_string(folder().join("gallery.md")).unwrap();
    for figure in FIGURES.split_whitespace() {
        let stem = stem(figure);
        let text = std::fs::read_to_string(folder().join(format!("report/{stem}.ron"))).unwrap();
        let line = text.lines().next().unwrap();
        let caption = line.strip_prefix(&format!("// Figure {figure}: ")).unwrap();
        let row = format!(
            "| [{figure}](report/{stem}.ron) | ![figure {figure}](gallery/{stem}.png) | {caption} |"
        );
        assert!(page.contains(&row), "{row}");
        let picture = image::open(folder().join(format!("gallery/{stem}.png"))).unwrap();
        assert_eq!(picture.width(), 240, "{figure}");
    }
    assert!(page.contains("![figure 8 without an offset](gallery/figure_08_acne.png)"));
    assert!(page.contains("## Table 2"));
}

/// Turns and moves what would be at round numbers, where nothing rounds.
fn askew() -> DAffine3 {
    let axis = DVec3::new(0.3, 0.7, -0.5).normalize();
    DAffine3::from_translation(DVec3::new(0.37, -5.3, 2.9)) * DAffine3::from_axis_angle(axis, 0.8)
}

fn shot(spp: u32) -> Shot {
    Shot {
        spp,
        sampler: SamplerKind::Independent,
        seed: 5,
    }
}

/// One ray through the middle of each of 64 by 64 pixels, and light that comes straight from the lights.
fn exact(mut scene: Scene) -> Scene {
    scene.film.size = (64, 64);
    scene.film.filter = Filter::Box { radius: 1e-9 };
    scene.integrator = IntegratorSettings::Path {
        max_depth: Some(1),
        russian_roulette: false,
    };
    scene
}

#[test]
fn a_sphere_light_has_the_variance_of_directions_within_its_cone() {
    let (radius, radiance, albedo) = (3.0, 2.0, 0.6);
    let light = DVec3::new(2.0, 8.0, -1.0);
    let mut scene = exact(empty_scene());
    scene.integrator = IntegratorSettings::whitted();
    scene.cameras = vec![camera(DVec3::new(0.0, 3.0, 9.0), DVec3::ZERO)];
    let floor = scene.material(diffuse(albedo as f32), 0.0);
    let lamp = scene.material(diffuse(0.0), radiance as f32);
    let up = DAffine3::from_rotation_x(-PI / 2.0);
    scene.place(Shape::Solid(Solid::Plane), floor, up);
    scene.solid(Solid::Sphere { radius }, lamp, light);
    let world = scene.world();
    let lens = world.scene().cameras[0].lens((1, 1)).unwrap();
    let batch: Vec<CameraRay> = (0..20_000)
        .map(|index| CameraRay {
            ray: lens.ray(0.5, 0.5, glam::Vec2::ZERO),
            sampler: Sampler::new(SamplerKind::Independent, 5, (0, 0), index),
        })
        .collect();
    let mut radiances = vec![Rgb::ZERO; batch.len()];
    integrator(&world.scene().integrator).radiance(&world, &batch, &mut radiances);
    let samples: Vec<f64> = radiances.iter().map(|r| f64::from(r.x)).collect();
    let (mean, deviation) = statistics(&samples);
    // For directions uniform in a cone of cosine c, around an axis with cosine a to the normal: means of the cosine
    // to the axis and of its square, and from them the variance of the cosine to the normal.
    let c = (1.0 - (radius / light.length()).powi(2)).sqrt();
    let a = light.y / light.length();
    let (first, second) = (0.5 + 0.5 * c, (1.0 + c + c * c) / 3.0);
    let variance = a * a * (second - first * first) + (1.0 - a * a) * (1.0 - second) / 2.0;
    let scale = albedo / PI * radiance * 2.0 * PI * (1.0 - c);
    // Both within five of their standard errors; the cosine has lighter tails than a normal distribution.
    let n = (samples.len() as f64).sqrt();
    assert!((mean - scale * a * first).abs() < 5.0 * deviation / n);
    let ratio = deviation / (scale * variance.sqrt());
    assert!((ratio - 1.0).abs() < 5.0 / n, "{ratio}");
}

#[test]
fn a_sphere_light_is_no_noisier_than_a_point_light_of_its_power_in_the_reports_room() {
    let variance = |name: &str| {
        let mut scene = load(name);
        assert_eq!(scene.film.spp, 5);
        scene.film.size = (48, 48);
        let world = scene.world();
        let [a, b] = [1, 2].map(|seed| shoot(&world, Shot { seed, ..shot(5) }));
        // In display brightness: a few paths near the light outweigh all others otherwise.
        let shown = |p: &Rgb| p.clamp(Vec3::ZERO, Vec3::ONE);
        let squares = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (shown(a) - shown(b)).length_squared());
        squares.sum::<f32>() / a.len() as f32
    };
    let (point, sphere) = (
        variance("report/figure_21a.ron"),
        variance("report/figure_21d.ron"),
    );
    println!("variance {sphere:.3e} against {point:.3e}");
    assert!(sphere < 1.2 * point, "{sphere} against {point}");
}

#[test]
fn the_shadow_of_a_box_has_no_bands() {
    let light = DVec3::new(-3.0, 7.0, 2.0);
    let half = DVec3::new(1.0, 1.5, 0.7);
    for degrees in [0.0_f64, 30.0, 45.0] {
        // One box stands on the floor, one floats.
        let boxes = [(-0.8, half.y), (2.5, half.y + 0.8)].map(|(x, y)| {
            let turn = DMat3::from_rotation_y(degrees.to_radians());
            DAffine3::from_mat3_translation(turn, DVec3::new(x, y, 0.0))
        });
        let mut scene = exact(empty_scene());
        let [eye, target] = [DVec3::new(5.0, 12.0, 7.0), DVec3::new(2.0, 0.0, 0.0)];
        let askew = askew();
        let moved = |p| askew.transform_point3(p);
        scene.cameras = vec![camera(moved(eye), moved(target))];
        scene.point_light(moved(light), 50.0);
        let matt = scene.material(diffuse(0.6), 0.0);
        let shape = Shape::Solid(Solid::Box { half });
        for place in boxes {
            scene.place(shape, matt, askew * place);
        }
        let up = DAffine3::from_rotation_x(-PI / 2.0);
        scene.place(Shape::Solid(Solid::Plane), matt, askew * up);
        let world = scene.world();
        let lens = world.scene().cameras[0].lens((64, 64)).unwrap();
        // How far a segment passes a box by: the longest stretch common to all three slabs, or less than none.
        let within = |place: &DAffine3, from: DVec3, to: DVec3| {
            let inverse = place.inverse();
            let (o, d) = (
                inverse.transform_point3(from),
                inverse.transform_vector3(to - from),
            );
            let (a, b) = ((-half - o) / d, (half - o) / d);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            leave.min(1.0) - enter.max(0.0)
        };
        let (mut lit, mut dark) = (0, 0);
        for (i, pixel) in shoot(&world, shot(1)).iter().enumerate() {
            let (x, y) = ((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
            let ray = lens.ray(x, y, glam::Vec2::ZERO);
            let (o, d) = (
                askew.inverse().transform_point3(ray.origin),
                askew.inverse().transform_vector3(ray.direction),
            );
            let p = o - o.y / d.y * d;
            if boxes.iter().any(|b| within(b, o, p) > -1e-6) {
                continue;
            }
            let depth = boxes.iter().map(|b| within(b, p, light));
            let depth = depth.fold(f64::NEG_INFINITY, f64::max);
            if depth.abs() < 1e-6 {
                continue;
            }
            let d = light - p;
            let truth = if depth > 0.0 {
                dark += 1;
                0.0
            } else {
                lit += 1;
                0.6 / PI * 50.0 * d.y / d.length().powi(3)
            };
            let error = (f64::from(pixel.x) - truth).abs();
            assert!(
                error < 1e-5,
                "{degrees} degrees, pixel {i}: {pixel} against {truth}"
            );
        }
        assert!(lit > 500 && dark > 200, "{lit} lit, {dark} dark");
    }
}

#[test]
fn a_mesh_with_normals_is_shaded_as_the_surface_it_stands_for() {
    let view = |smooth: Option<bool>| {
        let mut scene = exact(empty_scene());
        scene.cameras = vec![camera(DVec3::new(0.0, 0.0, 3.5), DVec3::ZERO)];
        // From beside the camera: no shadow boundary is in view, where a mesh's own edges would show.
        scene.point_light(DVec3::new(1.0, 1.0, 6.0), 40.0);
        let matt = scene.material(diffuse(0.7), 0.0);
        if let Some(smooth) = smooth {
            let mut mesh = moved(sphere_mesh(40, |_| 1.0), 1.0, Vec3::ZERO);
            mesh.normals = mesh.positions.clone();
            scene.mesh(mesh, matt);
            scene.instances[0].smooth = smooth;
        } else {
            scene.solid(Solid::Sphere { radius: 1.0 }, matt, DVec3::ZERO);
        }
        shoot(&scene.world(), shot(1))
    };
    let truth = view(None);
    let worst = |pixels: &[Rgb]| {
        let middle = (0..truth.len()).filter(|i| {
            let (x, y) = ((i % 64) as f64 - 31.5, (i / 64) as f64 - 31.5);
            x.hypot(y) < 20.0
        });
        let errors = middle.map(|i| (pixels[i].x / truth[i].x - 1.0).abs());
        errors.fold(0.0, f32::max)
    };
    let (smooth, flat) = (worst(&view(Some(true))), worst(&view(Some(false))));
    println!("smooth {smooth:.4}, flat {flat:.4}");
    assert!(smooth < 0.01, "{smooth}");
    assert!(flat > 0.03, "a test that flat normals pass: {flat}");
}

#[test]
fn no_ray_is_lost_in_a_closed_room_of_mirrors() {
    // Walls that send out 1/2 and reflect 1/2 are of radiance 1 wherever one looks, corners included.
    let half = DVec3::new(40.0, 25.0, 60.0);
    let settings = [
        IntegratorSettings::Path {
            max_depth: Some(40),
            russian_roulette: false,
        },
        IntegratorSettings::Whitted {
            max_depth: 40,
            shadow_factor: 0.0,
            background: None,
        },
    ];
    for integrator in settings {
        let mut scene = empty_scene();
        scene.film.size = (96, 96);
        scene.integrator = integrator;
        let askew = askew();
        let eye = askew.transform_point3(DVec3::new(0.0, 0.0, 55.0));
        let mut lens = camera(eye, askew.translation);
        lens.projection = Projection::pinhole(60_f64.to_radians());
        scene.cameras = vec![lens];
        let mirror = Surface::Mirror {
            color: Texture::Constant(Rgb::splat(0.5)),
        };
        let mirror = scene.material(mirror, 0.5);
        for axis in DVec3::AXES {
            for n in [axis, -axis] {
                let (x, y) = n.any_orthonormal_pair();
                let at = DVec3::new(0.0, 15.0, 0.0) - n * half.dot(axis);
                let place = Transform::rigid(DMat3::from_cols(x, y, n), at);
                let shape = Shape::Solid(Solid::Plane);
                scene.place(shape, mirror, askew * *place.matrix());
            }
        }
        scene.solid(Solid::Sphere { radius: 10.0 }, mirror, askew.translation);
        for (i, pixel) in shoot(&scene.world(), shot(64)).iter().enumerate() {
            let error = (*pixel - Rgb::ONE).abs().max_element();
            assert!(error < 1e-5, "pixel {i}: {pixel}");
        }
    }
}

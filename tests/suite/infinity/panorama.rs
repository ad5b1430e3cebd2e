//! A panorama is an environment.

use glam::{DVec3, Vec2};
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::film::Filter;
use solidtrace::geometry::Solid;
use solidtrace::integrator::integrator;
use solidtrace::io::{WriteOptions, write_image};
use solidtrace::light::EnvironmentMap;
use solidtrace::render::{RenderSettings, render};
use solidtrace::scene::{Scene, SceneDescription};

use crate::support::{Build, camera, diffuse, empty_scene};

use super::picture;

/// The axes and a colour for each.
const AXES: [(DVec3, Rgb); 6] = [
    (DVec3::X, Rgb::new(1.0, 0.0, 0.0)),
    (DVec3::NEG_X, Rgb::new(0.0, 1.0, 1.0)),
    (DVec3::Y, Rgb::new(0.0, 1.0, 0.0)),
    (DVec3::NEG_Y, Rgb::new(1.0, 0.0, 1.0)),
    (DVec3::Z, Rgb::new(0.0, 0.0, 1.0)),
    (DVec3::NEG_Z, Rgb::new(1.0, 1.0, 0.0)),
];

/// A glowing ball at each axis.
fn balls() -> Scene {
    let mut scene = empty_scene();
    for (axis, color) in AXES {
        let lamp = scene.material(diffuse(0.0), 0.0);
        scene.materials[lamp.0 as usize].emission = color;
        scene.solid(Solid::Sphere { radius: 0.5 }, lamp, 2.0 * axis);
    }
    scene
}

#[test]
fn a_panorama_of_a_scene_is_an_environment_that_shows_it() {
    let mut scene = balls();
    scene.film.size = (96, 48);
    scene.film.filter = Filter::Box { radius: 0.5 };
    scene.cameras[0].projection = Projection::Panorama;
    let world = scene.world();
    let scene = world.scene();
    let lens = scene.cameras[0].lens(scene.film.size).unwrap();
    let settings = RenderSettings::of(scene);
    let rendered = render(
        &world,
        &lens,
        integrator(&scene.integrator).as_ref(),
        &settings,
        &(),
    )
    .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("around.exr");
    write_image(&file, &rendered.film.to_image(), &WriteOptions::default()).unwrap();

    for (rotate, turned) in [(0, [0, 1, 2, 3, 4, 5]), (90, [4, 5, 2, 3, 1, 0])] {
        let text = format!(
            "(camera: Perspective(eye: (0, 0, 0), look_at: (0, 0, -1), vfov: 45), objects: [],\n environment: Image(file: \"around.exr\", rotate: {rotate}, scale: 2))"
        );
        let description = SceneDescription::from_text(folder.path().join("a.ron"), &text).unwrap();
        let world = description.load().unwrap().world();
        for (i, (axis, _)) in AXES.into_iter().enumerate() {
            // A quarter turn about y takes z to x, x to -z and so on.
            let color = AXES[turned[i]].1;
            let shown = world.beyond(axis, |_| 1.0);
            assert!(
                (shown - 2.0 * color).abs().max_element() < 1e-5,
                "{rotate}, {axis}: {shown}"
            );
        }
        assert_eq!(world.beyond(DVec3::ONE.normalize(), |_| 1.0), Rgb::ZERO);
    }
}

#[test]
fn a_panorama_camera_sees_the_pictures_pixels_where_they_are() {
    let (width, height) = (12, 6);
    let bitmap = picture(width, height, |x, y| (x + 100 * y) as f32);
    let map = EnvironmentMap::new(bitmap, 0.0);
    let mut camera = camera(DVec3::ZERO, DVec3::NEG_Z);
    camera.projection = Projection::Panorama;
    let lens = camera.lens((width as u32, height as u32)).unwrap();
    for y in 0..height {
        for x in 0..width {
            let ray = lens.ray(x as f64 + 0.5, y as f64 + 0.5, Vec2::ZERO);
            let (shown, _) = map.beyond(ray.direction);
            assert!(
                (shown.x - (x + 100 * y) as f32).abs() < 1e-3,
                "({x}, {y}): {shown}"
            );
        }
    }
}

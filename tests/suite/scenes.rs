//! Every scene of the project loads and renders, and shows what it says it shows; those of the report are in `report`.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use solidtrace::color::Rgb;
use solidtrace::geometry::Shape;
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::{Scene, SceneDescription};
use solidtrace::world::World;

use crate::support::{Build, Shot, shoot};

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

pub fn load(name: &str) -> Scene {
    let description = SceneDescription::read(folder().join(name));
    let scene = description.and_then(|description| description.load());
    scene.unwrap_or_else(|e| panic!("{name}: {e}"))
}

pub fn scenes(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut scenes: Vec<PathBuf> = paths
        .filter(|p| p.extension().is_some_and(|e| e == "ron"))
        .collect();
    scenes.sort();
    scenes
}

/// A small picture of the scene.
pub fn picture(mut scene: Scene) -> (World, Vec<Rgb>) {
    let (width, height) = scene.film.size;
    scene.film.size = (48, 48 * height / width);
    let world = scene.world();
    let pixels = shoot(
        &world,
        Shot {
            spp: 2,
            sampler: SamplerKind::Sobol,
            seed: 0,
        },
    );
    (world, pixels)
}

#[test]
fn every_scene_renders() {
    let all = scenes(&folder());
    assert!(all.len() >= 8, "{} scenes", all.len());
    for path in all {
        let (_, pixels) = picture(load(path.to_str().unwrap()));
        let shades: HashSet<[u32; 3]> = (pixels.iter())
            .map(|p| p.to_array().map(f32::to_bits))
            .collect();
        assert!(
            shades.len() > 100,
            "{}: {} shades",
            path.display(),
            shades.len()
        );
    }
}

/// The names of the materials that camera rays see, on CSG objects alone.
fn seen(name: &str) -> Vec<String> {
    let mut scene = load(name);
    scene.film.size = (96, 96);
    let world = scene.world();
    let lens = world.scene().cameras[0].lens((96, 96)).unwrap();
    let mut names: Vec<String> = (0..96 * 96)
        .filter_map(|i| {
            let (x, y) = (f64::from(i % 96) + 0.5, f64::from(i / 96) + 0.5);
            let ray = lens.ray(x, y, glam::Vec2::ZERO);
            let hit = world.intersect(&ray)?;
            let shape = world.instance(&hit).shape;
            matches!(shape, Shape::Csg(_))
                .then(|| world.material(&world.surface(&ray, &hit)).name.clone())
        })
        .collect();
    names.sort();
    names.dedup();
    names
}

#[test]
fn faces_have_the_materials_that_the_report_says() {
    // Own materials, and one that all faces share.
    assert_eq!(seen("report/figure_24a.ron"), ["blue", "red"]);
    assert_eq!(seen("report/figure_24b.ron"), ["white"]);
    // The red box rounded by the blue sphere, and the white cylinders' cuts.
    assert_eq!(seen("report/figure_34a.ron"), ["blue", "red", "white"]);
    // The other way round the sphere has no part in it.
    assert_eq!(seen("report/figure_34b.ron"), ["red", "white"]);
    // A mesh keeps its own materials beside that of the section.
    let girl = seen("cut_girl.ron");
    assert!(girl.contains(&"section".to_owned()) && girl.contains(&"dress".to_owned()));
}

#[test]
fn the_large_trees_are_as_large_as_they_say() {
    for (name, least) in [("swiss_cheese.ron", 100_000), ("engine_part.ron", 50)] {
        let scene = load(name);
        let operands: usize = scene.csgs.iter().map(solidtrace::geometry::Csg::len).sum();
        assert!(operands >= least, "{name}: {operands}");
    }
}

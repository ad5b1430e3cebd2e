//! What a scene file says of CSG is what the CSG objects of the scene are.

mod materials;
mod meshes;
mod nests;
mod operands;
mod repeats;

use std::path::Path;

use solidtrace::geometry::{Csg, Operand, Shape, Solid};
use solidtrace::scene::{Instance, Scene, SceneDescription};

/// A scene in `folder` with three materials.
fn describe(folder: &Path, objects: &str, definitions: &str) -> SceneDescription {
    let text = format!(
        "(camera: Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45),
        materials: {{\"red\": Mirror(), \"green\": Mirror(), \"blue\": Mirror()}},
        objects: [{objects}], definitions: {{{definitions}}})"
    );
    let description = SceneDescription::from_text(folder.join("test.ron"), &text);
    description.unwrap_or_else(|e| panic!("{e}"))
}

fn scene_in(folder: &Path, objects: &str, definitions: &str) -> Scene {
    let scene = describe(folder, objects, definitions).load();
    scene.unwrap_or_else(|e| panic!("{e}"))
}

fn scene(objects: &str, definitions: &str) -> Scene {
    scene_in(Path::new("."), objects, definitions)
}

fn csg_of<'a>(scene: &'a Scene, instance: &Instance) -> &'a Csg {
    match instance.shape {
        Shape::Csg(id) => &scene.csgs[id.0 as usize],
        other => panic!("{other:?} is no CSG object"),
    }
}

/// The only CSG object of a scene with one object.
fn only(scene: &Scene) -> &Csg {
    assert_eq!((scene.instances.len(), scene.csgs.len()), (1, 1));
    csg_of(scene, &scene.instances[0])
}

/// The material in a slot of an operand.
fn material(scene: &Scene, operand: u32, slot: u32) -> &str {
    let id = scene.instances[0].material(only(scene).slot(operand, slot));
    &scene.materials[id.0 as usize].name
}

/// How many materials the only instance has, which must all differ.
fn distinct_materials(scene: &Scene) -> usize {
    let materials = &scene.instances[0].materials;
    for (i, material) in materials.iter().enumerate() {
        assert!(!materials[..i].contains(material), "{materials:?}");
    }
    materials.len()
}

fn sphere(radius: f64) -> Operand {
    Operand::Solid(Solid::Sphere { radius })
}

fn radius(csg: &Csg, operand: u32) -> f64 {
    match csg.operand(operand).0 {
        Operand::Solid(Solid::Sphere { radius }) => radius,
        other => panic!("{other:?} is no sphere"),
    }
}

fn origin(csg: &Csg, operand: u32) -> [f64; 3] {
    csg.operand(operand).1.matrix().translation.to_array()
}

/// `of` four times.
fn repeat(of: &str, rest: &str) -> String {
    format!("Repeat(count: (2, 2, 1), step: ((10, 0, 0), (0, 20, 0), (0, 0, 30)), of: {of}{rest})")
}

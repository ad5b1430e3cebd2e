//! What is compared with Embree.

use glam::{DAffine3, Vec3};
use solidtrace::geometry::Mesh;
use solidtrace::io::bare_scene;
use solidtrace::math::Transform;
use solidtrace::scene::{Model, Part, Scene};

use super::meshes::{box_mesh, bumpy_sphere, moved, slivers, torus_mesh};

/// Meshes on which hits are compared with Embree's.
pub fn comparison_cases() -> Vec<(String, Mesh)> {
    [
        ("cube", box_mesh(Vec3::NEG_ONE, Vec3::ONE)),
        ("bumpy sphere", bumpy_sphere(130)),
        ("torus", torus_mesh(300, 100, 1.0, 0.35)),
        ("slivers", slivers(80)),
        (
            "cube moved by 1e6",
            moved(box_mesh(Vec3::NEG_ONE, Vec3::ONE), 1.0, Vec3::splat(1e6)),
        ),
        (
            "torus moved by 1e4",
            moved(torus_mesh(300, 100, 1.0, 0.35), 1.0, Vec3::splat(1e4)),
        ),
    ]
    .map(|(name, mesh)| (name.to_owned(), mesh))
    .into()
}

/// Meshes, each placed at will by its index, in the studio of a bare model.
pub fn framed(meshes: Vec<Mesh>, places: &[(usize, DAffine3)]) -> Scene {
    let parts = places.iter().map(|&(mesh, place)| Part {
        name: None,
        mesh,
        materials: Vec::new(),
        model_from_mesh: Transform::new(place).unwrap(),
    });
    let model = Model {
        meshes,
        parts: parts.collect(),
        ..Model::default()
    };
    bare_scene(model, false).unwrap()
}

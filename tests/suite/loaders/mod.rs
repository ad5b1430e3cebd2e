//! Models are read as their formats mean them, and no bad file makes a reader panic.

mod gltf;
mod mtl;
mod obj;

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use solidtrace::Result;
use solidtrace::error::Error;
use solidtrace::geometry::Mesh;
use solidtrace::io::read_model;
use solidtrace::scene::Model;
use tempfile::TempDir;

use crate::random::SplitMix;

/// A folder for a test's files.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn read(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<Model> {
        read_model(&self.write(name, bytes))
    }

    fn error(&self, name: &str, bytes: impl AsRef<[u8]>) -> Error {
        self.read(name, bytes).map(|_| ()).unwrap_err()
    }
}

/// Volume inside a closed mesh by the divergence theorem; positive when faces wind outward.
fn volume(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len() as u32)
        .map(|i| {
            let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

fn area(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len() as u32)
        .map(|i| {
            let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum()
}

fn below(random: &mut SplitMix, n: usize) -> usize {
    (random.next() % n as u64) as usize
}

/// One to four bytes changed, removed, repeated or swapped for something telling, or the end cut off.
fn mutate(random: &mut SplitMix, bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=below(random, 4) {
        if bytes.is_empty() {
            break;
        }
        let at = below(random, bytes.len());
        match below(random, 5) {
            0 => bytes[at] = random.next() as u8,
            1 => bytes[at] = b"/-#.\\ \n0e9\"{[,"[below(random, 14)],
            2 => {
                bytes.remove(at);
            }
            3 => bytes.insert(at, bytes[at]),
            _ => bytes.truncate(at),
        }
    }
    bytes
}

#[test]
fn models_of_other_formats_are_refused_with_what_is_supported() {
    let error = Files::new().error("a.fbx", "");
    assert!(error.to_string().contains(".obj, .gltf or .glb"), "{error}");
    let error = read_model(Path::new("no_extension")).unwrap_err();
    assert!(error.to_string().contains(".obj, .gltf or .glb"), "{error}");
}

#[test]
fn a_missing_model_and_a_folder_are_errors_that_name_the_file() {
    let files = Files::new();
    for name in ["a.obj", "a.gltf", "a.glb"] {
        let path = files.path(name);
        let error = read_model(&path).unwrap_err();
        assert_eq!(error.place().unwrap().file, path);
        std::fs::create_dir(&path).unwrap();
        assert_eq!(read_model(&path).unwrap_err().place().unwrap().file, path);
    }
}

#[test]
fn the_shared_girl_has_her_triangles_groups_and_bounds() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/girl.obj");
    if !path.exists() {
        println!("left out: {} is not there", path.display());
        return;
    }
    let model = read_model(&path).unwrap();
    let mesh = &model.meshes[0];
    assert_eq!(mesh.triangles.len(), 5484);
    assert_eq!(model.parts[0].materials, [None; 6]);
    assert_eq!(mesh.slots.iter().max(), Some(&5));
    assert_eq!(model.warnings.len(), 1);
    assert!(model.warnings[0].contains(":7: "));
    assert!(model.warnings[0].contains("`Beautiful Girl.mtl`"));
    let bounds = mesh.bounds();
    assert!((bounds.max.z - 1.717).abs() < 1e-3, "{bounds:?}");
    assert!(bounds.size().cmple(DVec3::splat(1.8)).all());
    assert_eq!(mesh.normals.len(), mesh.positions.len());
    assert_eq!(mesh.uvs.len(), mesh.positions.len());
    assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
}

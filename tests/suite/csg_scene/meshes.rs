//! Meshes as operands.

use solidtrace::geometry::Operand;
use solidtrace::io::{OpenMeshOperands, ReadOptions};

use super::{describe, distinct_materials, material, only, origin, scene_in};

/// A tetrahedron with two materials, in a folder of its own.
fn tetrahedron() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let obj = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
        usemtl floor\nf 1 3 2\nusemtl side\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(folder.path().join("t.obj"), obj).unwrap();
    let mtl = "newmtl floor\nKd 1 0 0\nnewmtl side\nKd 0 1 0\n";
    std::fs::write(folder.path().join("t.mtl"), mtl).unwrap();
    folder
}

#[test]
fn meshes_keep_their_files_materials_until_one_is_set() {
    let folder = tetrahedron();
    let scene = scene_in(
        folder.path(),
        "Union(of: [Mesh(file: \"t.obj\"), Sphere(radius: 1, material: \"red\"), Mesh(file: \"t.obj\", material: \"blue\"),
            Union(of: [Instance(of: \"t\")], material: \"green\"), Instance(of: \"t\"),
            Instance(of: \"t\", transform: [Translate((0, 7, 0))], material: \"red\")])",
        "\"t\": Mesh(file: \"t.obj\", transform: [Translate((5, 0, 0))])",
    );
    let of = |operand| [0, 1].map(|slot| material(&scene, operand, slot));
    assert_eq!(of(0), ["floor", "side"]);
    assert_eq!(of(1), ["red", "red"]);
    assert_eq!(of(2), ["blue", "blue"]);
    assert_eq!(of(3), ["green", "green"]);
    assert_eq!(of(4), ["floor", "side"]);
    assert_eq!(of(5), ["red", "red"]);
    assert_eq!(distinct_materials(&scene), 5);
    let csg = only(&scene);
    assert_eq!(csg.operand(0).0, csg.operand(5).0);
    assert_eq!(origin(csg, 5), [5.0, 7.0, 0.0]);
    assert_eq!(scene.meshes.len(), 1);
    assert!(scene.instances[0].smooth);
}

#[test]
fn one_mesh_with_flat_normals_makes_the_object_flat() {
    let folder = tetrahedron();
    let objects = "Union(of: [Sphere(radius: 1), Mesh(file: \"t.obj\", smooth: false)])";
    assert!(!scene_in(folder.path(), objects, "").instances[0].smooth);
}

#[test]
fn open_meshes_are_refused_or_judged_by_their_winding() {
    let folder = tetrahedron();
    let closed = std::fs::read_to_string(folder.path().join("t.obj")).unwrap();
    let open = closed.replace("f 3 1 4\n", "");
    std::fs::write(folder.path().join("open.obj"), open).unwrap();
    let load = |objects: &str, open_mesh_operands| {
        let options = ReadOptions {
            open_mesh_operands,
            ..ReadOptions::default()
        };
        describe(folder.path(), objects, "").load_with(&options)
    };
    let both =
        "Union(of: [Mesh(file: \"t.obj\"), Mesh(file: \"open.obj\"), Mesh(file: \"open.obj\")])";
    let error = load(both, OpenMeshOperands::Refuse).unwrap_err();
    assert!(error.message().contains("not closed"), "{error}");
    assert!(error.place().unwrap().file.ends_with("open.obj"), "{error}");

    let scene = load(both, OpenMeshOperands::Winding).unwrap();
    let operand = |i| only(&scene).operand(i).0;
    assert!(matches!(operand(0), Operand::Mesh(_)));
    assert!(matches!(operand(1), Operand::OpenMesh(_)));
    assert_eq!(operand(1), operand(2));
    let [warning] = &scene.warnings[..] else {
        panic!("{:?}", scene.warnings);
    };
    assert!(
        warning.contains("open.obj: the mesh is not closed"),
        "{warning}"
    );
    assert_eq!(warning.lines().count(), 1);

    // Alone it stands in the world as ever.
    let alone = load("Mesh(file: \"open.obj\")", OpenMeshOperands::Refuse).unwrap();
    assert_eq!((alone.instances.len(), alone.warnings.len()), (1, 0));
}

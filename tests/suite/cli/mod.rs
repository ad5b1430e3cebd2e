//! The program as people run it: exit codes, files, messages.

mod render;
mod trace;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

const SCENE: &str = r#"Scene(
    film: (size: (40, 30), spp: 5, filter: Gaussian(radius: 1.5)),
    camera: Perspective(eye: (0, 1, 5), look_at: (0, 0.5, 0), vfov: 40),
    environment: Constant(color: (0.3, 0.4, 0.5)),
    materials: {
        "white": Diffuse(color: (0.8, 0.8, 0.8)),
        "glass": Dielectric(ior: 1.5),
        "lamp": Emissive(radiance: (9, 9, 9)),
    },
    objects: [
        Plane(name: "floor", point: (0, 0, 0), normal: (0, 1, 0), material: "white"),
        Sphere(name: "ball, clear", center: (-0.6, 0.5, 0), radius: 0.5, material: "glass"),
        Torus(center: (0.8, 0.3, 0), axis: (0.3, 1, 0), major_radius: 0.5, minor_radius: 0.2, material: "white"),
        Sphere(center: (1, 3, 1), radius: 0.4, material: "lamp"),
    ],
)"#;

/// Runs the program in `folder`.
fn run(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_solidtrace"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn folder_with_scene() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("room.ron"), SCENE).unwrap();
    folder
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn wrong_usage_is_exit_code_2_and_wrong_input_1() {
    let folder = folder_with_scene();
    let path = folder.path();
    let code = |args: &[&str]| run(path, args).status.code();
    assert_eq!(code(&["render", "room.ron", "--size", "0x5"]), Some(2));
    assert_eq!(code(&["rendr", "room.ron"]), Some(2));
    assert_eq!(code(&["render", "room.ron", "--camera", "left"]), Some(2));
    assert_eq!(
        code(&["render", "room.ron", "--crop", "0,0,41,30"]),
        Some(2)
    );
    assert_eq!(code(&["render", "room.ron", "-o", "room.jpg"]), Some(2));
    assert_eq!(
        code(&["render", "room.ron", "--size", "65536x65536"]),
        Some(2)
    );
    for noise in ["0", "-0.1", "1.5", "nan", "little"] {
        let noise = format!("--noise={noise}");
        let output = run(path, &["render", "room.ron", &noise]);
        assert_eq!(output.status.code(), Some(2), "{noise}");
        let text = stderr(&output);
        assert!(text.contains("above 0 and at most 1, as 0.02"), "{text}");
    }
    for layers in [
        ["--layers=bounces", "--png=room.png"],
        ["--layers=strategies", "--integrator=whitted"],
        ["--layers=bounce", "--quiet"],
    ] {
        let output = run(path, &["render", "room.ron", layers[0], layers[1]]);
        assert_eq!(output.status.code(), Some(2), "{layers:?}");
    }
    assert_eq!(code(&["render", "missing.ron"]), Some(1));
    assert_eq!(code(&["info", "missing.obj"]), Some(1));
    let bad = SCENE.replace("radius: 0.4", "radius: -0.4");
    let line = 1 + bad.lines().position(|l| l.contains("-0.4")).unwrap();
    fs::write(path.join("bad.ron"), bad).unwrap();
    let output = run(path, &["render", "bad.ron"]);
    assert_eq!(output.status.code(), Some(1));
    let text = stderr(&output);
    assert!(text.contains(&format!("bad.ron:{line}:43")), "{text}");
    assert!(text.contains("`-0.4` must be above 0"), "{text}");
    assert!(
        fs::read_dir(path).unwrap().count() == 2,
        "no output was touched"
    );
}

#[test]
fn open_meshes_are_operands_only_on_request() {
    let folder = folder_with_scene();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
    fs::write(folder.path().join("open.obj"), obj).unwrap();
    let open = SCENE.replace(
        "objects: [",
        "objects: [Union(of: [Mesh(file: \"open.obj\")]),",
    );
    fs::write(folder.path().join("open.ron"), open).unwrap();
    let info = |more: &[&str]| run(folder.path(), &[&["info", "open.ron"], more].concat());
    for refused in [info(&[]), info(&["--open-mesh-operands", "refuse"])] {
        assert_eq!(refused.status.code(), Some(1));
        assert!(stderr(&refused).contains("error: the mesh is not closed"));
    }
    let winding = info(&["--open-mesh-operands", "winding"]);
    assert_eq!(winding.status.code(), Some(0), "{}", stderr(&winding));
    assert!(stderr(&winding).contains("not closed"));
    assert_eq!(
        info(&["--open-mesh-operands", "guess"]).status.code(),
        Some(2)
    );
}

#[test]
fn info_prints_one_json_object_and_nothing_else() {
    let folder = folder_with_scene();
    let output = run(folder.path(), &["info", "room.ron", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["instances"], 4);
    assert_eq!(json["solids"], 3);
    assert_eq!(json["planes"], 1);
    assert_eq!(json["lights"], 1);
    let text = run(folder.path(), &["info", "room.ron"]);
    assert!(String::from_utf8_lossy(&text.stdout).contains("3 solids, 1 planes"));
}

#[test]
fn triangles_that_are_left_out_are_counted_and_a_mesh_without_any_other_is_an_error() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\n";
    fs::write(
        path.join("some.obj"),
        format!("{corners}f 1 2 3\nf 3 1 2\nf 1 2 4\n"),
    )
    .unwrap();
    let output = run(path, &["render", "some.obj", "--size", "8x8", "--spp", "1"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stderr(&output);
    assert!(
        text.contains("1 triangles without area and 1 duplicates"),
        "{text}"
    );
    fs::write(path.join("none.obj"), format!("{corners}f 1 2 4\n")).unwrap();
    let output = run(path, &["render", "none.obj"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("none.obj"), "{}", stderr(&output));
}

#[test]
fn generated_models_are_inputs_like_files_and_a_file_of_such_a_name_comes_first() {
    let folder = TempDir::new().unwrap();
    let triangles = |input: &str| {
        let output = run(folder.path(), &["info", input, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        info["triangles"].as_u64().unwrap()
    };
    assert_eq!(triangles("sphere:800"), 800);
    fs::write(
        folder.path().join("sphere:1.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    assert_eq!(triangles("sphere:1.obj"), 1);
    let output = run(folder.path(), &["render", "spere:800"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("did you mean `sphere`?"));
}

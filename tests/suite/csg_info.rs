//! What `info` tells of CSG objects, counted by hand.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

fn solidtrace(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_solidtrace"));
    command.args(args).current_dir(folder).output().unwrap()
}

fn info(objects: &str) -> (serde_json::Value, String) {
    let folder = TempDir::new().unwrap();
    let text = format!(
        "(camera: Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45), objects: [{objects}])"
    );
    fs::write(folder.path().join("test.ron"), text).unwrap();
    let json = solidtrace(folder.path(), &["info", "test.ron", "--json"]);
    let json = serde_json::from_slice(&json.stdout).unwrap();
    let text = solidtrace(folder.path(), &["info", "test.ron"]);
    assert!(text.status.success());
    (json, String::from_utf8(text.stdout).unwrap())
}

#[test]
fn operands_operators_depth_and_what_was_dropped_are_counted() {
    // A flush pocket, a ball in the middle, one out of reach, nested twice deeper than need be.
    let (json, text) = info(
        "Difference(name: \"block\", from: Difference(from: Box(size: (2, 2, 2)), subtract: [Sphere(radius: 0.5)]), subtract: [
            Union(of: [Box(center: (0, 0.75, 0), size: (0.5, 0.5, 0.5)), Sphere(center: (9, 0, 0), radius: 1)])])",
    );
    let csg = &json["csg_objects"][0];
    for (field, value) in [
        ("operands", 4),
        ("dropped_operands", 1),
        ("operators", 3),
        ("operators_flattened", 1),
        ("depth", 2),
        // The pocket's mouth in the block's top.
        ("coincident_faces", 1),
    ] {
        assert_eq!(csg[field], value, "{field} in {csg}");
    }
    assert_eq!(
        (&csg["name"], &csg["empty"]),
        (&"block".into(), &false.into())
    );
    assert!(csg["bytes"].as_u64().unwrap() > 100);
    assert_eq!(json["csg_instances"], 1);
    for part in [
        "4 operands",
        "3 operators (flattened 1)",
        "depth 2",
        "1 operands dropped",
        "1 pairs of coincident",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn faces_coincide_only_where_they_lie_in_one_surface_and_meet() {
    for (objects, pairs) in [
        // Side by side: one face each.
        (
            "Union(of: [Box(size: (1, 1, 1)), Box(center: (1, 0, 0), size: (1, 0.5, 0.5))])",
            1,
        ),
        // Nearly.
        (
            "Union(of: [Box(size: (1, 1, 1)), Box(center: (1.001, 0, 0), size: (1, 0.5, 0.5))])",
            0,
        ),
        // In one plane, apart.
        (
            "Union(of: [Box(size: (1, 1, 1)), Box(center: (5, 0, 0), size: (1, 1, 1))])",
            0,
        ),
        // One in another, both caps; and the mantle.
        (
            "Difference(from: Cylinder(from: (0, 0, 0), to: (0, 2, 0), radius: 1), subtract: [Cylinder(from: (0, 0, 0), to: (0, 2, 0), radius: 0.5)])",
            2,
        ),
        (
            "Union(of: [Cylinder(from: (0, 0, 0), to: (0, 2, 0), radius: 1), Cylinder(from: (0, 1, 0), to: (0, 3, 0), radius: 1)])",
            1,
        ),
        // A ball and its copy, written otherwise.
        (
            "Union(of: [Sphere(center: (1, 2, 3), radius: 2), Sphere(radius: 1, transform: [Scale((2, 2, 2)), Translate((1, 2, 3))])])",
            1,
        ),
        // The same, a million times smaller and far larger.
        (
            "Union(of: [Box(size: (1e-6, 1e-6, 1e-6)), Box(center: (1e-6, 0, 0), size: (1e-6, 5e-7, 5e-7))])",
            1,
        ),
        (
            "Union(of: [Box(size: (1e-6, 1e-6, 1e-6)), Box(center: (1.001e-6, 0, 0), size: (1e-6, 5e-7, 5e-7))])",
            0,
        ),
        (
            "Union(of: [Box(size: (1e6, 1e6, 1e6)), Box(center: (1e6, 0, 0), size: (1e6, 5e5, 5e5))])",
            1,
        ),
        // A half-space through a box's face.
        (
            "Intersection(of: [Box(size: (2, 2, 2)), Plane(point: (5, 1, 0), normal: (0, 1, 0))])",
            1,
        ),
    ] {
        let (json, _) = info(objects);
        assert_eq!(
            json["csg_objects"][0]["coincident_faces"], pairs,
            "{objects}"
        );
    }
}

#[test]
fn an_object_of_which_nothing_is_left_is_told_of() {
    let objects = "Intersection(name: \"ghost\", of: [Sphere(radius: 1), Sphere(center: (5, 0, 0), radius: 1)])";
    let (json, text) = info(objects);
    assert_eq!(json["csg_objects"][0]["empty"], true);
    assert!(
        text.contains("`ghost`") && text.contains("nothing is left of it"),
        "{text}"
    );
    let folder = TempDir::new().unwrap();
    let scene = format!(
        "(camera: Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45), objects: [{objects}])"
    );
    fs::write(folder.path().join("test.ron"), scene).unwrap();
    let args = ["render", "test.ron", "--size", "8x8", "--spp", "1"];
    let rendered = solidtrace(folder.path(), &args);
    let warning = String::from_utf8_lossy(&rendered.stderr).into_owned();
    assert!(
        rendered.status.success() && warning.contains("nothing is left of the CSG object `ghost`"),
        "{warning}"
    );
}

//! Every mistake in a scene file is reported at the place of the value, with the value and a way out.

mod files;
mod names;
mod operators;
mod sky;
mod syntax;
mod values;

use solidtrace::Error;
use solidtrace::scene::SceneDescription;

/// Reads `marked` without its mark `«`, which must be where the error points; the report must hold all of `parts`.
#[track_caller]
fn fails_as(file: &str, marked: &str, parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let text = marked.replacen('«', "", 1);
    let path = folder.path().join(file);
    let error = SceneDescription::from_text(path, &text)
        .and_then(|d| d.load())
        .expect_err(&format!("nobody minds\n{text}"));
    check(&error, marked, parts);
}

#[track_caller]
fn check(error: &Error, marked: &str, parts: &[&str]) {
    let before = &marked[..marked.find('«').expect("a mark")];
    let line = before.matches('\n').count() + 1;
    let column = before.lines().next_back().map_or(0, |l| l.chars().count());
    let column = if before.ends_with('\n') {
        1
    } else {
        column + 1
    };
    let place = error.place().expect("a place");
    assert_eq!(
        (place.line, place.column),
        (Some(line), Some(column)),
        "{error}"
    );
    let report = error.to_string();
    for part in parts {
        assert!(report.contains(part), "`{part}` is not in\n{report}");
    }
    assert!(!report.contains('«'));
}

const CAMERA: &str = "camera: Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45)";

#[track_caller]
fn fails(marked: &str, parts: &[&str]) {
    fails_as("test.ron", marked, parts);
}

/// An error in a list of objects, with two materials and a definition around it.
#[track_caller]
fn object_fails(object: &str, parts: &[&str]) {
    let scene = format!(
        "Scene(\n    {CAMERA}, // é\n    materials: {{\"green\": Mirror(), \"red\": Mirror()}},\n    definitions: {{\"bolt\": Sphere(radius: 1)}},\n    objects: [\n        Sphere(radius: 1), /* é */ {object},\n    ],\n)"
    );
    fails(&scene, parts);
}

#[track_caller]
fn material_fails(material: &str, parts: &[&str]) {
    fails(
        &format!("(\n {CAMERA},\n objects: [],\n materials: {{\"x\": {material}}})"),
        parts,
    );
}

#[track_caller]
fn setting_fails(setting: &str, parts: &[&str]) {
    fails(&format!("(\n {CAMERA},\n objects: [], {setting})"), parts);
}

#[track_caller]
fn camera_fails(camera: &str, parts: &[&str]) {
    fails(&format!("(\n camera: {camera},\n objects: [])"), parts);
}

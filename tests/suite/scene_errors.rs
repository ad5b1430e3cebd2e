//! Every mistake in a scene file is reported at the place of the value, with the value and a way out.

use std::path::Path;

use solidtrace::io::{ReadOptions, read_scene};
use solidtrace::scene::SceneDescription;
use solidtrace::{Error, ErrorKind};

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

#[test]
fn lengths_must_be_above_zero_and_finite() {
    object_fails(
        "Sphere(radius: «-3)",
        &["`-3`", "`radius` of `Sphere`", "above 0"],
    );
    object_fails("Sphere(radius: «0)", &["`0`", "above 0"]);
    object_fails("Sphere(radius: «inf)", &["`inf`", "finite"]);
    object_fails("Sphere(radius: «-inf)", &["`-inf`", "finite"]);
    object_fails(
        "Sphere(center: (0, «NaN, 0), radius: 1)",
        &["`NaN`", "`center`"],
    );
    object_fails("Sphere(center: (0, 0, «1e300), radius: 1)", &["`1e300`"]);
    object_fails("Sphere(radius: «1e-200)", &["`1e-200`"]);
    object_fails("Box(size: (1, «0, 1))", &["`0`", "`size` of `Box`"]);
    object_fails(
        "Cylinder(from: (0, 0, 0), to: (0, 1, 0), radius: «-1)",
        &["`-1`"],
    );
    object_fails(
        "Cone(from: (0, 0, 0), to: (0, 1, 0), from_radius: «-1)",
        &["`-1`", "`from_radius` of `Cone`", "at least 0"],
    );
}

#[test]
fn solids_must_not_be_degenerate() {
    object_fails(
        "Cylinder(from: (1, 2, 3), to: «(1, 2, 3), radius: 1)",
        &["`(1, 2, 3)`", "same point as `from`"],
    );
    object_fails(
        "«Cone(from: (0, 0, 0), to: (0, 1, 0), from_radius: 0)",
        &["both radii"],
    );
    object_fails(
        "Torus(major_radius: 2, minor_radius: «2)",
        &["`2`", "less than the `major_radius`, 2"],
    );
    object_fails(
        "Torus(axis: «(0, 0, 0), major_radius: 2, minor_radius: 1)",
        &["`(0, 0, 0)`"],
    );
    object_fails("Plane(normal: «(0, 0, 0))", &["`(0, 0, 0)`", "direction"]);
    object_fails(
        "Box(size: (1, 1, 1), axes: ((1, 0, 0), «(2, 0, 0)))",
        &["`(2, 0, 0)`", "0.0 degrees", "perpendicular"],
    );
    object_fails(
        "Box(size: (1, 1, 1), axes: («(0, 0, 0), (2, 0, 0)))",
        &["`(0, 0, 0)`"],
    );
}

#[test]
fn transforms_must_be_invertible() {
    let sphere =
        |step: &str| format!("Sphere(radius: 1, transform: [Translate((1, 0, 0)), {step}])");
    object_fails(&sphere("Scale((1, «0, 1))"), &["`0`", "flatten"]);
    object_fails(&sphere("Scale(«0)"), &["`0`", "flatten"]);
    object_fails(
        &sphere("Rotate(axis: «(0, 0, 0), degrees: 3)"),
        &["`(0, 0, 0)`", "`axis` of `Rotate`"],
    );
    object_fails(
        &sphere("Rotate(«axes: (0, 0, 1), degrees: 3)"),
        &["`axes`", "did you mean `axis`?"],
    );
    object_fails(
        &sphere("«Rotat(axis: (0, 0, 1), degrees: 3)"),
        &["`Rotat`", "did you mean `Rotate`?"],
    );
    object_fails(
        &sphere("«Matrix(((1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 0)))"),
        &["flattens"],
    );
    object_fails(
        &sphere("Matrix(«((1, 0, 0), (0, 1, 0), (1, 1, 0)))"),
        &["3 values"],
    );
    object_fails("Sphere(radius: 1, transform: «Scale(2))", &["a list"]);
    let many = "Scale(1e12), ".repeat(25);
    let step = format!("{many}«Scale(1e12), {}", "Scale(1e12)");
    object_fails(&sphere(&step), &["beyond"]);
}

#[test]
fn tuples_must_have_the_right_count() {
    object_fails(
        "Sphere(center: «(0, 0), radius: 1)",
        &["`(0, 0)`", "2 values", "`(x, y, z)`"],
    );
    object_fails("Sphere(center: «(0, 0, 0, 1), radius: 1)", &["4 values"]);
    object_fails("Sphere(center: «7, radius: 1)", &["`7`", "`(x, y, z)`"]);
    setting_fails(
        "film: (size: «(1, 2, 3))",
        &["`(1, 2, 3)`", "`(width, height)`"],
    );
}

#[test]
fn values_must_be_of_the_right_type() {
    object_fails("Sphere(radius: «\"3\")", &["`\"3\"`", "a number"]);
    object_fails("Sphere(radius: «None)", &["`None`", "a number"]);
    object_fails(
        "Sphere(radius: 1, material: «red)",
        &["`red`", "double quotes"],
    );
    object_fails("Sphere(radius: 1, name: «3)", &["`3`"]);
    object_fails("Sphere(radius: 1, name: «\"\")", &["empty"]);
    object_fails(
        "Mesh(file: \"a.obj\", smooth: «1)",
        &["`1`", "`true` or `false`"],
    );
    object_fails("Sphere(«3)", &["need their names"]);
    object_fails("«7", &["`7`", "an object"]);
}

#[test]
fn misspelt_fields_get_a_suggestion() {
    object_fails(
        "Sphere(«raduis: 3)",
        &["`Sphere` has no field `raduis`", "did you mean `radius`?"],
    );
    object_fails(
        "Sphere(radius: 3, «centre: (0, 0, 0))",
        &["`centre`", "did you mean `center`?"],
    );
    object_fails(
        "Sphere(radius: 3, «quux: 1)",
        &[
            "`quux`",
            "known here: center, radius, name, material, transform",
        ],
    );
    object_fails("«Sphere(center: (0, 0, 0))", &["needs the field `radius`"]);
    object_fails(
        "Sphere(radius: 3, «radius: 4)",
        &["`radius` is given twice"],
    );
    fails(
        &format!("({CAMERA}, «object: [])"),
        &["did you mean `objects`?"],
    );
    fails(
        "(«camra: Perspective(), objects: [])",
        &["did you mean `camera`?"],
    );
    fails("«(objects: [])", &["needs the field `camera`"]);
    fails(
        &format!("\n«Scene({CAMERA})"),
        &["needs the field `objects`"],
    );
    setting_fails("film: («sp: 3)", &["`sp`", "did you mean `spp`?"]);
}

#[test]
fn misspelt_names_get_a_suggestion() {
    object_fails("«Spere(radius: 3)", &["`Spere`", "did you mean `Sphere`?"]);
    object_fails(
        "Sphere(radius: 3, material: «\"gren\")",
        &["`gren`", "did you mean `green`?"],
    );
    object_fails(
        "Sphere(radius: 3, material: «\"chrome\")",
        &["no material `chrome`", "known here: "],
    );
    object_fails(
        "Instance(of: «\"blot\")",
        &["no definition `blot`", "did you mean `bolt`?"],
    );
    material_fails(
        "«Difuse(color: (1, 1, 1))",
        &["`Difuse`", "did you mean `Diffuse`?"],
    );
    material_fails(
        "Diffuse(color: «Cheker())",
        &["`Cheker`", "did you mean `Checker`?"],
    );
    material_fails(
        "Dielectric(ior: 1.5, fresnel: «Schlik)",
        &["`Schlik`", "did you mean `Schlick`?"],
    );
    setting_fails("integrator: «path()", &["`path`", "did you mean `Path`?"]);
    setting_fails(
        "environment: «Const(color: (1, 1, 1))",
        &["`Const`", "Constant"],
    );
    setting_fails("lights: [«Spot()]", &["`Spot`", "Point"]);
    setting_fails(
        "film: (filter: «Gausian(radius: 2))",
        &["`Gausian`", "did you mean `Gaussian`?"],
    );
    setting_fails(
        "film: (tonemap: «sRGB)",
        &["`sRGB`", "did you mean `Srgb`?"],
    );
    camera_fails("«Fisheye()", &["`Fisheye`", "Perspective"]);
}

#[test]
fn operators_must_have_operands() {
    object_fails(
        "Union(of: «[])",
        &["`[]`", "`of` of `Union`", "at least one"],
    );
    object_fails("Intersection(of: «[ /* a */ ])", &["is empty"]);
    object_fails("«Union()", &["needs the field `of`"]);
    object_fails("Union(of: «Sphere(radius: 1))", &["a list"]);
    object_fails("«Difference(subtract: [])", &["needs the field `from`"]);
    object_fails(
        "«Difference(from: Sphere(radius: 1))",
        &["needs the field `subtract`"],
    );
    object_fails(
        "Difference(from: «[Sphere(radius: 1)], subtract: [])",
        &["an object"],
    );
    object_fails("Union(of: [Sphere(radius: 1), «7])", &["`7`", "an object"]);
    object_fails(
        "Union(of: [Intersection(of: [Sphere(radius: «-1)])])",
        &["`-1`", "`radius` of `Sphere`"],
    );
}

#[test]
fn misspelt_operators_get_a_suggestion() {
    object_fails("«Unoin(of: [])", &["did you mean `Union`?"]);
    object_fails("«Diference(from: 1)", &["did you mean `Difference`?"]);
    object_fails("Union(«off: [])", &["`off`", "did you mean `of`?"]);
    object_fails(
        "Difference(from: Sphere(radius: 1), «substract: [])",
        &["did you mean `subtract`?"],
    );
    object_fails(
        "Union(of: [Sphere(radius: 1)], «subtract: [])",
        &["known here: of, name, material, transform"],
    );
    object_fails(
        "Union(of: [Union(of: [«Spere(radius: 1)])])",
        &["`Spere`", "did you mean `Sphere`?"],
    );
    object_fails(
        "Union(of: [Sphere(radius: 1, material: «\"gren\")], material: \"red\")",
        &["`gren`", "did you mean `green`?"],
    );
    object_fails(
        "Union(of: [Union(of: [Sphere(radius: 1)], material: «\"gren\")], material: \"red\")",
        &["`gren`", "did you mean `green`?"],
    );
    object_fails(
        "Union(of: [Instance(of: «\"blot\")])",
        &["no definition `blot`", "did you mean `bolt`?"],
    );
}

#[test]
fn the_first_mistake_of_a_tree_is_reported() {
    object_fails(
        "Union(of: [Union(of: [Sphere(radius: «-1)]), Sphere(radius: -2)])",
        &["`-1`"],
    );
    object_fails("Union(of: [Sphere(radius: -1)], «x: 3)", &["no field `x`"]);
}

/// A `Repeat` of a small sphere.
fn repeat(count: &str, rest: &str) -> String {
    format!(
        "Repeat(count: {count}, step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), of: Sphere(radius: 0.1){rest})"
    )
}

#[test]
fn repeats_must_count_from_one_to_their_limit() {
    object_fails(
        &repeat("(2, «0, 1)", ""),
        &["`0`", "`count` of `Repeat`", "1..=16777216"],
    );
    object_fails(&repeat("(2, «1.5, 1)", ""), &["`1.5`", "whole"]);
    object_fails(&repeat("«(2, 2)", ""), &["2 values"]);
    object_fails(
        &repeat("«(256, 256, 257)", ""),
        &["`(256, 256, 257)`", "16842752 copies", "at most 16777216"],
    );
    object_fails(&repeat("(1, 1, 1)", ", jitter: (0, «-1, 0)"), &["`-1`"]);
    object_fails(&repeat("(1, 1, 1)", ", seed: «-1"), &["`-1`"]);
    object_fails(&repeat("(1, 1, 1)", ", «sed: 1"), &["did you mean `seed`?"]);
    object_fails(
        "Repeat(count: (1, 1, 1), step: («1, 0, 0), of: Sphere(radius: 1))",
        &["`1`", "`step` of `Repeat`", "`(x, y, z)`"],
    );
    object_fails(
        "«Repeat(count: (1, 1, 1), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)))",
        &["needs the field `of`"],
    );
    object_fails(
        "Repeat(count: (1, 1, 1), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), of: «[Sphere(radius: 1)])",
        &["an object"],
    );
}

#[test]
fn repeats_of_repeats_must_not_exhaust_memory() {
    let outer = |inner: &str| {
        format!("Repeat(count: (64, 64, 4), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), of: {inner})")
    };
    let inner = repeat("(64, 64, 2)", "");
    object_fails(
        &format!("Union(of: [«{}])", outer(&inner)),
        &["beyond 67108864 operands", "`count`"],
    );
    object_fails(
        &format!("«{}", outer(&inner)),
        &["8388608 instances", "`count`"],
    );
    let scene =
        |used: &str| format!("({CAMERA}, definitions: {{\"grid\": {inner}}}, objects: [{used}])");
    let used = outer("Union(of: [Instance(of: \"grid\")])");
    fails(
        &scene(&format!("Union(of: [«{used}])")),
        &["beyond 67108864 operands"],
    );
    fails(
        &scene(&format!("«{}", outer("Instance(of: \"grid\")"))),
        &["8388608 instances"],
    );
}

#[test]
fn operands_must_stay_within_numbers() {
    let far = "Scale(1e12), ".repeat(13);
    object_fails(
        &format!(
            "«Union(of: [Union(of: [Sphere(radius: 1, transform: [{far}])], transform: [{far}])])"
        ),
        &["beyond what numbers can hold"],
    );
}

#[test]
fn colours_must_be_in_range() {
    material_fails(
        "Diffuse(color: (0.5, «1.5, 0))",
        &["`1.5`", "0..=1", "`Emissive`"],
    );
    material_fails("Diffuse(color: (0.5, «-0.5, 0))", &["`-0.5`"]);
    material_fails("Diffuse(color: «(1, 1))", &["2 values", "`(r, g, b)`"]);
    material_fails(
        "Mirror(color: Checker(a: (1, 1, «2)))",
        &["`2`", "`a` of `Checker`"],
    );
    material_fails(
        "Diffuse(color: Checker(step: «0))",
        &["`0`", "`step` of `Checker`"],
    );
    material_fails(
        "Diffuse(color: Checker(«stp: 1))",
        &["did you mean `step`?"],
    );
    material_fails("Emissive(radiance: (15, «-1, 15))", &["`-1`"]);
    material_fails("«Emissive()", &["needs the field `radiance`"]);
    material_fails("Dielectric(ior: «0)", &["`0`", "`ior` of `Dielectric`"]);
    setting_fails("environment: Constant(color: (0, 0, «-1))", &["`-1`"]);
    setting_fails(
        "lights: [Point(position: (0, 0, 0), intensity: (1, 1, «-1))]",
        &["`-1`", "`intensity` of `Point`"],
    );
}

#[test]
fn settings_must_be_in_range() {
    setting_fails("film: (size: («0, 10))", &["`0`", "1..=65536"]);
    setting_fails("film: (size: (10, «65537))", &["`65537`"]);
    setting_fails("film: (size: (10, «1.5))", &["`1.5`", "whole"]);
    setting_fails("film: (spp: «0)", &["`0`"]);
    setting_fails("film: (filter: Box(radius: «0))", &["`0`"]);
    setting_fails("integrator: Path(max_depth: «-1)", &["`-1`"]);
    setting_fails("integrator: Whitted(shadow_factor: «2)", &["`2`", "0..=1"]);
    setting_fails("integrator: Ao(radius: «0)", &["`0`"]);
    setting_fails(
        "integrator: Normals(«radius: 1)",
        &["`Normals` has no field `radius`"],
    );
}

#[test]
fn motions_must_be_possible() {
    let keys = |keys: &str| {
        format!(
            "Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45, motion: Smooth(keys: [{keys}]))"
        )
    };
    camera_fails(&keys("(frame: 3), (frame: «3)"), &["`3`", "key before, 3"]);
    camera_fails(&keys("(frame: «-1)"), &["`frame` of `key`", "`-1`"]);
    camera_fails(&keys("(frame: «1.5)"), &["`1.5`", "whole number"]);
    camera_fails(&keys("«(eye: (0, 0, 1))"), &["field `frame`"]);
    camera_fails(&keys("(frame: 0, «vfof: 3)"), &["did you mean `vfov`?"]);
    camera_fails(&keys("(frame: 0, vfov: «180)"), &["`180`"]);
    camera_fails(&keys("(frame: 0, look_at: «(0, 0, 9))"), &["looks nowhere"]);
    camera_fails(
        &keys("(frame: 0), «(frame: 1, eye: (0, 4, 0))"),
        &["along its `up`", "give the key another"],
    );
    camera_fails(
        "Panorama(eye: (0, 0, 9), look_at: (0, 0, 0), motion: Linear(keys: [(frame: 0, «vfov: 3)]))",
        &["no field `vfov`"],
    );
    let camera = |rest: &str| format!("Orthographic(eye: (0, 0, 9), look_at: (0, 0, 0), {rest})");
    camera_fails(
        &camera("height: «0"),
        &["`height` of `Orthographic`", "`0`"],
    );
    camera_fails(&camera("height: 1, «vfov: 9"), &["no field `vfov`"]);
    camera_fails(
        &camera("height: 1, motion: «Bezier(keys: [])"),
        &["`Bezier`", "Linear"],
    );
    camera_fails(
        &camera("height: 1, motion: Linear(keys: «[])"),
        &["has no keys"],
    );
}

#[test]
fn cameras_must_look_somewhere() {
    let camera = |rest: &str| format!("Perspective(eye: (0, 0, 9), {rest})");
    camera_fails(&camera("look_at: «(0, 0, 9), vfov: 45"), &["`(0, 0, 9)`"]);
    camera_fails(
        &camera("look_at: (0, 0, 0), up: «(0, 0, 2), vfov: 45"),
        &["`(0, 0, 2)`", "along the view"],
    );
    camera_fails(
        "«Perspective(eye: (0, 5, 0), look_at: (0, 0, 0), vfov: 45)",
        &["y axis", "`up`"],
    );
    camera_fails(
        &camera("look_at: (0, 0, 0), vfov: «180"),
        &["`180`", "between 0 and 180"],
    );
    camera_fails(&camera("look_at: (0, 0, 0), vfov: «0"), &["`0`"]);
    camera_fails(
        &camera("look_at: (0, 0, 0), vfov: 9, aperture: «-1"),
        &["`-1`"],
    );
    camera_fails(&camera("look_at: (0, 0, 0), vfov: 9, focus: «0"), &["`0`"]);
    camera_fails(
        "«Perspective(look_at: (0, 0, 0), vfov: 9)",
        &["needs the field `eye`"],
    );
}

#[test]
fn names_must_be_given_once() {
    fails(
        &format!("({CAMERA}, objects: [], materials: {{\"a\": Mirror(), «\"a\": Mirror()}})"),
        &["`a` is given twice"],
    );
    fails(
        &format!(
            "({CAMERA}, objects: [], definitions: {{\"a\": Sphere(radius: 1), «\"a\": Sphere(radius: 2)}})"
        ),
        &["`a` is given twice"],
    );
}

#[test]
fn definitions_must_not_contain_themselves() {
    fails(
        &format!(
            "({CAMERA}, objects: [],\n definitions: {{\"a\": Instance(of: \"b\"),\n \"b\": Instance(of: «\"a\")}})"
        ),
        &["contains itself", "`a` → `b` → `a`"],
    );
    let chain: Vec<String> = (0..500)
        .map(|i| format!("\"d{i}\": Instance(of: \"d{}\"),\n", i + 1))
        .collect();
    let chain = chain.concat().replace("of: \"d64\"", "of: «\"d64\"");
    fails(
        &format!("({CAMERA}, objects: [], definitions: {{\n{chain} \"d500\": Sphere(radius: 1)}})"),
        &["more than 64 definitions"],
    );
}

#[test]
fn syntax_errors_point_at_the_token() {
    fails("(camera: «}", &["a value", "`}`"]);
    fails("(\n film: «(spp: 3,\n ", &["`(` is never closed"]);
    fails("(film: (spp: 3 «size: (1, 2)))", &["`,` or `)`", "`s`"]);
    fails("(«film (spp: 3))", &["need their names"]);
    fails("(film: (spp: «3x))", &["`3x` is not a number"]);
    fails("(film: «\"abc", &["never ends"]);
    fails("(film: \"ab«\\qc\")", &["`\\q`"]);
    fails("«/* (film: 3)", &["comment is never closed"]);
    fails(
        &format!("({CAMERA}, objects: []) «)"),
        &["the end of the file", "`)`"],
    );
    fails(" «", &["a value", "the end of the file"]);
    fails("[«1, 2]", &["the fields of `Scene`"]);
    fails("«Scne(film: ())", &["the fields of `Scene`"]);
}

#[test]
fn json_errors_point_at_the_value_too() {
    let json = |objects: &str| {
        format!(
            "{{\n \"camera\": {{\"Perspective\": {{\"eye\": [0, 0, 9], \"look_at\": [0, 0, 0], \"vfov\": 45}}}},\n \"objects\": [{objects}]}}"
        )
    };
    let fails = |objects: &str, parts: &[&str]| fails_as("test.json", &json(objects), parts);
    fails(
        "{\"Sphere\": {\"radius\": «-3}}",
        &["`-3`", "`radius` of `Sphere`"],
    );
    fails(
        "{\"Sphere\": {«\"raduis\": 3}}",
        &["did you mean `radius`?"],
    );
    fails("{«\"Spere\": {\"radius\": 3}}", &["did you mean `Sphere`?"]);
    fails(
        "{\"Sphere\": {\"radius\": 3, \"material\": «\"green\"}}",
        &["no material `green`"],
    );
    fails(
        "{\"Sphere\": {\"center\": «[0, 0], \"radius\": 3}}",
        &["2 values"],
    );
    fails("{\"Sphere\": «3}", &["the fields of `Sphere`"]);
    fails("{\"Sphere\": {\"radius\": 3, «}}", &["not valid JSON"]);
    fails(
        "{\"Sphere\": {\"radius\": 3}} «/* round */",
        &["not valid JSON"],
    );
}

#[test]
fn deep_nesting_is_an_error_and_no_overflow() {
    for open in ["(", "[", "{\"a\":", "Some("] {
        let error = SceneDescription::from_text("deep.ron", &open.repeat(100_000)).unwrap_err();
        assert!(
            error
                .message()
                .contains("65536 brackets inside one another"),
            "{error}"
        );
    }
    for (open, close) in [
        ("(", ")"),
        ("[", "]"),
        ("{\"a\":", "}"),
        ("Some(", ")"),
        ("a(b:", ")"),
    ] {
        let text = format!("{}1{}", open.repeat(65_000), close.repeat(65_000));
        let error = SceneDescription::from_text("deep.ron", &text).unwrap_err();
        assert!(!error.message().contains("brackets"), "{error}");
    }
    let nest = format!("{}1{}", "{\"a\":".repeat(65_000), "}".repeat(65_000));
    assert!(SceneDescription::from_text("deep.json", &nest).is_err());
    object_fails(
        &format!(
            "{}Union(of: [Sphere«(radius: 1){}",
            "Union(of: [".repeat(32_766),
            "])".repeat(32_767)
        ),
        &["more than 65536 brackets"],
    );
    let error = SceneDescription::from_text("deep.ron", &"/*".repeat(100_000)).unwrap_err();
    assert!(error.message().contains("comment"));
}

#[test]
fn no_mutation_of_a_scene_file_panics_or_loses_its_place() {
    let originals = [
        ("all.ron", super::scene_file::RON),
        ("all.json", super::scene_file::JSON),
    ];
    let pieces = [
        "(", ")", "[", "{", "\"", "\\u{", "-1", "1e999", "NaN", ",", ":", "é", "/*", "//", "#",
        "None", "r#\"", "\u{0}",
    ];
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let mut accepted = 0;
    for i in 0..4_000 {
        let (file, original) = originals[i % 2];
        let mut text: Vec<char> = original.chars().collect();
        for _ in 0..=random(3) {
            let at = random(text.len());
            match random(4) {
                0 => drop(text.remove(at)),
                1 => drop(text.splice(at..at, pieces[random(pieces.len())].chars())),
                2 => {
                    let end = (at + random(40)).min(text.len());
                    drop(text.drain(at..end));
                }
                _ => {
                    let other = random(text.len());
                    text.swap(at, other);
                }
            }
        }
        let text: String = text.into_iter().collect();
        match SceneDescription::from_text(file, &text).and_then(|d| d.load()) {
            Ok(_) => accepted += 1,
            Err(error) => {
                let place = error.place().expect("a place");
                let line = place.line.expect("a line");
                assert!(line <= text.lines().count() + 1, "{error}");
            }
        }
    }
    assert!(
        (20..2_000).contains(&accepted),
        "{accepted} of 4000 mutations accepted"
    );
}

#[test]
fn files_are_looked_for_beside_the_scene() {
    fails_as(
        "test.ron",
        &format!("({CAMERA},\n objects: [Mesh(file: «\"none.obj\")])"),
        &["`none.obj`", "test.ron"],
    );
    fails_as(
        "test.ron",
        &format!(
            "({CAMERA}, objects: [], materials: {{\"a\": Diffuse(color: Image(file: «\"none.png\"))}})"
        ),
        &["`none.png`"],
    );
}

#[test]
fn files_outside_the_scenes_tree_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = |name: &str| {
        let path = root.path().join(name);
        std::fs::create_dir_all(&path).unwrap();
        path
    };
    let (scenes, assets, other) = (folder("scenes"), folder("assets"), folder("other"));
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for folder in [&scenes, &assets, &other] {
        std::fs::write(folder.join("girl.obj"), triangle).unwrap();
    }
    let load = |in_folder: &Path, file: &str, allow: &[&Path]| {
        let path = in_folder.join("test.ron");
        let marked = format!("({CAMERA}, objects: [Mesh(file: «\"{file}\")])");
        std::fs::write(&path, marked.replace('«', "")).unwrap();
        let options = ReadOptions {
            allow_paths: allow.iter().map(|p| p.to_path_buf()).collect(),
            ..ReadOptions::default()
        };
        let refusal = read_scene(&path, &options).err();
        let refusal = refusal.filter(|e| e.message().contains("outside"));
        if let Some(error) = &refusal {
            check(error, &marked, &[file, "--allow-path"]);
        }
        refusal.is_none()
    };
    assert!(load(&scenes, "girl.obj", &[]));
    assert!(load(&scenes, "../assets/girl.obj", &[]));
    assert!(!load(&scenes, "../other/girl.obj", &[]));
    assert!(load(&scenes, "../other/girl.obj", &[&other]));
    assert!(!load(&other, "../assets/girl.obj", &[]));
    assert!(!load(
        &scenes,
        other.join("girl.obj").to_str().unwrap(),
        &[]
    ));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(other.join("girl.obj"), scenes.join("link.obj")).unwrap();
        assert!(!load(&scenes, "link.obj", &[]));
    }
    let near = scenes.join("near.ron");
    let marked = format!("({CAMERA}, objects: [Mesh(file: «\"../assets/gril.obj\")])");
    std::fs::write(&near, marked.replace('«', "")).unwrap();
    let error = read_scene(&near, &ReadOptions::default()).unwrap_err();
    check(
        &error,
        &marked,
        &["`../assets/gril.obj`", "did you mean `girl.obj`?"],
    );
    assert_eq!(error.kind(), ErrorKind::Read);
}

#[test]
fn inputs_that_are_no_scene_are_named() {
    let options = ReadOptions::default();
    let missing = read_scene(Path::new("nowhere/none.ron"), &options).unwrap_err();
    assert_eq!(missing.kind(), ErrorKind::Read);
    assert!(missing.to_string().contains("nowhere/none.ron"));
    let picture = read_scene(Path::new("a.tiff"), &options).unwrap_err();
    assert!(picture.to_string().contains("`tiff`"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("latin1.ron");
    std::fs::write(&path, b"(film:\n \"\xe9\")").unwrap();
    let error = SceneDescription::read(&path).unwrap_err();
    let place = error.place().unwrap();
    assert_eq!((place.line, place.column), (Some(2), Some(3)));
    assert!(error.message().contains("0xe9"));
}

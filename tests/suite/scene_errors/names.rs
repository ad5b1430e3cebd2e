//! Fields and names: misspelt, given twice, in circles.

use super::{CAMERA, camera_fails, fails, material_fails, object_fails, setting_fails};

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
    setting_fails("lights: [«Spto()]", &["`Spto`", "Spot"]);
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

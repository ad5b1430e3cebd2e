//! Set operations and repetitions.

use super::{CAMERA, fails, object_fails};

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
fn operands_must_have_an_inside() {
    let parts = ["has no inside", "thin `Box`"];
    object_fails("Union(of: [«Disk(normal: (0, 0, 1), radius: 1)])", &parts);
    object_fails(
        "Difference(from: Sphere(radius: 1), subtract: [«Rectangle(size: (1, 1))])",
        &parts,
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

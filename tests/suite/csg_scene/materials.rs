//! Which material an operand has.

use solidtrace::scene::Scene;

use super::{distinct_materials, material, only, radius, repeat, scene};

/// The materials of all operands by name, in the operands' order.
fn materials(scene: &Scene) -> Vec<&str> {
    let csg = only(scene);
    (0..csg.len() as u32)
        .map(|i| material(scene, i, 0))
        .collect()
}

#[test]
fn operands_have_their_own_materials_or_the_default() {
    let scene = scene(
        "Union(of: [Sphere(radius: 1, material: \"red\"), Sphere(radius: 2), Sphere(radius: 3, material: \"green\"),
            Difference(from: Sphere(radius: 4, material: \"red\"), subtract: [Sphere(radius: 5)])])",
        "",
    );
    assert_eq!(
        materials(&scene),
        ["red", "default", "green", "red", "default"]
    );
    assert_eq!(distinct_materials(&scene), 3);
}

#[test]
fn a_material_above_is_shared_and_the_outermost_wins() {
    let inner = |rest: &str| {
        format!(
            "Difference(from: Sphere(radius: 1, material: \"red\"), subtract: [Sphere(radius: 2),
                Union(of: [Sphere(radius: 3, material: \"red\")], material: \"green\")]{rest})"
        )
    };
    let beside = |inner: &str, rest: &str| {
        scene(
            &format!("Union(of: [{inner}, Sphere(radius: 4, material: \"red\")]{rest})"),
            "",
        )
    };
    let none = beside(&inner(""), "");
    assert_eq!(materials(&none), ["red", "default", "green", "red"]);
    let one = beside(&inner(", material: \"blue\""), "");
    assert_eq!(materials(&one), ["blue", "blue", "blue", "red"]);
    assert_eq!(distinct_materials(&one), 2);
    let all = beside(&inner(", material: \"blue\""), ", material: \"green\"");
    assert_eq!(materials(&all), ["green"; 4]);
    assert_eq!(distinct_materials(&all), 1);
}

#[test]
fn copies_share_the_material_of_their_repeat_or_have_their_own() {
    let pair = "Union(of: [Sphere(radius: 1, material: \"red\"), Sphere(radius: 2)])";
    let own = scene(&format!("Union(of: [{}])", repeat(pair, "")), "");
    assert_eq!(materials(&own), ["red", "default"].repeat(4));
    assert_eq!(distinct_materials(&own), 2);
    let shared = repeat(pair, ", material: \"blue\"");
    let shared = scene(&format!("Union(of: [{shared}])"), "");
    assert_eq!(materials(&shared), ["blue"; 8]);
}

#[test]
fn instances_share_their_material_or_have_the_definitions() {
    let scene = scene(
        "Union(of: [Instance(of: \"pair\"), Instance(of: \"pair\", material: \"blue\"), Instance(of: \"ball\"),
            Instance(of: \"ball\", material: \"green\"), Instance(of: \"again\"), Instance(of: \"grid\")])",
        "\"pair\": Union(of: [Sphere(radius: 1, material: \"red\"), Sphere(radius: 2, material: \"green\")]),
         \"again\": Instance(of: \"pair\", material: \"red\"), \"ball\": Sphere(radius: 3),
         \"grid\": Repeat(count: (1, 2, 1), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), of: Sphere(radius: 4, material: \"blue\"))",
    );
    let expected = [
        "red", "green", "blue", "blue", "default", "green", "red", "red", "blue", "blue",
    ];
    assert_eq!(materials(&scene), expected);
    assert_eq!(distinct_materials(&scene), 4);
    let radii: Vec<f64> = (0..10).map(|i| radius(only(&scene), i)).collect();
    assert_eq!(radii, [1.0, 2.0, 1.0, 2.0, 3.0, 3.0, 1.0, 2.0, 4.0, 4.0]);
}

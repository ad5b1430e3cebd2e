//! Nests of many levels, and trees that programs put together.

use glam::DVec3;
use solidtrace::geometry::{CsgOp, Shape, Solid};
use solidtrace::math::Transform;
use solidtrace::scene::description::{
    ObjectDescription, ObjectTree, Offset, Reference, ShapeDescription,
};
use solidtrace::scene::{Repeat, Scene, SceneDescription};

use super::{only, origin};

/// Text around `n` levels of `open` and `close`, and its format's file name.
fn nest(open: &str, inner: &str, close: &str, n: usize) -> String {
    format!("{}{inner}{}", open.repeat(n), close.repeat(n))
}

#[test]
fn nests_of_ten_thousand_levels_are_read_and_loaded() {
    let levels = 10_000;
    let ball = "Sphere(radius: 1)";
    let union = nest("Union(of: [", ball, "])", levels);
    let first = nest(
        "Difference(from: ",
        ball,
        ", subtract: [Sphere(radius: 0.1)])",
        levels,
    );
    let last = nest(
        "Difference(from: Sphere(radius: 2), subtract: [",
        ball,
        "])",
        levels,
    );
    let moved = nest(
        "Union(of: [",
        ball,
        "], transform: [Translate((1, 0, 0))])",
        levels,
    );
    let json = nest(
        "{\"Union\": {\"of\": [{\"Sphere\": {\"radius\": 2}}, ",
        "{\"Sphere\": {\"radius\": 1}}",
        "]}}",
        levels,
    );
    let ron = |object: &str| {
        (
            "a.ron",
            format!(
                "(camera: Perspective(eye: (0, 0, 1), look_at: (0, 0, 0), vfov: 45), objects: [{object}])"
            ),
        )
    };
    let json = format!(
        "{{\"camera\": {{\"Perspective\": {{\"eye\": [0, 0, 1], \"look_at\": [0, 0, 0], \"vfov\": 45}}}}, \"objects\": [{json}]}}"
    );
    for ((file, text), leaves) in [
        (ron(&union), 1),
        (ron(&first), levels + 1),
        (ron(&last), levels + 1),
        (ron(&moved), 1),
        (("a.json", json), levels + 1),
    ] {
        let description = SceneDescription::from_text(file, &text).unwrap();
        assert_eq!(description, description.clone());
        let scene = description.load().unwrap();
        assert_eq!((only(&scene).len(), only(&scene).results()), (leaves, 1));
    }
    let scene = SceneDescription::from_text("a.ron", &ron(&moved).1)
        .unwrap()
        .load()
        .unwrap();
    // The outermost transform is the instance's.
    assert_eq!(origin(only(&scene), 0), [9999.0, 0.0, 0.0]);
    let repeats = nest(
        "Repeat(count: (1, 1, 1), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), of: ",
        ball,
        ")",
        levels,
    );
    let scene = scene_of(&ron(&repeats).1);
    assert_eq!(
        scene.instances[0].shape,
        Shape::Solid(Solid::Sphere { radius: 1.0 })
    );
    assert_eq!(
        only(&scene_of(&ron(&format!("Union(of: [{repeats}])")).1)).len(),
        1
    );
}

fn scene_of(text: &str) -> Scene {
    SceneDescription::from_text("a.ron", text)
        .unwrap()
        .load()
        .unwrap()
}

#[test]
fn trees_that_programs_put_together_wrong_are_errors() {
    let object = |shape| ObjectDescription {
        name: None,
        material: None,
        transform: Transform::IDENTITY,
        shape,
        offset: Offset::default(),
    };
    let ball = || {
        object(ShapeDescription::Solid {
            solid: Solid::Sphere { radius: 1.0 },
            placement: Transform::IDENTITY,
        })
    };
    let op = |operands| {
        let op = CsgOp::Union;
        object(ShapeDescription::Csg { op, operands })
    };
    let repeat = |count| {
        object(ShapeDescription::Repeat(Repeat {
            count,
            step: [DVec3::X; 3],
            jitter: DVec3::ZERO,
            seed: 0,
        }))
    };
    let load = |tree: Vec<ObjectDescription>| {
        let description = SceneDescription {
            objects: vec![ObjectTree(tree.clone())],
            ..SceneDescription::default()
        };
        let outcome = description.load();
        let definition = SceneDescription {
            definitions: vec![("a".into(), ObjectTree(tree))],
            ..SceneDescription::default()
        };
        assert_eq!(definition.load().is_ok(), outcome.is_ok());
        outcome
            .map(|scene| scene.instances.len())
            .map_err(|e| e.to_string())
    };
    let fails = |tree, part: &str| {
        let error = load(tree).unwrap_err();
        assert!(error.contains(part), "{error}");
    };
    assert_eq!(load(vec![ball(), ball(), op(2)]), Ok(1));
    assert_eq!(load(vec![ball(), repeat([2, 3, 1])]), Ok(6));
    fails(vec![], "0 objects");
    fails(vec![ball(), ball()], "2 objects");
    fails(vec![op(0)], "no operands");
    fails(vec![ball(), op(2)], "takes 2 objects");
    fails(vec![repeat([1; 3])], "takes 1 objects");
    fails(vec![ball(), repeat([3, 0, 1])], "[3, 0, 1]");
    fails(vec![ball(), repeat([u32::MAX; 3])], "instances");
    fails(vec![ball(), repeat([u32::MAX; 3]), op(1)], "operands");
    let of = Reference {
        name: "b".into(),
        ..Reference::default()
    };
    fails(
        vec![object(ShapeDescription::Instance { of }), op(1)],
        "no definition `b`",
    );
}

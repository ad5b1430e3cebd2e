//! What a scene file says of CSG is what the CSG objects of the scene are.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use solidtrace::geometry::{Csg, CsgOp, Operand, Shape, Solid};
use solidtrace::io::{OpenMeshOperands, ReadOptions};
use solidtrace::math::Transform;
use solidtrace::scene::description::{
    ObjectDescription, ObjectTree, Offset, Reference, ShapeDescription,
};
use solidtrace::scene::{Instance, Repeat, Scene, SceneDescription};

/// A scene in `folder` with three materials.
fn describe(folder: &Path, objects: &str, definitions: &str) -> SceneDescription {
    let text = format!(
        "(camera: Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45),
        materials: {{\"red\": Mirror(), \"green\": Mirror(), \"blue\": Mirror()}},
        objects: [{objects}], definitions: {{{definitions}}})"
    );
    let description = SceneDescription::from_text(folder.join("test.ron"), &text);
    description.unwrap_or_else(|e| panic!("{e}"))
}

fn scene_in(folder: &Path, objects: &str, definitions: &str) -> Scene {
    let scene = describe(folder, objects, definitions).load();
    scene.unwrap_or_else(|e| panic!("{e}"))
}

fn scene(objects: &str, definitions: &str) -> Scene {
    scene_in(Path::new("."), objects, definitions)
}

fn csg_of<'a>(scene: &'a Scene, instance: &Instance) -> &'a Csg {
    match instance.shape {
        Shape::Csg(id) => &scene.csgs[id.0 as usize],
        other => panic!("{other:?} is no CSG object"),
    }
}

/// The only CSG object of a scene with one object.
fn only(scene: &Scene) -> &Csg {
    assert_eq!((scene.instances.len(), scene.csgs.len()), (1, 1));
    csg_of(scene, &scene.instances[0])
}

/// The materials of all operands by name, in the operands' order.
fn materials(scene: &Scene) -> Vec<&str> {
    let csg = only(scene);
    (0..csg.len() as u32)
        .map(|i| material(scene, i, 0))
        .collect()
}

/// The material in a slot of an operand.
fn material(scene: &Scene, operand: u32, slot: u32) -> &str {
    let id = scene.instances[0].material(only(scene).slot(operand, slot));
    &scene.materials[id.0 as usize].name
}

/// How many materials the only instance has, which must all differ.
fn distinct_materials(scene: &Scene) -> usize {
    let materials = &scene.instances[0].materials;
    for (i, material) in materials.iter().enumerate() {
        assert!(!materials[..i].contains(material), "{materials:?}");
    }
    materials.len()
}

fn sphere(radius: f64) -> Operand {
    Operand::Solid(Solid::Sphere { radius })
}

fn radius(csg: &Csg, operand: u32) -> f64 {
    match csg.operand(operand).0 {
        Operand::Solid(Solid::Sphere { radius }) => radius,
        other => panic!("{other:?} is no sphere"),
    }
}

fn at(position: [f64; 3]) -> Transform {
    Transform::rigid(DMat3::IDENTITY, DVec3::from(position))
}

fn origin(csg: &Csg, operand: u32) -> [f64; 3] {
    csg.operand(operand).1.matrix().translation.to_array()
}

#[test]
fn operators_and_operands_are_those_of_the_file_in_its_order() {
    let scene = scene(
        "Difference(from: Intersection(of: [Sphere(radius: 1), Sphere(radius: 2)]), subtract: [
            Union(of: [Sphere(radius: 3), Sphere(radius: 4), Sphere(radius: 5)]), Sphere(radius: 6)])",
        "",
    );
    let mut expected = Csg::default();
    let push = |csg: &mut Csg, radius| csg.push(sphere(radius), &Transform::IDENTITY, 0..1);
    push(&mut expected, 1.0);
    push(&mut expected, 2.0);
    expected.combine(CsgOp::Intersection, 2);
    for radius in [3.0, 4.0, 5.0] {
        push(&mut expected, radius);
    }
    expected.combine(CsgOp::Union, 3);
    push(&mut expected, 6.0);
    expected.combine(CsgOp::Difference, 3);
    assert_eq!(*only(&scene), expected);
    assert_eq!(only(&scene).results(), 1);
}

#[test]
fn a_difference_from_which_nothing_is_subtracted_is_whole() {
    let scene = scene("Difference(from: Sphere(radius: 1), subtract: [])", "");
    let mut expected = Csg::default();
    expected.push(sphere(1.0), &Transform::IDENTITY, 0..1);
    expected.combine(CsgOp::Difference, 1);
    assert_eq!(*only(&scene), expected);
}

#[test]
fn a_plane_is_the_half_space_against_its_normal() {
    let scene = scene(
        "Union(of: [Plane(point: (0, 5, 0), normal: (0, 1, 0)), Sphere(radius: 1)])",
        "",
    );
    let (operand, place) = only(&scene).operand(0);
    let Operand::Solid(solid) = operand else {
        panic!("{operand:?}");
    };
    let inside = |y| solid.contains(place.inverse_point(DVec3::new(3.0, y, -2.0)));
    assert!(inside(4.9) && !inside(5.1) && inside(-1e6));
}

#[test]
fn transforms_apply_from_the_operand_outward() {
    let scene = scene(
        "Union(of: [Difference(from: Sphere(center: (1, 0, 0), radius: 1, transform: [Scale((2, 1, 1))]),
            subtract: [], transform: [Translate((0, 3, 0)), Rotate(axis: (0, 0, 1), degrees: 90)])],
            transform: [Matrix(((1, 0, 0), (1, 1, 0), (0, 0, 1), (0, 0, 10)))])",
        "",
    );
    // The root's own transform is the instance's.
    let (_, place) = only(&scene).operand(0);
    let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
    let scale = DMat3::from_diagonal(DVec3::new(2.0, 1.0, 1.0));
    // The centre (1, 0, 0) is scaled to (2, 0, 0), lifted to (2, 3, 0) and turned to (-3, 2, 0).
    let expected = DAffine3::from_mat3_translation(quarter * scale, DVec3::new(-3.0, 2.0, 0.0));
    assert!(place.matrix().abs_diff_eq(expected, 1e-14), "{place:?}");
    let product = *place.inverse_matrix() * expected;
    assert!(product.abs_diff_eq(DAffine3::IDENTITY, 1e-14), "{place:?}");
    let sheared = scene.instances[0]
        .world_from_object
        .point(DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(sheared.to_array(), [3.0, 2.0, 13.0]);
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

/// `of` four times.
fn repeat(of: &str, rest: &str) -> String {
    format!("Repeat(count: (2, 2, 1), step: ((10, 0, 0), (0, 20, 0), (0, 0, 30)), of: {of}{rest})")
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

#[test]
fn all_parts_of_a_model_are_united() {
    let folder = tempfile::tempdir().unwrap();
    let corners: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let indices: [u16; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    std::fs::write(folder.path().join("t.bin"), bytes).unwrap();
    let gltf = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}], "scene": 0,
        "nodes": [{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b", "translation": [4, 0, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"uri": "t.bin", "byteLength": 72}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]}"#;
    std::fs::write(folder.path().join("t.gltf"), gltf).unwrap();
    let objects = "Difference(from: Sphere(radius: 9), subtract: [Mesh(file: \"t.gltf\", transform: [Scale(2)])])";
    let scene = scene_in(folder.path(), objects, "");
    let csg = only(&scene);
    let (operand, place) = csg.operand(1);
    let mut expected = Csg::default();
    expected.push(sphere(9.0), &Transform::IDENTITY, 0..1);
    expected.push(operand, &place, 0..1);
    expected.push(operand, &csg.operand(2).1, 0..1);
    expected.combine(CsgOp::Union, 2);
    expected.combine(CsgOp::Difference, 2);
    assert_eq!(*csg, expected);
    assert_eq!(origin(csg, 2), [8.0, 0.0, 0.0]);
}

#[test]
fn instances_of_a_definition_share_one_object() {
    let scene = scene(
        "Instance(of: \"bolt\"), Instance(of: \"two\", material: \"red\", name: \"second\"),
         Union(of: [Instance(of: \"inlined\")])",
        "\"unused\": Union(of: [Sphere(radius: 1)]), \"inlined\": Union(of: [Sphere(radius: 2)]),
         \"bolt\": Union(of: [Sphere(radius: 3, material: \"green\")], transform: [Scale(2)], name: \"bolt\"),
         \"two\": Instance(of: \"bolt\", transform: [Translate((1, 0, 0))])",
    );
    assert_eq!((scene.instances.len(), scene.csgs.len()), (3, 2));
    let [first, second, third] = &scene.instances[..] else {
        panic!();
    };
    assert_eq!(first.shape, second.shape);
    assert_eq!(radius(csg_of(&scene, first), 0), 3.0);
    assert_eq!(radius(csg_of(&scene, third), 0), 2.0);
    let name = |instance: &Instance| &scene.materials[instance.material(0).0 as usize].name;
    assert_eq!((&**name(first), &**name(second)), ("green", "red"));
    assert_eq!(second.name.as_deref(), Some("second/bolt"));
    let moved = second.world_from_object.point(DVec3::X);
    assert_eq!(moved.to_array(), [3.0, 0.0, 0.0]);
}

#[test]
fn a_csg_object_is_inlined_where_its_instance_is_an_operand() {
    let scene = scene(
        "Difference(from: Sphere(radius: 9), subtract: [Instance(of: \"pair\", transform: [Scale(3), Translate((0, 0, 1))])])",
        "\"pair\": Intersection(of: [Sphere(radius: 1, center: (1, 0, 0)), Instance(of: \"ball\")], transform: [Translate((0, 1, 0))]),
         \"ball\": Sphere(radius: 2, center: (0, 0, 4))",
    );
    let csg = only(&scene);
    assert_eq!((csg.len(), csg.results()), (3, 1));
    assert_eq!([1, 2].map(|i| radius(csg, i)), [1.0, 2.0]);
    assert_eq!(origin(csg, 1), [3.0, 3.0, 1.0]);
    assert_eq!(origin(csg, 2), [0.0, 3.0, 13.0]);
    let thrice = DMat3::from_diagonal(DVec3::splat(3.0));
    assert_eq!(csg.operand(2).1.matrix().matrix3, thrice);
}

#[test]
fn a_repeat_as_an_operand_is_the_union_of_its_copies() {
    let ball = "Sphere(center: (1, 0, 0), radius: 0.5)";
    let turn = ", transform: [Rotate(axis: (0, 0, 1), degrees: 90), Translate((0, 0, 5))]";
    let scene = scene(
        &format!(
            "Difference(from: Sphere(radius: 9), subtract: [{}, Sphere(radius: 8)])",
            repeat(ball, turn)
        ),
        "",
    );
    let csg = only(&scene);
    let places: Vec<Transform> = (1..5).map(|i| csg.operand(i).1).collect();
    let mut expected = Csg::default();
    expected.push(sphere(9.0), &Transform::IDENTITY, 0..1);
    let mut one = Csg::default();
    one.push(sphere(0.5), &at([1.0, 0.0, 0.0]), 0..1);
    let back = at([-1.0, 0.0, 0.0]);
    expected.append(&one, places.iter().map(|place| place.after(&back)), 0..1);
    expected.combine(CsgOp::Union, 4);
    expected.push(sphere(8.0), &Transform::IDENTITY, 0..1);
    expected.combine(CsgOp::Difference, 3);
    assert_eq!((csg.len(), csg.results()), (6, 1));
    // (x, y, z) turns to (-y, x, z); the copies stand at (1, 0), (11, 0), (1, 20), (11, 20).
    let positions = [[0.0, 1.0], [0.0, 11.0], [-20.0, 1.0], [-20.0, 11.0]];
    for (place, [x, y]) in places.iter().zip(positions) {
        let origin = place.matrix().translation;
        assert!(
            (origin - DVec3::new(x, y, 5.0)).length() < 1e-13,
            "{origin}"
        );
        let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        assert!(place.matrix().matrix3.abs_diff_eq(quarter, 1e-15));
    }
    for i in 0..6 {
        assert_eq!(csg.operand(i).0, expected.operand(i).0);
    }
}

#[test]
fn a_repeat_of_a_repeat_and_of_operators_copies_all_of_it() {
    let pair =
        "Difference(from: Sphere(radius: 1), subtract: [Sphere(radius: 2, center: (1, 0, 0))])";
    let inner = repeat(pair, "");
    let outer = format!(
        "Repeat(count: (1, 1, 3), step: ((0, 0, 0), (0, 0, 0), (0, 0, 100)), of: {inner}, transform: [Scale(2)])"
    );
    for text in [
        format!("Union(of: [Sphere(radius: 7), {outer}])"),
        "Union(of: [Sphere(radius: 7), Instance(of: \"grid\")])".into(),
    ] {
        let scene = scene(&text, &format!("\"grid\": {outer}"));
        let csg = only(&scene);
        assert_eq!((csg.len(), csg.results()), (25, 1));
        for copy in 0..12_u32 {
            let [i, j, k] = [copy % 2, copy / 2 % 2, copy / 4].map(f64::from);
            let [x, y, z] = [20.0 * i, 40.0 * j, 200.0 * k];
            assert_eq!(origin(csg, 1 + 2 * copy), [x, y, z]);
            assert_eq!(origin(csg, 2 + 2 * copy), [x + 2.0, y, z]);
            assert_eq!(radius(csg, 2 + 2 * copy), 2.0);
        }
    }
}

#[test]
fn a_repeat_in_the_world_is_so_many_instances() {
    let ball = "Sphere(radius: 1, center: (1, 0, 0), name: \"ball\", material: \"red\")";
    let named = scene(&repeat(ball, ", name: \"grid\", transform: [Scale(2)]"), "");
    let names: Vec<_> = named
        .instances
        .iter()
        .map(|i| i.name.as_deref().unwrap())
        .collect();
    let expected = [
        "grid[0,0,0]/ball",
        "grid[1,0,0]/ball",
        "grid[0,1,0]/ball",
        "grid[1,1,0]/ball",
    ];
    assert_eq!(names, expected);
    let origins = |scene: &Scene| -> Vec<[f64; 3]> {
        let origin = |i: &Instance| i.world_from_object.point(DVec3::ZERO).to_array();
        scene.instances.iter().map(origin).collect()
    };
    let expected = [[2.0, 0.0], [22.0, 0.0], [2.0, 40.0], [22.0, 40.0]];
    assert_eq!(origins(&named), expected.map(|[x, y]| [x, y, 0.0]));

    let twice = scene(
        "Instance(of: \"grid\"), Instance(of: \"grid\", material: \"blue\", name: \"b\")",
        &format!("\"grid\": {}", repeat("Union(of: [Sphere(radius: 1)])", "")),
    );
    assert_eq!((twice.instances.len(), twice.csgs.len()), (8, 1));
    assert_eq!(twice.instances[7].name.as_deref(), Some("b"));
    let expected = [[0.0, 0.0], [10.0, 0.0], [0.0, 20.0], [10.0, 20.0]].repeat(2);
    let expected: Vec<[f64; 3]> = expected.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    assert_eq!(origins(&twice), expected);
}

/// The definition of PCG-XSH-RR 64/32 (O'Neill 2014).
struct Pcg {
    state: u64,
    increment: u64,
}

impl Pcg {
    fn new(seed: u64, stream: u64) -> Self {
        let increment = stream << 1 | 1;
        let mut pcg = Self {
            state: 0,
            increment,
        };
        pcg.next();
        pcg.state = pcg.state.wrapping_add(seed);
        pcg.next();
        pcg
    }

    fn next(&mut self) -> u32 {
        let old = self.state;
        self.state = old
            .wrapping_mul(6364136223846793005)
            .wrapping_add(self.increment);
        let shifted = ((old >> 18 ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }
}

#[test]
fn jitter_is_what_the_generators_definition_gives() {
    // The first numbers of the demonstration that comes with the generator.
    let mut demo = Pcg::new(42, 54);
    assert_eq!(
        [0; 3].map(|_: u32| demo.next()),
        [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330]
    );

    let repeat = Repeat {
        count: [2, 1, 2],
        step: [DVec3::X, DVec3::Y, DVec3::Z],
        jitter: DVec3::new(0.25, 0.0, 2.0),
        seed: 7,
    };
    let mut pcg = Pcg::new(7, 0x0a02_bdbf_7bb3_c0a7);
    let mut uniform = || (f64::from(pcg.next()) + 0.5) / 2_147_483_648.0 - 1.0;
    let grid = [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]];
    let expected = grid.map(|index: [u32; 3]| {
        let [x, _, z] = [uniform(), uniform(), uniform()];
        let [i, j, k] = index.map(f64::from);
        (index, DVec3::new(i + 0.25 * x, j, k + 2.0 * z))
    });
    let positions: Vec<([u32; 3], DVec3)> = repeat.positions().collect();
    assert_eq!(positions, expected);
    // By another implementation still: r = 0x4be788d7 and 0x68ef91ea.
    assert!((positions[0].1.x - 0.25 * -0.406_996_626_639_738_7).abs() < 1e-16);
    assert!((positions[0].1.z - 2.0 * -0.180_188_904_283_568_26).abs() < 1e-15);
}

#[test]
fn a_file_of_copies_has_the_jitter_of_its_seed() {
    let scene = scene(
        "Union(of: [Repeat(count: (3, 1, 1), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), jitter: (0.5, 0.5, 0.5), seed: 7,
            of: Sphere(radius: 1))])",
        "",
    );
    let mut pcg = Pcg::new(7, 0x0a02_bdbf_7bb3_c0a7);
    for copy in 0..3 {
        let shift = [0; 3].map(|_| (f64::from(pcg.next()) + 0.5) / 4_294_967_296.0 - 0.5);
        let expected = DVec3::from(shift) + f64::from(copy) * DVec3::X;
        let origin = DVec3::from(origin(only(&scene), copy));
        assert!(
            (origin - expected).length() < 1e-15,
            "{origin} is not {expected}"
        );
    }
}

#[test]
fn a_million_copies_share_what_they_can() {
    let scene = scene(
        "Difference(from: Box(size: (1, 1, 1)), subtract: [Repeat(count: (100, 100, 100),
            step: ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01)), jitter: (0.001, 0.001, 0.001), of: Sphere(radius: 0.002))])",
        "",
    );
    let csg = only(&scene);
    assert_eq!((csg.len(), csg.results()), (1_000_001, 1));
    assert_eq!(scene.instances[0].materials.len(), 1);
    let last = DVec3::from(origin(csg, 1_000_000));
    assert!((last - DVec3::splat(0.99)).abs().max_element() < 0.001);
}

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

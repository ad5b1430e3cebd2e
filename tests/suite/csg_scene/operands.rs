//! Operators, operands and where they stand.

use glam::{DAffine3, DMat3, DVec3};
use solidtrace::geometry::{Csg, CsgOp, Operand};
use solidtrace::math::Transform;

use super::{only, origin, scene, scene_in, sphere};

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

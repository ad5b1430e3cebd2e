use glam::{Vec2, Vec3};
use serde_json::json;

use super::{Files, area, cube, document, floats, glb, read};

#[test]
fn strips_fans_and_lists_wind_the_same_way() {
    let files = Files::new();
    let zigzag = [
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
    ];
    let around = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    for (mode, points, expected) in [(5, zigzag, 1.5), (6, around, 2.0)] {
        let accessor = json!({"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"});
        let primitive = json!({"attributes": {"POSITION": 0}, "mode": mode});
        let model = read(
            &files,
            &document(&primitive, &[accessor], &[floats(&points)]),
        );
        let mesh = &model.meshes[0];
        assert_eq!(mesh.triangles.len(), 3);
        assert_eq!(area(mesh), expected);
        for i in 0..3 {
            let [a, b, c] = mesh.corners(i);
            assert!((b - a).cross(c - a).z > 0.0, "mode {mode} triangle {i}");
        }
    }
}

#[test]
fn primitives_become_one_mesh_with_a_slot_for_each_material() {
    let files = Files::new();
    let (mut document, binary) = cube();
    let primitive = |material: Option<u32>, mode: u32| {
        let mut p = json!({"attributes": {"POSITION": 0}, "indices": 1, "mode": mode});
        if let Some(material) = material {
            p["material"] = material.into();
        }
        p
    };
    document["materials"] = json!([{"name": "first"}, {"name": "second"}]);
    document["meshes"][0]["primitives"] = json!([
        primitive(Some(1), 4),
        primitive(None, 4),
        primitive(Some(0), 1),
        primitive(Some(1), 4),
        primitive(Some(0), 4)
    ]);
    let model = read(&files, &(document, binary));
    let mesh = &model.meshes[0];
    assert_eq!(mesh.triangles.len(), 48);
    assert_eq!(
        mesh.positions.len(),
        8,
        "primitives that share accessors share vertices"
    );
    let slots: Vec<u32> = mesh.slots.iter().step_by(12).copied().collect();
    assert_eq!(slots, [0, 1, 0, 2]);
    assert_eq!(model.parts[0].materials, [Some(1), None, Some(0)]);
    assert_eq!(model.warnings.len(), 1);
    assert!(model.warnings[0].contains("/meshes/0/primitives/2"));
}

#[test]
fn normals_and_coordinates_are_read_and_filled_where_a_primitive_has_none() {
    let files = Files::new();
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let vec3 =
        |view: u32| json!({"bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3"});
    let (mut document, binary) = document(
        &json!({"attributes": {"POSITION": 0}}),
        &[
            vec3(0),
            vec3(1),
            json!({"bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"}),
        ],
        &[
            floats(&points),
            floats(&[[0.0, 0.0, 5.0], [0.0, 3.0, 4.0], [0.0, 0.0, 0.0]]),
            vec![0, 0, 255, 0, 51, 255],
        ],
    );
    let full = json!({"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}});
    let bare = json!({"attributes": {"POSITION": 0}});
    let (z, slanted) = (Vec3::Z, Vec3::new(0.0, 0.6, 0.8));
    let normals = [z, slanted, Vec3::ZERO];
    // v = 0 is the top in the file and the bottom here.
    let uvs = [
        Vec2::new(0.0, 1.0),
        Vec2::new(1.0, 1.0),
        Vec2::new(0.2, 0.0),
    ];
    for full_first in [true, false] {
        document["meshes"][0]["primitives"] = if full_first {
            json!([full, bare])
        } else {
            json!([bare, full])
        };
        let model = read(&files, &(document.clone(), binary.clone()));
        let mesh = &model.meshes[0];
        let (with, without) = if full_first { (0, 3) } else { (3, 0) };
        assert_eq!(mesh.normals[with..with + 3], normals);
        assert_eq!(mesh.uvs[with..with + 3], uvs);
        assert_eq!(mesh.normals[without..without + 3], [Vec3::ZERO; 3]);
        assert_eq!(mesh.uvs[without..without + 3], [Vec2::ZERO; 3]);
    }
    document["accessors"][1]["count"] = 2.into();
    let error = files.error("a.glb", glb(&document, &binary));
    assert!(
        error.message().contains("2 values for 3 vertices"),
        "{error}"
    );
}

#[test]
fn quantized_positions_are_normalised_as_the_specification_says() {
    let files = Files::new();
    // 16-bit vectors are padded to 8 bytes; -32768 and -32767 are both -1.
    let raw: [i16; 12] = [-32768, 0, 32767, 9, 32767, -32767, 0, 9, 0, 32767, 16384, 9];
    let bytes: Vec<u8> = raw.iter().flat_map(|x| x.to_le_bytes()).collect();
    for (normalized, greatest) in [(true, 32767.0), (false, 1.0)] {
        let (mut document, binary) = document(
            &json!({"attributes": {"POSITION": 0}}),
            &[
                json!({"bufferView": 0, "componentType": 5122, "normalized": normalized, "count": 3, "type": "VEC3"}),
            ],
            std::slice::from_ref(&bytes),
        );
        document["bufferViews"][0]["byteStride"] = 8.into();
        document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let positions = &read(&files, &(document, binary)).meshes[0].positions;
        let least = if normalized { -1.0 } else { -32768.0 };
        assert_eq!(positions[0], Vec3::new(least, 0.0, 32767.0 / greatest));
        assert_eq!(positions[1], Vec3::new(32767.0, -32767.0, 0.0) / greatest);
        assert_eq!(positions[2], Vec3::new(0.0, 32767.0, 16384.0) / greatest);
    }
}

#[test]
fn sparse_accessors_replace_what_they_name() {
    let files = Files::new();
    let (mut document, binary) = document(
        &json!({"attributes": {"POSITION": 0}}),
        &[json!({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"})],
        &[
            floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
            vec![2, 1],
            floats(&[[0.0, 5.0, 0.0], [4.0, 0.0, 0.0]]),
        ],
    );
    document["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": 1, "componentType": 5121},
        "values": {"bufferView": 2},
    });
    let expected = [Vec3::ZERO, 4.0 * Vec3::X, 5.0 * Vec3::Y];
    assert_eq!(
        read(&files, &(document.clone(), binary.clone())).meshes[0].positions,
        expected
    );
    // Without a bufferView the rest is zero.
    document["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert_eq!(
        read(&files, &(document.clone(), binary.clone())).meshes[0].positions,
        expected
    );
    document["accessors"][0]["count"] = 2.into();
    let error = files.error("a.glb", glb(&document, &binary));
    assert!(error.message().contains("sparse index 2"), "{error}");
    document["accessors"][0]["count"] = (1_u64 << 62).into();
    let error = files.error("a.glb", glb(&document, &binary));
    assert!(error.message().contains("4611686018427387904"), "{error}");
}

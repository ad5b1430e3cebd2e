use glam::{DVec3, Vec2, Vec3};
use serde_json::{Value, json};
use solidtrace::color::Rgb;
use solidtrace::io::read_model;
use solidtrace::material::{Fresnel, Surface};
use solidtrace::scene::Model;
use solidtrace::texture::Texture;

use super::{Files, area, below, mutate, volume};
use crate::random::SplitMix;

/// Corners of a cube of edge 2 around the origin: bits of the index are x, y, z.
fn cube_positions() -> Vec<[f32; 3]> {
    (0..8)
        .map(|i: i32| std::array::from_fn(|k| (2 * (i >> k & 1) - 1) as f32))
        .collect()
}

const CUBE_INDICES: [u16; 36] = [
    0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3,
    7, 1, 7, 5,
];

fn floats<const N: usize>(values: &[[f32; N]]) -> Vec<u8> {
    values
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect()
}

fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A document with one mesh in one node; `views` become bufferViews, one for each accessor.
fn document(primitive: &Value, accessors: &[Value], views: &[Vec<u8>]) -> (Value, Vec<u8>) {
    let mut binary = Vec::new();
    let mut buffer_views = Vec::new();
    for view in views {
        buffer_views
            .push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": view.len()}));
        binary.extend_from_slice(view);
        binary.resize(binary.len().next_multiple_of(4), 0);
    }
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "thing", "mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
        "bufferViews": buffer_views,
        "buffers": [{"byteLength": binary.len()}],
    });
    (document, binary)
}

fn cube() -> (Value, Vec<u8>) {
    document(
        &json!({"attributes": {"POSITION": 0}, "indices": 1}),
        &[
            json!({"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"}),
            json!({"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}),
        ],
        &[floats(&cube_positions()), shorts(&CUBE_INDICES)],
    )
}

/// Three vertices in the xy plane as one triangle without indices.
fn triangle() -> (Value, Vec<u8>) {
    document(
        &json!({"attributes": {"POSITION": 0}}),
        &[json!({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"})],
        &[floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])],
    )
}

fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunks = [(&text[..], b"JSON"), (binary, b"BIN\0")];
    let length = 12 + 16 + text.len() + binary.len();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend_from_slice(&(length as u32).to_le_bytes());
    for (data, kind) in chunks {
        bytes.extend_from_slice(&(data.len() as u32).to_le_bytes());
        bytes.extend_from_slice(kind);
        bytes.extend_from_slice(data);
    }
    bytes
}

fn data_uri(bytes: &[u8]) -> String {
    let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut uri = "data:application/octet-stream;base64,".to_owned();
    for group in bytes.chunks(3) {
        let bits = group
            .iter()
            .fold(0_u32, |bits, &b| bits << 8 | u32::from(b));
        let bits = bits << (8 * (3 - group.len()));
        for i in 0..4 {
            let code = alphabet[(bits >> (18 - 6 * i) & 63) as usize];
            uri.push(if i <= group.len() {
                char::from(code)
            } else {
                '='
            });
        }
    }
    uri
}

fn read(files: &Files, (document, binary): &(Value, Vec<u8>)) -> Model {
    files.read("a.glb", glb(document, binary)).unwrap()
}

/// Sets the value at `pointer`, whose parent exists.
fn set(document: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(object) => {
            object.insert(key.to_owned(), value);
        }
        Value::Array(array) => {
            let i: usize = key.parse().unwrap();
            array.resize(array.len().max(i + 1), Value::Null);
            array[i] = value;
        }
        other => panic!("{other}"),
    }
}

/// The error that a changed cube gives: its pointer and message.
fn error_of(changes: &[(&str, Value)]) -> (String, String) {
    let files = Files::new();
    let (mut document, binary) = cube();
    for (pointer, value) in changes {
        set(&mut document, pointer, value.clone());
    }
    let Err(error) = files.read("a.glb", glb(&document, &binary)) else {
        panic!("no error for {changes:?}");
    };
    let place = error.place().unwrap();
    assert_eq!(place.file, files.path("a.glb"));
    (
        place.pointer.clone().unwrap_or_default(),
        error.message().to_owned(),
    )
}

#[test]
fn a_cube_is_the_same_from_glb_from_data_and_from_a_file_beside() {
    let files = Files::new();
    let (mut document, binary) = cube();
    let model = read(&files, &(document.clone(), binary.clone()));
    let mesh = &model.meshes[0];
    assert_eq!((volume(mesh), area(mesh)), (8.0, 24.0));
    assert_eq!(mesh.triangles.len(), 12);
    assert_eq!(mesh.triangles[1], [0, 3, 1]);
    assert!(mesh.slots.is_empty() && mesh.normals.is_empty() && mesh.uvs.is_empty());
    assert_eq!(model.parts[0].name.as_deref(), Some("thing"));
    assert_eq!(model.parts[0].materials, [None]);
    assert!(model.warnings.is_empty());
    document["buffers"][0]["uri"] = data_uri(&binary).into();
    let inside = files.read("b.gltf", format!("\u{FEFF}{document}")).unwrap();
    assert_eq!(inside.meshes, model.meshes);
    document["buffers"][0]["uri"] = "sub%20folder/caf%C3%A9.bin".into();
    files.write("sub folder/café.bin", &binary);
    let beside = files.read("c.gltf", document.to_string()).unwrap();
    assert_eq!(beside.meshes, model.meshes);
}

#[test]
fn a_glb_cut_anywhere_is_an_error() {
    let files = Files::new();
    let (document, binary) = cube();
    let whole = glb(&document, &binary);
    for length in 0..whole.len() {
        let error = files.error("cut.glb", &whole[..length]);
        assert_eq!(
            error.place().unwrap().file,
            files.path("cut.glb"),
            "{error}"
        );
        // Cut, with a header that agrees.
        if length >= 12 {
            let mut bytes = whole[..length].to_vec();
            bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            files.error("cut.glb", &bytes);
        }
    }
    files.read("cut.glb", &whole).unwrap();
}

#[test]
fn wrong_glb_headers_are_errors() {
    let files = Files::new();
    let (document, binary) = cube();
    let whole = glb(&document, &binary);
    let json_end = 20 + u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    for (at, word, message) in [
        (0, 0x4654_4C66, "not a GLB file: it begins with `fLTF`"),
        (4, 1, "GLB version 1"),
        (8, 0, "header says 0 bytes"),
        (8, u32::MAX, "header says 4294967295 bytes"),
        (12, u32::MAX, "chunk 0 says 4294967295 bytes"),
        (16, 0, "the first chunk is not JSON"),
        (json_end, u32::MAX, "chunk 1 says 4294967295 bytes"),
        (json_end + 4, 7, "no `uri`"),
    ] {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        let error = files.error("a.glb", bytes);
        assert!(error.message().contains(message), "{error}");
    }
    let error = files.error("a.glb", document.to_string());
    assert!(error.to_string().contains(".gltf"), "{error}");
    let error = files.error("a.gltf", "{\n  \"asset\": 2,,\n}");
    let place = error.place().unwrap();
    assert_eq!((place.line, place.column), (Some(2), Some(14)), "{error}");
}

#[test]
fn every_error_names_pointer_and_value() {
    let deep = "/meshes/0/primitives/0";
    let cases = [
        (
            "/asset",
            json!({"version": "1.0"}),
            "/asset/version",
            "`1.0`",
        ),
        ("/asset", json!({}), "/asset", "`version` is missing"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "/extensionsRequired/0",
            "KHR_draco",
        ),
        (
            "/extensionsRequired",
            json!(["EXT_meshopt_compression"]),
            "/extensionsRequired/0",
            "EXT_meshopt",
        ),
        ("/accessors/0/count", json!(9), "/accessors/0", "do not fit"),
        (
            "/accessors/0/count",
            json!(9_223_372_036_854_775_809_u64),
            "/accessors/0",
            "do not fit",
        ),
        ("/accessors/0/count", json!(-8), "/accessors/0/count", "-8"),
        (
            "/accessors/0/byteOffset",
            json!(u64::MAX),
            "/accessors/0",
            "do not fit",
        ),
        (
            "/accessors/0/type",
            json!("VEC2"),
            "/accessors/0/type",
            "2 numbers",
        ),
        (
            "/accessors/0/type",
            json!("MAT4"),
            "/accessors/0/type",
            "MAT4",
        ),
        (
            "/accessors/0/componentType",
            json!(5130),
            "/accessors/0/componentType",
            "5130",
        ),
        (
            "/accessors/1/componentType",
            json!(5126),
            "/accessors/1/componentType",
            "unsigned",
        ),
        (
            "/accessors/1/componentType",
            json!(5125),
            "/accessors/1",
            "do not fit",
        ),
        ("/accessors/1/count", json!(35), deep, "35 indices"),
        (
            "/accessors/0/bufferView",
            json!(4_294_967_296_u64),
            "/accessors/0/bufferView",
            "bufferViews[4294967296]",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(8),
            "/accessors/0",
            "byteStride 8",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(16),
            "/accessors/0",
            "do not fit",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(1000),
            "/bufferViews/0",
            "1000 bytes",
        ),
        (
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
            "/bufferViews/0",
            "do not fit",
        ),
        (
            "/bufferViews/0/buffer",
            json!(1),
            "/bufferViews/0/buffer",
            "buffers[1]",
        ),
        (
            "/buffers/0/byteLength",
            json!(4_294_967_296_u64),
            "/buffers/0/byteLength",
            "4294967296",
        ),
        (
            "/buffers/0/uri",
            json!("%FF.bin"),
            "/buffers/0/uri",
            "%FF.bin",
        ),
        (
            "/buffers/0/uri",
            json!("http://example.com/a.bin"),
            "/buffers/0/uri",
            "http:",
        ),
        (
            "/buffers/0/uri",
            json!("missing.bin"),
            "/buffers/0/uri",
            "`missing.bin`",
        ),
        (
            "/buffers/0/uri",
            json!("data:;base64,???"),
            "/buffers/0/uri",
            "base64",
        ),
        (
            "/buffers/0/uri",
            json!("data:;base64,AAAA"),
            "/buffers/0/byteLength",
            "has 3",
        ),
        (
            "/meshes/0/primitives/0/attributes",
            json!({"POSITION": 7}),
            "/meshes/0/primitives/0/attributes/POSITION",
            "accessors[7]",
        ),
        (
            "/meshes/0/primitives/0/attributes",
            json!({}),
            "/meshes/0/primitives/0/attributes",
            "`POSITION` is missing",
        ),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(1),
            "/accessors/1/type",
            "1 numbers",
        ),
        (
            "/meshes/0/primitives/0/indices",
            json!("1"),
            "/meshes/0/primitives/0/indices",
            "\"1\"",
        ),
        (
            "/meshes/0/primitives/0/mode",
            json!(7),
            "/meshes/0/primitives/0/mode",
            "7",
        ),
        (
            "/meshes/0/primitives/0/material",
            json!(0),
            "/meshes/0/primitives/0/material",
            "materials[0]",
        ),
        ("/meshes/0/primitives", json!([]), "", "no triangles"),
        ("/nodes/0/mesh", json!(1), "/nodes/0/mesh", "meshes[1]"),
        ("/nodes/0/children", json!([0]), "/nodes/0", "twice"),
        (
            "/nodes",
            json!([{"children": [1, 2]}, {"children": [2]}, {"mesh": 0}]),
            "/nodes/2",
            "twice",
        ),
        (
            "/nodes/0/rotation",
            json!([0, 0, 0, 0]),
            "/nodes/0/rotation",
            "no direction",
        ),
        (
            "/nodes/0/scale",
            json!([1, 1]),
            "/nodes/0/scale",
            "2 numbers",
        ),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "/nodes/0/matrix",
            "last row",
        ),
        (
            "/nodes/0/translation",
            json!([1e300, 0, 0]),
            "/nodes/0/translation/0",
            "is not a finite number",
        ),
        ("/scene", json!(3), "/scene", "scenes[3]"),
        (
            "/scenes/0/nodes",
            json!([1]),
            "/scenes/0/nodes/0",
            "nodes[1]",
        ),
        ("/scenes/0/nodes", json!([]), "", "no triangles"),
        (
            "/materials",
            json!([{"emissiveFactor": [-1, 0, 0]}]),
            "/materials/0",
            "negative",
        ),
        (
            "/materials",
            json!([5]),
            "/materials/0",
            "5 is not an object",
        ),
        ("/images", json!(7), "/images", "7 is not an array"),
    ];
    for (pointer, value, place, message) in cases {
        let (found, text) = error_of(&[(pointer, value.clone())]);
        assert!(text.contains(message), "{pointer} = {value}: {text}");
        assert_eq!(found, place, "{pointer} = {value}: {text}");
    }
}

#[test]
fn indices_and_numbers_in_the_data_are_checked() {
    let files = Files::new();
    let (document, mut binary) = cube();
    let (position, index) = (4 * 3 * 5, 4 * 3 * 8 + 2 * 10);
    binary[position..position + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = files.error("a.glb", glb(&document, &binary));
    assert!(
        error.message().contains("element 5 is not finite"),
        "{error}"
    );
    assert_eq!(
        error.place().unwrap().pointer.as_deref(),
        Some("/accessors/0")
    );
    let (document, mut binary) = cube();
    binary[index..index + 2].copy_from_slice(&8_u16.to_le_bytes());
    let error = files.error("a.glb", glb(&document, &binary));
    assert!(
        error.message().contains("element 10 is the index 8"),
        "{error}"
    );
    let pointer = error.place().unwrap().pointer.clone().unwrap();
    assert_eq!(pointer, "/meshes/0/primitives/0/indices");
}

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

#[test]
fn nodes_compose_from_the_root_down_and_share_their_mesh() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    let half = 0.5_f64.sqrt();
    document["scenes"] = json!([{"nodes": [1, 0]}]);
    document["nodes"] = json!([
        {"name": "alone", "mesh": 0},
        {"translation": [10, 0, 0], "rotation": [0, 0, half, half], "scale": [2, 2, 2], "children": [2, 3]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]},
        {"mesh": 0, "scale": [1, 0, 1]},
    ]);
    let model = read(&files, &(document.clone(), binary.clone()));
    assert_eq!(model.meshes.len(), 1);
    assert_eq!(model.parts.len(), 2);
    // (1, 2, 3), doubled, turned by a quarter about z, moved by 10.
    let place = &model.parts[0].model_from_mesh;
    assert!(
        place
            .point(DVec3::ZERO)
            .abs_diff_eq(DVec3::new(6.0, 2.0, 6.0), 1e-12)
    );
    assert!(place.vector(DVec3::X).abs_diff_eq(2.0 * DVec3::Y, 1e-12));
    assert_eq!(model.parts[1].name.as_deref(), Some("alone"));
    assert!(model.parts[1].model_from_mesh.is_identity());
    assert!(
        model.warnings[0].contains("/nodes/3"),
        "{:?}",
        model.warnings
    );
    // Without scenes, all nodes that have no parent.
    let object = document.as_object_mut().unwrap();
    object.remove("scene");
    object.remove("scenes");
    let names = |model: Model| model.parts.into_iter().map(|p| p.name).collect::<Vec<_>>();
    assert_eq!(
        names(read(&files, &(document, binary))),
        [Some("alone".to_owned()), None]
    );
}

#[test]
fn cameras_look_along_minus_z_and_point_lights_keep_their_numbers() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    let half = 0.5_f64.sqrt();
    let light = |i: u32| json!({"KHR_lights_punctual": {"light": i}});
    document["scenes"] = json!([{"nodes": [0, 1, 2, 3, 4]}]);
    document["nodes"] = json!([
        {"mesh": 0},
        {"camera": 0, "translation": [1, 2, 3], "rotation": [0, half, 0, half], "scale": [3, 3, 3], "name": "node"},
        {"camera": 1},
        {"extensions": light(0), "translation": [0, 4, 0]},
        {"extensions": light(1)},
    ]);
    document["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.75, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 1}},
    ]);
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1, 0.5, 0.25], "intensity": 8},
        {"type": "directional"},
    ]}});
    let model = read(&files, &(document.clone(), binary.clone()));
    assert_eq!(model.cameras.len(), 1);
    let camera = &model.cameras[0];
    assert_eq!(camera.name.as_deref(), Some("node"));
    assert_eq!(camera.eye, DVec3::new(1.0, 2.0, 3.0));
    // A quarter turn about y takes -z to -x.
    assert!((camera.look_at - camera.eye).abs_diff_eq(DVec3::NEG_X, 1e-12));
    assert!(camera.up.abs_diff_eq(DVec3::Y, 1e-12));
    assert_eq!(
        (camera.vfov, camera.aperture, camera.focus),
        (0.75, 0.0, None)
    );
    assert_eq!(model.lights.len(), 1);
    assert_eq!(model.lights[0].position, 4.0 * DVec3::Y);
    assert_eq!(model.lights[0].intensity, Rgb::new(8.0, 4.0, 2.0));
    assert_eq!(model.warnings.len(), 2, "{:?}", model.warnings);
    for (pointer, value, place) in [
        (
            "/cameras/0/perspective/yfov",
            json!(0),
            "/cameras/0/perspective/yfov",
        ),
        (
            "/cameras/0/perspective/yfov",
            json!(3.2),
            "/cameras/0/perspective/yfov",
        ),
        (
            "/cameras/0/perspective",
            json!({}),
            "/cameras/0/perspective",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/0/intensity",
            json!(-1),
            "/extensions/KHR_lights_punctual/lights/0",
        ),
        (
            "/nodes/3/extensions/KHR_lights_punctual/light",
            json!(2),
            "/nodes/3/extensions/KHR_lights_punctual/light",
        ),
    ] {
        let mut changed = document.clone();
        set(&mut changed, pointer, value);
        let error = files.error("a.glb", glb(&changed, &binary));
        assert_eq!(
            error.place().unwrap().pointer.as_deref(),
            Some(place),
            "{error}"
        );
    }
}

#[test]
fn materials_become_the_nearest_of_ours() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    let metal = |roughness: f64| json!({"pbrMetallicRoughness": {"baseColorFactor": [0.75, 0.5, 0.25, 1], "roughnessFactor": roughness}});
    document["materials"] = json!([
        {"name": "bare"},
        {"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.75, 0.5, 0.25, 1], "metallicFactor": 0}},
        metal(0.1),
        metal(0.5),
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.33}}},
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}},
        {"emissiveFactor": [1, 0.5, 0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 20}}},
        {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}},
    ]);
    let model = read(&files, &(document, binary));
    let color = Texture::Constant(Rgb::new(0.75, 0.5, 0.25));
    let fresnel = Fresnel::Exact;
    let white = Surface::Diffuse {
        color: Texture::Constant(Rgb::ONE),
    };
    let surfaces: Vec<Surface> = model.materials.iter().map(|m| m.surface.clone()).collect();
    assert_eq!(
        surfaces,
        [
            white.clone(),
            Surface::Diffuse {
                color: color.clone()
            },
            Surface::Mirror {
                color: color.clone()
            },
            Surface::Diffuse { color },
            Surface::Dielectric { ior: 1.33, fresnel },
            Surface::Dielectric { ior: 1.5, fresnel },
            white.clone(),
            white,
        ]
    );
    assert_eq!(model.materials[0].name, "bare");
    assert_eq!(model.materials[2].name, "material 2");
    assert_eq!(model.materials[6].emission, Rgb::new(20.0, 10.0, 0.0));
    assert_eq!(model.materials[7].emission, Rgb::ZERO);
    assert!(
        model.warnings[0].contains("/materials/7"),
        "{:?}",
        model.warnings
    );
}

#[test]
fn base_colour_textures_come_from_files_data_and_views() {
    let files = Files::new();
    let mut png = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbImage::from_raw(1, 1, vec![128, 255, 0]).unwrap();
    pixels.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    files.write("picture.png", &png);
    let (mut document, mut binary) = triangle();
    document["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": png.len()}));
    binary.extend_from_slice(&png);
    document["buffers"][0]["byteLength"] = binary.len().into();
    document["textures"] = json!([{"source": 0}]);
    document["materials"] = json!([
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1]}}
    ]);
    for source in [
        json!({"uri": "picture.png"}),
        json!({"uri": data_uri(&png)}),
        json!({"bufferView": 1}),
    ] {
        document["images"] = json!([source]);
        let model = read(&files, &(document.clone(), binary.clone()));
        let Surface::Diffuse {
            color: Texture::Image { image, scale },
        } = &model.materials[0].surface
        else {
            panic!("{:?}", model.materials[0]);
        };
        assert!(image.pixels[0].abs_diff_eq(Rgb::new(0.215_860_5, 1.0, 0.0), 1e-6));
        assert_eq!(*scale, Rgb::new(0.5, 1.0, 1.0));
    }
    files.write("text.png", "this is text");
    for (source, place) in [
        (json!({"uri": "text.png"}), "/images/0"),
        (json!({"uri": "missing.png"}), "/images/0/uri"),
        (json!({"bufferView": 0}), "/images/0"),
        (json!({"bufferView": 9}), "/images/0/bufferView"),
        (json!({}), "/images/0"),
    ] {
        document["images"] = json!([source]);
        let error = files.error("a.glb", glb(&document, &binary));
        assert_eq!(
            error.place().unwrap().pointer.as_deref(),
            Some(place),
            "{error}"
        );
    }
}

#[test]
fn material_extensions_that_are_required_but_unknown_are_warned_of() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    document["extensionsRequired"] = json!(["KHR_materials_volume", "KHR_lights_punctual"]);
    let warnings = read(&files, &(document, binary)).warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("`KHR_materials_volume`"));
}

/// A document that uses every part of the reader.
fn rich() -> (Value, Vec<u8>) {
    let (mut document, mut binary) = cube();
    let png = {
        let mut png = std::io::Cursor::new(Vec::new());
        let pixels = image::RgbImage::from_raw(1, 1, vec![1, 2, 3]).unwrap();
        pixels.write_to(&mut png, image::ImageFormat::Png).unwrap();
        png.into_inner()
    };
    document["bufferViews"].as_array_mut().unwrap().extend([
        json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": png.len(), "byteStride": 12}),
        json!({"buffer": 0, "byteOffset": 0, "byteLength": 96, "byteStride": 12}),
    ]);
    binary.extend_from_slice(&png);
    binary.resize(binary.len().next_multiple_of(4), 0);
    document["buffers"][0]["byteLength"] = binary.len().into();
    document["accessors"].as_array_mut().unwrap().extend([
        json!({"bufferView": 3, "componentType": 5126, "count": 8, "type": "VEC2", "byteOffset": 4, "normalized": false}),
        json!({"componentType": 5126, "count": 8, "type": "VEC3", "sparse": {
            "count": 2, "indices": {"bufferView": 1, "byteOffset": 2, "componentType": 5123}, "values": {"bufferView": 0, "byteOffset": 12}}}),
    ]);
    set(
        &mut document,
        "/accessors/3/sparse/indices/byteOffset",
        json!(0),
    );
    document["meshes"][0]["primitives"] = json!([
        {"attributes": {"POSITION": 0, "NORMAL": 3, "TEXCOORD_0": 2}, "indices": 1, "material": 0, "mode": 4},
        {"attributes": {"POSITION": 0}, "material": 1, "mode": 6},
    ]);
    document["nodes"] = json!([
        {"mesh": 0, "children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]},
        {"camera": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1],
         "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]);
    document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.75}}]);
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "color": [1, 1, 1], "intensity": 8}]}});
    document["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    document["images"] = json!([{"bufferView": 2, "mimeType": "image/png"}]);
    document["textures"] = json!([{"source": 0}]);
    document["materials"] = json!([
        {"alphaMode": "BLEND", "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0, "texCoord": 0}, "baseColorFactor": [1, 1, 1, 1], "metallicFactor": 1, "roughnessFactor": 0}},
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.5},
                        "KHR_materials_emissive_strength": {"emissiveStrength": 2}}},
    ]);
    (document, binary)
}

fn pointers(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.to_owned());
    match value {
        Value::Array(array) => {
            (array.iter().enumerate()).for_each(|(i, v)| pointers(v, &format!("{at}/{i}"), found));
        }
        Value::Object(object) => {
            (object.iter()).for_each(|(k, v)| pointers(v, &format!("{at}/{k}"), found));
        }
        _ => {}
    }
}

#[test]
fn no_single_changed_value_of_a_document_makes_the_reader_panic() {
    let files = Files::new();
    let (document, binary) = rich();
    let mesh = read(&files, &(document.clone(), binary.clone()))
        .meshes
        .remove(0);
    assert_eq!(mesh.triangles.len(), 12 + 6);
    let mut places = Vec::new();
    pointers(&document, "", &mut places);
    let values = [
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3.5),
        json!(255),
        json!(4294967296_u64),
        json!(9_223_372_036_854_775_809_u64),
        json!(u64::MAX),
        json!(1e308),
        json!(""),
        json!("a"),
        json!([]),
        json!({}),
        json!([[0]]),
    ];
    for place in &places {
        for value in &values {
            let mut changed = document.clone();
            *changed.pointer_mut(place).unwrap() = value.clone();
            match read_model(&files.write("a.glb", glb(&changed, &binary))) {
                Ok(model) => model.meshes.iter().for_each(|m| m.validate().unwrap()),
                Err(error) => assert!(error.place().is_some(), "{error}"),
            }
        }
        if let Some((parent, key)) = place.rsplit_once('/') {
            let mut changed = document.clone();
            if let Some(Value::Object(object)) = changed.pointer_mut(parent) {
                object.remove(key);
            }
            let _ = read_model(&files.write("a.glb", glb(&changed, &binary)));
        }
    }
}

#[test]
fn two_thousand_damaged_files_never_panic() {
    let files = Files::new();
    let (document, binary) = rich();
    let whole = glb(&document, &binary);
    let json_end = 20 + u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    let mut random = SplitMix(3);
    for i in 0..2000 {
        // Half of them keep the container whole, so that damage gets past it.
        let bytes = if i % 2 == 0 {
            mutate(&mut random, &whole)
        } else {
            let mut bytes = whole.clone();
            for _ in 0..3 {
                let at = 20 + below(&mut random, json_end - 20);
                bytes[at] = b"0123456789-\",:[]{}"[below(&mut random, 18)];
            }
            bytes
        };
        match read_model(&files.write("a.glb", bytes)) {
            Ok(model) => model.meshes.iter().for_each(|m| m.validate().unwrap()),
            Err(error) => assert!(error.place().is_some(), "{error}"),
        }
    }
}

//! glTF documents made by the tests, piece by piece.

mod container;
mod damage;
mod errors;
mod geometry;
mod material;
mod normal_map;
mod peer;
mod scene;

use serde_json::{Value, json};
use solidtrace::scene::Model;

use super::{Files, area, below, mutate, volume};

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

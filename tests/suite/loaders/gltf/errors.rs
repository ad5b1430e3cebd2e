use serde_json::{Value, json};

use super::{Files, cube, glb, set};

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
#[rustfmt::skip] // One case a line.
fn every_error_names_pointer_and_value() {
    let deep = "/meshes/0/primitives/0";
    let cases = [
        ("/asset", json!({"version": "1.0"}), "/asset/version", "`1.0`"),
        ("/asset", json!({}), "/asset", "`version` is missing"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "/extensionsRequired/0", "KHR_draco"),
        ("/extensionsRequired", json!(["EXT_meshopt_compression"]), "/extensionsRequired/0", "EXT_meshopt"),
        ("/accessors/0/count", json!(9), "/accessors/0", "do not fit"),
        ("/accessors/0/count", json!(9_223_372_036_854_775_809_u64), "/accessors/0", "do not fit"),
        ("/accessors/0/count", json!(-8), "/accessors/0/count", "-8"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "/accessors/0", "do not fit"),
        ("/accessors/0/type", json!("VEC2"), "/accessors/0/type", "2 numbers"),
        ("/accessors/0/type", json!("MAT4"), "/accessors/0/type", "MAT4"),
        ("/accessors/0/componentType", json!(5130), "/accessors/0/componentType", "5130"),
        ("/accessors/1/componentType", json!(5126), "/accessors/1/componentType", "unsigned"),
        ("/accessors/1/componentType", json!(5125), "/accessors/1", "do not fit"),
        ("/accessors/1/count", json!(35), deep, "35 indices"),
        ("/accessors/0/bufferView", json!(4_294_967_296_u64), "/accessors/0/bufferView", "bufferViews[4294967296]"),
        ("/bufferViews/0/byteStride", json!(8), "/accessors/0", "byteStride 8"),
        ("/bufferViews/0/byteStride", json!(16), "/accessors/0", "do not fit"),
        ("/bufferViews/0/byteLength", json!(1000), "/bufferViews/0", "1000 bytes"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "/bufferViews/0", "do not fit"),
        ("/bufferViews/0/buffer", json!(1), "/bufferViews/0/buffer", "buffers[1]"),
        ("/buffers/0/byteLength", json!(4_294_967_296_u64), "/buffers/0/byteLength", "4294967296"),
        ("/buffers/0/uri", json!("%FF.bin"), "/buffers/0/uri", "%FF.bin"),
        ("/buffers/0/uri", json!("http://example.com/a.bin"), "/buffers/0/uri", "http:"),
        ("/buffers/0/uri", json!("missing.bin"), "/buffers/0/uri", "`missing.bin`"),
        ("/buffers/0/uri", json!("data:;base64,???"), "/buffers/0/uri", "base64"),
        ("/buffers/0/uri", json!("data:;base64,AAAA"), "/buffers/0/byteLength", "has 3"),
        ("/meshes/0/primitives/0/attributes", json!({"POSITION": 7}), "/meshes/0/primitives/0/attributes/POSITION", "accessors[7]"),
        ("/meshes/0/primitives/0/attributes", json!({}), "/meshes/0/primitives/0/attributes", "`POSITION` is missing"),
        ("/meshes/0/primitives/0/attributes/NORMAL", json!(1), "/accessors/1/type", "1 numbers"),
        ("/meshes/0/primitives/0/indices", json!("1"), "/meshes/0/primitives/0/indices", "\"1\""),
        ("/meshes/0/primitives/0/mode", json!(7), "/meshes/0/primitives/0/mode", "7"),
        ("/meshes/0/primitives/0/material", json!(0), "/meshes/0/primitives/0/material", "materials[0]"),
        ("/meshes/0/primitives", json!([]), "", "no triangles"),
        ("/nodes/0/mesh", json!(1), "/nodes/0/mesh", "meshes[1]"),
        ("/nodes/0/children", json!([0]), "/nodes/0", "twice"),
        ("/nodes", json!([{"children": [1, 2]}, {"children": [2]}, {"mesh": 0}]), "/nodes/2", "twice"),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "/nodes/0/rotation", "no direction"),
        ("/nodes/0/scale", json!([1, 1]), "/nodes/0/scale", "2 numbers"),
        ("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "/nodes/0/matrix", "last row"),
        ("/nodes/0/translation", json!([1e300, 0, 0]), "/nodes/0/translation/0", "is not a finite number"),
        ("/scene", json!(3), "/scene", "scenes[3]"),
        ("/scenes/0/nodes", json!([1]), "/scenes/0/nodes/0", "nodes[1]"),
        ("/scenes/0/nodes", json!([]), "", "no triangles"),
        ("/materials", json!([{"emissiveFactor": [-1, 0, 0]}]), "/materials/0", "negative"),
        ("/materials", json!([5]), "/materials/0", "5 is not an object"),
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

use serde_json::{Value, json};
use solidtrace::io::read_model;

use super::{Files, below, cube, glb, mutate, read, set};
use crate::random::SplitMix;

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

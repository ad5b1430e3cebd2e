use super::{Files, area, cube, data_uri, glb, read, volume};

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

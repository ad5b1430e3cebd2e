use serde_json::json;
use solidtrace::color::Rgb;
use solidtrace::material::{Material, Principled, Roughness, Surface};
use solidtrace::texture::Texture;

use super::{Files, data_uri, glb, read, triangle};

fn principled(material: &Material) -> &Principled {
    match &material.surface {
        Surface::Principled(principled) => principled,
        other => panic!("{other:?}"),
    }
}

#[test]
fn factors_and_extensions_become_principled_surfaces() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    document["materials"] = json!([
        {"name": "bare"},
        {"pbrMetallicRoughness": {"baseColorFactor": [0.75, 0.5, 0.25, 1], "metallicFactor": 0, "roughnessFactor": 0.25}},
        {"pbrMetallicRoughness": {"metallicFactor": 0.5}, "extensions": {
            "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 1.5},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.125},
            "KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.25, 1], "sheenRoughnessFactor": 0.75},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2, 1, 0]},
            "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 250},
        }},
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.25},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [1, 0.5, 0.25], "attenuationDistance": 2}}},
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.75}}},
        {"emissiveFactor": [1, 0.5, 0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 20}}},
        {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}},
    ]);
    document["textures"] = json!([{}]);
    let model = read(&files, &(document, binary));
    let constant = |r, g, b| Texture::Constant(Rgb::new(r, g, b));
    // What glTF says of a material that says nothing.
    let bare = Principled {
        metallic: 1.0,
        thin: true,
        ..Principled::new(constant(1.0, 1.0, 1.0), Texture::Constant)
    };
    let materials: Vec<&Principled> = model.materials.iter().map(principled).collect();
    assert_eq!(materials[0], &bare);
    let paint = Principled {
        base_color: constant(0.75, 0.5, 0.25),
        metallic: 0.0,
        roughness: 0.25.into(),
        ..bare.clone()
    };
    assert_eq!(materials[1], &paint);
    let layered = Principled {
        metallic: 0.5,
        roughness: Roughness {
            value: 1.0,
            anisotropy: 0.6,
            rotation: 1.5,
        },
        specular: 0.5,
        specular_color: constant(2.0, 1.0, 0.0),
        clearcoat: 0.5,
        clearcoat_roughness: 0.125,
        sheen_color: constant(0.5, 0.25, 1.0),
        sheen_roughness: 0.75,
        iridescence: 1.0,
        iridescence_ior: 1.8,
        iridescence_thickness: 250.0,
        ..bare.clone()
    };
    assert_eq!(materials[2], &layered);
    let body = materials[3];
    assert_eq!((body.transmission, body.ior, body.thin), (1.0, 1.25, false));
    // Beer: half of green is left after two metres.
    let left = (-2.0 * body.absorption).exp();
    assert!((left - Rgb::new(1.0, 0.5, 0.25)).length() < 1e-6, "{left}");
    let sheet = materials[4];
    assert_eq!(
        (sheet.transmission, sheet.thin, sheet.interior()),
        (0.75, true, None)
    );
    assert_eq!(model.materials[0].name, "bare");
    assert_eq!(model.materials[2].name, "material 2");
    assert_eq!(model.materials[5].emission, Rgb::new(20.0, 10.0, 0.0));
    assert_eq!(model.materials[6].emission, Rgb::ZERO);
    assert!(
        model.warnings[0].contains("/textures/0"),
        "{:?}",
        model.warnings
    );
}

#[test]
fn material_factors_out_of_range_are_errors_or_clipped_and_unread_textures_are_warned_of() {
    let files = Files::new();
    let (mut document, binary) = triangle();
    document["materials"] = json!([{"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 7, "clearcoatTexture": {"index": 0}}},
        "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}]);
    let model = read(&files, &(document.clone(), binary.clone()));
    let coated = principled(&model.materials[0]);
    assert_eq!((coated.clearcoat, coated.metallic), (1.0, 0.0));
    let places = ["/materials/0/pbrMetallicRoughness", "clearcoatTexture"];
    for (warning, place) in model.warnings.iter().zip(places) {
        assert!(warning.contains(place), "{warning}");
    }
    for (extension, place) in [
        (
            json!({"KHR_materials_ior": {"ior": 0.5}}),
            "KHR_materials_ior",
        ),
        (
            json!({"KHR_materials_volume": {"attenuationDistance": -1}}),
            "KHR_materials_volume",
        ),
        (
            json!({"KHR_materials_sheen": {"sheenColorFactor": [1, 1]}}),
            "KHR_materials_sheen/sheenColorFactor",
        ),
    ] {
        document["materials"] = json!([{"extensions": extension}]);
        let error = files.error("a.glb", glb(&document, &binary));
        let pointer = error.place().unwrap().pointer.clone().unwrap();
        assert_eq!(pointer, format!("/materials/0/extensions/{place}"));
    }
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
        let Texture::Image { image, scale, .. } = &principled(&model.materials[0]).base_color
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
    document["extensionsRequired"] = json!(["KHR_materials_dispersion", "KHR_lights_punctual"]);
    let warnings = read(&files, &(document, binary)).warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("`KHR_materials_dispersion`"));
}

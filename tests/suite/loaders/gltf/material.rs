use glam::{DVec3, Vec2};
use serde_json::json;
use solidtrace::color::Rgb;
use solidtrace::material::{Material, Principled, Roughness, Surface};
use solidtrace::texture::{Texture, TexturePoint};

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
        metallic: 1.0.into(),
        thin: true,
        ..Principled::new(constant(1.0, 1.0, 1.0))
    };
    let materials: Vec<&Principled> = model.materials.iter().map(principled).collect();
    assert_eq!(materials[0], &bare);
    let paint = Principled {
        base_color: constant(0.75, 0.5, 0.25),
        metallic: 0.0.into(),
        roughness: 0.25.into(),
        ..bare.clone()
    };
    assert_eq!(materials[1], &paint);
    let layered = Principled {
        metallic: 0.5.into(),
        roughness: Roughness {
            value: 1.0.into(),
            anisotropy: 0.6.into(),
            rotation: 1.5.into(),
        },
        specular: 0.5.into(),
        specular_color: constant(2.0, 1.0, 0.0),
        clearcoat: 0.5.into(),
        clearcoat_roughness: 0.125.into(),
        sheen_color: constant(0.5, 0.25, 1.0),
        sheen_roughness: 0.75.into(),
        iridescence: 1.0.into(),
        iridescence_ior: 1.8,
        iridescence_thickness: 250.0.into(),
        ..bare.clone()
    };
    assert_eq!(materials[2], &layered);
    let body = materials[3];
    assert_eq!((body.ior, body.thin), (1.25, false));
    assert!(body.transmission.is(1.0));
    // Beer: half of green is left after two metres.
    let left = (-2.0 * body.absorption).exp();
    assert!((left - Rgb::new(1.0, 0.5, 0.25)).length() < 1e-6, "{left}");
    let sheet = materials[4];
    assert!(sheet.transmission.is(0.75) && sheet.thin && sheet.interior().is_none());
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
    document["materials"] = json!([{"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 7},
        "KHR_materials_sheen": {"sheenRoughnessFactor": 0.5, "sheenRoughnessTexture": {"index": 0}}}}]);
    let model = read(&files, &(document.clone(), binary.clone()));
    let coated = principled(&model.materials[0]);
    assert!(coated.clearcoat.is(1.0) && coated.sheen_roughness.is(0.5));
    let place = "KHR_materials_sheen/sheenRoughnessTexture";
    assert!(model.warnings[0].contains(place), "{:?}", model.warnings);
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
fn numbers_are_factors_times_their_channel_of_a_texture_taken_as_data() {
    let files = Files::new();
    let mut png = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbImage::from_raw(1, 1, vec![51, 102, 204]).unwrap();
    pixels.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let (mut document, binary) = triangle();
    document["images"] = json!([{"uri": data_uri(&png.into_inner())}]);
    document["textures"] = json!([{"source": 0}]);
    let info = json!({"index": 0});
    document["materials"] = json!([{
        "pbrMetallicRoughness": {"metallicRoughnessTexture": info, "metallicFactor": 0.5, "roughnessFactor": 0.25},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": info},
            "KHR_materials_specular": {"specularColorFactor": [1, 1, 2], "specularColorTexture": info},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatTexture": info,
                "clearcoatRoughnessFactor": 0.5, "clearcoatRoughnessTexture": info},
            "KHR_materials_sheen": {"sheenColorFactor": [1, 0.5, 1], "sheenColorTexture": info},
            "KHR_materials_iridescence": {"iridescenceFactor": 0.5, "iridescenceTexture": info,
                "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 700, "iridescenceThicknessTexture": info},
        },
    }]);
    let model = read(&files, &(document, binary));
    assert_eq!(model.warnings, [""; 0]);
    let found = principled(&model.materials[0]);
    let point = TexturePoint {
        p: DVec3::ZERO,
        n: DVec3::Z,
        uv: Vec2::ZERO,
    };
    // Red 0.2, green 0.4, blue 0.8.
    for (number, expected) in [
        (&found.metallic, 0.4),
        (&found.roughness.value, 0.1),
        (&found.transmission, 0.1),
        (&found.clearcoat, 0.15),
        (&found.clearcoat_roughness, 0.2),
        (&found.iridescence, 0.1),
        (&found.iridescence_thickness, 400.0),
    ] {
        let value = number.eval_scalar(&point);
        assert!(
            (value - expected).abs() < 1e-5 * expected,
            "{value} {expected}"
        );
    }
    // The curve of IEC 61966-2-1.
    let [r, g, b] = [0.033_104_77, 0.132_868_32, 0.603_827_4];
    for (color, expected) in [
        (&found.specular_color, Rgb::new(r, g, 2.0 * b)),
        (&found.sheen_color, Rgb::new(r, 0.5 * g, b)),
    ] {
        let value = color.eval(&point);
        assert!(value.abs_diff_eq(expected, 1e-5), "{value} {expected}");
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

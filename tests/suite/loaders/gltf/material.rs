use serde_json::json;
use solidtrace::color::Rgb;
use solidtrace::material::{Fresnel, Surface};
use solidtrace::texture::Texture;

use super::{Files, data_uri, glb, read, triangle};

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
    document["textures"] = json!([{}]);
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
        model.warnings[0].contains("/textures/0"),
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
            color: Texture::Image { image, scale, .. },
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

use glam::DVec3;
use serde_json::json;
use solidtrace::color::Rgb;
use solidtrace::io::{ReadOptions, read_scene};
use solidtrace::material::Relief;
use solidtrace::math::Ray;
use solidtrace::texture::{PixelFilter, Sampling, Texture, Wrap};
use solidtrace::world::World;

use super::{Files, document, floats, glb, read, triangle};

#[test]
fn normal_maps_are_data_and_samplers_say_what_lies_beyond_the_edges() {
    let files = Files::new();
    let pixel = image::RgbImage::from_raw(1, 1, vec![51, 204, 255]).unwrap();
    pixel.save(files.path("n.png")).unwrap();
    let (mut document, binary) = triangle();
    document["images"] = json!([{"uri": "n.png"}]);
    document["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    document["textures"] = json!([{"source": 0}, {"source": 0, "sampler": 0}]);
    document["materials"] = json!([{
        "normalTexture": {"index": 1, "scale": 0.5},
        "emissiveFactor": [1, 0.5, 0],
        "emissiveTexture": {"index": 0},
    }]);
    let material = &read(&files, &(document.clone(), binary.clone())).materials[0];
    let Some(Relief::NormalMap { texture, scale }) = &material.relief else {
        panic!("{material:?}");
    };
    let Texture::Image {
        image, sampling, ..
    } = texture
    else {
        panic!("{texture:?}");
    };
    assert_eq!(*scale, 0.5);
    assert!(image.pixels[0].abs_diff_eq(Rgb::new(0.2, 0.8, 1.0), 1e-6));
    let expected = Sampling {
        wrap: [Wrap::Clamp, Wrap::Mirror],
        filter: PixelFilter::Nearest,
    };
    assert_eq!(*sampling, expected);
    let Some(Texture::Image {
        image, sampling, ..
    }) = &material.emission_texture
    else {
        panic!("{material:?}");
    };
    // IEC 61966-2-1: 51/255 is 0.0331048 and 204/255 is 0.6038273 in linear light.
    assert!(image.pixels[0].abs_diff_eq(Rgb::new(0.033_104_8, 0.603_827_3, 1.0), 1e-6));
    assert_eq!(*sampling, Sampling::default());
    for (field, value) in [("wrapS", 1), ("magFilter", 9984)] {
        document["samplers"] = json!([{field: value}]);
        let error = files.error("a.glb", glb(&document, &binary));
        let pointer = error.place().unwrap().pointer.clone();
        assert_eq!(pointer.unwrap(), format!("/samplers/0/{field}"), "{error}");
    }
}

#[test]
fn green_is_up_in_the_pictures_of_normal_maps() {
    // glTF's v = 0, the upper edge of the picture, lies at y = 1.
    let files = Files::new();
    let pixel = image::RgbImage::from_raw(1, 1, vec![128, 230, 204]).unwrap();
    pixel.save(files.path("n.png")).unwrap();
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let uvs = [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]];
    let (mut document, binary) = document(
        &json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}),
        &[
            json!({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}),
            json!({"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}),
        ],
        &[floats(&positions), floats(&uvs)],
    );
    document["images"] = json!([{"uri": "n.png"}]);
    document["textures"] = json!([{"source": 0}]);
    document["materials"] = json!([{"normalTexture": {"index": 0}}]);
    let path = files.write("a.glb", glb(&document, &binary));
    let scene = read_scene(&path, &ReadOptions::default()).unwrap();
    let world = World::build(scene).unwrap();
    let ray = Ray::new(DVec3::new(0.2, 0.2, 0.01), DVec3::NEG_Z);
    let point = world.surface(&ray, &world.intersect(&ray).unwrap());
    let texel = DVec3::new(128.0, 230.0, 204.0) / 127.5 - 1.0;
    let expected = texel.normalize().as_vec3();
    assert!(point.ns.abs_diff_eq(expected, 1e-5), "{}", point.ns);
}

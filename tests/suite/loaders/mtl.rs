use std::sync::Arc;

use solidtrace::color::{Encoding, Rgb};
use solidtrace::io::{read_bitmap, read_model};
use solidtrace::material::{Fresnel, Material, Principled, Surface};
use solidtrace::texture::{Bitmap, Texture};

use super::{Files, mutate};
use crate::random::SplitMix;

const TRIANGLE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";

fn material(files: &Files, statements: &str) -> Material {
    files.write("a.mtl", format!("newmtl a\n{statements}\n"));
    let mut model = files.read("a.obj", TRIANGLE).unwrap();
    model.materials.remove(0)
}

fn surface(statements: &str) -> Surface {
    material(&Files::new(), statements).surface
}

fn diffuse(r: f32, g: f32, b: f32) -> Surface {
    Surface::Diffuse {
        color: Texture::Constant(Rgb::new(r, g, b)),
    }
}

fn glass(ior: f32) -> Surface {
    Surface::glass(ior)
}

/// Two pixels: sRGB (0, 128, 255) and (255, 0, 51).
fn picture() -> Vec<u8> {
    let image = image::RgbImage::from_raw(2, 1, vec![0, 128, 255, 255, 0, 51]).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn image_of(surface: &Surface) -> (&Arc<Bitmap>, Rgb) {
    match surface {
        Surface::Diffuse {
            color: Texture::Image { image, scale, .. },
        } => (image, *scale),
        other => panic!("no texture: {other:?}"),
    }
}

#[test]
fn colours_are_linear_and_may_be_one_number() {
    assert_eq!(surface("Kd 0.5"), diffuse(0.5, 0.5, 0.5));
    assert_eq!(surface("Kd 0.1 0.2 0.3 # warm"), diffuse(0.1, 0.2, 0.3));
    assert_eq!(surface("Kd 2 0.5 1"), diffuse(1.0, 0.5, 1.0));
    assert_eq!(surface("Ka 1 1 1\nillum 2\nNs 100"), diffuse(0.8, 0.8, 0.8));
    assert_eq!(
        surface("Kd 1 0 0\nKd 0 1 0\nnewmtl b\nKd 0 0 1"),
        diffuse(0.0, 1.0, 0.0)
    );
    let lamp = material(&Files::new(), "Kd 0\nKe 15 10 5");
    assert_eq!(lamp.emission, Rgb::new(15.0, 10.0, 5.0));
    assert_eq!(lamp.name, "a");
}

#[test]
fn illumination_models_and_transparency_choose_mirror_and_glass() {
    let mirror = Surface::Mirror {
        color: Texture::Constant(Rgb::new(0.9, 0.8, 0.7)),
    };
    assert_eq!(surface("Kd 1\nKs 0.9 0.8 0.7\nillum 3"), mirror);
    assert_eq!(surface("Kd 0.5\nKs 0 0 0\nillum 3"), diffuse(0.5, 0.5, 0.5));
    for illum in [4, 6, 7] {
        assert_eq!(surface(&format!("Kd 1\nNi 1.5\nillum {illum}")), glass(1.5));
        assert_eq!(
            surface(&format!("Kd 0.5\nNi 1\nillum {illum}")),
            diffuse(0.5, 0.5, 0.5)
        );
    }
    assert_eq!(surface("d 0.1\nNi 1.33"), glass(1.33));
    assert_eq!(surface("Tr 0.9\nNi 1.33"), glass(1.33));
    assert_eq!(surface("d -halo 0.1\nNi 1.33"), glass(1.33));
    // `d` says what `Tr` says wrongly in some writers' files.
    assert_eq!(
        surface("Kd 0.5\nd 1\nTr 1\nNi 1.45"),
        diffuse(0.5, 0.5, 0.5)
    );
}

#[test]
fn highlights_roughness_and_metal_become_principled() {
    let principled = |statements: &str| match surface(statements) {
        Surface::Principled(principled) => *principled,
        other => panic!("{other:?}"),
    };
    // GGX of alpha² = 2 / (Ns + 2), and half of white Ks for what glTF calls 1.
    let gloss = principled("Kd 0.5\nKs 0.25\nNs 30\nillum 2");
    let expected = Principled {
        roughness: 0.0625_f32.powf(0.25).into(),
        specular_color: Texture::Constant(Rgb::splat(0.5)),
        ..Principled::new(Texture::Constant(Rgb::splat(0.5)))
    };
    assert_eq!(gloss, expected);
    let metal = principled("Kd 1 0.5 0\nPm 1\nPr 0.3");
    assert_eq!((metal.metallic, metal.roughness), (1.0.into(), 0.3.into()));
    assert_eq!(metal.specular_color, Texture::Constant(Rgb::ONE));
    assert_eq!(principled("Kd 1\nPr 0.3\nKs 1\nNs 5").roughness, 0.3.into());
    // Without a highlight it stays matt.
    assert_eq!(
        surface("Kd 0.5\nKs 1\nNs 30\nillum 1"),
        diffuse(0.5, 0.5, 0.5)
    );
    assert_eq!(surface("Kd 0.5\nKs 0 0 0\nNs 30"), diffuse(0.5, 0.5, 0.5));
    let frosted = Surface::Dielectric {
        ior: 1.5,
        fresnel: Fresnel::Exact,
        roughness: 0.4.into(),
        absorption: Rgb::ZERO,
    };
    assert_eq!(surface("Ni 1.5\nillum 7\nPr 0.4"), frosted);
}

#[test]
fn map_options_are_not_part_of_the_file_name() {
    let files = Files::new();
    files.write("maps/my wood 2.png", picture());
    for options in [
        "",
        "-s 1 1 1",
        "-s 1",
        "-o 0 0",
        "-clamp on",
        "-mm 0 1 -bm 1.0 -blendu off -blendv on",
        "-imfchan r -texres 512 -boost 2 -cc on -t 0 0 0 -type sphere",
    ] {
        for name in [
            "maps/my wood 2.png",
            "maps\\my wood 2.png",
            ".\\maps/my wood 2.png",
        ] {
            let material = material(&files, &format!("Kd 0.5 1 0.25\nmap_Kd {options} {name}  "));
            let (image, scale) = image_of(&material.surface);
            assert_eq!((image.width, image.height), (2, 1));
            assert_eq!(scale, Rgb::new(0.5, 1.0, 0.25));
        }
    }
    assert_eq!(files.read("a.obj", TRIANGLE).unwrap().warnings.len(), 0);
    material(&files, "map_Kd -s 2 2 maps/my wood 2.png");
    let model = read_model(&files.path("a.obj")).unwrap();
    assert!(
        model.warnings[0].contains("a.mtl:2:"),
        "{:?}",
        model.warnings
    );
    assert_eq!(image_of(&model.materials[0].surface).1, Rgb::ONE);
}

#[test]
fn textures_are_decoded_from_srgb_and_read_once() {
    let files = Files::new();
    files.write("t.png", picture());
    files.write(
        "a.mtl",
        "newmtl a\nmap_Kd t.png\nnewmtl b\nKd 0.5\nmap_Kd t.png\n",
    );
    let text = format!("{TRIANGLE}usemtl b\nf 1 2 3\n");
    let model = files.read("a.obj", text).unwrap();
    let (first, _) = image_of(&model.materials[0].surface);
    let (second, _) = image_of(&model.materials[1].surface);
    assert!(Arc::ptr_eq(first, second));
    // IEC 61966-2-1: 128/255 is 0.2158605 and 51/255 is 0.0331048 in linear light.
    let expected = [
        Rgb::new(0.0, 0.215_860_5, 1.0),
        Rgb::new(1.0, 0.0, 0.033_104_8),
    ];
    for (pixel, expected) in first.pixels.iter().zip(expected) {
        assert!(pixel.abs_diff_eq(expected, 1e-6), "{pixel}");
    }
}

#[test]
fn sixteen_bit_and_gray_pictures_are_srgb_and_floats_are_linear() {
    let files = Files::new();
    let deep = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(1, 1, vec![32_896_u16]).unwrap();
    deep.save(files.path("deep.png")).unwrap();
    let pixel = read_bitmap(&files.path("deep.png"), Encoding::Srgb)
        .unwrap()
        .pixels[0];
    assert!(pixel.abs_diff_eq(Rgb::splat(0.215_860_5), 1e-6), "{pixel}");
    let bright = image::Rgb32FImage::from_raw(1, 1, vec![4.0, 0.5, 0.25]).unwrap();
    bright.save(files.path("bright.hdr")).unwrap();
    let pixel = read_bitmap(&files.path("bright.hdr"), Encoding::Srgb)
        .unwrap()
        .pixels[0];
    assert!(pixel.abs_diff_eq(Rgb::new(4.0, 0.5, 0.25), 0.02), "{pixel}");
    image::RgbaImage::from_raw(1, 1, vec![255, 0, 0, 0])
        .unwrap()
        .save(files.path("clear.tga"))
        .unwrap();
    assert_eq!(
        read_bitmap(&files.path("clear.tga"), Encoding::Srgb)
            .unwrap()
            .pixels,
        [Rgb::X]
    );
}

#[test]
fn a_texture_that_is_missing_or_no_picture_is_an_error_at_the_line_that_names_it() {
    let files = Files::new();
    files.write("text.png", "this is text");
    files.write("cut.png", &picture()[..40]);
    files.write("empty.jpg", "");
    for name in [
        "text.png",
        "cut.png",
        "empty.jpg",
        "missing.png",
        "text.xyz",
        ".",
    ] {
        files.write("a.mtl", format!("newmtl a\nKd 1\nmap_Kd -s 1 1 {name}\n"));
        let error = files.error("a.obj", TRIANGLE);
        let place = error.place().unwrap();
        assert_eq!(place.file, files.path("a.mtl"));
        assert_eq!((place.line, place.column), (Some(3), Some(15)), "{error}");
        assert!(error.message().contains(name), "{error}");
    }
    // A material that no face uses does no harm.
    files.write("a.mtl", "newmtl a\nKd 0.5\nnewmtl b\nmap_Kd missing.png\n");
    files.read("a.obj", TRIANGLE).unwrap();
}

#[test]
fn every_error_names_line_column_and_value() {
    let cases = [
        ("Kd 1 2", 1, "2 numbers"),
        ("Kd", 1, "0 numbers"),
        ("Kd red", 4, "`red` is not a number"),
        ("Kd 1 nan 1", 6, "`nan` is not a finite number"),
        ("Ke 1 1 -1", 8, "`-1` is negative"),
        ("Ni inf", 4, "`inf` is not a finite number"),
        ("d", 1, "`d` has no number"),
        ("illum two", 7, "`two` is not a number"),
        ("newmtl", 1, "no name"),
        ("map_Kd", 1, "names no file"),
        ("map_Kd -s 1 1 1", 1, "names no file"),
    ];
    let files = Files::new();
    for (line, column, message) in cases {
        files.write("a.mtl", format!("newmtl a\n# comment\n{line}\n"));
        let error = files.error("a.obj", TRIANGLE);
        let place = error.place().unwrap();
        assert!(error.message().contains(message), "{line}: {error}");
        assert_eq!(
            (place.line, place.column),
            (Some(3), Some(column)),
            "{error}"
        );
        assert_eq!(place.file, files.path("a.mtl"));
    }
}

#[test]
fn libraries_may_have_spaces_in_their_names_or_be_several_or_be_missing() {
    let files = Files::new();
    files.write("my lib.mtl", "newmtl a\nKd 0.25\n");
    let text = |names: &str| TRIANGLE.replace("a.mtl", names);
    let model = files.read("a.obj", text("my lib.mtl")).unwrap();
    assert_eq!(model.materials[0].surface, diffuse(0.25, 0.25, 0.25));
    files.write("b.mtl", "newmtl b\n");
    files.write("c.mtl", "newmtl a\nKd 0.75\n");
    let model = files.read("a.obj", text("b.mtl c.mtl")).unwrap();
    assert_eq!(model.materials[0].surface, diffuse(0.75, 0.75, 0.75));
    let model = files.read("a.obj", text("No Such.mtl")).unwrap();
    assert_eq!(model.parts[0].materials, [None]);
    assert_eq!(model.warnings.len(), 1);
    assert!(model.warnings[0].contains("a.obj:1:") && model.warnings[0].contains("`No Such.mtl`"));
}

#[test]
fn two_thousand_damaged_files_never_panic() {
    let text = "newmtl a\nKd 0.5 0.4 0.3\nKe 1 2 3\nNi 1.5\nd 0.5\nTr 0.5\nillum 4\n\
                map_Kd -s 1 1 1 -mm 0 1 -clamp on t.png\nnewmtl b\nKs 1 \\\n 1 1\nillum 3\n";
    let files = Files::new();
    files.write("t.png", picture());
    let obj = files.write("a.obj", TRIANGLE);
    let mut random = SplitMix(2);
    for _ in 0..2000 {
        files.write("a.mtl", mutate(&mut random, text.as_bytes()));
        if let Err(error) = read_model(&obj) {
            assert!(error.place().is_some(), "{error}");
        }
    }
    let picture = picture();
    for _ in 0..2000 {
        let path = files.write("t.png", mutate(&mut random, &picture));
        if let Err(error) = read_bitmap(&path, Encoding::Srgb) {
            assert!(error.place().is_some(), "{error}");
        }
    }
}

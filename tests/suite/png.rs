//! PNG files show the image through the curve that their header names.

use solidtrace::color::{Rgb, Tonemap};
use solidtrace::image::Image;
use solidtrace::io::encode_png;

fn grey(values: &[f32]) -> Image {
    let pixels: Vec<Rgb> = values.iter().map(|&x| Rgb::splat(x)).collect();
    Image::rgb(values.len(), 1, &pixels)
}

/// Width, height and RGB bytes, by the `image` crate.
fn decode_png(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Png).unwrap();
    assert_eq!(image.color(), image::ColorType::Rgb8);
    let rgb = image.into_rgb8();
    (rgb.width(), rgb.height(), rgb.into_raw())
}

#[test]
fn png_bytes_are_the_curves_closed_forms() {
    // 0.5: sRGB 187.516, power 186.09, linear 127.5, which rounds up.
    let image = grey(&[0.0, 0.5, 1.0, 1.5, -1.0, 1e30, f32::NAN]);
    for (tonemap, half) in [
        (Tonemap::Srgb, 188),
        (Tonemap::Gamma22, 186),
        (Tonemap::None, 128),
    ] {
        let (width, height, pixels) = decode_png(&encode_png(&image, tonemap).unwrap());
        let expected = [0, half, 255, 255, 0, 255, 0].map(|v| [v; 3]).concat();
        assert_eq!((width, height, pixels), (7, 1, expected), "{tonemap:?}");
    }
}

#[test]
fn png_bytes_are_the_nearest_to_the_curve() {
    let values: Vec<f32> = (0..5000).map(|i| i as f32 / 4999.0).collect();
    for tonemap in [Tonemap::Srgb, Tonemap::Gamma22, Tonemap::None] {
        let (_, _, pixels) = decode_png(&encode_png(&grey(&values), tonemap).unwrap());
        for (&x, rgb) in values.iter().zip(pixels.chunks(3)) {
            let x = f64::from(x);
            let curve = match tonemap {
                Tonemap::Srgb if x <= 0.0031308 => 12.92 * x,
                Tonemap::Srgb => 1.055 * x.powf(1.0 / 2.4) - 0.055,
                Tonemap::Gamma22 => x.powf(1.0 / 2.2),
                Tonemap::None => x,
            };
            assert!(
                (255.0 * curve - f64::from(rgb[0])).abs() < 0.5001,
                "{tonemap:?} {x}"
            );
        }
    }
}

#[test]
fn png_puts_channels_and_rows_where_they_belong() {
    let pixels = [
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
        (1.0, 1.0, 0.0),
        (0.0, 1.0, 1.0),
        (1.0, 0.0, 1.0),
    ]
    .map(|(r, g, b)| Rgb::new(r, g, b));
    let (width, height, bytes) =
        decode_png(&encode_png(&Image::rgb(3, 2, &pixels), Tonemap::Srgb).unwrap());
    assert_eq!((width, height), (3, 2));
    assert_eq!(
        bytes,
        pixels
            .map(|p| (255.0 * p).to_array().map(|c| c as u8))
            .concat()
    );
}

#[test]
fn png_headers_name_the_curve_and_carry_the_metadata() {
    let mut image = grey(&[0.5]);
    image.metadata = vec![("scene".to_owned(), "größe α.ron".to_owned())];
    for (tonemap, srgb, gamma) in [
        (Tonemap::Srgb, true, None),
        (Tonemap::Gamma22, false, Some(45_455)),
        (Tonemap::None, false, Some(100_000)),
    ] {
        let bytes = encode_png(&image, tonemap).unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        reader.finish().unwrap();
        let info = reader.info();
        assert_eq!(info.srgb.is_some(), srgb, "{tonemap:?}");
        assert_eq!(
            info.gama_chunk
                .map(::png::ScaledFloat::into_scaled)
                .filter(|_| !srgb),
            gamma
        );
        assert_eq!(info.utf8_text[0].keyword, "scene");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "größe α.ron");
    }
}

#[test]
fn png_refuses_what_it_cannot_show() {
    let mut depth = grey(&[1.0]);
    depth.channels.truncate(1);
    depth.channels[0].name = "Z".to_owned();
    let error = encode_png(&depth, Tonemap::Srgb).unwrap_err();
    assert!(error.message().contains("no channel `R`"), "{error}");
    let mut image = grey(&[1.0]);
    image.metadata = vec![("x".repeat(80), String::new())];
    assert!(encode_png(&image, Tonemap::Srgb).is_err());
    image.width = 0;
    assert!(encode_png(&image, Tonemap::Srgb).is_err());
}

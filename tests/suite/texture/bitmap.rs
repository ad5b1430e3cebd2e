//! Pictures: what lies between and beyond pixels, and what files' numbers mean.

use std::path::{Path, PathBuf};

use glam::Vec2;
use image::{DynamicImage, ImageBuffer, Luma};
use solidtrace::color::{Encoding, Rgb};
use solidtrace::image::{Channel, Image};
use solidtrace::io::{Precision, encode_exr, read_bitmap};
use solidtrace::texture::{Bitmap, PixelFilter, Sampling, Wrap};
use tempfile::TempDir;

/// Three pixels across, two down: 0 1 2 over 3 4 5.
fn six() -> Bitmap {
    Bitmap {
        width: 3,
        height: 2,
        pixels: (0..6).map(|i| Rgb::splat(i as f32)).collect(),
    }
}

fn look_up(wrap: Wrap, filter: PixelFilter, x: f32, y: f32) -> f32 {
    let sampling = Sampling {
        wrap: [wrap; 2],
        filter,
    };
    // Pixel units from the upper left corner.
    six().sample(Vec2::new(x / 3.0, 1.0 - y / 2.0), sampling).x
}

#[test]
fn pixels_have_their_own_values_at_their_centres() {
    for filter in [PixelFilter::Bilinear, PixelFilter::Nearest] {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            for i in 0..6 {
                let (x, y) = ((i % 3) as f32 + 0.5, (i / 3) as f32 + 0.5);
                assert!((look_up(wrap, filter, x, y) - i as f32).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn beyond_the_edges_pictures_repeat_stop_or_turn_round() {
    // The upper row at the centres of pixels -4 to 6.
    let row =
        |wrap| (-4..=6).map(move |i| look_up(wrap, PixelFilter::Nearest, i as f32 + 0.5, 0.5));
    let expected = |values: [i8; 11]| values.map(f32::from);
    assert!(row(Wrap::Repeat).eq(expected([2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0])));
    assert!(row(Wrap::Clamp).eq(expected([0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2])));
    assert!(row(Wrap::Mirror).eq(expected([2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0])));
    // The left column likewise.
    let column =
        |wrap| (-2..=3).map(move |i| look_up(wrap, PixelFilter::Nearest, 0.5, i as f32 + 0.5));
    assert!(column(Wrap::Repeat).eq([0.0, 3.0, 0.0, 3.0, 0.0, 3.0]));
    assert!(column(Wrap::Clamp).eq([0.0, 0.0, 0.0, 3.0, 3.0, 3.0]));
    assert!(column(Wrap::Mirror).eq([3.0, 0.0, 0.0, 3.0, 3.0, 0.0]));
}

#[test]
fn between_centres_bilinear_is_straight_and_nearest_is_level() {
    let bilinear = |wrap, x, y| look_up(wrap, PixelFilter::Bilinear, x, y);
    for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
        // Value = column + 3 row, straight inside the outermost centres.
        for (x, y) in [(0.7, 0.6), (1.0, 1.0), (2.4, 1.3)] {
            let expected = (x - 0.5) + 3.0 * (y - 0.5);
            assert!((bilinear(wrap, x, y) - expected).abs() < 1e-5);
        }
    }
    // At the left edge of the upper row: halfway to the last pixel, or the first one's own.
    assert!((bilinear(Wrap::Repeat, 0.0, 0.5) - 1.0).abs() < 1e-5);
    assert!(bilinear(Wrap::Clamp, 0.0, 0.5).abs() < 1e-5);
    assert!(bilinear(Wrap::Mirror, 0.0, 0.5).abs() < 1e-5);
    assert_eq!(look_up(Wrap::Repeat, PixelFilter::Nearest, 1.99, 0.99), 1.0);
    // Far away and nowhere there is no panic.
    for x in [1e30, -1e30, f32::INFINITY, f32::NAN] {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            let _ = (
                bilinear(wrap, x, 0.5),
                look_up(wrap, PixelFilter::Nearest, x, x),
            );
        }
    }
}

fn pixel(path: &Path, encoding: Encoding) -> Rgb {
    read_bitmap(path, encoding).unwrap().pixels[0]
}

/// IEC 61966-2-1.
fn decoded(x: f64) -> f64 {
    if x <= 0.04045 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

#[test]
fn integers_are_srgb_as_colours_and_in_proportion_as_data() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.png");
    for byte in [0_u8, 1, 10, 11, 128, 200, 255] {
        let image = ImageBuffer::from_pixel(2, 2, image::Rgb([byte; 3]));
        image.save(&path).unwrap();
        let share = f64::from(byte) / 255.0;
        let found = f64::from(pixel(&path, Encoding::Srgb).x);
        assert!((found - decoded(share)).abs() < 1e-6, "{byte}: {found}");
        assert!((f64::from(pixel(&path, Encoding::Linear).x) - share).abs() < 1e-7);
    }
    for word in [0_u16, 1000, 30_000, 65_535] {
        let image = ImageBuffer::from_pixel(1, 1, Luma([word]));
        DynamicImage::ImageLuma16(image).save(&path).unwrap();
        let share = f64::from(word) / 65_535.0;
        let found = f64::from(pixel(&path, Encoding::Srgb).y);
        assert!((found - decoded(share)).abs() < 1e-6, "{word}: {found}");
        assert!((f64::from(pixel(&path, Encoding::Linear).z) - share).abs() < 1e-7);
    }
    let path = folder.path().join("a.jpg");
    let image = ImageBuffer::from_pixel(16, 16, image::Rgb([100_u8; 3]));
    image.save(&path).unwrap();
    // The codec may be off by a step.
    assert!((pixel(&path, Encoding::Linear).x * 255.0 - 100.0).abs() < 1.5);
}

#[test]
fn floats_are_taken_as_they_are() {
    let folder = TempDir::new().unwrap();
    let hdr = folder.path().join("a.hdr");
    let values = [4.0_f32, 0.5, 0.25, 0.0, 1.0, 16.0];
    let image = ImageBuffer::from_fn(2, 1, |x, _| {
        let at = 3 * x as usize;
        image::Rgb([values[at], values[at + 1], values[at + 2]])
    });
    DynamicImage::ImageRgb32F(image).save(&hdr).unwrap();
    let exr_path = folder.path().join("a.exr");
    exr::prelude::write_rgb_file(&exr_path, 2, 1, |x, _| {
        (values[3 * x], values[3 * x + 1], values[3 * x + 2])
    })
    .unwrap();
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        // Radiance's format shares one exponent: a 256th of the largest channel.
        let found = read_bitmap(&hdr, encoding).unwrap();
        for (pixel, expected) in found.pixels.iter().zip(values.chunks(3)) {
            let expected = Rgb::from_slice(expected);
            assert!(
                pixel.abs_diff_eq(expected, expected.max_element() / 128.0),
                "{pixel}"
            );
        }
        let found = read_bitmap(&exr_path, encoding).unwrap();
        assert_eq!((found.width, found.height), (2, 1));
        assert_eq!(
            found.pixels,
            [Rgb::new(4.0, 0.5, 0.25), Rgb::new(0.0, 1.0, 16.0)]
        );
    }
}

/// An EXR of one pixel whose channels have the values 1, 2, 3 ...
fn exr_of(folder: &TempDir, names: &[&str]) -> PathBuf {
    let channel = |(i, name): (usize, &&str)| Channel {
        name: (*name).to_owned(),
        values: vec![i as f32 + 1.0],
    };
    let image = Image {
        width: 1,
        height: 1,
        channels: names.iter().enumerate().map(channel).collect(),
        metadata: Vec::new(),
    };
    let path = folder.path().join("channels.exr");
    std::fs::write(&path, encode_exr(&image, Precision::Half).unwrap()).unwrap();
    path
}

#[test]
fn of_an_exrs_channels_those_of_the_colour_are_read() {
    let folder = TempDir::new().unwrap();
    for (names, expected) in [
        (&["R", "G", "B"][..], Rgb::new(1.0, 2.0, 3.0)),
        (&["Z", "B", "A", "G", "R"], Rgb::new(5.0, 4.0, 2.0)),
        (&["Y", "A"], Rgb::ONE),
    ] {
        assert_eq!(pixel(&exr_of(&folder, names), Encoding::Linear), expected);
    }
    let error = read_bitmap(&exr_of(&folder, &["R", "G"]), Encoding::Linear).unwrap_err();
    let report = error.to_string();
    assert!(
        report.contains("R, G and B") && report.contains("channels.exr"),
        "{report}"
    );
    let cut = folder.path().join("cut.exr");
    let whole = std::fs::read(exr_of(&folder, &["Y"])).unwrap();
    std::fs::write(&cut, &whole[..whole.len() - 3]).unwrap();
    assert!(read_bitmap(&cut, Encoding::Linear).is_err());
}

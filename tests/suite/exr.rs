//! EXR files hold exactly what the image holds, and damaged ones do no damage.

use std::fs;

use solidtrace::ErrorKind;
use solidtrace::color::Rgb;
use solidtrace::image::{Channel, Image};
use solidtrace::io::{Precision, WriteOptions, decode_exr, encode_exr, read_exr, write_image};

use crate::random::SplitMix;

/// R, G, B and more, with every kind of finite f32.
fn picture(width: usize, height: usize, names: &[&str]) -> Image {
    let mut random = SplitMix((width * 1000 + height) as u64);
    let special = [
        0.0,
        -0.0,
        1.0,
        f32::from_bits(1),
        -f32::from_bits(0x7f_ffff),
        f32::MIN_POSITIVE,
        f32::MAX,
        f32::MIN,
        65504.0,
        65536.0,
    ];
    let channels = names.iter().map(|&name| Channel {
        name: name.to_owned(),
        values: (0..width * height)
            .map(|i| match i % 3 {
                0 => special[random.next() as usize % special.len()],
                1 => 0.25,
                _ => random.float(-126, 127),
            })
            .collect(),
    });
    Image {
        width,
        height,
        channels: channels.collect(),
        metadata: vec![
            ("camera".to_owned(), "front \"left\"\n, α = 0.5".to_owned()),
            ("scene".to_owned(), "größe.ron".to_owned()),
            ("Größe".to_owned(), "12.5".to_owned()),
            ("spp".to_owned(), "256".to_owned()),
            (
                "a name of more than thirty one characters".to_owned(),
                String::new(),
            ),
        ],
    }
}

fn value_bits(image: &Image, name: &str) -> Vec<u32> {
    let values = image
        .channel(name)
        .unwrap_or_else(|| panic!("no channel {name}"));
    values.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn exr_keeps_every_bit_name_and_word() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["R", "G", "B", "albedo.R", "N.X", "Z"];
    for (width, height) in [(1, 1), (1, 7), (7, 1), (33, 17), (128, 64)] {
        let image = picture(width, height, &names);
        let path = folder.path().join(format!("{width}x{height}.exr"));
        write_image(&path, &image, &WriteOptions::default()).unwrap();
        let back = read_exr(&path).unwrap();
        assert_eq!((back.width, back.height), (width, height));
        assert_eq!(back.channels.len(), names.len());
        for name in names {
            assert_eq!(value_bits(&back, name), value_bits(&image, name), "{name}");
        }
        let mut metadata = image.metadata.clone();
        metadata.sort();
        assert_eq!(back.metadata, metadata);
    }
}

#[test]
fn exr_is_what_another_reader_expects() {
    use ::exr::prelude::{ReadChannels, ReadLayers};
    let image = picture(19, 11, &["R", "G", "B"]);
    let bytes = encode_exr(&image, Precision::Float).unwrap();
    let read = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| vec![[0_f32; 3]; size.area()],
            |pixels, position, (r, g, b): (f32, f32, f32)| {
                pixels[position.flat_index_for_size(::exr::prelude::Vec2(19, 11))] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(&bytes))
        .unwrap();
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let pixels = &read.layer_data.channel_data.pixels;
        let bits: Vec<u32> = pixels.iter().map(|p| p[channel].to_bits()).collect();
        assert_eq!(bits, value_bits(&image, name));
    }
    let encoding = read.layer_data.encoding;
    assert_eq!(encoding.compression, ::exr::prelude::Compression::ZIP1);
    let attributes = &read.layer_data.attributes;
    let software = attributes.software_name.as_ref().unwrap().to_string();
    assert!(software.starts_with("solidtrace "), "{software}");
    assert_eq!(read.attributes.pixel_aspect, 1.0);
    assert_eq!(
        read.attributes.chromaticities.unwrap().white,
        ::exr::prelude::Vec2(0.3127, 0.329)
    );
}

#[test]
fn equal_images_give_equal_bytes() {
    let image = picture(40, 30, &["R", "G", "B", "Z"]);
    for precision in [Precision::Float, Precision::Half] {
        let first = encode_exr(&image, precision).unwrap();
        for _ in 0..20 {
            assert!(encode_exr(&image, precision).unwrap() == first);
        }
    }
}

#[test]
fn half_rounds_to_nearest_and_never_to_infinity() {
    // Between 1 and 2 halves are 2^-10 apart; a tie goes to the even one.
    let step = 2_f32.powi(-10);
    let given = [
        1.0 + 0.4 * step,
        1.0 + 0.6 * step,
        1.0 + 0.5 * step,
        1.0 + 1.5 * step,
        1e9,
        -1e9,
        f32::MAX,
        2_f32.powi(-24),
        65504.0,
    ];
    let stored = [
        1.0,
        1.0 + step,
        1.0,
        1.0 + 2.0 * step,
        65504.0,
        -65504.0,
        65504.0,
        2_f32.powi(-24),
        65504.0,
    ];
    let row = Image::rgb(given.len(), 1, &given.map(Rgb::splat));
    let bytes = encode_exr(&row, Precision::Half).unwrap();
    assert_eq!(decode_exr(&bytes).unwrap().channel("G").unwrap(), stored);
}

#[test]
fn exr_refuses_what_the_format_cannot_hold() {
    let refused = |message: &str, change: fn(&mut Image)| {
        let mut image = picture(2, 2, &["R", "G", "B"]);
        change(&mut image);
        let error = encode_exr(&image, Precision::Float).unwrap_err();
        assert!(error.message().contains(message), "{error}");
    };
    refused("nothing to write", |image| image.width = 0);
    refused("nothing to write", |image| image.channels.clear());
    refused("`G` has 3 values where 2 x 2 pixels need 4", |image| {
        image.channels[1].values.truncate(3);
    });
    refused("not unique", |image| image.channels[1].name = "R".into());
    refused("cannot name", |image| image.channels[1].name.clear());
    refused("cannot name", |image| image.metadata[0].0 = "a\0b".into());
    refused("reserved", |image| {
        image.metadata[0].0 = "dataWindow".into();
    });
}

#[test]
fn a_file_that_is_no_exr_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    let error = read_exr(&path).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Read);
    assert_eq!(error.place().unwrap().file, path);
    fs::write(&path, "no picture at all").unwrap();
    let error = read_exr(&path).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Input);
    assert_eq!(error.place().unwrap().file, path);
}

/// The position of the value of a header's attribute.
fn attribute(bytes: &[u8], name: &str) -> usize {
    let name = format!("{name}\0");
    let start = bytes
        .windows(name.len())
        .position(|w| w == name.as_bytes())
        .unwrap()
        + name.len();
    start + bytes[start..].iter().position(|&b| b == 0).unwrap() + 1 + 4
}

#[test]
fn a_header_that_asks_for_the_moon_is_refused_before_it_costs_memory() {
    let bytes = encode_exr(&picture(8, 8, &["R", "G", "B"]), Precision::Float).unwrap();
    let window = attribute(&bytes, "dataWindow");
    for (width, height) in [
        (1 << 29, 8),
        (8, 1 << 29),
        (1 << 29, 1 << 29),
        (100_000, 100_000),
        (8, 100_000),
    ] {
        let mut mutant = bytes.clone();
        mutant[window + 8..window + 12].copy_from_slice(&(width - 1_i32).to_le_bytes());
        mutant[window + 12..window + 16].copy_from_slice(&(height - 1_i32).to_le_bytes());
        let error = decode_exr(&mutant).unwrap_err();
        assert!(error.message().contains("cannot hold"), "{error}");
        assert!(
            error.message().contains(&format!("{width} x {height}")),
            "{error}"
        );
    }
}

#[test]
fn compressions_whose_decoders_are_not_safe_are_refused() {
    let bytes = encode_exr(&picture(8, 8, &["R", "G", "B"]), Precision::Float).unwrap();
    // B44, B44A, DWAA and DWAB in the order of the format's list.
    for code in 6..=9 {
        let mut mutant = bytes.clone();
        mutant[attribute(&bytes, "compression")] = code;
        let error = decode_exr(&mutant).unwrap_err();
        assert!(error.message().contains("is not read"), "{error}");
    }
}

#[test]
fn damaged_exr_files_are_errors_or_pictures_but_never_panics() {
    let mut random = SplitMix(7);
    let originals: Vec<Vec<u8>> = [(9, 5, Precision::Float), (3, 8, Precision::Half)]
        .map(|(width, height, precision)| {
            encode_exr(&picture(width, height, &["R", "G", "B", "N.X"]), precision).unwrap()
        })
        .to_vec();
    for original in &originals {
        for length in 0..original.len() {
            assert!(decode_exr(&original[..length]).is_err(), "cut to {length}");
        }
    }
    for round in 0..2000 {
        let mut mutant = originals[round % originals.len()].clone();
        for _ in 0..=random.next() % 3 {
            let at = random.next() as usize % mutant.len();
            match random.next() % 3 {
                0 => mutant[at] ^= 1 << (random.next() % 8),
                1 => mutant[at] = [0, 1, 0x7f, 0x80, 0xff][random.next() as usize % 5],
                _ => mutant[at] = random.next() as u8,
            }
        }
        let outcome =
            std::panic::catch_unwind(|| decode_exr(&mutant).map(|image| image.validate()));
        assert!(outcome.is_ok(), "mutant {round} made the reader panic");
    }
}

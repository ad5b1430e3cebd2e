//! Pictures come out whole, exact and only where they may.

use std::fs;
use std::path::Path;

use solidtrace::ErrorKind;
use solidtrace::color::{Rgb, Tonemap};
use solidtrace::image::{Channel, Image};
use solidtrace::io::{
    Precision, WriteOptions, check_image_path, check_writable, decode_exr, encode_exr, encode_png,
    read_exr, write_atomically, write_image,
};

use crate::random::SplitMix;

const REPLACE: WriteOptions = WriteOptions {
    overwrite: true,
    tonemap: Tonemap::Srgb,
    precision: Precision::Float,
};

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

fn grey(values: &[f32]) -> Image {
    let pixels: Vec<Rgb> = values.iter().map(|&x| Rgb::splat(x)).collect();
    Image::rgb(values.len(), 1, &pixels)
}

fn value_bits(image: &Image, name: &str) -> Vec<u32> {
    let values = image
        .channel(name)
        .unwrap_or_else(|| panic!("no channel {name}"));
    values.iter().map(|x| x.to_bits()).collect()
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
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
    use exr::prelude::{ReadChannels, ReadLayers};
    let image = picture(19, 11, &["R", "G", "B"]);
    let bytes = encode_exr(&image, Precision::Float).unwrap();
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| vec![[0_f32; 3]; size.area()],
            |pixels, position, (r, g, b): (f32, f32, f32)| {
                pixels[position.flat_index_for_size(exr::prelude::Vec2(19, 11))] = [r, g, b]
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
    assert_eq!(encoding.compression, exr::prelude::Compression::ZIP1);
    let attributes = &read.layer_data.attributes;
    let software = attributes.software_name.as_ref().unwrap().to_string();
    assert!(software.starts_with("solidtrace "), "{software}");
    assert_eq!(read.attributes.pixel_aspect, 1.0);
    assert_eq!(
        read.attributes.chromaticities.unwrap().white,
        exr::prelude::Vec2(0.3127, 0.329)
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
    let first = encode_png(&image, Tonemap::Srgb).unwrap();
    assert!(encode_png(&image, Tonemap::Srgb).unwrap() == first);
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
    let bytes = encode_exr(&grey(&given), Precision::Half).unwrap();
    assert_eq!(decode_exr(&bytes).unwrap().channel("G").unwrap(), stored);
}

#[test]
fn exr_refuses_what_the_format_cannot_hold() {
    let good = picture(2, 2, &["R", "G", "B"]);
    let broken: [(&str, fn(&mut Image)); 7] = [
        ("nothing to write", |image| image.width = 0),
        ("nothing to write", |image| image.channels.clear()),
        ("`G` has 3 values where 2 x 2 pixels need 4", |image| {
            image.channels[1].values.truncate(3)
        }),
        ("not unique", |image| {
            image.channels[1].name = "R".to_owned()
        }),
        ("cannot name", |image| image.channels[1].name.clear()),
        ("cannot name", |image| {
            image.metadata[0].0 = "a\0b".to_owned()
        }),
        ("reserved", |image| {
            image.metadata[0].0 = "dataWindow".to_owned()
        }),
    ];
    for (message, breaks) in broken {
        let mut image = good.clone();
        breaks(&mut image);
        let error = encode_exr(&image, Precision::Float).unwrap_err();
        assert!(error.message().contains(message), "{error}");
    }
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
        for _ in 0..1 + random.next() % 3 {
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
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        reader.finish().unwrap();
        let info = reader.info();
        assert_eq!(info.srgb.is_some(), srgb, "{tonemap:?}");
        assert_eq!(
            info.gama_chunk
                .map(png::ScaledFloat::into_scaled)
                .filter(|_| !srgb),
            gamma
        );
        assert_eq!(info.utf8_text[0].keyword, "scene");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "größe α.ron");
    }
}

#[test]
fn png_refuses_what_it_cannot_show() {
    let error = encode_png(&picture(2, 2, &["Z"]), Tonemap::Srgb).unwrap_err();
    assert!(error.message().contains("no channel `R`"), "{error}");
    let mut image = grey(&[1.0]);
    image.metadata = vec![("x".repeat(80), String::new())];
    assert!(encode_png(&image, Tonemap::Srgb).is_err());
    image.width = 0;
    assert!(encode_png(&image, Tonemap::Srgb).is_err());
}

#[test]
fn the_extension_chooses_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let image = grey(&[0.5]);
    for (name, magic) in [("a.exr", b"\x76\x2f\x31\x01"), ("a.PNG", b"\x89PNG")] {
        let path = folder.path().join(name);
        check_image_path(&path, false).unwrap();
        write_image(&path, &image, &WriteOptions::default()).unwrap();
        assert!(fs::read(&path).unwrap().starts_with(magic));
    }
    for name in ["a.jpg", "a", "a.exr.bak"] {
        let path = folder.path().join(name);
        for error in [
            write_image(&path, &image, &REPLACE).unwrap_err(),
            check_image_path(&path, true).unwrap_err(),
        ] {
            assert_eq!(error.kind(), ErrorKind::Usage);
            assert!(error.to_string().contains(".exr") && error.to_string().contains(".png"));
        }
    }
    assert_eq!(names_in(folder.path()), ["a.PNG", "a.exr"]);
}

#[test]
fn an_old_file_is_replaced_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.bin");
    check_writable(&path, false).unwrap();
    assert!(names_in(folder.path()).is_empty());
    write_atomically(&path, b"old", false).unwrap();
    for error in [
        write_atomically(&path, b"new", false).unwrap_err(),
        check_writable(&path, false).unwrap_err(),
    ] {
        assert_eq!(error.kind(), ErrorKind::Write);
        assert!(error.to_string().contains("--force"), "{error}");
        assert_eq!(error.place().unwrap().file, path);
    }
    assert_eq!(fs::read(&path).unwrap(), b"old");
    check_writable(&path, true).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"old");
    write_atomically(&path, b"new", true).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names_in(folder.path()), ["out.bin"]);
}

#[test]
fn what_cannot_be_written_is_an_error_before_and_after_the_render() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "old").unwrap();
    fs::create_dir(folder.path().join("taken.png")).unwrap();
    for (path, message) in [
        (file.join("out.png"), "is not a folder"),
        (folder.path().join("missing/out.png"), "does not exist"),
        (folder.path().join("taken.png"), "a folder has this name"),
        (folder.path().join(".."), "names no file"),
        (Path::new("/dev/null").to_owned(), "not a regular file"),
    ] {
        for overwrite in [false, true] {
            for error in [
                write_atomically(&path, b"new", overwrite).unwrap_err(),
                check_writable(&path, overwrite).unwrap_err(),
            ] {
                assert_eq!(error.kind(), ErrorKind::Write);
                assert!(error.message().contains(message), "{error}");
            }
        }
    }
    assert_eq!(fs::read(&file).unwrap(), b"old");
    assert_eq!(names_in(folder.path()), ["file", "taken.png"]);
}

#[test]
fn an_image_that_cannot_be_encoded_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["out.exr", "out.png"] {
        let path = folder.path().join(name);
        fs::write(&path, "old").unwrap();
        let mut image = grey(&[1.0, 2.0]);
        image.channels[2].values.pop();
        let error = write_image(&path, &image, &REPLACE).unwrap_err();
        assert_eq!(error.place().unwrap().file, path);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }
    assert_eq!(names_in(folder.path()), ["out.exr", "out.png"]);
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::process::Command;

    use super::*;

    const TARGET: &str = "SOLIDTRACE_TEST_TARGET";

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn a_new_file_has_the_permissions_of_any_other_and_an_old_one_keeps_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let ordinary = folder.path().join("ordinary");
        fs::write(&ordinary, "").unwrap();
        let path = folder.path().join("out");
        write_atomically(&path, b"new", false).unwrap();
        assert_eq!(mode(&path), mode(&ordinary));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        write_atomically(&path, b"newer", true).unwrap();
        assert_eq!(mode(&path), 0o640);
    }

    #[test]
    fn a_link_is_followed_and_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let target = elsewhere.path().join("target");
        fs::write(&target, "old").unwrap();
        let link = folder.path().join("link");
        symlink(&target, &link).unwrap();
        assert!(write_atomically(&link, b"new", false).is_err());
        write_atomically(&link, b"new", true).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
        fs::remove_file(&target).unwrap();
        let error = write_atomically(&link, b"new", true).unwrap_err();
        assert!(error.message().contains("leads nowhere"), "{error}");
    }

    #[test]
    fn a_disk_that_fills_up_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        fs::write(&path, "old").unwrap();
        // A limit on the size of files stands for the full disk: the write fails half way.
        let child = Command::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" --exact output::unix::writes_a_megabyte --ignored"])
            .arg(std::env::current_exe().unwrap())
            .env(TARGET, &path)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&child.stdout);
        assert!(
            child.status.success() && text.contains("1 passed"),
            "{text}"
        );
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names_in(folder.path()), ["out"]);
    }

    #[test]
    #[ignore = "run by a_disk_that_fills_up_leaves_the_old_file_and_nothing_else"]
    fn writes_a_megabyte() {
        let Some(path) = std::env::var_os(TARGET) else {
            return;
        };
        let error = write_atomically(Path::new(&path), &[7; 1 << 20], true).unwrap_err();
        assert!(error.message().contains("too large"), "{error}");
    }
}

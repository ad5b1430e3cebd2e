//! Pictures for the screen: 8-bit RGB PNG.

use png::text_metadata::ITXtChunk;
use png::{BitDepth, ColorType, Encoder, ScaledFloat, SrgbRenderingIntent};
use rayon::prelude::*;

use crate::color::Tonemap;
use crate::error::{Error, ErrorKind, Result};
use crate::image::Image;

/// Encodes the channels `R`, `G`, `B` as 8-bit PNG. Each value goes through the curve, is clipped and rounded
/// to the nearest of 255 steps, without dither; what is not a number becomes 0. The header names the curve
/// (`sRGB`, or `gAMA` for a power), and the metadata is written as text.
///
/// # Errors
/// Where a channel is missing, the image is empty or too large for the format, or a metadata name has not
/// 1 to 79 Latin-1 characters.
pub fn encode_png(image: &Image, tonemap: Tonemap) -> Result<Vec<u8>> {
    image.validate()?;
    let channel = |name: &str| {
        image.channel(name).ok_or_else(|| {
            Error::new(
                ErrorKind::Write,
                format!("the image has no channel `{name}`, and a PNG needs R, G and B"),
            )
            .help("write an .exr file, which takes any channels")
        })
    };
    let (r, g, b) = (channel("R")?, channel("G")?, channel("B")?);
    let byte = |linear: f32| (255.0 * tonemap.encode(linear)).round() as u8;
    let mut pixels = vec![0; 3 * r.len()];
    (pixels.par_chunks_mut(3).zip(r.par_iter().zip(g).zip(b)))
        .with_min_len(1 << 12)
        .for_each(|(pixel, ((&r, &g), &b))| {
            pixel.copy_from_slice(&[byte(r), byte(g), byte(b)]);
        });
    write_png(image, tonemap, &pixels).map_err(|cause| {
        Error::new(
            ErrorKind::Write,
            format!("the image does not fit into a PNG: {cause}"),
        )
    })
}

fn write_png(
    image: &Image,
    tonemap: Tonemap,
    pixels: &[u8],
) -> std::result::Result<Vec<u8>, png::EncodingError> {
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, side(image.width), side(image.height));
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    match tonemap {
        Tonemap::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric),
        Tonemap::Gamma22 => encoder.set_source_gamma(ScaledFloat::from_scaled(45_455)),
        Tonemap::None => encoder.set_source_gamma(ScaledFloat::from_scaled(100_000)),
    }
    let mut writer = encoder.write_header()?;
    for (name, value) in &image.metadata {
        writer.write_text_chunk(&ITXtChunk::new(name, value))?;
    }
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}

//! Pictures for the screen: 8-bit RGB PNG.

use std::io::Write;

use png::text_metadata::ITXtChunk;
use png::{BitDepth, ColorType, DeflateCompression, Encoder, ScaledFloat, SrgbRenderingIntent};
use rayon::prelude::*;

use crate::color::Tonemap;
use crate::error::{Error, ErrorKind, Result};
use crate::image::Image;

/// Encodes the channels `R`, `G`, `B` as 8-bit PNG, by [`screen_bytes`]. The header names the curve
/// (`sRGB`, or `gAMA` for a power), and the metadata is written as text.
///
/// # Errors
/// Where a channel is missing, the image is empty or too large for the format, or a metadata name has not
/// 1 to 79 Latin-1 characters.
pub fn encode_png(image: &Image, tonemap: Tonemap) -> Result<Vec<u8>> {
    let pixels = screen_bytes(image, tonemap)?;
    write_png(image, tonemap, &pixels).map_err(|cause| {
        Error::new(
            ErrorKind::Write,
            format!("the image does not fit into a PNG: {cause}"),
        )
    })
}

/// Three bytes a pixel, row by row: each value goes through the curve, is clipped and rounded to the nearest of 255
/// steps, without dither; what is not a number becomes 0.
///
/// # Errors
/// Where a channel is missing, or the image is empty.
pub fn screen_bytes(image: &Image, tonemap: Tonemap) -> Result<Vec<u8>> {
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
    let steps = Steps::of(|linear| (255.0 * tonemap.encode(linear)).round() as u8);
    let byte = |linear: f32| steps.byte(linear);
    let mut pixels = vec![0; 3 * r.len()];
    (pixels.par_chunks_mut(3).zip(r.par_iter().zip(g).zip(b)))
        .with_min_len(1 << 12)
        .for_each(|(pixel, ((&r, &g), &b))| {
            pixel.copy_from_slice(&[byte(r), byte(g), byte(b)]);
        });
    Ok(pixels)
}

/// A curve from numbers to bytes that never falls, as a table: the same bytes, sooner than by powers.
struct Steps {
    /// For each byte the least number, as its bits, that is beyond it.
    end: [u32; 256],
    /// The byte at the start of each range of [`Steps::RANGE`] bit patterns.
    start: Vec<u8>,
}

impl Steps {
    /// Positive numbers are ordered as their bits are.
    const RANGE: u32 = 1 << 18;

    fn of(curve: impl Fn(f32) -> u8) -> Self {
        let most = f32::INFINITY.to_bits();
        let reaches = |byte: u8| {
            let (mut below, mut at) = (0, most + 1);
            while at - below > 1 {
                let middle = below + (at - below) / 2;
                if curve(f32::from_bits(middle)) >= byte {
                    at = middle;
                } else {
                    below = middle;
                }
            }
            at
        };
        let mut end = [u32::MAX; 256];
        for (byte, end) in (1..=255).zip(&mut end) {
            *end = reaches(byte);
        }
        let start =
            (0..=most / Self::RANGE).map(|range| curve(f32::from_bits(range * Self::RANGE)));
        Self {
            start: start.collect(),
            end,
        }
    }

    /// 0 for what is below 0 or no number.
    fn byte(&self, x: f32) -> u8 {
        if x > 0.0 {
            let bits = x.to_bits();
            let mut byte = self.start[(bits / Self::RANGE) as usize];
            while bits >= self.end[byte as usize] {
                byte += 1;
            }
            byte
        } else {
            0
        }
    }
}

fn write_png(
    image: &Image,
    tonemap: Tonemap,
    pixels: &[u8],
) -> std::result::Result<Vec<u8>, png::EncodingError> {
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let mut bytes = Vec::new();
    let size = (side(image.width), side(image.height));
    let mut writer = encoder(&mut bytes, size, tonemap).write_header()?;
    for (name, value) in &image.metadata {
        writer.write_text_chunk(&ITXtChunk::new(name, value))?;
    }
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}

/// For 8-bit RGB that went through a curve.
pub(super) fn encoder<W: Write>(to: W, size: (u32, u32), tonemap: Tonemap) -> Encoder<'static, W> {
    let mut encoder = Encoder::new(to, size.0, size.1);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    match tonemap {
        Tonemap::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric),
        Tonemap::Gamma22 => encoder.set_source_gamma(ScaledFloat::from_scaled(45_455)),
        Tonemap::None => encoder.set_source_gamma(ScaledFloat::from_scaled(100_000)),
    }
    // Of a noisy picture a higher level takes off a thousandth, in half as much time again.
    encoder.set_deflate_compression(DeflateCompression::Level(4));
    encoder
}

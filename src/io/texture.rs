//! Picture files as textures.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use crate::color::{Rgb, srgb_to_linear};
use crate::error::{Error, Place, Result};
use crate::texture::Bitmap;

use super::read_file;

/// Most pixels a side.
const MAX_SIDE: u32 = 16_384;
/// Most bytes that a decoder may ask for.
const MAX_BYTES: u64 = 1 << 30;

/// Reads a picture (PNG, JPEG, BMP, TGA, Radiance HDR) into linear light: integer channels are decoded
/// from sRGB, floating-point ones are linear already; alpha is ignored.
///
/// # Errors
/// Where the file cannot be read, is not a picture, or has more than 16,384 pixels a side.
pub fn read_bitmap(path: &Path) -> Result<Bitmap> {
    let bytes = read_file(path)?;
    let by_name = ImageFormat::from_path(path).ok();
    decode_bitmap(&bytes, by_name).map_err(|e| e.at(Place::file(path)))
}

/// The picture in `bytes`, told by its first bytes, else (TGA has no mark) taken as `fallback`.
///
/// # Errors
/// As [`read_bitmap`], without a place.
pub(super) fn decode_bitmap(bytes: &[u8], fallback: Option<ImageFormat>) -> Result<Bitmap> {
    let bad = |cause: &dyn std::fmt::Display| {
        Error::input(format!("not a picture that can be read: {cause}"))
            .help("use PNG, JPEG, BMP, TGA or HDR")
    };
    let format = (image::guess_format(bytes).ok().or(fallback))
        .ok_or_else(|| bad(&"the format is not known"))?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| bad(&e))?;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let pixels = linear(picture);
    if pixels.is_empty() {
        return Err(bad(&"it has no pixels"));
    }
    if let Some(i) = pixels.iter().position(|p| !p.is_finite()) {
        return Err(Error::input(format!(
            "pixel ({}, {}) of the picture is not finite",
            i % width,
            i / width
        )));
    }
    Ok(Bitmap {
        width,
        height,
        pixels,
    })
}

fn linear(picture: DynamicImage) -> Vec<Rgb> {
    match picture {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let image = picture.into_rgb32f();
            image.pixels().map(|p| Rgb::from_array(p.0)).collect()
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            let decode = |c: u16| srgb_to_linear(f32::from(c) / 65_535.0);
            let image = picture.into_rgb16();
            (image.pixels().map(|p| Rgb::from_array(p.0.map(decode)))).collect()
        }
        _ => {
            let table: [f32; 256] = std::array::from_fn(|c| srgb_to_linear(c as f32 / 255.0));
            let image = picture.into_rgb8();
            (image.pixels())
                .map(|p| Rgb::from_array(p.0.map(|c| table[usize::from(c)])))
                .collect()
        }
    }
}

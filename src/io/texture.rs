//! Picture files as textures.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use crate::color::{Encoding, Rgb};
use crate::error::{Error, Place, Result};
use crate::image::Image;
use crate::texture::Bitmap;

use super::{decode_exr, read_file};

/// Most pixels a side.
const MAX_SIDE: u32 = 16_384;
/// Most bytes that a decoder may ask for.
const MAX_BYTES: u64 = 1 << 30;

/// Reads a picture (PNG, JPEG, BMP, TGA, Radiance HDR, EXR), told by its content, else by its name. Integer channels
/// are decoded as `encoding` says, floating-point ones are linear already. Alpha is ignored; of an EXR the channels `R`,
/// `G` and `B` are read, else `Y`.
///
/// # Errors
/// Where the file cannot be read, is not a picture, or has more than 16,384 pixels a side.
pub fn read_bitmap(path: &Path, encoding: Encoding) -> Result<Bitmap> {
    let bytes = read_file(path)?;
    let by_name = ImageFormat::from_path(path).ok();
    decode_bitmap(&bytes, by_name, encoding).map_err(|e| e.at(Place::file(path)))
}

/// The picture in `bytes`, told by its first bytes, else (TGA has no mark) taken as `fallback`.
///
/// # Errors
/// As [`read_bitmap`], without a place.
pub(super) fn decode_bitmap(
    bytes: &[u8],
    fallback: Option<ImageFormat>,
    encoding: Encoding,
) -> Result<Bitmap> {
    let format = (image::guess_format(bytes).ok().or(fallback))
        .ok_or_else(|| bad(&"the format is not known"))?;
    let bitmap = match format {
        ImageFormat::OpenExr => from_exr(&decode_exr(bytes)?)?,
        _ => from_other(bytes, format, encoding)?,
    };
    if bitmap.pixels.is_empty() {
        return Err(bad(&"it has no pixels"));
    }
    if let Some(i) = bitmap.pixels.iter().position(|p| !p.is_finite()) {
        return Err(Error::input(format!(
            "pixel ({}, {}) of the picture is not finite",
            i % bitmap.width,
            i / bitmap.width
        )));
    }
    Ok(bitmap)
}

fn bad(cause: &dyn std::fmt::Display) -> Error {
    Error::input(format!("not a picture that can be read: {cause}"))
        .help("use PNG, JPEG, BMP, TGA, HDR or EXR")
}

fn from_exr(image: &Image) -> Result<Bitmap> {
    let (width, height) = (image.width, image.height);
    if width.max(height) > MAX_SIDE as usize {
        return Err(bad(&format!(
            "it has {width} x {height} pixels, and {MAX_SIDE} a side are most"
        )));
    }
    let channels = match image.channel("Y") {
        Some(grey) if image.channel("R").is_none() => [grey; 3],
        _ => {
            let [r, g, b] = ["R", "G", "B"].map(|name| image.channel(name));
            let missing = || bad(&"it has neither the channels R, G and B nor Y");
            (r.zip(g).zip(b))
                .map(|((r, g), b)| [r, g, b])
                .ok_or_else(missing)?
        }
    };
    let pixel = |i: usize| Rgb::from_array(channels.map(|values| values[i]));
    Ok(Bitmap {
        width,
        height,
        pixels: (0..width * height).map(pixel).collect(),
    })
}

fn from_other(bytes: &[u8], format: ImageFormat, encoding: Encoding) -> Result<Bitmap> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| bad(&e))?;
    Ok(Bitmap {
        width: picture.width() as usize,
        height: picture.height() as usize,
        pixels: linear(picture, encoding),
    })
}

fn linear(picture: DynamicImage, encoding: Encoding) -> Vec<Rgb> {
    match picture {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let image = picture.into_rgb32f();
            image.pixels().map(|p| Rgb::from_array(p.0)).collect()
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            let decode = |c: u16| encoding.decode(f32::from(c) / 65_535.0);
            let image = picture.into_rgb16();
            (image.pixels().map(|p| Rgb::from_array(p.0.map(decode)))).collect()
        }
        _ => {
            let table: [f32; 256] = std::array::from_fn(|c| encoding.decode(c as f32 / 255.0));
            let image = picture.into_rgb8();
            (image.pixels())
                .map(|p| Rgb::from_array(p.0.map(|c| table[usize::from(c)])))
                .collect()
        }
    }
}

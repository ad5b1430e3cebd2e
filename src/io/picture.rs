//! A finished picture to a file, by the file's extension.

use std::path::Path;

use crate::color::Tonemap;
use crate::error::{Error, ErrorKind, Place, Result};
use crate::image::Image;

use super::{Precision, check_writable, encode_exr, encode_png, write_atomically};

/// How [`write_image`] writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Whether a file that is there is replaced.
    pub overwrite: bool,
    /// Curve of a PNG.
    pub tonemap: Tonemap,
    /// Size of an EXR's values.
    pub precision: Precision,
}

#[derive(Clone, Copy)]
enum Format {
    Exr,
    Png,
}

impl Format {
    fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_lowercase().as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            _ => {
                let message = if extension.is_empty() {
                    "the output's name has no extension".to_owned()
                } else {
                    format!("images cannot be written as `.{extension}`")
                };
                Err(Error::new(ErrorKind::Usage, message)
                    .at(Place::file(path))
                    .help("use .exr (linear, full precision) or .png (8 bits, for the screen)"))
            }
        }
    }
}

/// Writes a picture atomically, as linear EXR or as PNG through a curve.
///
/// # Errors
/// Where the extension is neither `.exr` nor `.png`, the format cannot hold the image, or the file cannot be
/// written; see [`encode_exr`], [`encode_png`] and [`write_atomically`].
pub fn write_image(path: &Path, image: &Image, options: &WriteOptions) -> Result<()> {
    let bytes = match Format::of(path)? {
        Format::Exr => encode_exr(image, options.precision),
        Format::Png => encode_png(image, options.tonemap),
    };
    let bytes = bytes.map_err(|error| error.at(Place::file(path)))?;
    write_atomically(path, &bytes, options.overwrite)
}

/// Finds out before a render whether [`write_image`] can write to `path`.
///
/// # Errors
/// Where the extension is neither `.exr` nor `.png`, or as [`check_writable`].
pub fn check_image_path(path: &Path, overwrite: bool) -> Result<()> {
    Format::of(path)?;
    check_writable(path, overwrite)
}

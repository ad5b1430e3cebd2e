//! Pictures laid over surfaces.

use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::texture::Bitmap;

/// Reads a picture.
///
/// # Errors
/// Always: placeholder until the readers land.
pub fn read_bitmap(path: &Path) -> Result<Bitmap> {
    Err(Error::input("pictures cannot be read yet").at(Place::file(path)))
}

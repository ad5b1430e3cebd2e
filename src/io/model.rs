//! One door for all model formats.

use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::scene::Model;

/// Reads a model.
///
/// # Errors
/// Always: placeholder until the readers land.
pub fn read_model(path: &Path) -> Result<Model> {
    Err(Error::input("models cannot be read yet").at(Place::file(path)))
}

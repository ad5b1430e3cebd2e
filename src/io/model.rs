//! One door for all model formats.

use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::scene::Model;

use super::{gltf, obj};

/// Reads a model; the extension says which format: `.obj`, `.gltf`, `.glb`.
///
/// # Errors
/// Where the file or one that it names cannot be read or is malformed, or the extension is another.
pub fn read_model(path: &Path) -> Result<Model> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "obj" => obj::read(path),
        "gltf" | "glb" => gltf::read(path),
        _ => Err(Error::input(format!(
            "no reader for models with the extension `{extension}`"
        ))
        .at(Place::file(path))
        .help("models can be .obj, .gltf or .glb")),
    }
}

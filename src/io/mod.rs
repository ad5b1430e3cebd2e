//! Files in and out: scenes, models, textures, images. Nothing else in the crate knows a file format.

mod atomic;
mod bare;
mod closed;
mod exr;
mod gltf;
mod lines;
mod model;
mod mtl;
mod obj;
mod picture;
mod png;
mod rays;
mod resolve;
mod scene_file;
mod texture;
mod video;

pub use atomic::{check_writable, write_atomically};
pub use bare::bare_scene;
pub use exr::{Precision, decode_exr, encode_exr, read_exr};
pub use model::read_model;
pub use picture::{WriteOptions, check_image_path, write_image};
pub use png::{encode_png, screen_bytes};
pub use rays::{HitRecord, RayReader, write_blocked, write_hit_header, write_hits};
pub use resolve::{OpenMeshOperands, ReadOptions, read_scene};
pub use texture::read_bitmap;
pub use video::{Video, VideoSettings};

use std::path::Path;

use crate::error::{Error, Result};

/// A whole file's bytes; devices and pipes, which may never end, are refused.
fn read_file(path: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::metadata(path).and_then(|meta| {
        if meta.is_file() {
            std::fs::read(path)
        } else {
            Err(std::io::Error::other("it is not a regular file"))
        }
    });
    bytes.map_err(|e| Error::read(path, &e))
}

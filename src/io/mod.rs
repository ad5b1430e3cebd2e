//! Files in and out: scenes, models, textures, images. Nothing else in the crate knows a file format.

mod atomic;
mod exr;
mod picture;
mod png;
mod rays;

pub use atomic::{check_writable, write_atomically};
pub use exr::{Precision, decode_exr, encode_exr, read_exr};
pub use picture::{WriteOptions, check_image_path, write_image};
pub use png::encode_png;
pub use rays::{HitRecord, RayReader, write_blocked, write_hit_header, write_hits};

//! Textures are the functions that they are said to be, and bend normals as geometry would.

mod bitmap;
mod emission;
mod noise;
mod normal_map;
mod pattern;
mod relief;
mod scene;

use glam::{DVec3, Vec2};
use solidtrace::texture::TexturePoint;

/// A point of space for textures that ask for nothing else.
fn at(p: impl Into<DVec3>) -> TexturePoint {
    TexturePoint {
        p: p.into(),
        n: DVec3::Z,
        uv: Vec2::ZERO,
    }
}

fn at_uv(u: f32, v: f32) -> TexturePoint {
    TexturePoint {
        uv: Vec2::new(u, v),
        ..at(DVec3::ZERO)
    }
}

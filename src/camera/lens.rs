use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2};

use crate::error::{Error, Result};
use crate::math::Ray;
use crate::sampling::uniform_disk;

use super::{Camera, Projection};

/// A camera's basis for one image size: makes rays.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Middle of the picture, in pixels.
    middle: (f64, f64),
    /// What a pixel is across and down, in the projection's units.
    pixel: (f64, f64),
    /// Distance of the plane in focus.
    focus: f64,
    projection: Projection,
}

impl Lens {
    pub(super) fn new(camera: &Camera, size: (u32, u32)) -> Result<Self> {
        let axis = camera.look_at - camera.eye;
        let forward = axis.try_normalize().ok_or_else(|| {
            Error::input(format!(
                "the camera's eye and look_at are the same point {}",
                camera.eye
            ))
        })?;
        let right = forward.cross(camera.up).try_normalize().ok_or_else(|| {
            Error::input(format!("the camera's up {} lies along its view", camera.up))
        })?;
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let square = |side: f64| (side / height, side / height);
        let mut lens = Self {
            eye: camera.eye,
            right,
            up: right.cross(forward),
            forward,
            middle: (0.5 * width, 0.5 * height),
            pixel: match camera.projection {
                Projection::Perspective { vfov, .. } => square(2.0 * (0.5 * vfov).tan()),
                Projection::Orthographic { height } => square(height),
                Projection::Panorama => (TAU / width, PI / height),
            },
            focus: match camera.projection {
                Projection::Perspective { focus, .. } => focus,
                _ => None,
            }
            .unwrap_or(axis.length()),
            projection: camera.projection,
        };
        if camera.projection == Projection::Panorama {
            lens.up = camera.up.normalize();
            lens.forward = lens.up.cross(right);
        }
        Ok(lens)
    }

    /// The ray through film point `(x, y)` in pixels from the top left, and lens sample `u2`.
    pub fn ray(&self, x: f64, y: f64, u2: Vec2) -> Ray {
        // To the right and up.
        let x = (x - self.middle.0) * self.pixel.0;
        let y = (self.middle.1 - y) * self.pixel.1;
        match self.projection {
            Projection::Perspective { aperture, .. } => {
                let direction = self.forward + x * self.right + y * self.up;
                if aperture == 0.0 {
                    return Ray::new(self.eye, direction.normalize());
                }
                let on_lens = aperture * uniform_disk(u2).as_dvec2();
                let offset = on_lens.x * self.right + on_lens.y * self.up;
                let to_focus = self.focus * direction - offset;
                Ray::new(self.eye + offset, to_focus.normalize())
            }
            Projection::Orthographic { .. } => {
                Ray::new(self.eye + x * self.right + y * self.up, self.forward)
            }
            Projection::Panorama => {
                let (to_right, ahead) = x.sin_cos();
                // Above the zenith, where the filter reaches, `level` is negative: the far side, as it should be.
                let (rise, level) = y.sin_cos();
                let along = ahead * self.forward + to_right * self.right;
                Ray::new(self.eye, level * along + rise * self.up)
            }
        }
    }
}

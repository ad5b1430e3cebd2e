//! Rays from points on the film.

use glam::{DVec3, Vec2};

use crate::error::{Error, Result};
use crate::math::Ray;
use crate::sampling::uniform_disk;

/// A perspective camera with an optional thin lens.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Its name in the scene or model file, if any.
    pub name: Option<String>,
    /// Centre of the lens.
    pub eye: DVec3,
    /// A point on the optical axis.
    pub look_at: DVec3,
    /// Which way is up in the picture.
    pub up: DVec3,
    /// Vertical field of view, radians, in (0, pi).
    pub vfov: f64,
    /// Radius of the lens; 0 is a pinhole.
    pub aperture: f64,
    /// Distance of the plane in focus along the axis; the distance of `look_at` where none is given.
    pub focus: Option<f64>,
}

/// The camera's basis for one image size: makes rays.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    half_height: f64,
    size: (f64, f64),
    aperture: f64,
    focus: f64,
}

impl Camera {
    /// Prepares rays for an image of `size` pixels.
    ///
    /// # Errors
    /// Where eye and target coincide, or `up` lies along the view.
    pub fn lens(&self, size: (u32, u32)) -> Result<Lens> {
        let axis = self.look_at - self.eye;
        let forward = (axis.try_normalize()).ok_or_else(|| {
            Error::input(format!(
                "the camera's eye and look_at are the same point {}",
                self.eye
            ))
        })?;
        let right = forward.cross(self.up).try_normalize().ok_or_else(|| {
            Error::input(format!("the camera's up {} lies along its view", self.up))
        })?;
        Ok(Lens {
            eye: self.eye,
            right,
            up: right.cross(forward),
            forward,
            half_height: (0.5 * self.vfov).tan(),
            size: (f64::from(size.0), f64::from(size.1)),
            aperture: self.aperture,
            focus: self.focus.unwrap_or(axis.length()),
        })
    }
}

impl Lens {
    /// The ray through film point `(x, y)` in pixels from the top left, and lens sample `u2`.
    pub fn ray(&self, x: f64, y: f64, u2: Vec2) -> Ray {
        let scale = 2.0 * self.half_height / self.size.1;
        let direction = self.forward
            + (x - 0.5 * self.size.0) * scale * self.right
            + (0.5 * self.size.1 - y) * scale * self.up;
        if self.aperture == 0.0 {
            return Ray::new(self.eye, direction.normalize());
        }
        let on_lens = self.aperture * uniform_disk(u2).as_dvec2();
        let offset = on_lens.x * self.right + on_lens.y * self.up;
        Ray::new(
            self.eye + offset,
            (self.focus * direction - offset).normalize(),
        )
    }
}

//! Rays from points on the film, and how what sends them moves.

mod lens;
mod motion;

pub use lens::Lens;
pub use motion::{Interpolation, Key, Motion};

use glam::{DQuat, DVec3};

use crate::error::Result;

/// Where a picture is taken from, and how space is laid onto it.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Its name in the scene or model file, if any.
    pub name: Option<String>,
    /// Centre of the lens, of an orthographic picture, or of a panorama.
    pub eye: DVec3,
    /// A point on the optical axis.
    pub look_at: DVec3,
    /// Which way is up in the picture.
    pub up: DVec3,
    /// Which ray belongs to a point of the film.
    pub projection: Projection,
    /// What the camera does in a film.
    pub motion: Option<Motion>,
}

/// Which ray belongs to a point of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays through one point, or through a thin lens. What is at distance `d` along the axis is spread over a disk of
    /// radius `aperture * |1 - d / focus|` there: the circle of confusion.
    Perspective {
        /// Vertical field of view, radians, in (0, pi).
        vfov: f64,
        /// Radius of the lens; 0 is a pinhole.
        aperture: f64,
        /// Distance of the plane in focus along the axis; the distance of `look_at` where none is given.
        focus: Option<f64>,
    },
    /// Parallel rays that start on the plane through the eye.
    Orthographic {
        /// What the picture covers from its lower to its upper edge, above 0.
        height: f64,
    },
    /// All directions around the eye, equirectangular: longitude runs from left to right, with the heading of `look_at`
    /// in the middle and what lies to its right in the right half; latitude runs from the zenith, which is
    /// `up` whatever `look_at` is, at the top to the nadir at the bottom.
    Panorama,
}

impl Projection {
    /// A pinhole with this vertical field of view, radians, in (0, pi).
    pub fn pinhole(vfov: f64) -> Self {
        Self::Perspective {
            vfov,
            aperture: 0.0,
            focus: None,
        }
    }

    /// How much the picture takes in from its lower to its upper edge: an angle, a length, or what cannot be chosen.
    pub fn field(&self) -> Option<f64> {
        match *self {
            Self::Perspective { vfov, .. } => Some(vfov),
            Self::Orthographic { height } => Some(height),
            Self::Panorama => None,
        }
    }

    /// The same with another [`Projection::field`], where that can be chosen.
    #[must_use]
    pub fn with_field(self, field: f64) -> Self {
        match self {
            Self::Perspective {
                aperture, focus, ..
            } => Self::Perspective {
                vfov: field,
                aperture,
                focus,
            },
            Self::Orthographic { .. } => Self::Orthographic { height: field },
            Self::Panorama => Self::Panorama,
        }
    }
}

impl Camera {
    /// Prepares rays for an image of `size` pixels.
    ///
    /// # Errors
    /// Where eye and target coincide, or `up` lies along the view.
    pub fn lens(&self, size: (u32, u32)) -> Result<Lens> {
        Lens::new(self, size)
    }

    /// The camera as it stands at a frame of its motion; itself if it has none.
    #[must_use]
    pub fn at(&self, frame: f64) -> Self {
        let key = self.motion.as_ref().and_then(|motion| motion.at(frame));
        let Some(key) = key else {
            return self.clone();
        };
        Self {
            name: self.name.clone(),
            eye: key.eye,
            look_at: key.look_at,
            up: key.up,
            projection: self.projection.with_field(key.field),
            motion: None,
        }
    }

    /// The camera carried around `look_at` about the axis `up`, `angle` radians counterclockwise as seen from above:
    /// what it looks at seems to turn clockwise.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Self {
        let turn = DQuat::from_axis_angle(self.up.normalize_or(DVec3::Y), angle);
        Self {
            eye: self.look_at + turn * (self.eye - self.look_at),
            motion: None,
            ..self.clone()
        }
    }
}

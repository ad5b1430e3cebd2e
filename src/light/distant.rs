use std::f32::consts::PI;

use glam::{DVec3, Vec2};

use crate::color::Rgb;
use crate::math::Frame;
use crate::sampling::{uniform_cone, uniform_cone_pdf};

use super::{LightSample, Source};

/// A disk of even radiance, infinitely far away, such as the sun; of no extent where its angle is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistantLight {
    /// Unit vector towards it.
    pub direction: DVec3,
    /// What it sheds on a surface that faces it, W/m² per channel.
    pub irradiance: Rgb,
    /// The angle across it, radians, from 0 to pi.
    pub angle: f64,
}

impl DistantLight {
    /// The angle across the sun as seen from the earth.
    pub const SUN_DEGREES: f64 = 0.53;

    /// Uniform over the cone in which the disk is seen.
    pub(super) fn sample(&self, u2: Vec2) -> LightSample {
        let one_minus_cos = self.one_minus_cos();
        if one_minus_cos == 0.0 {
            return LightSample {
                source: Source::Direction(self.direction),
                li: self.irradiance,
                pdf: f32::INFINITY,
                face: 0,
            };
        }
        let frame = Frame::around(self.direction.as_vec3().normalize());
        let wi = frame.to_world(uniform_cone(u2, one_minus_cos));
        LightSample {
            source: Source::Direction(wi.as_dvec3().normalize()),
            li: self.radiance(),
            pdf: uniform_cone_pdf(one_minus_cos),
            face: 0,
        }
    }

    /// Its radiance from the unit direction `wi`, and the density with which [`Self::sample`] draws that; `None` beside
    /// the disk.
    pub(super) fn beyond(&self, wi: DVec3) -> Option<(Rgb, f32)> {
        let one_minus_cos = self.one_minus_cos();
        let off_axis = 0.5 * wi.distance_squared(self.direction);
        (off_axis < f64::from(one_minus_cos))
            .then(|| (self.radiance(), uniform_cone_pdf(one_minus_cos)))
    }

    /// The cosine over the disk is pi sin² of half its angle.
    fn radiance(&self) -> Rgb {
        let one_minus_cos = self.one_minus_cos();
        self.irradiance / (PI * one_minus_cos * (2.0 - one_minus_cos))
    }

    /// Of half the angle.
    fn one_minus_cos(&self) -> f32 {
        (2.0 * (0.25 * self.angle).sin().powi(2)) as f32
    }

    pub(super) fn power(&self) -> f64 {
        f64::from(self.irradiance.element_sum())
    }
}

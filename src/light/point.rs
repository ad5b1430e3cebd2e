use std::f64::consts::PI;

use glam::DVec3;

use crate::color::Rgb;

use super::{LightSample, Source};

/// A light without extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Where.
    pub position: DVec3,
    /// Radiant intensity, W/sr per channel, the same in all directions.
    pub intensity: Rgb,
}

impl PointLight {
    pub(super) fn sample(&self, from: DVec3) -> Option<LightSample> {
        let d2 = self.position.distance_squared(from);
        (d2 > 0.0).then(|| LightSample {
            source: Source::Point(self.position),
            li: self.intensity / d2 as f32,
            pdf: f32::INFINITY,
        })
    }

    pub(super) fn power(&self) -> f64 {
        4.0 * PI * f64::from(self.intensity.element_sum())
    }
}

use std::f64::consts::TAU;

use glam::DVec3;

use crate::color::Rgb;

use super::{LightSample, Source};

/// A light without extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Where.
    pub position: DVec3,
    /// Radiant intensity, W/sr per channel: in all directions, or along the axis of the cone.
    pub intensity: Rgb,
    /// What a spot light is confined to.
    pub cone: Option<Cone>,
}

/// How the intensity of a spot light falls off: what `KHR_lights_punctual` of glTF recommends, the square of a line in
/// the cosine, from 1 at the inner angle to 0 at the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Where it shines, of unit length.
    pub axis: DVec3,
    /// Cosine of the angle from the axis within which it shines in full; at least `cos_outer`.
    pub cos_inner: f64,
    /// Cosine of the angle from the axis at which its light ends.
    pub cos_outer: f64,
}

impl Cone {
    /// From its angles in radians.
    pub fn new(axis: DVec3, inner: f64, outer: f64) -> Self {
        Self {
            axis,
            cos_inner: inner.cos(),
            cos_outer: outer.cos(),
        }
    }

    /// What is left of the intensity in the unit direction `w`.
    fn falloff(&self, w: DVec3) -> f64 {
        let cos = self.axis.dot(w);
        if cos >= self.cos_inner {
            1.0
        } else if cos <= self.cos_outer {
            0.0
        } else {
            ((cos - self.cos_outer) / (self.cos_inner - self.cos_outer)).powi(2)
        }
    }

    /// The integral of the falloff over all directions.
    fn solid_angle(&self) -> f64 {
        TAU * (1.0 - self.cos_inner + (self.cos_inner - self.cos_outer) / 3.0)
    }
}

impl PointLight {
    pub(super) fn sample(&self, from: DVec3) -> Option<LightSample> {
        let to = from - self.position;
        let d2 = to.length_squared();
        let falloff = self.cone.map_or(1.0, |cone| cone.falloff(to / d2.sqrt()));
        (d2 > 0.0 && falloff > 0.0).then(|| LightSample {
            source: Source::Point(self.position),
            li: self.intensity * (falloff / d2) as f32,
            pdf: f32::INFINITY,
            face: 0,
        })
    }

    pub(super) fn power(&self) -> f64 {
        let solid_angle = self.cone.map_or(2.0 * TAU, |cone| cone.solid_angle());
        solid_angle * f64::from(self.intensity.element_sum())
    }
}

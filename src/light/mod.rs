//! Light sources that paths can aim at: points, spheres and triangles.
//!
//! The constant environment is not among them: drawing directions from the BSDF samples it perfectly
//! on diffuse and specular surfaces alike.

mod point;
mod sampler;
mod sphere;
mod triangle;

pub use sampler::LightSampler;

use glam::{DVec3, Vec2};

use crate::color::Rgb;

pub use point::PointLight;
pub use sphere::SphereLight;
pub use triangle::TriangleLight;

/// A source of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// A point.
    Point(PointLight),
    /// A sphere whose surface emits.
    Sphere(SphereLight),
    /// A triangle that emits from both sides.
    Triangle(TriangleLight),
}

/// A point on a light as seen from a shading point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// The point, just in front of the light's surface.
    pub p: DVec3,
    /// Incoming radiance; for a point light its intensity over the squared distance.
    pub li: Rgb,
    /// Density per solid angle; infinite for a point light, whose weight is 1.
    pub pdf: f32,
}

impl LightSample {
    /// What the sample's weight divides by: the density, or 1 for a point.
    pub fn divisor(&self) -> f32 {
        if self.pdf.is_finite() { self.pdf } else { 1.0 }
    }
}

impl Light {
    /// Draws a point of the light as seen from `from`; `None` where it sheds no light there.
    pub fn sample(&self, from: DVec3, u2: Vec2) -> Option<LightSample> {
        match self {
            Self::Point(point) => point.sample(from),
            Self::Sphere(sphere) => sphere.sample(from, u2),
            Self::Triangle(triangle) => triangle.sample(from, u2),
        }
    }

    /// Density per solid angle at `from` with which [`Self::sample`] draws the light's point `p`.
    pub fn pdf(&self, from: DVec3, p: DVec3) -> f32 {
        match self {
            Self::Point(_) => 0.0,
            Self::Sphere(sphere) => sphere.pdf(from),
            Self::Triangle(triangle) => triangle.pdf(from, p),
        }
    }

    /// Emitted power in W, summed over channels, up to a common factor.
    fn power(&self) -> f64 {
        match self {
            Self::Point(point) => point.power(),
            Self::Sphere(sphere) => sphere.power(),
            Self::Triangle(triangle) => triangle.power(),
        }
    }
}

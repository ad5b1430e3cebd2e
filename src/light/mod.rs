//! Light sources that paths can aim at: points and spots, and surfaces: spheres, triangles, rectangles, boxes and what is
//! round. What has an extent emits from both sides.
//!
//! The constant environment is not among them: drawing directions from the BSDF samples it perfectly
//! on diffuse and specular surfaces alike.

mod cuboid;
mod flat;
mod patch;
mod point;
mod quad;
mod round;
mod sampler;
mod sphere;
mod triangle;

pub use sampler::LightSampler;

use glam::{DVec3, Vec2};

use crate::color::Rgb;

pub use cuboid::BoxLight;
pub use point::{Cone, PointLight};
pub use quad::{Quad, QuadLight};
pub use round::RoundLight;
pub use sphere::SphereLight;
pub use triangle::TriangleLight;

/// A source of light.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// A point.
    Point(PointLight),
    /// A sphere whose surface emits.
    Sphere(SphereLight),
    /// A triangle.
    Triangle(TriangleLight),
    /// A rectangle or another parallelogram.
    Quad(QuadLight),
    /// A box.
    Box(Box<BoxLight>),
    /// Other solids, and disks.
    Round(Box<RoundLight>),
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
    /// The face of a solid that the point is on; else 0.
    pub face: u32,
}

impl LightSample {
    /// A point of a surface; `None` where its density is 0 or beyond numbers.
    fn of_surface(p: DVec3, li: Rgb, pdf: f64, face: u32) -> Option<Self> {
        let pdf = pdf as f32;
        (pdf > 0.0 && pdf.is_finite()).then_some(Self { p, li, pdf, face })
    }

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
            Self::Quad(quad) => quad.sample(from, u2),
            Self::Box(cuboid) => cuboid.sample(from, u2),
            Self::Round(round) => round.sample(from, u2),
        }
    }

    /// Density per solid angle at `from` with which [`Self::sample`] draws the light's point `p`, on `face` of a solid.
    pub fn pdf(&self, from: DVec3, p: DVec3, face: u32) -> f32 {
        let pdf = match self {
            Self::Point(_) => 0.0,
            Self::Sphere(sphere) => sphere.pdf(from),
            Self::Triangle(triangle) => triangle.pdf(from, p),
            Self::Quad(quad) => quad.pdf(from, p),
            Self::Box(cuboid) => cuboid.pdf(from, p, face),
            Self::Round(round) => round.pdf(from, p, face),
        };
        let pdf = pdf as f32;
        // As sampling refuses it.
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// A point of the surface, and its face where it is a solid's: uniform in area, as object space has it under a
    /// transform that stretches.
    pub fn point(&self, u2: Vec2) -> (DVec3, u32) {
        match self {
            Self::Point(point) => (point.position, 0),
            Self::Sphere(sphere) => (sphere.point(u2), 0),
            Self::Triangle(triangle) => (triangle.point(u2), 0),
            Self::Quad(quad) => (quad.point(u2), 0),
            Self::Box(cuboid) => cuboid.point(u2),
            Self::Round(round) => round.point(u2),
        }
    }

    /// Intensity or radiance; of a textured surface its mean.
    pub(crate) fn strength_mut(&mut self) -> &mut Rgb {
        match self {
            Self::Point(point) => &mut point.intensity,
            Self::Sphere(sphere) => &mut sphere.radiance,
            Self::Triangle(triangle) => &mut triangle.radiance,
            Self::Quad(quad) => &mut quad.radiance,
            Self::Box(cuboid) => &mut cuboid.radiance,
            Self::Round(round) => &mut round.radiance,
        }
    }

    /// Emitted power in W, summed over channels.
    pub fn power(&self) -> f64 {
        match self {
            Self::Point(point) => point.power(),
            Self::Sphere(sphere) => sphere.power(),
            Self::Triangle(triangle) => triangle.power(),
            Self::Quad(quad) => quad.power(),
            Self::Box(cuboid) => cuboid.power(),
            Self::Round(round) => round.power(),
        }
    }
}

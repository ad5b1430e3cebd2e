//! Light sources that paths can aim at: points and spots; surfaces: spheres, triangles, rectangles, boxes and what is
//! round; and what is infinitely far away: disks and pictures. Surfaces emit from both sides.
//!
//! The constant environment is not among them: drawing directions from the BSDF samples it perfectly
//! on diffuse and specular surfaces alike.

mod cuboid;
mod distant;
mod environment;
mod flat;
mod patch;
mod point;
mod quad;
mod round;
mod sampler;
mod sky;
mod sphere;
mod triangle;

pub use sampler::LightSampler;

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use crate::color::Rgb;

pub use cuboid::BoxLight;
pub use distant::DistantLight;
pub use environment::EnvironmentMap;
pub use point::{Cone, PointLight};
pub use quad::{Quad, QuadLight};
pub use round::RoundLight;
pub use sky::Sky;
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
    /// A disk infinitely far away.
    Distant(DistantLight),
    /// A picture infinitely far away, all around.
    Environment(Arc<EnvironmentMap>),
}

/// Where a sample's light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A point, just in front of the light's surface.
    Point(DVec3),
    /// A unit direction, from infinitely far away.
    Direction(DVec3),
}

impl Source {
    /// Unit direction and distance from `p`; `None` where the light is right there.
    pub fn seen_from(self, p: DVec3) -> Option<(Vec3, f64)> {
        match self {
            Self::Point(q) => Some(((q - p).as_vec3().try_normalize()?, q.distance(p))),
            Self::Direction(wi) => Some((wi.as_vec3(), f64::INFINITY)),
        }
    }
}

/// A point on a light as seen from a shading point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Where it is.
    pub source: Source,
    /// Incoming radiance; for a point light its intensity over the squared distance, for a distant one without extent
    /// its irradiance.
    pub li: Rgb,
    /// Density per solid angle; infinite for a light without extent, whose weight is 1.
    pub pdf: f32,
    /// The face of a solid that the point is on; else 0.
    pub face: u32,
}

impl LightSample {
    /// A point of a surface; `None` where its density is 0 or beyond numbers.
    fn of_surface(p: DVec3, li: Rgb, pdf: f64, face: u32) -> Option<Self> {
        let pdf = pdf as f32;
        (pdf > 0.0 && pdf.is_finite()).then_some(Self {
            source: Source::Point(p),
            li,
            pdf,
            face,
        })
    }

    /// What the sample's weight divides by: the density, or 1 for a light without extent.
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
            Self::Distant(distant) => Some(distant.sample(u2)),
            Self::Environment(map) => map.sample(u2),
        }
    }

    /// Density per solid angle at `from` with which [`Self::sample`] draws the light's point `p`, on `face` of a solid; of
    /// lights at infinity [`Self::beyond`] says it.
    pub fn pdf(&self, from: DVec3, p: DVec3, face: u32) -> f32 {
        let pdf = match self {
            Self::Point(_) | Self::Distant(_) | Self::Environment(_) => 0.0,
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

    /// A point of a surface, and its face where it is a solid's: uniform in area, as object space has it under a
    /// transform that stretches. `None` of what is no surface.
    pub fn point(&self, u2: Vec2) -> Option<(DVec3, u32)> {
        match self {
            Self::Sphere(sphere) => Some((sphere.point(u2), 0)),
            Self::Triangle(triangle) => Some((triangle.point(u2), 0)),
            Self::Quad(quad) => Some((quad.point(u2), 0)),
            Self::Box(cuboid) => Some(cuboid.point(u2)),
            Self::Round(round) => Some(round.point(u2)),
            Self::Point(_) | Self::Distant(_) | Self::Environment(_) => None,
        }
    }

    /// What a ray sees of a light at infinity that leaves the scene in the unit direction `wi`: its radiance, and the
    /// density per solid angle with which [`Self::sample`] draws `wi`.
    fn beyond(&self, wi: DVec3) -> Option<(Rgb, f32)> {
        match self {
            Self::Distant(distant) => distant.beyond(wi),
            Self::Environment(map) => Some(map.beyond(wi)),
            _ => None,
        }
    }

    /// Whether it is infinitely far away.
    fn is_infinite(&self) -> bool {
        matches!(self, Self::Distant(_) | Self::Environment(_))
    }

    /// The radiance of a surface, which of a textured one is its mean; `None` of what is none.
    pub(crate) fn radiance_mut(&mut self) -> Option<&mut Rgb> {
        match self {
            Self::Sphere(sphere) => Some(&mut sphere.radiance),
            Self::Triangle(triangle) => Some(&mut triangle.radiance),
            Self::Quad(quad) => Some(&mut quad.radiance),
            Self::Box(cuboid) => Some(&mut cuboid.radiance),
            Self::Round(round) => Some(&mut round.radiance),
            Self::Point(_) | Self::Distant(_) | Self::Environment(_) => None,
        }
    }

    /// Emitted power in W, summed over channels; of lights at infinity what light sampling aims at
    /// of their radiance over all directions.
    pub fn power(&self) -> f64 {
        match self {
            Self::Point(point) => point.power(),
            Self::Sphere(sphere) => sphere.power(),
            Self::Triangle(triangle) => triangle.power(),
            Self::Quad(quad) => quad.power(),
            Self::Box(cuboid) => cuboid.power(),
            Self::Round(round) => round.power(),
            Self::Distant(distant) => distant.power(),
            Self::Environment(map) => map.power(),
        }
    }
}

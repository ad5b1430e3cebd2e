//! Light sources that paths can aim at: points and spots; surfaces, which emit from both sides; and what is infinitely
//! far away: disks and pictures.
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
mod surface;
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
pub use surface::SurfaceLight;
pub use triangle::TriangleLight;

/// A source of light.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// A point, or a spot.
    Point(PointLight),
    /// A surface.
    Surface(SurfaceLight),
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
    #[inline(always)]
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
    /// The face of a solid that it is on; else 0.
    pub face: u32,
}

impl LightSample {
    /// What the sample's weight divides by: the density, or 1 for a light without extent.
    pub fn divisor(&self) -> f32 {
        if self.pdf.is_finite() { self.pdf } else { 1.0 }
    }
}

impl Light {
    /// Draws a point of the light as seen from `from`; `None` where it sheds no light there.
    #[inline(always)]
    pub fn sample(&self, from: DVec3, u2: Vec2) -> Option<LightSample> {
        match self {
            Self::Point(point) => point.sample(from),
            Self::Surface(surface) => surface.sample(from, u2),
            Self::Distant(distant) => Some(distant.sample(u2)),
            Self::Environment(map) => map.sample(u2),
        }
    }

    /// Density per solid angle at `from` with which [`Self::sample`] draws the light's point `p`, on `face` of a solid; of
    /// lights at infinity [`Self::beyond`] says it.
    pub fn pdf(&self, from: DVec3, p: DVec3, face: u32) -> f32 {
        match self {
            Self::Point(_) | Self::Distant(_) | Self::Environment(_) => 0.0,
            Self::Surface(surface) => surface.pdf(from, p, face),
        }
    }

    /// What a ray sees of a light at infinity that leaves the scene in the unit direction `wi`: its radiance, and the
    /// density per solid angle with which [`Self::sample`] draws `wi`.
    fn beyond(&self, wi: DVec3) -> Option<(Rgb, f32)> {
        match self {
            Self::Distant(distant) => distant.beyond(wi),
            Self::Environment(map) => Some(map.beyond(wi)),
            Self::Point(_) | Self::Surface(_) => None,
        }
    }

    /// Whether it is infinitely far away.
    fn is_infinite(&self) -> bool {
        matches!(self, Self::Distant(_) | Self::Environment(_))
    }

    /// Emitted power in W, summed over channels; of lights at infinity what light sampling aims at
    /// of their radiance over all directions.
    pub fn power(&self) -> f64 {
        match self {
            Self::Point(point) => point.power(),
            Self::Surface(surface) => surface.power(),
            Self::Distant(distant) => distant.power(),
            Self::Environment(map) => map.power(),
        }
    }
}

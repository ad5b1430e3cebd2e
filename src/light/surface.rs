use glam::{DVec3, Vec2};

use crate::color::Rgb;

use super::{BoxLight, LightSample, QuadLight, RoundLight, Source, SphereLight, TriangleLight};

/// A surface that emits from both sides.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceLight {
    /// A sphere.
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

/// A point of a surface as seen from a shading point.
pub(super) struct SurfaceSample {
    /// The point, just in front of the surface.
    pub(super) p: DVec3,
    /// The face of a solid that it is on; else 0.
    pub(super) face: u32,
    /// Density per solid angle.
    pub(super) pdf: f64,
}

impl SurfaceLight {
    #[inline(always)]
    pub(super) fn sample(&self, from: DVec3, u2: Vec2) -> Option<LightSample> {
        let (sample, li) = match self {
            Self::Sphere(sphere) => (sphere.sample(from, u2)?, sphere.radiance),
            Self::Triangle(triangle) => (triangle.sample(from, u2)?, triangle.radiance),
            Self::Quad(quad) => (quad.sample(from, u2)?, quad.radiance),
            Self::Box(cuboid) => (cuboid.sample(from, u2)?, cuboid.radiance),
            Self::Round(round) => (round.sample(from, u2)?, round.radiance),
        };
        let pdf = sample.pdf as f32;
        is_usable(pdf).then_some(LightSample {
            source: Source::Point(sample.p),
            li,
            pdf,
            face: sample.face,
        })
    }

    pub(super) fn pdf(&self, from: DVec3, p: DVec3, face: u32) -> f32 {
        let pdf = match self {
            Self::Sphere(sphere) => sphere.pdf(from),
            Self::Triangle(triangle) => triangle.pdf(from, p),
            Self::Quad(quad) => quad.pdf(from, p),
            Self::Box(cuboid) => cuboid.pdf(from, p, face),
            Self::Round(round) => round.pdf(from, p, face),
        } as f32;
        if is_usable(pdf) { pdf } else { 0.0 }
    }

    /// A point, and its face where it is a solid's: uniform in area, as object space has it under a transform that
    /// stretches.
    pub fn point(&self, u2: Vec2) -> (DVec3, u32) {
        match self {
            Self::Sphere(sphere) => (sphere.point(u2), 0),
            Self::Triangle(triangle) => (triangle.point(u2), 0),
            Self::Quad(quad) => (quad.point(u2), 0),
            Self::Box(cuboid) => cuboid.point(u2),
            Self::Round(round) => round.point(u2),
        }
    }

    /// What it emits, W/(m² sr); of a textured surface the mean.
    pub fn radiance_mut(&mut self) -> &mut Rgb {
        match self {
            Self::Sphere(sphere) => &mut sphere.radiance,
            Self::Triangle(triangle) => &mut triangle.radiance,
            Self::Quad(quad) => &mut quad.radiance,
            Self::Box(cuboid) => &mut cuboid.radiance,
            Self::Round(round) => &mut round.radiance,
        }
    }

    pub(super) fn power(&self) -> f64 {
        let (area, radiance) = match self {
            Self::Sphere(sphere) => (sphere.area(), sphere.radiance),
            Self::Triangle(triangle) => (triangle.area(), triangle.radiance),
            Self::Quad(quad) => (quad.area(), quad.radiance),
            Self::Box(cuboid) => (cuboid.area(), cuboid.radiance),
            Self::Round(round) => (round.area(), round.radiance),
        };
        std::f64::consts::PI * area * f64::from(radiance.element_sum())
    }
}

/// Whether a sample of this density counts: one at the edge of what is seen may have none or a boundless one.
fn is_usable(pdf: f32) -> bool {
    pdf > 0.0 && pdf.is_finite()
}

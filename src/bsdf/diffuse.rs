//! Lambert's law: `f = albedo / pi`.

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};

use super::BsdfSample;

#[derive(Clone, Copy, Debug)]
pub(super) struct Diffuse {
    pub(super) albedo: Rgb,
}

impl Diffuse {
    /// A direction in proportion to the cosine, so that `f cos / pdf` is the albedo.
    #[inline(always)]
    pub(super) fn sample(&self, u2: Vec2) -> BsdfSample {
        let wi = cosine_hemisphere(u2);
        BsdfSample::new(wi, self.albedo, cosine_hemisphere_pdf(wi.z))
    }

    #[inline(always)]
    pub(super) fn eval(&self, wi: Vec3) -> (Rgb, f32) {
        let pdf = cosine_hemisphere_pdf(wi.z);
        (self.albedo * pdf, pdf)
    }
}

//! Lambert's law: `f = albedo / pi`.

use glam::{Vec2, Vec3};

use crate::sampling::{cosine_hemisphere, cosine_hemisphere_pdf};

/// A direction in proportion to the cosine, so that `f cos / pdf` is the albedo.
pub(super) fn sample(u2: Vec2) -> Vec3 {
    cosine_hemisphere(u2)
}

/// Density of [`sample`]; also `f cos` for an albedo of 1.
pub(super) fn pdf(wi: Vec3) -> f32 {
    cosine_hemisphere_pdf(wi.z)
}

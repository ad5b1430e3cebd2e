//! Two surfaces at once.

use glam::{Vec2, Vec3};

use crate::color::Rgb;

use super::BsdfSample;
use super::lobe::Lobe;

#[derive(Clone, Debug)]
pub(super) struct Mix {
    pub(super) a: Lobe,
    pub(super) b: Lobe,
    /// Share of `b`.
    pub(super) weight: f32,
}

impl Mix {
    pub(super) fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        let p = self.weight;
        let drawn = if u < p {
            self.b.sample(wo, u / p, u2)
        } else {
            self.a.sample(wo, (u - p) / (1.0 - p), u2)
        }?;
        if drawn.pdf.is_infinite() {
            return Some(drawn);
        }
        let mixed = BsdfSample::of(drawn.wi, self.eval(wo, drawn.wi))?;
        let eta2 = drawn.eta2;
        Some(BsdfSample { eta2, ..mixed })
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let (a, pdf_a) = self.a.eval(wo, wi);
        let (b, pdf_b) = self.b.eval(wo, wi);
        let p = self.weight;
        ((1.0 - p) * a + p * b, (1.0 - p) * pdf_a + p * pdf_b)
    }
}

//! A thin clear sheet: light is reflected to and fro between its two faces and leaves along its way in or mirrored.

use glam::Vec3;

use crate::color::Rgb;
use crate::material::Fresnel;

use super::BsdfSample;
use super::fresnel::dielectric;
use super::mirror::reflect;

#[derive(Clone, Copy, Debug)]
pub(super) struct Thin {
    pub(super) ior: f32,
}

impl Thin {
    pub(super) fn sample(self, wo: Vec3, u: f32) -> BsdfSample {
        // R + T² R + T² R³ + ... with T = 1 - R.
        let once = dielectric(Fresnel::Exact, wo.z, self.ior);
        let wi = if u < 2.0 * once / (1.0 + once) {
            reflect(wo)
        } else {
            -wo
        };
        BsdfSample::new(wi, Rgb::ONE, f32::INFINITY)
    }
}

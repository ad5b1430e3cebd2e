use glam::{DVec3, Vec2};

use crate::color::Rgb;
use crate::sampling::Discrete;

use super::{Light, LightSample};

/// Chooses among all lights in proportion to their power, in a time that grows with the logarithm of their number. Where
/// some are at infinity and others are not, either kind gets half of the samples: how much of an infinite power arrives
/// is a matter of where the scene ends.
#[derive(Clone, Debug, Default)]
pub struct LightSampler {
    lights: Vec<Light>,
    choice: Discrete,
    /// Which lights are at infinity.
    infinite: Vec<u32>,
}

impl LightSampler {
    /// Over `lights`; the index of a light here is its index there.
    pub fn new(lights: Vec<Light>) -> Self {
        let of_kind = |infinite: bool| -> f64 {
            let kind = lights
                .iter()
                .filter(|light| light.is_infinite() == infinite);
            kind.map(Light::power).sum()
        };
        let (near, far) = (of_kind(false), of_kind(true));
        let balance = if near > 0.0 && far > 0.0 {
            near / far
        } else {
            1.0
        };
        let weight =
            |light: &Light| light.power() * if light.is_infinite() { balance } else { 1.0 };
        let indices = 0..lights.len() as u32;
        Self {
            choice: Discrete::new(lights.iter().map(weight)),
            infinite: (indices.filter(|&i| lights[i as usize].is_infinite())).collect(),
            lights,
        }
    }

    /// All lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The index of one light and a point of it as seen from `from`, its density and weight with the choice included.
    #[inline(always)]
    pub fn sample(&self, from: DVec3, u: f32, u2: Vec2) -> Option<(u32, LightSample)> {
        let (index, probability) = self.choice.sample(u)?;
        let sample = self.lights[index].sample(from, u2)?;
        let sample = if sample.pdf.is_finite() {
            LightSample {
                pdf: sample.pdf * probability,
                ..sample
            }
        } else {
            LightSample {
                li: sample.li / probability,
                ..sample
            }
        };
        Some((index as u32, sample))
    }

    /// What a ray that leaves the scene in the unit direction `wi` sees of each light at infinity: the radiance, and the
    /// density with which [`Self::sample`] draws `wi`.
    pub fn beyond(&self, wi: DVec3) -> impl Iterator<Item = (Rgb, f32)> {
        self.infinite.iter().filter_map(move |&index| {
            let index = index as usize;
            let (radiance, pdf) = self.lights[index].beyond(wi)?;
            Some((radiance, self.choice.probability(index) * pdf))
        })
    }

    /// Density with which [`Self::sample`] draws the point `p` of light `index`, on `face` of a solid.
    pub fn pdf(&self, index: u32, from: DVec3, p: DVec3, face: u32) -> f32 {
        let index = index as usize;
        self.choice.probability(index) * self.lights[index].pdf(from, p, face)
    }
}

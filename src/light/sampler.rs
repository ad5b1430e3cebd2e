use glam::{DVec3, Vec2};

use crate::sampling::Discrete;

use super::{Light, LightSample};

/// Chooses among all lights in proportion to their power, in a time that grows with the logarithm of their number.
#[derive(Clone, Debug, Default)]
pub struct LightSampler {
    lights: Vec<Light>,
    choice: Discrete,
}

impl LightSampler {
    /// Over `lights`; the index of a light here is its index there.
    pub fn new(lights: Vec<Light>) -> Self {
        Self {
            choice: Discrete::new(lights.iter().map(Light::power)),
            lights,
        }
    }

    /// All lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The index of one light and a point of it as seen from `from`, its density and weight with the choice included.
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

    /// Density with which [`Self::sample`] draws the point `p` of light `index`, on `face` of a solid.
    pub fn pdf(&self, index: u32, from: DVec3, p: DVec3, face: u32) -> f32 {
        let index = index as usize;
        self.choice.probability(index) * self.lights[index].pdf(from, p, face)
    }
}

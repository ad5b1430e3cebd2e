use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::sobol;

/// Where canonical samples come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol points (Burley 2020), decorrelated between pixels.
    #[default]
    Sobol,
    /// Independent random numbers.
    Independent,
}

/// The canonical samples of one pixel sample: a pure function of (seed, pixel, sample index, set).
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    pixel_seed: u32,
    index: u32,
}

impl Sampler {
    /// The samples of `pixel`'s sample number `index`.
    pub fn new(kind: SamplerKind, seed: u64, pixel: (u32, u32), index: u32) -> Self {
        let key = mix(seed) ^ (u64::from(pixel.1) << 32 | u64::from(pixel.0));
        Self {
            kind,
            pixel_seed: mix(key) as u32,
            index,
        }
    }

    /// Four numbers in [0, 1), the same whenever they are asked for; each `set` has its own.
    pub fn set(&self, set: u32) -> [f32; 4] {
        let [numbers] = self.sets(set);
        numbers
    }

    /// Those of `N` sets, `first` and the ones after it, in less time than one after the other.
    #[inline]
    pub fn sets<const N: usize>(&self, first: u32) -> [[f32; 4]; N] {
        let sets = std::array::from_fn(|i| first + i as u32);
        match self.kind {
            SamplerKind::Sobol => {
                // Every set is the sequence's first four dimensions, whose projections are its best, in an order
                // and a scramble of its own (Burley 2020, section 5); so is every 65,536 points.
                let seeds = sets.map(|set| {
                    let own = set ^ (self.index & 0xffff_0000);
                    self.pixel_seed ^ own.wrapping_mul(0x9e37_79b9)
                });
                sobol::points(self.index & 0xffff, seeds)
            }
            SamplerKind::Independent => sets.map(|set| {
                let state = mix(u64::from(self.index) << 32 | u64::from(set));
                let mut rng = Pcg32::from_seed(seed_bytes(state, u64::from(self.pixel_seed)));
                std::array::from_fn(|_| rng.random())
            }),
        }
    }
}

fn seed_bytes(state: u64, stream: u64) -> [u8; 16] {
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&state.to_le_bytes());
    bytes[8..].copy_from_slice(&mix(stream).to_le_bytes());
    bytes
}

/// The finaliser of `SplitMix64` (Steele, Lea and Flood 2014): every input bit reaches every output bit.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

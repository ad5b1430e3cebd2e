use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg32;

/// The generator's stream, its authors' own choice (O'Neill 2014).
const STREAM: u64 = 0x0a02_bdbf_7bb3_c0a7;

/// Copies of an object in a grid, each shifted at random.
///
/// Copy (i, j, k) stands at `i step[0] + j step[1] + k step[2] + jitter * u`, each component of u being uniform in
/// (-1, 1). Copies are counted with i fastest and k slowest, and each takes three numbers r, for x, y and z, from
/// PCG-XSH-RR 64/32 (O'Neill 2014, section 6.3.1) with the state `seed` and the stream 0x0a02bdbf7bb3c0a7:
/// u = (r + 1/2) / 2^31 - 1. So they stand at the same places for ever.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeat {
    /// How many along each step, at least one.
    pub count: [u32; 3],
    /// From a copy to its neighbours.
    pub step: [DVec3; 3],
    /// The greatest shift along each axis, to either side.
    pub jitter: DVec3,
    /// Another seed, other shifts.
    pub seed: u64,
}

impl Repeat {
    /// How many copies there are.
    pub fn copies(&self) -> usize {
        let counts = self.count.map(|n| n as usize);
        counts.into_iter().fold(1, usize::saturating_mul)
    }

    /// Each copy's (i, j, k) and where it stands.
    pub fn positions(self) -> impl Iterator<Item = ([u32; 3], DVec3)> {
        let mut generator = Pcg32::new(self.seed, STREAM);
        let mut shift =
            move || (f64::from(generator.next_u32()) + 0.5) / f64::from(1_u32 << 31) - 1.0;
        let [nx, ny, _] = self.count.map(|n| n as usize);
        (0..self.copies()).map(move |n| {
            let index = [n % nx, n / nx % ny, n / nx / ny].map(|i| i as u32);
            let [i, j, k] = index.map(f64::from);
            let [a, b, c] = self.step;
            let shift = DVec3::from_array(std::array::from_fn(|_| shift()));
            (index, i * a + j * b + k * c + self.jitter * shift)
        })
    }
}

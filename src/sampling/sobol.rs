//! Sobol' points of four dimensions, scrambled by hashing (Burley 2020, "Practical Hash-based Owen Scrambling").
//!
//! They are those of the crate `sobol_burley`, to the bit. Here the points of several sets come at once, and table rows
//! take the place of a loop over the index's bits, at the end of which the processor would guess wrong.

/// Direction numbers with their bits reversed, one for each bit of an index (Joe and Kuo 2008): of the van der Corput
/// sequence, then of the primitive polynomials x + 1, x² + x + 1 and x³ + x + 1.
const DIRECTIONS: [[u32; 4]; 16] = {
    let degrees = [0, 1, 2, 3];
    let inner = [0, 0, 1, 1];
    let initial = [[0; 3], [1, 0, 0], [1, 3, 0], [1, 3, 1]];
    let mut directions = [[0; 4]; 16];
    let mut dimension = 0;
    while dimension < 4 {
        let degree = degrees[dimension];
        let mut numbers = [0_u32; 16];
        let mut i = 0;
        while i < 16 {
            numbers[i] = if degree == 0 {
                1
            } else if i < degree {
                initial[dimension][i]
            } else {
                // m_i = m_(i-s) ^ 2^s m_(i-s) ^ 2^k m_(i-k) for the coefficients a_k of the polynomial.
                let mut number = numbers[i - degree] ^ numbers[i - degree] << degree;
                let mut k = 1;
                while k < degree {
                    if inner[dimension] >> (degree - 1 - k) & 1 == 1 {
                        number ^= numbers[i - k] << k;
                    }
                    k += 1;
                }
                number
            };
            directions[i][dimension] = (numbers[i] << (31 - i)).reverse_bits();
            i += 1;
        }
        dimension += 1;
    }
    directions
};

/// For each four bits of an index, the first ones in the highest place, the sum of their directions.
const ROWS: [[[u32; 4]; 16]; 4] = {
    let mut rows = [[[0; 4]; 16]; 4];
    let mut at = 0;
    while at < 4 * 16 * 4 * 4 {
        let (four, value, bit, dimension) = (at / 256, at / 16 % 16, at / 4 % 4, at % 4);
        if value >> (3 - bit) & 1 == 1 {
            rows[four][value][dimension] ^= DIRECTIONS[4 * four + bit][dimension];
        }
        at += 1;
    }
    rows
};

/// What sets dimensions apart.
const LANES: [u32; 4] = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];

/// Point number `index`, below 65,536, of as many sequences as there are `seeds`.
pub(super) fn points<const N: usize>(index: u32, seeds: [u32; N]) -> [[f32; 4]; N] {
    let reversed = index.reverse_bits();
    let shuffled = seeds.map(|seed| scramble(reversed, hash(seed ^ 0x79c6_8e4a)) >> 16);
    let mut points = [[0; 4]; N];
    for (point, shuffled) in points.iter_mut().zip(shuffled) {
        for (four, rows) in ROWS.iter().enumerate() {
            let row = rows[(shuffled >> (12 - 4 * four)) as usize & 15];
            for (x, direction) in point.iter_mut().zip(row) {
                *x ^= direction;
            }
        }
    }
    let mut scrambled = [[0.0; 4]; N];
    for i in 0..N {
        let seed = seeds[i].wrapping_mul(0x9c8f_2d3b);
        for lane in 0..4 {
            let x = scramble(points[i][lane], hash(seed ^ LANES[lane])).reverse_bits();
            scrambled[i][lane] = f32::from_bits(x >> 9 | 0x3f80_0000) - 1.0;
        }
    }
    scrambled
}

/// Nearly Owen's scramble of a number with its bits reversed (Vegdahl 2021, "Building a Better LK Hash").
#[inline(always)]
fn scramble(x: u32, seed: u32) -> u32 {
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed);
    let x = x.wrapping_mul(seed >> 16 | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Wellons 2018, "Prospecting for Hash Functions".
#[inline(always)]
fn hash(x: u32) -> u32 {
    // So that 0 does not stay 0.
    let x = x ^ 0xe6fe_3beb;
    let x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    let x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

#[cfg(test)]
mod tests {
    use super::points;

    /// The crate is older than this and has the directions of all dimensions from their authors' file.
    #[test]
    fn points_are_those_of_the_crate_that_others_keep() {
        for index in 0..1_u32 << 16 {
            let seeds = [index.wrapping_mul(0x9e37_79b9), !index];
            let theirs = seeds.map(|seed| sobol_burley::sample_4d(index, 0, seed));
            assert_eq!(points(index, seeds), theirs, "point {index}");
        }
    }
}

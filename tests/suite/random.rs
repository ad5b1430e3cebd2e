//! Random numbers for tests.

use solidtrace::color::Rgb;

/// A small generator of its own, so that these tests lean on nothing that they test (Steele 2014, `SplitMix64`).
pub(crate) struct SplitMix(pub(crate) u64);

impl SplitMix {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Either sign, magnitudes spread evenly over 2^low .. 2^high, all mantissa bits in use.
    pub(crate) fn float(&mut self, low: i32, high: i32) -> f32 {
        let bits = self.next();
        let exponent = low + (bits >> 40) as i32 % (high - low);
        let mantissa = 1.0 + (bits & 0x007f_ffff) as f32 / 8_388_608.0;
        let sign = if bits & 0x0100_0000 == 0 { 1.0 } else { -1.0 };
        sign * mantissa * 2_f32.powi(exponent)
    }

    pub(crate) fn rgb(&mut self, low: i32, high: i32) -> Rgb {
        Rgb::new(
            self.float(low, high),
            self.float(low, high),
            self.float(low, high),
        )
    }

    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, (self.next() % (i as u64 + 1)) as usize);
        }
    }
}

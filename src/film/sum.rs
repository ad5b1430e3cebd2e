use crate::color::Rgb;

/// Sums are integers in units of 2⁻⁴⁸.
const UNITS: f64 = (1_u64 << 48) as f64;

/// The largest magnitude of a channel that a film takes, 2⁴⁷ or 1.4e14. With it 2³² samples stay below 2¹²⁷ units,
/// so no sum overflows.
pub const MAX_SAMPLE: f32 = (1_u64 << 47) as f32;

/// The samples of one pixel, summed exactly in 128-bit fixed point.
///
/// The resolution is 2⁻⁴⁸, 3.6e-15: a channel of magnitude 2⁻²⁵ (3e-8) or more enters as it is, a smaller one
/// is first rounded to the resolution. Integer addition is associative, so the sum has the same bits in every order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Zeroable)]
pub struct PixelSum {
    sum: [i128; 3],
    count: u32,
}

impl PixelSum {
    /// Adds a sample. Refuses it, and returns false, where a channel is not a number, infinite or beyond
    /// [`MAX_SAMPLE`]; the pixel is then as it was.
    #[must_use = "a refused sample is to be counted and named"]
    pub fn add(&mut self, sample: Rgb) -> bool {
        let channels = sample.to_array();
        let accepted = channels.iter().all(|c| c.abs() <= MAX_SAMPLE);
        if accepted {
            for (sum, c) in self.sum.iter_mut().zip(channels) {
                *sum += in_units(c);
            }
            self.count += 1;
        }
        accepted
    }

    /// How many samples were added.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Luminance of the samples' sum, in f64.
    pub(crate) fn luminance(&self) -> f64 {
        let [r, g, b] = self.sum.map(|sum| sum as f64 / UNITS);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// The mean of the samples, black where there are none.
    pub fn mean(&self) -> Rgb {
        Rgb::from_array([0, 1, 2].map(|channel| self.channel_mean(channel)))
    }

    pub(super) fn channel_mean(&self, channel: usize) -> f32 {
        mean(self.sum[channel], self.count)
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (sum, more) in self.sum.iter_mut().zip(other.sum) {
            *sum += more;
        }
        self.count += other.count;
    }
}

fn mean(sum: i128, count: u32) -> f32 {
    let units = UNITS * f64::from(count.max(1));
    // The same number, sooner.
    let sum = i64::try_from(sum).map_or(sum as f64, |sum| sum as f64);
    (sum / units) as f32
}

/// One layer of one pixel, summed like the pixel, whose count is its own too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Zeroable)]
pub(super) struct LayerSum([i128; 3]);

impl LayerSum {
    /// Adds a sample; a channel beyond [`MAX_SAMPLE`] is taken for that, and what is not a number for 0.
    pub(super) fn add(&mut self, sample: Rgb) {
        for (sum, c) in self.0.iter_mut().zip(sample.to_array()) {
            *sum += in_units(c.clamp(-MAX_SAMPLE, MAX_SAMPLE));
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (sum, more) in self.0.iter_mut().zip(other.0) {
            *sum += more;
        }
    }

    pub(super) fn channel_mean(&self, channel: usize, pixel: &PixelSum) -> f32 {
        mean(self.0[channel], pixel.count)
    }
}

/// The nearest whole number of units. Most are whole and fit into 64 bits, which is sooner done.
fn in_units(x: f32) -> i128 {
    let units = f64::from(x) * UNITS;
    let whole = units as i64;
    if whole as f64 == units && whole != i64::MAX {
        i128::from(whole)
    } else {
        units.round() as i128
    }
}

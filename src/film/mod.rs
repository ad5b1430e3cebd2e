//! Exact accumulation of samples: the sum does not depend on the order of addition.

mod filter;

pub use filter::Filter;

use crate::color::Rgb;
use crate::image::Image;
use crate::memory::Pages;

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

    /// The mean of the samples, black where there are none.
    pub fn mean(&self) -> Rgb {
        Rgb::from_array([0, 1, 2].map(|channel| self.channel_mean(channel)))
    }

    fn channel_mean(&self, channel: usize) -> f32 {
        let units = UNITS * f64::from(self.count.max(1));
        let sum = self.sum[channel];
        // The same number, sooner.
        let sum = i64::try_from(sum).map_or(sum as f64, |sum| sum as f64);
        (sum / units) as f32
    }

    fn merge(&mut self, other: &Self) {
        for (sum, more) in self.sum.iter_mut().zip(other.sum) {
            *sum += more;
        }
        self.count += other.count;
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

/// A rectangle of pixels; `x` and `y` are its top left pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// A whole picture of `size` pixels, width and height.
    pub fn of_size(size: (u32, u32)) -> Self {
        Self {
            x: 0,
            y: 0,
            width: size.0,
            height: size.1,
        }
    }

    /// Squares of `edge` pixels that cover the rectangle once, row by row; those at the right and bottom may be smaller.
    ///
    /// # Panics
    /// Where `edge` is 0.
    pub fn tiles(self, edge: u32) -> impl Iterator<Item = Self> + Clone {
        let steps = move |length: u32| {
            (0..length)
                .step_by(edge as usize)
                .map(move |start| (start, edge.min(length - start)))
        };
        steps(self.height).flat_map(move |(y, height)| {
            steps(self.width).map(move |(x, width)| Self {
                x: self.x + x,
                y: self.y + y,
                width,
                height,
            })
        })
    }

    /// Column and row of each of its pixels, row by row.
    pub fn pixels(self) -> impl Iterator<Item = (u32, u32)> + Clone {
        let columns = self.x..self.x + self.width;
        (self.y..self.y + self.height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }

    /// The same in squares of eight by eight, so that rays through pixels that follow each other go together.
    pub fn blocks(self) -> impl Iterator<Item = (u32, u32)> + Clone {
        self.tiles(8).flat_map(Self::pixels)
    }

    /// Whether all of `other` lies inside.
    pub fn contains(self, other: Self) -> bool {
        let inside = |start, length, other_start, other_length| {
            start <= other_start
                && other_start - start <= length
                && other_length <= length - (other_start - start)
        };
        inside(self.x, self.width, other.x, other.width)
            && inside(self.y, self.height, other.y, other.height)
    }
}

/// The sums of a rectangle of pixels: a whole picture, or the tile that one worker fills on its own and hands back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    rect: Rect,
    pixels: Pages<PixelSum>,
}

impl Film {
    /// No samples yet.
    pub fn new(rect: Rect) -> Self {
        let pixels = rect.width as usize * rect.height as usize;
        Self {
            rect,
            pixels: Pages::zeroed(pixels),
        }
    }

    /// Which pixels of the picture it holds.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// The pixel in column `x` and row `y` of the picture.
    ///
    /// # Panics
    /// Where the pixel lies outside.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> &mut PixelSum {
        let (column, row) = (x - self.rect.x, y - self.rect.y);
        assert!(
            column < self.rect.width,
            "column {x} is outside of {:?}",
            self.rect
        );
        &mut self.pixels[row as usize * self.rect.width as usize + column as usize]
    }

    /// The sums row by row from the top left.
    pub fn pixels(&self) -> &[PixelSum] {
        &self.pixels
    }

    /// Adds the samples of a tile, or of another film of the same picture. The order of such calls cannot show.
    ///
    /// # Panics
    /// Where `part` does not lie inside.
    pub fn add(&mut self, part: &Self) {
        assert!(
            self.rect.contains(part.rect),
            "{:?} is not inside of {:?}",
            part.rect,
            self.rect
        );
        let width = self.rect.width as usize;
        let left = (part.rect.x - self.rect.x) as usize;
        let top = (part.rect.y - self.rect.y) as usize;
        let columns = (part.rect.width as usize).max(1);
        for (row, sums) in part.pixels.chunks(columns).enumerate() {
            let start = (top + row) * width + left;
            for (pixel, sum) in self.pixels[start..].iter_mut().zip(sums) {
                pixel.merge(sum);
            }
        }
    }

    /// The means as channels `R`, `G`, `B`: each exact sum divided in f64, then rounded to f32.
    pub fn to_image(&self) -> Image {
        let (width, height) = (self.rect.width as usize, self.rect.height as usize);
        Image::of_channels(width, height, |pixel, c| self.pixels[pixel].channel_mean(c))
    }
}

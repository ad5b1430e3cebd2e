//! Exact accumulation of samples: the sum does not depend on the order of addition.

mod filter;
mod rect;
mod sum;

pub use filter::Filter;
pub use rect::Rect;
pub use sum::{MAX_SAMPLE, PixelSum};

use rayon::prelude::*;

use crate::color::Rgb;
use crate::image::{Channel, Image};
use crate::memory::Pages;

use sum::LayerSum;

/// What a film holds beside the picture: the name and channels of up to three numbers a sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// What stands before the dot in the channels' names.
    pub name: String,
    /// The channels that are written, one character each: `RGB`, `XYZ` or `Z`.
    pub channels: &'static str,
}

/// The sums of a rectangle of pixels: a whole picture, or the tile that one worker fills on its own and hands back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    rect: Rect,
    pixels: Pages<PixelSum>,
    /// How many layers a pixel has.
    depth: usize,
    /// Those of the first pixel, then those of the next.
    layers: Pages<LayerSum>,
}

impl Film {
    /// No samples yet, and no layers.
    pub fn new(rect: Rect) -> Self {
        Self::with_layers(rect, 0)
    }

    /// No samples yet; each is to bring a number of `layers` as well.
    pub fn with_layers(rect: Rect, layers: usize) -> Self {
        let pixels = rect.width as usize * rect.height as usize;
        Self {
            rect,
            pixels: Pages::zeroed(pixels),
            depth: layers,
            layers: Pages::zeroed(pixels * layers),
        }
    }

    /// Bytes that a pixel with so many layers takes.
    pub fn bytes_per_pixel(layers: usize) -> usize {
        size_of::<PixelSum>() + layers * size_of::<LayerSum>()
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
        let index = self.index(x, y);
        &mut self.pixels[index]
    }

    fn index(&self, x: u32, y: u32) -> usize {
        let (column, row) = (x - self.rect.x, y - self.rect.y);
        assert!(
            column < self.rect.width,
            "column {x} is outside of {:?}",
            self.rect
        );
        row as usize * self.rect.width as usize + column as usize
    }

    /// The pixel in column `x` and row `y` of the picture, as it is.
    ///
    /// # Panics
    /// Where the pixel lies outside.
    pub fn pixel(&self, x: u32, y: u32) -> &PixelSum {
        &self.pixels[self.index(x, y)]
    }

    /// Adds a sample with its layers to the pixel in column `x` and row `y`, or neither where [`PixelSum::add`]
    /// refuses the sample.
    ///
    /// # Panics
    /// Where the pixel lies outside, or there are not as many layers as the film has.
    #[must_use = "a refused sample is to be counted and named"]
    pub fn add_sample(&mut self, x: u32, y: u32, sample: Rgb, layers: &[Rgb]) -> bool {
        assert_eq!(layers.len(), self.depth, "layers of a sample");
        let index = self.index(x, y);
        let accepted = self.pixels[index].add(sample);
        if accepted {
            let sums = &mut self.layers[index * self.depth..];
            for (sum, &layer) in sums.iter_mut().zip(layers) {
                sum.add(layer);
            }
        }
        accepted
    }

    /// The sums row by row from the top left.
    pub fn pixels(&self) -> &[PixelSum] {
        &self.pixels
    }

    /// Adds the samples of a tile, or of another film of the same picture. The order of such calls cannot show.
    ///
    /// # Panics
    /// Where `part` does not lie inside, or has not as many layers.
    pub fn add(&mut self, part: &Self) {
        assert!(
            self.rect.contains(part.rect),
            "{:?} is not inside of {:?}",
            part.rect,
            self.rect
        );
        assert_eq!(part.depth, self.depth, "layers of a part");
        let width = self.rect.width as usize;
        let left = (part.rect.x - self.rect.x) as usize;
        let top = (part.rect.y - self.rect.y) as usize;
        let columns = (part.rect.width as usize).max(1);
        for (row, sums) in part.pixels.chunks(columns).enumerate() {
            let start = (top + row) * width + left;
            for (pixel, sum) in self.pixels[start..].iter_mut().zip(sums) {
                pixel.merge(sum);
            }
            let layers = part.layers[row * columns * self.depth..].iter();
            let into = &mut self.layers[start * self.depth..][..sums.len() * self.depth];
            for (layer, sum) in into.iter_mut().zip(layers) {
                layer.merge(sum);
            }
        }
    }

    /// The means as channels `R`, `G`, `B`: each exact sum divided in f64, then rounded to f32.
    pub fn to_image(&self) -> Image {
        let (width, height) = (self.rect.width as usize, self.rect.height as usize);
        Image::of_channels(width, height, |pixel, c| self.pixels[pixel].channel_mean(c))
    }

    /// The means of its layers, which are called `names`, as [`Self::to_image`] makes them: `name.R` and so on.
    pub fn layer_channels(&self, names: &[Layer]) -> Vec<Channel> {
        let channel = |(layer, name, c, letter): (usize, &str, usize, char)| Channel {
            name: format!("{name}.{letter}"),
            values: (self.pixels.par_iter().enumerate())
                .map(|(i, pixel)| self.layers[i * self.depth + layer].channel_mean(c, pixel))
                .collect(),
        };
        (names.iter().enumerate())
            .flat_map(|(i, layer)| {
                let letters = layer.channels.chars().enumerate();
                letters.map(move |(c, letter)| (i, layer.name.as_str(), c, letter))
            })
            .map(channel)
            .collect()
    }
}

//! Where a picture still needs samples.

use crate::film::{Film, Rect};

/// Samples of a batch: their mean is one estimate of a pixel. Samples of one batch are spread more evenly than chance
/// would have it, and batches among each other too, so the spread of batches overstates the error rather than not.
const BATCH: u32 = 16;

/// Batches that no pixel does without.
const FEWEST: u32 = 2;

/// Edge of the square blocks that are judged as one.
const EDGE: u32 = 8;

/// Added to the squared luminance, so that black need not be exact: below 3 % of white the error counts against that.
const DARK: f64 = 1e-3;

/// Decides block by block whether a picture is good enough.
///
/// The error of a pixel is the standard error of its mean luminance, estimated from the spread of batch means, over
/// that luminance; that of a block is the root of the mean square of its pixels' (the relative mean squared error of
/// Rousselle et al. 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization"). A block is done, for
/// good, when it and its eight neighbours are below the limit, so that pixels which have not met a rare bright path yet
/// do not stop where others nearby have. All this is a function of the pixels' sums after a given number of samples,
/// which do not depend on how the work is split.
pub(super) struct Adaptive {
    /// The largest error, squared.
    limit: f64,
    area: Rect,
    /// Blocks lie on a grid over the whole picture; columns of those that the area touches.
    columns: u32,
    blocks: Vec<Block>,
    pixels: Vec<Spread>,
    batches: u32,
}

#[derive(Clone, Default)]
struct Block {
    done: bool,
    pixels: u32,
    /// Sum of the squared errors of its pixels.
    error: f64,
}

/// The batches of one pixel.
#[derive(Clone, Default)]
struct Spread {
    /// Luminance of all samples of past batches.
    sum: f64,
    /// Sum of the squared means of past batches.
    squares: f64,
}

impl Adaptive {
    /// Nothing is done yet.
    pub(super) fn new(noise: f64, area: Rect) -> Self {
        let count = |start: u32, length: u32| (start + length).div_ceil(EDGE) - start / EDGE;
        let (columns, rows) = (count(area.x, area.width), count(area.y, area.height));
        let mut adaptive = Self {
            limit: noise * noise,
            area,
            columns,
            blocks: vec![Block::default(); columns as usize * rows as usize],
            pixels: vec![Spread::default(); area.width as usize * area.height as usize],
            batches: 0,
        };
        for pixel in area.pixels() {
            let block = adaptive.block(pixel);
            adaptive.blocks[block].pixels += 1;
        }
        adaptive
    }

    fn block(&self, (x, y): (u32, u32)) -> usize {
        let (column, row) = (x / EDGE - self.area.x / EDGE, y / EDGE - self.area.y / EDGE);
        row as usize * self.columns as usize + column as usize
    }

    /// Whether the pixel needs more samples.
    pub(super) fn needs(&self, pixel: (u32, u32)) -> bool {
        !self.blocks[self.block(pixel)].done
    }

    /// How many pixels need no more samples.
    pub(super) fn converged(&self) -> u64 {
        let done = self.blocks.iter().filter(|block| block.done);
        done.map(|block| u64::from(block.pixels)).sum()
    }

    /// Looks at the film after `taken` samples of each pixel that needs them; to be called after every pass.
    pub(super) fn judge(&mut self, film: &Film, taken: u32) {
        if taken != (self.batches + 1) * BATCH {
            return;
        }
        self.batches += 1;
        self.measure(film);
        if self.batches < FEWEST {
            return;
        }
        let (columns, count) = (self.columns as usize, self.blocks.len());
        let good: Vec<bool> = (self.blocks.iter())
            .map(|block| block.error <= self.limit * f64::from(block.pixels))
            .collect();
        for index in 0..count {
            let (column, row) = (index % columns, index / columns);
            let mut around = (row.saturating_sub(1)..=row + 1).flat_map(|row| {
                let near = column.saturating_sub(1)..=(column + 1).min(columns - 1);
                near.map(move |column| row * columns + column)
            });
            self.blocks[index].done |= around.all(|near| near >= count || good[near]);
        }
    }

    /// The errors of all blocks that are not done.
    fn measure(&mut self, film: &Film) {
        for block in self.blocks.iter_mut().filter(|block| !block.done) {
            block.error = 0.0;
        }
        let batches = f64::from(self.batches);
        for (i, pixel) in self.area.pixels().enumerate() {
            let block = self.block(pixel);
            if self.blocks[block].done {
                continue;
            }
            let spread = &mut self.pixels[i];
            let sum = film.pixel(pixel.0, pixel.1).luminance();
            // A sample that was refused counts as black.
            let mean = (sum - spread.sum) / f64::from(BATCH);
            spread.sum = sum;
            spread.squares += mean * mean;
            let mean = sum / (batches * f64::from(BATCH));
            let deviation = (spread.squares - batches * mean * mean).max(0.0);
            let variance = deviation / (batches * (batches - 1.0).max(1.0));
            self.blocks[block].error += variance / (mean * mean + DARK);
        }
    }
}

//! A picture in memory: named f32 channels, rows from the top.

use rayon::prelude::*;

use crate::color::Rgb;
use crate::error::{Error, ErrorKind, Result};

/// Channels of equal size, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// The channels in the order in which they are written.
    pub channels: Vec<Channel>,
    /// What made the picture, written to the file's header: name and value.
    pub metadata: Vec<(String, String)>,
}

/// One named plane of `width * height` values. Colour is `R`, `G`, `B`; layers use a dot, as in `albedo.R`.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name in the file.
    pub name: String,
    /// `width * height` values.
    pub values: Vec<f32>,
}

impl Image {
    /// A picture of `width * height` pixels with the channels `R`, `G`, `B` and no metadata.
    pub fn rgb(width: usize, height: usize, pixels: &[Rgb]) -> Self {
        Self::of_channels(width, height, |pixel, channel| pixels[pixel][channel])
    }

    /// The same, of what `value` says for pixel and channel.
    pub fn of_channels(
        width: usize,
        height: usize,
        value: impl Fn(usize, usize) -> f32 + Sync,
    ) -> Self {
        let channel = |(c, name): (usize, &str)| Channel {
            name: name.to_owned(),
            values: (0..width * height)
                .into_par_iter()
                .map(|pixel| value(pixel, c))
                .collect(),
        };
        Self {
            width,
            height,
            channels: ["R", "G", "B"]
                .into_iter()
                .enumerate()
                .map(channel)
                .collect(),
            metadata: Vec::new(),
        }
    }

    /// The values of the channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels
            .iter()
            .find(|c| c.name == name)
            .map(|c| c.values.as_slice())
    }

    /// Checks what the encoders rely on.
    ///
    /// # Errors
    /// Where there is no pixel or no channel, or a channel is not `width * height` long.
    pub fn validate(&self) -> Result<()> {
        let pixels = self.width.saturating_mul(self.height);
        if pixels == 0 || self.channels.is_empty() {
            return Err(Error::new(
                ErrorKind::Usage,
                format!(
                    "an image of {} x {} pixels and {} channels has nothing to write",
                    self.width,
                    self.height,
                    self.channels.len()
                ),
            ));
        }
        match self.channels.iter().find(|c| c.values.len() != pixels) {
            None => Ok(()),
            Some(channel) => Err(Error::new(
                ErrorKind::Usage,
                format!(
                    "channel `{}` has {} values where {} x {} pixels need {pixels}",
                    channel.name,
                    channel.values.len(),
                    self.width,
                    self.height
                ),
            )),
        }
    }
}

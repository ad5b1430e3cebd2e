//! A picture in memory: named f32 channels, rows from the top.

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
    /// The values of the channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels
            .iter()
            .find(|c| c.name == name)
            .map(|c| c.values.as_slice())
    }
}

//! Linear RGB with Rec. 709 primaries, and the curves that turn it into what a file or screen wants.

use glam::Vec3;

/// Linear RGB, Rec. 709 primaries, D65 white; unbounded above.
pub type Rgb = Vec3;

/// From linear light to what an 8-bit file stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tonemap {
    /// The piecewise curve of IEC 61966-2-1.
    #[default]
    Srgb,
    /// The plain power 1/2.2.
    Gamma22,
    /// Linear values as they are.
    None,
}

impl Tonemap {
    /// One channel in linear light to an encoded value in 0..=1; what lies outside is clipped.
    pub fn encode(self, linear: f32) -> f32 {
        let x = linear.clamp(0.0, 1.0);
        match self {
            Self::Srgb if x <= 0.003_130_8 => 12.92 * x,
            Self::Srgb => 1.055 * x.powf(1.0 / 2.4) - 0.055,
            Self::Gamma22 => x.powf(1.0 / 2.2),
            Self::None => x,
        }
    }
}

/// How a file's integers stand for numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Colours: the curve of IEC 61966-2-1.
    Srgb,
    /// Data: in proportion.
    Linear,
}

impl Encoding {
    /// One channel in 0..=1 as the file has it, decoded.
    pub fn decode(self, encoded: f32) -> f32 {
        match self {
            Self::Srgb => srgb_to_linear(encoded),
            Self::Linear => encoded,
        }
    }
}

/// Rec. 709 luminance; of a grey it is its value, to the bit.
pub fn luminance(color: Rgb) -> f32 {
    color.y + 0.2126 * (color.x - color.y) + 0.0722 * (color.z - color.y)
}

/// Decodes one sRGB channel in 0..=1 to linear light (IEC 61966-2-1).
pub fn srgb_to_linear(x: f32) -> f32 {
    if x <= 0.04045 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

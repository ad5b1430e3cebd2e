//! Exact accumulation of samples: the sum does not depend on the order of addition.

/// Pixel reconstruction filter, used by importance sampling: each sample lies in one pixel's filter and counts fully.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant over the pixel widened to `radius` (0.5 is the pixel itself).
    Box {
        /// Half width in pixels, above 0.
        radius: f64,
    },
    /// Falls linearly to 0 at `radius`.
    Tent {
        /// Half width in pixels, above 0.
        radius: f64,
    },
    /// A Gaussian of standard deviation `radius / 3`, cut at `radius`.
    Gaussian {
        /// Half width in pixels, above 0.
        radius: f64,
    },
}

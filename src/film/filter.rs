use glam::Vec2;

/// Pixel reconstruction filter, used by importance sampling: each sample lies in one pixel's filter and counts fully.
///
/// All filters are separable: the density in the plane is the product of the same density along x and along y.
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

impl Filter {
    /// Where a sample lies, in pixels from the pixel's centre; `u2` is uniform in [0, 1)² and the result
    /// is distributed as the filter. Each axis inverts the cumulative distribution, so strata stay strata.
    pub fn sample(&self, u2: Vec2) -> (f64, f64) {
        (self.sample_axis(u2.x), self.sample_axis(u2.y))
    }

    fn sample_axis(&self, u: f32) -> f64 {
        let u = f64::from(u);
        match *self {
            Self::Box { radius } => radius * (2.0 * u - 1.0),
            Self::Tent { radius } if u < 0.5 => radius * ((2.0 * u).sqrt() - 1.0),
            Self::Tent { radius } => radius * (1.0 - (2.0 - 2.0 * u).sqrt()),
            Self::Gaussian { radius } => {
                let p = BELOW_CUT + u * (1.0 - 2.0 * BELOW_CUT);
                let sigma = radius / 3.0;
                (sigma * inverse_normal_cdf(p)).clamp(-radius, radius)
            }
        }
    }
}

/// The share of a normal distribution that lies below minus three standard deviations.
const BELOW_CUT: f64 = 0.001_349_898_031_630_094_6;

/// The standard normal quantile of `p` in (0, 1), relative error below 1.2e-9
/// (Acklam 2003, "An algorithm for computing the inverse normal cumulative distribution function").
fn inverse_normal_cdf(p: f64) -> f64 {
    const A: [f64; 6] = [
        -3.969683028665376e+01,
        2.209460984245205e+02,
        -2.759285104469687e+02,
        1.383_577_518_672_69e2,
        -3.066479806614716e+01,
        2.506628277459239e+00,
    ];
    const B: [f64; 6] = [
        -5.447609879822406e+01,
        1.615858368580409e+02,
        -1.556989798598866e+02,
        6.680131188771972e+01,
        -1.328068155288572e+01,
        1.0,
    ];
    const C: [f64; 6] = [
        -7.784894002430293e-03,
        -3.223964580411365e-01,
        -2.400758277161838e+00,
        -2.549732539343734e+00,
        4.374664141464968e+00,
        2.938163982698783e+00,
    ];
    const D: [f64; 5] = [
        7.784695709041462e-03,
        3.224671290700398e-01,
        2.445134137142996e+00,
        3.754408661907416e+00,
        1.0,
    ];
    const TAIL: f64 = 0.02425;

    let horner = |coefficients: &[f64], x: f64| coefficients.iter().fold(0.0, |sum, c| sum * x + c);
    let from_center = p - 0.5;
    if from_center.abs() <= 0.5 - TAIL {
        let r = from_center * from_center;
        return from_center * horner(&A, r) / horner(&B, r);
    }
    let q = (-2.0 * p.min(1.0 - p).ln()).sqrt();
    -from_center.signum() * horner(&C, q) / horner(&D, q)
}

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number of about 32 decimal digits: the unevaluated sum of two f64 (Dekker 1971, "A floating-point
/// technique for extending the available precision").
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct Double {
    pub(super) high: f64,
    low: f64,
}

impl Double {
    /// The sum of two f64, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        let low = (a - (high - part)) + (b - part);
        Self { high, low }
    }

    pub(super) fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::from(0.0);
        }
        let root = Self::from(self.high.sqrt());
        root + (self - root * root) / (root + root)
    }

    pub(super) fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    pub(super) fn max(self, other: Self) -> Self {
        if self < other { other } else { self }
    }
}

impl From<f64> for Double {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let high = Self::sum(self.high, b.high);
        let low = Self::sum(self.low, b.low);
        let sum = Self::sum(high.high, high.low + low.high);
        Self::sum(sum.high, sum.low + low.low)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let high = self.high * b.high;
        let low = self.high.mul_add(b.high, -high);
        Self::sum(high, low + (self.high * b.low + self.low * b.high))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let first = self.high / b.high;
        let rest = self - b * Self::from(first);
        let second = rest.high / b.high;
        let rest = rest - b * Self::from(second);
        Self::sum(first, second) + Self::from(rest.high / b.high)
    }
}

#[test]
fn doubles_carry_more_than_thirty_digits() {
    let third = Double::from(1.0) / Double::from(3.0);
    let error = third * Double::from(3.0) - Double::from(1.0);
    assert!(error.high.abs() < 1e-31);
    let root = Double::from(2.0).sqrt();
    assert!((root * root - Double::from(2.0)).high.abs() < 1e-31);
    assert!(((Double::from(1.0) + Double::from(1e-25)) - Double::from(1.0)).high == 1e-25);
}

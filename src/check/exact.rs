//! Signs of volumes, exact whatever the rounding: expansions as in Shewchuk 1997, "Adaptive Precision Floating-Point
//! Arithmetic and Fast Robust Geometric Predicates", sections 2.2 to 2.4.

use glam::DVec3;

/// The sign of `d · ((a - o) × (b - o))` as -1, 0 or 1: on which side the line from `o` along `d` passes the edge from
/// `a` to `b`. Exact where no product of three of the numbers leaves the range of f64.
pub(super) fn volume_sign(o: DVec3, d: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (p, q) = (a - o, b - o);
    let reach = p.abs().max(q.abs()).max_element();
    let volume = d.dot(p.cross(q));
    // Six products of three factors, each factor and operation off by 2^-53 at most.
    if volume.abs() > 64.0 * f64::EPSILON * reach * reach * d.abs().max_element() {
        return volume.signum();
    }
    exact_sign(o, d, a, b)
}

/// [`volume_sign`] without the look at the rounded value.
fn exact_sign(o: DVec3, d: DVec3, a: DVec3, b: DVec3) -> f64 {
    let p = [0, 1, 2].map(|i| difference(a[i], o[i]));
    let q = [0, 1, 2].map(|i| difference(b[i], o[i]));
    let mut sum = Expansion::default();
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        for (x, y, z) in [(d[i], p[j], q[k]), (-d[i], p[k], q[j])] {
            for y in y {
                for z in z {
                    sum.add_product(x, y, z);
                }
            }
        }
    }
    sum.sign()
}

/// An exact sum: numbers of rising magnitude that do not overlap.
#[derive(Default)]
struct Expansion(Vec<f64>);

impl Expansion {
    fn add_product(&mut self, x: f64, y: f64, z: f64) {
        let (high, low) = product(x, y);
        for part in [low, high] {
            let (high, low) = product(part, z);
            self.add(low);
            self.add(high);
        }
    }

    fn add(&mut self, x: f64) {
        let mut carry = x;
        for part in &mut self.0 {
            (carry, *part) = sum(carry, *part);
        }
        self.0.push(carry);
        self.0.retain(|&part| part != 0.0);
    }

    /// That of the largest part.
    fn sign(&self) -> f64 {
        self.0.last().map_or(0.0, |part| part.signum())
    }
}

/// `x + y` rounded, and what rounding took (Knuth).
fn sum(x: f64, y: f64) -> (f64, f64) {
    let s = x + y;
    let y_part = s - x;
    let x_part = s - y_part;
    (s, (x - x_part) + (y - y_part))
}

/// `x - y` rounded, and what rounding took.
fn difference(x: f64, y: f64) -> [f64; 2] {
    let (s, rest) = sum(x, -y);
    [s, rest]
}

/// `x y` rounded, and what rounding took.
fn product(x: f64, y: f64) -> (f64, f64) {
    let p = x * y;
    (p, x.mul_add(y, -p))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// In integers that hold every product.
    fn integer_sign(o: [i64; 3], d: [i64; 3], a: [i64; 3], b: [i64; 3]) -> f64 {
        let [p, q] = [a, b].map(|x| [0, 1, 2].map(|i| i128::from(x[i] - o[i])));
        let volume: i128 = [(0, 1, 2), (1, 2, 0), (2, 0, 1)]
            .iter()
            .map(|&(i, j, k)| i128::from(d[i]) * (p[j] * q[k] - p[k] * q[j]))
            .sum();
        volume.signum() as f64
    }

    #[test]
    fn signs_are_those_of_integer_arithmetic() {
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let vector = |x: [i64; 3]| DVec3::from_array(x.map(|x| x as f64));
        let (mut zeros, mut doubtful) = (0, 0);
        for round in 0..200_000 {
            let most = 1_i64 << (3 + round % 37);
            let mut point = || [0; 3].map(|_| rng.random_range(-most..=most));
            let (o, a, mut b, mut d) = (point(), point(), point(), point());
            if round % 2 == 0 {
                // Flat to within one unit: d lies in the plane of p and q, b nearly.
                d = [0, 1, 2].map(|i| a[i] - o[i]);
                b = [0, 1, 2].map(|i| 2 * a[i] - o[i] + d[i] % 2);
                b[round % 3] += (round / 8 % 3) as i64 - 1;
                d[0] += (round / 32 % 3) as i64 - 1;
            }
            let truth = integer_sign(o, d, a, b);
            let [o, d, a, b] = [o, d, a, b].map(vector);
            assert_eq!(volume_sign(o, d, a, b), truth, "{o} {d} {a} {b}");
            assert_eq!(exact_sign(o, d, a, b), truth, "{o} {d} {a} {b}");
            zeros += u32::from(truth == 0.0);
            let rounded = d.dot((a - o).cross(b - o));
            doubtful +=
                u32::from(truth != 0.0 && rounded.signum() * truth <= 0.0 || rounded == 0.0);
        }
        assert!(zeros > 1000 && doubtful > 1000, "{zeros} {doubtful}");
    }

    #[test]
    fn parts_far_below_the_rounding_decide() {
        // An edge that the ray meets but for a part in 2^80.
        let tiny = 2.0_f64.powi(-80);
        let (a, b) = (DVec3::new(-1.0, 0.0, 1.0), DVec3::new(1.0, 0.0, 1.0));
        for y in [-tiny, 0.0, tiny] {
            let o = DVec3::new(0.0, y, 0.0);
            let expected = if y == 0.0 { 0.0 } else { y.signum() };
            assert_eq!(volume_sign(o, DVec3::Z, a, b), expected);
            assert_eq!(volume_sign(o, DVec3::Z, b, a), -expected);
        }
    }
}

//! Signed distances, negative inside, and the ways to join them.
//!
//! Some of these fields only bound the distance (an ellipsoid has no closed form); that is enough here, since the
//! polygoniser needs the right zero set and a gradient, not the right length.

use glam::{DMat3, DVec3};

/// An ellipsoid centred on the origin with the given semi-axes.
pub(crate) fn ellipsoid(p: DVec3, radii: DVec3) -> f64 {
    let scaled = p / radii;
    let slope = (scaled / radii).length();
    if slope == 0.0 {
        return -radii.min_element();
    }
    // First-order distance: the implicit function |p / r| - 1 over the length of its gradient.
    let k = scaled.length();
    k * (k - 1.0) / slope
}

/// The hull of two balls: a capsule when the radii agree, else a rounded cone.
///
/// The balls in between have radius `ra - s t` at height `t`; the nearest of them is where the derivative of
/// `|p - t| - r(t)` is zero, a fixed slant behind the foot of the perpendicular.
pub(crate) fn rounded_cone(p: DVec3, (a, ra): (DVec3, f64), (b, rb): (DVec3, f64)) -> f64 {
    let axis = b - a;
    let length = axis.length();
    let slope = (ra - rb) / length;
    let height = (p - a).dot(axis) / length;
    let across = ((p - a).length_squared() - height * height).max(0.0).sqrt();
    let slant = slope / (1.0 - slope * slope).max(1e-9).sqrt();
    let t = (height - across * slant).clamp(0.0, length);
    across.hypot(height - t) - (ra - slope * t)
}

/// A ring around the y axis.
pub(crate) fn ring(p: DVec3, radius: f64, thickness: f64) -> f64 {
    (p.x.hypot(p.z) - radius).hypot(p.y) - thickness
}

/// Union whose seam is filled over a width of about `k`.
pub(crate) fn join(a: f64, b: f64, k: f64) -> f64 {
    let overlap = (k - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * k)
}

/// Intersection whose edge is rounded over a width of about `k`.
pub(crate) fn meet(a: f64, b: f64, k: f64) -> f64 {
    -join(-a, -b, k)
}

/// `a` without `b`, the edge rounded over a width of about `k`.
pub(crate) fn carve(a: f64, b: f64, k: f64) -> f64 {
    meet(a, -b, k)
}

/// A Hermite step from 0 at `lo` to 1 at `hi`.
pub(crate) fn smoothstep(lo: f64, hi: f64, x: f64) -> f64 {
    let t = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A rotation whose y axis is `y` and whose z axis is as near to `z` as that allows.
pub(crate) fn basis(y: DVec3, z: DVec3) -> DMat3 {
    let y = y.normalize();
    let x = y.cross(z).normalize();
    DMat3::from_cols(x, y, x.cross(y))
}

/// A ball swept along a smooth curve while its radius changes.
pub(crate) struct Tube {
    balls: Vec<(DVec3, f64)>,
}

impl Tube {
    /// A Catmull-Rom curve through `knots` (centre, radius), cut into `steps` rounded cones a span.
    pub(crate) fn through(knots: &[(DVec3, f64)], steps: usize) -> Self {
        let mut balls = Vec::new();
        for i in 0..knots.len() - 1 {
            let at = |j: isize| knots[j.clamp(0, knots.len() as isize - 1) as usize];
            let k = i as isize;
            let span = [at(k - 1), at(k), at(k + 1), at(k + 2)];
            for step in 0..steps {
                let t = step as f64 / steps as f64;
                let blend = |q: [DVec3; 4]| {
                    q[1] + 0.5
                        * t
                        * ((q[2] - q[0])
                            + t * ((2.0 * q[0] - 5.0 * q[1] + 4.0 * q[2] - q[3])
                                + t * (3.0 * (q[1] - q[2]) + q[3] - q[0])))
                };
                // Radii run straight between knots: a spline could swing below zero.
                let radius = span[1].1 + t * (span[2].1 - span[1].1);
                balls.push((blend(span.map(|knot| knot.0)), radius));
            }
        }
        balls.extend(knots.last());
        Self { balls }
    }

    /// Rounded cones through `balls`.
    pub(crate) fn straight(balls: &[(DVec3, f64)]) -> Self {
        Self {
            balls: balls.to_vec(),
        }
    }

    /// The balls of the curve, in order.
    pub(crate) fn balls(&self) -> &[(DVec3, f64)] {
        &self.balls
    }

    /// Distance to the swept surface.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        self.balls
            .windows(2)
            .map(|pair| rounded_cone(p, pair[0], pair[1]))
            .fold(f64::INFINITY, f64::min)
    }
}

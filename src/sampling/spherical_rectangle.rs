use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;

/// A rectangle as it is seen from a point, for drawing directions uniformly from the solid angle that it subtends
/// (after Ureña, Fajardo and King 2013, "An Area-Preserving Parametrization for Spherical Rectangles").
///
/// Coordinates are along its edges, from the foot of the point's perpendicular on its plane.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    x: [f64; 2],
    y: [f64; 2],
    height: f64,
    /// [`strip`] at the lesser x.
    start: DVec2,
    solid_angle: f64,
}

impl SphericalRectangle {
    /// The rectangle of the ranges `x` and `y`, seen from `height` above 0 over its plane.
    #[inline(always)]
    pub fn new(x: [f64; 2], y: [f64; 2], height: f64) -> Self {
        let [start, end] = x.map(|x| strip(x, y, height));
        let angle = start.perp_dot(end).atan2(start.dot(end));
        // Only what lies on both sides of the foot can be more than half a turn.
        let beyond = start.y < 0.0 && end.y > 0.0 && angle < 0.0;
        Self {
            x,
            y,
            height,
            start,
            solid_angle: if beyond { angle + TAU } else { angle.max(0.0) },
        }
    }

    /// In steradians, at least 0; its inverse is the density of [`Self::sample`].
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A point of the rectangle, uniform in solid angle, as shares of its ranges.
    #[inline(always)]
    pub fn sample(&self, u2: DVec2) -> DVec2 {
        let Self { x, y, height, .. } = *self;
        let sides = y.map(|y| hypotenuse(y, height));
        // The strip that ends at x and holds the share u of the solid angle. With b_i the sines of the elevations of
        // both y over the plane x = 0 and c that of x, it is asin(c b_1) - asin(c b_0). Solved for c, that is the sine of
        // the angle over the root of `spread`; x over the height is the tangent of c's elevation.
        let length = (height * height + x[0] * x[0]) * sides[0] * sides[1];
        let half = half_angle(self.start / length).rotate(half_turn(u2.x * self.solid_angle));
        let [b0, b1] = [y[0] / sides[0], y[1] / sides[1]];
        let spread = (b1 - b0) * (b1 - b0) + 4.0 * b0 * b1 * half.y * half.y;
        let sine = 2.0 * half.y * half.x;
        let rest = (spread - sine * sine).max(0.0);
        let at_x = (sine * height / rest.sqrt()).clamp(x[0], x[1]);
        // Along the segment at x the solid angle is proportional to the sine of the elevation.
        let distance = hypotenuse(at_x, height);
        let [s0, s1] = y.map(|y| y / hypotenuse(y, distance));
        let s = s0 + u2.y * (s1 - s0);
        let at_y = (s * distance / (1.0 - s * s).sqrt()).clamp(y[0], y[1]);
        DVec2::new((at_x - x[0]) / (x[1] - x[0]), (at_y - y[0]) / (y[1] - y[0]))
    }
}

/// Without the library's care for numbers whose squares overflow, which takes longer than all the rest.
fn hypotenuse(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// A complex number whose argument is the solid angle of the strip between 0 and `x`, negative where `x` is: a
/// difference of two arcs' tangents, as a product.
fn strip(x: f64, y: [f64; 2], height: f64) -> DVec2 {
    let [r0, r1] = y.map(|y| (x * x + y * y + height * height).sqrt());
    DVec2::new(
        height * height * r0 * r1 + x * x * y[0] * y[1],
        height * x * (y[1] * r0 - y[0] * r1),
    )
}

/// Cosine and sine of half the angle, within ±pi, that has those of `whole`.
fn half_angle(whole: DVec2) -> DVec2 {
    if whole.x > 0.0 {
        let cos = (0.5 * (1.0 + whole.x)).sqrt();
        DVec2::new(cos, 0.5 * whole.y / cos)
    } else {
        let sin = (0.5 * (1.0 - whole.x)).sqrt();
        DVec2::new(0.5 * whole.y.abs() / sin, sin.copysign(whole.y))
    }
}

/// Cosine and sine of half of `angle` in 0 to 2 pi. The sine in f32 is as good as the number that asks for the angle;
/// squares add up to 1 to the last digit.
fn half_turn(angle: f64) -> DVec2 {
    let half = 0.5 * angle;
    let sin = f64::from((half as f32).sin());
    let cos = (1.0 - sin * sin).max(0.0).sqrt();
    DVec2::new(if half > FRAC_PI_2 { -cos } else { cos }, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a rectangle with a corner at the foot subtends.
    fn at_corner(x: f64, y: f64, height: f64) -> f64 {
        (x * y).atan2(height * (x * x + y * y + height * height).sqrt())
    }

    fn solid_angle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], height: f64) -> f64 {
        let corner = |x, y| at_corner(x, y, height);
        corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
    }

    /// Around the foot, beside it and far from it; wide ones from close by and narrow ones.
    const SEEN: [([f64; 2], [f64; 2], f64); 8] = [
        ([-1.0, 1.0], [-1.0, 1.0], 1.0),
        ([-1.0, 2.0], [-3.0, 0.5], 1e-6),
        ([-50.0, 1e-3], [-20.0, 1e-3], 0.01),
        ([0.0, 2.0], [0.0, 0.7], 0.1),
        ([0.5, 2.0], [-0.7, -0.1], 0.3),
        ([-8.0, -7.0], [3.0, 3.5], 2.0),
        ([-1.0, 1.0], [2.0, 2.001], 0.5),
        ([0.2, 0.201], [-4.0, 5.0], 1.5),
    ];

    #[test]
    fn solid_angles_are_those_of_the_corners() {
        for (x, y, height) in SEEN {
            let seen = SphericalRectangle::new(x, y, height).solid_angle();
            let sum = solid_angle(x, y, height);
            assert!((seen - sum).abs() < 1e-13, "{x:?} {y:?}: {seen}, {sum}");
        }
    }

    #[test]
    fn points_leave_the_share_of_the_solid_angle_that_was_asked_for() {
        for (x, y, height) in SEEN {
            let whole = SphericalRectangle::new(x, y, height);
            for i in 0..=20 {
                for j in 0..=20 {
                    let u = DVec2::new(f64::from(i), f64::from(j)) / 20.0;
                    let shares = whole.sample(u);
                    let at_x = x[0] + shares.x * (x[1] - x[0]);
                    let left = solid_angle([x[0], at_x], y, height) / whole.solid_angle();
                    // Of a narrow strip around x, what is below y.
                    let at_y = y[0] + shares.y * (y[1] - y[0]);
                    let far = hypotenuse(at_x, height);
                    let [low, high, at] = [y[0], y[1], at_y].map(|y| y / hypotenuse(y, far));
                    let below = (at - low) / (high - low);
                    let off = (DVec2::new(left, below) - u).abs().max_element();
                    assert!(
                        off < 1e-6,
                        "{x:?} {y:?} from {height}: {u} leaves {left}, {below}"
                    );
                }
            }
        }
    }
}

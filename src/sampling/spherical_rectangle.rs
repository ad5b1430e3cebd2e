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
    /// [`Self::strip`] at the lesser x.
    start: f64,
    solid_angle: f64,
}

impl SphericalRectangle {
    /// The rectangle of the ranges `x` and `y`, seen from `height` above 0 over its plane.
    #[inline(always)]
    pub fn new(x: [f64; 2], y: [f64; 2], height: f64) -> Self {
        let start = strip(x[0], y, height);
        Self {
            x,
            y,
            height,
            start,
            solid_angle: strip(x[1], y, height) - start,
        }
    }

    /// In steradians, at least 0; its inverse is the density of [`Self::sample`].
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle.max(0.0)
    }

    /// A point of the rectangle, uniform in solid angle, as shares of its ranges.
    #[inline(always)]
    pub fn sample(&self, u2: DVec2) -> DVec2 {
        let Self { x, y, height, .. } = *self;
        // The strip that ends at x and holds the share u of the solid angle. With b_i the sines of the elevations of
        // both y over the plane x = 0 and c that of x, it is asin(c b_1) - asin(c b_0). Solved for c, that is the sine of
        // the angle over the root of `spread`; x over the height is the tangent of c's elevation.
        let angle = self.start + u2.x * self.solid_angle;
        let (sin, cos) = (0.5 * angle).sin_cos();
        let [b0, b1] = y.map(|y| y / hypotenuse(y, height));
        let spread = (b1 - b0) * (b1 - b0) + 4.0 * b0 * b1 * sin * sin;
        let sine = 2.0 * sin * cos;
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

/// The solid angle of the strip between 0 and `x`, negative where `x` is: a difference of two arcs' tangents, as the
/// argument of one complex product.
fn strip(x: f64, y: [f64; 2], height: f64) -> f64 {
    let [r0, r1] = y.map(|y| (x * x + y * y + height * height).sqrt());
    let sin = height * x * (y[1] * r0 - y[0] * r1);
    sin.atan2(height * height * r0 * r1 + x * x * y[0] * y[1])
}

use glam::{DVec2, DVec3};

/// A triangle as it is seen from a point, for drawing directions uniformly from the solid angle that it subtends
/// (Arvo 1995, "Stratified Sampling of Spherical Triangles").
///
/// Its rounding is about 1e-16 over the square of the solid angle, and as much over that of what is missing to a
/// hemisphere.
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    /// Unit vectors to the corners.
    corners: [DVec3; 3],
    /// Of these three, without its sign.
    triple_product: f64,
    solid_angle: f64,
}

impl SphericalTriangle {
    /// The triangle of `corners` as seen from the origin, none of which is there.
    pub fn new(corners: [DVec3; 3]) -> Self {
        let corners = corners.map(DVec3::normalize);
        let [a, b, c] = corners;
        let triple_product = a.dot(b.cross(c)).abs();
        Self {
            corners,
            triple_product,
            // Van Oosterom and Strackee 1983.
            solid_angle: 2.0 * triple_product.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a)),
        }
    }

    /// In steradians, at least 0; its inverse is the density of [`Self::sample`].
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A unit vector within the triangle, uniform in solid angle.
    pub fn sample(&self, u2: DVec2) -> DVec3 {
        let [a, b, c] = self.corners;
        // The angle at corner a.
        let (ab, ac) = (a.cross(b), a.cross(c));
        let scale = ab.length() * ac.length();
        let (sin_a, cos_a) = (self.triple_product / scale, ab.dot(ac) / scale);
        // The corner on the arc from a to c with which a and b hold the share u of the solid angle.
        let (sin, cos) = (u2.x * self.solid_angle).sin_cos();
        let s = sin * cos_a - cos * sin_a;
        let t = cos * cos_a + sin * sin_a;
        let (u, v) = (t - cos_a, s + sin_a * a.dot(b));
        let q = ((v * t - u * s) * cos_a - v) / ((v * s + u * t) * sin_a);
        let corner = on_arc(a, c, q.clamp(-1.0, 1.0));
        // And a point on the arc from b to there.
        on_arc(b, corner, 1.0 - u2.y * (1.0 - corner.dot(b)))
    }
}

/// The point of the arc from `from` towards `to` at an angle of the given cosine.
fn on_arc(from: DVec3, to: DVec3, cos: f64) -> DVec3 {
    let across = (to - to.dot(from) * from).normalize_or_zero();
    cos * from + ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt() * across
}

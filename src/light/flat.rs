use glam::DVec3;

/// Steradians below which directions are not drawn from a solid angle: rounding would show, and area does as well.
pub(super) const SMALL: f64 = 1e-4;

/// What triangles and parallelograms have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Flat {
    /// Unit normal.
    n: DVec3,
    area: f64,
    /// The square of how far from the middle directions are drawn from the solid angle.
    near2: f64,
}

impl Flat {
    /// From two edges at a corner, of which the area is `part`.
    pub(super) fn new([x, y]: [DVec3; 2], part: f64) -> Self {
        let cross = x.cross(y);
        Self {
            n: cross.normalize(),
            area: part * cross.length(),
            near2: 2.0 * (x.length_squared() + y.length_squared()),
        }
    }

    /// The same, drawn from by area alone.
    pub(super) fn never_near(self) -> Self {
        Self { near2: 0.0, ..self }
    }

    pub(super) fn area(&self) -> f64 {
        self.area
    }

    /// The normal on the side of a viewer to whom some point of the plane is at `to`; `None` from less than `error` off
    /// the plane, where nothing is seen.
    pub(super) fn normal_towards(&self, to: DVec3, error: f64) -> Option<DVec3> {
        let height = -self.n.dot(to);
        (height.abs() > error).then(|| self.n * height.signum())
    }

    /// Density per solid angle, of a point at `to` that was drawn uniformly from the area.
    pub(super) fn pdf(&self, to: DVec3) -> f64 {
        let d2 = to.length_squared();
        d2 * d2.sqrt() / (self.area * self.n.dot(to).abs())
    }

    /// Whether a viewer, to whom the middle is at `to`, is so near that the density by area varies. From farther away
    /// drawing from the solid angle gains less variance than it takes time, as the Cornell box has it.
    pub(super) fn is_near(&self, to: DVec3) -> bool {
        to.length_squared() < self.near2
    }
}

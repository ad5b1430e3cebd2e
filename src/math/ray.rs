use glam::DVec3;

/// A half-open piece of a line: the points `origin + t direction` with `tmin < t < tmax`.
///
/// `direction` need not be of unit length; `t` is in its units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Where `t` is 0.
    pub origin: DVec3,
    /// Any length but zero.
    pub direction: DVec3,
    /// Hits at or before this are ignored; at least 0.
    pub tmin: f64,
    /// Hits at or beyond this are ignored.
    pub tmax: f64,
}

impl Ray {
    /// The whole half line in front of `origin`.
    pub const fn new(origin: DVec3, direction: DVec3) -> Self {
        Self {
            origin,
            direction,
            tmin: 0.0,
            tmax: f64::INFINITY,
        }
    }

    /// With every number rounded to f32: what engines that compute in f32 can be asked exactly.
    #[must_use]
    pub fn rounded(&self) -> Self {
        Self {
            origin: self.origin.as_vec3().as_dvec3(),
            direction: self.direction.as_vec3().as_dvec3(),
            tmin: f64::from(self.tmin as f32),
            tmax: f64::from(self.tmax as f32),
        }
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

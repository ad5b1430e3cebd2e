//! What the solids are, as functions of a point.

use glam::DVec3;
use solidtrace::geometry::Solid;

/// Negative inside, positive outside, and near the surface about as large as the distance to it; `p` is in the
/// solid's own space.
pub fn outside(solid: &Solid, p: DVec3) -> f64 {
    let rho = p.x.hypot(p.y);
    match *solid {
        Solid::Sphere { radius } => p.length() - radius,
        Solid::Box { half } => (p.abs() - half).max_element(),
        Solid::Cylinder { radius, height } => (rho - radius).max(-p.z).max(p.z - height),
        Solid::Cone {
            from_radius,
            to_radius,
            height,
        } => {
            let radius = from_radius + (to_radius - from_radius) * p.z / height;
            (rho - radius).max(-p.z).max(p.z - height)
        }
        Solid::Torus { major, minor } => (rho - major).hypot(p.z) - minor,
        Solid::Plane => p.z,
        Solid::Rectangle { .. } | Solid::Disk { .. } => unreachable!("no inside"),
    }
}

//! Perfect reflection.

use glam::Vec3;

/// `wo` mirrored at the normal.
pub(super) fn reflect(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}

use glam::Vec3;

/// An orthonormal right-handed basis around a unit normal; shading happens in it, with z along the normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// The normal.
    pub z: Vec3,
}

impl Frame {
    /// A frame whose z is the unit vector `normal` (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
    pub fn around(normal: Vec3) -> Self {
        let sign = 1.0_f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            x: Vec3::new(
                1.0 + sign * normal.x * normal.x * a,
                sign * b,
                -sign * normal.x,
            ),
            y: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            z: normal,
        }
    }

    /// A frame whose z is the unit vector `normal` and whose x lies as `tangent` does, as far as it can.
    pub fn along(normal: Vec3, tangent: Vec3) -> Self {
        let flat = tangent - normal.dot(tangent) * normal;
        match flat.try_normalize() {
            Some(x) => Self {
                x,
                y: normal.cross(x),
                z: normal,
            },
            None => Self::around(normal),
        }
    }

    /// World direction to frame coordinates.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// Frame coordinates to world direction.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        v.x * self.x + v.y * self.y + v.z * self.z
    }
}

use glam::{DAffine3, DMat3, DVec3};

use super::{Bounds, Ray};

/// An invertible affine map in f64, kept with its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    forward: DAffine3,
    inverse: DAffine3,
    /// Whether it shifts and does nothing else, which is less work, with the same bits.
    shift: bool,
    /// [`Self::max_stretch`].
    stretch: f64,
}

impl Transform {
    /// Leaves every point where it is.
    pub const IDENTITY: Self = Self {
        forward: DAffine3::IDENTITY,
        inverse: DAffine3::IDENTITY,
        shift: true,
        // The root of 3.
        stretch: 1.732_050_807_568_877_2,
    };

    /// The map `matrix`, or `None` where it is not finite or flattens space.
    pub fn new(matrix: DAffine3) -> Option<Self> {
        if !matrix.is_finite() {
            return None;
        }
        let inverse = matrix.inverse();
        let scale = matrix.matrix3.x_axis.length()
            * matrix.matrix3.y_axis.length()
            * matrix.matrix3.z_axis.length();
        // Columns that are dependent to within rounding have no usable inverse.
        let flat = matrix.matrix3.determinant().abs() <= 1e-14 * scale;
        (inverse.is_finite() && !flat).then(|| Self::of_parts(matrix, inverse))
    }

    /// Rotation by the orthonormal `axes` (columns), then translation to `origin`.
    pub fn rigid(axes: DMat3, origin: DVec3) -> Self {
        let back = axes.transpose();
        Self::of_parts(
            DAffine3::from_mat3_translation(axes, origin),
            DAffine3::from_mat3_translation(back, -(back * origin)),
        )
    }

    /// From a map and its inverse, which the caller vouches for.
    pub(crate) fn of_parts(forward: DAffine3, inverse: DAffine3) -> Self {
        Self {
            forward,
            inverse,
            shift: [forward, inverse].map(|map| map.matrix3) == [DMat3::IDENTITY; 2],
            stretch: stretch(&forward),
        }
    }

    /// First `other`, then this.
    #[must_use]
    pub fn after(&self, other: &Self) -> Self {
        Self::of_parts(self.forward * other.forward, other.inverse * self.inverse)
    }

    /// The map back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self {
            forward: self.inverse,
            inverse: self.forward,
            shift: self.shift,
            stretch: stretch(&self.inverse),
        }
    }

    /// The forward matrix.
    pub fn matrix(&self) -> &DAffine3 {
        &self.forward
    }

    /// The inverse matrix.
    pub fn inverse_matrix(&self) -> &DAffine3 {
        &self.inverse
    }

    /// Whether it leaves every point where it is, to the bit.
    pub fn is_identity(&self) -> bool {
        self.forward == DAffine3::IDENTITY
    }

    /// Whether all numbers of it and of its inverse are finite; [`Transform::after`] can overflow.
    pub fn is_finite(&self) -> bool {
        self.forward.is_finite() && self.inverse.is_finite()
    }

    /// Maps a point.
    pub fn point(&self, p: DVec3) -> DVec3 {
        if self.shift {
            p + self.forward.translation
        } else {
            self.forward.transform_point3(p)
        }
    }

    /// Maps a direction; its length changes with the map.
    pub fn vector(&self, v: DVec3) -> DVec3 {
        if self.shift {
            v
        } else {
            self.forward.transform_vector3(v)
        }
    }

    /// Maps a point back.
    pub fn inverse_point(&self, p: DVec3) -> DVec3 {
        if self.shift {
            p + self.inverse.translation
        } else {
            self.inverse.transform_point3(p)
        }
    }

    /// Maps a ray back; `t` means the same on both sides.
    #[inline(always)]
    pub fn inverse_ray(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.inverse_point(ray.origin),
            direction: if self.shift {
                ray.direction
            } else {
                self.inverse.transform_vector3(ray.direction)
            },
            ..*ray
        }
    }

    /// Maps the gradient of a function of space to that of the function moved along.
    pub fn gradient(&self, g: DVec3) -> DVec3 {
        if self.shift {
            g
        } else {
            self.inverse.matrix3.transpose() * g
        }
    }

    /// Maps a surface normal, as a gradient; same side of the surface. Of one of unit length it makes one of unit
    /// length.
    pub fn normal(&self, n: DVec3) -> DVec3 {
        if self.shift {
            n
        } else {
            self.gradient(n).normalize()
        }
    }

    /// The box around the image of `bounds`; all of space stays so.
    pub fn bounds(&self, bounds: &Bounds) -> Bounds {
        if bounds.is_finite() {
            Bounds::of_points(bounds.corners().map(|p| self.point(p)))
        } else {
            *bounds
        }
    }

    /// The greatest factor by which it stretches a length (an upper bound: the Frobenius norm).
    pub fn max_stretch(&self) -> f64 {
        self.stretch
    }

    /// The factor by which it scales every length, or `None` where directions differ.
    pub fn uniform_scale(&self) -> Option<f64> {
        let m = &self.forward.matrix3;
        let gram = m.transpose() * *m;
        let square = gram.x_axis.x;
        let same = gram.abs_diff_eq(DMat3::from_diagonal(DVec3::splat(square)), 1e-9 * square);
        same.then(|| square.sqrt())
    }
}

fn stretch(map: &DAffine3) -> f64 {
    let m = &map.matrix3;
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

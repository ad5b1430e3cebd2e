//! From canonical samples in [0, 1)² to directions and points, each beside its density.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI, TAU};

use glam::{Vec2, Vec3};

/// A point on the unit disk, uniform in area (Shirley and Chiu 1997, concentric map).
#[inline(always)]
pub fn uniform_disk(u2: Vec2) -> Vec2 {
    let p = 2.0 * u2 - Vec2::ONE;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    if p.x.abs() > p.y.abs() {
        let (sin, cos) = sin_cos_octant(FRAC_PI_4 * (p.y / p.x));
        p.x * Vec2::new(cos, sin)
    } else {
        let (sin, cos) = sin_cos_octant(FRAC_PI_4 * (p.x / p.y));
        p.y * Vec2::new(sin, cos)
    }
}

/// Sine and cosine of an angle within ±pi / 4, to within 1.5e-7, by their series.
fn sin_cos_octant(angle: f32) -> (f32, f32) {
    let x = angle * angle;
    let sin = ((1.0 / 362_880.0 * x - 1.0 / 5_040.0) * x + 1.0 / 120.0) * x - 1.0 / 6.0;
    let cos = ((1.0 / 40_320.0 * x - 1.0 / 720.0) * x + 1.0 / 24.0) * x - 0.5;
    (angle + angle * x * sin, 1.0 + x * cos)
}

/// A direction around +z, density cos / pi (Malley's method: the disk projected up).
#[inline(always)]
pub fn cosine_hemisphere(u2: Vec2) -> Vec3 {
    let d = uniform_disk(u2);
    // 1 - |d|² can round to 0 at the rim; a direction in the tangent plane has no density.
    d.extend((1.0 - d.length_squared()).max(1e-12).sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle.
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// A direction, uniform over the sphere.
pub fn uniform_sphere(u2: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u2.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let phi = TAU * u2.y;
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// A direction within a cone around +z, uniform in solid angle. The cone is given by
/// `one_minus_cos` of its half angle, so that narrow cones keep their precision.
pub fn uniform_cone(u2: Vec2, one_minus_cos: f32) -> Vec3 {
    let w = u2.x * one_minus_cos;
    let r = (w * (2.0 - w)).max(0.0).sqrt();
    let phi = TAU * u2.y;
    Vec3::new(r * phi.cos(), r * phi.sin(), 1.0 - w)
}

/// Density of [`uniform_cone`] per solid angle.
pub fn uniform_cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (2.0 * PI * one_minus_cos)
}

/// Barycentric weights of the second and third corner, uniform in area (Heitz 2019, low-distortion map).
pub fn uniform_triangle(u2: Vec2) -> Vec2 {
    if u2.y > u2.x {
        let x = 0.5 * u2.x;
        Vec2::new(x, u2.y - x)
    } else {
        let y = 0.5 * u2.y;
        Vec2::new(u2.x - y, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_cosines_within_an_octant_are_those_of_the_library() {
        for i in -10_000..=10_000 {
            let angle = FRAC_PI_4 * (i as f32 / 10_000.0);
            let (sin, cos) = sin_cos_octant(angle);
            let (true_sin, true_cos) = f64::from(angle).sin_cos();
            let off = (f64::from(sin) - true_sin)
                .abs()
                .max((f64::from(cos) - true_cos).abs());
            assert!(off < 1.5e-7, "{angle}: {sin}, {cos}");
        }
    }
}

use glam::{DVec2, DVec3};

use super::{Span, closest_approach, turn};
use crate::math::{Bounds, Interval, Ray, roots};

/// The solid between the discs of `from_radius` at z = 0 and of `to_radius` at z = `height`: cylinder and cone.
#[derive(Clone, Copy)]
pub(super) struct Frustum {
    pub(super) from_radius: f64,
    pub(super) to_radius: f64,
    pub(super) height: f64,
}

const SIDE: u32 = 0;
const FROM_CAP: u32 = 1;
const TO_CAP: u32 = 2;

impl Frustum {
    /// The slab between the caps, cut with the cone.
    #[inline(always)]
    pub(super) fn spans(self, ray: &Ray) -> Option<Span> {
        let middle = DVec3::new(0.0, 0.0, 0.5 * self.height);
        let (t, p) = closest_approach(ray, middle);
        let d = ray.direction;
        let slab = self.slab(p.z, d.z)?;
        let cone = self.cone(p, d);
        let mut side = cone.interval()?;
        if side.intersection(slab).is_empty() {
            return None;
        }
        if cone.runs_along_a_generator() {
            side.min = cone.polish(side.min, slab.min, side.min <= slab.min);
            side.max = cone.polish(side.max, slab.max, side.max >= slab.max);
        }
        let (bottom, top) = if d.z < 0.0 {
            (TO_CAP, FROM_CAP)
        } else {
            (FROM_CAP, TO_CAP)
        };
        let enter = if slab.min > side.min {
            (slab.min, bottom)
        } else {
            (side.min, SIDE)
        };
        let exit = if slab.max < side.max {
            (slab.max, top)
        } else {
            (side.max, SIDE)
        };
        (enter.0 <= exit.0).then(|| Span::new((t + enter.0, enter.1), (t + exit.0, exit.1)))
    }

    /// Where the line at `z` above the middle lies between the planes of the caps.
    #[inline(always)]
    fn slab(self, z: f64, dz: f64) -> Option<Interval> {
        let half = 0.5 * self.height;
        if dz == 0.0 {
            return (z.abs() <= half).then_some(Interval::ALL);
        }
        let half = half.copysign(dz);
        Some(Interval {
            min: (-half - z) / dz,
            max: (half - z) / dz,
        })
    }

    /// The line `p + s d`, `p` from the middle, beside the cone of the side.
    #[inline(always)]
    fn cone(self, p: DVec3, d: DVec3) -> Cone {
        let half = 0.5 * self.height;
        Cone {
            p: p.truncate(),
            d: d.truncate(),
            // Exact near an apex.
            radius: (self.from_radius * (half - p.z) + self.to_radius * (half + p.z)) / self.height,
            growth: (self.to_radius - self.from_radius) / self.height * d.z,
        }
    }

    pub(super) fn bounds(self) -> Bounds {
        let radius = self.from_radius.max(self.to_radius);
        Bounds {
            min: DVec3::new(-radius, -radius, 0.0),
            max: DVec3::new(radius, radius, self.height),
        }
    }

    pub(super) fn contains(self, p: DVec3) -> bool {
        let radius = (self.from_radius * (self.height - p.z) + self.to_radius * p.z) / self.height;
        p.z >= 0.0 && p.z <= self.height && p.truncate().length_squared() <= radius * radius
    }

    #[inline(always)]
    pub(super) fn normal(self, p: DVec3, face: u32) -> DVec3 {
        match face {
            FROM_CAP => DVec3::NEG_Z,
            TO_CAP => DVec3::Z,
            _ if self.from_radius == self.to_radius => {
                p.truncate().normalize_or(DVec2::X).extend(0.0)
            }
            _ => {
                let out = self.height * p.truncate().normalize_or(DVec2::X);
                out.extend(self.from_radius - self.to_radius).normalize()
            }
        }
    }

    /// Around the axis; and up the side, or from the middle of a cap to its rim.
    pub(super) fn uv(self, p: DVec3, face: u32) -> DVec2 {
        let v = match face {
            SIDE => p.z / self.height,
            _ => p.truncate().length() / self.cap(face).0.max(f64::MIN_POSITIVE),
        };
        DVec2::new(turn(p.truncate()), v.clamp(0.0, 1.0))
    }

    pub(super) fn project(self, p: DVec3, face: u32) -> DVec3 {
        let (radius, z) = if face == SIDE {
            // The closest point of the side's profile, a segment in the half-plane (radius, z).
            let profile = DVec2::new(self.to_radius - self.from_radius, self.height);
            let from = DVec2::new(p.truncate().length() - self.from_radius, p.z);
            let along = (from.dot(profile) / profile.length_squared()).clamp(0.0, 1.0);
            (
                (1.0 - along) * self.from_radius + along * self.to_radius,
                along * self.height,
            )
        } else {
            let (radius, z) = self.cap(face);
            (radius.min(p.truncate().length()), z)
        };
        (radius * p.truncate().normalize_or(DVec2::X)).extend(z)
    }

    /// Radius and height of a cap.
    fn cap(self, face: u32) -> (f64, f64) {
        if face == TO_CAP {
            (self.to_radius, self.height)
        } else {
            (self.from_radius, 0.0)
        }
    }
}

/// A line `p + s d`, seen along the axis, and the cone's radius `radius + s growth` at its height.
struct Cone {
    p: DVec2,
    d: DVec2,
    radius: f64,
    growth: f64,
}

impl Cone {
    /// Half the second derivative of [`Self::implicit`].
    #[inline(always)]
    fn bend(&self) -> f64 {
        self.d.length_squared() - self.growth * self.growth
    }

    /// `|p + s d|^2 - (radius + s growth)^2`, and its derivative.
    fn implicit(&self, s: f64) -> (f64, f64) {
        let (p, radius) = (self.p + s * self.d, self.radius + s * self.growth);
        (
            p.length_squared() - radius * radius,
            2.0 * (p.dot(self.d) - radius * self.growth),
        )
    }

    /// Where the line is in the cone, on the nappe that holds the solid (on the other one it may say what
    /// it likes: the slab is not there).
    #[inline(always)]
    fn interval(&self) -> Option<Interval> {
        let &Self {
            p,
            d,
            radius,
            growth,
        } = self;
        // The implicit function is a s^2 + 2 b s + c.
        let a = self.bend();
        let b = p.dot(d) - radius * growth;
        let c = p.length_squared() - radius * radius;
        if a == 0.0 && b == 0.0 {
            return (c <= 0.0).then_some(Interval::ALL);
        }
        // By Lagrange's identity b^2 - a c = m^2 - x^2; the smaller pair loses less to cancellation.
        // The second is the smaller one where the line passes close to the apex.
        let m2 = (radius * d - growth * p).length_squared();
        let x = p.perp_dot(d);
        let discriminant = if b * b <= m2 + x * x {
            b * b - a * c
        } else {
            (m2.sqrt() - x) * (m2.sqrt() + x)
        };
        if a >= 0.0 && discriminant < 0.0 {
            return None;
        }
        let (min, max) = roots::quadratic(a, b, c, discriminant.max(0.0));
        Some(if a >= 0.0 {
            Interval { min, max }
        } else if growth > 0.0 {
            // The line runs inside both nappes; the solid's is the one toward growing radius.
            Interval {
                min: max,
                ..Interval::ALL
            }
        } else {
            Interval {
                max: min,
                ..Interval::ALL
            }
        })
    }

    /// Whether the bend is a difference of nearly equal numbers; and so inexact is the root that divides
    /// by it.
    fn runs_along_a_generator(&self) -> bool {
        self.bend().abs() < 0.25 * self.growth * self.growth
    }

    /// Improves the root `s`, or leaves it alone where it is behind a cap and the cap inside the cone.
    fn polish(&self, s: f64, cap: f64, behind_cap: bool) -> f64 {
        if behind_cap && self.implicit(cap).0 <= 0.0 {
            return s;
        }
        let start = if behind_cap { cap } else { s };
        roots::polish(start, |s| self.implicit(s))
    }
}

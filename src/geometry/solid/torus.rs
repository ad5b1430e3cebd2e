use glam::{DVec2, DVec3};

use super::{Span, Spans, closest_approach, turn};
use crate::math::roots::{self, Tolerance};
use crate::math::{Bounds, Interval, Ray};

/// The tube of radius `minor` around the circle of radius `major` in the plane z = 0.
#[derive(Clone, Copy)]
pub(super) struct Torus {
    pub(super) major: f64,
    pub(super) minor: f64,
}

impl Torus {
    /// Between neighbouring stationary points of the quartic there is at most one root, and a change of
    /// sign shows it. Signs and roots come from the implicit function, which stays accurate where the
    /// quartic's coefficients do not; since both ends of the line count as outside, roots come in pairs.
    pub(super) fn spans(self, ray: &Ray) -> Spans {
        let (t, p) = closest_approach(ray, DVec3::ZERO);
        let speed = ray.direction.length();
        let u = ray.direction / speed;
        let Some(range) = self.clip(p, u) else {
            return Spans::default();
        };
        let f = |s: f64| self.implicit(p, u, s);
        let tolerance = self.tolerance();
        let cross = |outside: Station, inside: Station| {
            // The parabola with its vertex inside; exact enough that Newton needs a step or two.
            let part = (inside.value / (inside.value - outside.value.max(0.0))).sqrt();
            let guess = inside.s + part * (outside.s - inside.s);
            let s = roots::bracketed(outside.s, inside.s, guess, tolerance, f);
            t + s / speed
        };
        let station = |s: f64| Station { s, value: f(s).0 };

        let mut spans = Spans::default();
        let mut last = station(range.min);
        let mut enter = None;
        for s in self.stationary(p, u) {
            if !(s > range.min && s < range.max) {
                continue;
            }
            let next = station(s);
            match enter {
                None if next.value <= 0.0 => enter = Some(cross(last, next)),
                Some(t) if next.value > 0.0 => {
                    spans.push(Span::new((t, 0), (cross(next, last), 0)));
                    enter = None;
                }
                _ => {}
            }
            last = next;
        }
        if let Some(t) = enter {
            spans.push(Span::new((t, 0), (cross(station(range.max), last), 0)));
        }
        spans
    }

    /// The part of the line in the bounding sphere and slab, or `None` when that misses the torus or runs
    /// through its hole. `p` is the closest approach to the centre, `u` a unit vector.
    fn clip(self, p: DVec3, u: DVec3) -> Option<Interval> {
        let outer = self.major + self.minor;
        let room = outer * outer - p.length_squared();
        if room < 0.0 {
            return None;
        }
        let half = room.sqrt();
        let mut range = Interval {
            min: -half,
            max: half,
        };
        if u.z != 0.0 {
            let tube = self.minor.copysign(u.z);
            range = range.intersection(Interval {
                min: (-tube - p.z) / u.z,
                max: (tube - p.z) / u.z,
            });
        } else if p.z.abs() > self.minor {
            return None;
        }
        let hole = self.major - self.minor;
        let in_hole = |s: f64| (p + s * u).truncate().length_squared() < hole * hole;
        let misses = range.is_empty() || in_hole(range.min) && in_hole(range.max);
        (!misses).then_some(range)
    }

    /// Where the derivative of `(|p + s u|^2 + R^2 - r^2)^2 - 4 R^2 rho^2` vanishes. From the closest
    /// approach the quartic has no cubic term.
    fn stationary(self, p: DVec3, u: DVec3) -> [f64; 3] {
        let square = self.major * self.major;
        let reach = p.length_squared() + (self.major - self.minor) * (self.major + self.minor);
        let (p, u) = (p.truncate(), u.truncate());
        roots::depressed_cubic(
            reach - 2.0 * square * u.length_squared(),
            -2.0 * square * p.dot(u),
        )
    }

    /// Squared distance from the centre circle less `minor` squared, at `p + s u`; and Newton's step, value over slope.
    fn implicit(self, p: DVec3, u: DVec3, s: f64) -> (f64, f64) {
        let q = p + s * u;
        let rho = q.truncate().length();
        let off = rho - self.major;
        let value = off * off + (q.z - self.minor) * (q.z + self.minor);
        let slope_rho = 2.0 * (off * q.truncate().dot(u.truncate()) + rho * q.z * u.z);
        (value, value * rho / slope_rho)
    }

    /// A few ulps of the torus's size from the surface, where the gradient is twice `minor`; and the step
    /// after which the second derivative, at most `2 R / (R - r)` in the tube, leaves no more than that.
    fn tolerance(self) -> Tolerance {
        let value = 2.0 * self.minor * f64::EPSILON * (self.major + self.minor);
        Tolerance {
            value,
            step: (value * (1.0 - self.minor / self.major)).sqrt(),
        }
    }

    /// From the closest point of the centre circle to `p`.
    fn spoke(self, p: DVec3) -> DVec3 {
        let flat = p.truncate();
        (flat - self.major * flat.normalize_or(DVec2::X)).extend(p.z)
    }

    pub(super) fn bounds(self) -> Bounds {
        let outer = self.major + self.minor;
        Bounds::symmetric(DVec3::new(outer, outer, self.minor))
    }

    pub(super) fn contains(self, p: DVec3) -> bool {
        self.implicit(p, DVec3::ZERO, 0.0).0 <= 0.0
    }

    pub(super) fn normal(self, p: DVec3, _face: u32) -> DVec3 {
        self.spoke(p).normalize_or(DVec3::Z)
    }

    pub(super) fn uv(self, p: DVec3, _face: u32) -> DVec2 {
        let flat = p.truncate();
        let around_tube = DVec2::new(flat.length() - self.major, p.z);
        DVec2::new(turn(flat), turn(around_tube))
    }

    pub(super) fn project(self, p: DVec3, face: u32) -> DVec3 {
        p - self.spoke(p) + self.minor * self.normal(p, face)
    }
}

/// A parameter on the line and the implicit function there.
#[derive(Clone, Copy)]
struct Station {
    s: f64,
    value: f64,
}

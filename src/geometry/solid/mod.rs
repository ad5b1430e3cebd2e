//! Exact analytic solids in f64, each in a canonical position; a transform places it in the world.

mod cuboid;
mod flat;
mod frustum;
mod plane;
mod sphere;
mod torus;

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::math::{Bounds, Ray};
use cuboid::Cuboid;
use flat::{Disk, Rectangle};
use frustum::Frustum;
use plane::Plane;
use sphere::Sphere;
use torus::Torus;

/// A closed solid, the half-space of a plane, or a piece of a plane, in its canonical position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// Centred at the origin.
    Sphere {
        /// Above 0.
        radius: f64,
    },
    /// Centred at the origin, edges along the axes.
    Box {
        /// Half the edge lengths, each above 0.
        half: DVec3,
    },
    /// Around the z axis from z = 0 to z = `height`, with both caps.
    Cylinder {
        /// Above 0.
        radius: f64,
        /// Above 0.
        height: f64,
    },
    /// Around the z axis from z = 0 to z = `height`, with its caps; a radius of 0 makes a point.
    Cone {
        /// At z = 0; at least 0, and not both 0.
        from_radius: f64,
        /// At z = `height`; at least 0.
        to_radius: f64,
        /// Above 0.
        height: f64,
    },
    /// Around the z axis, centred at the origin.
    Torus {
        /// Distance from the centre to the tube's centre line.
        major: f64,
        /// Radius of the tube, above 0 and less than `major`.
        minor: f64,
    },
    /// The plane z = 0 with its normal along +z; as a solid, the half-space z <= 0.
    Plane,
    /// In the plane z = 0 with its normal along +z, centred at the origin, edges along x and y; it has no inside.
    Rectangle {
        /// Half the edge lengths, each above 0.
        half: DVec2,
    },
    /// In the plane z = 0 with its normal along +z, centred at the origin; it has no inside.
    Disk {
        /// Above 0.
        radius: f64,
    },
}

/// One crossing of a ray's line with a solid's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Ray parameter; infinite where a half-space has no end.
    pub t: f64,
    /// Which face: box 0..6 as -x +x -y +y -z +z; cylinder and cone 0 side, 1 cap at z = 0, 2 cap at `height`; else 0.
    pub face: u32,
}

/// A closed piece of a ray's line inside a solid: `enter.t <= exit.t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Where the line comes in.
    pub enter: Crossing,
    /// Where it leaves.
    pub exit: Crossing,
}

/// The at most two spans of one line in a solid, in order, disjoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spans([Option<Span>; 2]);

impl Spans {
    /// The spans, nearest first.
    pub fn iter(&self) -> impl Iterator<Item = &Span> {
        self.0.iter().flatten()
    }

    /// Adds the next span; where rounding let it touch the one before, the two become one.
    fn push(&mut self, span: Span) {
        match &mut self.0 {
            [Some(last), _] if last.exit.t >= span.enter.t => last.exit = span.exit,
            [Some(_), second] => *second = Some(span),
            [first, _] => *first = Some(span),
        }
    }
}

impl From<Option<Span>> for Spans {
    fn from(span: Option<Span>) -> Self {
        Self([span, None])
    }
}

impl Span {
    /// From the parameters and faces of both ends.
    fn new((enter, enter_face): (f64, u32), (exit, exit_face): (f64, u32)) -> Self {
        Self {
            enter: Crossing {
                t: enter,
                face: enter_face,
            },
            exit: Crossing {
                t: exit,
                face: exit_face,
            },
        }
    }
}

/// Calls a method of the solid's own type.
macro_rules! dispatch {
    ($solid:expr, $shape:ident => $call:expr) => {
        match *$solid {
            Solid::Sphere { radius } => {
                let $shape = Sphere { radius };
                $call
            }
            Solid::Box { half } => {
                let $shape = Cuboid { half };
                $call
            }
            Solid::Cylinder { radius, height } => {
                let $shape = Frustum {
                    from_radius: radius,
                    to_radius: radius,
                    height,
                };
                $call
            }
            Solid::Cone {
                from_radius,
                to_radius,
                height,
            } => {
                let $shape = Frustum {
                    from_radius,
                    to_radius,
                    height,
                };
                $call
            }
            Solid::Torus { major, minor } => {
                let $shape = Torus { major, minor };
                $call
            }
            Solid::Plane => {
                let $shape = Plane;
                $call
            }
            Solid::Rectangle { half } => {
                let $shape = Rectangle { half };
                $call
            }
            Solid::Disk { radius } => {
                let $shape = Disk { radius };
                $call
            }
        }
    };
}

impl Solid {
    /// All spans of the whole line of `ray` (its `tmin` and `tmax` play no part).
    ///
    /// A point `origin + t direction` of a finite crossing lies on its face to within
    /// `8 f64::EPSILON (|origin| + size)`, `size` being the greatest distance of the solid's points from the
    /// origin of its own frame (0 for a plane), for directions of any length whose square neither overflows
    /// nor underflows. So does a span's inside lie inside; what reaches no deeper, where a line grazes the
    /// surface, may be there or not, but never as an odd crossing. A line in the plane of a flat face counts
    /// as inside.
    ///
    /// Of a rectangle or disk it is the half-space behind its plane where the line goes through it, so that the finite end
    /// of the span is where the line meets it.
    #[expect(
        clippy::useless_conversion,
        reason = "a torus gives spans, the convex solids one at most"
    )]
    #[inline(always)]
    pub fn spans(&self, ray: &Ray) -> Spans {
        dispatch!(self, shape => shape.spans(ray).into())
    }

    /// Whether it stands in the world as a surface, which has two sides but no inside. As an operand of CSG a plane is a
    /// half-space; the others are none.
    pub fn is_surface(&self) -> bool {
        matches!(
            self,
            Self::Plane | Self::Rectangle { .. } | Self::Disk { .. }
        )
    }

    /// The first crossing with `tmin < t < tmax`, and whether the ray comes to it from inside.
    #[inline(always)]
    pub fn closest(&self, ray: &Ray) -> Option<(Crossing, bool)> {
        // Walls are most of what solids are used for.
        match *self {
            Self::Box { half } => first(Cuboid { half }.spans(ray).as_ref(), ray),
            _ => self.closest_of_any(ray),
        }
    }

    /// Whether [`Self::closest`] has nothing to find, as far as that is known at once: of boxes, which a ray may be past.
    #[inline(always)]
    pub fn is_behind(&self, ray: &Ray) -> bool {
        match *self {
            Self::Box { half } => Cuboid { half }.is_behind(ray),
            _ => false,
        }
    }

    #[inline(never)]
    fn closest_of_any(&self, ray: &Ray) -> Option<(Crossing, bool)> {
        first(self.spans(ray).iter(), ray)
    }

    /// The box around it; all of space below z = 0 for a plane.
    pub fn bounds(&self) -> Bounds {
        dispatch!(self, shape => shape.bounds())
    }

    /// Whether `p` lies inside or on the surface.
    pub fn contains(&self, p: DVec3) -> bool {
        dispatch!(self, shape => shape.contains(p))
    }

    /// The outward unit normal at the surface point `p` of `face`.
    #[inline(always)]
    pub fn normal(&self, p: DVec3, face: u32) -> DVec3 {
        dispatch!(self, shape => shape.normal(p, face))
    }

    /// Surface coordinates of `p` on `face`, both in 0..=1 where the surface is bounded.
    pub fn uv(&self, p: DVec3, face: u32) -> DVec2 {
        dispatch!(self, shape => shape.uv(p, face))
    }

    /// The gradients of u and v along the surface at `p` on `face`, by central differences: a few digits less than f64
    /// has. They grow without bound towards points around which u turns.
    pub fn uv_gradients(&self, p: DVec3, face: u32) -> [DVec3; 2] {
        let size = match self {
            Self::Plane => 1.0,
            Self::Rectangle { half } => 2.0 * half.min_element(),
            Self::Disk { radius } => 2.0 * radius,
            _ => self.bounds().size().min_element(),
        };
        let step = 1e-6 * size;
        let uv = |p: DVec3| self.uv(self.project(p, face), face);
        let rate = |t: DVec3| {
            let difference = uv(p + step * t) - uv(p - step * t);
            // One turn ends where the next begins.
            (difference - difference.round()) / (2.0 * step)
        };
        let (x, y) = self.normal(p, face).any_orthonormal_pair();
        let (along_x, along_y) = (rate(x), rate(y));
        [along_x.x * x + along_y.x * y, along_x.y * x + along_y.y * y]
    }

    /// Moves `p`, near the surface of `face`, onto it, to within a few ulps of the solid's size.
    pub fn project(&self, p: DVec3, face: u32) -> DVec3 {
        dispatch!(self, shape => shape.project(p, face))
    }
}

/// The first end of ordered spans with `tmin < t < tmax`, and whether it is where one is left.
#[inline(always)]
fn first<'a>(spans: impl IntoIterator<Item = &'a Span>, ray: &Ray) -> Option<(Crossing, bool)> {
    spans.into_iter().find_map(|span| {
        let inside = span.enter.t <= ray.tmin;
        let crossing = if inside { span.exit } else { span.enter };
        (crossing.t > ray.tmin && crossing.t < ray.tmax).then_some((crossing, inside))
    })
}

/// Parameter of the point of the ray's line that is closest to `center`, and that point seen from there.
///
/// Solving from here keeps the error at a few ulps of the distance to the ray's origin; from the origin
/// itself it would grow with the distance's square.
#[inline(always)]
fn closest_approach(ray: &Ray, center: DVec3) -> (f64, DVec3) {
    let o = ray.origin - center;
    let t = -o.dot(ray.direction) / ray.direction.length_squared();
    (t, o + t * ray.direction)
}

/// The angle of `v` around the origin as a fraction of a full turn from +x, in 0..=1.
fn turn(v: DVec2) -> f64 {
    let turn = v.y.atan2(v.x) / TAU;
    if turn < 0.0 { turn + 1.0 } else { turn }
}

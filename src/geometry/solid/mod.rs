//! Exact analytic solids in f64, each in a canonical position; a transform places it in the world.

use glam::{DVec2, DVec3};

use crate::math::{Bounds, Ray};

/// A closed solid, or the half-space of a plane, in its canonical position.
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
}

impl Solid {
    /// All spans of the whole line of `ray` (its `tmin` and `tmax` play no part).
    pub fn spans(&self, _ray: &Ray) -> Spans {
        todo!()
    }

    /// The first crossing with `tmin < t < tmax`.
    pub fn closest(&self, ray: &Ray) -> Option<Crossing> {
        (self.spans(ray).iter())
            .flat_map(|span| [span.enter, span.exit])
            .find(|c| c.t > ray.tmin && c.t < ray.tmax)
    }

    /// The box around it; all of space below z = 0 for a plane.
    pub fn bounds(&self) -> Bounds {
        todo!()
    }

    /// Whether `p` lies inside or on the surface.
    pub fn contains(&self, _p: DVec3) -> bool {
        todo!()
    }

    /// The outward unit normal at the surface point `p` of `face`.
    pub fn normal(&self, _p: DVec3, _face: u32) -> DVec3 {
        todo!()
    }

    /// Surface coordinates of `p` on `face`, both in 0..=1 where the surface is bounded.
    pub fn uv(&self, _p: DVec3, _face: u32) -> DVec2 {
        todo!()
    }

    /// Moves `p`, near the surface of `face`, onto it, to within a few ulps of the solid's size.
    pub fn project(&self, _p: DVec3, _face: u32) -> DVec3 {
        todo!()
    }
}

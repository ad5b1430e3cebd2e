use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::geometry::Solid;
use crate::math::Frame;
use crate::math::roots::{self, Tolerance};
use crate::sampling::{uniform_cone, uniform_disk};

/// A piece of a solid's surface from which points can be drawn, uniform in area.
#[derive(Clone, Copy)]
pub(super) enum Patch {
    /// A disk around the z axis.
    Disk { radius: f64, z: f64 },
    /// Of the side of a cylinder or cone around the z axis what lies within the angle `half` of the azimuth `middle`.
    Side {
        radii: [f64; 2],
        height: f64,
        middle: f64,
        half: f64,
    },
    /// Of a sphere what is seen under an angle from `axis` whose cosine is 1 less `depth`.
    Cap {
        radius: f64,
        axis: DVec3,
        depth: f64,
    },
    /// A torus.
    Tube { major: f64, minor: f64 },
}

/// The patches of a solid with the faces that they are on, where they are in view.
pub(super) type Patches = [Option<(u32, Patch)>; 3];

/// What is in view of a solid other than a box, rectangle or plane: from a point outside what is not beyond its own
/// horizon, as far as that is simple; from inside, or where there is no viewer, everything.
pub(super) fn patches(solid: Solid, viewer: Option<DVec3>) -> Patches {
    let outside = viewer.filter(|&viewer| !solid.contains(viewer));
    let only = |patch| [Some((0, patch)), None, None];
    match solid {
        Solid::Disk { radius } => only(Patch::Disk { radius, z: 0.0 }),
        Solid::Torus { major, minor } => only(Patch::Tube { major, minor }),
        Solid::Sphere { radius } => only(match outside {
            None => Patch::Cap {
                radius,
                axis: DVec3::Z,
                depth: 2.0,
            },
            Some(viewer) => Patch::Cap {
                radius,
                axis: viewer.normalize(),
                depth: 1.0 - radius / viewer.length(),
            },
        }),
        Solid::Cylinder { radius, height } => frustum([radius; 2], height, outside),
        Solid::Cone {
            from_radius,
            to_radius,
            height,
        } => frustum([from_radius, to_radius], height, outside),
        Solid::Box { .. } | Solid::Rectangle { .. } | Solid::Plane => [None; 3],
    }
}

fn frustum(radii: [f64; 2], height: f64, outside: Option<DVec3>) -> Patches {
    let [from, to] = radii;
    let (middle, half) = outside.map_or((0.0, PI), |viewer| {
        // The tangent planes through the viewer touch where its distance from the axis, towards there, is the radius at
        // its height.
        let radius = from + (to - from) * viewer.z / height;
        let cos = radius / viewer.truncate().length();
        (viewer.y.atan2(viewer.x), cos.clamp(-1.0, 1.0).acos())
    });
    let side = Patch::Side {
        radii,
        height,
        middle,
        half,
    };
    let cap = |radius, z, seen: bool| (radius > 0.0 && seen).then_some(Patch::Disk { radius, z });
    [
        (half > 0.0).then_some((0, side)),
        cap(from, 0.0, outside.is_none_or(|v| v.z < 0.0)).map(|cap| (1, cap)),
        cap(to, height, outside.is_none_or(|v| v.z > height)).map(|cap| (2, cap)),
    ]
}

impl Patch {
    pub(super) fn area(&self) -> f64 {
        match *self {
            Self::Disk { radius, .. } => PI * radius * radius,
            Self::Side {
                radii: [from, to],
                height,
                half,
                ..
            } => half * (from + to) * height.hypot(to - from),
            Self::Cap { radius, depth, .. } => TAU * depth * radius * radius,
            Self::Tube { major, minor } => TAU * TAU * major * minor,
        }
    }

    /// A point, uniform in area.
    pub(super) fn point(&self, u2: DVec2) -> DVec3 {
        match *self {
            Self::Disk { radius, z } => {
                let flat = uniform_disk(u2.as_vec2()).as_dvec2();
                // In f32 the rim may be a little farther out.
                (radius * flat.clamp_length_max(1.0)).extend(z)
            }
            Self::Side {
                radii: [from, to],
                height,
                middle,
                half,
            } => {
                let radius = (from * from + u2.x * (to * to - from * from)).sqrt();
                // The root for `along` without a difference of the radii.
                let along = u2.x * (from + to) / (from + radius).max(f64::MIN_POSITIVE);
                let azimuth = DVec2::from_angle(middle + half * (2.0 * u2.y - 1.0));
                (radius * azimuth).extend(along * height)
            }
            Self::Cap {
                radius,
                axis,
                depth,
            } => {
                let frame = Frame::around(axis.as_vec3().normalize());
                let direction = frame.to_world(uniform_cone(u2.as_vec2(), depth as f32));
                radius * direction.as_dvec3().normalize()
            }
            Self::Tube { major, minor } => {
                let ratio = minor / major;
                let turn = TAU * u2.x;
                // The tube is widest outside: area up to the angle t is as t + ratio sin t.
                let share = |t: f64| {
                    let value = t + ratio * t.sin() - turn;
                    (value, value / (1.0 + ratio * t.cos()))
                };
                let tolerance = Tolerance {
                    value: 1e-14,
                    step: 1e-9,
                };
                let t = roots::bracketed(TAU, 0.0, turn, tolerance, share);
                let around = DVec2::from_angle(TAU * u2.y);
                ((major + minor * t.cos()) * around).extend(minor * t.sin())
            }
        }
    }
}

//! A solid between two closed meshes, one inside it and one around it, whose hits are Embree's: where a ray is in the
//! inner one it is in the solid, and where it is outside of the outer one it is outside.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use solidtrace::embree::{EmbreeOptions, EmbreeScene};
use solidtrace::geometry::{Mesh, Solid};
use solidtrace::math::{Interval, Ray, Transform};

use super::lathe::{cuboid, lathe};
use super::{Leaf, Stretches};

/// Steps around the axis.
const AROUND: u32 = 256;

/// Steps of a half circle.
const ACROSS: u32 = 128;

/// More than what f32 costs, in the unit solid's space and seen at a right angle.
const ROUNDING: f64 = 1.0 / (1 << 18) as f64;

/// No unit solid reaches further from its origin.
const REACH: f64 = 2.0;

/// Both meshes of a unit solid, which stretching along the axes turns into any other with its proportions.
pub struct Sandwich {
    unit: Solid,
    inner: EmbreeScene,
    outer: EmbreeScene,
}

/// The unit solid of the same proportions, and how it is to be stretched.
fn unit_solid(solid: &Solid) -> (Solid, DVec3) {
    match *solid {
        Solid::Sphere { radius } => (Solid::Sphere { radius: 1.0 }, DVec3::splat(radius)),
        Solid::Box { half } => (Solid::Box { half: DVec3::ONE }, half),
        Solid::Cylinder { radius, height } => (
            Solid::Cylinder {
                radius: 1.0,
                height: 1.0,
            },
            DVec3::new(radius, radius, height),
        ),
        Solid::Cone {
            from_radius,
            to_radius,
            height,
        } => {
            let radius = from_radius.max(to_radius);
            let unit = Solid::Cone {
                from_radius: from_radius / radius,
                to_radius: to_radius / radius,
                height: 1.0,
            };
            (unit, DVec3::new(radius, radius, height))
        }
        Solid::Torus { major, minor } => {
            let unit = Solid::Torus {
                major: 1.0,
                minor: minor / major,
            };
            (unit, DVec3::splat(major))
        }
        Solid::Plane => (Solid::Plane, DVec3::ONE),
        Solid::Rectangle { .. } | Solid::Disk { .. } => unreachable!("no operands"),
    }
}

/// Whether the same meshes do for both unit solids: they may differ by a rounding of their proportions.
fn same(a: &Solid, b: &Solid) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    match (*a, *b) {
        (
            Solid::Cone {
                from_radius: a,
                to_radius: b,
                ..
            },
            Solid::Cone {
                from_radius: c,
                to_radius: d,
                ..
            },
        ) => close(a, c) && close(b, d),
        (Solid::Torus { minor: a, .. }, Solid::Torus { minor: b, .. }) => close(a, b),
        _ => a == b,
    }
}

impl Sandwich {
    /// For the unit solid of `solid`'s proportions.
    pub fn new(solid: &Solid) -> Self {
        let (unit, _) = unit_solid(solid);
        let (inner, outer) = meshes(&unit);
        let scene = |mesh: &Mesh| {
            let options = EmbreeOptions {
                robust: true,
                ..EmbreeOptions::default()
            };
            EmbreeScene::new(&[(mesh, &Transform::IDENTITY)], options).expect("the mesh is sound")
        };
        Self {
            unit,
            inner: scene(&inner),
            outer: scene(&outer),
        }
    }

    /// Whether it is that of `solid`.
    pub fn fits(&self, solid: &Solid) -> bool {
        same(&self.unit, &unit_solid(solid).0)
    }

    /// Where `ray` is inside the operand `leaf`. A half-space is one within `reach` of the origin only. Where Embree's
    /// hits do not alternate in and out, everything is possible.
    pub fn stretches(&self, leaf: &Leaf, ray: &Ray, reach: f64) -> Stretches {
        let stretch = match unit_solid(&leaf.solid) {
            // Half the unit box holds what matters of the half-space.
            (Solid::Plane, _) => {
                let columns = leaf.back.matrix3.to_cols_array().map(|x| x * x);
                let norm = columns.iter().sum::<f64>().sqrt();
                DVec3::splat(norm * reach + leaf.back.translation.length())
            }
            (_, stretch) => stretch,
        };
        let local = leaf.ray(ray);
        let (o, d) = (local.origin / stretch, local.direction / stretch);
        let speed = d.length();
        // From near by, so that f32 loses little.
        let t = -o.dot(d) / (speed * speed);
        let closest = o + t * d;
        if closest.length() > REACH {
            return Stretches::default();
        }
        let near = Ray::new(closest - 2.0 * REACH * d / speed, d / speed);
        let time = |s: f64| t + (s - 2.0 * REACH) / speed;
        let mut stretches = Stretches::default();
        let (Some(outer), Some(inner)) = (spans(&self.outer, &near), spans(&self.inner, &near))
        else {
            stretches.possible(f64::NEG_INFINITY, f64::INFINITY);
            return stretches;
        };
        for [enter, exit] in outer {
            stretches.possible(time(enter.s - enter.slack), time(exit.s + exit.slack));
        }
        for [enter, exit] in inner {
            let (min, max) = (enter.s + enter.slack, exit.s - exit.slack);
            if min < max {
                stretches.certain.push(Interval {
                    min: time(min),
                    max: time(max),
                });
            }
        }
        stretches
    }
}

/// A hit of Embree's.
#[derive(Clone, Copy)]
struct End {
    s: f64,
    /// How far off it may be.
    slack: f64,
    enter: bool,
}

/// All that is inside a closed mesh, or `None` where the hits do not alternate. An edge that is hit may count for both
/// of its triangles.
fn spans(scene: &EmbreeScene, ray: &Ray) -> Option<Vec<[End; 2]>> {
    let mut ends: Vec<End> = Vec::new();
    let mut rest = *ray;
    while let Some(hit) = scene.intersect(&rest) {
        let s = f64::from(hit.t);
        // Beyond it in f32; and beyond what was looked for, should Embree round a hit back to there.
        rest.tmin = f64::from(hit.t.next_up()).max(f64::from((rest.tmin as f32).next_up()));
        let cosine = hit.ng.as_dvec3().normalize().dot(ray.direction);
        let end = End {
            s,
            slack: ROUNDING / cosine.abs(),
            enter: cosine < 0.0,
        };
        match ends.last() {
            Some(last) if last.enter == end.enter && s - last.s <= last.slack + end.slack => {}
            _ => ends.push(end),
        }
    }
    let (pairs, rest) = ends.as_chunks();
    let alternate = rest.is_empty() && pairs.iter().all(|[a, b]| a.enter && !b.enter);
    alternate.then(|| pairs.to_vec())
}

/// The inner mesh and the outer one, except for roundings to f32.
///
/// A lathe's flat sides come as near to the axis as the cosine of half a step: there its section is the profile, pulled
/// in by that.
fn meshes(unit: &Solid) -> (Mesh, Mesh) {
    let cosine = |steps: u32| (PI / f64::from(steps)).cos();
    let out = 1.0 / cosine(AROUND);
    let turned = |profile: &[(f64, f64)]| lathe(profile, AROUND, false);
    let frustum = |from: f64, to: f64| {
        let profile = |k: f64| [(0.0, 0.0), (k * from, 0.0), (k * to, 1.0), (0.0, 1.0)];
        (turned(&profile(1.0)), turned(&profile(out)))
    };
    let twice = |mesh: Mesh| (mesh.clone(), mesh);
    match *unit {
        Solid::Sphere { .. } => {
            let half_turn = |radius: f64| -> Vec<(f64, f64)> {
                (0..=ACROSS)
                    .map(|i| (PI * f64::from(i) / f64::from(ACROSS)).sin_cos())
                    .map(|(sin, cos)| (radius * sin, -radius * cos))
                    .collect()
            };
            let around = out / cosine(2 * ACROSS);
            (turned(&half_turn(1.0)), turned(&half_turn(around)))
        }
        Solid::Box { .. } => twice(cuboid(1.0)),
        Solid::Plane => twice(cuboid(0.0)),
        Solid::Rectangle { .. } | Solid::Disk { .. } => unreachable!("no operands"),
        Solid::Cylinder { .. } => frustum(1.0, 1.0),
        Solid::Cone {
            from_radius,
            to_radius,
            ..
        } => frustum(from_radius, to_radius),
        Solid::Torus { minor, .. } => {
            let ring = |radius: f64| {
                let point = |i: u32| (TAU * f64::from(i) / f64::from(ACROSS)).sin_cos();
                let profile: Vec<_> = (0..ACROSS)
                    .map(point)
                    .map(|(sin, cos)| (1.0 + radius * cos, radius * sin))
                    .collect();
                lathe(&profile, AROUND, true)
            };
            // No point of the tube is pulled in or out by more than this.
            let pull = (1.0 + minor) * (out - 1.0);
            (ring(minor - pull), ring((minor + pull) / cosine(ACROSS)))
        }
    }
}

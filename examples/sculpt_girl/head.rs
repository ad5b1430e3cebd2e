//! The head and the face. The origin is the middle of the head; the face looks along z.

use glam::{DAffine3, DMat3, DVec3, dvec3};

use crate::part::{Group, Part};
use crate::sdf::{Tube, basis, carve, ellipsoid, join, meet, rounded_cone};

/// Distance to the head without its neck, which hair and features lean on.
pub(crate) fn skull(p: DVec3) -> f64 {
    let side = dvec3(p.x.abs(), p.y, p.z);
    let cranium = ellipsoid(p - dvec3(0.0, 0.035, -0.005), dvec3(0.183, 0.18, 0.178));
    let jaw = ellipsoid(p - dvec3(0.0, -0.065, 0.03), dvec3(0.145, 0.115, 0.13));
    let chin = ellipsoid(p - dvec3(0.0, -0.145, 0.075), dvec3(0.055, 0.04, 0.05));
    let cheek = ellipsoid(
        side - dvec3(0.082, -0.068, 0.085),
        dvec3(0.07, 0.062, 0.065),
    );
    let face = join(join(cranium, jaw, 0.07), cheek, 0.05);
    join(face, chin, 0.07)
}

fn head(p: DVec3) -> f64 {
    let side = dvec3(p.x.abs(), p.y, p.z);
    let nose = ellipsoid(p - dvec3(0.0, -0.04, 0.182), dvec3(0.019, 0.016, 0.02));
    let ear = ellipsoid(
        DMat3::from_rotation_y(-0.5) * (side - dvec3(0.183, -0.035, -0.002)),
        dvec3(0.016, 0.042, 0.03),
    );
    let bowl = ellipsoid(
        side - dvec3(0.205, -0.03, 0.014),
        dvec3(0.014, 0.026, 0.017),
    );
    let neck = rounded_cone(
        p,
        (dvec3(0.0, -0.28, -0.03), 0.056),
        (dvec3(0.0, -0.14, -0.02), 0.05),
    );
    let features = join(skull(p), nose, 0.026);
    join(join(features, carve(ear, bowl, 0.012), 0.012), neck, 0.02)
}

/// Where the ray from `p` along z leaves the solid of `field`, which holds `p`.
fn surface_along_z(field: impl Fn(DVec3) -> f64, p: DVec3) -> f64 {
    let (mut inside, mut outside) = (p.z - 0.1, p.z + 0.4);
    for _ in 0..40 {
        let z = 0.5 * (inside + outside);
        if field(p.with_z(z)) < 0.0 {
            inside = z;
        } else {
            outside = z;
        }
    }
    inside
}

/// The point of the face in front of (x, y), and the outward normal there.
fn on_face(x: f64, y: f64) -> (DVec3, DVec3) {
    let p = dvec3(x, y, surface_along_z(skull, dvec3(x, y, 0.0)));
    let slope = |axis: DVec3| skull(p + 1e-4 * axis) - skull(p - 1e-4 * axis);
    (
        p,
        dvec3(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize(),
    )
}

/// A tube drawn on the face through (x, y, radius).
fn stroke(group: Group, cell: f64, knots: &[(f64, f64, f64)]) -> Part {
    let knots: Vec<_> = knots
        .iter()
        .map(|&(x, y, r)| (on_face(x, y).0, r))
        .collect();
    Part::tubes(group, cell, cell, vec![Tube::through(&knots, 6)])
}

/// An eye: white, iris, pupil and two lights, flat ellipsoids each just proud of the one below, so that their
/// outlines are exact curves whatever the mesh; then the lashes.
fn eye(side: f64) -> Vec<Part> {
    let (p, n) = on_face(side * 0.07, -0.004);
    // Between the skin's normal and straight ahead: eyes that follow the skin would squint outward.
    let out = n.lerp(DVec3::Z, 0.45).normalize();
    let x = DVec3::Y.cross(out).normalize();
    let axes = DMat3::from_cols(x, out.cross(x), out);
    let frame = DAffine3::from_mat3_translation(axes, p - 0.018 * n);
    let look = -0.004 * side;
    let white = dvec3(0.049, 0.058, 0.027);
    // (group, rings, centre, semi-axes), from the white outward.
    let discs = [
        (Group::Tights, 12, [0.0, 0.0, 0.0], white.to_array()),
        (
            Group::Shoes,
            12,
            [look, -0.002, 0.0122],
            [0.0385, 0.0445, 0.0161],
        ),
        (
            Group::Dress,
            12,
            [look, -0.002, 0.0143],
            [0.034, 0.039, 0.0161],
        ),
        (
            Group::Shoes,
            9,
            [look, -0.002, 0.0205],
            [0.0215, 0.026, 0.012],
        ),
        (
            Group::Tights,
            6,
            [0.011, 0.017, 0.0295],
            [0.0095, 0.011, 0.006],
        ),
        (
            Group::Tights,
            5,
            [-0.012, -0.02, 0.0275],
            [0.0052, 0.0058, 0.005],
        ),
    ];
    let mut parts: Vec<_> = discs
        .into_iter()
        .map(|(group, rings, centre, radii)| {
            Part::ellipsoid(group, rings, centre.into(), DMat3::IDENTITY, radii.into())
                .placed(frame)
        })
        .collect();
    // The lashes follow the upper rim, where the white comes out of the skin.
    let rim = |degrees: f64, reach: f64, radius: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let flat = dvec3(side * reach * white.x * cos, reach * white.y * sin, 0.0);
        let z = surface_along_z(
            |p| ellipsoid(p, white).min(skull(frame.transform_point3(p))),
            flat,
        );
        (flat.with_z(z), radius)
    };
    let lashes = [
        rim(158.0, 0.93, 0.0026),
        rim(130.0, 0.95, 0.0045),
        rim(95.0, 0.96, 0.0062),
        rim(60.0, 0.97, 0.0068),
        rim(35.0, 1.02, 0.006),
        rim(26.0, 1.22, 0.0026),
    ];
    parts.push(
        Part::tubes(Group::Shoes, 0.0047, 0.001, vec![Tube::through(&lashes, 5)]).placed(frame),
    );
    parts
}

/// An open smile: dark lips and mouth, with teeth and a tongue.
fn mouth() -> Vec<Part> {
    const HALF: f64 = 0.05;
    let arch = |x: f64| 1.0 - (x / HALF).powi(2);
    let upper = move |x: f64| -0.092 - 0.012 * arch(x);
    let lower = move |x: f64| -0.092 - 0.043 * arch(x);
    let bounds = [dvec3(-0.075, -0.155, 0.12), dvec3(0.075, -0.07, 0.21)];
    let between = |p: DVec3, top: f64, bottom: f64| 0.75 * meet(p.y - top, bottom - p.y, 0.004);
    let hollow = move |p: DVec3| {
        let layer = (skull(p) - 0.0012).max(0.13 - p.z);
        meet(layer, between(p, upper(p.x), lower(p.x)), 0.003)
    };
    let teeth = move |p: DVec3| {
        let layer = (skull(p) - 0.0026).max(0.13 - p.z).max(p.x.abs() - 0.036);
        let strip = between(
            p,
            upper(p.x) - 0.001,
            (upper(p.x) - 0.0115).max(lower(p.x) + 0.004),
        );
        meet(layer, strip, 0.003)
    };
    let (p, n) = on_face(0.0, -0.127);
    let tongue = dvec3(0.019, 0.011, 0.007);
    let axes = basis(DVec3::Y - n * n.y, n);
    let lip: Vec<_> = [-1.0, -0.7, -0.35, 0.0, 0.35, 0.7, 1.0]
        .map(|t: f64| (t * HALF, upper(t * HALF), 0.0043 - 0.0006 * t * t))
        .into();
    vec![
        Part::new(Group::Shoes, 0.0042, bounds, hollow),
        Part::new(Group::Tights, 0.0042, bounds, teeth),
        Part::ellipsoid(Group::Arms, 7, p - 0.0045 * n, axes, tongue),
        stroke(Group::Shoes, 0.0042, &lip),
    ]
}

/// The head with its face, in the head's own space.
pub(crate) fn parts() -> Vec<Part> {
    let bounds = [dvec3(-0.23, -0.37, -0.22), dvec3(0.23, 0.24, 0.24)];
    let mut parts = vec![Part::new(Group::Skin, 0.0175, bounds, head)];
    for side in [-1.0, 1.0] {
        parts.extend(eye(side));
        let brow = [
            (0.034, 0.092, 0.005),
            (0.068, 0.105, 0.0068),
            (0.105, 0.093, 0.004),
        ];
        parts.push(stroke(
            Group::Hair,
            0.0052,
            &brow.map(|(x, y, r)| (side * x, y, r)),
        ));
        let (p, n) = on_face(side * 0.106, -0.072);
        let blush = basis(DVec3::Y - n * n.y, n);
        parts.push(Part::ellipsoid(
            Group::Arms,
            8,
            p - 0.0063 * n,
            blush,
            dvec3(0.03, 0.021, 0.0075),
        ));
        for (x, y) in [(0.052, -0.052), (0.072, -0.064), (0.04, -0.07)] {
            let (p, _) = on_face(side * x, y);
            let radii = DVec3::splat(0.0032);
            parts.push(Part::ellipsoid(Group::Hair, 4, p, DMat3::IDENTITY, radii));
        }
    }
    parts.extend(mouth());
    parts
}

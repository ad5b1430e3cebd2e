//! The dress, with its collar, petticoat, cuffs, belt and buttons.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3, Vec3Swizzles, dvec3};

use crate::limbs::{ARMS, NECK};
use crate::part::{Group, Part};
use crate::sdf::{basis, carve, ellipsoid, join, meet, ring, rounded_cone, smoothstep};

const WAIST: DVec3 = dvec3(-0.012, 0.79, 0.0);
const HEM: f64 = 0.455;
const FOLDS: f64 = 9.0;

fn bodice(p: DVec3) -> f64 {
    let chest = ellipsoid(p - dvec3(0.0, 0.965, 0.002), dvec3(0.116, 0.125, 0.09));
    let waist = rounded_cone(
        p,
        (WAIST + 0.055 * DVec3::Y, 0.086),
        (dvec3(-0.002, 0.93, 0.0), 0.09),
    );
    let shoulders = rounded_cone(p, (ARMS[0].shoulder, 0.05), (ARMS[1].shoulder, 0.05));
    let neck = rounded_cone(p, (NECK - 0.06 * DVec3::Y, 0.08), (NECK, 0.062));
    let flat = dvec3(1.0, 1.0, 0.9);
    let body = join(join(chest, waist / flat.z, 0.05), shoulders, 0.05);
    let mut body = join(body, neck, 0.03);
    for arm in ARMS {
        // A puff sleeve: full at the shoulder, gathered at the cuff by folds around the arm.
        let axes = basis(arm.elbow - arm.shoulder, DVec3::Z);
        let q = axes.transpose() * (p - arm.shoulder);
        let gathers = 0.0035 * (10.0 * q.x.atan2(q.z)).cos();
        let puff = ellipsoid(q - dvec3(0.0, 0.038, 0.0), dvec3(0.066, 0.064, 0.066)) + gathers;
        body = join(body, puff, 0.022);
    }
    body
}

/// A flared skirt of pleats, `ease` larger than the dress's own; it sways toward the bent leg.
fn skirt(p: DVec3, ease: f64) -> f64 {
    let t = ((WAIST.y - p.y) / (WAIST.y - HEM)).max(0.0);
    let sway = dvec3(0.03, 0.0, 0.012) * t * t;
    let q = p - dvec3(WAIST.x, 0.0, 0.0) - sway;
    let angle = q.x.atan2(q.z);
    let depth = 0.03 * smoothstep(0.0, 0.9, t) + 0.002;
    let pleat = (FOLDS * angle + 0.5 * (2.0 * angle).sin() + 0.6 * t).cos();
    let radius = 0.084 + 0.19 * t.powf(0.85) + depth * pleat + ease;
    // The slant of the cone makes the radial distance too long.
    0.8 * (q.x.hypot(q.z * 1.08) - radius)
}

/// The skirt down to a hem that waves with its folds; it is solid, domed underneath.
fn cloth(p: DVec3, ease: f64, hem: f64) -> f64 {
    let dome = 0.09 * (0.9 - p.xz().length_squared() / 0.07).max(0.0);
    meet(skirt(p, ease), hem + dome - p.y, 0.03)
}

fn dress_skirt(p: DVec3) -> f64 {
    let hem = HEM + 0.006 * (FOLDS * p.x.atan2(p.z)).cos();
    meet(cloth(p, 0.0, hem), p.y - WAIST.y - 0.012, 0.02)
}

/// Lace that shows below the hem.
fn petticoat(p: DVec3) -> f64 {
    let lace = HEM - 0.031 + 0.006 * (2.0 * FOLDS * p.x.atan2(p.z)).cos();
    meet(cloth(p, -0.02, lace), p.y - HEM - 0.035, 0.02)
}

/// A round collar lying on the bodice: two leaves in front, one behind.
fn collar(p: DVec3) -> f64 {
    let disc = |x: f64, z: f64, radius: f64| p.distance(NECK + dvec3(x, 0.0, z)) - radius;
    let front = disc(-0.046, 0.035, 0.078).min(disc(0.046, 0.035, 0.078));
    let outline = join(front, disc(0.0, -0.035, 0.08), 0.01);
    // The lower face lies well inside the bodice, so that the rim meets the cloth steeply.
    let sheet = (bodice(p) + 0.004).abs() - 0.016;
    meet(sheet, outline, 0.012)
}

/// The dress and all that is sewn to it.
pub(crate) fn parts() -> Vec<Part> {
    let box_of = |x: f64, y: [f64; 2], z: f64| [dvec3(-x, y[0], -z), dvec3(x, y[1], z)];
    let mut parts = vec![
        Part::new(
            Group::Dress,
            0.0155,
            box_of(0.24, [0.73, 1.19], 0.16),
            bodice,
        ),
        Part::new(
            Group::Dress,
            0.0172,
            box_of(0.38, [0.42, 0.84], 0.36),
            dress_skirt,
        ),
        Part::new(
            Group::Tights,
            0.0165,
            box_of(0.38, [0.38, 0.52], 0.36),
            petticoat,
        ),
        Part::new(
            Group::Tights,
            0.0118,
            box_of(0.16, [0.96, 1.2], 0.16),
            collar,
        ),
        Part::new(
            Group::Shoes,
            0.0108,
            box_of(0.14, [0.74, 0.85], 0.13),
            |p| {
                let q = p - WAIST - dvec3(0.0, 0.008, 0.0);
                let band = (q.x.hypot(q.z * 1.08) - 0.089).abs() - 0.0115;
                meet(band, q.y.abs() - 0.0165, 0.02)
            },
        ),
    ];
    // The belt is tied behind.
    let knot =
        DAffine3::from_rotation_y(PI) * DAffine3::from_translation(dvec3(0.012, 0.795, 0.092));
    parts.push(bow(1.5).placed(knot));
    for arm in ARMS {
        let along = arm.elbow - arm.shoulder;
        let place = DAffine3::from_mat3_translation(
            basis(along, DVec3::Z),
            arm.shoulder + 0.094 * along.normalize(),
        );
        let half = dvec3(0.07, 0.03, 0.07);
        let cuff = |p: DVec3| ring(p * dvec3(1.0, 0.75, 1.0), 0.041, 0.012);
        parts.push(Part::new(Group::Tights, 0.0115, [-half, half], cuff).placed(place));
    }
    for y in [0.995, 0.945, 0.895] {
        let mut z = 0.2;
        while bodice(dvec3(0.0, y, z)) > 0.0 {
            z -= 0.001;
        }
        let radii = dvec3(0.0115, 0.0115, 0.008);
        parts.push(Part::ellipsoid(
            Group::Tights,
            6,
            dvec3(0.0, y, z),
            DMat3::IDENTITY,
            radii,
        ));
    }
    parts
}

/// A ribbon's bow in the plane z = 0, two loops and a knot, `size` times as large as those of the braids.
pub(crate) fn bow(size: f64) -> Part {
    let half = size * dvec3(0.085, 0.06, 0.03);
    Part::new(Group::Shoes, 0.0085 * size, [-half, half], move |p| {
        let q = p.with_x(p.x.abs()) / size;
        let loops = ellipsoid(
            DMat3::from_rotation_z(-0.25) * (q - dvec3(0.038, 0.004, 0.0)),
            dvec3(0.036, 0.026, 0.014),
        );
        let dent = ellipsoid(q - dvec3(0.045, 0.008, 0.018), dvec3(0.016, 0.01, 0.012));
        let knot = ellipsoid(q, dvec3(0.014, 0.016, 0.016));
        size * join(carve(loops, dent, 0.008), knot, 0.004)
    })
}

//! Arms and hands, legs, feet and shoes: the pose.

use glam::{DAffine3, DMat3, DVec3, dvec3};

use crate::part::{Group, Part};
use crate::sdf::{Tube, basis, carve, ellipsoid, join, meet, rounded_cone};

/// The foot of the neck.
pub(crate) const NECK: DVec3 = dvec3(0.004, 1.085, -0.008);

/// An arm: its joints, and where the hand points and its palm looks.
pub(crate) struct Arm {
    pub(crate) shoulder: DVec3,
    pub(crate) elbow: DVec3,
    wrist: DVec3,
    fingers: DVec3,
    palm: DVec3,
    /// Which way along the hand's x axis the thumb lies.
    thumb: f64,
    /// How far the fingers are spread and bent, in radians.
    spread: f64,
    curl: f64,
}

/// Her right arm waves; her left hand rests on the hip.
pub(crate) const ARMS: [Arm; 2] = [
    Arm {
        shoulder: dvec3(-0.126, 1.05, -0.005),
        elbow: dvec3(-0.29, 0.965, 0.03),
        wrist: dvec3(-0.362, 1.135, 0.085),
        fingers: dvec3(-0.16, 1.0, 0.08),
        palm: dvec3(0.25, 0.0, 1.0),
        thumb: 1.0,
        spread: 0.24,
        curl: 0.15,
    },
    Arm {
        shoulder: dvec3(0.126, 1.032, -0.005),
        elbow: dvec3(0.275, 0.885, -0.045),
        wrist: dvec3(0.168, 0.79, 0.045),
        fingers: dvec3(-0.5, -0.45, 0.75),
        palm: dvec3(-0.8, 0.1, -0.45),
        thumb: -1.0,
        spread: 0.05,
        curl: 0.35,
    },
];

/// Hands are drawn large, as figurines' are.
const HAND: f64 = 1.2;
const WRIST: f64 = 0.0235;

fn hand(p: DVec3, arm: &Arm) -> f64 {
    let p = dvec3(p.x * arm.thumb, p.y, p.z) / HAND;
    let mut hand = ellipsoid(p - dvec3(0.0, 0.042, 0.0), dvec3(0.035, 0.042, 0.019));
    for (i, length) in [0.043, 0.052, 0.05, 0.038].into_iter().enumerate() {
        let rank = 1.5 - i as f64;
        let base = dvec3(0.0165 * rank, 0.068, 0.0);
        let turn = DMat3::from_rotation_z(-arm.spread * rank);
        let bend = |angle: f64| turn * DMat3::from_rotation_x(angle) * (0.5 * length * DVec3::Y);
        let knuckle = base + bend(arm.curl);
        let tip = knuckle + bend(2.2 * arm.curl);
        hand = join(
            hand,
            rounded_cone(p, (base, 0.0115), (knuckle, 0.011)),
            0.006,
        );
        hand = join(
            hand,
            rounded_cone(p, (knuckle, 0.011), (tip, 0.0095)),
            0.003,
        );
    }
    let thumb = rounded_cone(
        p,
        (dvec3(0.02, 0.025, 0.006), 0.0145),
        (dvec3(0.052, 0.062, 0.014), 0.0105),
    );
    HAND * join(hand, thumb, 0.012)
}

fn arm(arm: &'static Arm) -> [Part; 2] {
    let bones = [(arm.shoulder, 0.04), (arm.elbow, 0.034), (arm.wrist, WRIST)];
    let place = DAffine3::from_mat3_translation(basis(arm.fingers, arm.palm), arm.wrist);
    let bounds = [dvec3(-0.1, -0.09, -0.09), dvec3(0.1, 0.18, 0.11)];
    // The hand brings a little of the forearm, so that the wrist is round and its edge is hidden inside the arm.
    let stub = 0.045 * (place.matrix3.transpose() * (arm.elbow - arm.wrist).normalize());
    let hand = move |p: DVec3| {
        let wrist = rounded_cone(p, (DVec3::ZERO, WRIST), (stub, 0.7 * WRIST));
        join(hand(p, arm), wrist, 0.035)
    };
    [
        Part::tubes(
            Group::Arms,
            0.013,
            0.02,
            bones.windows(2).map(Tube::straight).collect(),
        ),
        Part::new(Group::Arms, 0.008, bounds, hand).placed(place),
    ]
}

struct Leg {
    hip: DVec3,
    knee: DVec3,
    ankle: DVec3,
    /// Where the foot stands, and how far it is turned out, in radians.
    foot: DVec3,
    turn: f64,
}

/// The weight is on her right leg; the left is bent, its foot turned out.
const LEGS: [Leg; 2] = [
    Leg {
        hip: dvec3(-0.082, 0.53, 0.006),
        knee: dvec3(-0.08, 0.345, 0.012),
        ankle: dvec3(-0.074, 0.1, -0.012),
        foot: dvec3(-0.074, 0.0, 0.0),
        turn: -0.2,
    },
    Leg {
        hip: dvec3(0.078, 0.52, 0.02),
        knee: dvec3(0.112, 0.33, 0.075),
        ankle: dvec3(0.146, 0.1, 0.045),
        foot: dvec3(0.152, 0.0, 0.058),
        turn: 0.65,
    },
];

fn leg(leg: &'static Leg) -> Part {
    let place = DAffine3::from_mat3_translation(DMat3::from_rotation_y(leg.turn), leg.foot);
    let inverse = place.inverse();
    let low = dvec3(leg.foot.x - 0.17, 0.005, -0.16);
    let high = dvec3(leg.foot.x + 0.14, 0.63, 0.24);
    Part::new(Group::Tights, 0.019, [low, high], move |p| {
        let thigh = rounded_cone(p, (leg.hip, 0.066), (leg.knee, 0.05));
        let shin = rounded_cone(p, (leg.knee, 0.05), (leg.ankle, 0.031));
        let calf = leg.knee.lerp(leg.ankle, 0.35) - 0.014 * DVec3::Z;
        let calf = ellipsoid(p - calf, dvec3(0.044, 0.085, 0.044));
        let q = inverse.transform_point3(p);
        let instep = rounded_cone(
            q,
            (dvec3(0.0, 0.056, -0.005), 0.034),
            (dvec3(0.0, 0.045, 0.085), 0.026),
        );
        join(join(join(thigh, shin, 0.03), calf, 0.04), instep, 0.05)
    })
}

fn shoe(leg: &'static Leg) -> Part {
    let bounds = [dvec3(-0.09, -0.02, -0.1), dvec3(0.09, 0.15, 0.17)];
    let place = DAffine3::from_mat3_translation(DMat3::from_rotation_y(leg.turn), leg.foot);
    Part::new(Group::Shoes, 0.0117, bounds, |p| {
        let toe = ellipsoid(p - dvec3(0.0, 0.036, 0.082), dvec3(0.05, 0.042, 0.06));
        let heel = ellipsoid(p - dvec3(0.0, 0.045, -0.018), dvec3(0.045, 0.052, 0.046));
        let upper = join(toe, heel, 0.05);
        let mouth = ellipsoid(p - dvec3(0.0, 0.098, 0.028), dvec3(0.034, 0.05, 0.052));
        let upper = carve(upper, mouth, 0.01);
        let strap = meet(
            ellipsoid(p - dvec3(0.0, 0.045, 0.03), dvec3(0.048, 0.05, 0.06)),
            (p.z - 0.034).abs() - 0.011,
            0.008,
        );
        let outline = rounded_cone(
            dvec3(p.x, 0.0, p.z),
            (dvec3(0.0, 0.0, -0.018), 0.05),
            (dvec3(0.0, 0.0, 0.085), 0.056),
        );
        let sole = meet(outline, p.y - 0.019, 0.006);
        // A plane, so that she stands flat on the floor.
        join(join(upper, strap, 0.006), sole, 0.008).max(-p.y)
    })
    .placed(place)
}

/// Arms, legs and shoes.
pub(crate) fn parts() -> Vec<Part> {
    let mut parts: Vec<_> = ARMS.iter().flat_map(arm).collect();
    for limb in &LEGS {
        parts.push(leg(limb));
        parts.push(shoe(limb));
    }
    parts
}

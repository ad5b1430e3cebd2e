//! The hair: a parted cap, fringe and side locks, and two braids. The cap is in the head's space.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, dvec3};

use crate::dress::bow;
use crate::head::skull;
use crate::part::{Group, Part};
use crate::sdf::{Tube, basis, ellipsoid, join, meet, ring, smoothstep};

/// Where the hair of a side is gathered into its braid, behind the ear.
fn gather(side: f64) -> DVec3 {
    dvec3(side * 0.168, -0.085, -0.085)
}

fn half_cap(p: DVec3, side: f64) -> f64 {
    let volume = ellipsoid(
        p - dvec3(side * 0.026 + 0.006, 0.045, -0.018),
        dvec3(0.19, 0.203, 0.203),
    );
    // Strands run from the parting to the braid: grooves along the rays from where it starts.
    let from = p - gather(side);
    let angle = from.y.atan2(from.z);
    let reach = smoothstep(0.03, 0.16, from.length()) * smoothstep(-0.03, 0.05, from.y);
    let groove = 0.5 + 0.5 * (18.0 * angle).cos();
    volume + 0.011 * reach * groove.powi(2)
}

fn cap(p: DVec3) -> f64 {
    // The parting starts over her left eye and runs to the middle behind.
    let parting = (p.x - 0.04 * smoothstep(-0.12, 0.12, p.z)) / 0.013;
    let halves = join(half_cap(p, -1.0), half_cap(p, 1.0), 0.006) + 0.009 / (1.0 + parting.powi(4));
    // Over the forehead the cap sinks under the locks.
    let halves = halves + 0.018 * smoothstep(0.06, 0.15, p.z);
    let hairline = p.dot(dvec3(0.0, -0.62, 0.785)) - 0.018;
    let shell = meet(halves, hairline, 0.02);
    let nape = -0.15 - p.y;
    let mut hair = meet(shell, nape, 0.05);
    for side in [-1.0, 1.0] {
        let knot = ellipsoid(p - gather(side), dvec3(0.045, 0.05, 0.05));
        hair = join(hair, knot, 0.04);
    }
    hair
}

/// A point just above the skull over (x, y), found by walking onto it from in front and from the side.
fn on_skull(x: f64, y: f64) -> DVec3 {
    let outward = dvec3(0.2 * x.signum() * (x.abs() / 0.15).powi(4), 0.15, 1.0).normalize();
    let start = dvec3(x, y, 0.6 * (0.2 - x.abs()).max(0.0) + 0.03);
    (0..12).fold(start, |p, _| p - (skull(p) - 0.008) * outward)
}

/// Locks that start at the side parting and fall over the forehead, and one before each ear.
fn locks() -> Vec<Tube> {
    let mut locks = Vec::new();
    // (end x, end y, radius): to her right a long sweep, to her left a short one.
    let ends = [
        (0.178, 0.0, 0.03),
        (0.152, 0.052, 0.03),
        (0.118, 0.088, 0.029),
        (0.075, 0.11, 0.028),
        (0.034, 0.126, 0.025),
        (-0.012, 0.105, 0.029),
        (-0.056, 0.1, 0.03),
        (-0.1, 0.078, 0.03),
        (-0.142, 0.052, 0.031),
        (-0.18, -0.005, 0.031),
    ];
    for (x, y, radius) in ends {
        let start = dvec3(0.045 + 0.1 * (x - 0.03), 0.225, 0.06);
        let middle = on_skull(0.045 + 0.62 * (x - 0.045), 0.5 * (y + 0.2) + 0.022);
        let middle = middle + 0.008 * middle.normalize();
        let end = on_skull(x, y);
        locks.push(Tube::through(
            &[
                (start, 0.02),
                (middle, radius),
                (end.lerp(middle, 0.5), 0.72 * radius),
                (end, 0.0055),
            ],
            5,
        ));
    }
    for side in [-1.0, 1.0] {
        locks.push(Tube::through(
            &[
                (dvec3(side * 0.165, 0.06, 0.05), 0.02),
                (dvec3(side * 0.183, -0.03, 0.058), 0.016),
                (dvec3(side * 0.172, -0.09, 0.075), 0.011),
                (dvec3(side * 0.178, -0.125, 0.09), 0.0055),
            ],
            5,
        ));
    }
    locks
}

/// A braid of three strands around `spine`, whose radii are those of the braid.
fn braid(spine: &Tube, turns: f64) -> Vec<Tube> {
    let balls = spine.balls();
    let last = balls.len() - 1;
    (0..3)
        .map(|strand| {
            let knots: Vec<_> = (0..=last)
                .map(|i| {
                    let (centre, radius) = balls[i];
                    let along = balls[(i + 1).min(last)].0 - balls[i.saturating_sub(1)].0;
                    let axes = basis(along, DVec3::Z);
                    // A flat figure of eight, a third of a turn apart: each strand passes over and under in turn.
                    let phase = TAU * (turns * i as f64 / last as f64 + strand as f64 / 3.0);
                    let across = 0.62 * radius * phase.sin() * axes.x_axis;
                    let over = 0.4 * radius * (2.0 * phase).sin() * axes.z_axis;
                    (centre + across + over, 0.56 * radius)
                })
                .collect();
            Tube::through(&knots, 2)
        })
        .collect()
}

fn braids(head: DAffine3) -> Vec<Part> {
    let mut parts = Vec::new();
    let paths = [
        (
            -1.0,
            [
                dvec3(-0.245, 1.25, -0.10),
                dvec3(-0.262, 1.15, -0.105),
                dvec3(-0.262, 1.06, -0.10),
                dvec3(-0.285, 0.985, -0.085),
            ],
        ),
        (
            1.0,
            [
                dvec3(0.262, 1.27, -0.10),
                dvec3(0.31, 1.18, -0.09),
                dvec3(0.342, 1.09, -0.06),
                dvec3(0.405, 1.03, -0.03),
            ],
        ),
    ];
    for (side, path) in paths {
        let start = head.transform_point3(gather(side));
        let radii = [0.044, 0.046, 0.046, 0.043, 0.034];
        let knots: Vec<_> = std::iter::once(start).chain(path).zip(radii).collect();
        let spine = Tube::through(&knots, 9);
        let strands = braid(&spine, 3.2);
        let (tie, tip) = (path[3], path[3] - path[2]);
        let brush: Vec<_> = [-0.22, 0.0, 0.04]
            .map(|bend| {
                let fall = tie + tip + bend * dvec3(0.25, 0.3, 0.2);
                Tube::through(&[(tie, 0.018), (tie + 0.45 * tip, 0.024), (fall, 0.008)], 5)
            })
            .into();
        let mut tubes = strands;
        tubes.extend(brush);
        parts.push(Part::tubes(Group::Hair, 0.0123, 0.004, tubes));
        let axes = basis(tip, DVec3::Z);
        let tied = DAffine3::from_mat3_translation(axes, tie);
        let half = dvec3(0.055, 0.03, 0.055);
        let band = |p: DVec3| ring(p, 0.028, 0.011);
        parts.push(Part::new(Group::Shoes, 0.0095, [-half, half], band).placed(tied));
        parts.push(bow(1.0).placed(tied * DAffine3::from_translation(0.042 * DVec3::Z)));
    }
    parts
}

/// All the hair, given the head's place in the figure.
pub(crate) fn parts(head: DAffine3) -> Vec<Part> {
    let bounds = [dvec3(-0.26, -0.2, -0.26), dvec3(0.26, 0.29, 0.26)];
    let mut parts = vec![
        Part::new(Group::Hair, 0.016, bounds, cap).placed(head),
        Part::tubes(Group::Hair, 0.011, 0.005, locks()).placed(head),
    ];
    parts.extend(braids(head));
    parts
}

//! The figurine that the gallery shows, and the surface nets that make it.

use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;

use glam::DVec3;

#[path = "../../examples/sculpt_girl/surface_nets.rs"]
mod surface_nets;

/// A group's name and its triangles.
type Group = (String, Vec<[usize; 3]>);

fn girl() -> (Vec<DVec3>, Vec<Group>) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/girl.obj");
    let text = std::fs::read_to_string(path).expect("assets/girl.obj is part of the project");
    let (mut positions, mut groups) = (Vec::new(), Vec::<Group>::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f64> = words.map(|w| w.parse().expect("a number")).collect();
                positions.push(DVec3::from_slice(&numbers));
            }
            Some("usemtl") => groups.push((words.collect(), Vec::new())),
            Some("f") => {
                let corners: Vec<usize> = words
                    .map(|w| w.split('/').next().expect("a corner"))
                    .map(|w| w.parse::<usize>().expect("a vertex index") - 1)
                    .collect();
                let (_, triangles) = groups.last_mut().expect("usemtl before the first face");
                triangles.push(corners.try_into().expect("three corners"));
            }
            _ => {}
        }
    }
    (positions, groups)
}

/// Every directed edge occurs once and so does its opposite.
fn is_closed(triangles: &[[usize; 3]]) -> bool {
    let mut count = HashMap::new();
    for &[a, b, c] in triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            *count.entry(edge).or_insert(0) += 1;
        }
    }
    count
        .iter()
        .all(|(&(a, b), &n)| n == 1 && count.get(&(b, a)) == Some(&1))
}

/// The enclosed volume by the divergence theorem, positive when the triangles look outward.
fn volume(positions: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
    triangles
        .iter()
        .map(|t| t.map(|i| positions[i]))
        .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
        .sum()
}

#[test]
fn the_girl_has_six_materials_and_twenty_thousand_triangles() {
    let (_, groups) = girl();
    let names: HashSet<_> = groups.iter().map(|(name, _)| name).collect();
    assert_eq!(groups.len(), 6);
    assert_eq!(names.len(), 6);
    let total: usize = groups.iter().map(|(_, triangles)| triangles.len()).sum();
    assert!(total >= 20_000, "{total} triangles");
}

#[test]
fn each_group_of_the_girl_is_closed_and_looks_outward() {
    let (positions, groups) = girl();
    for (name, triangles) in &groups {
        assert!(is_closed(triangles), "{name} has an open edge");
        assert!(volume(&positions, triangles) > 0.0, "{name} is inside out");
    }
}

#[test]
fn no_triangle_of_the_girl_is_degenerate_or_doubled() {
    let (positions, groups) = girl();
    let mut seen = HashSet::new();
    for (name, triangles) in &groups {
        for &triangle in triangles {
            let [a, b, c] = triangle.map(|i| positions[i]);
            let area = 0.5 * (b - a).cross(c - a).length();
            assert!(area > 1e-8, "{name}: {triangle:?} has area {area}");
            let mut corners = triangle;
            corners.sort_unstable();
            assert!(seen.insert(corners), "{name}: {triangle:?} occurs twice");
        }
    }
}

#[test]
fn the_girl_stands_on_the_floor_at_the_origin_165_centimetres_tall() {
    let (positions, _) = girl();
    let lo = positions
        .iter()
        .copied()
        .reduce(DVec3::min)
        .expect("vertices");
    let hi = positions
        .iter()
        .copied()
        .reduce(DVec3::max)
        .expect("vertices");
    assert_eq!(lo.y, 0.0);
    assert!((hi.y - 1.65).abs() < 0.01, "{} tall", hi.y);
    let centre = 0.5 * (lo + hi);
    assert!(centre.x.abs() < 0.01 && centre.z.abs() < 0.01, "{centre}");
}

#[test]
fn a_net_of_a_ball_has_its_volume_and_normals() {
    let ball = |p: DVec3| p.length() - 1.0;
    let half = DVec3::splat(1.1);
    let net = surface_nets::polygonize(&ball, -half, half, 0.05);
    assert!(is_closed(&net.triangles));
    let exact = 4.0 / 3.0 * PI;
    let ratio = volume(&net.positions, &net.triangles) / exact;
    assert!((0.995..1.0).contains(&ratio), "{ratio} of the volume");
    for (p, n) in net.positions.iter().zip(&net.normals) {
        // A vertex may miss a surface that only cuts a corner off its cell: by the diagonal of the margin of 0.002.
        assert!(
            (p.length() - 1.0).abs() < 0.002 * 3f64.sqrt(),
            "{p} is off the ball"
        );
        assert!((*n - p.normalize()).length() < 1e-4, "{n} at {p}");
    }
}

#[test]
fn a_net_of_a_field_finer_than_its_cells_is_closed() {
    // Waves shorter than two cells give corner signs of every kind, diagonals too.
    let foam = |p: DVec3| {
        let waves = (17.0 * p.x).sin() + (19.0 * p.y).sin() + (23.0 * p.z).sin();
        (p.length() - 1.0).max(0.1 * waves)
    };
    let half = DVec3::splat(1.2);
    let net = surface_nets::polygonize(&foam, -half, half, 0.15);
    assert!(net.triangles.len() > 1000);
    assert!(is_closed(&net.triangles));
}

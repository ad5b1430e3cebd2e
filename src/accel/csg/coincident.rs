//! Faces of different operands that lie in one surface.

use glam::DVec3;

use crate::geometry::Solid;
use crate::math::Bounds;

use super::CsgTree;
use super::operand::Kind;

/// The surface that a face is part of: a plane (normal, distance from the origin), a sphere (centre, radius) or an
/// endless cylinder (direction, the axis's closest point to the origin, radius).
#[derive(Clone, Copy)]
struct Face {
    kind: u8,
    numbers: [f64; 7],
    /// All numbers as one: close where they are.
    rank: f64,
    bounds: Bounds,
    leaf: u32,
}

/// Numbers that differ by less, in units of the object's size or of themselves, are equal.
const SAME: f64 = 1e-9;
/// Enough for any object that a person made; a million copies side by side are not worth counting.
const MOST: usize = 10_000_000;

impl CsgTree {
    /// How many pairs of faces of different operands lie in one surface and have overlapping boxes. Such faces are no
    /// trouble, but a hint of a modelling slip. Operands that are sheared count with their flat faces only, and meshes
    /// not at all. Very many comparisons are cut short.
    pub fn coincident_faces(&self) -> usize {
        let mut faces = Vec::new();
        for leaf in 0..self.leaves.len() as u32 {
            self.faces(leaf, &mut faces);
        }
        faces.sort_by(|a, b| a.rank.total_cmp(&b.rank));
        let size = (faces.iter().map(|f| f.bounds).filter(Bounds::is_finite))
            .flat_map(|b| [b.min.abs().max_element(), b.max.abs().max_element()])
            .fold(0.0, f64::max);
        let (mut pairs, mut compared) = (0, 0);
        for (i, a) in faces.iter().enumerate() {
            for b in &faces[i + 1..] {
                compared += 1;
                if b.rank - a.rank > 16.0 * SAME * size.max(1.0) || compared > MOST {
                    break;
                }
                let same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME * size.max(a.abs());
                let one_surface = a.kind == b.kind && a.numbers.iter().zip(&b.numbers).all(same);
                pairs += usize::from(a.leaf != b.leaf && one_surface && meet(a, b, SAME * size));
            }
        }
        pairs
    }

    fn faces(&self, position: u32, faces: &mut Vec<Face>) {
        let leaf = &self.leaves[position as usize];
        let form = &self.forms[leaf.form as usize];
        let Kind::Solid(solid) = form.kind else {
            return;
        };
        let place = self.maps[leaf.map as usize].at(leaf.origin);
        let bounds = place.bounds(&form.bounds());
        let mut add = |kind: u8, numbers: [f64; 7]| {
            let rank = numbers
                .iter()
                .zip(1_u8..)
                .map(|(x, i)| x * f64::from(i).sqrt());
            faces.push(Face {
                kind,
                numbers,
                rank: rank.sum(),
                bounds,
                leaf: position,
            });
        };
        let mut plane = |p: DVec3, n: DVec3| {
            let n = towards_one_side(place.normal(n));
            add(0, [n.x, n.y, n.z, n.dot(place.point(p)), 0.0, 0.0, 0.0]);
        };
        match solid {
            Solid::Plane => plane(DVec3::ZERO, DVec3::Z),
            Solid::Box { half } => {
                for axis in DVec3::AXES {
                    plane(half * axis, axis);
                    plane(-half * axis, axis);
                }
            }
            Solid::Cylinder { height, .. } | Solid::Cone { height, .. } => {
                plane(DVec3::ZERO, DVec3::Z);
                plane(height * DVec3::Z, DVec3::Z);
            }
            Solid::Sphere { .. }
            | Solid::Torus { .. }
            | Solid::Rectangle { .. }
            | Solid::Disk { .. } => {}
        }
        let Some(scale) = place.uniform_scale() else {
            return;
        };
        match solid {
            Solid::Sphere { radius } => {
                let c = leaf.origin;
                add(1, [c.x, c.y, c.z, scale * radius, 0.0, 0.0, 0.0]);
            }
            Solid::Cylinder { radius, .. } => {
                let axis = towards_one_side(place.vector(DVec3::Z).normalize());
                let near = leaf.origin - leaf.origin.dot(axis) * axis;
                let r = scale * radius;
                add(2, [axis.x, axis.y, axis.z, near.x, near.y, near.z, r]);
            }
            _ => {}
        }
    }
}

/// Whether the boxes share more than an edge, to within `same`.
fn meet(a: &Face, b: &Face, same: f64) -> bool {
    let mut shared = a.bounds.intersection(b.bounds).size().to_array();
    shared.sort_by(f64::total_cmp);
    shared[0] >= -same && shared[1] > same
}

/// Of `v` and `-v` always the same one.
fn towards_one_side(v: DVec3) -> DVec3 {
    let first = v.to_array().into_iter().find(|x| x.abs() > 1e-6);
    if first.is_some_and(|x| x < 0.0) {
        -v
    } else {
        v
    }
}

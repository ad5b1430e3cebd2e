//! Which triangles of a mesh go into its tree.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::Mesh;

use super::MeshReport;
use crate::accel::alike::{alike, mix};

/// The triangles with an area, the first of each set with equal corners, in order.
pub(super) fn distinct(mesh: &Mesh) -> (Vec<u32>, MeshReport) {
    let mut kept: Vec<u32> = (0..mesh.triangles.len() as u32)
        .into_par_iter()
        .filter(|&i| {
            let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
            (b - a).cross(c - a) != DVec3::ZERO
        })
        .collect();
    let with_area = kept.len();
    let duplicates = duplicates(mesh, &kept);
    if !duplicates.is_empty() {
        kept.retain(|i| duplicates.binary_search(i).is_err());
    }
    let report = MeshReport {
        triangles: kept.len(),
        degenerate: mesh.triangles.len() - with_area,
        duplicate: duplicates.len(),
        bytes: 0,
    };
    (kept, report)
}

/// Those of `triangles` whose corners, in any order, are those of an earlier one, ascending.
fn duplicates(mesh: &Mesh, triangles: &[u32]) -> Vec<u32> {
    let corners: Vec<u64> = (mesh.positions.par_iter())
        .map(|&p| mix(bits_of(p)))
        .collect();
    let hashes: Vec<u64> = (triangles.par_iter())
        .map(|&i| {
            // A sum is the same for corners in any order.
            let [a, b, c] = mesh.triangles[i as usize].map(|corner| corners[corner as usize]);
            a.wrapping_add(b).wrapping_add(c)
        })
        .collect();
    // Sorted, equal corners are neighbours, and the lowest index comes first.
    let mut suspects: Vec<([[u32; 3]; 3], u32)> = (alike(&hashes).into_par_iter())
        .map(|position| {
            let i = triangles[position as usize];
            let mut corners = mesh.corners(i).map(bits_of);
            corners.sort_unstable();
            (corners, i)
        })
        .collect();
    suspects.par_sort_unstable();
    let mut duplicates: Vec<u32> = (suspects.chunk_by(|a, b| a.0 == b.0))
        .flat_map(|same| same[1..].iter().map(|(_, i)| *i))
        .collect();
    duplicates.sort_unstable();
    duplicates
}

fn bits_of(p: Vec3) -> [u32; 3] {
    // Adding 0 makes -0 and 0 one.
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// The triangles whose corners differ.
pub(super) fn cornered(mesh: &Mesh) -> (Vec<u32>, MeshReport) {
    let kept: Vec<u32> = (0..mesh.triangles.len() as u32)
        .into_par_iter()
        .filter(|&i| {
            let [a, b, c] = mesh.corners(i);
            a != b && b != c && c != a
        })
        .collect();
    let report = MeshReport {
        triangles: kept.len(),
        degenerate: mesh.triangles.len() - kept.len(),
        ..MeshReport::default()
    };
    (kept, report)
}

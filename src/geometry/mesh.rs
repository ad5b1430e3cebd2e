use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::error::{Error, Result};
use crate::math::Bounds;
use crate::memory::fetch;

/// Triangles over shared vertices, in the file's order: a triangle's index here is its index in its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions; all finite.
    pub positions: Vec<Vec3>,
    /// Shading normals, one a vertex, or none at all; unit length, or zero where the file has none.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a vertex, or none at all.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the slot of its material in its instance's list; empty when all are in slot 0.
    pub slots: Vec<u32>,
}

impl Mesh {
    /// Checks what every other part of the crate relies on: attributes of equal length, indices in range,
    /// finite positions, at least one triangle.
    ///
    /// # Errors
    /// Names the first offending vertex or triangle and its value.
    pub fn validate(&self) -> Result<()> {
        let count = self.positions.len();
        if self.triangles.is_empty() {
            return Err(Error::input("the mesh has no triangles"));
        }
        for (name, len) in [("normals", self.normals.len()), ("uvs", self.uvs.len())] {
            if len != 0 && len != count {
                return Err(Error::input(format!("{len} {name} for {count} vertices")));
            }
        }
        if !self.slots.is_empty() && self.slots.len() != self.triangles.len() {
            return Err(Error::input(format!(
                "{} material slots for {} triangles",
                self.slots.len(),
                self.triangles.len()
            )));
        }
        if let Some(i) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(Error::input(format!(
                "vertex {i} is not finite: {}",
                self.positions[i]
            )));
        }
        if let Some((i, t)) = (self.triangles.iter().enumerate())
            .find(|(_, t)| t.iter().any(|&v| v as usize >= count))
        {
            return Err(Error::input(format!(
                "triangle {i} uses vertices {t:?}, but there are {count}"
            )));
        }
        Ok(())
    }

    /// The corners of triangle `i`.
    pub fn corners(&self, i: u32) -> [Vec3; 3] {
        self.triangles[i as usize].map(|v| self.positions[v as usize])
    }

    /// Asks memory for the corners' indices of triangle `i`.
    pub(crate) fn fetch_indices(&self, i: u32) {
        fetch(&raw const self.triangles[i as usize]);
    }

    /// Asks memory for what shading reads at the corners of triangle `i`, whose indices should be there.
    pub(crate) fn fetch_corners(&self, i: u32) {
        for vertex in self.triangles[i as usize].map(|v| v as usize) {
            fetch(&raw const self.positions[vertex]);
            if let Some(normal) = self.normals.get(vertex) {
                fetch(normal);
            }
            if let Some(uv) = self.uvs.get(vertex) {
                fetch(uv);
            }
        }
    }

    /// The surface coordinates at the corners of triangle `i`; those of a mesh without are the barycentric ones.
    pub fn uv_corners(&self, i: u32) -> [Vec2; 3] {
        if self.uvs.is_empty() {
            return [Vec2::ZERO, Vec2::X, Vec2::Y];
        }
        self.triangles[i as usize].map(|v| self.uvs[v as usize])
    }

    /// The gradients of u and v along triangle `i`; zero where it has no area.
    pub fn uv_gradients(&self, i: u32) -> [DVec3; 2] {
        let [a, b, c] = self.corners(i).map(Vec3::as_dvec3);
        let [ta, tb, tc] = self.uv_corners(i).map(Vec2::as_dvec2);
        let (ab, ac) = (b - a, c - a);
        let cross = ab.cross(ac);
        let square = cross.length_squared();
        if square == 0.0 {
            return [DVec3::ZERO; 2];
        }
        // Of the weights of the second and the third corner.
        let (second, third) = (ac.cross(cross) / square, cross.cross(ab) / square);
        let (d_second, d_third) = (tb - ta, tc - ta);
        [
            d_second.x * second + d_third.x * third,
            d_second.y * second + d_third.y * third,
        ]
    }

    /// The weights of the second and third corner of triangle `i`, which has an area, at a point of its plane.
    pub fn weights(&self, i: u32, p: DVec3) -> Vec2 {
        let [a, b, c] = self.corners(i).map(Vec3::as_dvec3);
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let cross = ab.cross(ac);
        let weights = DVec2::new(ap.cross(ac).dot(cross), ab.cross(ap).dot(cross));
        (weights / cross.length_squared()).as_vec2()
    }

    /// The material slot of triangle `i`.
    pub fn slot(&self, i: u32) -> u32 {
        self.slots.get(i as usize).copied().unwrap_or(0)
    }

    /// The box around all vertices that a triangle uses.
    pub fn bounds(&self) -> Bounds {
        Bounds::of_points(
            (self.triangles.iter().flatten()).map(|&v| self.positions[v as usize].as_dvec3()),
        )
    }
}

use bytemuck::Zeroable;
use glam::Vec3;

use crate::accel::triangle::Triangle;

/// Triangles that a leaf holds at most.
pub(in crate::accel) const LANES: usize = 8;

/// A leaf's triangles, relative to the tree's centre, as planes. Lanes without one hold NaN, which no test accepts.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(64))]
pub(in crate::accel) struct Block {
    /// `[corner][axis][lane]`.
    pub corners: [[[f32; LANES]; 3]; 3],
    /// Indices in the mesh.
    pub primitives: [u32; LANES],
}

impl Block {
    /// Holds `triangles`, at most [`LANES`].
    pub(in crate::accel) fn new(triangles: impl Iterator<Item = Triangle>) -> Self {
        let mut block = Self {
            corners: [[[f32::NAN; LANES]; 3]; 3],
            primitives: [u32::MAX; LANES],
        };
        for (lane, triangle) in triangles.enumerate() {
            for (planes, corner) in block.corners.iter_mut().zip(triangle.corners) {
                for (plane, x) in planes.iter_mut().zip(corner.to_array()) {
                    plane[lane] = x;
                }
            }
            block.primitives[lane] = triangle.primitive;
        }
        block
    }

    /// The coordinates of a triangle's corners along `axes`.
    #[inline(always)]
    pub(in crate::accel) fn corners_along(&self, lane: usize, axes: [u32; 3]) -> [[f32; 3]; 3] {
        let [x, y, z] = axes.map(|axis| axis as usize);
        let [a, b, c] = &self.corners;
        [
            [a[x][lane], a[y][lane], a[z][lane]],
            [b[x][lane], b[y][lane], b[z][lane]],
            [c[x][lane], c[y][lane], c[z][lane]],
        ]
    }

    /// The triangles, first to last.
    pub(in crate::accel) fn triangles(&self) -> impl Iterator<Item = Triangle> + '_ {
        (0..LANES)
            .filter(|&lane| self.primitives[lane] != u32::MAX)
            .map(|lane| Triangle {
                corners: self
                    .corners
                    .map(|planes| Vec3::from_array(planes.map(|p| p[lane]))),
                primitive: self.primitives[lane],
            })
    }
}

use bytemuck::Zeroable;
use glam::Vec3;

use crate::accel::triangle::Triangle;

/// Triangles that a leaf holds at most.
pub(in crate::accel) const LANES: usize = 8;

/// A leaf's triangles, relative to the tree's centre, as planes; those of two corners side by side are one load. Lanes
/// without a triangle hold NaN, which no test accepts.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(64))]
pub(in crate::accel) struct Block {
    /// `[axis][corner][lane]`.
    pub planes: [[[f32; LANES]; 3]; 3],
    /// Indices in the mesh.
    pub primitives: [u32; LANES],
}

impl Block {
    /// Holds `triangles`, at most [`LANES`].
    pub(in crate::accel) fn new(triangles: impl Iterator<Item = Triangle>) -> Self {
        let mut block = Self {
            planes: [[[f32::NAN; LANES]; 3]; 3],
            primitives: [u32::MAX; LANES],
        };
        for (lane, triangle) in triangles.enumerate() {
            for (i, corner) in triangle.corners.iter().enumerate() {
                for (planes, x) in block.planes.iter_mut().zip(corner.to_array()) {
                    planes[i][lane] = x;
                }
            }
            block.primitives[lane] = triangle.primitive;
        }
        block
    }

    /// Where the planes along `axes` begin, corner by corner.
    #[inline(always)]
    pub(super) fn planes_along(&self, axes: [u32; 3]) -> [*const f32; 3] {
        axes.map(|axis| {
            (&raw const self.planes[0])
                .wrapping_add(axis as usize)
                .cast()
        })
    }

    /// The coordinates of a triangle's corners along `axes`.
    #[inline(always)]
    pub(in crate::accel) fn corners_along(&self, lane: usize, axes: [u32; 3]) -> [[f32; 3]; 3] {
        let [x, y, z] = axes.map(|axis| &self.planes[axis as usize]);
        [
            [x[0][lane], y[0][lane], z[0][lane]],
            [x[1][lane], y[1][lane], z[1][lane]],
            [x[2][lane], y[2][lane], z[2][lane]],
        ]
    }

    /// The triangles, first to last.
    pub(in crate::accel) fn triangles(&self) -> impl Iterator<Item = Triangle> + '_ {
        (0..LANES)
            .filter(|&lane| self.primitives[lane] != u32::MAX)
            .map(|lane| Triangle {
                corners: [0, 1, 2]
                    .map(|corner| Vec3::from_array(self.planes.map(|p| p[corner][lane]))),
                primitive: self.primitives[lane],
            })
    }
}

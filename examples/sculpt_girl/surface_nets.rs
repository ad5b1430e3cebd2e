//! Surface nets: a closed triangle mesh of the zero set of a field.
//!
//! One vertex in every grid cell that the surface crosses, one quad for every grid edge that it crosses
//! (Gibson, "Constrained Elastic Surface Nets", 1998). The vertex starts at the mean of the crossings; then it
//! relaxes toward its neighbours and is drawn along the gradient onto the surface, and never leaves its cell.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

/// A closed surface: counter-clockwise triangles seen from outside, a unit normal at each vertex.
pub(crate) struct Surface {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

/// A vertex stays this far (in cells) from its cell's walls, so that no two vertices meet.
const MARGIN: f64 = 0.04;
const NEWTON_STEPS: usize = 4;
const RELAXATIONS: usize = 3;
const AXES: [IVec3; 3] = [IVec3::X, IVec3::Y, IVec3::Z];

struct Grid<'a> {
    field: &'a (dyn Fn(DVec3) -> f64 + Sync),
    origin: DVec3,
    cell: f64,
    samples: IVec3,
    values: Vec<f64>,
}

/// Meshes the zero set of `field` inside the box `lo..hi` with cells of side `cell`.
///
/// # Panics
/// If the surface leaves the box: the mesh would have a hole there.
pub(crate) fn polygonize(
    field: &(dyn Fn(DVec3) -> f64 + Sync),
    lo: DVec3,
    hi: DVec3,
    cell: f64,
) -> Surface {
    let mut grid = Grid::sample(field, lo, hi, cell);
    grid.drop_ambiguous_faces();
    let crossed: Vec<IVec3> = (0..grid.values.len())
        .map(|i| grid.at(i))
        .filter(|&corner| grid.is_crossed(corner))
        .collect();
    let mut vertex_of = vec![usize::MAX; grid.values.len()];
    for (vertex, &corner) in crossed.iter().enumerate() {
        vertex_of[grid.index(corner)] = vertex;
    }
    let mut positions: Vec<DVec3> = crossed.par_iter().map(|&c| grid.vertex(c)).collect();
    let quads = grid.quads(&vertex_of);
    for _ in 0..RELAXATIONS {
        let means = neighbour_means(&positions, &quads);
        positions = (crossed.par_iter().zip(means))
            .map(|(&corner, mean)| grid.project(corner, mean))
            .collect();
    }
    // A wider difference than Newton's blunts creases that are finer than the mesh can show.
    let normals = positions
        .par_iter()
        .map(|&p| gradient(field, p, 0.12 * cell).normalize())
        .collect();
    let triangles = quads.iter().flat_map(|&quad| split(quad, &positions));
    Surface {
        triangles: triangles.collect(),
        positions,
        normals,
    }
}

impl<'a> Grid<'a> {
    fn sample(field: &'a (dyn Fn(DVec3) -> f64 + Sync), lo: DVec3, hi: DVec3, cell: f64) -> Self {
        let samples = ((hi - lo) / cell).ceil().as_ivec3() + 1;
        let mut grid = Self {
            field,
            origin: lo,
            cell,
            samples,
            values: Vec::new(),
        };
        let count = samples.as_usizevec3().element_product();
        grid.values = (0..count)
            .into_par_iter()
            .map(|i| field(grid.point(grid.at(i))))
            .collect();
        for i in 0..count {
            let corner = grid.at(i);
            let edge = corner.cmpeq(IVec3::ZERO).any() || corner.cmpeq(samples - 1).any();
            assert!(
                !edge || grid.values[i] > 0.0,
                "the surface leaves its box at {}",
                grid.point(corner)
            );
        }
        grid
    }

    fn at(&self, index: usize) -> IVec3 {
        let (nx, ny) = (self.samples.x as usize, self.samples.y as usize);
        IVec3::new(
            (index % nx) as i32,
            (index / nx % ny) as i32,
            (index / nx / ny) as i32,
        )
    }

    fn index(&self, corner: IVec3) -> usize {
        let (nx, ny) = (self.samples.x as usize, self.samples.y as usize);
        corner.x as usize + nx * (corner.y as usize + ny * corner.z as usize)
    }

    fn point(&self, corner: IVec3) -> DVec3 {
        self.origin + self.cell * corner.as_dvec3()
    }

    fn value(&self, corner: IVec3) -> f64 {
        self.values[self.index(corner)]
    }

    fn inside(&self, corner: IVec3) -> bool {
        self.value(corner) < 0.0
    }

    /// Moves samples out of the solid until no cell face has its inside corners on a diagonal.
    ///
    /// Such a face is crossed by four grid edges, so its two vertices would be joined by four quads and the edge
    /// would not be manifold. Samples only ever leave the solid, so this ends.
    fn drop_ambiguous_faces(&mut self) {
        let mut changed = true;
        while changed {
            changed = false;
            for i in 0..self.values.len() {
                let corner = self.at(i);
                for (u, v) in [(0, 1), (1, 2), (2, 0)] {
                    let (u, v) = (AXES[u], AXES[v]);
                    if (corner + u + v).cmpge(self.samples).any() {
                        continue;
                    }
                    let face = [corner, corner + u, corner + u + v, corner + v];
                    let [a, b, c, d] = face.map(|corner| self.inside(corner));
                    if a == c && b == d && a != b {
                        // Of the two corners inside, the one nearer the surface.
                        let [p, q] = if a {
                            [corner, face[2]]
                        } else {
                            [face[1], face[3]]
                        };
                        let shallow = if self.value(p) > self.value(q) { p } else { q };
                        let index = self.index(shallow);
                        self.values[index] = f64::MIN_POSITIVE;
                        changed = true;
                    }
                }
            }
        }
    }

    fn is_crossed(&self, corner: IVec3) -> bool {
        if (corner + 1).cmpge(self.samples).any() {
            return false;
        }
        let first = self.inside(corner);
        cube().any(|offset| self.inside(corner + offset) != first)
    }

    fn vertex(&self, corner: IVec3) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for a in cube() {
            for axis in AXES {
                let b = a + axis;
                if b.max_element() > 1 || self.inside(corner + a) == self.inside(corner + b) {
                    continue;
                }
                let (va, vb) = (self.value(corner + a), self.value(corner + b));
                sum += a.as_dvec3().lerp(b.as_dvec3(), va / (va - vb));
                count += 1.0;
            }
        }
        self.project(corner, self.point(corner) + self.cell * sum / count)
    }

    /// Draws `p` onto the surface, but not out of the cell at `corner`.
    fn project(&self, corner: IVec3, p: DVec3) -> DVec3 {
        let base = self.point(corner);
        let (lo, hi) = (base + MARGIN * self.cell, base + (1.0 - MARGIN) * self.cell);
        let mut p = p.clamp(lo, hi);
        for _ in 0..NEWTON_STEPS {
            let distance = (self.field)(p);
            if distance.abs() < 1e-8 {
                break;
            }
            let slope = gradient(self.field, p, 1e-5);
            let step = distance / slope.length_squared().max(1e-2);
            p = (p - step * slope).clamp(lo, hi);
        }
        p
    }

    /// The vertices of the four cells around each crossed edge, counter-clockwise from outside.
    fn quads(&self, vertex_of: &[usize]) -> Vec<[usize; 4]> {
        let mut quads = Vec::new();
        for i in 0..self.values.len() {
            let corner = self.at(i);
            for axis in 0..3 {
                let (along, u, v) = (AXES[axis], AXES[(axis + 1) % 3], AXES[(axis + 2) % 3]);
                if (corner + along).cmpge(self.samples).any()
                    || self.inside(corner) == self.inside(corner + along)
                {
                    continue;
                }
                let mut quad = [corner, corner - u, corner - u - v, corner - v]
                    .map(|corner| vertex_of[self.index(corner)]);
                if !self.inside(corner) {
                    quad.reverse();
                }
                quads.push(quad);
            }
        }
        quads
    }
}

/// The mean of the neighbours of each vertex.
fn neighbour_means(positions: &[DVec3], quads: &[[usize; 4]]) -> Vec<DVec3> {
    let mut sums = vec![(DVec3::ZERO, 0.0); positions.len()];
    for quad in quads {
        // Each edge belongs to two quads, once in each direction.
        for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let sum = &mut sums[quad[a]];
            sum.0 += positions[quad[b]];
            sum.1 += 1.0;
        }
    }
    sums.iter().map(|&(sum, count)| sum / count).collect()
}

/// Two triangles along the shorter diagonal, which makes the rounder pair.
fn split([a, b, c, d]: [usize; 4], positions: &[DVec3]) -> [[usize; 3]; 2] {
    let length = |i: usize, j: usize| positions[i].distance_squared(positions[j]);
    if length(a, c) <= length(b, d) {
        [[a, b, c], [a, c, d]]
    } else {
        [[b, c, d], [b, d, a]]
    }
}

fn cube() -> impl Iterator<Item = IVec3> {
    (0..8).map(|i| IVec3::new(i & 1, i >> 1 & 1, i >> 2))
}

fn gradient(field: &(dyn Fn(DVec3) -> f64 + Sync), p: DVec3, h: f64) -> DVec3 {
    let slope = |axis: DVec3| (field(p + h * axis) - field(p - h * axis)) / (2.0 * h);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
}

use std::fmt::Write;

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Error;

use super::Mesh;

/// What keeps a mesh from enclosing a solid. Vertices in one place count as one vertex, and triangles with two corners
/// in one place do not count.
#[derive(Clone, Debug, PartialEq)]
pub struct Openness {
    /// Edges of one triangle only.
    pub boundary: usize,
    /// Edges of two triangles that wind against each other.
    pub flipped: usize,
    /// Edges of more triangles, not as many running along it one way as the other.
    pub nonmanifold: usize,
    /// Connected pieces of the boundary: holes, mostly.
    pub loops: usize,
    /// The first ten such edges, in the order of their triangles.
    pub edges: Vec<OpenEdge>,
    /// The volume inside, negative where the triangles face inward; of no meaning where there are open edges.
    pub volume: f64,
}

/// An edge at which a mesh is not closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEdge {
    /// What is wrong.
    pub fault: EdgeFault,
    /// The ends, in the direction in which the triangle runs.
    pub ends: [Vec3; 2],
    /// The first of its triangles.
    pub triangle: u32,
}

/// How an edge can fail to close a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeFault {
    /// It has one triangle only.
    Boundary,
    /// Its two triangles wind against each other.
    Flipped,
    /// It has more than two triangles, which do not pair up.
    NonManifold,
}

/// A triangle's side, its ends being welded vertices.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    low: u32,
    high: u32,
    triangle: u32,
    /// Whether the triangle runs from `low` to `high`.
    up: bool,
}

/// How many open edges are kept.
const SHOWN: usize = 10;

impl Mesh {
    /// What keeps the mesh, a valid one, from being closed; `None` where it is: along every edge as many triangles run
    /// one way as the other, so that it winds around each point a whole number of times, and the volume inside is
    /// above 0.
    pub fn openness(&self) -> Option<Openness> {
        let welded = self.welded();
        let sides = self.sides(&welded);
        let mut found = Openness {
            boundary: 0,
            flipped: 0,
            nonmanifold: 0,
            loops: 0,
            edges: Vec::new(),
            volume: self.signed_volume(),
        };
        let (mut open, mut boundary) = (Vec::new(), Vec::new());
        for edge in sides.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
            let up = edge.iter().filter(|side| side.up).count();
            if 2 * up == edge.len() {
                continue;
            }
            let (fault, count) = match edge.len() {
                1 => (EdgeFault::Boundary, &mut found.boundary),
                2 => (EdgeFault::Flipped, &mut found.flipped),
                _ => (EdgeFault::NonManifold, &mut found.nonmanifold),
            };
            *count += 1;
            if fault == EdgeFault::Boundary {
                boundary.push([edge[0].low, edge[0].high]);
            }
            open.push((edge[0], fault));
        }
        if open.is_empty() && found.volume > 0.0 {
            return None;
        }
        open.sort_unstable_by_key(|(side, _)| (side.triangle, side.low, side.high));
        found
            .edges
            .extend(open.iter().take(SHOWN).map(|&(side, fault)| {
                let [low, high] = [side.low, side.high].map(|v| self.positions[v as usize]);
                OpenEdge {
                    fault,
                    ends: if side.up { [low, high] } else { [high, low] },
                    triangle: side.triangle,
                }
            }));
        found.loops = pieces(&boundary);
        Some(found)
    }

    /// For each vertex the one in its place that stands for all of them.
    fn welded(&self) -> Vec<u32> {
        let mut order: Vec<([u32; 3], u32)> = (self.positions.par_iter().enumerate())
            // Adding 0 makes -0 and 0 one.
            .map(|(i, p)| ((*p + Vec3::ZERO).to_array().map(f32::to_bits), i as u32))
            .collect();
        order.par_sort_unstable();
        let mut welded = vec![0; order.len()];
        for place in order.chunk_by(|a, b| a.0 == b.0) {
            for (_, vertex) in place {
                welded[*vertex as usize] = place[0].1;
            }
        }
        welded
    }

    /// All sides of the triangles that have three corners, the sides of one edge together.
    fn sides(&self, welded: &[u32]) -> Vec<Side> {
        let mut sides: Vec<Side> = (self.triangles.par_iter().enumerate())
            .flat_map_iter(|(i, triangle)| {
                let [a, b, c] = triangle.map(|v| welded[v as usize]);
                let cornered = a != b && b != c && c != a;
                let sides = cornered.then_some([(a, b), (b, c), (c, a)]);
                sides.into_iter().flatten().map(move |(from, to)| Side {
                    low: from.min(to),
                    high: from.max(to),
                    triangle: i as u32,
                    up: from < to,
                })
            })
            .collect();
        sides.par_sort_unstable();
        sides
    }

    /// By the divergence theorem, measured from one of its points so that a place far away costs no digits.
    fn signed_volume(&self) -> f64 {
        let Some(&[first, ..]) = self.triangles.first() else {
            return 0.0;
        };
        let origin = self.positions[first as usize].as_dvec3();
        let six_times: f64 = (0..self.triangles.len() as u32)
            .map(|i| {
                let [a, b, c] = self.corners(i).map(|p| p.as_dvec3() - origin);
                a.dot(b.cross(c))
            })
            .sum();
        six_times / 6.0
    }
}

/// The number of connected pieces that edges between vertices make.
fn pieces(edges: &[[u32; 2]]) -> usize {
    let mut vertices: Vec<u32> = edges.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    // Union-find: each vertex's parent, a root being its own.
    let mut parent: Vec<usize> = (0..vertices.len()).collect();
    let mut pieces = vertices.len();
    for edge in edges {
        let [a, b] = edge.map(|v| {
            let mut at = vertices.partition_point(|&known| known < v);
            while parent[at] != at {
                parent[at] = parent[parent[at]];
                at = parent[at];
            }
            at
        });
        if a != b {
            parent[a] = b;
            pieces -= 1;
        }
    }
    pieces
}

impl Openness {
    /// How many edges are open.
    pub fn open_edges(&self) -> usize {
        self.boundary + self.flipped + self.nonmanifold
    }

    /// The error that it is as an operand of CSG: the counts, then the first edges one a line. `name` is the mesh's in
    /// its file, and `line` tells the line there of a triangle where it is known.
    pub fn error(&self, name: Option<&str>, line: impl Fn(u32) -> Option<u32>) -> Error {
        let mesh = name.map_or("the mesh".to_owned(), |name| format!("the mesh `{name}`"));
        if self.open_edges() == 0 {
            return self.inverted(&mesh);
        }
        let counted = |count: usize, what: &str| {
            format!("{count} {what}{}", if count == 1 { "" } else { "s" })
        };
        let mut message = format!(
            "{mesh} is not closed: {} in {}, {}, {}",
            counted(self.boundary, "boundary edge"),
            counted(self.loops, "loop"),
            counted(self.flipped, "flipped edge"),
            counted(self.nonmanifold, "non-manifold edge"),
        );
        for edge in &self.edges {
            let fault = match edge.fault {
                EdgeFault::Boundary => "boundary",
                EdgeFault::Flipped => "flipped",
                EdgeFault::NonManifold => "non-manifold",
            };
            let [from, to] = edge.ends.map(|p| format!("({}, {}, {})", p.x, p.y, p.z));
            let place = line(edge.triangle).map_or(String::new(), |line| format!(", line {line}"));
            let _ = write!(
                message,
                "\n   {fault}: {from} to {to}, triangle {}{place}",
                edge.triangle
            );
        }
        if self.open_edges() > self.edges.len() {
            let _ = write!(
                message,
                "\n   and {} more",
                self.open_edges() - self.edges.len()
            );
        }
        Error::input(message).help(
            "CSG needs to know what is inside: fill the holes, or turn the flipped triangles over, in a modelling \
             program, or let `--open-mesh-operands winding` judge by the generalized winding number",
        )
    }

    fn inverted(&self, mesh: &str) -> Error {
        if self.volume < 0.0 {
            Error::input(format!("{mesh} is inside out: its volume is {}", self.volume)).help(
                "its triangles wind clockwise seen from outside; flip all of them in a modelling program",
            )
        } else {
            Error::input(format!("{mesh} encloses no volume"))
                .help("CSG needs a solid: a closed mesh with an inside")
        }
    }
}

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DMat3, DVec3, Mat3, Vec3, Vec3A};
use obvhs::aabb::Aabb;

use crate::geometry::Solid;
use crate::math::{Bounds, Ray};

use super::build::{self, MAX_DEPTH, Topology};
use super::mesh::MeshTree;
use super::triangle::Triangle;

/// The generalized winding number of any mesh (Jacobson, Kavan, Sorkine-Hornung 2013): the solid angle under which a
/// point sees the triangles, over 4 pi. Around a closed mesh it is a whole number; across holes and gaps it passes
/// smoothly from the one of the inside to the one of the outside, and where it is above 1/2 counts as inside.
///
/// Far groups of triangles are taken together (Barill et al. 2018), which changes the number by less than 0.002.
#[derive(Debug)]
pub(super) struct WindingNumber {
    pub mesh: Arc<MeshTree>,
    tree: Topology,
    /// In the order of the tree's leaves, relative to the mesh's centre.
    triangles: Vec<Triangle>,
    /// One for each inner node of the tree.
    clusters: Vec<Cluster>,
}

/// A group of triangles, seen from afar: the Taylor expansion of its solid angle about `center`. Its moments are
/// integrals over the triangles, y being the point's place from `center` in units of `radius`, n the normal. Traces,
/// to which the solid angle is blind, are taken out.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    /// Middle of the triangles, weighted by area.
    center: DVec3,
    /// No triangle reaches farther from there.
    radius: f64,
    /// n.
    normal: Vec3,
    /// y nᵀ.
    spread: Mat3,
    /// y yᵀ times each component of n.
    bend: [Mat3; 3],
}

/// What a cluster is put together from: its moments as they are.
#[derive(Clone, Copy, Debug)]
struct Part {
    area: f64,
    center: DVec3,
    radius: f64,
    bounds: Bounds,
    normal: DVec3,
    spread: DMat3,
    bend: [DMat3; 3],
}

/// A place where a ray passes from the outside to the inside or back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OpenCrossing {
    /// Ray parameter.
    pub t: f64,
    /// The triangle at which it does, whichever way that one faces; `None` in a hole, where [`WindingNumber::fall`]
    /// has the direction to the outside.
    pub primitive: Option<u32>,
    /// Whether it comes in.
    pub enter: bool,
}

/// What taking groups together mostly changes the number by; at worst ten times that.
pub(super) const APPROXIMATION: f64 = 0.0002;

/// Triangles in the smallest group.
const GROUP: u32 = 4;

/// Groups farther than this many radii are taken together.
const FAR: f64 = 3.0;

/// A ray's place where the inside can change, with the triangle that it crosses there.
#[derive(Clone, Copy)]
struct Knot {
    t: f64,
    primitive: Option<u32>,
}

impl WindingNumber {
    /// Over a tree that [`MeshTree::build_operand`] made.
    pub(super) fn new(mesh: Arc<MeshTree>) -> Self {
        let triangles: Vec<Triangle> = mesh.triangles().collect();
        let boxes: Vec<Aabb> = (triangles.iter())
            .map(|triangle| Aabb::from_points(&triangle.corners.map(Vec3A::from)))
            .collect();
        let tree = build::build(&boxes, GROUP);
        let triangles: Vec<Triangle> = (tree.order.iter())
            .map(|&i| triangles[i as usize])
            .collect();
        let mut parts = vec![Part::NOTHING; tree.children.len()];
        for node in (0..parts.len()).rev() {
            for child in tree.children[node] {
                let child = if child.count == 0 {
                    parts[child.first as usize]
                } else {
                    let leaf = child.first as usize..(child.first + child.count) as usize;
                    (triangles[leaf].iter())
                        .map(Part::of)
                        .fold(Part::NOTHING, Part::union)
                };
                parts[node] = parts[node].union(child);
            }
        }
        Self {
            clusters: parts.into_iter().map(Part::cluster).collect(),
            tree,
            triangles,
            mesh,
        }
    }

    /// The number of `p`.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let p = p - self.mesh.center;
        self.number(p, p)
    }

    /// Whether `p` counts as inside.
    pub(super) fn contains(&self, p: DVec3) -> bool {
        self.at(p) > 0.5
    }

    /// How fast the number falls and in which direction: to the outside, for a point in a hole.
    pub(super) fn fall(&self, p: DVec3) -> DVec3 {
        let p = p - self.mesh.center;
        let step = f64::from(self.mesh.extent) * 2.0_f64.powi(-16);
        let slope = DVec3::AXES
            .map(|axis| self.number(p - step * axis, p) - self.number(p + step * axis, p));
        DVec3::from_array(slope) / (2.0 * step)
    }

    /// The number of `p` relative to the tree's centre, with groups taken together that are far from `near`.
    fn number(&self, p: DVec3, near: DVec3) -> f64 {
        let tree = &self.tree;
        let mut stack = [tree.root; MAX_DEPTH + 1];
        let mut height = 1;
        let mut angle = 0.0;
        while height > 0 {
            height -= 1;
            let link = stack[height];
            if link.count > 0 {
                let leaf = link.first as usize..(link.first + link.count) as usize;
                angle += self.triangles[leaf]
                    .iter()
                    .map(|triangle| solid_angle(triangle, p))
                    .sum::<f64>();
                continue;
            }
            let cluster = &self.clusters[link.first as usize];
            if cluster.center.distance_squared(near) > (FAR * cluster.radius).powi(2) {
                angle += cluster.solid_angle(p);
            } else {
                for child in tree.children[link.first as usize] {
                    stack[height] = child;
                    height += 1;
                }
            }
        }
        angle / (2.0 * TAU)
    }

    /// Where `ray` passes from outside to inside and back beyond `ray.tmin`, in order: enter and exit take turns, and
    /// the last is an exit, so that a ray whose first crossing is an exit starts inside. Nothing outside of the mesh's
    /// box is inside.
    ///
    /// Between neighbouring triangles on the ray the number is looked at near both ends and in the middle; what comes
    /// and goes between two of these is not seen.
    pub(super) fn open_crossings(&self, ray: &Ray, mut visit: impl FnMut(OpenCrossing)) {
        let bounds = self.mesh.bounds;
        let around = Ray {
            origin: ray.origin - bounds.center(),
            ..*ray
        };
        let spans = Solid::Box {
            half: 0.5 * bounds.size(),
        }
        .spans(&around);
        let Some(span) = spans.iter().next().filter(|span| span.exit.t > ray.tmin) else {
            return;
        };
        // Far above the rounding of t and of points, far below what can be seen.
        let reach =
            f64::from(self.mesh.extent) + (ray.origin - self.mesh.center).abs().max_element();
        let close = reach * 2.0_f64.powi(-44) / ray.direction.abs().max_element();
        let start = ray.tmin.max(span.enter.t);
        let knots = self.knots(ray, start, span.exit.t, 4.0 * close);

        let mut inside = start == ray.tmin && self.contains(ray.at(knots[0].t + close));
        let mut report = |t: f64, primitive: Option<u32>, enter: bool| {
            visit(OpenCrossing {
                t,
                primitive,
                enter,
            });
        };
        for ends in knots.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            let mut before = from.t + close;
            if self.contains(ray.at(before)) != inside {
                inside = !inside;
                report(from.t, from.primitive, inside);
            }
            for t in [0.5 * (from.t + to.t), to.t - close] {
                if self.contains(ray.at(t)) != inside {
                    inside = !inside;
                    report(self.passage(ray, before, t, close), None, inside);
                }
                before = t;
            }
        }
        if inside {
            let last = knots[knots.len() - 1];
            report(last.t, last.primitive, false);
        }
    }

    /// The triangles that `ray` crosses, in order, between the ends of its part in the box; those that lie closer than
    /// `gap` together are one, the lowest.
    fn knots(&self, ray: &Ray, start: f64, end: f64, gap: f64) -> Vec<Knot> {
        let mut knots: Vec<Knot> = [start, end].map(|t| Knot { t, primitive: None }).into();
        self.mesh.crossings(ray, |crossing| {
            knots.push(Knot {
                t: crossing.t,
                primitive: Some(crossing.primitive),
            });
        });
        knots.sort_unstable_by(|a, b| a.t.total_cmp(&b.t));
        knots.dedup_by(|later, kept| {
            let same = later.t - kept.t <= gap;
            if same && kept.primitive.is_none() {
                *kept = *later;
            } else if same && later.primitive.is_some() {
                kept.primitive = kept.primitive.min(later.primitive);
            }
            same
        });
        knots
    }

    /// Where between two places, one inside and the other outside, the number passes 1/2, to within `close`.
    fn passage(&self, ray: &Ray, mut from: f64, mut to: f64, close: f64) -> f64 {
        let inside = self.contains(ray.at(from));
        while to - from > close {
            let middle = 0.5 * (from + to);
            if self.contains(ray.at(middle)) == inside {
                from = middle;
            } else {
                to = middle;
            }
        }
        0.5 * (from + to)
    }
}

impl Part {
    const NOTHING: Self = Self {
        area: 0.0,
        center: DVec3::ZERO,
        radius: 0.0,
        bounds: Bounds::EMPTY,
        normal: DVec3::ZERO,
        spread: DMat3::ZERO,
        bend: [DMat3::ZERO; 3],
    };

    fn of(triangle: &Triangle) -> Self {
        let corners = triangle.corners.map(Vec3::as_dvec3);
        let [a, b, c] = corners;
        let normal = 0.5 * (b - a).cross(c - a);
        let center = (a + b + c) / 3.0;
        // The mean of y yᵀ over a triangle is a twelfth of the corners' sum.
        let square: DMat3 = (corners.iter())
            .map(|&corner| outer(corner - center, corner - center) / 12.0)
            .sum();
        Self {
            area: normal.length(),
            center,
            radius: (corners.iter()).fold(0.0, |r, corner| r.max(corner.distance(center))),
            bounds: Bounds::of_points(corners),
            normal,
            spread: DMat3::ZERO,
            bend: normal.to_array().map(|n| n * square),
        }
    }

    fn union(self, other: Self) -> Self {
        let area = self.area + other.area;
        let bounds = self.bounds.union(other.bounds);
        let center = if area > 0.0 {
            (self.area * self.center + other.area * other.center) / area
        } else {
            bounds.center()
        };
        let [a, b] = [self.about(center), other.about(center)];
        let farthest = (center - bounds.min).max(bounds.max - center).length();
        Self {
            area,
            center,
            radius: a.radius.max(b.radius).min(farthest),
            bounds,
            normal: a.normal + b.normal,
            spread: a.spread + b.spread,
            bend: [0, 1, 2].map(|i| a.bend[i] + b.bend[i]),
        }
    }

    fn about(self, center: DVec3) -> Self {
        let shift = self.center - center;
        Self {
            center,
            radius: self.radius + shift.length(),
            spread: self.spread + outer(shift, self.normal),
            bend: [0, 1, 2].map(|i| {
                let s = self.spread.col(i);
                self.bend[i]
                    + outer(s, shift)
                    + outer(shift, s)
                    + self.normal[i] * outer(shift, shift)
            }),
            ..self
        }
    }

    fn cluster(self) -> Cluster {
        let trace = |m: DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
        let [x, y, z] = self.bend;
        let vector = DVec3::from_array(
            [0, 1, 2].map(|i| 2.0 * (x.col(i).x + y.col(i).y + z.col(i).z) + trace(self.bend[i])),
        );
        let unit = self.radius.recip();
        let square = unit * unit;
        Cluster {
            center: self.center,
            radius: self.radius,
            normal: (self.normal * square).as_vec3(),
            spread: ((self.spread - DMat3::IDENTITY * (trace(self.spread) / 3.0))
                * (square * unit))
                .as_mat3(),
            bend: [0, 1, 2].map(|i| {
                ((self.bend[i] - DMat3::IDENTITY * (vector[i] / 5.0)) * (square * square)).as_mat3()
            }),
        }
    }
}

impl Cluster {
    /// The first three terms of the integral of x·n / |x|³, x from `p`: derivatives of 1 / |x| times the moments.
    fn solid_angle(&self, p: DVec3) -> f64 {
        let d = (self.center - p) / self.radius;
        let square = d.length_squared();
        let [x, y, z] = self.bend.map(|m| m.as_dmat3());
        let normal = d.dot(self.normal.as_dvec3());
        let spread = d.dot(self.spread.as_dmat3() * d);
        let bend = d.dot((x * d.x + y * d.y + z * d.z) * d);
        (normal + (7.5 * bend / square - 3.0 * spread) / square) / (square * square.sqrt())
    }
}

/// Van Oosterom and Strackee 1983, equation 8; positive where the triangle faces away from `p`. The determinant is
/// taken from the edges, so that its sign holds near slivers.
fn solid_angle(triangle: &Triangle, p: DVec3) -> f64 {
    let corners = triangle.corners.map(Vec3::as_dvec3);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let [a, b, c] = corners.map(|corner| corner - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(normal).atan2(denominator)
}

/// The matrix u vᵀ.
fn outer(u: DVec3, v: DVec3) -> DMat3 {
    DMat3::from_cols(u * v.x, u * v.y, u * v.z)
}

#[cfg(test)]
mod tests;

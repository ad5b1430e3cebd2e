use glam::{DVec2, DVec3, Vec2, Vec3, Vec3Swizzles};

use super::ray::{ExactRay, TreeRay};

/// A triangle's corners relative to its tree's centre, exact, with its index in the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub corners: [Vec3; 3],
    pub primitive: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleHit {
    /// Ray parameter.
    pub t: f64,
    /// Barycentric weights of the second and third corner.
    pub u: f64,
    pub v: f64,
    /// Whether the ray comes from the side that the triangle faces away from.
    pub inside: bool,
}

/// A triangle as the ray sees it: sheared so that the ray is the third axis.
struct View {
    corners: [DVec3; 3],
    /// Twice the areas of the triangles that the ray makes with the sides opposite to the corners, positive where it
    /// has the side on its right.
    edges: DVec3,
}

/// Coordinates below this are taken for 0, so that products of two of them and their roundings do not underflow.
pub(super) const TINY: f64 = f64::from_bits((1023 - 400) << 52);

impl Triangle {
    /// Where the ray meets the triangle, its edges included.
    ///
    /// The test is that of Woop, Benthin and Wald 2013: corners are sheared into the ray's frame by operations that
    /// depend on the corner alone, and signs of edge functions are exact from there on, so triangles that share an
    /// edge or a corner leave no gap. f32 turns away what certainly misses; what is left is decided in f64.
    ///
    /// This is the part in f64, for corners whose axes are in the ray's order.
    #[inline(always)]
    pub(super) fn intersect(ray: &ExactRay, corners: [[f32; 3]; 3]) -> Option<TriangleHit> {
        let view = View::new(ray, corners);
        view.met().then(|| view.hit(ray.length))
    }

    /// The same for a ray that is given by what an [`ExactRay`] says of its direction, and corners relative to its
    /// origin.
    #[inline(always)]
    pub(super) fn intersect_from_origin(
        shear: [f64; 2],
        length: f64,
        corners: [[f64; 3]; 3],
    ) -> Option<TriangleHit> {
        let view = View::from_origin(shear, corners);
        view.met().then(|| view.hit(length))
    }

    /// Where the ray goes through the triangle. Of the triangles around an edge or a corner that the ray hits exactly,
    /// those answer that a ray beside it, at no distance, would go through: along a whole line a closed mesh is
    /// entered as often as it is left.
    pub(super) fn crossing(&self, ray: &TreeRay, exact: &ExactRay) -> Option<TriangleHit> {
        if self.missed(ray) {
            None
        } else {
            self.decide_crossing(ray, exact)
        }
    }

    /// [`Triangle::crossing`] without the filter.
    pub(super) fn decide_crossing(&self, ray: &TreeRay, exact: &ExactRay) -> Option<TriangleHit> {
        let view = self.view(ray, exact);
        view.crossed().then(|| view.hit(exact.length))
    }

    /// Barycentric weights of the second and third corner where the ray goes through the triangle; for a ray that
    /// misses it by a little, those of a point on its edge.
    pub(super) fn weights(&self, ray: &TreeRay, exact: &ExactRay) -> DVec2 {
        let edges = self.view(ray, exact).edges;
        let facing = (edges * edges.element_sum().signum()).max(DVec3::ZERO);
        let det = facing.element_sum();
        if det > 0.0 {
            facing.yz() / det
        } else {
            DVec2::splat(1.0 / 3.0)
        }
    }

    /// Outward, of any length.
    pub(super) fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        (b - a).cross(c - a)
    }

    #[inline]
    fn missed(&self, ray: &TreeRay) -> bool {
        let mut p = [Vec2::ZERO; 3];
        let mut size = 0.0_f32;
        for (p, corner) in p.iter_mut().zip(self.seen_along(ray)) {
            let z = corner[2] - ray.origin[2];
            p.x = corner[0] - ray.origin[0] - z * ray.shear[0];
            p.y = corner[1] - ray.origin[1] - z * ray.shear[1];
            size = size.max(p.x.abs()).max(p.y.abs());
        }
        let [a, b, c] = p;
        let edge = |p: Vec2, q: Vec2| q.x * p.y - q.y * p.x;
        let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
        let doubt = ray.doubt(size);
        u.min(v).min(w) < -doubt && u.max(v).max(w) > doubt
    }

    fn view(&self, ray: &TreeRay, exact: &ExactRay) -> View {
        View::new(exact, self.seen_along(ray))
    }

    /// The corners' coordinates in the order of the ray's axes.
    fn seen_along(&self, ray: &TreeRay) -> [[f32; 3]; 3] {
        self.corners
            .map(|corner| ray.axes.map(|axis| corner[axis as usize]))
    }
}

impl View {
    /// Of the triangle with these corners, their axes in the ray's order.
    #[inline(always)]
    fn new(ray: &ExactRay, corners: [[f32; 3]; 3]) -> Self {
        let [a, b, c] = corners;
        let relative = [relative(ray, a), relative(ray, b), relative(ray, c)];
        Self::from_origin(ray.shear, relative)
    }

    /// Corners are relative to the ray's origin.
    #[inline(always)]
    fn from_origin(shear: [f64; 2], corners: [[f64; 3]; 3]) -> Self {
        let corners = [
            sheared(shear, corners[0]),
            sheared(shear, corners[1]),
            sheared(shear, corners[2]),
        ];
        let [a, b, c] = corners;
        Self {
            corners,
            edges: DVec3::new(edge(b, c), edge(c, a), edge(a, b)),
        }
    }

    /// Whether edge functions have one sign, zeros aside.
    #[inline(always)]
    fn met(&self) -> bool {
        let DVec3 { x: u, y: v, z: w } = self.edges;
        let front = (u >= 0.0) & (v >= 0.0) & (w >= 0.0);
        let back = (u <= 0.0) & (v <= 0.0) & (w <= 0.0);
        (front | back) & ((u != 0.0) | (v != 0.0) | (w != 0.0))
    }

    /// For a triangle whose edge functions have one sign, zeros aside.
    #[inline(always)]
    fn hit(&self, length: f64) -> TriangleHit {
        let [a, b, c] = self.corners;
        let det = self.edges.element_sum();
        TriangleHit {
            t: self.edges.dot(DVec3::new(a.z, b.z, c.z)) / (det * length),
            u: self.edges.y / det,
            v: self.edges.z / det,
            inside: (det < 0.0) == (length > 0.0),
        }
    }

    /// Whether the ray goes through. Where an edge function is 0, its sign is that for a ray moved by a little along the
    /// first axis and far less along the second (symbolic perturbation, Edelsbrunner and Muecke 1990); an edge that is
    /// seen as a point bounds no area.
    fn crossed(&self) -> bool {
        let [a, b, c] = self.corners;
        let signs = DVec3::new(
            moved(self.edges.x, b, c),
            moved(self.edges.y, c, a),
            moved(self.edges.z, a, b),
        );
        signs.min_element() > 0.0 || signs.max_element() < 0.0
    }
}

#[inline(always)]
fn relative(ray: &ExactRay, corner: [f32; 3]) -> [f64; 3] {
    [
        f64::from(corner[0]) - ray.origin[0],
        f64::from(corner[1]) - ray.origin[1],
        f64::from(corner[2]) - ray.origin[2],
    ]
}

#[inline(always)]
fn sheared(shear: [f64; 2], [x, y, z]: [f64; 3]) -> DVec3 {
    DVec3::new(seen(x - z * shear[0]), seen(y - z * shear[1]), z)
}

#[inline(always)]
fn seen(x: f64) -> f64 {
    if x.abs() < TINY { 0.0 } else { x }
}

/// `q.x p.y - q.y p.x` with an exact sign: rounding keeps the order of products, and of equal ones the residuals,
/// which `mul_add` gives exactly, tell.
#[inline(always)]
fn edge(p: DVec3, q: DVec3) -> f64 {
    let (right, left) = (q.x * p.y, q.y * p.x);
    if right == left {
        q.x.mul_add(p.y, -right) - q.y.mul_add(p.x, -left)
    } else {
        right - left
    }
}

/// The sign of `edge`, the value of `edge(p, q)`, after the perturbation.
fn moved(edge: f64, p: DVec3, q: DVec3) -> f64 {
    if edge != 0.0 {
        edge
    } else if p.y != q.y {
        q.y - p.y
    } else {
        p.x - q.x
    }
}

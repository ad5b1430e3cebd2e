use glam::{DVec3, Vec2, Vec3};

use super::Mesh;

/// For each vertex of a mesh the direction in which u grows, smooth over the surface: once for triangles on which u and
/// v turn as seen from outside, once for those with mirrored coordinates.
///
/// The normal maps of `MikkTSpace` (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited") are made for such
/// directions: a triangle's own, projected to the plane of the vertex normal and weighted by the corner's angle.
#[derive(Clone, Debug)]
pub struct Tangents(Vec<[Vec3; 2]>);

impl Tangents {
    /// Of a mesh with normals and texture coordinates.
    pub fn of(mesh: &Mesh) -> Self {
        let mut sums = vec![[DVec3::ZERO; 2]; mesh.positions.len()];
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            let i = i as u32;
            let corners = mesh.corners(i).map(Vec3::as_dvec3);
            let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let Some((tangent, _)) = uv_axes(mesh.uv_gradients(i), flat) else {
                continue;
            };
            for k in 0..3 {
                let vertex = triangle[k] as usize;
                let normal = mesh.normals[vertex].as_dvec3();
                let normal = normal.try_normalize().unwrap_or(flat.normalize());
                let level = |v: DVec3| v.reject_from_normalized(normal);
                let [to_next, to_last] =
                    [1, 2].map(|step| level(corners[(k + step) % 3] - corners[k]));
                let angle = to_next.angle_between(to_last);
                let tangent = level(tangent).normalize_or_zero();
                if angle.is_finite() {
                    sums[vertex][mirrored(mesh, i)] += angle * tangent;
                }
            }
        }
        let unit = |sum: DVec3| sum.normalize_or_zero().as_vec3();
        Self(sums.into_iter().map(|both| both.map(unit)).collect())
    }

    /// The direction at a point of a triangle, not of unit length; `weights` are those of its second and third corner.
    pub fn at(&self, mesh: &Mesh, triangle: u32, weights: Vec2) -> DVec3 {
        let kind = mirrored(mesh, triangle);
        let [a, b, c] = mesh.triangles[triangle as usize].map(|v| self.0[v as usize][kind]);
        let first = 1.0 - weights.x - weights.y;
        (first * a + weights.x * b + weights.y * c).as_dvec3()
    }
}

/// 1 where surface coordinates run the other way round than seen from outside, else 0.
fn mirrored(mesh: &Mesh, triangle: u32) -> usize {
    let [a, b, c] = mesh.uv_corners(triangle);
    usize::from((b - a).perp_dot(c - a) < 0.0)
}

/// The unit vector along a surface with normal `n` (of any length) on which u grows and v stays, and 1 where v grows to
/// its left as seen from outside, -1 where to its right; `None` where the gradients of `u` and `v` are no coordinates.
pub fn uv_axes([u, v]: [DVec3; 2], n: DVec3) -> Option<(DVec3, f64)> {
    let side = n.dot(u.cross(v)).signum();
    let tangent = (side * v.cross(n)).try_normalize()?;
    (u.dot(tangent) > 0.0).then_some((tangent, side))
}

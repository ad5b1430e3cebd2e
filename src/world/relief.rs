//! How surface coordinates lie around a point, and the shading normals that bumps and normal maps bend, in object space.

use glam::{DVec2, DVec3};

use crate::accel::{HOLE, Hit};
use crate::geometry::{Operand, Shape, Tangents, uv_axes};
use crate::material::{MaterialId, Relief};
use crate::math::Transform;
use crate::scene::{Instance, Scene};
use crate::texture::{Texture, TexturePoint};

use super::World;
use super::surface::LocalPoint;

/// How surface coordinates lie around a point.
struct Coordinates {
    /// Of u and v.
    gradients: [DVec3; 2],
    /// Where u grows as a smooth mesh has it.
    smooth: Option<DVec3>,
}

impl Coordinates {
    /// Where u grows on a surface of normal `n`, and the side on which v does, as [`uv_axes`] has it.
    fn axes(&self, n: DVec3) -> Option<(DVec3, f64)> {
        let (flat, side) = uv_axes(self.gradients, n)?;
        Some((self.smooth.unwrap_or(flat), side))
    }
}

impl World {
    /// Where the first surface coordinate grows, of any length; 0 where that is nowhere.
    pub(super) fn tangent(&self, instance: &Instance, hit: &Hit, at: &LocalPoint) -> DVec3 {
        let axes = self.coordinates(instance, hit, at).axes(at.n);
        axes.map_or(DVec3::ZERO, |(tangent, _)| tangent)
    }

    /// The shading normal that `relief` makes of a point's own.
    pub(super) fn bent(
        &self,
        relief: &Relief,
        instance: &Instance,
        hit: &Hit,
        at: &LocalPoint,
    ) -> DVec3 {
        let own = at.shading.and_then(DVec3::try_normalize);
        let n = own.map_or(at.n, |n| if n.dot(at.n) < 0.0 { -n } else { n });
        let coordinates = self.coordinates(instance, hit, at);
        let point = at.texture_point();
        match relief {
            Relief::Bump { texture, height } => {
                bumped(texture, *height, &point, n, coordinates.gradients)
            }
            Relief::NormalMap { texture, scale } => {
                mapped(texture, *scale, &point, n, &coordinates)
            }
        }
    }

    fn coordinates(&self, instance: &Instance, hit: &Hit, at: &LocalPoint) -> Coordinates {
        let (operand, place, face) = match instance.shape {
            Shape::Solid(solid) => (Operand::Solid(solid), Transform::IDENTITY, hit.face),
            Shape::Mesh(id) => (Operand::Mesh(id), Transform::IDENTITY, hit.primitive),
            Shape::Csg(id) => {
                let csg = &self.scene.csgs[id.0 as usize];
                let (operand, place) = csg.operand(hit.primitive);
                (operand, place, hit.face)
            }
        };
        let (gradients, smooth) = match operand {
            Operand::Solid(solid) => (solid.uv_gradients(place.inverse_point(at.p), face), None),
            Operand::OpenMesh(_) if face == HOLE => ([DVec3::ZERO; 2], None),
            Operand::Mesh(id) | Operand::OpenMesh(id) => {
                let mesh = &self.scene.meshes[id.0 as usize];
                let tangents = self.tangents[id.0 as usize].as_ref();
                let tangents = tangents.filter(|_| instance.smooth);
                let smooth = tangents.map(|t| place.vector(t.at(mesh, face, hit.uv)));
                (mesh.uv_gradients(face), smooth)
            }
        };
        Coordinates {
            gradients: gradients.map(|g| place.gradient(g)),
            smooth,
        }
    }
}

/// The normal of the surface raised along `n` by `height` times the texture (Blinn 1978): `n` less the slope.
fn bumped(
    texture: &Texture,
    height: f64,
    point: &TexturePoint,
    n: DVec3,
    [u, v]: [DVec3; 2],
) -> DVec3 {
    let (x, y) = n.any_orthonormal_pair();
    let slope = |t: DVec3| texture.slope(point, t, DVec2::new(u.dot(t), v.dot(t)));
    n - height * (slope(x) * x + slope(y) * y)
}

/// The map's vector in the frame of `n` and the direction in which u grows; `n` where that has none.
fn mapped(
    texture: &Texture,
    scale: f64,
    point: &TexturePoint,
    n: DVec3,
    coordinates: &Coordinates,
) -> DVec3 {
    let Some((tangent, side)) = coordinates.axes(point.n) else {
        return n;
    };
    let Some(tangent) = tangent.reject_from_normalized(n).try_normalize() else {
        return n;
    };
    let map = 2.0 * texture.eval(point).as_dvec3() - 1.0;
    scale * (map.x * tangent + map.y * side * n.cross(tangent)) + map.z * n
}

/// The tangents of the meshes that show a normal map, or are brushed, on smooth normals.
pub(super) fn tangents(scene: &Scene) -> Vec<Option<Tangents>> {
    let mut tangents = vec![None; scene.meshes.len()];
    for instance in scene.instances.iter().filter(|instance| instance.smooth) {
        let turned = |m: &MaterialId| {
            let material = &scene.materials[m.0 as usize];
            matches!(material.relief, Some(Relief::NormalMap { .. }))
                || material.surface.is_brushed()
        };
        if !instance.materials.iter().any(turned) {
            continue;
        }
        let meshes = match instance.shape {
            Shape::Solid(_) => Vec::new(),
            Shape::Mesh(id) => vec![id],
            Shape::Csg(id) => scene.csgs[id.0 as usize].meshes(),
        };
        for id in meshes {
            let mesh = &scene.meshes[id.0 as usize];
            if !mesh.normals.is_empty() && !mesh.uvs.is_empty() {
                tangents[id.0 as usize].get_or_insert_with(|| Tangents::of(mesh));
            }
        }
    }
    tangents
}

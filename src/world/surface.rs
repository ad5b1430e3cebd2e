//! From a hit to a point ready for shading.

use glam::{DVec3, Vec2, Vec3};

use crate::accel::{HOLE, Hit};
use crate::geometry::{CsgId, MeshId, Operand, Shape, Solid};
use crate::light::Source;
use crate::material::MaterialId;
use crate::math::Ray;
use crate::scene::Instance;
use crate::texture::TexturePoint;

use super::World;

/// A point on a surface, ready for shading.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Where, in world space.
    pub p: DVec3,
    /// Whose surface.
    pub instance: u32,
    /// A ray must start this far off the surface so as not to meet it again.
    pub error: f64,
    /// Outward geometric normal.
    pub ng: Vec3,
    /// 1 where the ray came from the side of `ng`, -1 where it came from inside.
    pub side: f32,
    /// Shading normal, on the side of `ng`.
    pub ns: Vec3,
    /// Along the surface, where its first coordinate grows; of any length, and 0 where it has no such direction or
    /// looks the same when it is turned.
    pub tangent: Vec3,
    /// What textures see.
    pub texture: TexturePoint,
    /// The surface's material.
    pub material: MaterialId,
}

impl World {
    /// Asks memory for what [`Self::surface`] reads of `hits` that come soon, while the first one is worked on.
    #[inline]
    pub fn fetch_ahead(&self, hits: &[Option<Hit>]) {
        let on_mesh = |ahead: usize| {
            let hit = hits.get(ahead)?.as_ref()?;
            match self.instance(hit).shape {
                Shape::Mesh(id) => Some((&self.scene.meshes[id.0 as usize], hit.primitive)),
                _ => None,
            }
        };
        if let Some((mesh, triangle)) = on_mesh(8) {
            mesh.fetch_indices(triangle);
        }
        if let Some((mesh, triangle)) = on_mesh(4) {
            mesh.fetch_corners(triangle);
        }
    }

    /// The surface where `ray` was hit.
    #[inline(always)]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let instance = self.instance(hit);
        let transform = &instance.world_from_object;
        let local = transform.inverse_ray(ray);
        let at = match instance.shape {
            Shape::Solid(solid) => on_solid(solid, local.at(hit.t), hit.face),
            Shape::Mesh(id) => self.on_mesh(id, hit.primitive, hit.uv, instance.smooth),
            Shape::Csg(id) => self.on_csg(id, &local, hit, instance.smooth),
        };
        let ng = transform.normal(at.n).as_vec3();
        let id = instance.material(at.slot);
        let material = &self.scene.materials[id.0 as usize];
        let ns = match &material.relief {
            None => (at.shading)
                .map(|n| transform.normal(n).normalize().as_vec3())
                .filter(|n| n.is_finite())
                .map_or(ng, |n| if n.dot(ng) < 0.0 { -n } else { n }),
            Some(relief) => {
                let n = transform.normal(self.bent(relief, instance, hit, &at));
                above_horizon(n.normalize().as_vec3(), ng)
            }
        };
        let tangent = if material.surface.is_brushed() {
            transform.vector(self.tangent(instance, hit, &at)).as_vec3()
        } else {
            Vec3::ZERO
        };
        SurfacePoint {
            p: transform.point(at.p),
            instance: hit.instance,
            error: self.accel.error_at(hit, at.p, at.n),
            ng,
            side: if hit.inside { -1.0 } else { 1.0 },
            ns,
            tangent,
            texture: at.texture_point(),
            material: id,
        }
    }

    /// What textures see at the world's point `p` on the surface of a mesh's `triangle`, or the plane that it is in, or
    /// on a `face` of a solid.
    pub(super) fn texture_point(
        &self,
        instance: &Instance,
        triangle: u32,
        face: u32,
        p: DVec3,
    ) -> TexturePoint {
        let p = instance.world_from_object.inverse_point(p);
        let at = match instance.shape {
            Shape::Solid(solid) => on_solid(solid, p, face),
            Shape::Mesh(id) => {
                let mesh = &self.scene.meshes[id.0 as usize];
                self.on_mesh(id, triangle, mesh.weights(triangle, p), false)
            }
            Shape::Csg(_) => unreachable!("no light is of CSG"),
        };
        at.texture_point()
    }

    #[inline(always)]
    fn on_mesh(&self, id: MeshId, triangle: u32, weights: Vec2, smooth: bool) -> LocalPoint {
        let mesh = &self.scene.meshes[id.0 as usize];
        let corner = mesh.triangles[triangle as usize];
        let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
        let (ab, ac) = (b - a, c - a);
        let (v, w) = (weights.x, weights.y);
        let u = 1.0 - v - w;
        let shading = (smooth && !mesh.normals.is_empty()).then(|| {
            let [na, nb, nc] = corner.map(|i| mesh.normals[i as usize]);
            (u * na + v * nb + w * nc).as_dvec3()
        });
        let [ta, tb, tc] = mesh.uv_corners(triangle);
        LocalPoint {
            p: a + f64::from(v) * ab + f64::from(w) * ac,
            // An operand keeps triangles without area.
            n: ab.cross(ac).normalize_or(DVec3::Z),
            shading,
            uv: u * ta + v * tb + w * tc,
            slot: mesh.slot(triangle),
        }
    }

    /// A point on the surface of one operand, seen from the whole: where that is subtracted, its normals turn round.
    fn on_csg(&self, id: CsgId, ray: &Ray, hit: &Hit, smooth: bool) -> LocalPoint {
        let csg = &self.scene.csgs[id.0 as usize];
        let (operand, transform) = csg.operand(hit.primitive);
        let local = transform.inverse_ray(ray);
        let at = match operand {
            Operand::Solid(solid) => on_solid(solid, local.at(hit.t), hit.face),
            Operand::OpenMesh(_) if hit.face == HOLE => {
                let p = local.at(hit.t);
                LocalPoint {
                    p,
                    n: self.csg(id).hole_normal(hit.primitive, p),
                    shading: None,
                    uv: Vec2::ZERO,
                    slot: 0,
                }
            }
            Operand::Mesh(mesh) => self.on_mesh(mesh, hit.face, hit.uv, smooth),
            Operand::OpenMesh(mesh) => {
                // Its triangles may face either way.
                let mut at = self.on_mesh(mesh, hit.face, hit.uv, smooth);
                let enters = hit.inside == hit.negated;
                if (at.n.dot(local.direction) > 0.0) == enters {
                    at.n = -at.n;
                    at.shading = at.shading.map(|n| -n);
                }
                at
            }
        };
        let sign = if hit.negated { -1.0 } else { 1.0 };
        LocalPoint {
            p: transform.point(at.p),
            n: sign * transform.normal(at.n),
            shading: at.shading.map(|n| sign * transform.normal(n)),
            uv: at.uv,
            slot: csg.slot(hit.primitive, at.slot),
        }
    }
}

/// A point on a surface in the object's space.
pub(super) struct LocalPoint {
    pub(super) p: DVec3,
    /// Outward unit normal.
    pub(super) n: DVec3,
    /// Interpolated normal, not of unit length.
    pub(super) shading: Option<DVec3>,
    uv: Vec2,
    /// Material slot.
    slot: u32,
}

impl LocalPoint {
    pub(super) fn texture_point(&self) -> TexturePoint {
        TexturePoint {
            p: self.p,
            n: self.n,
            uv: self.uv,
        }
    }
}

/// A bent normal laid down on the surface where it points below; `ng` where it points nowhere.
fn above_horizon(n: Vec3, ng: Vec3) -> Vec3 {
    if !n.is_finite() {
        return ng;
    }
    let height = n.dot(ng);
    if height < 0.0 {
        (n - height * ng).normalize_or(ng)
    } else {
        n
    }
}

/// The surface near `p`.
#[inline(always)]
fn on_solid(solid: Solid, p: DVec3, face: u32) -> LocalPoint {
    let p = solid.project(p, face);
    LocalPoint {
        p,
        n: solid.normal(p, face),
        shading: None,
        uv: solid.uv(p, face).as_vec2(),
        slot: 0,
    }
}

impl SurfacePoint {
    /// The surface's point moved clear of it, to the side of `direction`.
    pub fn origin(&self, direction: Vec3) -> DVec3 {
        let side = self.error.copysign(f64::from(direction.dot(self.ng)));
        self.p + side * self.ng.as_dvec3()
    }

    /// A ray that leaves the surface.
    pub fn spawn(&self, direction: Vec3) -> Ray {
        Ray::new(self.origin(direction), direction.as_dvec3())
    }

    /// From the surface to a light, for a shadow query; to a point it is a segment.
    pub fn towards(&self, source: Source) -> Ray {
        let target = match source {
            Source::Point(target) => target,
            Source::Direction(wi) => return self.spawn(wi.as_vec3()),
        };
        let origin = self.origin((target - self.p).as_vec3());
        Ray {
            tmax: 1.0,
            ..Ray::new(origin, target - origin)
        }
    }
}

//! The scene with its trees and lights built: answers rays.

use glam::{DVec3, Vec2, Vec3};

use crate::accel::{Accel, Hit, MeshReport, Placed};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::error::Result;
use crate::geometry::{CsgId, MeshId, Operand, Shape, Solid};
use crate::light::{Light, LightSampler, SphereLight, TriangleLight};
use crate::material::{Material, MaterialId};
use crate::math::{Bounds, Ray};
use crate::scene::{Instance, Scene};
use crate::texture::TexturePoint;

/// Everything that rendering reads, immutable.
#[derive(Debug)]
pub struct World {
    scene: Scene,
    accel: Accel,
    lights: LightSampler,
    /// For each instance where its lights start in the sampler's list.
    emitters: Vec<Emitters>,
}

/// Which of the sampler's lights are the surfaces of one instance.
#[derive(Clone, Debug)]
enum Emitters {
    None,
    /// The whole shape is one light.
    One(u32),
    /// For each triangle of a mesh its light, or `u32::MAX`.
    Triangles(Vec<u32>),
}

/// A point on a surface, ready for shading.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Where, in world space.
    pub p: DVec3,
    /// A ray must start this far off the surface so as not to meet it again.
    pub error: f64,
    /// Outward geometric normal.
    pub ng: Vec3,
    /// 1 where the ray came from the side of `ng`, -1 where it came from inside.
    pub side: f32,
    /// Shading normal, on the side of `ng`.
    pub ns: Vec3,
    /// What textures see.
    pub texture: TexturePoint,
    /// The surface's material.
    pub material: MaterialId,
}

impl World {
    /// Builds trees and lights.
    ///
    /// # Errors
    /// Where a mesh is invalid or has no triangle with an area, or a CSG tree is not whole or has an open mesh.
    pub fn build(scene: Scene) -> Result<Self> {
        let placed = (scene.instances.iter())
            .map(|instance| Placed {
                shape: instance.shape,
                world_from_object: instance.world_from_object,
            })
            .collect();
        let accel = Accel::build(&scene.meshes, &scene.csgs, placed)?;
        let mut lights: Vec<Light> = scene.lights.iter().copied().map(Light::Point).collect();
        let emitters = (0..scene.instances.len())
            .map(|i| find_emitters(&scene, &accel, i, &mut lights))
            .collect();
        Ok(Self {
            lights: LightSampler::new(lights),
            scene,
            accel,
            emitters,
        })
    }

    /// The scene it was built from.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The lights that paths can aim at.
    pub fn lights(&self) -> &LightSampler {
        &self.lights
    }

    /// The box around everything but planes.
    pub fn bounds(&self) -> Bounds {
        self.accel.bounds()
    }

    /// What building the meshes' trees found, in all.
    pub fn mesh_report(&self) -> MeshReport {
        (self.accel.mesh_reports()).fold(MeshReport::default(), |sum, one| MeshReport {
            triangles: sum.triangles + one.triangles,
            degenerate: sum.degenerate + one.degenerate,
            duplicate: sum.duplicate + one.duplicate,
            bytes: sum.bytes + one.bytes,
        })
    }

    /// The closest hit with `tmin < t < tmax`.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.accel.intersect(ray)
    }

    /// Whether anything lies in `tmin < t < tmax`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.accel.occluded(ray)
    }

    /// The closest hit of each ray, into `hits` of the same length.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len());
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.intersect(ray);
        }
    }

    /// The instance that was hit.
    pub fn instance(&self, hit: &Hit) -> &Instance {
        &self.scene.instances[hit.instance as usize]
    }

    /// The material at a surface point.
    pub fn material(&self, point: &SurfacePoint) -> &Material {
        &self.scene.materials[point.material.0 as usize]
    }

    /// How the surface scatters.
    pub fn bsdf(&self, point: &SurfacePoint) -> Bsdf {
        let surface = &self.material(point).surface;
        Bsdf::new(surface, &point.texture, point.ng, point.ns, point.side)
    }

    /// Density per solid angle with which light sampling at `from` draws the point that was hit; 0
    /// where the surface is not among the lights.
    pub fn light_pdf(&self, from: DVec3, hit: &Hit, p: DVec3) -> f32 {
        let light = match &self.emitters[hit.instance as usize] {
            Emitters::None => return 0.0,
            Emitters::One(light) => *light,
            Emitters::Triangles(lights) => lights[hit.primitive as usize],
        };
        if light == u32::MAX {
            0.0
        } else {
            self.lights.pdf(light, from, p)
        }
    }

    /// The surface where `ray` was hit.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let instance = self.instance(hit);
        let transform = &instance.world_from_object;
        let local = transform.inverse_ray(ray);
        let at = match instance.shape {
            Shape::Solid(solid) => on_solid(solid, &local, hit.t, hit.face),
            Shape::Mesh(id) => self.on_mesh(id, hit.primitive, hit.uv, instance.smooth),
            Shape::Csg(id) => self.on_csg(id, &local, hit, instance.smooth),
        };
        let outward = transform.normal(at.n);
        let ng = outward.as_vec3().normalize();
        let ns = (at.shading)
            .map(|n| transform.normal(n).as_vec3())
            .filter(|n| n.is_finite())
            .map_or(ng, |n| if n.dot(ng) < 0.0 { -n } else { n });
        SurfacePoint {
            p: transform.point(at.p),
            error: self.accel.error_at(hit, at.p, at.n),
            ng,
            side: if hit.inside { -1.0 } else { 1.0 },
            ns,
            texture: TexturePoint {
                p: at.p,
                n: at.n,
                uv: at.uv,
            },
            material: instance.material(at.slot),
        }
    }

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
        let uv = if mesh.uvs.is_empty() {
            weights
        } else {
            let [ta, tb, tc] = corner.map(|i| mesh.uvs[i as usize]);
            u * ta + v * tb + w * tc
        };
        LocalPoint {
            p: a + f64::from(v) * ab + f64::from(w) * ac,
            n: ab.cross(ac).normalize(),
            shading,
            uv,
            slot: mesh.slot(triangle),
        }
    }

    /// A point on the surface of one operand, seen from the whole: where that is subtracted, its normals turn round.
    fn on_csg(&self, id: CsgId, ray: &Ray, hit: &Hit, smooth: bool) -> LocalPoint {
        let csg = &self.scene.csgs[id.0 as usize];
        let (operand, transform) = csg.operand(hit.primitive);
        let local = transform.inverse_ray(ray);
        let at = match operand {
            Operand::Solid(solid) => on_solid(solid, &local, hit.t, hit.face),
            Operand::Mesh(mesh) | Operand::OpenMesh(mesh) => {
                self.on_mesh(mesh, hit.face, hit.uv, smooth)
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
struct LocalPoint {
    p: DVec3,
    /// Outward unit normal.
    n: DVec3,
    /// Interpolated normal, not of unit length.
    shading: Option<DVec3>,
    uv: Vec2,
    /// Material slot.
    slot: u32,
}

fn on_solid(solid: Solid, ray: &Ray, t: f64, face: u32) -> LocalPoint {
    let p = solid.project(ray.at(t), face);
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

    /// The segment from the surface to `target`, for a shadow query.
    pub fn towards(&self, target: DVec3) -> Ray {
        let origin = self.origin((target - self.p).as_vec3());
        Ray {
            tmax: 1.0,
            ..Ray::new(origin, target - origin)
        }
    }
}

/// Adds the lights that the surfaces of instance `index` are.
fn find_emitters(scene: &Scene, accel: &Accel, index: usize, lights: &mut Vec<Light>) -> Emitters {
    let instance = &scene.instances[index];
    let emission = |slot: u32| scene.materials[instance.material(slot).0 as usize].emission;
    let transform = &instance.world_from_object;
    match instance.shape {
        Shape::Solid(Solid::Sphere { radius }) if emission(0) != Rgb::ZERO => {
            // A sphere that a transform squashes is no sphere: rays find it, nothing aims at it.
            let Some(scale) = transform.uniform_scale() else {
                return Emitters::None;
            };
            lights.push(Light::Sphere(SphereLight {
                center: transform.point(DVec3::ZERO),
                radius: radius * scale,
                radiance: emission(0),
                error: accel.error(index as u32, DVec3::X * radius),
            }));
            Emitters::One(lights.len() as u32 - 1)
        }
        Shape::Mesh(id) => {
            let mesh = &scene.meshes[id.0 as usize];
            let dropped = accel.dropped(id);
            let mut found = false;
            let of_triangle = (0..mesh.triangles.len() as u32)
                .map(|i| {
                    let radiance = emission(mesh.slot(i));
                    // Rays never report a triangle that the tree left out.
                    if radiance == Rgb::ZERO || dropped.binary_search(&i).is_ok() {
                        return u32::MAX;
                    }
                    found = true;
                    let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
                    let corner = transform.point(a);
                    lights.push(Light::Triangle(TriangleLight {
                        corner,
                        edges: [transform.point(b) - corner, transform.point(c) - corner],
                        radiance,
                        error: accel.error(index as u32, a),
                    }));
                    lights.len() as u32 - 1
                })
                .collect();
            if found {
                Emitters::Triangles(of_triangle)
            } else {
                Emitters::None
            }
        }
        Shape::Solid(_) | Shape::Csg(_) => Emitters::None,
    }
}

//! The scene with its trees and lights built: answers rays.

mod emitters;
mod media;
mod relief;
mod surface;

use glam::DVec3;

use crate::accel::{Accel, CsgTree, Hit, MeshReport, Placed};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::geometry::{CsgId, Operand, Solid, Tangents};
use crate::light::LightSampler;
use crate::material::Material;
use crate::math::{Bounds, Ray};
use crate::scene::{Instance, Scene};

use emitters::Emitters;
pub use media::Media;
use media::Medium;
pub use surface::SurfacePoint;

/// Everything that rendering reads, immutable.
#[derive(Debug)]
pub struct World {
    scene: Scene,
    accel: Accel,
    lights: LightSampler,
    emitters: Emitters,
    /// The instances that light goes through.
    clear: Vec<Medium>,
    /// Of the meshes on which a normal map or a brushed surface needs them.
    tangents: Vec<Option<Tangents>>,
}

impl World {
    /// Builds trees and lights.
    ///
    /// # Errors
    /// Where a mesh is invalid or has no triangle with an area, or a CSG tree is not whole or has an operand without an
    /// inside: an open mesh, a rectangle or a disk.
    pub fn build(scene: Scene) -> Result<Self> {
        let flat = |operand: &Operand| {
            matches!(
                operand,
                Operand::Solid(Solid::Rectangle { .. } | Solid::Disk { .. })
            )
        };
        if (scene.csgs.iter()).any(|csg| csg.operands.iter().any(flat)) {
            let message = "an operand of CSG is a rectangle or disk, which has no inside";
            return Err(Error::input(message).help("take a thin box or cylinder, or a plane"));
        }
        let placed = (scene.instances.iter())
            .map(|instance| Placed {
                shape: instance.shape,
                world_from_object: instance.world_from_object,
            })
            .collect();
        let accel = Accel::build(&scene.meshes, &scene.csgs, placed)?;
        let clear = (0..scene.instances.len()).filter_map(|i| Medium::of(&scene, i));
        let mut world = Self {
            clear: clear.collect(),
            tangents: relief::tangents(&scene),
            lights: LightSampler::default(),
            scene,
            accel,
            emitters: Emitters::default(),
        };
        world.find_lights();
        Ok(world)
    }

    /// The scene it was built from.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The lights that paths can aim at.
    pub fn lights(&self) -> &LightSampler {
        &self.lights
    }

    /// The box around everything that has an end.
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

    /// A CSG object of the scene.
    pub fn csg(&self, id: CsgId) -> &CsgTree {
        self.accel.csg(id)
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
        self.accel.intersect_batch(rays, hits);
    }

    /// Whether each ray is blocked, into `blocked` of the same length.
    pub fn occluded_batch(&self, rays: &[Ray], blocked: &mut [bool]) {
        self.accel.occluded_batch(rays, blocked);
    }

    /// The instance that was hit.
    pub fn instance(&self, hit: &Hit) -> &Instance {
        &self.scene.instances[hit.instance as usize]
    }

    /// The material at a surface point.
    pub fn material(&self, point: &SurfacePoint) -> &Material {
        &self.scene.materials[point.material.0 as usize]
    }

    /// How the surface scatters light that comes from a path in `media`.
    pub fn bsdf(&self, point: &SurfacePoint, media: &Media) -> Bsdf {
        let surface = &self.material(point).surface;
        let interior = surface.interior();
        let eta = interior.map_or(1.0, |interior| media.eta(point, interior.ior));
        let SurfacePoint {
            ng,
            ns,
            tangent,
            side,
            ..
        } = *point;
        Bsdf::new(surface, &point.texture, ng, ns, tangent, side, eta)
    }

    /// What a ray that meets nothing sees in its unit direction `wi`: the environment, and of lights at infinity what
    /// `weight` makes of the density with which light sampling draws `wi`.
    pub fn beyond(&self, wi: DVec3, weight: impl Fn(f32) -> f32) -> Rgb {
        let lights = self.lights.beyond(wi);
        lights.fold(self.scene.environment, |sum, (radiance, pdf)| {
            sum + weight(pdf) * radiance
        })
    }
}

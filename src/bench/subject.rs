use glam::{DVec3, Vec3};

use crate::accel::Placed;
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::geometry::{Mesh, MeshId, Shape};
use crate::math::{Bounds, Transform};
use crate::scene::Scene;

/// The triangles that are raced over: meshes, and where they stand.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Each with a use at least.
    pub meshes: Vec<Mesh>,
    /// Index of the mesh and `world_from_object`. Where no mesh is used twice, meshes are in world space and every
    /// transform is the identity, so that engines with and without instances are asked the same.
    pub instances: Vec<(usize, Transform)>,
    /// From where camera rays start.
    pub camera: Camera,
}

impl Subject {
    /// The mesh instances of a scene, seen by its first camera. Solids, planes and CSG objects do not race.
    ///
    /// # Errors
    /// Where the scene has no mesh, or one is not valid.
    pub fn of_scene(scene: Scene) -> Result<Self> {
        let placed: Vec<(usize, Transform)> = (scene.instances.iter())
            .filter_map(|instance| match instance.shape {
                Shape::Mesh(id) => Some((id.0 as usize, instance.world_from_object)),
                _ => None,
            })
            .collect();
        if placed.is_empty() {
            return Err(Error::input("the scene has no mesh to race over")
                .help("meshes alone are raced: solids and CSG objects have no peer here"));
        }
        let mut uses = vec![0; scene.meshes.len()];
        for (mesh, _) in &placed {
            uses[*mesh] += 1;
        }
        let camera = scene.cameras[0].clone();
        let (meshes, instances): (Vec<Mesh>, Vec<_>) = if uses.iter().any(|&uses| uses > 1) {
            let kept = |mesh: usize| uses[..mesh].iter().filter(|&&uses| uses > 0).count();
            let instances = placed.iter().map(|(mesh, at)| (kept(*mesh), *at)).collect();
            let meshes = (scene.meshes.into_iter().zip(&uses))
                .filter_map(|(mesh, &uses)| (uses > 0).then_some(mesh));
            (meshes.collect(), instances)
        } else {
            let meshes = (placed.iter()).map(|(mesh, at)| in_place(&scene.meshes[*mesh], at));
            let instances = (0..placed.len()).map(|mesh| (mesh, Transform::IDENTITY));
            (meshes.collect(), instances.collect())
        };
        for mesh in &meshes {
            mesh.validate()?;
        }
        Ok(Self {
            meshes,
            instances,
            camera,
        })
    }

    /// Whether a mesh is used more than once.
    pub fn is_instanced(&self) -> bool {
        self.instances.len() > self.meshes.len()
    }

    /// Triangles of all meshes, each mesh counted once.
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
    }

    /// Triangles of all instances.
    pub fn placed_triangles(&self) -> usize {
        let triangles = |(mesh, _): &(usize, Transform)| self.meshes[*mesh].triangles.len();
        self.instances.iter().map(triangles).sum()
    }

    /// The box around all of it.
    pub fn bounds(&self) -> Bounds {
        let each: Vec<Bounds> = self.meshes.iter().map(Mesh::bounds).collect();
        (self.instances.iter())
            .map(|(mesh, at)| at.bounds(&each[*mesh]))
            .fold(Bounds::EMPTY, Bounds::union)
    }

    /// As our trees want it.
    pub fn placed(&self) -> Vec<Placed> {
        (self.instances.iter())
            .map(|(mesh, at)| Placed {
                shape: Shape::Mesh(MeshId(*mesh as u32)),
                world_from_object: *at,
            })
            .collect()
    }

    /// A triangle of an instance, in world space.
    pub fn corners(&self, instance: u32, triangle: u32) -> [DVec3; 3] {
        let (mesh, at) = &self.instances[instance as usize];
        self.meshes[*mesh]
            .corners(triangle)
            .map(|p| at.point(p.as_dvec3()))
    }

    /// All instances as one mesh, for engines that have no instances.
    pub fn flat(&self) -> Mesh {
        let mut flat = Mesh::default();
        for (mesh, at) in &self.instances {
            let mesh = in_place(&self.meshes[*mesh], at);
            let first = flat.positions.len() as u32;
            flat.positions.extend(mesh.positions);
            let moved = mesh.triangles.iter().map(|t| t.map(|v| first + v));
            flat.triangles.extend(moved);
        }
        flat
    }
}

/// The mesh's triangles in world space.
fn in_place(mesh: &Mesh, at: &Transform) -> Mesh {
    let place = |p: &Vec3| at.point(p.as_dvec3()).as_vec3();
    Mesh {
        positions: mesh.positions.iter().map(place).collect(),
        triangles: mesh.triangles.clone(),
        ..Mesh::default()
    }
}

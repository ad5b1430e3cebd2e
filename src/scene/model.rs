use crate::camera::Camera;
use crate::geometry::{Mesh, MeshId, Shape};
use crate::light::Light;
use crate::material::{Material, MaterialId};
use crate::math::Transform;

use super::{Instance, Scene};

/// What a model file (OBJ, glTF, ...) holds, before it is placed in a scene.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// The file's meshes.
    pub meshes: Vec<Mesh>,
    /// The file's materials.
    pub materials: Vec<Material>,
    /// Where its meshes stand.
    pub parts: Vec<Part>,
    /// Its cameras.
    pub cameras: Vec<Camera>,
    /// Its point, spot and directional lights.
    pub lights: Vec<Light>,
    /// What the reader wants the user to know: one sentence each, with file and line where known.
    pub warnings: Vec<String>,
}

/// One mesh of a model in its place.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name of the object or node.
    pub name: Option<String>,
    /// Index into [`Model::meshes`].
    pub mesh: usize,
    /// For each material slot of the mesh an index into [`Model::materials`]; `None` is the default material.
    pub materials: Vec<Option<usize>>,
    /// From the mesh to the model's space.
    pub model_from_mesh: Transform,
}

impl Scene {
    /// Takes over a model's meshes, materials and warnings. Returns its parts as instances in the model's
    /// space, which are not yet in the scene; its cameras and lights are left out.
    pub fn adopt(&mut self, model: Model) -> Vec<Instance> {
        let first_mesh = self.meshes.len();
        let first_material = self.materials.len();
        self.meshes.extend(model.meshes);
        self.materials.extend(model.materials);
        self.warnings.extend(model.warnings);
        let mut instances = Vec::with_capacity(model.parts.len());
        for part in model.parts {
            let slots = part.materials.into_iter();
            let mut materials: Vec<MaterialId> = slots
                .map(|slot| match slot {
                    Some(i) => MaterialId((first_material + i) as u32),
                    None => self.default_material(),
                })
                .collect();
            if materials.is_empty() {
                materials.push(self.default_material());
            }
            instances.push(Instance {
                name: part.name,
                shape: Shape::Mesh(MeshId((first_mesh + part.mesh) as u32)),
                materials,
                world_from_object: part.model_from_mesh,
                smooth: true,
            });
        }
        instances
    }

    /// The material of what has none.
    pub fn default_material(&mut self) -> MaterialId {
        let default = Material::default();
        let known = self.materials.iter().position(|m| *m == default);
        MaterialId(known.unwrap_or_else(|| {
            self.materials.push(default);
            self.materials.len() - 1
        }) as u32)
    }
}

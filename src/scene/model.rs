use crate::camera::Camera;
use crate::geometry::Mesh;
use crate::light::PointLight;
use crate::material::Material;
use crate::math::Transform;

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
    /// Its point lights.
    pub lights: Vec<PointLight>,
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

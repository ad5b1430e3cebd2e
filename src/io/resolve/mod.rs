//! From a description to a scene: files read, names resolved to ids.

mod checks;
mod csg;
mod environment;
mod files;
mod objects;
mod textures;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use crate::color::Encoding;
use crate::error::{Error, Place, Result, did_you_mean};
use crate::geometry::{Csg, CsgId, MeshId, Operand, Shape};
use crate::material::{Material, MaterialId};
use crate::scene::description::{MaterialDescription, ObjectTree, Offset, Reference};
use crate::scene::{Instance, Scene, SceneDescription};
use crate::texture::{Bitmap, Texture};

use self::objects::Role;
use super::bare::bare_scene;
use super::read_model;

/// What a scene may hold, all copies counted, so that its memory stays within a few gigabytes: operands and
/// operators count once, instances as many times as they are larger.
const MOST: usize = 1 << 26;
const INSTANCE: usize = 8;

/// What the reader of a scene may do.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Folders whose trees a scene may read from, beside its own folder's tree. A scene anywhere in a folder called `scenes`
    /// may read from the `assets` folder next to that one in any case.
    pub allow_paths: Vec<PathBuf>,
    /// What becomes of CSG operands that are meshes with holes.
    pub open_mesh_operands: OpenMeshOperands,
}

/// What becomes of a mesh that is not closed where CSG needs its inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OpenMeshOperands {
    /// It is an error.
    #[default]
    Refuse,
    /// Its inside is where its generalized winding number is above one half; there is a warning.
    Winding,
}

/// Reads whatever can be rendered: a scene (`.ron`, `.json`) or a bare model (`.obj`, `.gltf`, `.glb`), which is
/// framed and lit where it has no camera or lights of its own.
///
/// # Errors
/// Where the file, or one that it names, cannot be read or is wrong.
pub fn read_scene(path: &Path, options: &ReadOptions) -> Result<Scene> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "ron" | "json" => SceneDescription::read(path)?.load_with(options),
        "obj" => bare_scene(read_model(path)?, true),
        "gltf" | "glb" => bare_scene(read_model(path)?, false),
        _ => Err(
            Error::input(format!("the extension `{extension}` is of no known input"))
                .at(Place::file(path))
                .help("an input is a scene (.ron, .json) or a model (.obj, .gltf, .glb)"),
        ),
    }
}

impl SceneDescription {
    /// Reads the files and resolves the names.
    ///
    /// # Errors
    /// At the place of the name or file that cannot be resolved, or in that file.
    pub fn load(&self) -> Result<Scene> {
        self.load_with(&ReadOptions::default())
    }

    /// As [`SceneDescription::load`], with more folders to read from.
    ///
    /// # Errors
    /// At the place of the name or file that cannot be resolved, or in that file.
    pub fn load_with(&self, options: &ReadOptions) -> Result<Scene> {
        let mut loader = Loader {
            description: self,
            options,
            roots: files::roots(self, options)?,
            scene: Scene {
                film: self.film.clone(),
                integrator: self.integrator.clone(),
                cameras: self.cameras.clone(),
                lights: self.lights.clone(),
                ..Scene::default()
            },
            csgs: Vec::new(),
            materials: HashMap::new(),
            definitions: self.definitions.iter().map(|(n, o)| (&**n, o)).collect(),
            resolved: HashMap::new(),
            models: HashMap::new(),
            meshes: HashMap::new(),
            operands: HashMap::new(),
            texture_indices: (self.textures.iter().enumerate())
                .map(|(i, (name, _))| (&**name, i))
                .collect(),
            textures: HashMap::new(),
            bitmaps: HashMap::new(),
            room: MOST,
        };
        loader.check()?;
        loader.environment()?;
        for (i, material) in self.materials.iter().enumerate() {
            let resolved = loader.resolve_material(material)?;
            loader.scene.materials.push(resolved);
            loader
                .materials
                .insert(&material.name, MaterialId(i as u32));
        }
        for ObjectTree(tree) in &self.objects {
            let instances = loader.instances(tree, Role::World)?;
            loader.scene.instances.extend(instances);
        }
        loader.check_textures()?;
        loader.resolve_unused()?;
        Ok(loader.finish())
    }
}

struct Loader<'a> {
    description: &'a SceneDescription,
    options: &'a ReadOptions,
    /// Folders to read from.
    roots: Vec<PathBuf>,
    scene: Scene,
    /// All CSG objects so far; the scene gets those that it uses.
    csgs: Vec<Csg>,
    materials: HashMap<&'a str, MaterialId>,
    definitions: HashMap<&'a str, &'a ObjectTree>,
    /// The definitions that were needed so far.
    resolved: HashMap<(&'a str, Role), Rc<[Instance]>>,
    /// Each model file's parts, read once.
    models: HashMap<PathBuf, Vec<Instance>>,
    /// Where each mesh comes from, and the name of its first part.
    meshes: HashMap<MeshId, (PathBuf, Option<String>)>,
    /// The meshes that are operands.
    operands: HashMap<MeshId, Operand>,
    /// Where each name stands in the scene's list of textures.
    texture_indices: HashMap<&'a str, usize>,
    /// The named textures that were needed so far, as colours or as data.
    textures: HashMap<(&'a str, Encoding), Texture>,
    bitmaps: HashMap<(PathBuf, Encoding), Arc<Bitmap>>,
    /// What the scene may still grow by.
    room: usize,
}

impl<'a> Loader<'a> {
    fn place(&self, offset: Offset) -> Place {
        self.description.source.place(offset)
    }

    /// Makes sure, before it is done, that the scene may grow by that much.
    fn grow(&mut self, by: usize, offset: Offset) -> Result<()> {
        self.room = self.room.checked_sub(by).ok_or_else(|| {
            let instances = MOST / INSTANCE;
            Error::input(format!(
                "here the scene grows beyond {MOST} operands and operators of CSG, or {instances} instances"
            ))
            .at(self.place(offset))
            .help("all copies count: lower the `count` of a `Repeat`")
        })?;
        Ok(())
    }

    /// The scene with those of the CSG objects that are in it.
    fn finish(mut self) -> Scene {
        let mut known = HashMap::new();
        for instance in &mut self.scene.instances {
            if let Shape::Csg(id) = &mut instance.shape {
                let csgs = &mut self.scene.csgs;
                *id = *known.entry(*id).or_insert_with(|| {
                    csgs.push(std::mem::take(&mut self.csgs[id.0 as usize]));
                    CsgId(csgs.len() as u32 - 1)
                });
            }
        }
        self.scene
    }

    fn material(&self, name: &Reference) -> Result<MaterialId> {
        self.materials.get(&*name.name).copied().ok_or_else(|| {
            Error::input(format!("there is no material `{}`", name.name))
                .at(self.place(name.offset))
                .help(did_you_mean(&name.name, self.materials.keys().copied()))
        })
    }

    fn resolve_material(&mut self, material: &'a MaterialDescription) -> Result<Material> {
        let emission_texture = material.emission_texture.as_ref();
        Ok(Material {
            name: material.name.clone(),
            surface: (material.surface)
                .try_map(&mut |texture, encoding| self.texture(texture, encoding))?,
            emission: material.emission,
            emission_texture: emission_texture
                .map(|texture| self.texture(texture, Encoding::Srgb))
                .transpose()?,
            relief: (material.relief.as_ref())
                .map(|relief| self.relief(relief))
                .transpose()?,
        })
    }
}

//! From a description to a scene: files read, names resolved to ids.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{Error, ErrorKind, Place, Result, did_you_mean};
use crate::geometry::Shape;
use crate::material::{Material, MaterialId, Surface};
use crate::math::Transform;
use crate::scene::description::{
    ColorDescription, ObjectDescription, Reference, ShapeDescription, SurfaceDescription,
};
use crate::scene::{Instance, Scene, SceneDescription};
use crate::texture::{Bitmap, Texture};

use super::bare::bare_scene;
use super::{read_bitmap, read_model};

/// Definitions may hold instances of other definitions this deep.
const MAX_NESTING: usize = 64;

/// What the reader of a scene may do.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Folders whose trees a scene may read from, beside its own folder's tree. A scene in a folder called `scenes`
    /// may read from the `assets` folder next to that one in any case.
    pub allow_paths: Vec<PathBuf>,
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
            roots: roots(self, options)?,
            scene: Scene {
                film: self.film.clone(),
                integrator: self.integrator.clone(),
                cameras: self.cameras.clone(),
                environment: self.environment,
                lights: self.lights.clone(),
                ..Scene::default()
            },
            materials: HashMap::new(),
            definitions: self
                .definitions
                .iter()
                .map(|(name, o)| (&**name, o))
                .collect(),
            models: HashMap::new(),
            bitmaps: HashMap::new(),
        };
        for (i, material) in self.materials.iter().enumerate() {
            let resolved = Material {
                name: material.name.clone(),
                surface: loader.surface(&material.surface)?,
                emission: material.emission,
            };
            loader.scene.materials.push(resolved);
            loader
                .materials
                .insert(&material.name, MaterialId(i as u32));
        }
        // Definitions that stand nowhere are checked as well.
        for (name, object) in &self.definitions {
            loader.instances(object, &mut vec![name])?;
        }
        for object in &self.objects {
            let instances = loader.instances(object, &mut Vec::new())?;
            loader.scene.instances.extend(instances);
        }
        Ok(loader.scene)
    }
}

/// The folders whose trees the scene may read from.
fn roots(description: &SceneDescription, options: &ReadOptions) -> Result<Vec<PathBuf>> {
    let canonical = |path: &Path| path.canonicalize().map_err(|e| Error::read(path, &e));
    let own = canonical(description.source.folder())?;
    let assets = own.with_file_name("assets").canonicalize();
    let beside = assets.ok().filter(|_| own.ends_with("scenes"));
    let allowed = options.allow_paths.iter().map(|path| canonical(path));
    let mut roots = allowed.collect::<Result<Vec<_>>>()?;
    roots.extend(beside);
    roots.push(own);
    Ok(roots)
}

struct Loader<'a> {
    description: &'a SceneDescription,
    roots: Vec<PathBuf>,
    scene: Scene,
    materials: HashMap<&'a str, MaterialId>,
    definitions: HashMap<&'a str, &'a ObjectDescription>,
    /// Each model file's parts, read once.
    models: HashMap<PathBuf, Vec<Instance>>,
    bitmaps: HashMap<PathBuf, Arc<Bitmap>>,
}

impl<'a> Loader<'a> {
    fn place(&self, reference: &Reference) -> Place {
        self.description.source.place(reference.offset)
    }

    /// What an object puts into the world; `within` are the definitions that led to it.
    fn instances(
        &mut self,
        object: &'a ObjectDescription,
        within: &mut Vec<&'a str>,
    ) -> Result<Vec<Instance>> {
        let material = (object.material.as_ref())
            .map(|name| self.material(name))
            .transpose()?;
        let mut instances = match &object.shape {
            ShapeDescription::Solid { solid, placement } => vec![Instance {
                name: None,
                shape: Shape::Solid(*solid),
                materials: vec![material.unwrap_or_else(|| self.scene.default_material())],
                world_from_object: *placement,
                smooth: true,
            }],
            ShapeDescription::Mesh { file, smooth } => {
                let mut parts = self.model(file)?.clone();
                for part in &mut parts {
                    part.smooth = *smooth;
                }
                parts
            }
            ShapeDescription::Instance { of } => self.definition(of, within)?,
        };
        for instance in &mut instances {
            if let Some(material) = material {
                instance.materials = vec![material];
            }
            instance.name = match (&object.name, instance.name.take()) {
                (Some(outer), Some(inner)) => Some(format!("{outer}/{inner}")),
                (outer, inner) => outer.clone().or(inner),
            };
            instance.world_from_object = self.placed(object, &instance.world_from_object)?;
        }
        Ok(instances)
    }

    fn placed(&self, object: &ObjectDescription, inner: &Transform) -> Result<Transform> {
        let placed = object.transform.after(inner);
        if placed.is_finite() {
            return Ok(placed);
        }
        let name = object.name.as_deref().unwrap_or("without a name");
        Err(Error::input(format!(
            "the transforms of the object {name} take it beyond what numbers can hold"
        ))
        .at(Place::file(&self.description.source.file)))
    }

    fn definition(
        &mut self,
        of: &'a Reference,
        within: &mut Vec<&'a str>,
    ) -> Result<Vec<Instance>> {
        let Some((name, object)) = self.definitions.get_key_value(&*of.name) else {
            let help = did_you_mean(&of.name, self.definitions.keys().copied());
            return Err(
                Error::input(format!("there is no definition `{}`", of.name))
                    .at(self.place(of))
                    .help(help),
            );
        };
        let (name, object) = (*name, *object);
        if within.contains(&name) {
            let circle = within.join("` → `");
            return Err(Error::input(format!(
                "the definition `{name}` contains itself: `{circle}` → `{name}`"
            ))
            .at(self.place(of))
            .help("a definition cannot hold an instance of itself, directly or through others"));
        }
        if within.len() == MAX_NESTING {
            return Err(Error::input(format!(
                "more than {MAX_NESTING} definitions inside one another"
            ))
            .at(self.place(of)));
        }
        within.push(name);
        let instances = self.instances(object, within)?;
        within.pop();
        Ok(instances)
    }

    fn material(&self, name: &Reference) -> Result<MaterialId> {
        self.materials.get(&*name.name).copied().ok_or_else(|| {
            Error::input(format!("there is no material `{}`", name.name))
                .at(self.place(name))
                .help(did_you_mean(&name.name, self.materials.keys().copied()))
        })
    }

    fn surface(&mut self, surface: &SurfaceDescription) -> Result<Surface> {
        Ok(match surface {
            SurfaceDescription::Diffuse { color } => Surface::Diffuse {
                color: self.texture(color)?,
            },
            SurfaceDescription::Mirror { color } => Surface::Mirror {
                color: self.texture(color)?,
            },
            SurfaceDescription::Dielectric { ior, fresnel } => Surface::Dielectric {
                ior: *ior,
                fresnel: *fresnel,
            },
        })
    }

    fn texture(&mut self, color: &ColorDescription) -> Result<Texture> {
        Ok(match color {
            ColorDescription::Constant(color) => Texture::Constant(*color),
            ColorDescription::Checker { a, b, step } => Texture::Checker {
                a: *a,
                b: *b,
                step: *step,
            },
            ColorDescription::Image { file } => {
                let path = self.find(file)?;
                if !self.bitmaps.contains_key(&path) {
                    let bitmap = read_bitmap(&path).map_err(|e| e.at(self.place(file)))?;
                    self.bitmaps.insert(path.clone(), Arc::new(bitmap));
                }
                Texture::Image {
                    image: self.bitmaps[&path].clone(),
                    scale: glam::Vec3::ONE,
                }
            }
        })
    }

    fn model(&mut self, file: &Reference) -> Result<&Vec<Instance>> {
        let path = self.find(file)?;
        if !self.models.contains_key(&path) {
            let model = read_model(&path).map_err(|e| e.at(self.place(file)))?;
            let parts = self.scene.adopt(model);
            self.models.insert(path.clone(), parts);
        }
        Ok(&self.models[&path])
    }

    /// The real path of a file that the scene names, which must exist inside one of the roots.
    fn find(&self, file: &Reference) -> Result<PathBuf> {
        let path = self.description.source.folder().join(&file.name);
        let real = path.canonicalize().map_err(|e| {
            let message = format!("cannot read the file `{}`: {e}", file.name);
            let error = Error::new(ErrorKind::Read, message).at(self.place(file));
            error.help(self.neighbour(&path).unwrap_or_else(|| {
                format!(
                    "paths start at the scene's folder, so this is {}",
                    path.display()
                )
            }))
        })?;
        if self.may_read(&real) {
            return Ok(real);
        }
        let allow = real.parent().unwrap_or(&real).display();
        Err(Error::input(format!(
            "the file `{}` is outside the folders that this scene may read",
            file.name
        ))
        .at(self.place(file))
        .help(format!(
            "move it into the scene's folder, or allow its own with `--allow-path {allow}`"
        )))
    }

    /// The help for a file that is not in its folder: another there whose name is much like it.
    fn neighbour(&self, path: &Path) -> Option<String> {
        let folder = path.parent()?.canonicalize().ok()?;
        if !self.may_read(&folder) {
            return None;
        }
        let entries = std::fs::read_dir(folder).ok()?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let names: BTreeSet<String> = names.collect();
        let help = did_you_mean(
            path.file_name()?.to_str()?,
            names.iter().map(String::as_str),
        );
        help.starts_with("did").then_some(help)
    }

    fn may_read(&self, real: &Path) -> bool {
        self.roots.iter().any(|root| real.starts_with(root))
    }
}

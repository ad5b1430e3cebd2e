//! Wavefront OBJ: `tobj` makes the vertices, our own prepass sees to it that what it reads is sound.

mod clean;
mod faces;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};

use crate::error::{Error, Place, Result};
use crate::geometry::Mesh;
use crate::material::Material;
use crate::math::Transform;
use crate::scene::{Model, Part};

use super::{mtl, read_file};
use clean::Cleaner;
pub(super) use clean::triangle_lines;
use faces::Found;

/// Reads an OBJ file as one mesh and one part: triangle `i` is the file's triangle `i`, polygons being
/// cut into triangles in place, and each material name that faces use is a slot, in order of first use.
///
/// A corner without `vn` in a file that has some gets the zero normal (no shading normal here), one
/// without `vt` gets (0, 0). `w` and colours of vertices are not used.
///
/// # Errors
/// Where the file, or a texture that a used material names, cannot be read or is malformed.
pub(super) fn read(path: &Path) -> Result<Model> {
    let bytes = read_file(path)?;
    let mut cleaner = Cleaner::new(path, &bytes);
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: true,
        ..Default::default()
    };
    // The prepass keeps material statements to itself, so the loader of materials is never called.
    let loaded = tobj::load_obj_buf(&mut cleaner, &options, |_| {
        Err(tobj::LoadError::GenericFailure)
    });
    let found = cleaner.finish()?;
    let (models, _) = loaded.map_err(|e| Error::input(e.to_string()).at(Place::file(path)))?;
    let source = (models.into_iter().next())
        .map(|model| model.mesh)
        .unwrap_or_default();
    let mesh = mesh(&source, &found);
    mesh.validate()
        .map_err(|e| (e.at(Place::file(path))).help("an OBJ file needs `v` lines and `f` lines"))?;
    let mut warnings = found.warnings(path);
    let (materials, slots) = materials(path, &found, &mut warnings)?;
    Ok(Model {
        meshes: vec![mesh],
        materials,
        parts: vec![Part {
            name: None,
            mesh: 0,
            materials: slots,
            model_from_mesh: Transform::IDENTITY,
        }],
        warnings,
        ..Model::default()
    })
}

fn mesh(source: &tobj::Mesh, found: &Found) -> Mesh {
    let normal = |n: &[f32; 3]| {
        let n = Vec3::from_array(*n).as_dvec3();
        n.normalize_or_zero().as_vec3()
    };
    let mut mesh = Mesh {
        positions: (source.positions.as_chunks().0.iter())
            .map(|&p| Vec3::from_array(p))
            .collect(),
        triangles: source.indices.as_chunks().0.to_vec(),
        ..Mesh::default()
    };
    if found.uses_normals {
        mesh.normals = source.normals.as_chunks().0.iter().map(normal).collect();
    }
    if found.uses_uvs {
        mesh.uvs = (source.texcoords.as_chunks().0.iter())
            .map(|&uv| Vec2::from_array(uv))
            .collect();
    }
    if found.slots.len() > 1 {
        mesh.slots.clone_from(&found.triangle_slots);
    }
    mesh
}

/// The used materials, and for each slot of the mesh an index into them.
fn materials(
    path: &Path,
    found: &Found,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Material>, Vec<Option<usize>>)> {
    let mut definitions = Vec::new();
    let mut complete = true;
    for (line, name) in &found.libraries {
        let files = library_files(path, name);
        if files.is_empty() {
            complete = false;
            warnings.push(format!(
                "{}:{line}: the material library `{name}` does not exist; its materials are replaced by the default",
                path.display()
            ));
        }
        for file in files {
            definitions.extend(mtl::read(&file, warnings)?);
        }
    }
    let mut materials = Vec::new();
    let mut slots = Vec::new();
    let mut textures = HashMap::new();
    for slot in &found.slots {
        let definition = definitions.iter().find(|d| d.name == slot.name);
        slots.push(definition.map(|_| materials.len()));
        if let Some(definition) = definition {
            materials.push(definition.material(&mut textures, warnings)?);
        } else if complete && !slot.name.is_empty() {
            let nearest = (definitions.iter())
                .min_by_key(|d| strsim::damerau_levenshtein(&d.name, &slot.name))
                .map_or(String::new(), |d| {
                    format!("; the nearest name is `{}`", d.name)
                });
            warnings.push(format!(
                "{}:{}: no material is called `{}`, the default is used{nearest}",
                path.display(),
                slot.line,
                slot.name
            ));
        }
    }
    Ok((materials, slots))
}

/// The files that `mtllib` names: the whole line as one name, which may hold spaces, else each word.
fn library_files(obj: &Path, names: &str) -> Vec<PathBuf> {
    let whole = mtl::relative_to(obj, names);
    if whole.is_file() {
        return vec![whole];
    }
    (names.split_whitespace())
        .map(|name| mtl::relative_to(obj, name))
        .filter(|file| file.is_file())
        .collect()
}

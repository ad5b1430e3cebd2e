//! glTF 2.0, as `.gltf` and `.glb`. Every index, size and offset is checked against what is there.

mod accessor;
mod buffer;
mod json;
mod material;
mod mesh;
mod node;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Place, Result};
use crate::scene::{Model, Part};

use super::lines::without_bom;
use super::read_file;
use accessor::Document;
use json::Json;

/// Extensions that a file may require and that are read as they are meant.
const SUPPORTED: [&str; 11] = [
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
];

/// Reads a glTF file: a mesh for each glTF mesh that the scene uses, a part for each node that has one,
/// cameras, point and spot lights.
///
/// # Errors
/// Where the file or one that it names cannot be read, is malformed, requires an extension that is not known,
/// or holds no triangles.
pub(super) fn read(path: &Path) -> Result<Model> {
    let bytes = read_file(path)?;
    let named_glb = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    let (text, binary) = if named_glb || bytes.starts_with(b"glTF") {
        let glb = buffer::split_glb(path, &bytes)?;
        (glb.json, glb.binary)
    } else {
        (without_bom(&bytes), None)
    };
    let value = parse(path, text)?;
    let root = Json::root(path, &value);
    let mut warnings = Vec::new();
    check_version(&root)?;
    check_extensions(&root, &mut warnings)?;
    let buffers = buffer::read_buffers(&root, binary)?;
    let document = Document { root, buffers };
    build(&document, warnings)
}

fn parse(path: &Path, text: &[u8]) -> Result<Value> {
    // Some writers pad the JSON chunk with zeros where spaces belong.
    let end = text
        .iter()
        .rposition(|&b| b != 0)
        .map_or(0, |last| last + 1);
    serde_json::from_slice(&text[..end]).map_err(|e| {
        let excerpt = text.split(|&b| b == b'\n').nth(e.line().saturating_sub(1));
        let excerpt = String::from_utf8_lossy(excerpt.unwrap_or_default());
        Error::input(format!("the JSON is malformed: {e}"))
            .at(Place::column(path, e.line(), e.column(), &excerpt))
            .help("the file is damaged or not glTF")
    })
}

fn check_version(root: &Json<'_>) -> Result<()> {
    let asset = root.need("asset")?;
    let version = asset.need("version")?;
    let least = asset.get("minVersion")?;
    let unknown = match least {
        _ if !version.text()?.starts_with("2.") => version,
        Some(least) if least.text()? != "2.0" => least,
        _ => return Ok(()),
    };
    Err((unknown.error(format!("glTF version `{}`", unknown.text()?))).help("glTF 2.0 is read"))
}

fn check_extensions(root: &Json<'_>, warnings: &mut Vec<String>) -> Result<()> {
    for extension in root.list("extensionsRequired")? {
        let name = extension.text()?;
        if SUPPORTED.contains(&name) {
            continue;
        }
        // These change how the surface looks, not what is there.
        if name.starts_with("KHR_materials_") || name == "KHR_texture_transform" {
            warnings.push(extension.warning(&format!("`{name}` is not supported and ignored")));
        } else {
            return Err(
                (extension.error(format!("the file requires the extension `{name}`")))
                    .help("export it again without this extension"),
            );
        }
    }
    Ok(())
}

/// A mesh's index in the model and the materials of its slots.
type Known = (usize, Vec<Option<usize>>);

fn build(document: &Document<'_>, mut warnings: Vec<String>) -> Result<Model> {
    let root = &document.root;
    let mut model = Model {
        materials: material::read_all(document, &mut warnings)?,
        ..Model::default()
    };
    // By glTF mesh; `None` where it has no triangles.
    let mut known: BTreeMap<usize, Option<Known>> = BTreeMap::new();
    for node in node::walk(root)? {
        let Some(world_from_node) = node.world_from_node else {
            warnings.push(
                node.json
                    .warning("the node's transform has no inverse; it is left out"),
            );
            continue;
        };
        let camera = node::camera(root, &node.json, &world_from_node)?;
        model.cameras.extend(camera);
        model.lights.extend(node::light(
            root,
            &node.json,
            &world_from_node,
            &mut warnings,
        )?);
        let Some(reference) = node.json.get("mesh")? else {
            continue;
        };
        let (index, source) = root.element("meshes", &reference)?;
        let known = match known.entry(index) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let shaped = mesh::read(document, &source, &mut warnings)?;
                entry.insert(shaped.map(|shaped| {
                    model.meshes.push(shaped.mesh);
                    (model.meshes.len() - 1, shaped.materials)
                }))
            }
        };
        if let Some((mesh, materials)) = known {
            model.parts.push(Part {
                name: node.json.name().or_else(|| source.name()),
                mesh: *mesh,
                materials: materials.clone(),
                model_from_mesh: world_from_node,
            });
        }
    }
    if model.parts.is_empty() {
        return Err(root
            .error("the scene has no triangles")
            .help("export the file with meshes"));
    }
    model.warnings = warnings;
    Ok(model)
}

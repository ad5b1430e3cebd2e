//! Meshes: all primitives of a glTF mesh in one.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::error::Result;
use crate::geometry::Mesh;

use super::accessor::Document;
use super::json::Json;

/// A mesh with the glTF material of each of its slots.
pub(super) struct Shaped {
    pub(super) mesh: Mesh,
    pub(super) materials: Vec<Option<usize>>,
}

/// How a primitive's indices make triangles.
#[derive(Clone, Copy)]
enum Mode {
    List,
    Strip,
    Fan,
}

/// Attributes of a primitive by accessor; primitives that share them share vertices.
type Attributes = (usize, Option<usize>, Option<usize>);

/// Reads a mesh; `None` where it has points and lines only. Triangles are numbered through its primitives.
/// `TEXCOORD_0` is turned over, as v = 0 is the top edge in glTF.
///
/// # Errors
/// Where an accessor is wrong or an index is out of range.
pub(super) fn read(
    document: &Document<'_>,
    source: &Json<'_>,
    warnings: &mut Vec<String>,
) -> Result<Option<Shaped>> {
    let mut mesh = Mesh::default();
    let mut materials = Vec::new();
    let mut bases: HashMap<Attributes, (u32, u32)> = HashMap::new();
    for primitive in source.need("primitives")?.elements()? {
        let mode = match primitive.count_or("mode", 4)? {
            0..=3 => {
                warnings.push(primitive.warning("points and lines are not read"));
                continue;
            }
            4 => Mode::List,
            5 => Mode::Strip,
            6 => Mode::Fan,
            mode => {
                return Err(primitive
                    .need("mode")?
                    .error(format!("{mode} is not a mode")));
            }
        };
        let attributes = primitive.need("attributes")?;
        let position = attributes.need("POSITION")?;
        let (normal, uv) = (attributes.get("NORMAL")?, attributes.get("TEXCOORD_0")?);
        let key = (
            position.count()?,
            normal.as_ref().map(Json::count).transpose()?,
            uv.as_ref().map(Json::count).transpose()?,
        );
        let (base, count) = if let Some(&known) = bases.get(&key) {
            known
        } else {
            let added = add_vertices(document, &mut mesh, &position, normal.as_ref(), uv.as_ref())?;
            bases.insert(key, added);
            added
        };
        let indices = if let Some(reference) = primitive.get("indices")? {
            let indices = document.indices(&reference)?;
            if let Some(i) = indices.iter().position(|&i| i >= count) {
                return Err(reference.error(format!(
                    "element {i} is the index {}, but there are {count} vertices",
                    indices[i]
                )));
            }
            indices
        } else {
            (0..count).collect()
        };
        let before = mesh.triangles.len();
        add_triangles(&mut mesh, &primitive, mode, &indices, base)?;
        let material = (primitive.get("material")?)
            .map(|reference| Ok(document.root.element("materials", &reference)?.0))
            .transpose()?;
        let slot = materials
            .iter()
            .position(|&m| m == material)
            .unwrap_or_else(|| {
                materials.push(material);
                materials.len() - 1
            });
        let added = mesh.triangles.len() - before;
        mesh.slots.extend(std::iter::repeat_n(slot as u32, added));
    }
    if mesh.triangles.is_empty() {
        return Ok(None);
    }
    if materials.len() == 1 {
        mesh.slots.clear();
    }
    mesh.validate().map_err(|e| e.at(source.place()))?;
    Ok(Some(Shaped { mesh, materials }))
}

/// Appends the vertices of a primitive: the first one's index and how many there are.
fn add_vertices(
    document: &Document<'_>,
    mesh: &mut Mesh,
    position: &Json<'_>,
    normal: Option<&Json<'_>>,
    uv: Option<&Json<'_>>,
) -> Result<(u32, u32)> {
    let base = mesh.positions.len();
    let positions = document.vectors::<3>(position)?;
    let total = base + positions.len();
    if u32::try_from(total).is_err() {
        return Err(position.error(format!(
            "the mesh has {total} vertices, more than can be indexed"
        )));
    }
    let check = |reference: &Json<'_>, count: usize| {
        if count == positions.len() {
            return Ok(());
        }
        Err(reference.error(format!("{count} values for {} vertices", positions.len())))
    };
    // Where only some primitives have an attribute, the others get zeros.
    if let Some(reference) = normal {
        let normals = document.vectors::<3>(reference)?;
        check(reference, normals.len())?;
        mesh.normals.resize(base, Vec3::ZERO);
        mesh.normals.extend((normals.iter()).map(|&n| {
            let n = Vec3::from_array(n).as_dvec3();
            n.normalize_or_zero().as_vec3()
        }));
    } else if !mesh.normals.is_empty() {
        mesh.normals.resize(total, Vec3::ZERO);
    }
    if let Some(reference) = uv {
        let uvs = document.vectors::<2>(reference)?;
        check(reference, uvs.len())?;
        mesh.uvs.resize(base, Vec2::ZERO);
        mesh.uvs
            .extend(uvs.iter().map(|&[u, v]| Vec2::new(u, 1.0 - v)));
    } else if !mesh.uvs.is_empty() {
        mesh.uvs.resize(total, Vec2::ZERO);
    }
    mesh.positions
        .extend(positions.iter().map(|&p| Vec3::from_array(p)));
    Ok((base as u32, positions.len() as u32))
}

/// Section 3.7.2.1 of the specification: every other triangle of a strip is turned over.
fn add_triangles(
    mesh: &mut Mesh,
    primitive: &Json<'_>,
    mode: Mode,
    indices: &[u32],
    base: u32,
) -> Result<()> {
    let count = indices.len();
    let fits = match mode {
        Mode::List => count.is_multiple_of(3) && count > 0,
        Mode::Strip | Mode::Fan => count >= 3,
    };
    if !fits {
        return Err(primitive.error(format!("{count} indices do not make triangles")));
    }
    let triangles = match mode {
        Mode::List => count / 3,
        Mode::Strip | Mode::Fan => count - 2,
    };
    mesh.triangles.extend((0..triangles).map(|i| {
        let corners = match mode {
            Mode::List => [3 * i, 3 * i + 1, 3 * i + 2],
            Mode::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Mode::Fan => [0, i + 1, i + 2],
        };
        corners.map(|c| base + indices[c])
    }));
    Ok(())
}

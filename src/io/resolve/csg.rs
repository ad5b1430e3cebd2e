//! Trees of operators as CSG objects.

use std::mem;
use std::ops::Range;
use std::slice;

use glam::DMat3;

use crate::error::{Error, Result};
use crate::geometry::{Csg, CsgId, CsgOp, MeshId, Operand, Shape, Solid};
use crate::material::MaterialId;
use crate::math::Transform;
use crate::scene::Instance;
use crate::scene::description::{ObjectDescription, ShapeDescription};

use super::super::closed::check_closed;
use super::objects::Role;
use super::{Loader, OpenMeshOperands};

/// What an operator has from those above it.
#[derive(Clone, Copy)]
struct Context {
    /// Where it stands in its frame: the whole object, or one copy of the `Repeat` that it is part of.
    frame_from_self: Transform,
    /// The outermost material that is set, its own included.
    material: Option<MaterialId>,
}

/// A CSG object in the making.
struct Draft {
    csg: Csg,
    materials: Vec<MaterialId>,
    /// Whether all meshes in it have interpolated normals.
    smooth: bool,
}

impl<'a> Loader<'a> {
    /// The CSG object of a tree whose root is an operator or a `Repeat`. The root's own name, material and transform
    /// are left out of it.
    ///
    /// Transforms and materials go down from the root, then operands come up in post-order. What a `Repeat` copies
    /// is built in a frame of its own.
    pub(super) fn csg(&mut self, tree: &'a [ObjectDescription]) -> Result<Instance> {
        let (parents, opened) = links(tree);
        let contexts = self.contexts(tree, &parents)?;
        let mut outer = Vec::new();
        let mut draft = Draft {
            csg: Csg::default(),
            materials: Vec::new(),
            smooth: true,
        };
        for (i, object) in tree.iter().enumerate() {
            for _ in 0..opened[i] {
                outer.push(mem::take(&mut draft.csg));
            }
            match &object.shape {
                &ShapeDescription::Csg { op, operands } => {
                    self.grow(1, object.offset)?;
                    draft.csg.combine(op, operands);
                }
                ShapeDescription::Repeat(repeat) => {
                    let outer = outer.pop().expect("one was opened for it");
                    let one = mem::replace(&mut draft.csg, outer);
                    let copies = repeat.copies();
                    self.grow(one.steps.len().saturating_mul(copies), object.offset)?;
                    let places = repeat.positions().map(|(_, position)| {
                        let place = Transform::rigid(DMat3::IDENTITY, position);
                        contexts[i].frame_from_self.after(&place)
                    });
                    let slots = 0..draft.materials.len() as u32;
                    draft.csg.append(&one, places, slots);
                    draft.csg.combine(CsgOp::Union, copies);
                }
                _ => {
                    let parent = parents[i];
                    let place = frame_from_operands(&tree[parent], &contexts[parent]);
                    self.add(object, &place, contexts[parent].material, &mut draft)?;
                }
            }
        }
        let Draft {
            csg,
            materials,
            smooth,
        } = draft;
        let finite = csg.leaves.iter().all(|leaf| leaf.origin.is_finite())
            && (csg.maps.iter()).all(|map| map.forward.is_finite() && map.inverse.is_finite());
        if !finite {
            return Err(self.too_far(&tree[tree.len() - 1]));
        }
        self.csgs.push(csg);
        Ok(Instance {
            name: None,
            shape: Shape::Csg(CsgId(self.csgs.len() as u32 - 1)),
            materials,
            world_from_object: Transform::IDENTITY,
            smooth,
        })
    }

    /// Adds an object that is no operator in its `place`, with the material that it shares, if it does.
    fn add(
        &mut self,
        object: &'a ObjectDescription,
        place: &Transform,
        shared: Option<MaterialId>,
        draft: &mut Draft,
    ) -> Result<()> {
        let pieces = self.instances(slice::from_ref(object), Role::Operand)?;
        if pieces.is_empty() {
            let message = "the operand has no meshes, and so no inside";
            return Err(Error::input(message).at(self.place(object.offset)));
        }
        for piece in &pieces {
            self.grow(1, object.offset)?;
            draft.smooth &= piece.smooth;
            let materials = shared
                .as_ref()
                .map_or(&piece.materials[..], slice::from_ref);
            let slots = slots(&mut draft.materials, materials);
            let place = place.after(&piece.world_from_object);
            let operand = match piece.shape {
                Shape::Solid(Solid::Rectangle { .. } | Solid::Disk { .. }) => {
                    let message = "the operand is a rectangle or disk, which has no inside";
                    return Err(Error::input(message)
                        .at(self.place(object.offset))
                        .help("take a thin `Box` or `Cylinder`, or a `Plane`"));
                }
                Shape::Solid(solid) => Operand::Solid(solid),
                Shape::Mesh(id) => self.mesh_operand(id, object)?,
                Shape::Csg(id) => {
                    self.grow(self.csgs[id.0 as usize].steps.len(), object.offset)?;
                    draft.csg.append(&self.csgs[id.0 as usize], [place], slots);
                    continue;
                }
            };
            draft.csg.push(operand, &place, slots);
        }
        if pieces.len() > 1 {
            draft.csg.combine(CsgOp::Union, pieces.len());
        }
        Ok(())
    }

    /// The context of each operator of a tree.
    fn contexts(&self, tree: &[ObjectDescription], parents: &[usize]) -> Result<Vec<Context>> {
        let root = Context {
            frame_from_self: Transform::IDENTITY,
            material: None,
        };
        let mut contexts = vec![root; tree.len()];
        for i in (0..tree.len() - 1).rev() {
            let (object, parent) = (&tree[i], parents[i]);
            if object.shape.operands() == 0 {
                continue;
            }
            let own = (object.material.as_ref())
                .map(|m| self.material(m))
                .transpose()?;
            let frame_from_parent = frame_from_operands(&tree[parent], &contexts[parent]);
            contexts[i] = Context {
                frame_from_self: frame_from_parent.after(&object.transform),
                material: contexts[parent].material.or(own),
            };
        }
        Ok(contexts)
    }

    /// A mesh as an operand, checked the first time.
    fn mesh_operand(&mut self, id: MeshId, object: &ObjectDescription) -> Result<Operand> {
        if let Some(known) = self.operands.get(&id) {
            return Ok(*known);
        }
        let (file, part) = &self.meshes[&id];
        let mesh = &self.scene.meshes[id.0 as usize];
        let operand = match check_closed(file, part.as_deref(), mesh) {
            Ok(()) => Operand::Mesh(id),
            Err(e) if self.options.open_mesh_operands == OpenMeshOperands::Refuse => {
                return Err(e.at(self.place(object.offset)));
            }
            Err(e) => {
                let what = e.message().lines().next().unwrap_or_default();
                let warning = format!(
                    "{}: {what}; its inside is where it winds around a point",
                    file.display()
                );
                self.scene.warnings.push(warning);
                Operand::OpenMesh(id)
            }
        };
        self.operands.insert(id, operand);
        Ok(operand)
    }
}

/// For each object the index of its operator (the root has its own), and how many `Repeat`s make copies of what begins
/// there.
fn links(tree: &[ObjectDescription]) -> (Vec<usize>, Vec<usize>) {
    let mut parents = vec![tree.len() - 1; tree.len()];
    let mut opened = vec![0; tree.len()];
    // The last and the first object of each that no operator has taken so far.
    let mut results: Vec<(usize, usize)> = Vec::new();
    for (i, object) in tree.iter().enumerate() {
        let operands = results.split_off(results.len() - object.shape.operands());
        for &(operand, _) in &operands {
            parents[operand] = i;
        }
        let first = operands.first().map_or(i, |&(_, first)| first);
        if let ShapeDescription::Repeat(_) = object.shape {
            opened[first] += 1;
        }
        results.push((i, first));
    }
    (parents, opened)
}

/// Where the operands of an operator stand.
fn frame_from_operands(operator: &ObjectDescription, context: &Context) -> Transform {
    match operator.shape {
        ShapeDescription::Repeat(_) => Transform::IDENTITY,
        _ => context.frame_from_self,
    }
}

/// Where `own` stands in `materials`, to which it is added if it does not.
fn slots(materials: &mut Vec<MaterialId>, own: &[MaterialId]) -> Range<u32> {
    let known = materials.windows(own.len()).position(|run| run == own);
    let start = known.unwrap_or_else(|| {
        materials.extend(own);
        materials.len() - own.len()
    });
    start as u32..(start + own.len()) as u32
}

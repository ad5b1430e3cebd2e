//! Trees of operators as CSG objects.

use std::mem;
use std::ops::Range;
use std::slice;

use glam::DMat3;

use crate::error::{Error, Result};
use crate::geometry::{Csg, CsgId, CsgOp, MeshId, Operand, Shape};
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

impl<'a> Loader<'a> {
    /// The CSG object of a tree whose root is an operator or a `Repeat`. The root's own name, material and transform
    /// are left out of it.
    ///
    /// Transforms and materials go down from the root, then operands come up in post-order. What a `Repeat` copies
    /// is built in a frame of its own.
    pub(super) fn csg(&mut self, tree: &'a [ObjectDescription]) -> Result<Instance> {
        let (parents, opened) = links(tree);
        let contexts = self.contexts(tree, &parents)?;
        let mut frame = Csg::default();
        let mut outer_frames = Vec::new();
        let mut materials = Vec::new();
        let mut smooth = true;
        for (i, object) in tree.iter().enumerate() {
            for _ in 0..opened[i] {
                outer_frames.push(mem::take(&mut frame));
            }
            match &object.shape {
                &ShapeDescription::Csg { op, operands } => {
                    self.grow(1, object.offset)?;
                    frame.combine(op, operands);
                }
                ShapeDescription::Repeat(repeat) => {
                    let outer = outer_frames.pop().expect("one was opened for it");
                    let one = mem::replace(&mut frame, outer);
                    let copies = repeat.copies();
                    self.grow(one.steps.len().saturating_mul(copies), object.offset)?;
                    let places = repeat.positions().map(|(_, position)| {
                        let place = Transform::rigid(DMat3::IDENTITY, position);
                        contexts[i].frame_from_self.after(&place)
                    });
                    frame.append(&one, places, 0..materials.len() as u32);
                    frame.combine(CsgOp::Union, copies);
                }
                _ => {
                    let parent = parents[i];
                    let frame_from_parent = frame_from_operands(&tree[parent], &contexts[parent]);
                    let pieces = self.instances(slice::from_ref(object), Role::Operand)?;
                    if pieces.is_empty() {
                        let message = "an operand without any mesh, of which there is no inside";
                        return Err(Error::input(message).at(self.place(object.offset)));
                    }
                    for piece in &pieces {
                        let place = frame_from_parent.after(&piece.world_from_object);
                        let shared = contexts[parent].material.as_ref();
                        let own = shared.map_or(&piece.materials[..], slice::from_ref);
                        let slots = slots(&mut materials, own);
                        smooth &= piece.smooth;
                        self.grow(1, object.offset)?;
                        match piece.shape {
                            Shape::Solid(solid) => frame.push(Operand::Solid(solid), &place, slots),
                            Shape::Mesh(id) => {
                                frame.push(self.mesh_operand(id, object)?, &place, slots);
                            }
                            Shape::Csg(id) => {
                                let steps = self.csgs[id.0 as usize].steps.len();
                                self.grow(steps, object.offset)?;
                                frame.append(&self.csgs[id.0 as usize], [place], slots);
                            }
                        }
                    }
                    if pieces.len() > 1 {
                        frame.combine(CsgOp::Union, pieces.len());
                    }
                }
            }
        }
        let finite = frame.leaves.iter().all(|leaf| leaf.origin.is_finite())
            && (frame.maps.iter()).all(|map| map.forward.is_finite() && map.inverse.is_finite());
        if !finite {
            return Err(self.too_far(&tree[tree.len() - 1]));
        }
        self.csgs.push(frame);
        Ok(Instance {
            name: None,
            shape: Shape::Csg(CsgId(self.csgs.len() as u32 - 1)),
            materials,
            world_from_object: Transform::IDENTITY,
            smooth,
        })
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

//! Objects as instances.

use std::rc::Rc;

use glam::DMat3;

use crate::error::{Error, Result};
use crate::geometry::Shape;
use crate::math::Transform;
use crate::scene::description::{ObjectDescription, ObjectTree, Reference, ShapeDescription};
use crate::scene::{Instance, Repeat};

use super::{INSTANCE, Loader};

/// What an object is used as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Role {
    /// It stands in the world, each copy by itself.
    World,
    /// It is combined with others; all copies are one CSG object.
    Operand,
}

impl<'a> Loader<'a> {
    /// The instances that a tree's object consists of.
    pub(super) fn instances(
        &mut self,
        tree: &'a [ObjectDescription],
        role: Role,
    ) -> Result<Vec<Instance>> {
        let repeats = (tree.iter().rev())
            .take_while(|o| role == Role::World && matches!(o.shape, ShapeDescription::Repeat(_)));
        let (base, repeats) = tree.split_at(tree.len() - repeats.count());
        let object = &base[base.len() - 1];
        let mut instances = match &object.shape {
            ShapeDescription::Solid { solid, placement } => vec![Instance {
                name: None,
                shape: Shape::Solid(*solid),
                materials: match object.material {
                    Some(_) => Vec::new(),
                    None => vec![self.scene.default_material()],
                },
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
            ShapeDescription::Instance { of } => {
                let instances = self.resolve(of, role)?;
                self.grow(INSTANCE * instances.len(), object.offset)?;
                instances.to_vec()
            }
            ShapeDescription::Csg { .. } | ShapeDescription::Repeat(_) => vec![self.csg(base)?],
        };
        self.dress(object, object.name.as_deref(), &mut instances)?;
        for object in repeats {
            if let ShapeDescription::Repeat(repeat) = &object.shape {
                instances = self.copies(object, *repeat, &instances)?;
            }
        }
        Ok(instances)
    }

    /// The instances of a definition, resolved when they are first asked for.
    fn resolve(&mut self, of: &Reference, role: Role) -> Result<Rc<[Instance]>> {
        let (name, ObjectTree(tree)) = self.definition(of)?;
        // All else is the same in both roles.
        let role = match tree[tree.len() - 1].shape {
            ShapeDescription::Instance { .. } | ShapeDescription::Repeat(_) => role,
            _ => Role::World,
        };
        if let Some(known) = self.resolved.get(&(name, role)) {
            return Ok(known.clone());
        }
        let instances: Rc<[Instance]> = self.instances(tree, role)?.into();
        self.resolved.insert((name, role), instances.clone());
        Ok(instances)
    }

    /// Checks the definitions that nothing has needed.
    pub(super) fn resolve_unused(&mut self) -> Result<()> {
        for (name, ObjectTree(tree)) in &self.description.definitions {
            let used = |role| self.resolved.contains_key(&(&**name, role));
            if !used(Role::World) && !used(Role::Operand) {
                self.instances(tree, Role::World)?;
            }
        }
        Ok(())
    }

    fn copies(
        &mut self,
        object: &ObjectDescription,
        repeat: Repeat,
        of: &[Instance],
    ) -> Result<Vec<Instance>> {
        let count = of.len().saturating_mul(repeat.copies());
        self.grow(count.saturating_mul(INSTANCE), object.offset)?;
        let mut copies = Vec::with_capacity(count);
        for ([i, j, k], position) in repeat.positions() {
            let place = Transform::rigid(DMat3::IDENTITY, position);
            let first = copies.len();
            copies.extend(of.iter().map(|instance| Instance {
                world_from_object: place.after(&instance.world_from_object),
                ..instance.clone()
            }));
            let name = object
                .name
                .as_ref()
                .map(|name| format!("{name}[{i},{j},{k}]"));
            self.dress(object, name.as_deref(), &mut copies[first..])?;
        }
        Ok(copies)
    }

    /// Gives instances the material and transform of their object, if it has them, and a name that starts with its.
    fn dress(
        &self,
        object: &ObjectDescription,
        name: Option<&str>,
        instances: &mut [Instance],
    ) -> Result<()> {
        let material = (object.material.as_ref())
            .map(|m| self.material(m))
            .transpose()?;
        for instance in instances {
            if let Some(material) = material {
                instance.materials = vec![material];
            }
            instance.name = match (name, instance.name.take()) {
                (Some(outer), Some(inner)) => Some(format!("{outer}/{inner}")),
                (outer, inner) => outer.map(str::to_owned).or(inner),
            };
            let placed = object.transform.after(&instance.world_from_object);
            if !placed.is_finite() {
                return Err(self.too_far(object));
            }
            instance.world_from_object = placed;
        }
        Ok(())
    }

    pub(super) fn too_far(&self, object: &ObjectDescription) -> Error {
        let name = object.name.as_deref().unwrap_or("without a name");
        Error::input(format!(
            "the transforms of the object {name} take it beyond what numbers can hold"
        ))
        .at(self.place(object.offset))
    }
}

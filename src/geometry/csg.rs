use std::borrow::Borrow;
use std::ops::Range;

use glam::{DAffine3, DMat3, DVec3};

use crate::math::Transform;

use super::{MeshId, Solid};

/// Index into the scene's list of CSG objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CsgId(pub u32);

/// A set operation on any number of operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CsgOp {
    /// What is in any of them.
    Union,
    /// What is in all of them.
    Intersection,
    /// What is in the first and in none of the others.
    Difference,
}

/// What CSG combines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operand {
    /// An analytic solid in its canonical position; the plane is a half-space.
    Solid(Solid),
    /// A closed mesh: inside is where it winds around a point at least once.
    Mesh(MeshId),
    /// Any mesh: inside is where its generalized winding number is above one half.
    OpenMesh(MeshId),
}

/// A tree of set operations over operands in their places, in post-order: a step puts a result on top of those
/// before it, and an operator takes the topmost ones away for it. Nothing about it is recursive, so trees may be
/// of any depth.
///
/// ```
/// use glam::DVec3;
/// use solidtrace::geometry::{Csg, CsgOp, Operand, Solid};
/// use solidtrace::math::Transform;
///
/// let mut bead = Csg::default();
/// bead.push(Operand::Solid(Solid::Sphere { radius: 1.0 }), &Transform::IDENTITY, 0..1);
/// bead.push(Operand::Solid(Solid::Box { half: DVec3::new(0.3, 0.3, 2.0) }), &Transform::IDENTITY, 1..2);
/// bead.combine(CsgOp::Difference, 2);
/// assert_eq!((bead.results(), bead.len()), (1, 2));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Csg {
    /// Neighbouring leaves share an entry where they can, and so do all copies of a repeated tree.
    pub(crate) operands: Vec<Operand>,
    /// Shared in the same way.
    pub(crate) maps: Vec<LinearMap>,
    pub(crate) leaves: Vec<CsgLeaf>,
    pub(crate) steps: Vec<CsgStep>,
    results: usize,
}

/// The linear part of an operand's transform, with its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinearMap {
    pub(crate) forward: DMat3,
    pub(crate) inverse: DMat3,
}

impl LinearMap {
    /// This map, and then the origin moved to `origin`.
    pub(crate) fn at(&self, origin: DVec3) -> Transform {
        Transform::of_parts(
            DAffine3::from_mat3_translation(self.forward, origin),
            DAffine3::from_mat3_translation(self.inverse, -(self.inverse * origin)),
        )
    }
}

/// An operand in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CsgLeaf {
    /// Where the operand's own origin lies.
    pub(crate) origin: DVec3,
    /// Index of the operand.
    pub(crate) operand: u32,
    /// Index of the linear map.
    pub(crate) map: u32,
    /// First of its material slots, and how many there are.
    slot: u32,
    slots: u32,
}

/// One step of the post-order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CsgStep {
    /// The next leaf.
    Leaf,
    /// An operator over the last so many results.
    Combine(CsgOp, u32),
}

impl Csg {
    /// Adds an operand. Its surface has the instance's material `slots`; a mesh with more slots than that has the last
    /// of them on the rest.
    pub fn push(&mut self, operand: Operand, csg_from_operand: &Transform, slots: Range<u32>) {
        let map = LinearMap {
            forward: csg_from_operand.matrix().matrix3,
            inverse: csg_from_operand.inverse_matrix().matrix3,
        };
        self.leaves.push(CsgLeaf {
            origin: csg_from_operand.matrix().translation,
            operand: shared(&mut self.operands, operand),
            map: shared(&mut self.maps, map),
            slot: slots.start,
            slots: slots.end - slots.start,
        });
        self.steps.push(CsgStep::Leaf);
        self.results += 1;
    }

    /// Makes one result of the last `count`, at least one.
    ///
    /// # Panics
    /// Where there are fewer.
    pub fn combine(&mut self, op: CsgOp, count: usize) {
        assert!(
            (1..=self.results).contains(&count),
            "{count} operands of {}",
            self.results
        );
        self.steps.push(CsgStep::Combine(op, count as u32));
        self.results -= count - 1;
    }

    /// Adds all results of `other` once for each of `places`. Its material slots are the instance's `slots`; where it
    /// has more than that, the last of them is on the rest.
    pub fn append(
        &mut self,
        other: &Self,
        places: impl IntoIterator<Item = impl Borrow<Transform>>,
        slots: Range<u32>,
    ) {
        let places = places.into_iter();
        let copies = places.size_hint().0;
        self.leaves.reserve(copies * other.leaves.len());
        self.steps.reserve(copies * other.steps.len());
        let first_operand = self.operands.len() as u32;
        self.operands.extend(&other.operands);
        let mut placed: Option<(DMat3, u32)> = None;
        for place in places {
            let (outer, back) = (place.borrow().matrix(), place.borrow().inverse_matrix());
            let first_map = match placed {
                Some((linear, first)) if linear == outer.matrix3 => first,
                _ => {
                    let first = self.maps.len() as u32;
                    self.maps.extend(other.maps.iter().map(|map| LinearMap {
                        forward: outer.matrix3 * map.forward,
                        inverse: map.inverse * back.matrix3,
                    }));
                    first
                }
            };
            placed = Some((outer.matrix3, first_map));
            self.leaves.extend(other.leaves.iter().map(|leaf| {
                let slot = (slots.start + leaf.slot).min(slots.end - 1);
                CsgLeaf {
                    origin: outer.transform_point3(leaf.origin),
                    operand: first_operand + leaf.operand,
                    map: first_map + leaf.map,
                    slot,
                    slots: leaf.slots.min(slots.end - slot),
                }
            }));
            self.steps.extend(&other.steps);
            self.results += other.results;
        }
    }

    /// How many results no operator has taken; a finished tree has one.
    pub fn results(&self) -> usize {
        self.results
    }

    /// How many operands there are; an operand's index counts them in the order in which they were added.
    pub fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// Operand `index` and its transform.
    pub fn operand(&self, index: u32) -> (Operand, Transform) {
        let leaf = &self.leaves[index as usize];
        let transform = self.maps[leaf.map as usize].at(leaf.origin);
        (self.operands[leaf.operand as usize], transform)
    }

    /// The meshes among its operands; some may be named more than once.
    pub fn meshes(&self) -> Vec<MeshId> {
        let mesh = |operand: &Operand| match operand {
            Operand::Solid(_) => None,
            Operand::Mesh(id) | Operand::OpenMesh(id) => Some(*id),
        };
        self.operands.iter().filter_map(mesh).collect()
    }

    /// The instance's material slot for operand `index`'s own `slot`.
    pub fn slot(&self, index: u32, slot: u32) -> u32 {
        let leaf = &self.leaves[index as usize];
        leaf.slot + slot.min(leaf.slots - 1)
    }
}

/// The index of `item`, which is taken over from the last place if it is there.
fn shared<T: PartialEq>(list: &mut Vec<T>, item: T) -> u32 {
    if list.last() != Some(&item) {
        list.push(item);
    }
    list.len() as u32 - 1
}

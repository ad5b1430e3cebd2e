//! CSG objects: one tree of boxes over all operands, and one pass along a ray that counts which of them it is in.
//!
//! The cost of a ray grows with the logarithm of the number of operands, for it sees only those that it meets, in
//! order, up to its first hit.

mod coincident;
mod flatten;
mod operand;
mod sweep;

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{DVec3, Vec2};

use crate::error::{Error, Result};
use crate::geometry::{Csg, LinearMap, Mesh, Operand};
use crate::math::{Bounds, Ray};

use super::boxes::BoxTree;
use super::mesh::MeshTree;
use super::options::AccelOptions;

use super::winding::{APPROXIMATION, WindingNumber};
use flatten::{Formula, Literal, Operator};
pub use operand::HOLE;
pub(super) use operand::ROUNDING;
use operand::{Form, Kind, Leaf, moved};

/// A CSG object made ready for rays and points, in its own space.
#[derive(Debug)]
pub struct CsgTree {
    /// The first is the root; each stands behind its parent.
    operators: Vec<Operator>,
    forms: Vec<Form>,
    maps: Vec<LinearMap>,
    /// Those without bounds, then the others in the order of the tree's leaves.
    leaves: Vec<Leaf>,
    unbounded: u32,
    /// Where in `leaves` each authored operand is, or `u32::MAX`.
    positions: Vec<u32>,
    tree: Option<BoxTree>,
    bounds: Bounds,
    report: CsgReport,
}

/// What building a CSG object found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CsgReport {
    /// Operands as authored.
    pub operands: usize,
    /// Those left out because they cannot matter: their boxes miss everything that they are combined with.
    pub dropped: usize,
    /// Operators as authored.
    pub operators: usize,
    /// Operators left after flattening.
    pub flattened: usize,
    /// The most operators above an operand as authored.
    pub depth: usize,
    /// Bytes held.
    pub bytes: usize,
}

/// A place where a ray crosses the surface of a CSG object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CsgCrossing {
    /// Ray parameter.
    pub t: f64,
    /// Index of the operand whose surface it is.
    pub operand: u32,
    /// Solid: the face. Mesh: the triangle, or [`HOLE`].
    pub face: u32,
    /// Whether the ray goes into the object.
    pub enter: bool,
    /// Whether the operand is subtracted there: its surface faces into it.
    pub negated: bool,
}

impl CsgTree {
    /// Builds the tree of `csg`, whose mesh operands are in `meshes` by index.
    ///
    /// # Errors
    /// Where the tree is not one whole, or a mesh is not closed.
    pub fn build(csg: &Csg, meshes: &[Mesh]) -> Result<Self> {
        let options = AccelOptions::default();
        let meshes = mesh_trees(meshes, std::slice::from_ref(csg), options)?;
        Self::over(csg, &meshes, options)
    }

    /// As [`CsgTree::build`], over what [`mesh_trees`] made.
    pub(super) fn over(csg: &Csg, meshes: &[Arc<MeshTree>], options: AccelOptions) -> Result<Self> {
        if csg.results() != 1 {
            return Err(
                Error::input(format!("the CSG tree has {} results", csg.results()))
                    .help("its last step must combine all that is left"),
            );
        }
        let forms: Vec<Form> = (csg.operands.iter())
            .map(|operand| {
                Form::new(match operand {
                    Operand::Solid(solid) => Kind::Solid(*solid),
                    Operand::Mesh(id) => Kind::Mesh(meshes[id.0 as usize].clone()),
                    Operand::OpenMesh(id) => {
                        let mesh = meshes[id.0 as usize].clone();
                        Kind::OpenMesh(Arc::new(WindingNumber::new(mesh)))
                    }
                })
            })
            .collect();
        let maps = csg.maps.clone();
        let boxes: Vec<Bounds> = (csg.leaves.iter())
            .map(|leaf| {
                let bounds = forms[leaf.operand as usize].bounds();
                let map = &maps[leaf.map as usize];
                if bounds.is_finite() {
                    Bounds::of_points(bounds.corners().map(|p| leaf.origin + map.forward * p))
                } else {
                    Bounds::ALL
                }
            })
            .collect();
        let (formula, authored) = Formula::new(csg, &boxes);
        drop(boxes);
        let (bounded, unbounded): (Vec<&Literal>, Vec<_>) =
            (formula.literals.iter()).partition(|literal| literal.bounds.is_finite());
        let boxes: Vec<Bounds> = bounded.iter().map(|literal| literal.bounds).collect();
        let (tree, order) = if boxes.is_empty() {
            (None, Vec::new())
        } else {
            let (tree, order) = BoxTree::build(&boxes, None, options);
            (Some(tree), order)
        };
        let in_order = order.iter().map(|&i| bounded[i as usize]);
        let leaves: Vec<Leaf> = (unbounded.iter().copied().chain(in_order))
            .map(|literal| {
                let leaf = &csg.leaves[literal.leaf as usize];
                Leaf::new(
                    leaf.origin,
                    leaf.operand,
                    leaf.map,
                    literal.leaf,
                    literal.parent,
                    literal.negated,
                )
            })
            .collect();
        let mut positions = vec![u32::MAX; csg.len()];
        for (position, leaf) in leaves.iter().enumerate() {
            positions[leaf.id as usize] = position as u32;
        }
        let bytes = tree.as_ref().map_or(0, BoxTree::bytes)
            + size_of_val(&*leaves)
            + size_of_val(&*formula.operators)
            + size_of_val(&*forms)
            + size_of_val(&*maps)
            + size_of_val(&*positions);
        Ok(Self {
            report: CsgReport {
                operands: csg.len(),
                dropped: csg.len() - leaves.len(),
                operators: authored.operators,
                flattened: formula.operators.len(),
                depth: authored.depth,
                bytes,
            },
            operators: formula.operators,
            forms,
            maps,
            leaves,
            unbounded: unbounded.len() as u32,
            positions,
            tree,
            bounds: formula.bounds,
        })
    }

    /// What building it found.
    pub fn report(&self) -> CsgReport {
        self.report
    }

    /// The box around it: empty where nothing is left of it, infinite where half-spaces leave it open.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The first crossing with `tmin < t < tmax`.
    ///
    /// Crossings of two operands that are closer than their rounding are one: coincident faces have neither skins
    /// nor cracks. Of coincident surfaces the one of an operand that is not subtracted is reported, then the lowest.
    pub fn intersect(&self, ray: &Ray) -> Option<CsgCrossing> {
        self.sweep(ray, |flip| ControlFlow::Break(self.crossing(flip)))
    }

    /// Whether there is a crossing with `tmin < t < tmax`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.sweep(ray, |_| ControlFlow::Break(())).is_some()
    }

    /// All crossings with `tmin < t < tmax`, in order.
    pub fn crossings(&self, ray: &Ray) -> Vec<CsgCrossing> {
        let mut crossings = Vec::new();
        let _: Option<()> = self.sweep(ray, |flip| {
            crossings.push(self.crossing(flip));
            ControlFlow::Continue(())
        });
        crossings
    }

    /// Whether `p` lies inside or, to within rounding, on the surface.
    pub fn contains(&self, p: DVec3) -> bool {
        let holds = |position: &u32| {
            let leaf = &self.leaves[*position as usize];
            leaf.contains(
                &self.forms[leaf.form as usize],
                &self.maps[leaf.map as usize],
                p,
            )
        };
        let mut holding: Vec<u32> = (0..self.unbounded).filter(holds).collect();
        if let Some(tree) = &self.tree {
            tree.around(p, |leaf| {
                holding.extend(Some(leaf + self.unbounded).filter(holds));
            });
        }
        self.holds(holding.into_iter())
    }

    /// How far off its place the surface of `operand` at `face` may be found, seen from its own point `p` with the
    /// unit normal `n`.
    pub(super) fn uncertainty(&self, operand: u32, face: u32, p: DVec3, n: DVec3) -> f64 {
        let (leaf, form, map) = self.leaf(operand);
        if face == HOLE
            && let Kind::OpenMesh(mesh) = &form.kind
        {
            let fall = mesh.fall(map.inverse * (p - leaf.origin));
            let n = map.forward.transpose() * n;
            return n.length() * (APPROXIMATION / fall.length()).min(form.size);
        }
        let span = 2.0 * p.abs() + leaf.origin.abs();
        let distance = (map.inverse * (p - leaf.origin)).length();
        let n = map.forward.transpose() * n;
        n.length() * form.uncertainty(moved(&map.inverse, span), distance, n.normalize())
    }

    /// The barycentric weights of the second and third corner where `ray` crosses a mesh; else 0.
    pub(super) fn weights(&self, ray: &Ray, crossing: &CsgCrossing) -> Vec2 {
        let (leaf, form, map) = self.leaf(crossing.operand);
        let mesh = match &form.kind {
            Kind::Solid(_) => return Vec2::ZERO,
            Kind::Mesh(mesh) => mesh,
            Kind::OpenMesh(winding) => &winding.mesh,
        };
        let local = leaf.local_ray(map, ray);
        mesh.barycentric(&local, crossing.t, crossing.face)
            .as_vec2()
    }

    /// The outward normal of `operand` at its own point `p` in a hole, where the face is [`HOLE`]; all in the
    /// operand's space.
    pub fn hole_normal(&self, operand: u32, p: DVec3) -> DVec3 {
        match &self.leaf(operand).1.kind {
            Kind::OpenMesh(mesh) => mesh.fall(p).normalize_or(DVec3::Z),
            _ => DVec3::Z,
        }
    }

    fn leaf(&self, operand: u32) -> (&Leaf, &Form, &LinearMap) {
        let leaf = &self.leaves[self.positions[operand as usize] as usize];
        let (form, map) = (leaf.form as usize, leaf.map as usize);
        (leaf, &self.forms[form], &self.maps[map])
    }

    fn crossing(&self, flip: sweep::Flip) -> CsgCrossing {
        let leaf = &self.leaves[flip.leaf as usize];
        CsgCrossing {
            t: flip.t,
            operand: leaf.id,
            face: flip.face,
            enter: flip.enter,
            negated: leaf.negated(),
        }
    }
}

/// The tree of each mesh; those of meshes that a CSG object uses hold every triangle.
///
/// # Errors
/// Where a mesh is invalid, or is an operand and not closed.
pub(super) fn mesh_trees(
    meshes: &[Mesh],
    csgs: &[Csg],
    options: AccelOptions,
) -> Result<Vec<Arc<MeshTree>>> {
    let mut is_operand = vec![false; meshes.len()];
    let mut must_be_closed = is_operand.clone();
    for operand in csgs.iter().flat_map(|csg| &csg.operands) {
        if let Operand::Mesh(id) | Operand::OpenMesh(id) = operand {
            is_operand[id.0 as usize] = true;
            must_be_closed[id.0 as usize] |= matches!(operand, Operand::Mesh(_));
        }
    }
    let tree = |(i, mesh): (usize, &Mesh)| {
        if must_be_closed[i]
            && let Some(openness) = mesh.openness()
        {
            return Err(openness.error(None, |_| None));
        }
        let tree = if is_operand[i] {
            MeshTree::build_operand(mesh, options)
        } else {
            MeshTree::build(mesh, options)
        };
        tree.map(Arc::new)
    };
    meshes.iter().enumerate().map(tree).collect()
}

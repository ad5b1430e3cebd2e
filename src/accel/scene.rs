mod batch;
mod packets;

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{DVec3, Vec2};

use crate::error::Result;
use crate::geometry::{Csg, CsgId, Mesh, MeshId, Shape, Solid};
use crate::math::{Bounds, Ray, Transform};

use super::boxes::BoxTree;
use super::csg::{CsgTree, ROUNDING, mesh_trees};
use super::mesh::{MeshReport, MeshTree};
use super::options::AccelOptions;
use super::triangle::TriangleHit;

/// A shape in its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// What.
    pub shape: Shape,
    /// Where.
    pub world_from_object: Transform,
}

/// The closest point in which a ray meets the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in units of the ray's direction.
    pub t: f64,
    /// Mesh: barycentric weights of the second and third corner; else 0.
    pub uv: Vec2,
    /// Index of the placed shape.
    pub instance: u32,
    /// Mesh: the triangle's index in its file. CSG: the operand's index in its tree. Else 0.
    pub primitive: u32,
    /// Solid, also as an operand: the face that was hit. Mesh as an operand: the triangle, or [`super::HOLE`]. Else 0.
    pub face: u32,
    /// Whether the ray came from inside.
    pub inside: bool,
    /// CSG: whether the operand is subtracted here, so that its surface faces into it.
    pub negated: bool,
}

/// Ray queries over placed shapes.
#[derive(Debug)]
pub struct Accel {
    meshes: Vec<Arc<MeshTree>>,
    csgs: Vec<CsgTree>,
    placed: Vec<Placed>,
    /// How each one's space and rays are to those of the world.
    spaces: Vec<Space>,
    /// Over the shapes with bounds, `order` mapping its leaf positions to them; `None` where there are none.
    tree: Option<(BoxTree, Vec<u32>)>,
    /// Those that every ray is tested with: planes, CSG objects that half-spaces leave open, and all of few shapes.
    always: Vec<u32>,
    /// The mesh that is all there is and stands where it was made, and whose: most programs ask about one.
    lone: Option<(Arc<MeshTree>, u32)>,
    bounds: Bounds,
}

/// How a placed shape's space is to the world's.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Space {
    /// It is another one.
    Own,
    /// It is the same.
    World,
    /// It is the same, and rays made ready for the tree of all are so for the mesh's.
    Shared,
}

impl Accel {
    /// Builds a tree for each of `meshes` and `csgs` and one over `placed`, which refers to them by index.
    ///
    /// # Errors
    /// Where a mesh is invalid or has no triangle with an area, or a CSG tree is not whole.
    pub fn build(meshes: &[Mesh], csgs: &[Csg], placed: Vec<Placed>) -> Result<Self> {
        Self::build_with(meshes, csgs, placed, AccelOptions::default())
    }

    /// [`Accel::build`] in a way of one's own.
    ///
    /// # Errors
    /// As [`Accel::build`].
    pub fn build_with(
        meshes: &[Mesh],
        csgs: &[Csg],
        placed: Vec<Placed>,
        options: AccelOptions,
    ) -> Result<Self> {
        let meshes = mesh_trees(meshes, csgs, options)?;
        let csgs = (csgs.iter())
            .map(|csg| CsgTree::over(csg, &meshes, options))
            .collect::<Result<Vec<_>>>()?;
        let (mut bounded, mut boxes, mut always) = (Vec::new(), Vec::new(), Vec::new());
        for (i, p) in placed.iter().enumerate() {
            let bounds = p.bounds(&meshes, &csgs);
            if bounds.is_finite() {
                bounded.push(i as u32);
                boxes.push(bounds);
            } else if !bounds.is_empty() {
                always.push(i as u32);
            }
        }
        if boxes.len() <= FEW {
            always.append(&mut bounded);
            always.sort_unstable();
        }
        let bounds = (boxes.iter().copied()).fold(Bounds::EMPTY, Bounds::union);
        let least = 0.5 * bounds.size().max_element() / COARSER;
        let unmoved = |p: &Placed| match p.shape {
            _ if !p.world_from_object.is_identity() => None,
            Shape::Mesh(id) => {
                let mesh = &meshes[id.0 as usize];
                (f64::from(mesh.extent) >= least).then_some(mesh)
            }
            _ => None,
        };
        let largest = (placed.iter().filter_map(unmoved)).max_by_key(|m| m.report.triangles);
        let center = largest.map(|mesh| mesh.center);
        let tree = (!bounded.is_empty()).then(|| {
            let (tree, order) = BoxTree::build(&boxes, center, options);
            let order = order.into_iter().map(|i| bounded[i as usize]).collect();
            (tree, order)
        });
        let space = |p: &Placed| match unmoved(p) {
            _ if !p.world_from_object.is_identity() => Space::Own,
            Some(mesh) if Some(mesh.center) == center => Space::Shared,
            _ => Space::World,
        };
        let spaces: Vec<Space> = placed.iter().map(space).collect();
        let lone = match *always {
            [i] if tree.is_none() && spaces[i as usize] != Space::Own => {
                match placed[i as usize].shape {
                    Shape::Mesh(id) => Some((meshes[id.0 as usize].clone(), i)),
                    _ => None,
                }
            }
            _ => None,
        };
        Ok(Self {
            meshes,
            csgs,
            placed,
            spaces,
            tree,
            always,
            lone,
            bounds,
        })
    }

    /// The box around everything that has an end.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The box around `instance` in world space; without end for a plane.
    pub fn instance_bounds(&self, instance: u32) -> Bounds {
        self.placed[instance as usize].bounds(&self.meshes, &self.csgs)
    }

    /// Whether `instance` holds the point `p`, or has it on its surface to within rounding.
    pub fn contains(&self, instance: u32, p: DVec3) -> bool {
        let placed = &self.placed[instance as usize];
        let local = placed.world_from_object.inverse_point(p);
        match placed.shape {
            Shape::Mesh(id) => self.meshes[id.0 as usize].winding(local) > 0,
            Shape::Solid(solid) => solid.contains(local),
            Shape::Csg(id) => self.csg(id).contains(local),
        }
    }

    /// What building each mesh found.
    pub fn mesh_reports(&self) -> impl Iterator<Item = MeshReport> + '_ {
        self.meshes.iter().map(|mesh| mesh.report)
    }

    /// A CSG object.
    pub fn csg(&self, id: CsgId) -> &CsgTree {
        &self.csgs[id.0 as usize]
    }

    /// The triangles of a mesh that its tree left out, ascending.
    pub fn dropped(&self, mesh: MeshId) -> &[u32] {
        &self.meshes[mesh.0 as usize].dropped
    }

    /// How far, in world units, a ray must start off the surface that was hit, at the object-space point `p` with
    /// the unit normal `n`, so as not to meet it again.
    pub fn error_at(&self, hit: &Hit, p: DVec3, n: DVec3) -> f64 {
        let Placed {
            shape,
            world_from_object,
        } = &self.placed[hit.instance as usize];
        let Shape::Csg(id) = shape else {
            return self.error(hit.instance, p);
        };
        let uncertain = self.csg(*id).uncertainty(hit.primitive, hit.face, p, n);
        let position = world_from_object.point(p).abs().max_element();
        MARGIN * (uncertain * world_from_object.max_stretch() + ROUNDING * position)
    }

    /// How far, in world units, a ray must start off the surface of `instance`, a mesh or a solid, near the
    /// object-space point `p` so as not to meet it again: queries decide in f64, and this is well above its rounding.
    pub fn error(&self, instance: u32, p: DVec3) -> f64 {
        let Placed {
            shape,
            world_from_object,
        } = &self.placed[instance as usize];
        let size = match shape {
            Shape::Mesh(id) => self.meshes[id.0 as usize].bounds.size().max_element(),
            Shape::Solid(Solid::Plane) | Shape::Csg(_) => 0.0,
            Shape::Solid(solid) => solid.bounds().size().max_element(),
        };
        let local = size + p.abs().max_element();
        let position = world_from_object.point(p).abs().max_element();
        ERROR * (local * world_from_object.max_stretch() + position)
    }

    /// The closest hit with `tmin < t < tmax`; of equal `t` the lowest instance, then primitive.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        if let Some((mesh, instance)) = &self.lone {
            let (hit, primitive) = mesh.intersect(ray, ray.tmax)?;
            return Some(Hit::of_triangle(&hit, primitive, *instance));
        }
        self.intersect_all(ray)
    }

    #[inline(never)]
    fn intersect_all(&self, ray: &Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut limit = ray.tmax;
        let mut offer = |hit: Hit, limit: &mut f64| {
            let tie = best.is_some_and(|b| hit.t == b.t && hit.instance < b.instance);
            if hit.t < *limit || tie {
                *limit = hit.t;
                best = Some(hit);
            }
        };
        for &instance in &self.always {
            if let Some(hit) = self.intersect_one(instance, ray, limit) {
                offer(hit, &mut limit);
            }
        }
        if let Some((tree, order)) = &self.tree {
            let _ = tree.traverse(ray, limit, |leaf| {
                let instance = order[leaf as usize];
                if let Some(hit) = self.intersect_one(instance, ray, limit.next_up()) {
                    offer(hit, &mut limit);
                }
                ControlFlow::Continue(limit)
            });
        }
        best
    }

    /// Whether anything lies in `tmin < t < tmax`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        if let Some((mesh, _)) = &self.lone {
            return mesh.occluded(ray);
        }
        self.occluded_by_any(ray)
    }

    #[inline(never)]
    fn occluded_by_any(&self, ray: &Ray) -> bool {
        if (self.always.iter()).any(|&instance| self.occludes(instance, ray)) {
            return true;
        }
        let Some((tree, order)) = &self.tree else {
            return false;
        };
        tree.traverse(ray, ray.tmax, |leaf| {
            if self.occludes(order[leaf as usize], ray) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(ray.tmax)
            }
        })
        .is_break()
    }

    /// `ray` in the space of `instance`, where that is not the world's.
    #[inline]
    fn moved_ray(&self, instance: u32, ray: &Ray) -> Option<Ray> {
        let placed = &self.placed[instance as usize];
        (self.is_moved(instance)).then(|| placed.world_from_object.inverse_ray(ray))
    }

    /// Whether the transform of `instance` changes anything.
    #[inline]
    fn is_moved(&self, instance: u32) -> bool {
        self.spaces[instance as usize] == Space::Own
    }

    /// Whether it is clear at once that `ray` does not meet `instance`: it may be the wall that it leaves, whose box is
    /// too close for f32 to tell.
    #[inline(always)]
    fn is_behind(&self, instance: u32, ray: &Ray) -> bool {
        let placed = &self.placed[instance as usize];
        let Shape::Solid(solid) = placed.shape else {
            return false;
        };
        let moved = self.moved_ray(instance, ray);
        solid.is_behind(moved.as_ref().unwrap_or(ray))
    }

    #[inline(always)]
    fn intersect_one(&self, instance: u32, ray: &Ray, tmax: f64) -> Option<Hit> {
        let placed = &self.placed[instance as usize];
        let moved = self.moved_ray(instance, ray);
        let local = moved.as_ref().unwrap_or(ray);
        let ending = || Ray { tmax, ..*local };
        match placed.shape {
            Shape::Mesh(id) => {
                let (hit, primitive) = self.meshes[id.0 as usize].intersect(local, tmax)?;
                Some(Hit::of_triangle(&hit, primitive, instance))
            }
            Shape::Solid(solid) => {
                let (crossing, inside) = solid.closest(&ending())?;
                Some(Hit {
                    t: crossing.t,
                    uv: Vec2::ZERO,
                    instance,
                    primitive: 0,
                    face: crossing.face,
                    inside,
                    negated: false,
                })
            }
            Shape::Csg(id) => {
                let tree = self.csg(id);
                let crossing = tree.intersect(&ending())?;
                Some(Hit {
                    t: crossing.t,
                    uv: tree.weights(local, &crossing),
                    instance,
                    primitive: crossing.operand,
                    face: crossing.face,
                    inside: !crossing.enter,
                    negated: crossing.negated,
                })
            }
        }
    }

    #[inline(always)]
    fn occludes(&self, instance: u32, ray: &Ray) -> bool {
        let placed = &self.placed[instance as usize];
        let moved = self.moved_ray(instance, ray);
        let local = moved.as_ref().unwrap_or(ray);
        match placed.shape {
            Shape::Mesh(id) => self.meshes[id.0 as usize].occluded(local),
            Shape::Solid(solid) => solid.closest(local).is_some(),
            Shape::Csg(id) => self.csg(id).occluded(local),
        }
    }
}

impl Hit {
    fn of_triangle(hit: &TriangleHit, primitive: u32, instance: u32) -> Self {
        Self {
            t: hit.t,
            uv: Vec2::new(hit.u as f32, hit.v as f32),
            instance,
            primitive,
            face: 0,
            inside: hit.inside,
            negated: false,
        }
    }
}

impl Placed {
    /// The box around it in world space.
    fn bounds(&self, meshes: &[Arc<MeshTree>], csgs: &[CsgTree]) -> Bounds {
        let bounds = match self.shape {
            Shape::Mesh(id) => meshes[id.0 as usize].bounds,
            Shape::Solid(solid) => solid.bounds(),
            Shape::Csg(id) => csgs[id.0 as usize].bounds(),
        };
        if bounds.is_finite() {
            padded(&self.world_from_object.bounds(&bounds))
        } else {
            bounds
        }
    }
}

/// A mesh shares rays with the tree of all where that is at most so many times as large: they are made ready for the
/// rounding that the larger one brings.
const COARSER: f64 = 16.0;

/// So many shapes need no tree of boxes.
const FEW: usize = 4;

/// How many times its uncertainty a CSG surface is left behind.
const MARGIN: f64 = 32.0;

/// Far above the relative rounding of a few f64 operations, far below what can be seen.
const ERROR: f64 = 1.0 / (1_u64 << 40) as f64;

/// Grown by what transforming to f32 object space and back may lose.
fn padded(bounds: &Bounds) -> Bounds {
    let reach = bounds.size().max_element() * 2.0_f64.powi(-20);
    Bounds {
        min: bounds.min - reach,
        max: bounds.max + reach,
    }
}

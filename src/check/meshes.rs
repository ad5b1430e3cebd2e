use glam::{DVec3, Vec3};

use crate::geometry::{Mesh, Shape};
use crate::math::Transform;
use crate::scene::Scene;

/// A scene's meshes in their places, without the shapes that Embree does not know.
#[derive(Debug)]
pub struct Meshes<'a> {
    scene: &'a Scene,
    placed: Vec<Placement>,
}

#[derive(Debug)]
struct Placement {
    mesh: usize,
    transform: Transform,
    /// How many times the rounding of a point grows on the way to the object and back.
    condition: f64,
    /// The number of triangles of those before it.
    first: u64,
}

/// A triangle of a placed mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spot {
    /// Index among the placed meshes.
    pub instance: u32,
    /// Index in its mesh.
    pub primitive: u32,
}

impl<'a> Meshes<'a> {
    /// Those of `scene`.
    pub fn of(scene: &'a Scene) -> Self {
        let mut placed = Vec::new();
        let mut first = 0;
        for instance in &scene.instances {
            if let Shape::Mesh(id) = instance.shape {
                let mesh = id.0 as usize;
                let transform = instance.world_from_object;
                placed.push(Placement {
                    mesh,
                    transform,
                    condition: condition(&transform),
                    first,
                });
                first += scene.meshes[mesh].triangles.len() as u64;
            }
        }
        Self { scene, placed }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.placed.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.placed.is_empty()
    }

    /// How many objects of the scene are something else.
    pub fn left_out(&self) -> usize {
        self.scene.instances.len() - self.len()
    }

    /// Each with its place, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&'a Mesh, &Transform)> {
        (self.placed.iter()).map(|place| (&self.scene.meshes[place.mesh], &place.transform))
    }

    /// All triangles, each instance's counted.
    pub fn triangles(&self) -> u64 {
        let last = self.placed.last();
        last.map_or(0, |place| {
            place.first + self.scene.meshes[place.mesh].triangles.len() as u64
        })
    }

    /// Triangle `n` of all.
    pub(super) fn spot(&self, n: u64) -> Spot {
        let instance = self.placed.partition_point(|place| place.first <= n) - 1;
        Spot {
            instance: instance as u32,
            primitive: (n - self.placed[instance].first) as u32,
        }
    }

    /// The mesh that an instance places: its index in the scene, and its place.
    pub(super) fn placed(&self, instance: u32) -> (usize, &Transform) {
        let place = &self.placed[instance as usize];
        (place.mesh, &place.transform)
    }

    /// The scene's meshes.
    pub(super) fn meshes(&self) -> &'a [Mesh] {
        &self.scene.meshes
    }

    pub(super) fn condition(&self, instance: u32) -> f64 {
        self.placed[instance as usize].condition
    }

    /// Corners in object space, exact.
    pub(super) fn object_corners(&self, spot: Spot) -> [DVec3; 3] {
        let mesh = self.placed[spot.instance as usize].mesh;
        (self.scene.meshes[mesh].corners(spot.primitive)).map(Vec3::as_dvec3)
    }

    /// Corners in world space.
    pub(super) fn corners(&self, spot: Spot) -> [DVec3; 3] {
        let transform = &self.placed[spot.instance as usize].transform;
        let corners = self.object_corners(spot);
        if transform.is_identity() {
            corners
        } else {
            corners.map(|p| transform.point(p))
        }
    }
}

/// The condition number in the Frobenius norm, 1 for a turn.
fn condition(transform: &Transform) -> f64 {
    let m = transform.inverse_matrix().matrix3;
    let shrink = m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared();
    transform.max_stretch() * shrink.sqrt() / 3.0
}

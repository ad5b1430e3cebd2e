//! Which surfaces are lights to aim at: spheres, and the triangles of meshes.

use glam::{DVec3, Vec3};

use crate::accel::{Accel, Hit};
use crate::color::Rgb;
use crate::geometry::{Shape, Solid};
use crate::light::{Light, SphereLight, TriangleLight};
use crate::scene::Scene;

/// Which of the sampler's lights are the surfaces of one instance.
#[derive(Clone, Debug)]
pub(super) enum Emitters {
    None,
    /// The whole shape is one light.
    One(u32),
    /// For each triangle of a mesh its light, or `u32::MAX`.
    Triangles(Vec<u32>),
}

impl Emitters {
    /// The light that was hit.
    pub(super) fn light(&self, hit: &Hit) -> Option<u32> {
        let light = match self {
            Self::None => u32::MAX,
            Self::One(light) => *light,
            Self::Triangles(lights) => lights[hit.primitive as usize],
        };
        (light != u32::MAX).then_some(light)
    }

    /// Adds the lights that the surfaces of instance `index` are.
    pub(super) fn find(
        scene: &Scene,
        accel: &Accel,
        index: usize,
        lights: &mut Vec<Light>,
    ) -> Self {
        let instance = &scene.instances[index];
        let emission = |slot: u32| {
            let material = &scene.materials[instance.material(slot).0 as usize];
            match material.emission_texture {
                None => material.emission,
                // Samples of lights know nothing of textures.
                Some(_) => Rgb::ZERO,
            }
        };
        let transform = &instance.world_from_object;
        match instance.shape {
            Shape::Solid(Solid::Sphere { radius }) if emission(0) != Rgb::ZERO => {
                // A sphere that a transform squashes is no sphere: rays find it, nothing aims at it.
                let Some(scale) = transform.uniform_scale() else {
                    return Emitters::None;
                };
                lights.push(Light::Sphere(SphereLight {
                    center: transform.point(DVec3::ZERO),
                    radius: radius * scale,
                    radiance: emission(0),
                    error: accel.error(index as u32, DVec3::X * radius),
                }));
                Emitters::One(lights.len() as u32 - 1)
            }
            Shape::Mesh(id) => {
                let mesh = &scene.meshes[id.0 as usize];
                let dropped = accel.dropped(id);
                let mut found = false;
                let of_triangle = (0..mesh.triangles.len() as u32)
                    .map(|i| {
                        let radiance = emission(mesh.slot(i));
                        // Rays never report a triangle that the tree left out.
                        if radiance == Rgb::ZERO || dropped.binary_search(&i).is_ok() {
                            return u32::MAX;
                        }
                        found = true;
                        let [a, b, c] = mesh.corners(i).map(Vec3::as_dvec3);
                        let corner = transform.point(a);
                        lights.push(Light::Triangle(TriangleLight {
                            corner,
                            edges: [transform.point(b) - corner, transform.point(c) - corner],
                            radiance,
                            error: accel.error(index as u32, a),
                        }));
                        lights.len() as u32 - 1
                    })
                    .collect();
                if found {
                    Emitters::Triangles(of_triangle)
                } else {
                    Emitters::None
                }
            }
            Shape::Solid(_) | Shape::Csg(_) => Emitters::None,
        }
    }
}

//! Which surfaces are lights to aim at: all that have an end, but for those of CSG objects.

use glam::{DVec3, Vec2, Vec3};

use crate::accel::Hit;
use crate::color::Rgb;
use crate::geometry::{Mesh, MeshId, Shape, Solid};
use crate::light::{
    BoxLight, Light, LightSample, LightSampler, Quad, QuadLight, RoundLight, Source, SphereLight,
    SurfaceLight, TriangleLight,
};
use crate::material::{Material, MaterialId};
use crate::scene::Instance;

use super::World;

/// How lights and surfaces belong together.
#[derive(Clone, Debug, Default)]
pub(super) struct Emitters {
    /// How many lights come before those that are surfaces.
    first: usize,
    /// Where the others are, if their emission varies.
    places: Vec<Option<Place>>,
    /// For each instance which lights its surfaces are.
    surfaces: Vec<Surfaces>,
}

/// A surface that emits.
#[derive(Clone, Copy, Debug)]
struct Place {
    instance: u32,
    /// Mesh: the triangle, or one of the two that are one light.
    triangle: u32,
}

impl Place {
    fn of_solid(instance: u32) -> Self {
        Self {
            instance,
            triangle: 0,
        }
    }
}

/// Which of the sampler's lights the surfaces of one instance are.
#[derive(Clone, Debug)]
enum Surfaces {
    None,
    /// The whole shape is one light.
    One(u32),
    /// For each triangle of a mesh its light, or `NO_LIGHT`.
    Triangles(Vec<u32>),
}

const NO_LIGHT: u32 = u32::MAX;

impl World {
    /// Draws a point of one of the lights as seen from `from`; see [`LightSampler::sample`].
    #[inline(always)]
    pub fn sample_light(&self, from: DVec3, u: f32, u2: Vec2) -> Option<LightSample> {
        let (light, mut sample) = self.lights.sample(from, u, u2)?;
        if let Some(i) = (light as usize).checked_sub(self.emitters.first)
            && let Some(place) = self.emitters.places[i]
        {
            let (instance, material) = self.emitter(place);
            if let Source::Point(p) = sample.source {
                let point = self.texture_point(instance, place.triangle, sample.face, p);
                sample.li = material.emitted(&point);
            }
        }
        Some(sample)
    }

    /// Density per solid angle with which light sampling at `from` draws the point `p` that was hit; 0
    /// where the surface is not among the lights.
    pub fn light_pdf(&self, from: DVec3, hit: &Hit, p: DVec3) -> f32 {
        let light = match &self.emitters.surfaces[hit.instance as usize] {
            Surfaces::None => NO_LIGHT,
            Surfaces::One(light) => *light,
            Surfaces::Triangles(lights) => lights[hit.primitive as usize],
        };
        if light == NO_LIGHT {
            return 0.0;
        }
        self.lights.pdf(light, from, p, hit.face)
    }

    fn emitter(&self, place: Place) -> (&Instance, &Material) {
        let instance = &self.scene.instances[place.instance as usize];
        let slot = match instance.shape {
            Shape::Mesh(id) => self.scene.meshes[id.0 as usize].slot(place.triangle),
            Shape::Solid(_) | Shape::Csg(_) => 0,
        };
        let material = instance.material(slot);
        (instance, &self.scene.materials[material.0 as usize])
    }

    /// Lists the lights: those of the scene, then its surfaces.
    pub(super) fn find_lights(&mut self) {
        let mut lights = self.scene.lights.clone();
        let mut emitters = Emitters {
            first: lights.len(),
            ..Emitters::default()
        };
        for instance in 0..self.scene.instances.len() as u32 {
            let mut add = |place, light| {
                let Some(light) = self.with_mean_radiance(place, light) else {
                    return NO_LIGHT;
                };
                let varies = self.emitter(place).1.emission_texture.is_some();
                emitters.places.push(varies.then_some(place));
                lights.push(Light::Surface(light));
                lights.len() as u32 - 1
            };
            let surfaces = match self.scene.instances[instance as usize].shape {
                Shape::Solid(solid) => {
                    let place = Place::of_solid(instance);
                    let light = self.solid_light(place, solid);
                    light.map_or(Surfaces::None, |light| Surfaces::One(add(place, light)))
                }
                Shape::Mesh(id) => self.mesh_lights(instance, id, add),
                Shape::Csg(_) => Surfaces::None,
            };
            emitters.surfaces.push(surfaces);
        }
        self.emitters = emitters;
        self.lights = LightSampler::new(lights);
    }

    /// A light with the mean of what its texture lets it emit; `None` where that is nothing, as far as can be seen.
    fn with_mean_radiance(&self, place: Place, mut light: SurfaceLight) -> Option<SurfaceLight> {
        let (instance, material) = self.emitter(place);
        if material.emission_texture.is_some() {
            let grid = match light {
                SurfaceLight::Triangle(_) => 4,
                _ => 32,
            };
            let emitted = |i: u32| {
                let cell = Vec2::new((i % grid) as f32, (i / grid) as f32);
                let (p, face) = light.point((cell + 0.5) / grid as f32);
                material.emitted(&self.texture_point(instance, place.triangle, face, p))
            };
            let sum: Rgb = (0..grid * grid).map(emitted).sum();
            *light.radiance_mut() = sum / (grid * grid) as f32;
        }
        (*light.radiance_mut() != Rgb::ZERO).then_some(light)
    }

    /// The light that a solid is.
    fn solid_light(&self, place: Place, solid: Solid) -> Option<SurfaceLight> {
        let (instance, material) = self.emitter(place);
        let transform = &instance.world_from_object;
        let bounds = solid.bounds();
        if material.emission == Rgb::ZERO || !bounds.is_finite() {
            return None;
        }
        let radiance = material.emission;
        let error = self.accel.error(place.instance, bounds.max);
        Some(match (solid, transform.uniform_scale()) {
            (Solid::Sphere { radius }, Some(scale)) => SurfaceLight::Sphere(SphereLight {
                center: transform.point(DVec3::ZERO),
                radius: radius * scale,
                radiance,
                error,
            }),
            (Solid::Rectangle { half }, _) => {
                let edges = [DVec3::X * half.x, DVec3::Y * half.y];
                let quad = Quad::new(
                    transform.point(DVec3::ZERO),
                    edges.map(|edge| transform.vector(2.0 * edge)),
                );
                SurfaceLight::Quad(QuadLight::new(quad, radiance, error))
            }
            (Solid::Box { half }, _) => SurfaceLight::Box(Box::new(BoxLight {
                center: transform.point(DVec3::ZERO),
                axes: DVec3::AXES.map(|axis| transform.vector(half * axis)),
                radiance,
                error,
            })),
            _ => SurfaceLight::Round(Box::new(RoundLight {
                solid,
                world_from_object: *transform,
                radiance,
                error,
            })),
        })
    }

    /// The lights that a mesh's triangles are: each one, or two together that are a rectangle.
    fn mesh_lights(
        &self,
        instance: u32,
        id: MeshId,
        mut add: impl FnMut(Place, SurfaceLight) -> u32,
    ) -> Surfaces {
        let owner = &self.scene.instances[instance as usize];
        let emits = |id: &MaterialId| self.scene.materials[id.0 as usize].emission != Rgb::ZERO;
        if !owner.materials.iter().any(emits) {
            return Surfaces::None;
        }
        let mesh = &self.scene.meshes[id.0 as usize];
        let dropped = self.accel.dropped(id);
        let mut lights = vec![NO_LIGHT; mesh.triangles.len()];
        let transform = &owner.world_from_object;
        for triangle in 0..mesh.triangles.len() as u32 {
            let place = Place { instance, triangle };
            let (_, material) = self.emitter(place);
            let radiance = material.emission;
            // Rays never report a triangle that the tree left out.
            let is_light = |i: u32| dropped.binary_search(&i).is_err();
            let known = lights[triangle as usize] != NO_LIGHT;
            if radiance == Rgb::ZERO || known || !is_light(triangle) {
                continue;
            }
            let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
            let error = self.accel.error(instance, a);
            let next = Some(triangle + 1)
                .filter(|&i| (i as usize) < lights.len() && is_light(i))
                .filter(|&i| mesh.slot(i) == mesh.slot(triangle));
            let pair = next.and_then(|next| {
                let [middle, x, y, off] =
                    rectangle(mesh, triangle, next, material.emission_texture.is_some())?;
                let edges = [x, y].map(|edge| transform.vector(edge));
                let quad = Quad::new(transform.point(middle), edges);
                // What f32 made of a plane is none to the last digit.
                let error = error + transform.vector(off).length();
                quad.is_rectangle().then_some((next, quad, error))
            });
            if let Some((next, quad, error)) = pair {
                let light = QuadLight::new(quad, radiance, error);
                let light = add(place, SurfaceLight::Quad(light));
                lights[triangle as usize] = light;
                lights[next as usize] = light;
            } else {
                let corners = [a, b, c].map(|p| transform.point(p));
                let light = TriangleLight::new(corners, radiance, error);
                lights[triangle as usize] = add(place, SurfaceLight::Triangle(light));
            }
        }
        if lights.iter().all(|&light| light == NO_LIGHT) {
            return Surfaces::None;
        }
        Surfaces::Triangles(lights)
    }
}

/// The middle of the parallelogram that two triangles of a mesh are, its edges, and how far the fourth corner is from where
/// it should be, to within what f32 may do; `None` where they are none, or surface coordinates, which must go on
/// `straight`, do not.
fn rectangle(mesh: &Mesh, first: u32, second: u32, straight: bool) -> Option<[DVec3; 4]> {
    let corners = |triangle: u32| {
        let uvs = mesh.uv_corners(triangle);
        let corners = mesh.corners(triangle);
        [0, 1, 2].map(|i| (corners[i], if straight { uvs[i] } else { Vec2::ZERO }))
    };
    let (a, b) = (corners(first), corners(second));
    // Each begun at a corner so that the other two are the same.
    let turned = |t: [_; 3], i: usize| [t[i], t[(i + 1) % 3], t[(i + 2) % 3]];
    let mut pairs = (0..9).map(|i| (turned(a, i / 3), turned(b, i % 3)));
    let ([p, x, y], [q, ..]) =
        pairs.find(|(a, b)| a[1..] == b[1..] || (a[1] == b[2] && a[2] == b[1]))?;
    let bend = x.1 + y.1 - p.1 - q.1;
    let [p, q, x, y] = [p, q, x, y].map(|corner| corner.0.as_dvec3());
    let (x, y) = (x - p, y - p);
    let off = p + x + y - q;
    let flat = off.length() <= 1e-6 * (x.length() + y.length());
    (flat && bend.abs().max_element() <= 1e-5).then(|| [p + 0.5 * (x + y), x, y, off])
}

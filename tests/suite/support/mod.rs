//! Scenes made in code, and renders of them, for the tests.

pub mod brute;
#[cfg(feature = "embree")]
pub mod comparison;
pub mod leaks;
pub mod meshes;

use glam::{DAffine3, DVec3};
use solidtrace::camera::{Camera, Projection};
use solidtrace::color::{Rgb, Tonemap};
use solidtrace::film::{Filter, PixelSum};
use solidtrace::geometry::{Csg, CsgId, Mesh, MeshId, Shape, Solid};
use solidtrace::integrator::{Integrator, integrator};
use solidtrace::light::{Light, PointLight};
use solidtrace::material::{Fresnel, Material, MaterialId, Surface};
use solidtrace::math::Transform;
use solidtrace::render::{RenderSettings, render};
use solidtrace::sampling::SamplerKind;
use solidtrace::scene::{FilmSettings, Instance, IntegratorSettings, Scene};
use solidtrace::texture::Texture;
use solidtrace::world::World;

pub const SAMPLERS: [SamplerKind; 2] = [SamplerKind::Sobol, SamplerKind::Independent];

/// A scene without objects, seen by a camera at the origin that looks along -z.
pub fn empty_scene() -> Scene {
    Scene {
        film: FilmSettings {
            size: (8, 8),
            spp: 16,
            filter: Filter::Box { radius: 0.5 },
            tonemap: Tonemap::Srgb,
        },
        integrator: IntegratorSettings::Path {
            max_depth: None,
            russian_roulette: false,
        },
        cameras: vec![camera(DVec3::ZERO, DVec3::NEG_Z)],
        environment: Rgb::ZERO,
        lights: Vec::new(),
        materials: Vec::new(),
        meshes: Vec::new(),
        csgs: Vec::new(),
        instances: Vec::new(),
        warnings: Vec::new(),
    }
}

pub fn camera(eye: DVec3, look_at: DVec3) -> Camera {
    let straight_up = (look_at - eye).cross(DVec3::Y) == DVec3::ZERO;
    Camera {
        name: None,
        eye,
        look_at,
        up: if straight_up { DVec3::Z } else { DVec3::Y },
        projection: Projection::pinhole(40_f64.to_radians()),
        motion: None,
    }
}

pub fn diffuse(albedo: f32) -> Surface {
    Surface::Diffuse {
        color: Texture::Constant(Rgb::splat(albedo)),
    }
}

/// A smooth boundary of clear glass with the given reflectance.
pub fn dielectric(ior: f32, fresnel: Fresnel) -> Surface {
    Surface::Dielectric {
        ior,
        fresnel,
        roughness: 0.0.into(),
        absorption: Rgb::ZERO,
    }
}

/// Adding to a scene what a test needs.
pub trait Build {
    fn material(&mut self, surface: Surface, emission: f32) -> MaterialId;
    fn place(&mut self, shape: Shape, material: MaterialId, at: DAffine3) -> &mut Self;
    fn solid(&mut self, solid: Solid, material: MaterialId, at: DVec3) -> &mut Self;
    fn mesh(&mut self, mesh: Mesh, material: MaterialId) -> &mut Self;
    fn csg(&mut self, csg: Csg, materials: &[MaterialId], at: DAffine3) -> &mut Self;
    fn point_light(&mut self, position: DVec3, intensity: f32) -> &mut Self;
    fn world(self) -> World;
}

impl Build for Scene {
    fn material(&mut self, surface: Surface, emission: f32) -> MaterialId {
        self.materials.push(Material {
            name: format!("m{}", self.materials.len()),
            surface,
            emission: Rgb::splat(emission),
            ..Material::default()
        });
        MaterialId(self.materials.len() as u32 - 1)
    }

    fn place(&mut self, shape: Shape, material: MaterialId, at: DAffine3) -> &mut Self {
        self.instances.push(Instance {
            name: None,
            shape,
            materials: vec![material],
            world_from_object: Transform::new(at).unwrap(),
            smooth: true,
        });
        self
    }

    fn solid(&mut self, solid: Solid, material: MaterialId, at: DVec3) -> &mut Self {
        self.place(
            Shape::Solid(solid),
            material,
            DAffine3::from_translation(at),
        )
    }

    fn mesh(&mut self, mesh: Mesh, material: MaterialId) -> &mut Self {
        self.meshes.push(mesh);
        let id = MeshId(self.meshes.len() as u32 - 1);
        self.place(Shape::Mesh(id), material, DAffine3::IDENTITY)
    }

    fn csg(&mut self, csg: Csg, materials: &[MaterialId], at: DAffine3) -> &mut Self {
        self.csgs.push(csg);
        let id = CsgId(self.csgs.len() as u32 - 1);
        self.place(Shape::Csg(id), materials[0], at);
        let last = self.instances.last_mut().unwrap();
        last.materials = materials.to_vec();
        self
    }

    fn point_light(&mut self, position: DVec3, intensity: f32) -> &mut Self {
        self.lights.push(Light::Point(PointLight {
            position,
            intensity: Rgb::splat(intensity),
            cone: None,
        }));
        self
    }

    fn world(self) -> World {
        World::build(self).unwrap()
    }
}

/// How a test renders; fields differ from the scene's settings only where a test says so.
#[derive(Clone, Copy)]
pub struct Shot {
    pub spp: u32,
    pub sampler: SamplerKind,
    pub seed: u64,
}

/// The mean of each pixel, rendered by the scene's integrator with its first camera.
pub fn shoot(world: &World, shot: Shot) -> Vec<Rgb> {
    let integrator = integrator(&world.scene().integrator);
    shoot_with(world, integrator.as_ref(), shot)
}

pub fn shoot_with(world: &World, integrator: &dyn Integrator, shot: Shot) -> Vec<Rgb> {
    let scene = world.scene();
    let settings = RenderSettings {
        samples: 0..shot.spp,
        sampler: shot.sampler,
        seed: shot.seed,
        ..RenderSettings::of(scene)
    };
    let lens = scene.cameras[0].lens(scene.film.size).unwrap();
    let rendered = render(world, &lens, integrator, &settings, &()).unwrap();
    assert_eq!(
        rendered.bad,
        [],
        "no sample may be anything but a finite number"
    );
    rendered.film.pixels().iter().map(PixelSum::mean).collect()
}

/// Mean and standard deviation.
pub fn statistics(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, variance.sqrt())
}

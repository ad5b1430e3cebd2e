//! Scenes made in code, and renders of them, for the tests.

use glam::{DAffine3, DVec3, Vec3};
use solidtrace::camera::Camera;
use solidtrace::color::{Rgb, Tonemap};
use solidtrace::film::{Filter, Rect};
use solidtrace::geometry::{Mesh, MeshId, Shape, Solid};
use solidtrace::integrator::{Integrator, integrator};
use solidtrace::light::PointLight;
use solidtrace::material::{Material, MaterialId, Surface};
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
        vfov: 40_f64.to_radians(),
        aperture: 0.0,
        focus: None,
    }
}

pub fn diffuse(albedo: f32) -> Surface {
    Surface::Diffuse {
        color: Texture::Constant(Rgb::splat(albedo)),
    }
}

/// Adding to a scene what a test needs.
pub trait Build {
    fn material(&mut self, surface: Surface, emission: f32) -> MaterialId;
    fn place(&mut self, shape: Shape, material: MaterialId, at: DAffine3) -> &mut Self;
    fn solid(&mut self, solid: Solid, material: MaterialId, at: DVec3) -> &mut Self;
    fn mesh(&mut self, mesh: Mesh, material: MaterialId) -> &mut Self;
    fn point_light(&mut self, position: DVec3, intensity: f32) -> &mut Self;
    fn world(self) -> World;
}

impl Build for Scene {
    fn material(&mut self, surface: Surface, emission: f32) -> MaterialId {
        self.materials.push(Material {
            name: format!("m{}", self.materials.len()),
            surface,
            emission: Rgb::splat(emission),
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
        self.place(Shape::Solid(solid), material, DAffine3::from_translation(at))
    }

    fn mesh(&mut self, mesh: Mesh, material: MaterialId) -> &mut Self {
        self.meshes.push(mesh);
        let id = MeshId(self.meshes.len() as u32 - 1);
        self.place(Shape::Mesh(id), material, DAffine3::IDENTITY)
    }

    fn point_light(&mut self, position: DVec3, intensity: f32) -> &mut Self {
        self.lights.push(PointLight {
            position,
            intensity: Rgb::splat(intensity),
        });
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
        area: Rect::of_size(scene.film.size),
        samples: 0..shot.spp,
        filter: scene.film.filter,
        sampler: shot.sampler,
        seed: shot.seed,
        threads: 0,
        tile_size: 16,
    };
    let lens = scene.cameras[0].lens(scene.film.size).unwrap();
    let rendered = render(world, &lens, integrator, &settings, &()).unwrap();
    assert_eq!(rendered.bad, [], "no sample may be anything but a finite number");
    rendered.film.pixels().iter().map(|p| p.mean()).collect()
}

/// An axis-aligned box of twelve triangles, outward.
pub fn box_mesh(min: Vec3, max: Vec3) -> Mesh {
    let corner = |i: usize| {
        Vec3::new(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    let quads = [
        [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6],
    ];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles,
        ..Mesh::default()
    }
}

/// A sphere of `rings` by `2 rings` quads around the origin, each vertex moved along its direction by
/// `shape(direction)`; closed, outward, with smooth normals only if it is a true sphere.
pub fn sphere_mesh(rings: u32, shape: impl Fn(Vec3) -> f32) -> Mesh {
    let columns = 2 * rings;
    let mut positions = vec![Vec3::Y * shape(Vec3::Y)];
    for ring in 1..rings {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for column in 0..columns {
            let phi = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            let d = DVec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                -theta.sin() * phi.sin(),
            )
            .as_vec3();
            positions.push(d * shape(d));
        }
    }
    positions.push(Vec3::NEG_Y * shape(Vec3::NEG_Y));
    let last = positions.len() as u32 - 1;
    let at = |ring: u32, column: u32| 1 + (ring - 1) * columns + column % columns;
    let mut triangles = Vec::new();
    for column in 0..columns {
        triangles.push([0, at(1, column), at(1, column + 1)]);
        triangles.push([last, at(rings - 1, column + 1), at(rings - 1, column)]);
        for ring in 1..rings - 1 {
            let (a, b) = (at(ring, column), at(ring, column + 1));
            let (c, d) = (at(ring + 1, column), at(ring + 1, column + 1));
            triangles.push([a, c, d]);
            triangles.push([a, d, b]);
        }
    }
    Mesh {
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// Mean and standard deviation.
pub fn statistics(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, variance.sqrt())
}

use glam::{DVec3, Vec2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::camera::Lens;
use crate::color::Rgb;
use crate::film::Rect;
use crate::integrator::{CameraRay, PathIntegrator, Probe};
use crate::math::{Bounds, Ray};
use crate::sampling::{Sampler, SamplerKind, point_around, random_chord};
use crate::scene::{IntegratorSettings, Scene};
use crate::world::World;

use super::meshes::Meshes;

/// Ways to aim rays at a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayClass {
    /// From the scene's camera, spread evenly over the picture.
    Camera,
    /// As the path tracer shoots them after its first hit.
    Bounce,
    /// To the lights, as the path tracer shoots them, asked for any hit; its bounces where there is no light to aim at.
    Shadow,
    /// Between random points of the surrounding sphere.
    Chord,
    /// From the surrounding sphere at a vertex.
    Vertex,
    /// From the surrounding sphere at a point of an edge.
    Edge,
    /// Along an axis, through a vertex's coordinates.
    Axis,
}

impl RayClass {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Camera,
        Self::Bounce,
        Self::Shadow,
        Self::Chord,
        Self::Vertex,
        Self::Edge,
        Self::Axis,
    ];

    /// In lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Bounce => "bounce",
            Self::Shadow => "shadow",
            Self::Chord => "chord",
            Self::Vertex => "vertex",
            Self::Edge => "edge",
            Self::Axis => "axis",
        }
    }
}

/// A ray as each side is asked it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// For us.
    pub ray: Ray,
    /// For Embree: exact in f32. It differs from `ray` for the renderer's own rays alone, which are f64 and start right
    /// at a surface; this one counts hits only from where f32 can tell them from that surface.
    pub peer: Ray,
    /// Column and row of the picture, for rays of [`RayClass::Camera`].
    pub pixel: Option<(u32, u32)>,
}

/// Which part of a class.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunk {
    pub class: RayClass,
    /// The number of its first ray.
    pub first: u64,
    pub count: usize,
    /// Rays of the whole class.
    pub total: u64,
    pub seed: u64,
}

/// Makes rays for a scene.
pub(super) struct RayMaker<'a> {
    world: &'a World,
    meshes: &'a Meshes<'a>,
    lens: Lens,
    integrator: PathIntegrator,
    /// Of the meshes.
    bounds: Bounds,
}

/// Paths that the path tracer takes at once.
const PATHS: usize = 2048;

/// So many batches without a ray that was looked for, and there are none.
const PATIENCE: u32 = 8;

impl<'a> RayMaker<'a> {
    pub(super) fn new(
        world: &'a World,
        meshes: &'a Meshes<'a>,
        lens: Lens,
        bounds: Bounds,
    ) -> Self {
        Self {
            lens,
            integrator: integrator(world.scene()),
            bounds,
            world,
            meshes,
        }
    }

    /// A chunk's rays; fewer where the scene's paths have no more of this class.
    pub(super) fn queries(&self, chunk: &Chunk) -> Vec<Query> {
        let state = chunk.seed ^ (chunk.first << 8 | chunk.class as u64).rotate_left(20);
        let rng = &mut Pcg64Mcg::seed_from_u64(state);
        match chunk.class {
            RayClass::Camera => self.camera(chunk, rng),
            RayClass::Bounce | RayClass::Shadow => self.paths(chunk, rng),
            class => std::iter::repeat_with(|| self.aimed(class, rng))
                .filter(is_ray)
                .take(chunk.count)
                .map(exact)
                .collect(),
        }
    }

    /// Through a grid over the picture with about as many cells as there are rays, but at most one a pixel, over and
    /// over again.
    fn camera(&self, chunk: &Chunk, rng: &mut Pcg64Mcg) -> Vec<Query> {
        let (width, height) = self.world.scene().film.size;
        let part = (chunk.total as f64 / (f64::from(width) * f64::from(height))).sqrt();
        let cells = |side: u32| ((f64::from(side) * part).ceil() as u32).clamp(1, side);
        let (columns, rows) = (cells(width), cells(height));
        let first = chunk.first % (u64::from(columns) * u64::from(rows));
        let grid = Rect::of_size((columns, rows)).blocks().cycle();
        grid.skip(first as usize)
            .take(chunk.count)
            .map(|(column, row)| {
                let along = |cell: u32, cells: u32, side: u32, jitter: f64| {
                    (f64::from(cell) + jitter) / f64::from(cells) * f64::from(side)
                };
                let x = along(column, columns, width, rng.random());
                let y = along(row, rows, height, rng.random());
                let ray = self.lens.ray(x, y, Vec2::new(rng.random(), rng.random()));
                Query {
                    pixel: Some(((x as u32).min(width - 1), (y as u32).min(height - 1))),
                    ..exact(ray)
                }
            })
            .collect()
    }

    /// What the path tracer shoots for random samples of random pixels.
    fn paths(&self, chunk: &Chunk, rng: &mut Pcg64Mcg) -> Vec<Query> {
        let (width, height) = self.world.scene().film.size;
        let lights = !self.world.lights().lights().is_empty();
        let mut sieve = Sieve {
            shadows: chunk.class == RayClass::Shadow && lights,
            rays: Vec::new(),
        };
        let mut queries = Vec::with_capacity(chunk.count);
        let mut idle = 0;
        while queries.len() < chunk.count && idle < PATIENCE {
            let batch: Vec<CameraRay> = (0..PATHS)
                .map(|_| {
                    let pixel = (rng.random_range(0..width), rng.random_range(0..height));
                    let kind = SamplerKind::default();
                    let sampler = Sampler::new(kind, chunk.seed, pixel, rng.random());
                    let [u, v, lens_u, lens_v] = sampler.set(0);
                    let x = f64::from(pixel.0) + f64::from(u);
                    let y = f64::from(pixel.1) + f64::from(v);
                    let ray = self.lens.ray(x, y, Vec2::new(lens_u, lens_v));
                    CameraRay { ray, sampler }
                })
                .collect();
            let mut radiance = vec![Rgb::ZERO; batch.len()];
            (self.integrator).radiance_probed(self.world, &batch, &mut radiance, &mut sieve);
            idle = if sieve.rays.is_empty() { idle + 1 } else { 0 };
            let found = sieve.rays.drain(..).map(|ray| self.off_surface(ray));
            queries.extend(found.filter(|query| is_ray(&query.peer)));
        }
        queries.truncate(chunk.count);
        queries
    }

    fn off_surface(&self, ray: Ray) -> Query {
        let scale = ray.origin.abs().max_element() + self.radius();
        let clear = 2.0_f64.powi(-16) * scale / ray.direction.length();
        let peer = Ray {
            tmin: ray.tmin + clear,
            tmax: ray.tmax - clear,
            ..ray
        };
        Query {
            ray,
            peer: peer.rounded(),
            pixel: None,
        }
    }

    fn aimed(&self, class: RayClass, rng: &mut Pcg64Mcg) -> Ray {
        match class {
            RayClass::Vertex => {
                let vertex = self.corners(rng)[0];
                self.at(vertex, rng)
            }
            RayClass::Edge => {
                let [a, b, _] = self.corners(rng);
                self.at(a.lerp(b, rng.random()), rng)
            }
            RayClass::Axis => {
                let mut origin = self.corners(rng)[0];
                let axis = rng.random_range(0..3);
                let sign = if rng.random() { 1.0 } else { -1.0 };
                origin[axis] = self.bounds.center()[axis] - sign * 1.5 * self.radius();
                Ray::new(origin, sign * DVec3::AXES[axis])
            }
            _ => random_chord(&self.bounds, rng),
        }
    }

    /// From the surrounding sphere at a point, which the rounding of the origin does not move.
    fn at(&self, point: DVec3, rng: &mut Pcg64Mcg) -> Ray {
        let origin = point_around(&self.bounds, 2.0, rng).as_vec3().as_dvec3();
        Ray::new(origin, point - origin)
    }

    fn radius(&self) -> f64 {
        0.5 * self.bounds.size().length()
    }

    fn corners(&self, rng: &mut Pcg64Mcg) -> [DVec3; 3] {
        let n = rng.random_range(0..self.meshes.triangles());
        self.meshes.corners(self.meshes.spot(n))
    }
}

/// Keeps one kind of rays.
struct Sieve {
    shadows: bool,
    rays: Vec<Ray>,
}

impl Probe for Sieve {
    fn closest(&mut self, depth: u32, rays: &[Ray]) {
        if depth > 0 && !self.shadows {
            self.rays.extend_from_slice(rays);
        }
    }

    fn shadow(&mut self, rays: &[Ray]) {
        if self.shadows {
            self.rays.extend_from_slice(rays);
        }
    }
}

/// The scene's path tracer, or as it is where nothing else is said.
fn integrator(scene: &Scene) -> PathIntegrator {
    match scene.integrator {
        IntegratorSettings::Path {
            max_depth,
            russian_roulette,
        } => PathIntegrator {
            max_depth,
            russian_roulette,
        },
        _ => PathIntegrator {
            max_depth: Some(8),
            russian_roulette: true,
        },
    }
}

/// One ray for both sides.
fn exact(ray: Ray) -> Query {
    let ray = ray.rounded();
    Query {
        ray,
        peer: ray,
        pixel: None,
    }
}

/// Two points that round to the same one make no ray.
fn is_ray(ray: &Ray) -> bool {
    let ray = ray.rounded();
    let finite = ray.origin.is_finite() && ray.direction.is_finite();
    finite && ray.direction != DVec3::ZERO && ray.tmin < ray.tmax
}

use glam::{DVec3, Vec2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::accel::Accel;
use crate::error::{Error, Result};
use crate::math::{Frame, Ray};
use crate::sampling::{cosine_hemisphere, uniform_sphere};

use super::Subject;

/// Ways to ask. All directions are of unit length, so that engines which normalise them are asked the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// Closest hit from one point through a picture, in tiles.
    Camera,
    /// Closest hit from the camera rays' hits, in the directions of diffuse reflection.
    Bounce,
    /// Any hit from the camera rays' hits to random points of a square light above.
    Shadow,
    /// Closest hit between random points of the surrounding sphere.
    Chords,
    /// Any hit of the bounces within a quarter of the scene's diagonal.
    Occlusion,
}

impl RayKind {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Camera,
        Self::Bounce,
        Self::Shadow,
        Self::Chords,
        Self::Occlusion,
    ];

    /// In lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Bounce => "bounce",
            Self::Shadow => "shadow",
            Self::Chords => "chords",
            Self::Occlusion => "occlusion",
        }
    }

    /// Whether any hit will do.
    pub fn any_hit(self) -> bool {
        matches!(self, Self::Shadow | Self::Occlusion)
    }
}

/// Camera rays come in squares of so many pixels a side, as the renderer makes them.
const TILE: u32 = 8;

/// Sets of rays are cut to a multiple of this, so that packets are full.
const PACKET: usize = 16;

/// The rays of one race: every number in them is an f32, so that no engine is asked anything else.
pub struct RaySets([Vec<Ray>; RayKind::ALL.len()]);

impl RaySets {
    /// As many camera rays and chords as a picture of `size` has pixels, and of the others one for each camera ray
    /// that hits.
    ///
    /// # Errors
    /// Where hardly any camera ray meets a triangle, or the camera is not valid.
    pub fn new(subject: &Subject, accel: &Accel, size: (u32, u32)) -> Result<Self> {
        let mut rng = Pcg64Mcg::seed_from_u64(0);
        let lens = subject.camera.lens(size)?;
        let bounds = subject.bounds();
        let (center, radius) = (bounds.center(), 0.5 * bounds.size().length());
        let on_film = |(x, y)| lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, Vec2::splat(0.5));
        let camera: Vec<Ray> = (pixels(size).map(on_film))
            .map(|ray| exact(ray.origin, ray.direction, f64::INFINITY))
            .collect();
        let mut around = || center + 1.1 * radius * on_sphere(&mut rng);
        let chord = |_: &Ray| {
            let (a, b) = (around(), around());
            exact(a, b - a, f64::INFINITY)
        };
        let chords = camera.iter().map(chord).collect();
        let (mut bounce, mut shadow, mut occlusion) = (Vec::new(), Vec::new(), Vec::new());
        for ray in &camera {
            let Some(hit) = accel.intersect(ray) else {
                continue;
            };
            let [a, b, c] = subject.corners(hit.instance, hit.primitive);
            let Some(n) = (b - a).cross(c - a).try_normalize() else {
                continue;
            };
            let n = if n.dot(ray.direction) > 0.0 { -n } else { n };
            // Far enough off the surface for engines that compute in f32.
            let p = ray.at(hit.t) + 1e-4 * radius * n;
            let local = cosine_hemisphere(Vec2::new(rng.random(), rng.random()));
            let out = Frame::around(n.as_vec3()).to_world(local).as_dvec3();
            bounce.push(exact(p, out, f64::INFINITY));
            occlusion.push(exact(p, out, 0.5 * radius));
            let mut across = || rng.random_range(-0.5..0.5);
            let light = center + radius * DVec3::new(across(), 2.0, across());
            shadow.push(exact(p, light - p, 0.999 * p.distance(light)));
        }
        if bounce.len() < PACKET {
            return Err(Error::input(format!(
                "of {} camera rays only {} meet a mesh",
                camera.len(),
                bounce.len()
            ))
            .help("the scene's first camera must look at its meshes; see --size also"));
        }
        // In the order of `RayKind`.
        let mut sets = [camera, bounce, shadow, chords, occlusion];
        for rays in &mut sets {
            rays.truncate(rays.len() / PACKET * PACKET);
        }
        Ok(Self(sets))
    }

    /// The rays of a kind.
    pub fn of(&self, kind: RayKind) -> &[Ray] {
        &self.0[kind as usize]
    }
}

/// All pixels, tile by tile.
fn pixels((width, height): (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    let starts = |length: u32| (0..length).step_by(TILE as usize);
    let tiles = starts(height).flat_map(move |y| starts(width).map(move |x| (x, y)));
    let inside = move |(x0, y0): (u32, u32)| {
        let columns = x0..width.min(x0 + TILE);
        (y0..height.min(y0 + TILE)).flat_map(move |y| columns.clone().map(move |x| (x, y)))
    };
    tiles.flat_map(inside)
}

fn on_sphere(rng: &mut Pcg64Mcg) -> DVec3 {
    uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3()
}

/// A ray whose numbers are f32; its direction has length 1 to within that.
fn exact(origin: DVec3, direction: DVec3, tmax: f64) -> Ray {
    Ray {
        tmax: f64::from(tmax as f32),
        ..Ray::new(
            origin.as_vec3().as_dvec3(),
            direction.normalize().as_vec3().as_dvec3(),
        )
    }
}

use glam::{DVec3, Vec2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::accel::Accel;
use crate::error::{Error, Result};
use crate::film::Rect;
use crate::math::{Frame, Ray};
use crate::sampling::{cosine_hemisphere, random_chord};

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
        let camera: Vec<Ray> = (Rect::of_size(size).blocks())
            .map(|pixel| of_unit_length(on_film(pixel)))
            .collect();
        let chords = (camera.iter())
            .map(|_| of_unit_length(random_chord(&bounds, &mut rng)))
            .collect();
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
            let ray = of_unit_length(Ray::new(p, out));
            bounce.push(ray);
            occlusion.push(until(ray, 0.5 * radius));
            let mut across = || rng.random_range(-0.5..0.5);
            let light = center + radius * DVec3::new(across(), 2.0, across());
            let ray = of_unit_length(Ray::new(p, light - p));
            shadow.push(until(ray, 0.999 * p.distance(light)));
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

/// With a direction of length 1, to within an f32.
fn of_unit_length(ray: Ray) -> Ray {
    Ray::new(ray.origin, ray.direction.normalize()).rounded()
}

fn until(ray: Ray, tmax: f64) -> Ray {
    Ray { tmax, ..ray }.rounded()
}

use glam::{DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::accel::Accel;
use crate::geometry::Mesh;
use crate::math::{Frame, Ray};
use crate::sampling::{cosine_hemisphere, uniform_sphere};

/// Ways to aim rays at a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayClass {
    /// From one point in front, through a picture.
    Camera,
    /// From points of the surface, cosine-weighted.
    Bounce,
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
    pub const ALL: [Self; 6] = [
        Self::Camera,
        Self::Bounce,
        Self::Chord,
        Self::Vertex,
        Self::Edge,
        Self::Axis,
    ];
}

/// Makes rays whose origins and directions are exact in f32, as Embree needs them.
pub struct RayMaker<'a> {
    mesh: &'a Mesh,
    accel: &'a Accel,
    center: DVec3,
    radius: f64,
}

impl<'a> RayMaker<'a> {
    /// For `mesh`, the only shape of `accel`.
    pub fn new(mesh: &'a Mesh, accel: &'a Accel) -> Self {
        let bounds = mesh.bounds();
        Self {
            mesh,
            accel,
            center: bounds.center(),
            radius: 0.5 * bounds.size().length(),
        }
    }

    /// Rays without end; the same for the same class, seed and chunk.
    pub fn rays(&self, class: RayClass, seed: u64, chunk: u64) -> impl Iterator<Item = Ray> + '_ {
        let state = u128::from(seed) << 64 | u128::from(chunk) << 8 | class as u128;
        let mut rng = Pcg64Mcg::seed_from_u64((state ^ state >> 64) as u64 ^ seed.rotate_left(40));
        std::iter::repeat_with(move || self.ray(class, &mut rng)).filter(is_ray)
    }

    fn ray(&self, class: RayClass, rng: &mut Pcg64Mcg) -> Ray {
        match class {
            RayClass::Camera => self.camera(rng),
            RayClass::Bounce => self.bounce(rng),
            RayClass::Chord => between(self.around(1.1, rng), self.around(1.1, rng)),
            RayClass::Vertex => between(self.around(2.0, rng), self.corner(rng)),
            RayClass::Edge => {
                let [a, b, _] = self.triangle(rng);
                between(self.around(2.0, rng), a.lerp(b, rng.random()))
            }
            RayClass::Axis => {
                let through = self.corner(rng);
                let (axis, sign) = (
                    rng.random_range(0..3),
                    if rng.random() { 1.0 } else { -1.0 },
                );
                let mut origin = through;
                origin[axis] = self.center[axis] - sign * 1.5 * self.radius;
                let mut direction = DVec3::ZERO;
                direction[axis] = sign;
                exact(origin, direction)
            }
        }
    }

    fn camera(&self, rng: &mut Pcg64Mcg) -> Ray {
        let eye = self.center + self.radius * DVec3::new(0.7, 0.5, 1.9);
        let spread = DVec3::new(rng.random(), rng.random(), rng.random()) - 0.5;
        between(eye, self.center + 1.6 * self.radius * spread)
    }

    fn bounce(&self, rng: &mut Pcg64Mcg) -> Ray {
        let ray = self.camera(rng);
        let Some(hit) = self.accel.intersect(&ray) else {
            return ray;
        };
        let [a, b, c] = self.mesh.corners(hit.primitive).map(Vec3::as_dvec3);
        let n = (b - a).cross(c - a).normalize().as_vec3();
        let n = if n.as_dvec3().dot(ray.direction) > 0.0 {
            -n
        } else {
            n
        };
        let local = cosine_hemisphere(Vec2::new(rng.random(), rng.random()));
        let lifted = ray.at(hit.t) + 1e-4 * self.radius * n.as_dvec3();
        exact(lifted, Frame::around(n).to_world(local).as_dvec3())
    }

    /// A point of the sphere around the mesh, `scale` times as large.
    fn around(&self, scale: f64, rng: &mut Pcg64Mcg) -> DVec3 {
        let d = uniform_sphere(Vec2::new(rng.random(), rng.random()));
        self.center + scale * self.radius * d.as_dvec3()
    }

    fn triangle(&self, rng: &mut Pcg64Mcg) -> [DVec3; 3] {
        let i = rng.random_range(0..self.mesh.triangles.len() as u32);
        self.mesh.corners(i).map(Vec3::as_dvec3)
    }

    fn corner(&self, rng: &mut Pcg64Mcg) -> DVec3 {
        self.triangle(rng)[0]
    }
}

/// From `a` through `b`, the direction taken from the rounded origin, of any length.
fn between(a: DVec3, b: DVec3) -> Ray {
    let a = a.as_vec3().as_dvec3();
    exact(a, b - a)
}

fn exact(origin: DVec3, direction: DVec3) -> Ray {
    Ray::new(origin.as_vec3().as_dvec3(), direction.as_vec3().as_dvec3())
}

/// Two points that round to the same one make no ray.
fn is_ray(ray: &Ray) -> bool {
    ray.direction != DVec3::ZERO && ray.direction.is_finite()
}

//! Which clear medium a path is in, where clear objects stand inside one another.

use glam::{DVec3, Vec3};

use crate::color::Rgb;
use crate::geometry::Shape;
use crate::material::{Interior, Material, MaterialId};
use crate::scene::Scene;

use super::{SurfacePoint, World};

/// The clear objects that a path is inside of, the one whose medium it is in last: of objects that overlap that is
/// the one entered last. Outside of all there is air, of index 1.
///
/// An object's medium is that of the face by which the path came in.
#[derive(Clone, Debug, Default)]
pub struct Media(Vec<Medium>);

/// A clear object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium {
    instance: u32,
    interior: Interior,
}

impl Medium {
    /// The medium inside instance `index`; what is a surface has no inside.
    pub(super) fn of(scene: &Scene, index: usize) -> Option<Self> {
        let instance = &scene.instances[index];
        if matches!(instance.shape, Shape::Solid(solid) if solid.is_surface()) {
            return None;
        }
        let surface = |id: &MaterialId| &scene.materials[id.0 as usize].surface;
        instance.materials.iter().map(surface).find_map(|surface| {
            let instance = index as u32;
            let interior = surface.interior()?;
            Some(Self { instance, interior })
        })
    }
}

impl Media {
    /// The index of refraction beyond the surface over the one before it, for an object of index `ior`.
    pub(super) fn eta(&self, point: &SurfacePoint, ior: f32) -> f32 {
        let others = |medium: &&Medium| medium.instance != point.instance;
        let around = self.0.iter().rfind(others).map_or(1.0, |m| m.interior.ior);
        if point.side > 0.0 {
            return ior / around;
        }
        match self.0.iter().rposition(|m| m.instance == point.instance) {
            // The path goes on in an object that it entered later.
            Some(i) if i + 1 < self.0.len() => 1.0,
            Some(i) => around / self.0[i].interior.ior,
            None => around / ior,
        }
    }

    /// What is left of light after `distance` in the medium that rules here (Beer's law).
    pub fn transmittance(&self, distance: f64) -> Rgb {
        let absorption = self.0.last().map_or(Rgb::ZERO, |m| m.interior.absorption);
        if absorption == Rgb::ZERO {
            return Rgb::ONE;
        }
        let left = |a: f32| {
            // Of what is not absorbed at all nothing is lost however far it goes.
            if a == 0.0 {
                1.0
            } else {
                (-a * distance as f32).exp()
            }
        };
        Rgb::from_array(absorption.to_array().map(left))
    }

    /// What is left of light that reaches the surface along `wi` from `distance` away.
    pub fn towards(
        &self,
        point: &SurfacePoint,
        material: &Material,
        wi: Vec3,
        distance: f64,
    ) -> Rgb {
        let mut beyond = self.clone();
        beyond.follow(point, material, wi);
        beyond.transmittance(distance)
    }

    /// The path leaves the surface along `wi`: where that crosses a clear one, it enters or leaves the object.
    pub fn follow(&mut self, point: &SurfacePoint, material: &Material, wi: Vec3) {
        let Some(interior) = material.surface.interior() else {
            return;
        };
        if point.side * wi.dot(point.ng) >= 0.0 {
            return;
        }
        let instance = point.instance;
        self.0.retain(|medium| medium.instance != instance);
        if point.side > 0.0 {
            self.0.push(Medium { instance, interior });
        }
    }
}

impl World {
    /// The media in which a path from `p` starts: of objects inside one another the smaller counts as entered later.
    pub fn media_at(&self, p: DVec3) -> Media {
        let mut around: Vec<Medium> = (self.clear.iter())
            .filter(|medium| self.accel.contains(medium.instance, p))
            .copied()
            .collect();
        let volume = |medium: &Medium| {
            let bounds = self.accel.instance_bounds(medium.instance);
            bounds.size().element_product()
        };
        around.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
        Media(around)
    }
}

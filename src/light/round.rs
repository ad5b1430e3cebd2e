use glam::{DVec2, DVec3, Vec2};

use crate::color::Rgb;
use crate::geometry::Solid;
use crate::math::Transform;
use crate::sampling::choose;

use super::patch::{Patches, patches};
use super::surface::SurfaceSample;

/// A disk, cylinder, cone, torus or sphere under any transform that emits `radiance` from every point of its surface,
/// from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundLight {
    /// None of the others.
    pub solid: Solid,
    /// Where.
    pub world_from_object: Transform,
    /// W/(m² sr).
    pub radiance: Rgb,
    /// How far off the surface a point must be to lie clearly in front of it.
    pub error: f64,
}

/// A point from which the light is seen, and what is in view of it.
struct Viewer {
    from: DVec3,
    /// In object space.
    local: DVec3,
    patches: Patches,
}

impl RoundLight {
    /// Uniform in area over what is in view, area being that of object space.
    pub(super) fn sample(&self, from: DVec3, u2: Vec2) -> Option<SurfaceSample> {
        let viewer = self.viewer(from);
        let (q, face) = draw(&viewer.patches, u2)?;
        let p = self.world_from_object.point(q);
        let outward = self.solid.normal(q, face);
        let n = self.world_from_object.normal(outward) * outward.dot(viewer.local - q).signum();
        Some(SurfaceSample {
            p: p + self.error * n,
            face,
            pdf: self.density(&viewer, p, face),
        })
    }

    pub(super) fn pdf(&self, from: DVec3, p: DVec3, face: u32) -> f64 {
        self.density(&self.viewer(from), p, face)
    }

    /// A point, uniform in area of object space, and its face.
    pub(super) fn point(&self, u2: Vec2) -> (DVec3, u32) {
        let (q, face) = draw(&patches(self.solid, None), u2).unwrap_or_default();
        (self.world_from_object.point(q), face)
    }

    fn viewer(&self, from: DVec3) -> Viewer {
        let local = self.world_from_object.inverse_point(from);
        Viewer {
            from,
            local,
            patches: patches(self.solid, Some(local)),
        }
    }

    /// From area in object space to solid angle in the world: a piece dA at q with the unit normal n, seen from v, has
    /// the solid angle |det M n.(v - q)| dA / d³, d being the distance in the world.
    fn density(&self, viewer: &Viewer, p: DVec3, face: u32) -> f64 {
        let q = self.world_from_object.inverse_point(p);
        let facing = self.solid.normal(q, face).dot(viewer.local - q);
        let hides_itself = !matches!(self.solid, Solid::Disk { .. } | Solid::Torus { .. });
        if hides_itself && facing <= 0.0 && !self.solid.contains(viewer.local) {
            return 0.0;
        }
        let determinant = self.world_from_object.matrix().matrix3.determinant();
        let total: f64 = areas(&viewer.patches).iter().sum();
        viewer.from.distance(p).powi(3) / (total * determinant * facing).abs()
    }

    /// Of the outside, or of both sides of a disk.
    pub(super) fn area(&self) -> f64 {
        const GRID: u32 = 16;
        let all = patches(self.solid, None);
        let transform = &self.world_from_object;
        // By how much more the transform enlarges pieces of the surface than it does lengths along their normals.
        let stretches = (0..GRID * GRID).filter_map(|i| {
            let cell = Vec2::new((i % GRID) as f32, (i / GRID) as f32);
            let (q, face) = draw(&all, (cell + 0.5) / GRID as f32)?;
            Some(transform.gradient(self.solid.normal(q, face)).length())
        });
        let stretch = stretches.sum::<f64>() / f64::from(GRID * GRID);
        let area = areas(&all).iter().sum::<f64>()
            * (stretch * transform.matrix().matrix3.determinant()).abs();
        let sides = if self.solid.is_surface() { 2.0 } else { 1.0 };
        sides * area
    }
}

fn areas(patches: &Patches) -> [f64; 3] {
    patches.map(|patch| patch.map_or(0.0, |(_, patch)| patch.area()))
}

/// A point of the patches in object space, uniform in area, and its face.
fn draw(patches: &Patches, u2: Vec2) -> Option<(DVec3, u32)> {
    let (index, u) = choose(f64::from(u2.x), areas(patches))?;
    let (face, patch) = patches[index]?;
    Some((patch.point(DVec2::new(u, f64::from(u2.y))), face))
}

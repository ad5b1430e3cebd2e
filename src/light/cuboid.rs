use glam::{DVec2, DVec3, Vec2};

use crate::color::Rgb;
use crate::sampling::choose;

use super::quad::{Quad, View};
use super::surface::SurfaceSample;

/// A box in world space, or what an affine map makes of one, that emits `radiance` from every point of its surface,
/// inward too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxLight {
    /// Its middle.
    pub center: DVec3,
    /// From there to the middles of the faces on the positive side.
    pub axes: [DVec3; 3],
    /// W/(m² sr).
    pub radiance: Rgb,
    /// How far off the surface a point must be to lie clearly in front of it.
    pub error: f64,
}

impl BoxLight {
    /// Of the faces in view one by its solid angle, then a point as on a rectangle: uniform in solid angle over all that
    /// is seen of the box.
    pub(super) fn sample(&self, from: DVec3, u2: Vec2) -> Option<SurfaceSample> {
        let faces = self.faces();
        let views = self.views(&faces, from);
        let (face, u) = choose(f64::from(u2.x), extents(&views))?;
        let view = views[face].as_ref()?;
        let (p, pdf) = view.sample(DVec2::new(u, f64::from(u2.y)));
        Some(SurfaceSample {
            p: p + self.error * view.n,
            face: face as u32,
            pdf: pdf * share(&views, face),
        })
    }

    pub(super) fn pdf(&self, from: DVec3, p: DVec3, face: u32) -> f64 {
        let faces = self.faces();
        let views = self.views(&faces, from);
        let view = views[face as usize].as_ref();
        view.map_or(0.0, |view| view.pdf(p) * share(&views, face as usize))
    }

    /// A point, uniform in area, and its face.
    pub(super) fn point(&self, u2: Vec2) -> (DVec3, u32) {
        let faces = self.faces();
        let (face, u) =
            choose(f64::from(u2.x), faces.map(|quad| quad.area())).expect("a box has an area");
        let p = faces[face].point(DVec2::new(u, f64::from(u2.y)));
        (p, face as u32)
    }

    /// The faces, numbered as those of [`crate::geometry::Solid::Box`] are.
    fn faces(&self) -> [Quad; 6] {
        std::array::from_fn(|face| {
            let [out, x, y] = [0, 1, 2].map(|i| self.axes[(face / 2 + i) % 3]);
            Quad::new(self.center + sign(face) * out, [2.0 * x, 2.0 * y])
        })
    }

    /// What is seen of each face: from outside of those turned to `from`, from inside of all.
    fn views<'a>(&self, faces: &'a [Quad; 6], from: DVec3) -> [Option<View<'a>>; 6] {
        let [x, y, z] = self.axes;
        let to = from - self.center;
        // Where the box goes from -1 to 1.
        let at = [y.cross(z), z.cross(x), x.cross(y)].map(|n| n.dot(to) / x.dot(y.cross(z)));
        let inside = at.iter().all(|at| at.abs() < 1.0);
        std::array::from_fn(|face| {
            let turned = inside || sign(face) * at[face / 2] > 1.0;
            faces[face].view(from, self.error).filter(|_| turned)
        })
    }

    /// Of the outside: what shines inward comes out no more.
    pub(super) fn area(&self) -> f64 {
        self.faces().iter().map(Quad::area).sum()
    }
}

/// On which side of the middle a face is.
fn sign(face: usize) -> f64 {
    if face.is_multiple_of(2) { -1.0 } else { 1.0 }
}

fn extents(views: &[Option<View<'_>>; 6]) -> [f64; 6] {
    views
        .each_ref()
        .map(|view| view.as_ref().map_or(0.0, View::extent))
}

/// The part of what is seen that is on one face.
fn share(views: &[Option<View<'_>>; 6], face: usize) -> f64 {
    let extents = extents(views);
    extents[face] / extents.iter().sum::<f64>()
}

//! A part of the figure: its surface, where it goes and what it is made of.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec3};

use crate::sdf::Tube;
use crate::surface_nets::{Surface, polygonize};

/// The six groups of the figure; each has the material of the same name.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    Skin,
    Hair,
    Dress,
    Tights,
    Shoes,
    Arms,
}

/// A solid of one group. Details borrow the group whose colour they need: the irises are of the dress, the lips of
/// the shoes.
pub(crate) struct Part {
    pub(crate) group: Group,
    frame: DAffine3,
    mesh: Box<dyn Fn() -> Surface + Sync>,
}

impl Part {
    /// The solid where `field` is negative, which lies in the box `lo..hi`, cut into cells of side `cell`.
    pub(crate) fn new(
        group: Group,
        cell: f64,
        [lo, hi]: [DVec3; 2],
        field: impl Fn(DVec3) -> f64 + Sync + 'static,
    ) -> Self {
        Self {
            group,
            frame: DAffine3::IDENTITY,
            mesh: Box::new(move || polygonize(&field, lo, hi, cell)),
        }
    }

    /// The union of tubes, its seams filled over a width of about `seam`.
    pub(crate) fn tubes(group: Group, cell: f64, seam: f64, tubes: Vec<Tube>) -> Self {
        let balls = || tubes.iter().flat_map(Tube::balls);
        let pad = 1.5 * cell;
        let lo = balls().map(|&(p, r)| p - r - pad).reduce(DVec3::min);
        let hi = balls().map(|&(p, r)| p + r + pad).reduce(DVec3::max);
        let bounds = [lo.unwrap_or_default(), hi.unwrap_or_default()];
        Self::new(group, cell, bounds, move |p| {
            let distances = tubes.iter().map(|tube| tube.distance(p));
            distances.fold(f64::INFINITY, |a, b| crate::sdf::join(a, b, seam))
        })
    }

    /// An ellipsoid at `centre` whose axes are the columns of `axes`, in `rings` bands from pole to pole along z.
    ///
    /// It needs no net: where two such ellipsoids share their poles, as in an eye, they meet in a clean ellipse.
    pub(crate) fn ellipsoid(
        group: Group,
        rings: usize,
        centre: DVec3,
        axes: DMat3,
        radii: DVec3,
    ) -> Self {
        Self {
            group,
            frame: DAffine3::from_mat3_translation(axes, centre),
            mesh: Box::new(move || globe(rings, radii)),
        }
    }

    /// Moves and scales the part by a similarity.
    pub(crate) fn placed(mut self, frame: DAffine3) -> Self {
        self.frame = frame * self.frame;
        self
    }

    /// Meshes the part, in the figure's space.
    pub(crate) fn sculpt(&self) -> Surface {
        let mut surface = (self.mesh)();
        for p in &mut surface.positions {
            *p = self.frame.transform_point3(*p);
        }
        for n in &mut surface.normals {
            *n = self.frame.transform_vector3(*n).normalize();
        }
        surface
    }
}

/// An ellipsoid of latitudes and longitudes.
fn globe(rings: usize, radii: DVec3) -> Surface {
    let sectors = 3 * rings;
    let mut sphere = vec![DVec3::Z];
    for ring in 1..rings {
        let (sin, cos) = (PI * ring as f64 / rings as f64).sin_cos();
        sphere.extend((0..sectors).map(|sector| {
            let (y, x) = (TAU * sector as f64 / sectors as f64).sin_cos();
            DVec3::new(sin * x, sin * y, cos)
        }));
    }
    sphere.push(DVec3::NEG_Z);
    let last = sphere.len() - 1;
    let at = |ring: usize, sector: usize| 1 + (ring - 1) * sectors + sector % sectors;
    let mut triangles = Vec::new();
    for s in 0..sectors {
        triangles.push([0, at(1, s), at(1, s + 1)]);
        triangles.push([last, at(rings - 1, s + 1), at(rings - 1, s)]);
        for ring in 1..rings - 1 {
            let [a, b] = [at(ring, s), at(ring, s + 1)];
            let [c, d] = [at(ring + 1, s), at(ring + 1, s + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    Surface {
        positions: sphere.iter().map(|&p| p * radii).collect(),
        normals: sphere.iter().map(|&p| (p / radii).normalize()).collect(),
        triangles,
    }
}

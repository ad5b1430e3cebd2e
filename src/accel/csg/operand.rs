//! An operand in its place: where a ray crosses it, and how surely.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::accel::mesh::{MeshCrossing, MeshTree};
use crate::accel::winding::WindingNumber;
use crate::geometry::solid::Crossing;
use crate::geometry::{LinearMap, Solid};
use crate::math::{Bounds, Ray};

/// What an operand is.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    Solid(Solid),
    Mesh(Arc<MeshTree>),
    OpenMesh(Arc<WindingNumber>),
}

/// The face where an open mesh has none: in a hole.
pub const HOLE: u32 = u32::MAX;

/// What operands share.
#[derive(Clone, Debug)]
pub(super) struct Form {
    pub(super) kind: Kind,
    /// The greatest distance of its points from its origin; 0 for a half-space.
    pub(super) size: f64,
}

/// An operand of the formula, in its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub(super) origin: DVec3,
    pub(super) form: u32,
    pub(super) map: u32,
    /// Index in the authored tree.
    pub(super) id: u32,
    /// Operator of the formula, and in the lowest bit whether the operand is negated.
    literal: u32,
}

/// Where a ray's line crosses the surface of an operand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub(super) t: f64,
    /// The crossing may be this far off along the ray: what is within it of another happens at the same place.
    pub(super) dt: f64,
    /// Position of the leaf.
    pub(super) leaf: u32,
    /// Solid: the face. Mesh: the triangle.
    pub(super) face: u32,
    pub(super) enter: bool,
}

impl Event {
    pub(super) fn earliest(&self) -> f64 {
        self.t - self.dt
    }

    pub(super) fn latest(&self) -> f64 {
        self.t + self.dt
    }
}

/// An open mesh looks at its winding number beside its crossings, this far away.
const BESIDE: f64 = 1024.0 * f64::EPSILON;

/// Solids find their crossings this close to a face, in units of their size and the distance to the ray's origin
/// ([`Solid::spans`]); transforming the ray costs less, in units of the coordinates.
pub(in crate::accel) const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Form {
    pub(super) fn new(kind: Kind) -> Self {
        let mut form = Self { kind, size: 0.0 };
        let bounds = form.bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).length();
        if reach.is_finite() {
            form.size = reach;
        }
        form
    }

    pub(super) fn bounds(&self) -> Bounds {
        match &self.kind {
            Kind::Solid(solid) => solid.bounds(),
            Kind::Mesh(mesh) => mesh.bounds,
            Kind::OpenMesh(mesh) => mesh.mesh.bounds,
        }
    }

    /// How far along the unit normal `n` the surface may be found off its place. All in the operand's space: `moved`
    /// bounds what the coordinates were before they came there (see [`moved`]), `distance` is that of the operand's
    /// origin to where the solver started.
    #[inline(always)]
    pub(super) fn uncertainty(&self, moved: DVec3, distance: f64, n: DVec3) -> f64 {
        self.rounding() * (self.size + distance + n.abs().dot(moved))
    }

    fn rounding(&self) -> f64 {
        match self.kind {
            Kind::Solid(_) | Kind::Mesh(_) => ROUNDING,
            Kind::OpenMesh(_) => BESIDE,
        }
    }
}

/// The coordinates `span` taken to the operand's space without signs, so that nothing cancels.
#[inline(always)]
pub(super) fn moved(inverse: &DMat3, span: DVec3) -> DVec3 {
    inverse.x_axis.abs() * span.x + inverse.y_axis.abs() * span.y + inverse.z_axis.abs() * span.z
}

impl Leaf {
    pub(super) fn new(
        origin: DVec3,
        form: u32,
        map: u32,
        id: u32,
        parent: u32,
        negated: bool,
    ) -> Self {
        Self {
            origin,
            form,
            map,
            id,
            literal: parent << 1 | u32::from(negated),
        }
    }

    pub(super) fn parent(&self) -> u32 {
        self.literal >> 1
    }

    pub(super) fn negated(&self) -> bool {
        self.literal & 1 == 1
    }

    #[inline(always)]
    pub(super) fn local_ray(&self, map: &LinearMap, ray: &Ray) -> Ray {
        Ray {
            origin: map.inverse * (ray.origin - self.origin),
            direction: map.inverse * ray.direction,
            ..*ray
        }
    }

    /// All events from `ray.tmin` on (and some before: a span comes whole), as the leaf at `position`.
    #[inline(always)]
    pub(super) fn events(
        &self,
        position: u32,
        form: &Form,
        map: &LinearMap,
        ray: &Ray,
        mut emit: impl FnMut(Event),
    ) {
        let local = self.local_ray(map, ray);
        let certainty = Certainty {
            leaf: self,
            form,
            inverse: &map.inverse,
            ray,
            local: &local,
            distance: local.origin.length(),
        };
        match &form.kind {
            Kind::Solid(solid) => {
                for span in solid.spans(&local).iter() {
                    let chord = span.exit.t - span.enter.t;
                    if span.exit.t + chord < ray.tmin {
                        continue;
                    }
                    let moved = certainty.moved(span.enter.t, span.exit.t);
                    for (crossing, enter) in [(span.enter, true), (span.exit, false)] {
                        let Crossing { t, face } = crossing;
                        let n = solid.normal(local.at(t), face);
                        emit(Event {
                            t,
                            dt: certainty.dt(t, moved, n, chord),
                            leaf: position,
                            face,
                            enter,
                        });
                    }
                }
            }
            Kind::Mesh(mesh) => winding_events(mesh, &local, |crossing, enter, chord| {
                let moved = certainty.moved(crossing.t, crossing.t);
                emit(Event {
                    t: crossing.t,
                    dt: certainty.dt(crossing.t, moved, crossing.n.normalize(), chord),
                    leaf: position,
                    face: crossing.primitive,
                    enter,
                });
            }),
            Kind::OpenMesh(mesh) => {
                let off = form.uncertainty(DVec3::ZERO, local.origin.length(), DVec3::ZERO);
                let dt = off / local.direction.length();
                let event = |t: f64, face: u32, enter: bool| Event {
                    t,
                    dt: if t.is_finite() { dt } else { 0.0 },
                    leaf: position,
                    face,
                    enter,
                };
                let mut inside = false;
                mesh.open_crossings(&local, |crossing| {
                    // A ray that first leaves has started inside.
                    if inside == crossing.enter {
                        emit(event(f64::NEG_INFINITY, HOLE, true));
                    }
                    inside = crossing.enter;
                    let face = crossing.primitive.unwrap_or(HOLE);
                    emit(event(crossing.t, face, crossing.enter));
                });
            }
        }
    }

    /// Whether the point `p` lies inside or on the surface.
    pub(super) fn contains(&self, form: &Form, map: &LinearMap, p: DVec3) -> bool {
        let local = map.inverse * (p - self.origin);
        match &form.kind {
            Kind::Solid(solid) => solid.contains(local),
            Kind::Mesh(mesh) => mesh.winding(local) > 0,
            Kind::OpenMesh(mesh) => mesh.contains(local),
        }
    }
}

/// How surely a ray's crossings with a leaf are where they are.
struct Certainty<'a> {
    leaf: &'a Leaf,
    form: &'a Form,
    inverse: &'a DMat3,
    ray: &'a Ray,
    local: &'a Ray,
    /// Of the operand's origin to the ray's.
    distance: f64,
}

impl Certainty<'_> {
    /// For crossings at both ends of a span: see [`moved`].
    #[inline(always)]
    fn moved(&self, enter: f64, exit: f64) -> DVec3 {
        let reach = |t: f64| {
            if t.is_finite() {
                self.ray.at(t).abs()
            } else {
                DVec3::ZERO
            }
        };
        let near = self.ray.origin.abs() + self.leaf.origin.abs();
        moved(self.inverse, near + reach(enter).max(reach(exit)))
    }

    /// How far off along the ray the crossing at `t` may be: at most `chord`, the distance to the operand's next one,
    /// because a shallower span is as good as none.
    #[inline(always)]
    fn dt(&self, t: f64, moved: DVec3, n: DVec3, chord: f64) -> f64 {
        if t.is_infinite() {
            return 0.0;
        }
        let off = (self.form).uncertainty(moved, self.distance, n);
        (off / n.dot(self.local.direction).abs()).min(chord)
    }
}

/// Where `ray` passes from winding number 0 to 1 or back beyond `ray.tmin`, in order, with how far it is to the next or
/// last such place. A ray that starts inside first enters before all numbers.
fn winding_events(mesh: &MeshTree, ray: &Ray, mut visit: impl FnMut(&MeshCrossing, bool, f64)) {
    let mut crossings: Vec<MeshCrossing> = Vec::new();
    mesh.crossings(ray, |crossing| crossings.push(crossing));
    crossings.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
    let step = |crossing: &MeshCrossing| if crossing.enter { 1 } else { -1 };
    let mut winding = -crossings.iter().map(step).sum::<i32>();
    let mut last = f64::NEG_INFINITY;
    if let Some(first) = crossings.first().filter(|_| winding > 0) {
        let start = MeshCrossing { t: last, ..*first };
        visit(&start, true, 0.0);
    }
    for (i, crossing) in crossings.iter().enumerate() {
        let before = winding > 0;
        winding += step(crossing);
        if before != (winding > 0) {
            let next = crossings.get(i + 1).map_or(f64::INFINITY, |next| next.t);
            visit(
                crossing,
                winding > 0,
                (next - crossing.t).min(crossing.t - last),
            );
            last = crossing.t;
        }
    }
}

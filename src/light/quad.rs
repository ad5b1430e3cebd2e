use glam::{DVec2, DVec3, Vec2};

use crate::color::Rgb;
use crate::sampling::SphericalRectangle;

use super::flat::{Flat, SMALL};
use super::surface::SurfaceSample;

/// A parallelogram in world space that emits `radiance` from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadLight {
    quad: Quad,
    /// W/(m² sr).
    pub radiance: Rgb,
    error: f64,
}

impl QuadLight {
    /// `error` is how far off the surface a point must be to lie clearly in front of it.
    pub fn new(quad: Quad, radiance: Rgb, error: f64) -> Self {
        Self {
            quad,
            radiance,
            error,
        }
    }

    /// Uniform in solid angle, of a rectangle from nearby; else in area.
    #[inline(always)]
    pub(super) fn sample(&self, from: DVec3, u2: Vec2) -> Option<SurfaceSample> {
        let view = self.quad.view(from, self.error)?;
        let (p, pdf) = view.sample(u2.as_dvec2());
        Some(SurfaceSample {
            p: p + self.error * view.n,
            face: 0,
            pdf,
        })
    }

    pub(super) fn pdf(&self, from: DVec3, p: DVec3) -> f64 {
        (self.quad.view(from, self.error)).map_or(0.0, |view| view.pdf(p))
    }

    pub(super) fn point(&self, u2: Vec2) -> DVec3 {
        self.quad.point(u2.as_dvec2())
    }

    /// Of both sides.
    pub(super) fn area(&self) -> f64 {
        2.0 * self.quad.area()
    }
}

/// A parallelogram in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    middle: DVec3,
    edges: [DVec3; 2],
    /// Half their lengths.
    halves: [f64; 2],
    /// Unit directions along them.
    axes: [DVec3; 2],
    flat: Flat,
}

impl Quad {
    /// From its middle and two edges.
    pub fn new(middle: DVec3, edges: [DVec3; 2]) -> Self {
        let flat = Flat::new(edges, 1.0);
        let quad = Self {
            middle,
            edges,
            halves: edges.map(|edge| 0.5 * edge.length()),
            axes: edges.map(DVec3::normalize),
            flat,
        };
        if quad.is_rectangle() {
            return quad;
        }
        Self {
            flat: flat.never_near(),
            ..quad
        }
    }

    /// Whether it is a rectangle, to within what f32 makes of one.
    pub fn is_rectangle(&self) -> bool {
        let [x, y] = self.edges;
        x.dot(y).powi(2) <= 1e-12 * x.length_squared() * y.length_squared()
    }

    pub(super) fn area(&self) -> f64 {
        self.flat.area()
    }

    /// The point at shares `u2` of the edges.
    pub(super) fn point(&self, u2: DVec2) -> DVec3 {
        self.middle + (u2.x - 0.5) * self.edges[0] + (u2.y - 0.5) * self.edges[1]
    }

    /// What is seen of it; `None` from less than `error` off its plane, where that is nothing.
    #[inline(always)]
    pub(super) fn view(&self, from: DVec3, error: f64) -> Option<View<'_>> {
        let to = self.middle - from;
        let n = self.flat.normal_towards(to, error)?;
        let near = self.flat.is_near(to);
        Some(View {
            quad: self,
            from,
            n,
            seen: near.then(|| self.seen(to, n)).flatten(),
        })
    }

    /// What directions are drawn from, the middle being seen at `to`.
    #[inline(always)]
    fn seen(&self, to: DVec3, n: DVec3) -> Option<SphericalRectangle> {
        let [x, y] = [0, 1].map(|i| {
            let middle = to.dot(self.axes[i]);
            [middle - self.halves[i], middle + self.halves[i]]
        });
        let seen = SphericalRectangle::new(x, y, -n.dot(to));
        (seen.solid_angle() > SMALL).then_some(seen)
    }
}

/// A parallelogram as seen from a point.
pub(super) struct View<'a> {
    quad: &'a Quad,
    from: DVec3,
    /// Unit normal on the side of the point.
    pub(super) n: DVec3,
    /// What directions are drawn from, nearby.
    seen: Option<SphericalRectangle>,
}

impl View<'_> {
    /// A point and its density per solid angle.
    #[inline(always)]
    pub(super) fn sample(&self, u2: DVec2) -> (DVec3, f64) {
        let shares = self.seen.map_or(u2, |seen| seen.sample(u2));
        let p = self.quad.point(shares);
        (p, self.pdf(p))
    }

    pub(super) fn pdf(&self, p: DVec3) -> f64 {
        match self.seen {
            Some(seen) => seen.solid_angle().recip(),
            None => self.quad.flat.pdf(p - self.from),
        }
    }

    /// About the solid angle; exactly where directions are drawn from it.
    pub(super) fn extent(&self) -> f64 {
        match self.seen {
            Some(seen) => seen.solid_angle(),
            None => (self.quad.flat.pdf(self.quad.middle - self.from)).recip(),
        }
    }
}

//! Scattering at one surface point. `wo` points to where light goes (the camera's side), `wi` to where
//! it comes from; inside a lobe both are in the shading frame with z along the normal.

mod albedo;
mod dielectric;
mod diffuse;
mod film;
mod fresnel;
mod lobe;
mod microfacet;
mod mirror;
mod mix;
mod plastic;
mod principled;
mod reflection;
mod sheen;
mod thin;

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::material::Surface;
use crate::math::Frame;
use crate::texture::TexturePoint;

use self::lobe::Lobe;

/// A direction drawn from a lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Direction of the incoming light.
    pub wi: Vec3,
    /// `f |cos| / pdf`.
    pub weight: Rgb,
    /// Density per solid angle; infinite for a delta lobe.
    pub pdf: f32,
    /// Relative index of refraction squared where the direction crosses the surface, else 1: what
    /// radiance loses by spreading, kept apart for Russian roulette.
    pub eta2: f32,
}

impl BsdfSample {
    /// On this side of the surface, or between equal media.
    fn new(wi: Vec3, weight: Rgb, pdf: f32) -> Self {
        Self {
            wi,
            weight,
            pdf,
            eta2: 1.0,
        }
    }

    /// A direction with its `f |cos|` and density, if it has one.
    fn of(wi: Vec3, (f_cos, pdf): (Rgb, f32)) -> Option<Self> {
        (pdf > 0.0).then(|| Self::new(wi, f_cos / pdf, pdf))
    }
}

/// Scattering at a surface point, directions in world space.
///
/// A shading normal that differs from the geometric one would send light through the surface or lose
/// it. Directions that end on the wrong side are folded back across the surface, by `sample` and by
/// `eval` alike, so that no energy is lost and both agree.
#[derive(Clone, Debug)]
pub struct Bsdf {
    lobe: Lobe,
    /// Around the shading normal, on the side of the geometric one.
    frame: Frame,
    /// Geometric normal, outward.
    ng: Vec3,
    /// 1 where light goes out along `ng`, -1 where it goes inside.
    side: f32,
}

/// Views flatter than this on the shading normal count as this flat.
const FLATTEST: f32 = 1e-4;

impl Bsdf {
    /// The scattering of `surface` at `point` towards the side of the outward normal `ng` (`side` 1) or
    /// the other (-1); `ns` lies on the side of `ng`, and anisotropic facets are stretched along `tangent`, which need
    /// be neither at right angles to `ns` nor of unit length. Where light goes through to other media `eta` is the index
    /// of refraction beyond the surface over that on this side.
    #[inline(always)]
    pub fn new(
        surface: &Surface,
        point: &TexturePoint,
        ng: Vec3,
        ns: Vec3,
        tangent: Vec3,
        side: f32,
        eta: f32,
    ) -> Self {
        let lobe = Lobe::new(surface, point, side, eta);
        let frame = if lobe.is_anisotropic() {
            Frame::along(ns, tangent)
        } else {
            Frame::around(ns)
        };
        Self {
            lobe,
            frame,
            ng,
            side,
        }
    }

    /// The share of light that it reflects in all, as a colour to show: a metal's at normal incidence, the base's where
    /// there are layers, white where light goes through.
    pub fn albedo(&self) -> Rgb {
        self.lobe.albedo()
    }

    /// Whether light can be gathered towards chosen directions: not where all lobes are delta lobes.
    pub fn is_smooth(&self) -> bool {
        self.lobe.is_smooth()
    }

    /// `f |cos|` for light from `wi` to `wo` and the density with which [`Self::sample`] draws `wi`. Delta lobes have
    /// no part in either.
    #[inline(always)]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let (frame, out) = self.facing(wo);
        let reflected = self.side * wi.dot(self.ng) > 0.0;
        if !reflected && !self.lobe.transmits() {
            return (Rgb::ZERO, 0.0);
        }
        // The direction itself, and the one that is folded onto it where the normal is bent.
        let both = [wi, self.fold(wi)];
        let count = if frame.z == self.ng { 1 } else { 2 };
        let mut sum = (Rgb::ZERO, 0.0);
        for &w in &both[..count] {
            let local = self.side * frame.to_local(w);
            if (local.z > 0.0) == reflected {
                let (f_cos, pdf) = self.lobe.eval(out, local);
                sum.0 += f_cos;
                sum.1 += pdf;
            }
        }
        sum
    }

    /// Draws a direction; `None` where all light is absorbed. `u` picks a lobe, `u2` a direction in it.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        let (frame, out) = self.facing(wo);
        let drawn = self.lobe.sample(out, u, u2)?;
        let to = if drawn.wi.z < 0.0 {
            -self.side
        } else {
            self.side
        };
        let wi = self.keep(frame.to_world(self.side * drawn.wi), to);
        if drawn.pdf.is_infinite() || frame.z == self.ng {
            return Some(BsdfSample { wi, ..drawn });
        }
        let (f_cos, pdf) = self.eval(wo, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: f_cos / pdf,
            pdf,
            ..drawn
        })
    }

    /// The frame for light towards `wo`, and `wo` in it, above the surface.
    #[inline(always)]
    fn facing(&self, wo: Vec3) -> (Frame, Vec3) {
        let out = self.side * self.frame.to_local(wo);
        if out.z >= FLATTEST {
            return (self.frame, out);
        }
        // A view from behind the bent normal has no refraction there: light that goes through takes the true surface,
        // light that is reflected leaves at the flattest.
        let (frame, out) = if self.lobe.transmits() {
            let frame = Frame::along(self.ng, self.frame.x);
            (frame, self.side * frame.to_local(wo))
        } else {
            (self.frame, out)
        };
        let flat = out.truncate().normalize_or(Vec2::X);
        let z = out.z.max(FLATTEST);
        (frame, ((1.0 - z * z).sqrt() * flat).extend(z))
    }

    /// `wi` on the given side of the geometric surface, folded across it if need be.
    fn keep(&self, wi: Vec3, side: f32) -> Vec3 {
        if side * wi.dot(self.ng) < 0.0 {
            self.fold(wi)
        } else {
            wi
        }
    }

    fn fold(&self, w: Vec3) -> Vec3 {
        w - 2.0 * w.dot(self.ng) * self.ng
    }
}

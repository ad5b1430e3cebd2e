//! Scattering at one surface point. `wo` points to where light goes (the camera's side), `wi` to where
//! it comes from; inside a lobe both are in the shading frame with z along the normal.

mod dielectric;
mod diffuse;
mod mirror;

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::material::{Fresnel, Surface};
use crate::math::Frame;
use crate::texture::TexturePoint;

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

/// A lobe in its shading frame.
#[derive(Clone, Copy, Debug)]
enum Lobe {
    Diffuse { albedo: Rgb },
    Mirror { color: Rgb },
    Dielectric { eta: f32, fresnel: Fresnel },
}

/// Scattering at a surface point, directions in world space.
///
/// A shading normal that differs from the geometric one would send light through the surface or lose
/// it. Directions that end on the wrong side are folded back across the surface, by `sample` and by
/// `eval` alike, so that no energy is lost and both agree.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    lobe: Lobe,
    /// Around the shading normal, on the side of the geometric one.
    frame: Frame,
    /// Geometric normal, outward.
    ng: Vec3,
    /// 1 where light goes out along `ng`, -1 where it goes inside.
    side: f32,
}

impl Bsdf {
    /// The scattering of `surface` at `point` towards the side of the outward normal `ng` (`side` 1) or
    /// the other (-1); `ns` lies on the side of `ng`. At a dielectric `eta` is the index of refraction beyond the
    /// surface over that on this side.
    pub fn new(
        surface: &Surface,
        point: &TexturePoint,
        ng: Vec3,
        ns: Vec3,
        side: f32,
        eta: f32,
    ) -> Self {
        let lobe = match surface {
            Surface::Diffuse { color } => Lobe::Diffuse {
                albedo: color.eval(point),
            },
            Surface::Mirror { color } => Lobe::Mirror {
                color: color.eval(point),
            },
            Surface::Dielectric { fresnel, .. } => Lobe::Dielectric {
                eta,
                fresnel: *fresnel,
            },
        };
        Self {
            lobe,
            frame: Frame::around(ns),
            ng,
            side,
        }
    }

    /// The share of light that it reflects in all, as a colour to show.
    pub fn albedo(&self) -> Rgb {
        match self.lobe {
            Lobe::Diffuse { albedo } => albedo,
            Lobe::Mirror { color } => color,
            Lobe::Dielectric { .. } => Rgb::ONE,
        }
    }

    /// Whether light can be gathered towards chosen directions: not for delta lobes.
    pub fn is_smooth(&self) -> bool {
        matches!(self.lobe, Lobe::Diffuse { .. })
    }

    /// `f |cos|` and the density with which [`Self::sample`] draws `wi`. Delta lobes give 0.
    pub fn eval(&self, wi: Vec3) -> (Rgb, f32) {
        let Lobe::Diffuse { albedo } = self.lobe else {
            return (Rgb::ZERO, 0.0);
        };
        let side = self.side;
        if side * wi.dot(self.ng) <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let direct = diffuse::pdf(side * self.frame.to_local(wi));
        let folded = diffuse::pdf(side * self.frame.to_local(self.fold(wi)));
        let pdf = direct + folded;
        (albedo * pdf, pdf)
    }

    /// Draws a direction; `None` where all light is absorbed. `u` picks a lobe, `u2` a direction in it.
    pub fn sample(&self, wo: Vec3, u: f32, u2: Vec2) -> Option<BsdfSample> {
        let side = self.side;
        match self.lobe {
            Lobe::Diffuse { albedo } => {
                let wi = self.frame.to_world(side * diffuse::sample(u2));
                let wi = self.keep(wi, side);
                let (_, pdf) = self.eval(wi);
                (pdf > 0.0).then_some(BsdfSample {
                    wi,
                    weight: albedo,
                    pdf,
                    eta2: 1.0,
                })
            }
            Lobe::Mirror { color } => {
                let wi = self
                    .frame
                    .to_world(mirror::reflect(self.frame.to_local(wo)));
                Some(BsdfSample {
                    wi: self.keep(wi, side),
                    weight: color,
                    pdf: f32::INFINITY,
                    eta2: 1.0,
                })
            }
            Lobe::Dielectric { eta, fresnel } => {
                // A view from behind the bent normal has no refraction there: use the true surface.
                let bent = side * wo.dot(self.frame.z) <= 0.0;
                let frame = if bent {
                    Frame::around(self.ng)
                } else {
                    self.frame
                };
                let mut out = side * frame.to_local(wo);
                out.z = out.z.max(0.0);
                let scattered = dielectric::sample(out, eta, fresnel, u);
                let wi = frame.to_world(side * scattered.wi);
                let to = if scattered.transmitted { -side } else { side };
                Some(BsdfSample {
                    wi: self.keep(wi, to),
                    weight: Rgb::splat(if scattered.transmitted {
                        eta.powi(-2)
                    } else {
                        1.0
                    }),
                    pdf: f32::INFINITY,
                    eta2: if scattered.transmitted {
                        eta * eta
                    } else {
                        1.0
                    },
                })
            }
        }
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

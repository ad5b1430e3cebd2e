//! Scattering at one point: every kind of surface, at five roughnesses and from five angles.

mod bent;
pub mod drawing;
mod laws;
mod quadrature;
mod values;

use glam::{DVec3, Vec2, Vec3};
use solidtrace::bsdf::Bsdf;
use solidtrace::color::Rgb;
use solidtrace::material::{Fresnel, Metal, Principled, Roughness, Surface, absorption};
use solidtrace::sampling::{Sampler, SamplerKind};
use solidtrace::texture::{Texture, TexturePoint};

pub const NG: Vec3 = Vec3::Z;
pub const ROUGHNESSES: [f32; 5] = [0.1, 0.25, 0.45, 0.7, 1.0];
/// Degrees from the normal.
pub const ANGLES: [f32; 5] = [0.0, 30.0, 60.0, 80.0, 88.0];

/// A surface seen from one side.
#[derive(Clone)]
pub struct Case {
    pub name: &'static str,
    pub surface: Surface,
    pub roughness: f32,
    pub side: f32,
    /// How far its albedo may be below 1; 1 where it absorbs as it likes.
    pub loss: f32,
}

/// `surface` at the origin, its normal up; light goes to `side`.
pub fn bsdf(surface: &Surface, ns: Vec3, side: f32) -> Bsdf {
    let point = TexturePoint {
        p: DVec3::ZERO,
        n: DVec3::Z,
        uv: Vec2::ZERO,
    };
    let ior = surface.interior().map_or(1.0, |interior| interior.ior);
    let eta = if side > 0.0 { ior } else { 1.0 / ior };
    Bsdf::new(surface, &point, NG, ns, Vec3::X, side, eta)
}

impl Case {
    pub fn bsdf(&self) -> Bsdf {
        bsdf(&self.surface, NG, self.side)
    }

    /// The directions from which it is looked at, all on its side.
    pub fn views(&self) -> impl Iterator<Item = Vec3> + use<> {
        ANGLES
            .map(|degrees| self.side * direction(degrees, 40.0))
            .into_iter()
    }

    /// Relative index of refraction beyond it.
    pub fn eta(&self) -> f32 {
        let ior = self.surface.interior().map_or(1.0, |interior| interior.ior);
        if self.side > 0.0 { ior } else { 1.0 / ior }
    }
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let side = if self.side > 0.0 { "outside" } else { "inside" };
        write!(
            f,
            "{}, roughness {}, from {side}",
            self.name, self.roughness
        )
    }
}

pub fn direction(degrees: f32, azimuth: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (y, x) = azimuth.to_radians().sin_cos();
    Vec3::new(sin * x, sin * y, cos)
}

fn color(r: f32, g: f32, b: f32) -> Texture {
    Texture::Constant(Rgb::new(r, g, b))
}

fn white() -> Texture {
    Texture::Constant(Rgb::ONE)
}

fn principled(edit: impl FnOnce(&mut Principled)) -> Surface {
    let mut principled = Principled::new(color(0.8, 0.5, 0.2));
    edit(&mut principled);
    Surface::Principled(Box::new(principled))
}

/// All kinds of surface of one roughness, and how much of light they may lose.
fn kinds(r: f32) -> Vec<(&'static str, Surface, f32)> {
    let brushed = Roughness {
        value: r.into(),
        anisotropy: 0.6.into(),
        rotation: 0.5.into(),
    };
    let glass = Surface::Dielectric {
        ior: 1.5,
        fresnel: Fresnel::Exact,
        roughness: r.into(),
        absorption: Rgb::ZERO,
    };
    let plastic = |color, roughness: f32| Surface::Plastic {
        color,
        ior: 1.5,
        roughness: roughness.into(),
    };
    let gold = Surface::Conductor {
        metal: Metal::named("gold").unwrap(),
        roughness: r.into(),
    };
    let glossy = |color, roughness| Surface::Glossy { color, roughness };
    vec![
        ("gold", gold.clone(), 1.0),
        ("white gloss", glossy(white(), r.into()), 0.01),
        (
            "brushed white gloss",
            glossy(white(), brushed.clone()),
            0.01,
        ),
        (
            "brushed gloss",
            glossy(color(0.9, 0.5, 0.1), brushed.clone()),
            1.0,
        ),
        ("glass", glass.clone(), 1.0),
        ("plastic", plastic(color(0.7, 0.3, 0.1), r), 1.0),
        ("white plastic", plastic(white(), r), 0.01),
        (
            "white plastic under a smooth coat",
            plastic(white(), 0.0),
            0.01,
        ),
        (
            "principled paint",
            principled(|p| p.roughness = r.into()),
            1.0,
        ),
        (
            "principled white paint",
            principled(|p| {
                p.roughness = r.into();
                p.base_color = white();
            }),
            0.01,
        ),
        (
            "principled metal under a smooth coat",
            principled(|p| {
                p.metallic = 1.0.into();
                p.roughness = brushed;
                p.clearcoat = 1.0.into();
            }),
            1.0,
        ),
        (
            "principled, all at once",
            principled(|p| {
                p.metallic = 0.3.into();
                p.roughness = r.into();
                p.specular_color = color(1.0, 2.0, 0.5);
                p.transmission = 0.4.into();
                p.clearcoat = 0.7.into();
                p.clearcoat_roughness = (0.5 * r).into();
                p.sheen_color = color(0.2, 0.5, 0.9);
                p.sheen_roughness = r.into();
                p.iridescence = 0.8.into();
            }),
            1.0,
        ),
        (
            "principled velvet",
            principled(|p| {
                p.base_color = white();
                p.sheen_color = white();
                p.sheen_roughness = r.into();
            }),
            1.0,
        ),
        (
            "principled soap",
            principled(|p| {
                p.base_color = white();
                p.roughness = r.into();
                p.iridescence = 1.0.into();
                p.iridescence_thickness = 500.0.into();
            }),
            1.0,
        ),
        (
            "principled glass",
            principled(|p| {
                p.roughness = r.into();
                p.transmission = 1.0.into();
                p.specular = 0.8.into();
                p.absorption = absorption(Rgb::splat(0.5), 1.0);
            }),
            1.0,
        ),
        (
            "principled smooth glass",
            principled(|p| {
                p.base_color = white();
                p.roughness = 0.0.into();
                p.transmission = 1.0.into();
            }),
            1e-5,
        ),
        (
            "principled sheet",
            principled(|p| {
                p.roughness = r.into();
                p.transmission = 0.9.into();
                p.thin = true;
            }),
            1.0,
        ),
        (
            "gold and plastic",
            Surface::Mix {
                a: Box::new(gold.clone()),
                b: Box::new(plastic(color(0.2, 0.3, 0.8), 0.0)),
                weight: 0.4.into(),
            },
            1.0,
        ),
        (
            "glass and gold by side",
            Surface::TwoSided {
                front: Box::new(glass),
                back: Box::new(gold),
            },
            1.0,
        ),
    ]
}

/// Those without roughness, and what does not lose light is said to lose at most rounding.
fn smooth_kinds() -> Vec<(&'static str, Surface, f32)> {
    let diffuse = |color| Surface::Diffuse { color };
    vec![
        ("white", diffuse(white()), 1e-5),
        ("red", diffuse(color(0.8, 0.1, 0.1)), 1.0),
        ("mirror", Surface::Mirror { color: white() }, 1e-5),
        ("clear glass", Surface::glass(1.5), 1e-5),
        ("window", Surface::ThinDielectric { ior: 1.5 }, 1e-5),
    ]
}

/// Every kind at every roughness, from outside and, where light goes through, from inside.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let rough = ROUGHNESSES.into_iter().map(|r| (r, kinds(r)));
    for (roughness, kinds) in rough.chain([(0.0, smooth_kinds())]) {
        for (name, surface, loss) in kinds {
            let sides: &[f32] = match surface.interior() {
                Some(_) => &[1.0, -1.0],
                None => &[1.0],
            };
            for &side in sides {
                cases.push(Case {
                    name,
                    surface: surface.clone(),
                    roughness,
                    side,
                    loss,
                });
            }
        }
    }
    cases
}

/// Canonical samples for drawing, independent of each other.
pub fn canonical(seed: u64, index: u32) -> (f32, Vec2) {
    let [pick, u, v, _] = Sampler::new(SamplerKind::Independent, seed, (0, 0), index).set(0);
    (pick, Vec2::new(u, v))
}

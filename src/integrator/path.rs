use glam::{DVec3, Vec2, Vec3};

use crate::accel::Hit;
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::math::Ray;
use crate::sampling::{Sampler, power_heuristic};
use crate::world::{Media, SurfacePoint, World};

use super::{CameraRay, Integrator, media};

/// Unidirectional path tracing: light sampling and BSDF sampling joined by multiple importance sampling.
///
/// The paths of a batch advance together, one bounce at a time: all their rays are intersected, all
/// surfaces shaded, all shadow rays tested.
#[derive(Clone, Copy, Debug)]
pub struct PathIntegrator {
    /// Most scattering events on a path; `None` is as good as unlimited, 65,536.
    pub max_depth: Option<u32>,
    /// Whether dim paths are ended at random, without bias.
    pub russian_roulette: bool,
}

/// Light that reaches the camera straight from its source or over mirrors and clear glass, sampled as
/// [`PathIntegrator`] does it: a path goes on as long as delta lobes send it on.
#[derive(Clone, Copy, Debug)]
pub struct DirectIntegrator {
    /// Most scattering events on a path.
    pub max_depth: u32,
}

/// Is shown what paths do, a batch at a time: their rays before they are traced, and the light they bring.
pub trait Probe {
    /// Rays whose closest hits are asked for; at depth 0 those of the camera.
    fn closest(&mut self, _depth: u32, _rays: &[Ray]) {}

    /// Rays from a surface to a light, asked whether anything lies between.
    fn shadow(&mut self, _rays: &[Ray]) {}

    /// Light that is added to the radiance of ray `index` of the batch, scattered `bounces` times on its way.
    fn light(&mut self, _index: usize, _bounces: u32, _strategy: Strategy, _light: Rgb) {}
}

/// Looks at nothing, at no cost.
impl Probe for () {}

/// How light was found. The weights of multiple importance sampling are in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// The camera sees the source itself.
    Emitted,
    /// A light was aimed at.
    Light,
    /// A direction drawn from a surface's BSDF, a mirror's too, led to the source.
    Bsdf,
}

/// Where even an unlimited path ends: between white walls or mirrors without a way out it never would.
const LONGEST: u32 = 1 << 16;

/// Paths whose throughput is below the inverse of this are ended in proportion. Of thresholds and first depths tried,
/// this one and the second scattering gave a diffuse box the least variance times rays: a tenth less than 1 and the
/// fourth.
const CAREFUL: f32 = 2.0;

/// What the integrators of this file have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tracer {
    /// Most scattering events on a path.
    pub(super) most: u32,
    russian_roulette: bool,
    /// Whether paths end after the first lobe that is no delta.
    direct: bool,
}

/// A path under way.
struct Path {
    /// Index in the batch.
    index: usize,
    sampler: Sampler,
    /// Throughput.
    beta: Rgb,
    /// What refraction did to `beta` by spreading light, taken out: Russian roulette must not see it.
    eta2: f32,
    /// Where the last scattering happened and its density; infinite after a delta lobe or the camera.
    from: DVec3,
    pdf: f32,
    media: Media,
}

/// Light that arrives at the pixel sample `index` if nothing is in the way.
struct Shadowed {
    index: usize,
    light: Rgb,
}

impl Integrator for PathIntegrator {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        self.radiance_probed(world, batch, radiance, &mut ())
    }
}

impl PathIntegrator {
    /// [`Integrator::radiance`] with a look at everything.
    pub fn radiance_probed(
        &self,
        world: &World,
        batch: &[CameraRay],
        radiance: &mut [Rgb],
        probe: &mut impl Probe,
    ) -> u64 {
        Tracer::from(*self).trace(world, batch, radiance, probe)
    }
}

impl Integrator for DirectIntegrator {
    fn radiance(&self, world: &World, batch: &[CameraRay], radiance: &mut [Rgb]) -> u64 {
        Tracer::from(*self).trace(world, batch, radiance, &mut ())
    }
}

impl From<PathIntegrator> for Tracer {
    fn from(path: PathIntegrator) -> Self {
        Self {
            most: path.max_depth.unwrap_or(LONGEST).min(LONGEST),
            russian_roulette: path.russian_roulette,
            direct: false,
        }
    }
}

impl From<DirectIntegrator> for Tracer {
    fn from(direct: DirectIntegrator) -> Self {
        Self {
            most: direct.max_depth.min(LONGEST),
            russian_roulette: false,
            direct: true,
        }
    }
}

/// Takes the light that paths bring.
struct Sink<'a, P> {
    radiance: &'a mut [Rgb],
    probe: &'a mut P,
}

impl<P: Probe> Sink<'_, P> {
    fn add(&mut self, index: usize, bounces: u32, strategy: Strategy, light: Rgb) {
        self.radiance[index] += light;
        self.probe.light(index, bounces, strategy, light);
    }
}

impl Tracer {
    pub(super) fn trace(
        self,
        world: &World,
        batch: &[CameraRay],
        radiance: &mut [Rgb],
        probe: &mut impl Probe,
    ) -> u64 {
        radiance.fill(Rgb::ZERO);
        let mut sink = Sink { radiance, probe };
        let mut paths: Vec<Path> = (batch.iter().zip(media(world, batch)).enumerate())
            .map(|(index, (camera, media))| Path {
                index,
                sampler: camera.sampler,
                beta: Rgb::ONE,
                eta2: 1.0,
                from: camera.ray.origin,
                pdf: f32::INFINITY,
                media,
            })
            .collect();
        let mut rays: Vec<Ray> = batch.iter().map(|camera| camera.ray).collect();
        let mut hits = vec![None; rays.len()];
        let mut shadows: Vec<Shadowed> = Vec::new();
        let mut shadow_rays: Vec<Ray> = Vec::new();
        let mut blocked = vec![false; rays.len()];
        let mut traced = 0;
        for depth in 0..=self.most {
            let found = match depth {
                0 => Strategy::Emitted,
                _ => Strategy::Bsdf,
            };
            traced += rays.len() as u64;
            sink.probe.closest(depth, &rays);
            world.intersect_batch(&rays, &mut hits[..rays.len()]);
            let mut alive = 0;
            for i in 0..rays.len() {
                world.fetch_ahead(&hits[i..rays.len()]);
                let index = paths[i].index;
                let distance = hits[i].map_or(f64::INFINITY, |hit| hit.t);
                let left = paths[i].media.transmittance(distance);
                paths[i].beta *= left;
                let Some(hit) = hits[i] else {
                    let light = beyond(world, &paths[i], &rays[i]);
                    sink.add(index, depth, found, light);
                    continue;
                };
                let point = world.surface(&rays[i], &hit);
                let light = emitted(world, &paths[i], &hit, &point);
                sink.add(index, depth, found, light);
                if depth >= self.most || (self.direct && paths[i].pdf.is_finite()) {
                    continue;
                }
                let wo = -rays[i].direction.as_vec3();
                let bsdf = world.bsdf(&point, &paths[i].media);
                let [onward, aim] = paths[i].sampler.sets(2 * depth + 1);
                if bsdf.is_smooth()
                    && let Some((ray, light)) = direct(world, &paths[i], &point, &bsdf, wo, aim)
                {
                    let light = paths[i].beta * light;
                    shadows.push(Shadowed { index, light });
                    shadow_rays.push(ray);
                }
                if let Some(ray) = self.scatter(&mut paths[i], &point, &bsdf, wo, onward, depth) {
                    let wi = ray.direction.as_vec3();
                    paths[i].media.follow(&point, world.material(&point), wi);
                    paths.swap(alive, i);
                    rays[alive] = ray;
                    alive += 1;
                }
            }
            paths.truncate(alive);
            rays.truncate(alive);
            traced += shadows.len() as u64;
            let blocked = &mut blocked[..shadows.len()];
            sink.probe.shadow(&shadow_rays);
            world.occluded_batch(&shadow_rays, blocked);
            shadow_rays.clear();
            for (shadow, blocked) in shadows.drain(..).zip(blocked) {
                if !*blocked {
                    sink.add(shadow.index, depth + 1, Strategy::Light, shadow.light);
                }
            }
            if paths.is_empty() {
                break;
            }
        }
        traced
    }
}

/// What the surface sends back along the path by itself, weighted against light sampling.
fn emitted(world: &World, path: &Path, hit: &Hit, point: &SurfacePoint) -> Rgb {
    let emission = world.material(point).emitted(&point.texture);
    if emission == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let weight = if path.pdf.is_infinite() {
        1.0
    } else {
        power_heuristic(path.pdf, world.light_pdf(path.from, hit, point.p))
    };
    path.beta * emission * weight
}

/// What a ray that meets nothing brings, weighted against light sampling where that aims at it.
fn beyond(world: &World, path: &Path, ray: &Ray) -> Rgb {
    // An infinite density outweighs any other.
    path.beta * world.beyond(ray.direction, |other| power_heuristic(path.pdf, other))
}

/// Light sampled towards one light: the shadow ray, and what it brings if it is free.
fn direct(
    world: &World,
    path: &Path,
    point: &SurfacePoint,
    bsdf: &Bsdf,
    wo: Vec3,
    [u, v, pick, _]: [f32; 4],
) -> Option<(Ray, Rgb)> {
    let sample = world.sample_light(point.p, pick, Vec2::new(u, v))?;
    let (wi, distance) = sample.source.seen_from(point.p)?;
    let (f_cos, pdf) = bsdf.eval(wo, wi);
    if f_cos == Rgb::ZERO {
        return None;
    }
    let weight = power_heuristic(sample.pdf, pdf) / sample.divisor();
    let left = (path.media).towards(point, world.material(point), wi, distance);
    let light = f_cos * sample.li * weight * left;
    (light != Rgb::ZERO).then(|| (point.towards(sample.source), light))
}

impl Tracer {
    /// Draws the path's next direction; `None` where it ends.
    fn scatter(
        self,
        path: &mut Path,
        point: &SurfacePoint,
        bsdf: &Bsdf,
        wo: Vec3,
        [u, v, pick, survive]: [f32; 4],
        depth: u32,
    ) -> Option<Ray> {
        let sample = bsdf.sample(wo, pick, Vec2::new(u, v))?;
        path.beta *= sample.weight;
        path.eta2 *= sample.eta2;
        if self.russian_roulette && depth > 0 {
            let chance = (CAREFUL * (path.beta * path.eta2).max_element()).min(1.0);
            if survive >= chance {
                return None;
            }
            path.beta /= chance;
        }
        path.from = point.p;
        path.pdf = sample.pdf;
        (path.beta != Rgb::ZERO).then(|| point.spawn(sample.wi))
    }
}

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

/// Is shown the rays of paths before they are traced, a batch at a time.
pub trait Probe {
    /// Rays whose closest hits are asked for; at depth 0 those of the camera.
    fn closest(&mut self, depth: u32, rays: &[Ray]);

    /// Rays from a surface to a light, asked whether anything lies between.
    fn shadow(&mut self, rays: &[Ray]);
}

/// Looks at nothing, at no cost.
impl Probe for () {
    fn closest(&mut self, _depth: u32, _rays: &[Ray]) {}

    fn shadow(&mut self, _rays: &[Ray]) {}
}

/// Where even an unlimited path ends: between white walls or mirrors without a way out it never would.
const LONGEST: u32 = 1 << 16;

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
    /// [`Integrator::radiance`] with a look at every ray.
    pub fn radiance_probed(
        &self,
        world: &World,
        batch: &[CameraRay],
        radiance: &mut [Rgb],
        probe: &mut impl Probe,
    ) -> u64 {
        radiance.fill(Rgb::ZERO);
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
        let most = self.max_depth.unwrap_or(LONGEST).min(LONGEST);
        for depth in 0..=most {
            traced += rays.len() as u64;
            probe.closest(depth, &rays);
            world.intersect_batch(&rays, &mut hits[..rays.len()]);
            let mut alive = 0;
            for i in 0..rays.len() {
                let index = paths[i].index;
                let distance = hits[i].map_or(f64::INFINITY, |hit| hit.t);
                let left = paths[i].media.transmittance(distance);
                paths[i].beta *= left;
                let Some(hit) = hits[i] else {
                    radiance[index] += paths[i].beta * world.scene().environment;
                    continue;
                };
                let point = world.surface(&rays[i], &hit);
                radiance[index] += emitted(world, &paths[i], &hit, &point);
                if depth >= most {
                    continue;
                }
                let wo = -rays[i].direction.as_vec3();
                let bsdf = world.bsdf(&point, &paths[i].media);
                let [pick, u, v, _] = paths[i].sampler.set(2 * depth + 2);
                if bsdf.is_smooth()
                    && let Some((ray, light)) =
                        direct(world, &paths[i], &point, &bsdf, wo, pick, Vec2::new(u, v))
                {
                    let light = paths[i].beta * light;
                    shadows.push(Shadowed { index, light });
                    shadow_rays.push(ray);
                }
                if let Some(ray) = self.scatter(&mut paths[i], &point, &bsdf, wo, depth) {
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
            probe.shadow(&shadow_rays);
            world.occluded_batch(&shadow_rays, blocked);
            shadow_rays.clear();
            for (shadow, blocked) in shadows.drain(..).zip(blocked) {
                if !*blocked {
                    radiance[shadow.index] += shadow.light;
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

/// Light sampled towards one light: the shadow ray, and what it brings if it is free.
fn direct(
    world: &World,
    path: &Path,
    point: &SurfacePoint,
    bsdf: &Bsdf,
    wo: Vec3,
    pick: f32,
    u2: Vec2,
) -> Option<(Ray, Rgb)> {
    let sample = world.sample_light(point.p, pick, u2)?;
    let wi = (sample.p - point.p).as_vec3().try_normalize()?;
    let (f_cos, pdf) = bsdf.eval(wo, wi);
    if f_cos == Rgb::ZERO {
        return None;
    }
    let weight = power_heuristic(sample.pdf, pdf) / sample.divisor();
    let distance = sample.p.distance(point.p);
    let left = (path.media).towards(point, world.material(point), wi, distance);
    let light = f_cos * sample.li * weight * left;
    (light != Rgb::ZERO).then(|| (point.towards(sample.p), light))
}

impl PathIntegrator {
    /// Draws the path's next direction; `None` where it ends.
    fn scatter(
        &self,
        path: &mut Path,
        point: &SurfacePoint,
        bsdf: &Bsdf,
        wo: Vec3,
        depth: u32,
    ) -> Option<Ray> {
        let [pick, u, v, survive] = path.sampler.set(2 * depth + 1);
        let sample = bsdf.sample(wo, pick, Vec2::new(u, v))?;
        path.beta *= sample.weight;
        path.eta2 *= sample.eta2;
        if self.russian_roulette && depth >= 3 {
            let chance = (path.beta * path.eta2).max_element().min(1.0);
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

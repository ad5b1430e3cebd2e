//! A look at the path tracer's rays.

use glam::{DVec3, Vec2};
use solidtrace::color::Rgb;
use solidtrace::geometry::Solid;
use solidtrace::integrator::{CameraRay, Integrator, PathIntegrator, Probe};
use solidtrace::math::Ray;
use solidtrace::sampling::{Sampler, SamplerKind};

use crate::support::{Build, diffuse, empty_scene};

#[derive(Default)]
struct Seen {
    closest: Vec<(u32, Vec<Ray>)>,
    shadows: Vec<Ray>,
}

impl Probe for Seen {
    fn closest(&mut self, depth: u32, rays: &[Ray]) {
        self.closest.push((depth, rays.to_vec()));
    }

    fn shadow(&mut self, rays: &[Ray]) {
        self.shadows.extend_from_slice(rays);
    }
}

#[test]
fn the_probe_sees_every_ray_and_changes_nothing() {
    let mut scene = empty_scene();
    let white = scene.material(diffuse(0.8), 0.0);
    scene
        .solid(
            Solid::Sphere { radius: 1.0 },
            white,
            DVec3::new(0., 0., -4.),
        )
        .solid(Solid::Sphere { radius: 9.0 }, white, DVec3::ZERO)
        .point_light(DVec3::new(2.0, 2.0, 0.0), 5.0);
    let world = scene.world();
    let lens = world.scene().cameras[0].lens((8, 8)).unwrap();
    let batch: Vec<CameraRay> = (0..64)
        .map(|i| CameraRay {
            ray: lens.ray(f64::from(i % 8), f64::from(i / 8), Vec2::ZERO),
            sampler: Sampler::new(SamplerKind::Sobol, 0, (i % 8, i / 8), 0),
        })
        .collect();
    let path = PathIntegrator {
        max_depth: Some(3),
        russian_roulette: false,
    };
    let (mut plain, mut probed) = (vec![Rgb::ZERO; 64], vec![Rgb::ZERO; 64]);
    let mut seen = Seen::default();
    let traced = path.radiance(&world, &batch, &mut plain);
    assert_eq!(
        path.radiance_probed(&world, &batch, &mut probed, &mut seen),
        traced
    );
    assert_eq!(plain, probed);
    let depths: Vec<u32> = seen.closest.iter().map(|(depth, _)| *depth).collect();
    assert_eq!(depths, [0, 1, 2, 3]);
    let camera: Vec<Ray> = batch.iter().map(|camera| camera.ray).collect();
    assert_eq!(seen.closest[0].1, camera);
    let closest: usize = seen.closest.iter().map(|(_, rays)| rays.len()).sum();
    assert_eq!((closest + seen.shadows.len()) as u64, traced);
    // All end at the only light.
    assert!(seen.shadows.len() > 100);
    for ray in &seen.shadows {
        assert!(ray.at(ray.tmax).distance(DVec3::new(2.0, 2.0, 0.0)) < 1e-5);
    }
}

//! Scenes whose radiance is known everywhere: nothing may be lost or won.

use glam::{DVec3, Vec3};
use solidtrace::color::Rgb;
use solidtrace::geometry::{Mesh, Solid};
use solidtrace::material::{Fresnel, Surface};
use solidtrace::scene::{IntegratorSettings, Scene};
use solidtrace::texture::{Pattern, Ramp, Texture};

use crate::support::meshes::{box_mesh, sphere_mesh};
use crate::support::{
    Build, SAMPLERS, Shot, camera, dielectric, diffuse, empty_scene, shoot, statistics,
};

const TOLERANCE: f32 = 0.005;

fn assert_one(scene: Scene, what: &str) {
    assert_radiance(scene, what, 1.0 - TOLERANCE);
}

/// Every pixel is 1 within the tolerance, or at least `least`.
fn assert_radiance(scene: Scene, what: &str, least: f32) {
    let spp = 1024;
    let world = scene.world();
    for sampler in SAMPLERS {
        for (i, pixel) in shoot(
            &world,
            Shot {
                spp,
                sampler,
                seed: 1,
            },
        )
        .iter()
        .enumerate()
        {
            assert!(
                pixel.min_element() >= least && pixel.max_element() <= 1.0 + TOLERANCE,
                "{what}, {sampler:?}: pixel {i} is {pixel}"
            );
        }
    }
}

fn materials() -> Vec<(&'static str, Surface)> {
    let white = || Texture::Constant(Rgb::ONE);
    let mut all = vec![
        ("diffuse", Surface::Diffuse { color: white() }),
        ("mirror", Surface::Mirror { color: white() }),
        (
            "checker",
            Surface::Diffuse {
                color: Texture::Pattern {
                    pattern: Pattern::Checker { step: 0.3 },
                    colors: Ramp::between(Rgb::ONE, Rgb::ONE),
                },
            },
        ),
    ];
    for (name, fresnel) in [
        ("glass", Fresnel::Exact),
        ("glass by Schlick", Fresnel::Schlick),
        ("glass without Fresnel", Fresnel::None),
    ] {
        all.push((name, dielectric(1.5, fresnel)));
    }
    all
}

/// The unit sphere as a coarse mesh whose shading normals are far from its faces'.
fn smooth_sphere() -> Mesh {
    let mut mesh = sphere_mesh(8, |_| 1.0);
    mesh.normals = mesh.positions.clone();
    mesh
}

#[test]
fn white_solids_vanish_in_a_white_environment() {
    let solids = [
        Solid::Sphere { radius: 1.0 },
        Solid::Box {
            half: DVec3::new(0.9, 0.7, 0.8),
        },
        Solid::Cylinder {
            radius: 0.7,
            height: 1.2,
        },
        Solid::Cone {
            from_radius: 0.9,
            to_radius: 0.2,
            height: 1.3,
        },
        Solid::Torus {
            major: 0.8,
            minor: 0.3,
        },
    ];
    for (name, surface) in materials() {
        for solid in solids {
            let mut scene = empty_scene();
            scene.environment = Rgb::ONE;
            scene.cameras = vec![camera(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO)];
            let material = scene.material(surface.clone(), 0.0);
            scene.solid(solid, material, DVec3::ZERO);
            assert_one(scene, &format!("{name} {solid:?}"));
        }
    }
}

#[test]
fn white_meshes_vanish_in_a_white_environment() {
    for (name, surface) in materials() {
        for (form, mesh) in [
            ("box", box_mesh(Vec3::splat(-0.8), Vec3::splat(0.7))),
            ("smooth sphere", smooth_sphere()),
        ] {
            let mut scene = empty_scene();
            scene.environment = Rgb::ONE;
            scene.cameras = vec![camera(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO)];
            let material = scene.material(surface.clone(), 0.0);
            scene.mesh(mesh, material);
            // Normals that are bent far can keep light inside of glass for good; none may be won.
            let bent_glass = form != "box" && name.starts_with("glass");
            let least = if bent_glass { 0.95 } else { 1.0 - TOLERANCE };
            assert_radiance(scene, &format!("{name} {form}"), least);
        }
    }
}

#[test]
fn radiance_inside_glass_is_the_index_squared_as_high() {
    for fresnel in [Fresnel::Exact, Fresnel::Schlick, Fresnel::None] {
        let mut scene = empty_scene();
        scene.environment = Rgb::ONE;
        let glass = scene.material(dielectric(1.5, fresnel), 0.0);
        // From the centre every ray meets the surface head-on, so nothing is trapped.
        scene.solid(Solid::Sphere { radius: 1.0 }, glass, DVec3::ZERO);
        let shot = Shot {
            spp: 16,
            sampler: SAMPLERS[0],
            seed: 0,
        };
        for pixel in shoot(&scene.world(), shot) {
            assert!(
                (pixel - 2.25).abs().max_element() < 1e-5,
                "{fresnel:?}: {pixel}"
            );
        }
    }
}

/// A closed box whose walls emit 0.5 and reflect half: 0.5 + 0.25 + ... = 1 everywhere inside.
fn glowing_box(analytic: bool) -> Scene {
    let mut scene = empty_scene();
    let eye = DVec3::new(0.1, -0.2, 0.3);
    scene.cameras = vec![camera(eye, DVec3::new(0.6, 0.3, -0.9))];
    let wall = scene.material(diffuse(0.5), 0.5);
    if analytic {
        scene.solid(Solid::Box { half: DVec3::ONE }, wall, DVec3::ZERO);
    } else {
        scene.mesh(box_mesh(Vec3::NEG_ONE, Vec3::ONE), wall);
    }
    scene
}

#[test]
fn a_glowing_box_has_radiance_one_inside() {
    assert_one(glowing_box(true), "box solid");
}

#[test]
fn a_glowing_box_of_triangles_has_radiance_one_inside_up_to_the_noise_of_light_sampling() {
    let world = glowing_box(false).world();
    for sampler in SAMPLERS {
        let shot = Shot {
            spp: 1024,
            sampler,
            seed: 1,
        };
        let pixels = shoot(&world, shot);
        // Drawing the walls by area instead of by cosine costs a deviation of about 0.1 a sample, 0.3 % a pixel.
        let values: Vec<f64> = pixels.iter().map(|p| f64::from(p.x)).collect();
        let (mean, deviation) = statistics(&values);
        println!("{sampler:?}: {mean} ± {deviation}");
        assert!((mean - 1.0).abs() < 0.001, "{sampler:?}: {mean}");
        assert!(deviation < 0.004, "{sampler:?}: {deviation}");
    }
}

#[test]
fn the_depth_limit_cuts_the_series_where_it_says() {
    for depth in [0, 1, 2, 5] {
        let mut scene = glowing_box(true);
        scene.integrator = IntegratorSettings::Path {
            max_depth: Some(depth),
            russian_roulette: false,
        };
        let expected = 1.0 - 0.5_f32.powi(depth as i32 + 1);
        for pixel in shoot(
            &scene.world(),
            Shot {
                spp: 4,
                sampler: SAMPLERS[0],
                seed: 0,
            },
        ) {
            assert!((pixel.x - expected).abs() < 1e-5, "depth {depth}: {pixel}");
        }
    }
}

#[test]
fn russian_roulette_does_not_change_the_mean() {
    let mut scene = glowing_box(true);
    scene.film.size = (16, 16);
    scene.integrator = IntegratorSettings::Path {
        max_depth: None,
        russian_roulette: true,
    };
    let pixels = shoot(
        &scene.world(),
        Shot {
            spp: 1024,
            sampler: SAMPLERS[1],
            seed: 3,
        },
    );
    let mean = pixels.iter().map(|p| f64::from(p.x)).sum::<f64>() / pixels.len() as f64;
    // A sample's deviation is below 0.25 here, so the mean of 2^18 deviates by less than 0.0005.
    assert!((mean - 1.0).abs() < 0.002, "{mean}");
    assert!(pixels.iter().any(|p| p.x != 1.0), "roulette was played");
}

//! Surfaces in scenes: as files write them, and as light meets them.

use glam::{DVec3, Vec3};
use solidtrace::camera::Projection;
use solidtrace::color::Rgb;
use solidtrace::geometry::Solid;
use solidtrace::material::{Fresnel, Metal, Principled, Roughness, Surface, absorption};
use solidtrace::scene::description::{SurfaceDescription, TextureDescription};
use solidtrace::scene::{IntegratorSettings, Scene, SceneDescription};
use solidtrace::texture::{Pattern, Ramp, Texture};

use crate::support::meshes::sphere_mesh;
use crate::support::{Build, SAMPLERS, Shot, camera, diffuse, empty_scene, shoot};

const CAMERA: &str = "camera: Perspective(eye: (0, 0, 5), look_at: (0, 0, 0), vfov: 40)";

/// The last of some materials.
fn read(materials: &str) -> SurfaceDescription {
    let text = format!("({CAMERA}, objects: [], materials: {{{materials}}})");
    let description = SceneDescription::from_text("a.ron", &text);
    let mut description = description.unwrap_or_else(|e| panic!("{materials}: {e}"));
    description.materials.pop().unwrap().surface
}

fn fails(materials: &str, parts: &[&str]) {
    let text = format!("({CAMERA}, objects: [], materials: {{{materials}}})");
    let at = text.find('«').expect("a mark where the error is");
    let error = SceneDescription::from_text("a.ron", &text.replacen('«', "", 1)).unwrap_err();
    let column = text[..at].chars().count() + 1;
    assert_eq!(error.place().unwrap().column, Some(column), "{error}");
    for part in parts {
        assert!(error.to_string().contains(part), "no `{part}` in: {error}");
    }
}

fn grey(x: f32) -> TextureDescription {
    TextureDescription::Constant(Rgb::splat(x))
}

#[test]
fn surfaces_are_as_written() {
    let gold = Surface::Conductor {
        metal: Metal::named("gold").unwrap(),
        roughness: 0.25.into(),
    };
    assert_eq!(
        read("\"a\": Conductor(metal: \"gold\", roughness: 0.25)"),
        gold
    );
    let brushed = Surface::Conductor {
        metal: Metal::new(Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, 5.0, 6.0)),
        roughness: Roughness {
            value: 0.5.into(),
            anisotropy: 0.75.into(),
            rotation: std::f32::consts::FRAC_PI_2.into(),
        },
    };
    let text = "\"a\": Conductor(eta: (1, 2, 3), k: (4, 5, 6), roughness: 0.5, anisotropy: 0.75, anisotropy_rotation: 90)";
    assert_eq!(read(text), brushed);
    let frosted = Surface::Dielectric {
        ior: 1.5,
        fresnel: Fresnel::Exact,
        roughness: 0.5.into(),
        absorption: Rgb::new(0.0, 2_f32.ln() / 2.0, 4_f32.ln() / 2.0),
    };
    let text = "\"a\": Dielectric(ior: 1.5, roughness: 0.5, attenuation_color: (1, 0.5, 0.25), attenuation_distance: 2)";
    assert_eq!(read(text), frosted);
    assert_eq!(
        read("\"a\": ThinDielectric()"),
        Surface::ThinDielectric { ior: 1.5 }
    );
    let gloss = Surface::Glossy {
        color: grey(0.5),
        roughness: 0.3.into(),
    };
    assert_eq!(read("\"a\": Glossy(color: (0.5, 0.5, 0.5))"), gloss);
    let plastic = Surface::Plastic {
        color: grey(0.25),
        ior: 1.25,
        roughness: 0.0.into(),
    };
    assert_eq!(
        read("\"a\": Plastic(color: (0.25, 0.25, 0.25), ior: 1.25)"),
        plastic
    );
    let Surface::Principled(plain) = read("\"a\": Principled()") else {
        panic!("not principled");
    };
    let default = Principled::new(grey(1.0));
    let half = Principled {
        roughness: 0.5.into(),
        ..default
    };
    assert_eq!(*plain, half);
    let text = "\"a\": Principled(base_color: (0.5, 0.5, 0.5), metallic: 0.125, roughness: 0.25, anisotropy: 0.5, ior: 2, specular: 0.75, \
        specular_color: (0.1, 0.1, 0.1), transmission: 0.625, thin: true, attenuation_color: (0.5, 0.5, 0.5), clearcoat: 0.3, \
        clearcoat_roughness: 0.4, sheen_color: (0.2, 0.2, 0.2), sheen_roughness: 0.6, iridescence: 0.7, iridescence_ior: 1.75, \
        iridescence_thickness: 300)";
    let Surface::Principled(full) = read(text) else {
        panic!("not principled");
    };
    let expected = Principled {
        base_color: grey(0.5),
        metallic: 0.125.into(),
        roughness: Roughness {
            value: 0.25.into(),
            anisotropy: 0.5.into(),
            rotation: 0.0.into(),
        },
        ior: 2.0,
        specular: 0.75.into(),
        specular_color: grey(0.1),
        transmission: 0.625.into(),
        thin: true,
        absorption: Rgb::splat(2_f32.ln()),
        clearcoat: 0.3.into(),
        clearcoat_roughness: 0.4.into(),
        sheen_color: grey(0.2),
        sheen_roughness: 0.6.into(),
        iridescence: 0.7.into(),
        iridescence_ior: 1.75,
        iridescence_thickness: 300.0.into(),
    };
    assert_eq!(*full, expected);
}

#[test]
fn numbers_are_textures_too() {
    let checker = |a: f32, b: f32| TextureDescription::Pattern {
        pattern: Pattern::Checker { step: 2.0 },
        colors: Ramp::between(Rgb::splat(a), Rgb::splat(b)),
    };
    let scaled = |by: f32| TextureDescription::Scale {
        of: Box::new(checker(1.0, 0.0)),
        by: Rgb::splat(by),
    };
    let text = "\"a\": Principled(metallic: Checker(step: 2, a: 0.5, b: 0.25), roughness: Channel(of: Checker(step: 2), channel: Green), \
        anisotropy_rotation: Checker(step: 2), iridescence_thickness: Checker(step: 2))";
    let expected = Principled {
        metallic: checker(0.5, 0.25),
        roughness: Roughness {
            value: TextureDescription::Channel {
                of: Box::new(checker(1.0, 0.0)),
                by: Rgb::Y,
            },
            anisotropy: 0.0.into(),
            // A full turn, and a micrometre.
            rotation: scaled(std::f32::consts::TAU),
        },
        iridescence_thickness: scaled(1000.0),
        ..Principled::new(1.0.into())
    };
    assert_eq!(read(text), Surface::Principled(Box::new(expected)));
    fails(
        "\"a\": Mirror(color: Channel(of: 1, channel: «Grey))",
        &["`Grey` is not a channel", "Red, Green, Blue"],
    );
}

#[test]
fn parts_are_written_out_or_named_wherever_they_stand() {
    let mirror = || Box::new(Surface::Mirror { color: grey(1.0) });
    let dull = || Box::new(Surface::Diffuse { color: grey(0.5) });
    let mix = Surface::Mix {
        a: mirror(),
        b: dull(),
        weight: 0.25.into(),
    };
    let sides = Surface::TwoSided {
        front: Box::new(mix.clone()),
        back: mirror(),
    };
    let text =
        "\"m\": Mirror(), \"mix\": Mix(a: \"m\", b: Diffuse(color: (0.5, 0.5, 0.5)), weight: 0.25)";
    assert_eq!(read(text), mix);
    let last = format!("{text}, \"sides\": TwoSided(front: \"mix\", back: \"m\")");
    assert_eq!(read(&last), sides);
    // Before what they name, too.
    let first = format!("\"sides\": TwoSided(front: \"mix\", back: \"m\"), {text}");
    let text = format!("({CAMERA}, objects: [], materials: {{{first}}})");
    let description = SceneDescription::from_text("a.ron", &text).unwrap();
    assert_eq!(description.materials[0].surface, sides);
    let json = r#"{"camera": {"Perspective": {"eye": [0, 0, 5], "look_at": [0, 0, 0], "vfov": 40}}, "objects": [],
        "materials": {"m": {"Mirror": {}}, "x": {"Mix": {"a": "m", "b": {"Diffuse": {"color": [0.5, 0.5, 0.5]}}, "weight": 0.25}}}}"#;
    let description = SceneDescription::from_text("a.json", json).unwrap();
    assert_eq!(description.materials[1].surface, mix);
}

#[test]
fn what_is_wrong_with_a_surface_is_said_where_it_is() {
    fails(
        "\"a\": Conductor(metal: «\"cheese\")",
        &[
            "`\"cheese\"` is not a metal",
            "gold, silver, copper",
            "titanium",
            "`eta` and `k`",
        ],
    );
    fails("\"a\": «Conductor()", &["`metal`", "`eta` and `k`"]);
    fails(
        "\"a\": «Conductor(metal: \"gold\", eta: (1, 1, 1))",
        &["either"],
    );
    fails("\"a\": «Conductor(eta: (1, 1, 1))", &["either"]);
    fails(
        "\"a\": Conductor(eta: (1, «-1, 1), k: (1, 1, 1))",
        &["`-1`", "0..=100"],
    );
    fails(
        "\"a\": Conductor(metal: \"gold\", roughness: «2)",
        &["`2`", "0..=1", "`roughness` of `Conductor`"],
    );
    fails(
        "\"a\": Glossy(color: (1, 1, 1), anisotropy: «-0.5)",
        &["`-0.5`", "0..=1"],
    );
    fails(
        "\"a\": Plastic(color: (1, 1, 1), ior: «5)",
        &["`5`", "1..=3"],
    );
    fails("\"a\": ThinDielectric(ior: «0.5)", &["`0.5`"]);
    fails(
        "\"a\": Dielectric(ior: 1.5, attenuation_distance: «0)",
        &["`0`", "above 0"],
    );
    fails(
        "\"a\": Principled(«basecolor: (1, 1, 1))",
        &["did you mean `base_color`?"],
    );
    fails(
        "\"a\": Principled(metallic: «1.5)",
        &["`1.5`", "`metallic` of `Principled`"],
    );
    fails("\"a\": «Principle()", &["did you mean `Principled`?"]);
    fails(
        "\"gold\": Mirror(), \"a\": Mix(a: «\"gald\", b: \"gold\")",
        &["no material `gald`", "did you mean `gold`?"],
    );
    fails(
        "\"gold\": Mirror(), \"a\": «Mix(a: \"gold\")",
        &["`b`", "missing"],
    );
    fails(
        "\"lamp\": Emissive(radiance: (1, 1, 1)), \"a\": TwoSided(front: «\"lamp\", back: Mirror())",
        &["emits light"],
    );
    fails(
        "\"a\": TwoSided(front: Mirror(), back: «Mirror(bump: (texture: Noise(), height: 1)))",
        &["bump", "the whole can have one"],
    );
    fails(
        "\"m\": Mirror(), \"a\": Mix(a: «\"a\", b: \"m\")",
        &["inside one another", "made of itself"],
    );
}

/// What every pixel of a scene is, on average over independent runs.
fn pixels(scene: Scene, spp: u32) -> Vec<Rgb> {
    let shot = Shot {
        spp,
        sampler: SAMPLERS[0],
        seed: 5,
    };
    shoot(&scene.world(), shot)
}

#[test]
fn white_balls_vanish_in_a_white_environment_rough_or_coated_or_brushed() {
    let white = || Texture::Constant(Rgb::ONE);
    let principled = |edit: fn(&mut Principled)| {
        let mut principled = Principled::new(white());
        edit(&mut principled);
        Surface::Principled(Box::new(principled))
    };
    let glossy = |value: f32, anisotropy: f32| Surface::Glossy {
        color: white(),
        roughness: Roughness {
            value: value.into(),
            anisotropy: anisotropy.into(),
            rotation: 0.4.into(),
        },
    };
    let plastic = |roughness: f32| Surface::Plastic {
        color: white(),
        ior: 1.5,
        roughness: roughness.into(),
    };
    let surfaces = [
        ("gloss", glossy(0.5, 0.0)),
        ("brushed gloss", glossy(0.4, 0.6)),
        ("plastic", plastic(0.0)),
        ("rough plastic", plastic(0.6)),
        ("paint", principled(|p| p.roughness = 0.4.into())),
        (
            "metal",
            principled(|p| {
                p.metallic = 1.0.into();
                p.roughness = 0.7.into();
            }),
        ),
        ("bubble", Surface::ThinDielectric { ior: 1.5 }),
        (
            "principled glass",
            principled(|p| {
                p.transmission = 1.0.into();
                p.roughness = 0.0.into();
            }),
        ),
    ];
    for (name, surface) in surfaces {
        for bent in [false, true] {
            // Under normals bent far glass can keep light for good.
            if bent && name.contains("glass") {
                continue;
            }
            let mut scene = empty_scene();
            scene.environment = Rgb::ONE;
            scene.cameras = vec![camera(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO)];
            let material = scene.material(surface.clone(), 0.0);
            if bent {
                let mut mesh = sphere_mesh(8, |_| 1.0);
                mesh.normals = mesh.positions.clone();
                scene.mesh(mesh, material);
            } else {
                scene.solid(Solid::Sphere { radius: 1.0 }, material, DVec3::ZERO);
            }
            for (i, pixel) in pixels(scene, 1024).iter().enumerate() {
                let error = (*pixel - 1.0).abs().max_element();
                assert!(error < 0.015, "{name}, bent {bent}: pixel {i} is {pixel}");
            }
        }
    }
}

/// A ball of radius 1 that absorbs, and bends light not at all.
fn absorbing(sigma: Rgb) -> Surface {
    Surface::Dielectric {
        ior: 1.0,
        fresnel: Fresnel::Exact,
        roughness: 0.0.into(),
        absorption: sigma,
    }
}

#[test]
fn light_dies_away_in_an_absorbing_ball_as_beer_says() {
    let sigma = absorption(Rgb::new(1.0, 0.5, 0.1), 1.0);
    for integrator in [empty_scene().integrator, IntegratorSettings::whitted()] {
        let mut scene = empty_scene();
        scene.integrator = integrator;
        scene.environment = Rgb::ONE;
        let mut eye = camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO);
        eye.projection = Projection::pinhole(1_f64.to_radians());
        scene.cameras = vec![eye];
        let ball = scene.material(absorbing(sigma), 0.0);
        scene.solid(Solid::Sphere { radius: 1.0 }, ball, DVec3::ZERO);
        for pixel in pixels(scene, 4) {
            // Two metres through the middle: nothing is lost of red.
            assert!(
                (pixel - Rgb::new(1.0, 0.25, 0.01)).length() < 5e-3,
                "{pixel}"
            );
        }
    }
}

#[test]
fn light_that_is_aimed_at_is_attenuated_on_its_way_too() {
    let sigma = Rgb::new(0.0, 0.5, 1.0);
    let mut scene = empty_scene();
    scene.cameras = vec![camera(DVec3::new(0.0, 2.0, 0.0), DVec3::ZERO)];
    scene.cameras[0].projection = Projection::pinhole(1_f64.to_radians());
    let clear = scene.material(absorbing(sigma), 0.0);
    scene.solid(Solid::Sphere { radius: 9.0 }, clear, DVec3::ZERO);
    let floor = scene.material(diffuse(0.5), 0.0);
    let half = DVec3::new(2.0, 0.5, 2.0);
    scene.solid(Solid::Box { half }, floor, DVec3::NEG_Y * 0.5);
    scene.point_light(DVec3::new(1.5, 2.0, 0.0), 10.0);
    scene.integrator = IntegratorSettings::Path {
        max_depth: Some(1),
        russian_roulette: false,
    };
    // 2.5 m from the light, 2 m to the camera.
    let lit = 0.5 / std::f32::consts::PI * 10.0 / 6.25 * 0.8;
    let expected = lit * (-4.5 * sigma).exp();
    for pixel in pixels(scene, 4) {
        assert!(
            (pixel - expected).length() < 0.02 * lit,
            "{pixel} {expected}"
        );
    }
}

#[test]
fn whitted_shows_what_a_smooth_coat_reflects() {
    let mut scene = empty_scene();
    scene.integrator = IntegratorSettings::whitted();
    scene.environment = Rgb::ONE;
    scene.cameras = vec![camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO)];
    scene.cameras[0].projection = Projection::pinhole(1_f64.to_radians());
    let plastic = scene.material(
        Surface::Plastic {
            color: Texture::Constant(Vec3::splat(0.5)),
            ior: 1.5,
            roughness: 0.0.into(),
        },
        0.0,
    );
    scene.solid(Solid::Sphere { radius: 1.0 }, plastic, DVec3::ZERO);
    let pixels = pixels(scene, 256);
    let mean = pixels.iter().sum::<Rgb>() / pixels.len() as f32;
    assert!((mean - 0.04).abs().max_element() < 1e-3, "{mean}");
}

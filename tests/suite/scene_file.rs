//! What a scene file says is what the description and the scene hold.

use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};

use glam::{DVec2, DVec3, Vec3};
use solidtrace::camera::Projection;
use solidtrace::color::{Rgb, Tonemap};
use solidtrace::film::Filter;
use solidtrace::geometry::{Shape, Solid};
use solidtrace::light::{Cone, Light, PointLight};
use solidtrace::material::{Fresnel, Surface};
use solidtrace::scene::description::{
    EnvironmentDescription, ShapeDescription, SurfaceDescription, TextureDescription,
};
use solidtrace::scene::{IntegratorSettings, Repeat, Scene, SceneDescription};
use solidtrace::texture::{Pattern, Ramp, Texture};

/// Every construct of the format once.
pub const RON: &str = r#"#![enable(implicit_some)]
/* block /* nested */ comment */
Scene(
    film: (size: (640, 480), spp: 16, filter: Gaussian(radius: 1.5), tonemap: None),
    camera: Perspective(eye: (0, 14, 55), look_at: (0, -2, 0), up: (0, 1, 0), vfov: 40, aperture: 0, focus: None),
    cameras: {
        "near \"door\"": Perspective(eye: (0, 1, 5), look_at: (0, 0, 0), vfov: 60.5, aperture: 0.25, focus: Some(4)),
    },
    integrator: Path(max_depth: None, russian_roulette: false),
    environment: Constant(color: (0.2, 0.4, 0.9)), // sky
    materials: {
        "green": Diffuse(color: (0.1, 0.7, 0.1)),
        "tiles": Diffuse(color: Checker(a: (1, 1, 1), b: (0.1, 0.1, 0.1), step: 2)),
        "glass": Dielectric(ior: 1.5),
        "thin":  Dielectric(ior: 1.33, fresnel: None),
        "gold":  Mirror(color: (1, 0.8, 0.3)),
        "silver": Mirror(),
        "lamp":  Emissive(radiance: (15, 15, 15)),
    },
    lights: [Point(position: (-10, 20, 40), intensity: (1.5e3, 1_500, 1500.0))],
    objects: [
        Plane(point: (0, -12, 0), normal: (0, 2, 0), material: "tiles", name: "floor"),
        Sphere(center: (10, 20, 0), radius: 3, material: "lamp"),
        Box(center: (1, 2, 3), size: (2, 4, 6), axes: ((0, 1, 0), (-1, 0, 0)), material: Some("green")),
        Cylinder(from: (0, 0, -7), to: (0, 0, 7), radius: 3, material: "green"),
        Cone(from: (0, -7, 0), to: (0, 7, 0), from_radius: 3, to_radius: 1, material: None),
        Torus(center: (0, 0, 0), axis: (0, 1, 0), major_radius: 5, minor_radius: 0.5),
        Sphere(radius: 1, transform: [Scale((1, 2, 3)), Rotate(axis: (0, 0, 1), degrees: 90), Translate((5, 0, 0))]),
        Difference(
            from: Intersection(of: [Box(size: (2, 2, 2), name: "block"), Instance(of: "grid", material: "glass")]),
            subtract: [
                Plane(normal: (0, 1, 0)),
                Repeat(count: (2, 1, 3), step: ((1, 0, 0), (0, 1, 0), (0, 0, 2)), jitter: (0.1, 0, 0.2), seed: 7,
                    of: Union(of: [Sphere(radius: 0.5)], transform: [Scale(2)])),
            ],
            name: "part", material: "gold",
            transform: [Matrix(((1, 0, 0), (0.5, 1, 0), (0, 0, 1), (1, 2, 3)))],
        ),
        Instance(of: "bolt", transform: [Scale(2), Translate((4, 0, 0))], name: "left"),
    ],
    definitions: {
        "bolt": Instance(of: "shaft", material: "gold", name: "bolt"),
        "grid": Repeat(count: (2, 2, 1), step: ((1, 0, 0), (0, 1, 0), (0, 0, 1)), of: Sphere(radius: 1)),
        "shaft": Cylinder(from: (1, 0, 0), to: (1, 3, 0), radius: 0.5, transform: [Translate((0, 1, 0))]),
    },
)
"#;

/// The same in JSON.
pub const JSON: &str = r#"{
    "film": {"size": [640, 480], "spp": 16, "filter": {"Gaussian": {"radius": 1.5}}, "tonemap": "None"},
    "camera": {"Perspective": {"eye": [0, 14, 55], "look_at": [0, -2, 0], "up": [0, 1, 0], "vfov": 40, "aperture": 0, "focus": null}},
    "cameras": {
        "near \u0022door\"": {"Perspective": {"eye": [0, 1, 5], "look_at": [0, 0, 0], "vfov": 60.5, "aperture": 0.25, "focus": 4}}
    },
    "integrator": {"Path": {"max_depth": null, "russian_roulette": false}},
    "environment": {"Constant": {"color": [0.2, 0.4, 0.9]}},
    "materials": {
        "green": {"Diffuse": {"color": [0.1, 0.7, 0.1]}},
        "tiles": {"Diffuse": {"color": {"Checker": {"a": [1, 1, 1], "b": [0.1, 0.1, 0.1], "step": 2}}}},
        "glass": {"Dielectric": {"ior": 1.5}},
        "thin": {"Dielectric": {"ior": 1.33, "fresnel": "None"}},
        "gold": {"Mirror": {"color": [1, 0.8, 0.3]}},
        "silver": {"Mirror": {}},
        "lamp": {"Emissive": {"radiance": [15, 15, 15]}}
    },
    "lights": [{"Point": {"position": [-10, 20, 40], "intensity": [1.5e3, 1500, 1500.0]}}],
    "objects": [
        {"Plane": {"point": [0, -12, 0], "normal": [0, 2, 0], "material": "tiles", "name": "floor"}},
        {"Sphere": {"center": [10, 20, 0], "radius": 3, "material": "lamp"}},
        {"Box": {"center": [1, 2, 3], "size": [2, 4, 6], "axes": [[0, 1, 0], [-1, 0, 0]], "material": "green"}},
        {"Cylinder": {"from": [0, 0, -7], "to": [0, 0, 7], "radius": 3, "material": "green"}},
        {"Cone": {"from": [0, -7, 0], "to": [0, 7, 0], "from_radius": 3, "to_radius": 1, "material": null}},
        {"Torus": {"center": [0, 0, 0], "axis": [0, 1, 0], "major_radius": 5, "minor_radius": 0.5}},
        {"Sphere": {"radius": 1, "transform": [{"Scale": [1, 2, 3]}, {"Rotate": {"axis": [0, 0, 1], "degrees": 90}}, {"Translate": [5, 0, 0]}]}},
        {"Difference": {
            "from": {"Intersection": {"of": [{"Box": {"size": [2, 2, 2], "name": "block"}}, {"Instance": {"of": "grid", "material": "glass"}}]}},
            "subtract": [
                {"Plane": {"normal": [0, 1, 0]}},
                {"Repeat": {"count": [2, 1, 3], "step": [[1, 0, 0], [0, 1, 0], [0, 0, 2]], "jitter": [0.1, 0, 0.2], "seed": 7,
                    "of": {"Union": {"of": [{"Sphere": {"radius": 0.5}}], "transform": [{"Scale": 2}]}}}}
            ],
            "name": "part", "material": "gold",
            "transform": [{"Matrix": [[1, 0, 0], [0.5, 1, 0], [0, 0, 1], [1, 2, 3]]}]
        }},
        {"Instance": {"of": "bolt", "transform": [{"Scale": 2}, {"Translate": [4, 0, 0]}], "name": "left"}}
    ],
    "definitions": {
        "bolt": {"Instance": {"of": "shaft", "material": "gold", "name": "bolt"}},
        "grid": {"Repeat": {"count": [2, 2, 1], "step": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "of": {"Sphere": {"radius": 1}}}},
        "shaft": {"Cylinder": {"from": [1, 0, 0], "to": [1, 3, 0], "radius": 0.5, "transform": [{"Translate": [0, 1, 0]}]}}
    }
}"#;

fn description() -> SceneDescription {
    SceneDescription::from_text("all.ron", RON).unwrap()
}

fn loaded() -> Scene {
    description().load().unwrap()
}

/// Where an instance puts a point of its canonical solid.
fn placed(scene: &Scene, instance: usize, p: [f64; 3]) -> DVec3 {
    scene.instances[instance]
        .world_from_object
        .point(DVec3::from(p))
}

fn assert_near(a: DVec3, b: [f64; 3]) {
    assert!((a - DVec3::from(b)).length() < 1e-12, "{a} is not {b:?}");
}

#[test]
fn ron_and_json_say_the_same() {
    let json = SceneDescription::from_text("all.json", JSON).unwrap();
    assert_eq!(description(), json);
}

#[test]
fn both_texts_are_what_other_readers_take() {
    let ron: Result<ron::Value, _> = ron::from_str(RON);
    assert!(ron.is_ok(), "{ron:?}");
    let json: Result<serde_json::Value, _> = serde_json::from_str(JSON);
    assert!(json.is_ok(), "{json:?}");
}

#[test]
fn a_byte_order_mark_and_windows_line_ends_change_nothing() {
    let text = format!("\u{feff}{}", RON.replace('\n', "\r\n"));
    assert_eq!(
        SceneDescription::from_text("all.ron", &text).unwrap(),
        description()
    );
}

#[test]
fn settings_are_as_written() {
    let d = description();
    assert_eq!(d.film.size, (640, 480));
    assert_eq!(d.film.spp, 16);
    assert_eq!(d.film.filter, Filter::Gaussian { radius: 1.5 });
    assert_eq!(d.film.tonemap, Tonemap::None);
    let path = IntegratorSettings::Path {
        max_depth: None,
        russian_roulette: false,
    };
    assert_eq!(d.integrator, path);
    let blue = EnvironmentDescription::Constant(Vec3::new(0.2, 0.4, 0.9));
    assert_eq!(d.environment, blue);
    let light = Light::Point(PointLight {
        position: DVec3::new(-10.0, 20.0, 40.0),
        intensity: Vec3::splat(1500.0),
        cone: None,
    });
    assert_eq!(d.lights, [light]);
    let [first, near] = &d.cameras[..] else {
        panic!("{} cameras", d.cameras.len());
    };
    assert_eq!(first.name, None);
    assert_eq!(first.eye, DVec3::new(0.0, 14.0, 55.0));
    assert_eq!(
        first.projection,
        Projection::pinhole(0.698_131_700_797_731_8)
    );
    assert_eq!(near.name.as_deref(), Some("near \"door\""));
    let lens = Projection::Perspective {
        vfov: 60.5_f64.to_radians(),
        aperture: 0.25,
        focus: Some(4.0),
    };
    assert_eq!(near.projection, lens);
    assert_eq!(near.up, DVec3::Y);
}

#[test]
fn what_is_left_out_has_its_default() {
    let text = "(camera: Perspective(eye: (0, 0, 1), look_at: (0, 0, 0), vfov: 45), objects: [])";
    let d = SceneDescription::from_text("small.ron", text).unwrap();
    assert_eq!((d.film.size, d.film.spp), ((1280, 720), 256));
    assert_eq!(d.film.tonemap, Tonemap::Srgb);
    let path = IntegratorSettings::Path {
        max_depth: Some(8),
        russian_roulette: true,
    };
    assert_eq!(d.integrator, path);
    assert_eq!(d.environment, EnvironmentDescription::Constant(Vec3::ZERO));
    assert!(d.load().unwrap().instances.is_empty());
}

#[test]
fn integrators_take_their_settings() {
    let read = |integrator: &str| {
        let text = format!(
            "(camera: Perspective(eye: (0, 0, 1), look_at: (0, 0, 0), vfov: 45), objects: [], integrator: {integrator})"
        );
        SceneDescription::from_text("a.ron", &text)
            .unwrap()
            .integrator
    };
    let whitted = IntegratorSettings::Whitted {
        max_depth: 100,
        shadow_factor: 0.5,
        background: Some(Vec3::Z),
    };
    assert_eq!(
        read("Whitted(max_depth: 100, shadow_factor: 0.5, background: (0, 0, 1))"),
        whitted
    );
    assert_eq!(read("Normals"), IntegratorSettings::Normals);
    assert_eq!(read("Flat"), IntegratorSettings::Flat);
    assert_eq!(read("Depth"), IntegratorSettings::Depth);
    assert_eq!(read("Ao"), IntegratorSettings::Ao { radius: None });
    assert_eq!(
        read("Ao(radius: 2)"),
        IntegratorSettings::Ao { radius: Some(2.0) }
    );
}

#[test]
fn materials_are_as_written_and_shared_by_name() {
    let d = description();
    let thin = SurfaceDescription::Dielectric {
        ior: 1.33,
        fresnel: Fresnel::None,
        roughness: 0.0.into(),
        absorption: Rgb::ZERO,
    };
    assert_eq!(d.materials[3].surface, thin);
    let silver = SurfaceDescription::Mirror {
        color: TextureDescription::Constant(Vec3::ONE),
    };
    assert_eq!(d.materials[5].surface, silver);

    let scene = loaded();
    let of = |instance: usize| &scene.materials[scene.instances[instance].material(0).0 as usize];
    let tiles = Texture::Pattern {
        pattern: Pattern::Checker { step: 2.0 },
        colors: Ramp::between(Vec3::ONE, Vec3::splat(0.1)),
    };
    assert_eq!(of(0).surface, Surface::Diffuse { color: tiles });
    assert_eq!(of(1).emission, Vec3::splat(15.0));
    assert_eq!(scene.instances[2].materials, scene.instances[3].materials);
    assert_eq!(of(4).name, "default");
    assert_eq!(scene.materials.len(), 8);
}

#[test]
fn solids_stand_where_their_numbers_say() {
    let scene = loaded();
    let solid = |i: usize| match scene.instances[i].shape {
        Shape::Solid(solid) => solid,
        other => panic!("instance {i} is {other:?}"),
    };
    assert_eq!(solid(0), Solid::Plane);
    assert_near(placed(&scene, 0, [0.0, 0.0, 1.0]), [0.0, -11.0, 0.0]);
    assert_eq!(solid(1), Solid::Sphere { radius: 3.0 });
    assert_near(placed(&scene, 1, [0.0; 3]), [10.0, 20.0, 0.0]);
    let half = DVec3::new(1.0, 2.0, 3.0);
    assert_eq!(solid(2), Solid::Box { half });
    assert_near(placed(&scene, 2, [1.0, 0.0, 0.0]), [1.0, 3.0, 3.0]);
    assert_near(placed(&scene, 2, [0.0, 1.0, 0.0]), [0.0, 2.0, 3.0]);
    assert_near(placed(&scene, 2, [0.0, 0.0, 1.0]), [1.0, 2.0, 4.0]);
    let (radius, height) = (3.0, 14.0);
    assert_eq!(solid(3), Solid::Cylinder { radius, height });
    assert_near(placed(&scene, 3, [0.0, 0.0, 14.0]), [0.0, 0.0, 7.0]);
    let cone = Solid::Cone {
        from_radius: 3.0,
        to_radius: 1.0,
        height: 14.0,
    };
    assert_eq!(solid(4), cone);
    assert_near(placed(&scene, 4, [0.0; 3]), [0.0, -7.0, 0.0]);
    assert_near(placed(&scene, 4, [0.0, 0.0, 14.0]), [0.0, 7.0, 0.0]);
    let (major, minor) = (5.0, 0.5);
    assert_eq!(solid(5), Solid::Torus { major, minor });
    assert_near(placed(&scene, 5, [0.0, 0.0, 1.0]), [0.0, 1.0, 0.0]);
    for instance in &scene.instances {
        assert!(instance.world_from_object.matrix().matrix3.determinant() > 0.0);
    }
}

#[test]
fn rectangles_disks_and_spots_are_as_written() {
    let text = r"(
        camera: Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45),
        lights: [
            Spot(position: (1, 2, 3), target: (1, 0, 3), intensity: (1, 2, 3), angle: 60, inner_angle: 60),
            Spot(position: (0, 0, 0), direction: (0, 3, 0), intensity: (1, 1, 1)),
        ],
        objects: [
            Rectangle(center: (1, 2, 3), size: (4, 2), axes: ((0, 1, 0), (0, 0, 1))),
            Rectangle(size: (2, 2)),
            Disk(center: (1, 2, 3), normal: (0, 2, 0), radius: 0.5),
        ],
    )";
    let scene = SceneDescription::from_text("a.ron", text);
    let scene = scene.and_then(|d| d.load()).unwrap();
    let cones = scene.lights.iter().map(|light| match light {
        Light::Point(point) => point.cone.unwrap(),
        _ => panic!("{light:?}"),
    });
    let expected = [
        Cone::new(DVec3::NEG_Y, FRAC_PI_3, FRAC_PI_3),
        Cone::new(DVec3::Y, 0.0, FRAC_PI_4),
    ];
    for (cone, expected) in cones.zip(expected) {
        assert_eq!(cone.axis, expected.axis);
        assert!((cone.cos_inner - expected.cos_inner).abs() < 1e-12);
        assert!((cone.cos_outer - expected.cos_outer).abs() < 1e-12);
    }
    let half = DVec2::new(2.0, 1.0);
    assert_eq!(
        scene.instances[0].shape,
        Shape::Solid(Solid::Rectangle { half })
    );
    assert_near(placed(&scene, 0, [2.0, 0.0, 0.0]), [1.0, 4.0, 3.0]);
    assert_near(placed(&scene, 0, [0.0, 1.0, 0.0]), [1.0, 2.0, 4.0]);
    assert_near(placed(&scene, 1, [1.0, 1.0, 0.0]), [1.0, 1.0, 0.0]);
    assert_eq!(
        scene.instances[2].shape,
        Shape::Solid(Solid::Disk { radius: 0.5 })
    );
    assert_near(placed(&scene, 2, [0.0, 0.0, 1.0]), [1.0, 3.0, 3.0]);
}

#[test]
fn transforms_apply_in_the_order_written() {
    // (1, 1, 0) is scaled to (1, 2, 0), turned to (-2, 1, 0), moved to (3, 1, 0).
    assert_near(placed(&loaded(), 6, [1.0, 1.0, 0.0]), [3.0, 1.0, 0.0]);
}

#[test]
fn a_matrix_says_where_the_axes_and_the_origin_go() {
    // (1, 1, 0) is sheared to (1.5, 1, 0) and moved.
    assert_near(placed(&loaded(), 7, [1.0, 1.0, 0.0]), [2.5, 3.0, 3.0]);
}

#[test]
fn operators_follow_their_operands() {
    let tree = &description().objects[7].0;
    let shapes: Vec<String> = (tree.iter())
        .map(|object| match &object.shape {
            ShapeDescription::Csg { op, operands } => format!("{op:?} of {operands}"),
            ShapeDescription::Solid { solid, .. } => format!("{solid:?}"),
            ShapeDescription::Instance { of } => of.name.clone(),
            ShapeDescription::Repeat(repeat) => format!("{} copies", repeat.copies()),
            ShapeDescription::Mesh { file, .. } => file.name.clone(),
        })
        .collect();
    let half = DVec3::ONE;
    let expected = [
        &format!("{:?}", Solid::Box { half }),
        "grid",
        "Intersection of 2",
        "Plane",
        "Sphere { radius: 0.5 }",
        "Union of 1",
        "6 copies",
        "Difference of 3",
    ];
    assert_eq!(shapes, expected);
    let named = |i: usize| tree[i].name.as_deref();
    assert_eq!((named(0), named(7)), (Some("block"), Some("part")));
    let material = |i: usize| tree[i].material.as_ref().map(|m| &*m.name);
    assert_eq!((material(1), material(7)), (Some("glass"), Some("gold")));
    let expected = Repeat {
        count: [2, 1, 3],
        step: [DVec3::X, DVec3::Y, 2.0 * DVec3::Z],
        jitter: DVec3::new(0.1, 0.0, 0.2),
        seed: 7,
    };
    assert_eq!(tree[6].shape, ShapeDescription::Repeat(expected));
}

#[test]
fn an_instance_of_an_instance_joins_transforms_names_and_materials() {
    let scene = loaded();
    let last = scene.instances.len() - 1;
    assert_eq!(scene.instances[last].name.as_deref(), Some("left/bolt"));
    let material = scene.instances[last].material(0);
    assert_eq!(scene.materials[material.0 as usize].name, "gold");
    // The shaft's foot (1, 0, 0) is lifted by 1, doubled, moved by 4.
    assert_near(placed(&scene, last, [0.0; 3]), [6.0, 2.0, 0.0]);
}

#[test]
fn escapes_mean_what_the_formats_say() {
    let named = |file: &str, camera: &str| {
        SceneDescription::from_text(file, camera).unwrap().cameras[0]
            .name
            .clone()
            .unwrap()
    };
    let ron = r#"(cameras: {"a\u{1F600}\x41\n\\": Perspective(eye: (0, 0, 1), look_at: (0, 0, 0), vfov: 45)}, objects: [])"#;
    assert_eq!(named("a.ron", ron), "a\u{1F600}A\n\\");
    let raw = r##"(cameras: {r#"b\"c"#: Perspective(eye: (0, 0, 1), look_at: (0, 0, 0), vfov: 45)}, objects: [])"##;
    assert_eq!(named("a.ron", raw), "b\\\"c");
    let json = r#"{"cameras": {"\uD83D\uDE00\u00e9\/": {"Perspective": {"eye": [0, 0, 1], "look_at": [0, 0, 0], "vfov": 45}}}, "objects": []}"#;
    assert_eq!(named("a.json", json), "\u{1F600}é/");
}

#[test]
fn the_scenes_of_the_project_load() {
    for name in ["first_light", "cornell", "lamps"] {
        let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
        let scene = SceneDescription::read(&path).and_then(|d| d.load());
        let scene = scene.unwrap_or_else(|e| panic!("{e}"));
        assert!(!scene.instances.is_empty());
    }
}

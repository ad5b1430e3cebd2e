//! What is raced over and the rays that are asked; with the feature `bench` the race itself, but for its times.

use solidtrace::accel::Accel;
use solidtrace::bench::{RayKind, RaySets, Subject};
use solidtrace::io::bare_scene;
use solidtrace::math::Ray;
use solidtrace::scene::generated;

fn subject(name: &str) -> Subject {
    let model = generated(name).unwrap().unwrap();
    Subject::of_scene(bare_scene(model, false).unwrap()).unwrap()
}

fn rays(subject: &Subject) -> RaySets {
    let accel = Accel::build(&subject.meshes, &[], subject.placed()).unwrap();
    RaySets::new(subject, &accel, (64, 48)).unwrap()
}

#[test]
fn generated_meshes_are_closed_and_about_as_large_as_asked_for() {
    for (name, count) in [
        ("sphere:20k", 20_000.0),
        ("scan:3000", 3_000.0),
        ("slivers:1k", 1_000.0),
    ] {
        let subject = subject(name);
        let triangles = subject.triangles() as f64;
        assert!(
            (triangles / count - 1.0).abs() < 0.05,
            "{name}: {triangles}"
        );
        assert!(subject.meshes[0].openness().is_none(), "{name}");
        assert!(!subject.is_instanced());
    }
}

#[test]
fn generated_instances_share_their_mesh() {
    let subject = subject("instances:7");
    assert_eq!((subject.meshes.len(), subject.instances.len()), (1, 7));
    assert_eq!(subject.placed_triangles(), 7 * subject.triangles());
    let flat = subject.flat();
    assert_eq!(flat.triangles.len(), subject.placed_triangles());
    let (a, b) = (flat.bounds(), subject.bounds());
    // The box of a turned box is larger than that of what is in it.
    assert!(a.min.cmpge(b.min - 1e-5).all() && a.max.cmple(b.max + 1e-5).all());
}

#[test]
fn wrong_names_of_generated_meshes_say_what_is_right() {
    for (name, help) in [
        ("spere:2M", "did you mean `sphere`?"),
        ("scan:many", "70k, 2M or 1000"),
        ("scan:1e99", "70k, 2M or 1000"),
        ("scan:NaN", "70k, 2M or 1000"),
        ("slivers:", "70k, 2M or 1000"),
    ] {
        let error = generated(name).unwrap().unwrap_err().to_string();
        assert!(error.contains(help), "{name}: {error}");
    }
    for file in ["scenes/showcase.ron", "C:/girl.obj", "a-1:2", "girl.obj"] {
        assert!(generated(file).is_none(), "{file}");
    }
}

#[test]
fn rays_are_exact_in_f32_and_of_unit_length() {
    let sets = rays(&subject("scan:3000"));
    for kind in RayKind::ALL {
        let rays = sets.of(kind);
        assert!(
            rays.len() >= 16 && rays.len().is_multiple_of(16),
            "{kind:?}"
        );
        for Ray {
            origin,
            direction,
            tmin,
            tmax,
        } in rays
        {
            assert_eq!(*origin, origin.as_vec3().as_dvec3());
            assert_eq!(*direction, direction.as_vec3().as_dvec3());
            assert_eq!(*tmax, f64::from(*tmax as f32));
            assert_eq!(*tmin, 0.0);
            assert!((direction.length() - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn rays_are_what_their_kind_says() {
    let subject = subject("scan:3000");
    let (sets, bounds) = (rays(&subject), subject.bounds());
    let radius = 0.5 * bounds.size().length();
    let camera = sets.of(RayKind::Camera);
    assert_eq!(camera.len(), 64 * 48);
    assert!(camera.iter().all(|ray| ray.origin == camera[0].origin));
    // A tile of 8 by 8 pixels comes together: it spans an eighth of the picture's width.
    let spread = |rays: &[Ray]| {
        let cosines = rays.iter().map(|ray| ray.direction.dot(rays[0].direction));
        cosines.fold(1.0, f64::min).acos()
    };
    assert!(spread(&camera[..64]) < 0.3 * spread(camera));

    let (bounce, occlusion) = (sets.of(RayKind::Bounce), sets.of(RayKind::Occlusion));
    for (a, b) in bounce.iter().zip(occlusion) {
        assert_eq!((a.origin, a.direction), (b.origin, b.direction));
        assert!(a.tmax.is_infinite() && (b.tmax / (0.5 * radius) - 1.0).abs() < 1e-6);
    }
    for ray in sets.of(RayKind::Shadow) {
        let light = (ray.at(ray.tmax / 0.999) - bounds.center()) / radius;
        assert!((light.y - 2.0).abs() < 1e-3, "{light}");
        assert!(light.x.abs().max(light.z.abs()) < 0.501, "{light}");
    }
    for ray in sets.of(RayKind::Chords) {
        let start = (ray.origin - bounds.center()).length();
        assert!((start / (1.1 * radius) - 1.0).abs() < 1e-5);
    }
}

#[test]
fn bounces_start_outside_of_a_closed_mesh() {
    let subject = subject("sphere:20k");
    let accel = Accel::build(&subject.meshes, &[], subject.placed()).unwrap();
    let sets = RaySets::new(&subject, &accel, (64, 48)).unwrap();
    let bounce = sets.of(RayKind::Bounce);
    assert!(bounce.iter().all(|ray| !accel.contains(0, ray.origin)));
}

#[cfg(not(feature = "bench"))]
#[test]
fn a_build_without_the_feature_says_how_to_get_it() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_solidtrace"))
        .args(["bench", "scan:70k", "--json"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.starts_with("error: this command is not in this build"),
        "{message}"
    );
    assert!(message.contains("--features bench"), "{message}");
}

#[cfg(feature = "bench")]
mod race {
    use std::fs;
    use std::path::Path;
    use std::process::{Command, Output};

    use serde_json::Value;
    use solidtrace::accel::Kernel;
    use tempfile::TempDir;

    fn bench(folder: &Path, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_solidtrace"))
            .arg("bench")
            .args(args)
            .current_dir(folder)
            .output()
            .unwrap()
    }

    /// The engines that any build has, and those of this processor.
    fn engines() -> Vec<String> {
        let mut engines: Vec<String> = [
            "single",
            "batch",
            "embree",
            "embree-robust",
            "embree-high",
            "obvhs-bvh2",
            "obvhs-cwbvh",
            "bvh",
            "parry3d",
        ]
        .map(str::to_owned)
        .into();
        for kernel in Kernel::available() {
            if kernel == Kernel::default() {
                continue;
            }
            match kernel.name() {
                "portable" => engines.push("portable".to_owned()),
                name => engines.extend([format!("single-{name}"), format!("batch-{name}")]),
            }
        }
        engines
    }

    /// Checks that every element is closed in its turn and that every `&` starts a known entity.
    fn assert_well_formed(xml: &str) {
        let mut open = Vec::new();
        for tag in xml.split('<').skip(1) {
            let (tag, text) = tag.split_once('>').expect("a tag ends");
            let name = tag.split([' ', '/']).next().unwrap();
            if let Some(name) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(name));
            } else if !tag.ends_with('/') {
                open.push(name);
            }
            assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
            for entity in text.split('&').skip(1) {
                assert!(
                    ["amp;", "lt;", "gt;"]
                        .iter()
                        .any(|known| entity.starts_with(known))
                );
            }
        }
        assert!(open.is_empty(), "{open:?} are open");
    }

    #[test]
    fn every_engine_races_agrees_and_is_reported() {
        let folder = TempDir::new().unwrap();
        let args = [
            "instances:3",
            "--json",
            "--plot",
            "plot.svg",
            "--rounds",
            "1",
            "--threads",
            "2",
            "--size",
            "64x64",
        ];
        let output = bench(folder.path(), &args);
        let messages = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{messages}");
        assert!(messages.contains("60000 triangles"), "{messages}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["input"], "instances:3");
        assert_eq!(
            (&report["triangles"], &report["threads"]),
            (&Value::from(20_000), &Value::from(2))
        );
        let svg = fs::read_to_string(folder.path().join("plot.svg")).unwrap();
        assert_well_formed(&svg);
        for kind in ["camera", "bounce", "shadow", "chords", "occlusion"] {
            let of_kind = report["mrays"][kind].as_object().unwrap();
            for engine in engines() {
                let speeds = &of_kind[&engine];
                let [median, min, max] =
                    ["median", "min", "max"].map(|key| speeds[key].as_f64().unwrap());
                assert!(
                    0.0 < min && min <= median && median <= max,
                    "{kind} {engine}: {speeds}"
                );
                assert!(
                    speeds["hits"].as_u64().unwrap() > 0,
                    "{kind} {engine}: {speeds}"
                );
                assert!(svg.contains(&format!(">{engine}<")), "{engine}");
            }
            assert_eq!(of_kind["embree"]["ratio"], 1.0);
            for (engine, speeds) in of_kind {
                assert_eq!(speeds["agrees"], true, "{kind} {engine}: {speeds}");
            }
        }
        for kind in ["camera", "shadow"] {
            assert!(
                report["mrays"][kind]["embree-packet"]["median"]
                    .as_f64()
                    .unwrap()
                    > 0.0
            );
        }
        for engine in [
            "ours-fast",
            "ours-balanced",
            "ours-best",
            "embree-medium",
            "embree-high",
            "obvhs-bvh2",
            "obvhs-cwbvh",
            "bvh",
        ] {
            for key in ["build_seconds", "bytes_per_triangle"] {
                assert!(
                    report[key][engine].as_f64().unwrap() > 0.0,
                    "{key} {engine}"
                );
            }
        }
    }

    #[test]
    fn a_scene_without_meshes_has_nothing_to_race_over() {
        let folder = TempDir::new().unwrap();
        let scene = r"Scene(camera: Perspective(eye: (0, 0, 5), look_at: (0, 0, 0), vfov: 40), objects: [Sphere(center: (0, 0, 0), radius: 1)])";
        fs::write(folder.path().join("ball.ron"), scene).unwrap();
        let output = bench(folder.path(), &["ball.ron"]);
        assert_eq!(output.status.code(), Some(1));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(
            message.contains("no mesh") && message.contains("ball.ron"),
            "{message}"
        );
    }
}

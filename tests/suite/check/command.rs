use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use solidtrace::accel::Kernel;
use solidtrace::io::read_exr;
use tempfile::TempDir;

const INSTANCES: &str = r#"Scene(
    film: (size: (48, 27), spp: 4),
    camera: Perspective(eye: (0, 2, 7), look_at: (0, 0.8, 0), vfov: 40),
    environment: Constant(color: (0.3, 0.4, 0.5)),
    materials: { "lamp": Emissive(radiance: (9, 9, 9)) },
    objects: [
        Plane(point: (0, 0, 0), normal: (0, 1, 0)),
        Sphere(center: (1, 4, 2), radius: 0.4, material: "lamp"),
        Instance(of: "girl", transform: [Translate((-1.5, 0, 0))]),
        Instance(of: "girl", transform: [Scale((-1, 1.2, 1))]),
        Instance(of: "girl", transform: [Matrix(((1, 0.3, 0), (0.2, 0.7, 0.1), (0, 0.4, 1), (1.5, 0, 0)))]),
    ],
    definitions: { "girl": Mesh(file: "assets/girl.obj") },
)"#;

fn check(folder: &Path, args: &[&str]) -> Output {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let _ = std::os::unix::fs::symlink(&assets, folder.join("assets"));
    Command::new(env!("CARGO_BIN_EXE_solidtrace"))
        .arg("check")
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const COUNTS: [&str; 11] = [
    "rays",
    "hits",
    "differences",
    "ours_wrong",
    "embree_wrong",
    "embree_robust_wrong",
    "edge",
    "sliver",
    "grazing",
    "end",
    "ties",
];

/// The report, its sums proved.
fn report(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object alone");
    let classes = report["classes"].as_object().unwrap();
    for name in [
        "camera", "bounce", "shadow", "chord", "vertex", "edge", "axis",
    ] {
        assert!(classes.contains_key(name), "{name}");
    }
    assert_eq!(classes.len(), 7);
    for count in COUNTS {
        let sum: u64 = classes.values().map(|c| c[count].as_u64().unwrap()).sum();
        assert_eq!(report[count].as_u64(), Some(sum), "{count}");
    }
    for (name, class) in classes {
        let n = |count: &str| class[count].as_u64().unwrap();
        let excused = n("edge") + n("sliver") + n("grazing") + n("end");
        let wrong = n("ours_wrong") + n("embree_wrong") + n("embree_robust_wrong");
        assert!(excused <= n("differences"), "{name}: {class}");
        assert!(excused + wrong >= n("differences"), "{name}: {class}");
        assert!(n("hits") <= n("rays"), "{name}: {class}");
        assert!(
            class["worst_dt"].as_f64().unwrap() <= 1.0,
            "{name}: {class}"
        );
    }
    assert_eq!(report["ours_wrong"], 0, "{report}");
    report
}

#[test]
fn a_model_is_checked_and_told_of_in_json() {
    let folder = TempDir::new().unwrap();
    let args = ["assets/girl.obj", "--rays", "70001", "--json"];
    let output = check(folder.path(), &args);
    let first = report(&output);
    assert_eq!(
        (&first["input"], &first["rays"]),
        (&"assets/girl.obj".into(), &70_001.into())
    );
    assert!(first["seconds"].as_f64().unwrap() > 0.0);
    for class in ["vertex", "edge", "axis"] {
        let n = |count: &str| first["classes"][class][count].as_u64().unwrap();
        assert!(
            n("hits") > n("rays") * 9 / 10 && n("ties") > n("rays") / 20,
            "{first}"
        );
    }
    // The same again but for the time; other rays with another seed.
    let without_time = |mut report: Value| {
        report["seconds"] = Value::Null;
        report
    };
    let again = report(&check(folder.path(), &args));
    assert_eq!(without_time(again), without_time(first.clone()));
    let other = report(&check(
        folder.path(),
        &[&args[..], &["--seed", "1"]].concat(),
    ));
    assert_ne!(other["hits"], first["hits"]);
}

#[test]
fn instances_are_checked_sheared_and_mirrored_and_the_heat_map_shows_where() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("crowd.ron"), INSTANCES).unwrap();
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
    let args = [
        "crowd.ron",
        "--allow-path",
        assets,
        "--rays",
        "7000",
        "--heatmap",
        "heat.exr",
    ];
    let output = check(folder.path(), &[&args[..], &["--json"]].concat());
    let report = report(&output);
    assert!(
        stderr(&output).contains("meshes alone: 2"),
        "{}",
        stderr(&output)
    );
    // One a pixel of 48x27 where a seventh of all would be 1000.
    assert_eq!(report["classes"]["camera"]["rays"], 48 * 27);
    assert_eq!(report["rays"], 48 * 27 + 6000);
    for class in ["bounce", "shadow"] {
        assert!(
            report["classes"][class]["hits"].as_u64().unwrap() > 10,
            "{report}"
        );
    }
    let map = read_exr(&folder.path().join("heat.exr")).unwrap();
    assert_eq!((map.width, map.height), (48, 27));
    assert_eq!(map.channel("rays").unwrap(), [1.0; 48 * 27]);
    let camera = &report["classes"]["camera"];
    for (channel, count) in [
        ("ours.wrong", "ours_wrong"),
        ("fast.wrong", "embree_wrong"),
        ("robust.wrong", "embree_robust_wrong"),
    ] {
        let sum: f32 = map.channel(channel).unwrap().iter().sum();
        assert_eq!(f64::from(sum), camera[count].as_f64().unwrap(), "{channel}");
    }
    assert!(map.channel("fast.differs").is_some() && map.channel("robust.differs").is_some());

    let refused = check(folder.path(), &args);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("--force"), "{}", stderr(&refused));
}

#[test]
fn the_table_has_a_row_for_each_class_and_a_closing_line() {
    let folder = TempDir::new().unwrap();
    let output = check(folder.path(), &["assets/girl.obj", "--rays", "700"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 10, "{text}");
    let heads = [
        "class",
        "rays",
        "hits",
        "ours wrong",
        "edge",
        "sliver",
        "grazing",
        "ties",
    ];
    assert!(heads.iter().all(|head| lines[0].contains(head)), "{text}");
    assert!(
        lines[..9].iter().all(|line| line.len() == lines[0].len()),
        "{text}"
    );
    assert!(
        lines[8].starts_with("all") && lines[8].contains("700"),
        "{text}"
    );
    assert!(
        lines[9].contains("Mrays/s") && lines[9].contains("ours wrong 0"),
        "{text}"
    );
}

#[test]
fn generated_meshes_are_checked_on_every_kernel_of_the_processor() {
    let folder = TempDir::new().unwrap();
    for name in ["scan:2k", "slivers:20k", "instances:20"] {
        let report = report(&check(folder.path(), &[name, "--rays", "7000", "--json"]));
        assert_eq!(
            (&report["input"], &report["rays"]),
            (&name.into(), &7000.into())
        );
        let kernels: Vec<&str> = Kernel::available().into_iter().map(Kernel::name).collect();
        assert_eq!(report["kernels"], Value::from(kernels));
        for class in ["camera", "chord", "vertex", "edge", "axis"] {
            let tally = &report["classes"][class];
            assert!(
                tally["hits"].as_u64().unwrap() > 20,
                "{name} {class}: {tally}"
            );
        }
    }
}

#[test]
fn what_cannot_be_checked_is_an_error_that_says_so() {
    let folder = TempDir::new().unwrap();
    let scene = INSTANCES.lines().filter(|line| !line.contains("girl"));
    let scene = scene.collect::<Vec<_>>().join("\n");
    fs::write(folder.path().join("solids.ron"), scene).unwrap();
    let output = check(folder.path(), &["solids.ron"]);
    assert_eq!(output.status.code(), Some(1));
    let said = stderr(&output);
    assert!(
        said.contains("no meshes") && said.contains("solids.ron"),
        "{said}"
    );
    for args in [
        &["assets/girl.obj", "--rays", "0"][..],
        &["assets/girl.obj", "--heatmap", "heat.png"],
        &["assets/girl.obj", "--heatmap", "heat.jpg"],
    ] {
        assert_eq!(
            check(folder.path(), args).status.code(),
            Some(2),
            "{args:?}"
        );
    }
}

//! The program as people run it: exit codes, files, messages.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use glam::DVec3;
use solidtrace::io::{RayReader, ReadOptions, read_exr, read_scene};
use solidtrace::world::World;
use tempfile::TempDir;

const SCENE: &str = r#"Scene(
    film: (size: (40, 30), spp: 5, filter: Gaussian(radius: 1.5)),
    camera: Perspective(eye: (0, 1, 5), look_at: (0, 0.5, 0), vfov: 40),
    environment: Constant(color: (0.3, 0.4, 0.5)),
    materials: {
        "white": Diffuse(color: (0.8, 0.8, 0.8)),
        "glass": Dielectric(ior: 1.5),
        "lamp": Emissive(radiance: (9, 9, 9)),
    },
    objects: [
        Plane(name: "floor", point: (0, 0, 0), normal: (0, 1, 0), material: "white"),
        Sphere(name: "ball, clear", center: (-0.6, 0.5, 0), radius: 0.5, material: "glass"),
        Torus(center: (0.8, 0.3, 0), axis: (0.3, 1, 0), major_radius: 0.5, minor_radius: 0.2, material: "white"),
        Sphere(center: (1, 3, 1), radius: 0.4, material: "lamp"),
    ],
)"#;

/// Runs the program in `folder`.
fn run(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_solidtrace"))
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn folder_with_scene() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("room.ron"), SCENE).unwrap();
    folder
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn render_alone_writes_exr_and_png_and_ends_with_a_line_of_figures() {
    let folder = folder_with_scene();
    let output = run(folder.path(), &["render", "room.ron"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let line = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(line.contains("40x30") && line.contains("Mrays/s"), "{line}");
    let image = read_exr(&folder.path().join("room.exr")).unwrap();
    assert_eq!((image.width, image.height), (40, 30));
    let noted = |name: &str| {
        image
            .metadata
            .iter()
            .find(|(n, _)| n == name)
            .unwrap()
            .1
            .clone()
    };
    assert_eq!(noted("spp"), "5");
    assert_eq!(noted("scene"), "room.ron");
    assert_eq!(noted("solidtrace"), env!("CARGO_PKG_VERSION"));
    assert!(noted("camera").contains("eye"));
    assert!(
        fs::read(folder.path().join("room.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    // Not on a terminal: plain lines.
    assert!(stderr(&output).contains("100%"), "{}", stderr(&output));
}

#[test]
fn threads_and_tiles_do_not_show_in_the_files() {
    let folder = folder_with_scene();
    let splits = [["1", "32"], ["2", "32"], ["2", "7"], ["3", "1"]];
    let files: Vec<[Vec<u8>; 2]> = splits
        .iter()
        .map(|[threads, tile]| {
            let args = [
                "render",
                "room.ron",
                "--force",
                "--threads",
                threads,
                "--tile-size",
                tile,
            ];
            let output = run(folder.path(), &args);
            assert!(output.status.success(), "{}", stderr(&output));
            ["room.exr", "room.png"].map(|name| fs::read(folder.path().join(name)).unwrap())
        })
        .collect();
    for (split, file) in splits.iter().zip(&files) {
        assert!(*file == files[0], "{split:?}");
    }
    let other = run(
        folder.path(),
        &["render", "room.ron", "--force", "--seed", "1"],
    );
    assert!(other.status.success());
    assert!(
        fs::read(folder.path().join("room.exr")).unwrap() != files[0][0],
        "the seed counts"
    );
}

#[test]
fn files_that_exist_are_kept_unless_forced() {
    let folder = folder_with_scene();
    fs::write(folder.path().join("room.png"), "mine").unwrap();
    let output = run(folder.path(), &["render", "room.ron"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("--force"), "{}", stderr(&output));
    assert_eq!(fs::read(folder.path().join("room.png")).unwrap(), b"mine");
    assert!(
        !folder.path().join("room.exr").exists(),
        "nothing is rendered in vain"
    );
    let output = run(
        folder.path(),
        &["render", "room.ron", "-o", "nowhere/room.exr"],
    );
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("nowhere"), "{}", stderr(&output));
}

#[test]
fn wrong_usage_is_exit_code_2_and_wrong_input_1() {
    let folder = folder_with_scene();
    let path = folder.path();
    let code = |args: &[&str]| run(path, args).status.code();
    assert_eq!(code(&["render", "room.ron", "--size", "0x5"]), Some(2));
    assert_eq!(code(&["rendr", "room.ron"]), Some(2));
    assert_eq!(code(&["render", "room.ron", "--camera", "left"]), Some(2));
    assert_eq!(
        code(&["render", "room.ron", "--crop", "0,0,41,30"]),
        Some(2)
    );
    assert_eq!(code(&["render", "room.ron", "-o", "room.jpg"]), Some(2));
    assert_eq!(
        code(&["render", "room.ron", "--size", "65536x65536"]),
        Some(2)
    );
    assert_eq!(code(&["render", "missing.ron"]), Some(1));
    assert_eq!(code(&["info", "missing.obj"]), Some(1));
    let bad = SCENE.replace("radius: 0.4", "radius: -0.4");
    let line = 1 + bad.lines().position(|l| l.contains("-0.4")).unwrap();
    fs::write(path.join("bad.ron"), bad).unwrap();
    let output = run(path, &["render", "bad.ron"]);
    assert_eq!(output.status.code(), Some(1));
    let text = stderr(&output);
    assert!(text.contains(&format!("bad.ron:{line}:43")), "{text}");
    assert!(text.contains("`-0.4` must be above 0"), "{text}");
    assert!(
        fs::read_dir(path).unwrap().count() == 2,
        "no output was touched"
    );
}

#[test]
fn open_meshes_are_operands_only_on_request() {
    let folder = folder_with_scene();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
    fs::write(folder.path().join("open.obj"), obj).unwrap();
    let open = SCENE.replace(
        "objects: [",
        "objects: [Union(of: [Mesh(file: \"open.obj\")]),",
    );
    fs::write(folder.path().join("open.ron"), open).unwrap();
    let info = |more: &[&str]| run(folder.path(), &[&["info", "open.ron"], more].concat());
    for refused in [info(&[]), info(&["--open-mesh-operands", "refuse"])] {
        assert_eq!(refused.status.code(), Some(1));
        assert!(stderr(&refused).contains("error: the mesh is not closed"));
    }
    let winding = info(&["--open-mesh-operands", "winding"]);
    assert_eq!(winding.status.code(), Some(0), "{}", stderr(&winding));
    assert!(stderr(&winding).contains("not closed"));
    assert_eq!(
        info(&["--open-mesh-operands", "guess"]).status.code(),
        Some(2)
    );
}

#[test]
fn crop_and_sample_ranges_are_parts_of_the_whole_picture() {
    let folder = folder_with_scene();
    let path = folder.path();
    let picture = |args: &[&str]| {
        let mut all = vec!["render", "room.ron", "-o", "part.exr", "--force", "--quiet"];
        all.extend(args);
        assert!(run(path, &all).status.success());
        read_exr(&path.join("part.exr")).unwrap()
    };
    let whole = picture(&[]);
    let part = picture(&["--crop", "10,5,30,20"]);
    for name in ["R", "G", "B"] {
        let (a, b) = (whole.channel(name).unwrap(), part.channel(name).unwrap());
        for i in 0..40 * 30 {
            let inside = (10..30).contains(&(i % 40)) && (5..20).contains(&(i / 40));
            assert_eq!(b[i], if inside { a[i] } else { 0.0 }, "{name} {i}");
        }
    }
    // Two halves of the samples weigh as they should: 2 and 3 of 5.
    let (first, rest) = (
        picture(&["--samples", "0..2"]),
        picture(&["--samples", "2..5"]),
    );
    let green = |image: &solidtrace::image::Image| image.channel("G").unwrap().to_vec();
    for ((w, a), b) in green(&whole).iter().zip(green(&first)).zip(green(&rest)) {
        assert!((w - (2.0 * a + 3.0 * b) / 5.0).abs() <= 1e-5 * w.max(1.0));
    }
}

#[test]
fn a_time_limit_ends_a_render_with_what_there_is() {
    let folder = folder_with_scene();
    let args = ["render", "room.ron", "--spp", "100000000", "--time", "1s"];
    let output = run(folder.path(), &args);
    assert!(output.status.success(), "{}", stderr(&output));
    let image = read_exr(&folder.path().join("room.exr")).unwrap();
    assert!(image.channel("R").unwrap().iter().any(|&x| x > 0.0));
    assert!(image.metadata.iter().any(|(name, _)| name == "incomplete"));
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupt_writes_what_there_is_and_exits_with_130() {
    let folder = folder_with_scene();
    // What runs in the background of a script inherits that interrupts are ignored, and keeps to it.
    let child = Command::new("env")
        .args(["--default-signal=INT", env!("CARGO_BIN_EXE_solidtrace")])
        .args(["render", "room.ron", "--spp", "100000000", "--time", "60s"])
        .current_dir(folder.path())
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupt.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("interrupted"),
        "{}",
        stderr(&output)
    );
    assert!(read_exr(&folder.path().join("room.exr")).is_ok());
}

#[test]
fn trace_answers_a_million_rays_as_the_library_does() {
    const RAYS: i32 = 1_000_000;
    let count = RAYS as usize;
    let folder = folder_with_scene();
    let path = folder.path();
    let mut rays = String::from("ox,oy,oz,dx,dy,dz,tmin,tmax\n");
    for i in 0..RAYS {
        let (x, y) = (
            f64::from(i % 1009) / 500.0 - 1.0,
            f64::from(i % 997) / 800.0 - 0.6,
        );
        let tmax = if i % 10 == 0 { "4.5" } else { "inf" };
        let tmin = i % 3;
        writeln!(rays, "0,1,5,{x},{y},-2.5,{tmin},{tmax}").unwrap();
    }
    fs::write(path.join("rays.csv"), rays).unwrap();
    let output = run(path, &["trace", "room.ron", "rays.csv", "-o", "hits.csv"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let output = run(path, &["trace", "room.ron", "rays.csv", "--any"]);
    let any = String::from_utf8(output.stdout).unwrap();

    let scene = read_scene(&path.join("room.ron"), &ReadOptions::default()).unwrap();
    let world = World::build(scene).unwrap();
    let rays = RayReader::open(&path.join("rays.csv"))
        .unwrap()
        .read(count + 1)
        .unwrap();
    let mut lines = csv::Reader::from_path(path.join("hits.csv")).unwrap();
    let header = "hit,t,px,py,pz,nx,ny,nz,u,v,object,primitive,material";
    assert_eq!(
        lines
            .headers()
            .unwrap()
            .iter()
            .collect::<Vec<_>>()
            .join(","),
        header
    );
    let lines: Vec<csv::StringRecord> = lines.records().map(Result::unwrap).collect();
    assert_eq!((lines.len(), any.lines().count()), (count, count + 1));
    let mut hits = 0;
    for ((ray, line), any) in rays.iter().zip(&lines).zip(any.lines().skip(1)) {
        assert_eq!(&line[0], &any[..1]);
        let Some(hit) = world.intersect(ray) else {
            assert_eq!(&line[0], "0");
            continue;
        };
        hits += 1;
        let point = world.surface(ray, &hit);
        let number = |i: usize| line[i].parse::<f64>().unwrap();
        assert_eq!(&line[0], "1");
        assert_eq!(number(1), hit.t);
        assert_eq!(DVec3::new(number(2), number(3), number(4)), point.p);
        let n = DVec3::new(number(5), number(6), number(7));
        let outward = point.ng.as_dvec3();
        let name = world.instance(&hit).name.clone();
        let turned = name.as_deref() == Some("floor") && outward.dot(ray.direction) > 0.0;
        assert_eq!(n, if turned { -outward } else { outward });
        assert_eq!(&line[10], name.unwrap_or_else(|| hit.instance.to_string()));
        assert_eq!(&line[11], hit.primitive.to_string());
        assert_eq!(&line[12], world.material(&point).name);
    }
    assert!(hits > RAYS / 5, "{hits}");
}

#[test]
fn a_bad_ray_is_an_error_with_its_place_and_no_output() {
    let folder = folder_with_scene();
    let path = folder.path();
    for (rays, place) in [
        (
            "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n0,0,0,zero,0,1\n",
            "rays.csv:3:7",
        ),
        ("ox,oy,oz,dx,dy,dz\n0,0,0,0,0,0\n", "rays.csv:2:7"),
        ("ox,oy,oz,dx,dy\n0,0,0,0,0\n", "rays.csv:1"),
        ("ox,oy,oz,dx,dy,dz\n0,0,NaN,0,0,1\n", "rays.csv:2:5"),
        ("ox,oy,oz,dx,dy,dz\n0,0,0,0,1\n", "rays.csv:2"),
        (
            "ox,oy,oz,dx,dy,dz,tmin,tmax\n0,0,0,0,1,0,3,2\n",
            "rays.csv:2:13",
        ),
        ("ox,oy,oz,dx,dy,dz,tmin\n0,0,0,0,1,0,-1\n", "rays.csv:2:13"),
    ] {
        fs::write(path.join("rays.csv"), rays).unwrap();
        let output = run(path, &["trace", "room.ron", "rays.csv", "-o", "hits.csv"]);
        assert_eq!(output.status.code(), Some(1), "{rays}");
        assert!(
            stderr(&output).contains(place),
            "{rays}: {}",
            stderr(&output)
        );
        assert!(!path.join("hits.csv").exists());
    }
}

#[test]
fn info_prints_one_json_object_and_nothing_else() {
    let folder = folder_with_scene();
    let output = run(folder.path(), &["info", "room.ron", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["instances"], 4);
    assert_eq!(json["solids"], 3);
    assert_eq!(json["planes"], 1);
    assert_eq!(json["lights"], 1);
    let text = run(folder.path(), &["info", "room.ron"]);
    assert!(String::from_utf8_lossy(&text.stdout).contains("3 solids, 1 planes"));
}

#[test]
fn every_integrator_renders_every_scene_that_ships() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = TempDir::new().unwrap();
    let mut scenes = 0;
    for entry in fs::read_dir(root.join("scenes")).unwrap() {
        let scene = entry.unwrap().path();
        if scene.extension().is_none_or(|e| e != "ron") {
            continue;
        }
        scenes += 1;
        for integrator in ["path", "whitted", "normals", "depth", "flat", "ao"] {
            let input = scene.to_str().unwrap();
            let args = [
                "render",
                input,
                "--size",
                "48x36",
                "--spp",
                "4",
                "--integrator",
                integrator,
                "-o",
                "a.exr",
                "--png",
                "a.png",
                "--force",
            ];
            let output = run(folder.path(), &args);
            assert!(
                output.status.success(),
                "{input} {integrator}: {}",
                stderr(&output)
            );
            let image = read_exr(&folder.path().join("a.exr")).unwrap();
            let values = image.channel("G").unwrap();
            let mean = values.iter().sum::<f32>() / values.len() as f32;
            let varied = values.iter().any(|v| (v - mean).abs() > 0.01 * mean);
            assert!(mean > 0.0 && varied, "{input} {integrator} shows something");
        }
    }
    assert!(scenes >= 4, "{scenes}");
}

#[test]
fn triangles_that_are_left_out_are_counted_and_a_mesh_without_any_other_is_an_error() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\n";
    fs::write(
        path.join("some.obj"),
        format!("{corners}f 1 2 3\nf 3 1 2\nf 1 2 4\n"),
    )
    .unwrap();
    let output = run(path, &["render", "some.obj", "--size", "8x8", "--spp", "1"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stderr(&output);
    assert!(
        text.contains("1 triangles without area and 1 duplicates"),
        "{text}"
    );
    fs::write(path.join("none.obj"), format!("{corners}f 1 2 4\n")).unwrap();
    let output = run(path, &["render", "none.obj"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("none.obj"), "{}", stderr(&output));
}

#[test]
fn generated_models_are_inputs_like_files_and_a_file_of_such_a_name_comes_first() {
    let folder = TempDir::new().unwrap();
    let triangles = |input: &str| {
        let output = run(folder.path(), &["info", input, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        info["triangles"].as_u64().unwrap()
    };
    assert_eq!(triangles("sphere:800"), 800);
    fs::write(
        folder.path().join("sphere:1.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    assert_eq!(triangles("sphere:1.obj"), 1);
    let output = run(folder.path(), &["render", "spere:800"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("did you mean `sphere`?"));
}

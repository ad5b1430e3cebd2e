//! `solidtrace render`.

use std::fs;
use std::path::Path;
use std::process::Command;

use solidtrace::image::Image;
use solidtrace::io::read_exr;
use tempfile::TempDir;

use super::{folder_with_scene, run, stderr};

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
    let green = |image: &Image| image.channel("G").unwrap().to_vec();
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
        for integrator in [
            "path", "direct", "whitted", "normals", "depth", "flat", "ao",
        ] {
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

fn noted(image: &Image, name: &str) -> Option<String> {
    let mut found = image.metadata.iter().filter(|(n, _)| n == name);
    found.next().map(|(_, value)| value.clone())
}

#[test]
fn noise_is_a_limit_to_the_samples_and_the_last_line_tells_how_many_there_were() {
    let folder = folder_with_scene();
    let path = folder.path();
    let render = |more: &[&str]| {
        let all = [&["render", "room.ron", "--force", "--noise", "0.3"], more].concat();
        let output = run(path, &all);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(stderr(&output).contains("100%"), "{}", stderr(&output));
        let line = String::from_utf8(output.stdout).unwrap();
        (line, read_exr(&path.join("room.exr")).unwrap())
    };
    let (line, image) = render(&["--spp", "300"]);
    let samples = image.channel("samples").unwrap();
    let mean = f64::from(samples.iter().sum::<f32>()) / samples.len() as f64;
    let told = format!("{mean:.1} of 300 spp in the mean, 100.0 % of the pixels");
    assert!(line.contains(&told), "{told}: {line}");
    assert!((32.0..200.0).contains(&mean));
    assert_eq!(noted(&image, "noise").unwrap(), "0.3");
    let (line, image) = render(&["--samples", "8..24", "--crop", "3,4,20,19"]);
    assert!(line.contains("16.0 of 16 spp in the mean, 0.0 %"), "{line}");
    let samples = image.channel("samples").unwrap();
    assert_eq!(samples.iter().filter(|&&n| n == 16.0).count(), 17 * 15);
    assert_eq!(
        samples.iter().filter(|&&n| n == 0.0).count(),
        40 * 30 - 17 * 15
    );
}

#[test]
fn a_time_limit_ends_the_search_for_little_noise_too() {
    let folder = folder_with_scene();
    let args = "render room.ron --spp 100000000 --time 1s --noise 1e-9 --layers strategies";
    let output = run(folder.path(), &args.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("stopped early"));
    let image = read_exr(&folder.path().join("room.exr")).unwrap();
    assert!(noted(&image, "incomplete").is_some());
    for name in ["G", "light.G", "bsdf.G", "samples"] {
        assert!(
            image.channel(name).unwrap().iter().any(|&x| x > 0.0),
            "{name}"
        );
    }
}

#[test]
fn layers_stand_beside_the_same_picture_in_exr_and_png() {
    let folder = folder_with_scene();
    let path = folder.path();
    let render = |more: &str| {
        let args = format!("render room.ron --force --quiet {more}");
        let output = run(path, &args.trim_end().split(' ').collect::<Vec<_>>());
        assert!(output.status.success(), "{}", stderr(&output));
        let png = fs::read(path.join("room.png")).unwrap();
        (read_exr(&path.join("room.exr")).unwrap(), png)
    };
    let (plain, png) = render("");
    let (layered, same_png) = render("--layers bounces,strategies --aov albedo,normal,depth");
    assert!(png == same_png);
    assert_eq!(
        (plain.channels.len(), layered.channels.len()),
        (3, 3 + 3 * 9 + 3 * 3 + 7)
    );
    for channel in &plain.channels {
        assert_eq!(
            layered.channel(&channel.name),
            Some(channel.values.as_slice())
        );
    }
    // The sky is seen directly, and nothing else in its pixels.
    assert_eq!(
        layered.channel("emitted.R").unwrap()[0],
        plain.channel("R").unwrap()[0]
    );
    let (depth, png) = render("--integrator depth --noise 0.5");
    let (_, same_png) = render("--integrator depth --layers normal,depth --noise 0.5");
    assert!(
        png == same_png,
        "the largest distance is that of the picture"
    );
    assert!(depth.channel("samples").is_some());
}

//! What the README shows works as it stands there.

use std::fs;
use std::path::Path;
use std::process::Command;

use solidtrace::scene::SceneDescription;
use tempfile::TempDir;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The lines of all blocks of one language.
fn blocks(language: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    let fence = format!("```{language}\n");
    (text.split(&fence).skip(1))
        .map(|rest| rest.split("```").next().unwrap().to_owned())
        .collect()
}

#[test]
fn the_commands_run() {
    let folder = TempDir::new().unwrap();
    for name in ["scenes", "assets"] {
        std::os::unix::fs::symlink(root().join(name), folder.path().join(name)).unwrap();
    }
    let mut count = 0;
    for line in blocks("sh").iter().flat_map(|block| block.lines()) {
        let with_embree = "tests/with-embree.sh cargo run --release --features embree -- ";
        let args = match line.strip_prefix(with_embree) {
            Some(args) if cfg!(feature = "embree") => Some(args),
            _ => line.strip_prefix("cargo run --release -- "),
        };
        // What takes longer is run by hand.
        let Some(args) = args.filter(|args| !args.ends_with("--rays 10000000")) else {
            continue;
        };
        count += 1;
        // A film has many frames: here they are small.
        let args = args.replace("--size 240x360 --spp 64", "--size 24x36 --spp 1");
        let mut command = Command::new(env!("CARGO_BIN_EXE_solidtrace"));
        command.args(args.split(' ')).current_dir(folder.path());
        if args.starts_with("render") && !args.contains("--size") {
            command.args(["--size", "64x36"]);
        }
        if args.starts_with("render") && !args.contains("--spp") {
            command.args(["--spp", "2"]);
        }
        if args.starts_with("check") && !args.contains("--rays") {
            command.args(["--rays", "20000"]);
        }
        let output = command.output().unwrap();
        assert!(
            output.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let film = ["turntable.mp4", "turntable.png"].map(|name| folder.path().join(name).is_file());
    assert!(film[0] != film[1], "a film, whether ffmpeg is there or not");
    assert!(count >= 5, "{count} commands found");
    for written in [
        "showcase.exr",
        "showcase.png",
        "girl.exr",
        "box.png",
        "normals.png",
    ] {
        assert!(folder.path().join(written).is_file(), "{written}");
    }
}

#[test]
fn the_scene_loads() {
    let [scene] = blocks("ron").try_into().unwrap();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("scene.ron");
    fs::write(&path, scene).unwrap();
    let scene = SceneDescription::read(&path).unwrap().load().unwrap();
    assert_eq!((scene.instances.len(), scene.csgs.len()), (5, 1));
}

#[test]
fn files_that_it_links_to_exist() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    for link in text
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
    {
        assert!(
            link.starts_with("https://") || root().join(link).exists(),
            "{link}"
        );
    }
}

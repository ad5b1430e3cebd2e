//! Films as people make them: numbered files, what is kept, animated PNGs, ffmpeg.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use solidtrace::io::read_exr;
use tempfile::TempDir;

/// A white ball that a camera passes by, and that lights itself: no noise where no edge is.
const SCENE: &str = r#"Scene(
    film: (size: (33, 21), spp: 4, filter: Box(radius: 0.5)),
    camera: Perspective(eye: (0, 0, 5), look_at: (0, 0, 0), vfov: 40, motion: Linear(keys: [
        (frame: 0), (frame: 4, eye: (4, 0, 5), look_at: (4, 0, 0)),
    ])),
    environment: Constant(color: (0.1, 0.4, 0.2)),
    materials: {"lamp": Emissive(radiance: (0.9, 0.1, 0.3))},
    objects: [Sphere(center: (0, 0, 0), radius: 0.8, material: "lamp")],
)"#;

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("pass.ron"), SCENE).unwrap();
    folder
}

fn command(folder: &Path, args: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_solidtrace"));
    command.args(args.split(' ')).current_dir(folder);
    command
}

fn run(folder: &Path, args: &str) -> Output {
    command(folder, args).output().unwrap()
}

#[track_caller]
fn succeeds(mut command: Command) -> String {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    String::from_utf8(output.stdout).unwrap()
}

#[track_caller]
fn fails(folder: &Path, args: &str, code: i32, part: &str) {
    let output = run(folder, args);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(said.contains(part), "`{part}` is not in\n{said}");
}

fn names(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = files
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .filter(|name| name != "pass.ron")
        .collect();
    names.sort();
    names
}

/// How many a second, and the frames' bytes.
type Film = (f64, (u32, u32), Vec<Vec<u8>>);

fn read_apng(path: &Path) -> Film {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap()))
        .read_info()
        .unwrap();
    let control = *reader.info().animation_control().expect("an animation");
    assert_eq!(control.num_plays, 0, "it repeats for ever");
    let size = reader.info().size();
    let mut frames = Vec::new();
    let mut fps = 0.0;
    for _ in 0..control.num_frames {
        let mut frame = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut frame).unwrap();
        let control = reader.info().frame_control().unwrap();
        assert_eq!((control.width, control.height), size);
        fps = f64::from(control.delay_den) / f64::from(control.delay_num);
        frames.push(frame);
    }
    (fps, size, frames)
}

fn read_png(path: &Path) -> Vec<u8> {
    image::open(path).unwrap().into_rgb8().into_raw()
}

#[test]
fn frames_are_numbered_files_each_as_its_camera_sees_it() {
    let folder = folder();
    let said = succeeds(command(
        folder.path(),
        "render pass.ron --frames 1..4 -o out.exr --png out.png",
    ));
    assert!(
        said.contains("out_0001.exr to out_0003.exr") && said.contains("3 frames"),
        "{said}"
    );
    let expected = [1, 2, 3].map(|i| [format!("out_000{i}.exr"), format!("out_000{i}.png")]);
    let mut expected = expected.concat();
    expected.sort();
    assert_eq!(names(folder.path()), expected);
    // Frame 2 is half way: the same as a still camera there, but for the noise at the ball's edge.
    let still = SCENE.replace(
        "eye: (0, 0, 5), look_at: (0, 0, 0)",
        "eye: (2, 0, 5), look_at: (2, 0, 0)",
    );
    fs::write(folder.path().join("still.ron"), still).unwrap();
    succeeds(command(
        folder.path(),
        "render still.ron --seed 2 -o still.exr",
    ));
    let [film, still] =
        ["out_0002.exr", "still.exr"].map(|name| read_exr(&folder.path().join(name)).unwrap());
    assert_eq!(film.channels, still.channels);
    let frame = film.metadata.iter().find(|(name, _)| name == "frame");
    assert_eq!(frame.unwrap().1, "2");
}

#[test]
fn frames_that_exist_are_kept_and_the_missing_ones_follow() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let film = "render pass.ron --frames 0..4 --png out.png";
    succeeds(command(folder.path(), film));
    let first = ["out_0000.png", "out_0002.png"].map(|name| fs::read(path(name)).unwrap());
    fs::remove_file(path("out_0002.png")).unwrap();
    fs::write(path("out_0001.png"), "mine").unwrap();
    let said = succeeds(command(folder.path(), film));
    assert!(said.contains("4 frames of which 3 were there"), "{said}");
    assert_eq!(fs::read(path("out_0001.png")).unwrap(), b"mine");
    assert!(fs::read(path("out_0002.png")).unwrap() == first[1]);
    succeeds(command(folder.path(), &format!("{film} --force")));
    assert!(fs::read(path("out_0000.png")).unwrap() == first[0]);
    assert!(
        fs::read(path("out_0001.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
}

#[test]
fn an_interrupted_film_keeps_its_whole_frames_and_goes_on_with_the_rest() {
    let folder = folder();
    let film = "render pass.ron --frames 0..60 --spp 256 --png out.png --video film.png";
    // What runs in the background of a script inherits that interrupts are ignored, and keeps to it.
    let child = Command::new("env")
        .args(["--default-signal=INT", env!("CARGO_BIN_EXE_solidtrace")])
        .args(film.split(' '))
        .current_dir(folder.path())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    while !folder.path().join("out_0001.png").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let id = child.id().to_string();
    let interrupt = Command::new("kill").args(["-INT", &id]).status();
    assert!(interrupt.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(
        said.contains("the same command goes on with the rest"),
        "{said}"
    );
    let there = names(folder.path());
    let expected = (0..there.len()).map(|i| format!("out_{i:04}.png"));
    assert_eq!(there, expected.collect::<Vec<_>>());
    assert!((2..60).contains(&there.len()));
    let said = succeeds(command(folder.path(), film));
    assert!(
        said.contains(&format!("of which {} were there", there.len())),
        "{said}"
    );
    assert_eq!(read_apng(&folder.path().join("film.png")).2.len(), 60);
}

#[test]
fn an_animated_png_has_every_frame_at_its_rate() {
    let folder = folder();
    succeeds(command(
        folder.path(),
        "render pass.ron --frames 0..5 --png out.png --video film.png --fps 12",
    ));
    let (fps, size, frames) = read_apng(&folder.path().join("film.png"));
    assert_eq!((fps, size), (12.0, (33, 21)));
    let numbered = |i: usize| read_png(&folder.path().join(format!("out_{i:04}.png")));
    assert_eq!(frames.len(), 5);
    for (i, frame) in frames.iter().enumerate() {
        assert!(*frame == numbered(i), "frame {i}");
    }
    assert!(frames[0] != frames[1]);
    // The same film again, now of files that are there.
    let said = succeeds(command(
        folder.path(),
        "render pass.ron --frames 0..5 --png out.png --video again.png --fps 12",
    ));
    assert!(said.contains("of which 5 were there"), "{said}");
    let [one, other] = ["film.png", "again.png"].map(|n| fs::read(folder.path().join(n)).unwrap());
    assert!(one == other);
    fails(
        folder.path(),
        "render pass.ron --frames 0..5 --png out.png --video third.png --size 20x20",
        1,
        "this frame is 33x21",
    );
    assert!(!folder.path().join("third.png").exists());
}

/// A folder with a program called ffmpeg, or without.
fn programs(script: Option<&str>) -> TempDir {
    let folder = TempDir::new().unwrap();
    if let Some(script) = script {
        let path = folder.path().join("ffmpeg");
        fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        fs::set_permissions(&path, mode).unwrap();
    }
    folder
}

#[test]
fn without_ffmpeg_a_film_is_an_animated_png_and_says_so() {
    let folder = folder();
    let mut without = command(folder.path(), "render pass.ron --turntable 3");
    let said = succeeds({
        without.env("PATH", programs(None).path());
        without
    });
    assert!(
        said.contains("pass.png (animated, as ffmpeg is not installed)"),
        "{said}"
    );
    assert_eq!(names(folder.path()), ["pass.png"]);
    let (fps, _, frames) = read_apng(&folder.path().join("pass.png"));
    assert_eq!((fps, frames.len()), (24.0, 3));
}

#[test]
fn when_ffmpeg_fails_its_words_are_shown_and_no_file_is_left() {
    let folder = folder();
    for script in [
        "echo no such encoder >&2; exit 3",
        "/bin/cat > /dev/null; echo no such encoder >&2; exit 3",
    ] {
        let programs = programs(Some(script));
        let mut film = command(
            folder.path(),
            "render pass.ron --turntable 3 --video out.mp4",
        );
        let output = film.env("PATH", programs.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(
            said.contains("no such encoder") && said.contains("out.mp4"),
            "{said}"
        );
        assert_eq!(names(folder.path()), [""; 0]);
    }
}

#[test]
fn with_ffmpeg_a_film_plays_in_its_colours() {
    let probe = |args: &[&str], path: &PathBuf| {
        let mut command = Command::new("ffprobe");
        command.args(["-v", "error", "-count_frames", "-of", "csv=p=0"]);
        command.args(args).arg(path).output()
    };
    let folder = folder();
    let path = folder.path().join("out.mp4");
    if probe(&["-version"], &path).is_err() {
        eprintln!("left out: ffmpeg and ffprobe are not installed");
        return;
    }
    let said = succeeds(command(
        folder.path(),
        "render pass.ron --turntable 6 --video out.mp4 --fps 10",
    ));
    assert!(said.starts_with("out.mp4: 6 frames"), "{said}");
    let stream = "stream=width,height,r_frame_rate,nb_read_frames";
    let shown = probe(&["-show_entries", stream], &path).unwrap();
    assert_eq!(
        String::from_utf8_lossy(&shown.stdout).trim(),
        "34,22,10/1,6"
    );
    let raw = Command::new("ffmpeg")
        .args(["-v", "error", "-i"])
        .arg(&path)
        .args(["-f", "rawvideo", "-pix_fmt", "rgb24", "pipe:1"])
        .output()
        .unwrap();
    assert_eq!(raw.stdout.len(), 6 * 34 * 22 * 3);
    // The environment and the lamp through sRGB's curve, as far as video keeps colours.
    let byte = |linear: f64| 255.0 * (1.055 * linear.powf(1.0 / 2.4) - 0.055);
    for (pixel, color) in [(0, [0.1, 0.4, 0.2]), (34 * 10 + 16, [0.9, 0.1, 0.3])] {
        let shown = &raw.stdout[3 * pixel..3 * pixel + 3];
        for (channel, linear) in color.into_iter().enumerate() {
            let off = f64::from(shown[channel]) - byte(linear);
            assert!(off.abs() < 12.0, "{shown:?} for {color:?}");
        }
    }
}

#[test]
fn mistakes_in_films_are_told_before_the_first_frame() {
    let folder = folder();
    let still = SCENE.replace("motion: Linear", "focus: None, motion: Linear");
    let (start, end) = (
        still.find("motion").unwrap(),
        still.find(")),\n    env").unwrap(),
    );
    let still = format!("{}{}", &still[..start], &still[end + 1..]);
    fs::write(folder.path().join("still.ron"), still).unwrap();
    let crossing = SCENE.replace("eye: (4, 0, 5), look_at: (4, 0, 0)", "eye: (0, 0, -5)");
    fs::write(folder.path().join("crossing.ron"), crossing).unwrap();
    fs::create_dir(folder.path().join("out_0001.png")).unwrap();
    for (args, code, part) in [
        ("render still.ron --frames 0..2", 2, "pass --turntable N"),
        (
            "render crossing.ron --frames 0..5",
            1,
            "at frame 2 the camera's eye and look_at",
        ),
        ("render pass.ron --frames 3..3", 2, "larger end"),
        (
            "render pass.ron --frames 0..4000000000",
            2,
            "at most 100000",
        ),
        (
            "render pass.ron --frames 0..2 --turntable 3",
            2,
            "cannot be used with",
        ),
        ("render pass.ron --turntable 0", 2, "0 is not in"),
        ("render pass.ron --video out.mp4", 2, "--frames"),
        ("render pass.ron --turntable 2 --fps 0", 2, "0 is not in"),
        (
            "render pass.ron --turntable 2 --time 1m",
            2,
            "cannot be used with",
        ),
        ("render pass.ron --turntable 2 --video out.gif", 2, "`.gif`"),
        (
            "render pass.ron --frames 0..2 --png out.png",
            1,
            "a folder has this name",
        ),
        (
            "render pass.ron --frames 0..2 --video nowhere/out.png",
            1,
            "does not exist",
        ),
    ] {
        fails(folder.path(), args, code, part);
    }
    fs::remove_dir(folder.path().join("out_0001.png")).unwrap();
    fs::remove_file(folder.path().join("still.ron")).unwrap();
    fs::remove_file(folder.path().join("crossing.ron")).unwrap();
    assert_eq!(names(folder.path()), [""; 0]);
    fs::write(folder.path().join("film.png"), "mine").unwrap();
    fails(
        folder.path(),
        "render pass.ron --turntable 2 --video film.png",
        1,
        "it exists already",
    );
    assert_eq!(fs::read(folder.path().join("film.png")).unwrap(), b"mine");
}

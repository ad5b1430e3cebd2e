//! Suns, skies and pictures of them.

use std::path::Path;

use solidtrace::image::{Channel, Image};
use solidtrace::io::{WriteOptions, write_image};
use solidtrace::light::Light;
use solidtrace::scene::{Scene, SceneDescription};

use super::{CAMERA, check, setting_fails};

#[test]
fn suns_must_be_possible() {
    let sun = |fields: &str| format!("lights: [Sun({fields})]");
    setting_fails(
        &sun("direction: «(0, 0, 0), irradiance: (1, 1, 1)"),
        &["`(0, 0, 0)`", "direction"],
    );
    setting_fails(
        "lights: [«Sun(irradiance: (1, 1, 1))]",
        &["needs the field `direction`"],
    );
    setting_fails(
        "lights: [«Sun(direction: (0, 1, 0))]",
        &["needs the field `irradiance`"],
    );
    let up = "direction: (0, 1, 0)";
    setting_fails(&sun(&format!("{up}, irradiance: (1, «-1, 1)")), &["`-1`"]);
    setting_fails(
        &sun(&format!(
            "{up}, irradiance: «(1, 1, 1), radiance: (1, 1, 1)"
        )),
        &["beside `radiance`", "remove one"],
    );
    setting_fails(
        &sun(&format!("{up}, radiance: «(1, 1, 1), angle: 0")),
        &["without extent", "`irradiance`"],
    );
    for angle in ["-1", "181", "1e-4"] {
        let fields = format!("{up}, irradiance: (1, 1, 1), angle: «{angle}");
        setting_fails(&sun(&fields), &[&format!("`{angle}`"), "`angle` of `Sun`"]);
    }
    setting_fails(
        &sun("direction: (elevation: «91, azimuth: 0), irradiance: (1, 1, 1)"),
        &["`91`", "-90..=90"],
    );
    setting_fails(
        &sun("direction: (elevation: 9, «asimuth: 0), irradiance: (1, 1, 1)"),
        &["did you mean `azimuth`?"],
    );
    setting_fails(
        "lights: [«Sum(direction: (0, 1, 0))]",
        &["did you mean `Sun`?"],
    );
}

#[test]
fn skies_must_be_possible() {
    let sky = |fields: &str| format!("environment: Sky({fields})");
    let sun = "sun: (elevation: 30, azimuth: 40)";
    setting_fails(
        "environment: «Sky(turbidity: 3)",
        &["needs the field `sun`"],
    );
    setting_fails(
        &sky(&format!("{sun}, turbidity: «0.5")),
        &["`0.5`", "1..=10"],
    );
    setting_fails(
        &sky(&format!("{sun}, ground: (0, «2, 0)")),
        &["`2`", "`ground` of `Sky`"],
    );
    setting_fails(
        &sky(&format!("{sun}, scale: «-1")),
        &["`-1`", "`scale` of `Sky`"],
    );
    setting_fails(
        &sky(&format!("{sun}, disk: «1")),
        &["`1`", "`true` or `false`"],
    );
    setting_fails(&sky("sun: «(1, 2)"), &["2 values"]);
}

/// Loads a scene in `folder` whose environment is the picture there; errors that point into the scene are looked at.
fn load(folder: &Path, name: &str, content: &[u8]) -> Result<Scene, solidtrace::Error> {
    std::fs::write(folder.join(name), content).unwrap();
    let text = format!("({CAMERA},\n objects: [], environment: Image(file: \"{name}\"))");
    SceneDescription::from_text(folder.join("a.ron"), &text)?.load()
}

#[test]
fn pictures_of_the_sky_must_be_whole() {
    let folder = tempfile::tempdir().unwrap();
    let marked = format!("({CAMERA},\n objects: [], environment: Image(file: «\"none.hdr\"))");
    let error = SceneDescription::from_text(folder.path().join("a.ron"), &marked.replace('«', ""))
        .and_then(|d| d.load())
        .unwrap_err();
    check(&error, &marked, &["`none.hdr`"]);
    setting_fails(
        "environment: «Image(rotate: 3)",
        &["needs the field `file`"],
    );
    setting_fails(
        "environment: Image(file: \"a.hdr\", scale: «1e7)",
        &["`1e7`", "`scale` of `Image`"],
    );

    let header =
        |size: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    let cut = [header("-Y 2 +X 4"), vec![128, 128, 128, 129, 1]].concat();
    for (name, content) in [
        ("cut.hdr", cut),
        ("flat.hdr", header("-Y 0 +X 4")),
        ("huge.hdr", header("-Y 100000 +X 100000")),
        ("text.hdr", b"no picture".to_vec()),
        ("empty.exr", Vec::new()),
    ] {
        let error = load(folder.path(), name, &content).expect_err(name);
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn pixels_that_are_no_light_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.exr");
    let exr = |strange: f32| {
        let mut values = vec![1.0; 8];
        values[6] = strange;
        let channels = ["R", "G", "B"].map(|name| Channel {
            name: name.to_owned(),
            values: values.clone(),
        });
        let image = Image {
            width: 4,
            height: 2,
            channels: channels.to_vec(),
            metadata: Vec::new(),
        };
        let options = WriteOptions {
            overwrite: true,
            ..WriteOptions::default()
        };
        write_image(&file, &image, &options).unwrap();
        load(folder.path(), "a.exr", &std::fs::read(&file).unwrap())
    };
    for strange in [f32::NAN, f32::INFINITY, 2e12] {
        let error = exr(strange).expect_err("taken");
        let report = error.to_string();
        assert!(
            report.contains("pixel (2, 1)") && report.contains("a.exr"),
            "{report}"
        );
    }
    assert_eq!(exr(0.0).unwrap().warnings, Vec::<String>::new());
    let scene = exr(-3.0).unwrap();
    assert!(
        scene.warnings[0].contains("pixel (2, 1)"),
        "{:?}",
        scene.warnings
    );
    let Light::Environment(map) = &scene.lights[0] else {
        panic!("{:?}", scene.lights);
    };
    // The third of four columns, in the lower half: between +x and +z, below.
    let (shown, _) = map.beyond(glam::DVec3::new(1.0, -1.5, -1.0).normalize());
    assert!(
        shown.min_element() >= 0.0 && shown.max_element() < 0.5,
        "{shown}"
    );
}

#[test]
fn radiance_hdr_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    // One pixel, not compressed: mantissas over 256, times 2 to the exponent less 128.
    let content = [
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".as_slice(),
        &[128, 64, 32, 132],
    ]
    .concat();
    let scene = load(folder.path(), "sun.hdr", &content).unwrap();
    let Light::Environment(map) = &scene.lights[0] else {
        panic!("{:?}", scene.lights);
    };
    assert_eq!(map.beyond(glam::DVec3::X).0, glam::Vec3::new(8.0, 4.0, 2.0));
}

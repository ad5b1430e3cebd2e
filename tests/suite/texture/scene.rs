//! Textures in scene files.

use glam::DVec3;
use solidtrace::color::Rgb;
use solidtrace::material::{Material, Relief, Surface};
use solidtrace::scene::SceneDescription;
use solidtrace::texture::{Pattern, PixelFilter, Ramp, Sampling, Texture, Wrap};
use solidtrace::{Error, Result};
use tempfile::TempDir;

use super::at;

/// A folder with a picture of one pixel, (128, 0, 255), and a file that is none.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let pixel = image::RgbImage::from_raw(1, 1, vec![128, 0, 255]).unwrap();
    pixel.save(folder.path().join("a.png")).unwrap();
    std::fs::write(folder.path().join("text.png"), "this is text").unwrap();
    folder
}

fn materials(textures: &str, materials: &str) -> Result<Vec<Material>> {
    let folder = folder();
    let text = format!(
        "(camera: Perspective(eye: (0, 0, 9), look_at: (0, 0, 0), vfov: 45), objects: [],\n textures: {{{textures}}},\n materials: {{{materials}}})"
    );
    let description = SceneDescription::from_text(folder.path().join("a.ron"), &text)?;
    Ok(description.load()?.materials)
}

/// What `color` is, with `textures` to name.
fn color(textures: &str, color: &str) -> Texture {
    let found = materials(textures, &format!("\"m\": Diffuse(color: {color})")).unwrap();
    let Surface::Diffuse { color } = found[0].surface.clone() else {
        panic!("{found:?}");
    };
    color
}

fn pattern(pattern: Pattern, a: Rgb, b: Rgb) -> Texture {
    let colors = Ramp::between(a, b);
    Texture::Pattern { pattern, colors }
}

#[test]
fn patterns_are_as_written_and_have_the_reports_values_where_nothing_is_said() {
    let marble = Pattern::Marble {
        grain: 15.0,
        octaves: 40,
        alpha: 0.5,
    };
    let wood = Pattern::Wood {
        grain: 15.0,
        octaves: 5,
    };
    assert_eq!(color("", "Marble()"), pattern(marble, Rgb::ONE, Rgb::ZERO));
    let (light, dark) = (Rgb::new(0.8, 0.5, 0.2), Rgb::new(0.4, 0.2, 0.1));
    assert_eq!(color("", "Wood"), pattern(wood, light, dark));
    assert_eq!(
        color("", "Wood(b: (0, 0, 1))"),
        pattern(wood, light, Rgb::Z)
    );
    let noise = Pattern::Noise {
        scale: 2.0,
        octaves: 3,
    };
    let ramp = "Noise(scale: 2, octaves: 3, ramp: [(-1, 0), (0.5, (1, 0, 0)), (1, 1)])";
    let stops = vec![(-1.0, Rgb::ZERO), (0.5, Rgb::X), (1.0, Rgb::ONE)];
    let colors = Ramp::new(stops).unwrap();
    let expected = Texture::Pattern {
        pattern: noise,
        colors,
    };
    assert_eq!(color("", ramp), expected);
    let squares = Pattern::UvChecker { step: 0.5 };
    assert_eq!(
        color("", "UvChecker(a: 0.2, b: (1, 0, 0), step: 0.5)"),
        pattern(squares, Rgb::splat(0.2), Rgb::X)
    );
    for plain in [
        "Turbulence()",
        "Clouds(cover: 0.3)",
        "Rings(step: 2, grain: 1)",
        "Fire()",
    ] {
        assert!(
            matches!(color("", plain), Texture::Pattern { .. }),
            "{plain}"
        );
    }
}

#[test]
fn names_stand_for_their_textures_in_colours_and_in_textures() {
    let textures = r#""half": 0.5, "red": Scale(of: "half", by: (1, 0, 0)),
        "both": Mix(a: "red", b: (0, 0, 1), by: "half"),
        "far": Transform(of: Checker(), transform: [Translate((0.5, 0, 0))])"#;
    let of = |name: &str| color(textures, name).eval(&at(DVec3::new(0.2, 0.5, 0.5)));
    assert_eq!(of("\"half\""), Rgb::splat(0.5));
    assert_eq!(of("\"red\""), Rgb::new(0.5, 0.0, 0.0));
    assert_eq!(of("\"both\""), Rgb::new(0.25, 0.0, 0.5));
    assert_eq!(of("\"far\""), Rgb::ZERO);
    assert_eq!(of("Checker()"), Rgb::ONE);
}

#[test]
fn pictures_are_colours_or_data_by_their_use_unless_they_say() {
    let texture = r#""t": Image(file: "a.png", wrap: Mirror, filter: Nearest)"#;
    let sampling = Sampling {
        wrap: [Wrap::Mirror; 2],
        filter: PixelFilter::Nearest,
    };
    let Texture::Image {
        sampling: found, ..
    } = color(texture, "\"t\"")
    else {
        panic!("no picture");
    };
    assert_eq!(found, sampling);
    let (curve, share) = (
        Rgb::new(0.215_860_5, 0.0, 1.0),
        Rgb::new(128.0 / 255.0, 0.0, 1.0),
    );
    let middle = at(DVec3::ZERO);
    let near = |texture: Texture, expected| {
        let found = texture.eval(&middle);
        assert!(found.abs_diff_eq(expected, 1e-6), "{found}");
    };
    near(color(texture, "\"t\""), curve);
    near(
        color("", "Image(file: \"a.png\", color_space: Linear)"),
        share,
    );
    // What mixes is data, and the colours that it mixes are not.
    let mix = color(texture, "Mix(a: \"t\", b: \"t\", by: \"t\")");
    near(mix.clone(), curve);
    let Texture::Mix { by, .. } = mix else {
        panic!("no mix");
    };
    near((*by).clone(), share);
    let found = materials(
        texture,
        r#""a": Diffuse(color: "t", bump: (texture: "t", height: -0.25)),
        "b": Mirror(normal_map: (texture: "t")),
        "c": Mirror(normal_map: (texture: Image(file: "a.png", color_space: Srgb), scale: 0.5)),
        "d": Emissive(radiance: (2, 2, 2), texture: "t")"#,
    )
    .unwrap();
    let Some(Relief::Bump { texture, height }) = found[0].relief.clone() else {
        panic!("{:?}", found[0]);
    };
    assert_eq!(height, -0.25);
    near(texture, share);
    for (material, expected) in found[1..3].iter().zip([(share, 1.0), (curve, 0.5)]) {
        let Some(Relief::NormalMap { texture, scale }) = material.relief.clone() else {
            panic!("{material:?}");
        };
        near(texture, expected.0);
        assert_eq!(scale, expected.1);
    }
    assert!(found[3].emitted(&middle).abs_diff_eq(2.0 * curve, 1e-6));
}

#[track_caller]
fn fails(textures: &str, material: &str, parts: &[&str]) {
    let error: Error = materials(textures, &format!("\"m\": {material}")).unwrap_err();
    let report = error.to_string();
    let line = if textures.contains('«') { 2 } else { 3 };
    assert_eq!(error.place().and_then(|p| p.line), Some(line), "{report}");
    for part in parts {
        assert!(report.contains(part), "`{part}` is not in\n{report}");
    }
}

#[test]
fn names_that_lead_nowhere_or_in_circles_are_errors() {
    let marble = "\"marble\": Marble()";
    let named = |name: &str| format!("Diffuse(color: \"{name}\")");
    fails(
        marble,
        &named("marbel"),
        &["no texture `marbel`", "did you mean `marble`?"],
    );
    fails(
        marble,
        &named("Marble"),
        &["no texture `Marble`", "`marble`"],
    );
    fails("\"\": 1", &named("x"), &["no texture `x`"]);
    // The marks say in which of the two places the error is; names may hold anything.
    fails(
        "\"a«\": \"a«\"",
        "Mirror()",
        &["`a«` does not come before this one"],
    );
    fails(
        "\"a\": Scale(of: \"b«\", by: 1), \"b«\": \"a\"",
        "Mirror(color: \"b«\")",
        &["`b«` does not come before", "above it"],
    );
    fails("\"«\": \"nobody\"", "Mirror()", &["no texture `nobody`"]);
}

#[test]
fn textures_of_too_many_parts_are_errors_and_take_no_time() {
    let chain = |count: usize, next: fn(String) -> String| {
        let texture = |i: usize| match i {
            0 => "0.5".to_owned(),
            _ => next(format!("\"t{}\"", i - 1)),
        };
        let textures = (0..count).map(|i| format!("\"t{i}\": {}", texture(i)));
        textures.collect::<Vec<_>>().join(", ") + ", \"«\": 1"
    };
    fails(
        &chain(60, |t| format!("Mix(a: {t}, b: {t}, by: {t})")),
        "Diffuse(color: \"t59\")",
        &["more than 256", "each counts as often as it is used"],
    );
    fails(
        &chain(100_000, |t| t),
        "Diffuse(color: \"t99999\")",
        &["more than 64 names"],
    );
    let deep = format!("{}1{}", "Scale(by: 1, of: ".repeat(5000), ")".repeat(5000));
    fails(
        "",
        &format!("Diffuse(color: {deep})"),
        &["more than 32 textures"],
    );
}

#[test]
fn values_that_make_no_sense_are_errors() {
    let of = |texture: &str| format!("Diffuse(color: {texture})");
    for (texture, parts) in [
        ("Marbel()", &["`Marbel`", "did you mean `Marble`?"][..]),
        ("Marble(octaves: 0)", &["`0`", "`octaves` of `Marble`"]),
        ("Noise(scale: 0)", &["`0`", "`scale` of `Noise`", "above 0"]),
        ("Noise(a: 1.5)", &["`1.5`", "0..=1"]),
        ("1.5", &["`1.5`", "0..=1"]),
        ("Noise(ramp: [])", &["is no ramp"]),
        (
            "Noise(ramp: [(1, 0), (0, 1)])",
            &["is no ramp", "do not go down"],
        ),
        ("Noise(ramp: [(0, 1)], a: 1)", &["`a` and `b`"]),
        ("Clouds(cover: 2)", &["`2`", "`cover` of `Clouds`"]),
        (
            "Image(file: \"b.png\")",
            &["cannot read the file `b.png`", "did you mean `a.png`?"],
        ),
        (
            "Image(file: \"a.png\", wrap: Clmap)",
            &["did you mean `Clamp`?"],
        ),
        (
            "Image(file: \"a.png\", filter: Cubic)",
            &["`Cubic`", "Bilinear"],
        ),
        (
            "Image(file: \"a.png\", color_space: Sgrb)",
            &["did you mean `Srgb`?"],
        ),
        ("Scale(of: Noise(), by: 2)", &["`2`", "`by` of `Scale`"]),
        ("Transform(of: Noise(), transform: [Scale(0)])", &["`0`"]),
        ("Mix(a: 0, b: 1)", &["needs the field `by`"]),
    ] {
        fails("", &of(texture), parts);
    }
    fails(
        "",
        "Mirror(bump: (texture: 1, height: 1), normal_map: (texture: 1))",
        &["one of the two"],
    );
    fails(
        "",
        "Mirror(bump: (texture: 1))",
        &["needs the field `height`"],
    );
    fails(
        "",
        "Dielectric(ior: 1.5, bump: (texture: 1, hight: 1))",
        &["did you mean `height`?"],
    );
    // A file that is wrong is the place of its error.
    let error = materials("", "\"m\": Mirror(color: Image(file: \"text.png\"))").unwrap_err();
    assert!(error.to_string().contains("not a picture"), "{error}");
    assert!(error.place().unwrap().file.ends_with("text.png"));
}

#[test]
fn pictures_are_colours_where_colours_are_meant_and_data_where_numbers_are() {
    let found = materials(
        "\"t\": Image(file: \"a.png\")",
        "\"m\": Plastic(color: \"t\", roughness: \"t\")",
    );
    let Surface::Plastic {
        color, roughness, ..
    } = &found.unwrap()[0].surface
    else {
        panic!("no plastic");
    };
    let point = at(DVec3::ZERO);
    // Half of red is little light, and as a number half.
    assert!((color.eval(&point).x - 0.215_860_5).abs() < 1e-6);
    assert!((roughness.eval(&point).x - 128.0 / 255.0).abs() < 1e-6);
}

//! Text that is no scene, and text that is hostile.

use solidtrace::scene::SceneDescription;

use super::{CAMERA, fails, fails_as, object_fails};

#[test]
fn syntax_errors_point_at_the_token() {
    fails("(camera: «}", &["a value", "`}`"]);
    fails("(\n film: «(spp: 3,\n ", &["`(` is never closed"]);
    fails("(film: (spp: 3 «size: (1, 2)))", &["`,` or `)`", "`s`"]);
    fails("(«film (spp: 3))", &["need their names"]);
    fails("(film: (spp: «3x))", &["`3x` is not a number"]);
    fails("(film: «\"abc", &["never ends"]);
    fails("(film: \"ab«\\qc\")", &["`\\q`"]);
    fails("«/* (film: 3)", &["comment is never closed"]);
    fails(
        &format!("({CAMERA}, objects: []) «)"),
        &["the end of the file", "`)`"],
    );
    fails(" «", &["a value", "the end of the file"]);
    fails("[«1, 2]", &["the fields of `Scene`"]);
    fails("«Scne(film: ())", &["the fields of `Scene`"]);
}

#[test]
fn json_errors_point_at_the_value_too() {
    let json = |objects: &str| {
        format!(
            "{{\n \"camera\": {{\"Perspective\": {{\"eye\": [0, 0, 9], \"look_at\": [0, 0, 0], \"vfov\": 45}}}},\n \"objects\": [{objects}]}}"
        )
    };
    let fails = |objects: &str, parts: &[&str]| fails_as("test.json", &json(objects), parts);
    fails(
        "{\"Sphere\": {\"radius\": «-3}}",
        &["`-3`", "`radius` of `Sphere`"],
    );
    fails(
        "{\"Sphere\": {«\"raduis\": 3}}",
        &["did you mean `radius`?"],
    );
    fails("{«\"Spere\": {\"radius\": 3}}", &["did you mean `Sphere`?"]);
    fails(
        "{\"Sphere\": {\"radius\": 3, \"material\": «\"green\"}}",
        &["no material `green`"],
    );
    fails(
        "{\"Sphere\": {\"center\": «[0, 0], \"radius\": 3}}",
        &["2 values"],
    );
    fails("{\"Sphere\": «3}", &["the fields of `Sphere`"]);
    fails("{\"Sphere\": {\"radius\": 3, «}}", &["not valid JSON"]);
    fails(
        "{\"Sphere\": {\"radius\": 3}} «/* round */",
        &["not valid JSON"],
    );
}

#[test]
fn deep_nesting_is_an_error_and_no_overflow() {
    for open in ["(", "[", "{\"a\":", "Some("] {
        let error = SceneDescription::from_text("deep.ron", &open.repeat(100_000)).unwrap_err();
        assert!(
            error
                .message()
                .contains("65536 brackets inside one another"),
            "{error}"
        );
    }
    for (open, close) in [
        ("(", ")"),
        ("[", "]"),
        ("{\"a\":", "}"),
        ("Some(", ")"),
        ("a(b:", ")"),
    ] {
        let text = format!("{}1{}", open.repeat(65_000), close.repeat(65_000));
        let error = SceneDescription::from_text("deep.ron", &text).unwrap_err();
        assert!(!error.message().contains("brackets"), "{error}");
    }
    let nest = format!("{}1{}", "{\"a\":".repeat(65_000), "}".repeat(65_000));
    assert!(SceneDescription::from_text("deep.json", &nest).is_err());
    object_fails(
        &format!(
            "{}Union(of: [Sphere«(radius: 1){}",
            "Union(of: [".repeat(32_766),
            "])".repeat(32_767)
        ),
        &["more than 65536 brackets"],
    );
    let error = SceneDescription::from_text("deep.ron", &"/*".repeat(100_000)).unwrap_err();
    assert!(error.message().contains("comment"));
}

#[test]
fn no_mutation_of_a_scene_file_panics_or_loses_its_place() {
    let originals = [
        ("all.ron", crate::scene_file::RON),
        ("all.json", crate::scene_file::JSON),
    ];
    let pieces = [
        "(", ")", "[", "{", "\"", "\\u{", "-1", "1e999", "NaN", ",", ":", "é", "/*", "//", "#",
        "None", "r#\"", "\u{0}",
    ];
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let mut accepted = 0;
    for i in 0..4_000 {
        let (file, original) = originals[i % 2];
        let mut text: Vec<char> = original.chars().collect();
        for _ in 0..=random(3) {
            let at = random(text.len());
            match random(4) {
                0 => drop(text.remove(at)),
                1 => drop(text.splice(at..at, pieces[random(pieces.len())].chars())),
                2 => {
                    let end = (at + random(40)).min(text.len());
                    drop(text.drain(at..end));
                }
                _ => {
                    let other = random(text.len());
                    text.swap(at, other);
                }
            }
        }
        let text: String = text.into_iter().collect();
        match SceneDescription::from_text(file, &text).and_then(|d| d.load()) {
            Ok(_) => accepted += 1,
            Err(error) => {
                let place = error.place().expect("a place");
                let line = place.line.expect("a line");
                assert!(line <= text.lines().count() + 1, "{error}");
            }
        }
    }
    assert!(
        (20..2_000).contains(&accepted),
        "{accepted} of 4000 mutations accepted"
    );
}

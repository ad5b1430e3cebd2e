//! The plan of the house: imports point one way, and two things have only one place.

use std::fs;
use std::path::{Path, PathBuf};

/// Ground floor first; a room may use those before it.
const ROOMS: [&str; 22] = [
    "error",
    "math",
    "memory",
    "color",
    "image",
    "sampling",
    "geometry",
    "accel",
    "texture",
    "material",
    "bsdf",
    "light",
    "camera",
    "film",
    "scene",
    "io",
    "world",
    "integrator",
    "render",
    "embree",
    "check",
    "bench",
];

/// Above all rooms.
const ROOF: &str = "cli";

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Every source file below `src` with its room and its text without comments.
fn sources() -> Vec<(PathBuf, String, String)> {
    let mut found = Vec::new();
    files(&source(), &mut found);
    let read = |path: PathBuf| {
        let relative = path.strip_prefix(source()).unwrap();
        let first = relative.components().next().unwrap().as_os_str();
        let room = first.to_str().unwrap().trim_end_matches(".rs").to_owned();
        let text = fs::read_to_string(&path).unwrap();
        let code = |line: &str| line.split("//").next().unwrap_or("").to_owned();
        (
            path,
            room,
            text.lines().map(code).collect::<Vec<_>>().join("\n"),
        )
    };
    found.into_iter().map(read).collect()
}

fn rank(room: &str) -> usize {
    if room == ROOF {
        return ROOMS.len();
    }
    (ROOMS.iter().position(|r| *r == room))
        .unwrap_or_else(|| panic!("`{room}` is not in the plan: give it a place in ROOMS"))
}

/// The rooms that `code` names after `crate::`, inside of braces too.
fn imports(code: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        let items = match rest.strip_prefix('{') {
            Some(group) => {
                let mut depth = 1;
                let end = group.find(|c: char| {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    depth == 0
                });
                let mut names = Vec::new();
                let mut nested = 0;
                for part in group[..end.unwrap_or(0)].split_inclusive([',', '{', '}']) {
                    if nested == 0 {
                        names.push(part);
                    }
                    nested += i32::from(part.ends_with('{')) - i32::from(part.ends_with('}'));
                }
                names
            }
            None => vec![rest],
        };
        for item in items {
            let name: String = (item.trim_start().chars())
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            if name.starts_with(|c: char| c.is_lowercase()) {
                rooms.push(name);
            }
        }
    }
    rooms
}

#[test]
fn imports_point_to_lower_rooms_only() {
    let mut seen = 0;
    for (path, room, code) in sources() {
        if room == "lib" || room == "main" {
            continue;
        }
        for used in imports(&code) {
            seen += 1;
            assert!(
                used == room || rank(&used) < rank(&room),
                "{}: `{room}` must not use `{used}`",
                path.display()
            );
        }
    }
    assert!(
        seen > 100,
        "only {seen} imports found: is the search broken?"
    );
}

#[test]
fn grouped_imports_are_seen() {
    let code = "use crate::{math::{Ray, Bounds}, scene::Scene};\nlet x = crate::io::read();";
    assert_eq!(imports(code), ["math", "scene", "io"]);
}

#[test]
fn obvhs_and_unsafe_code_stay_in_their_rooms() {
    for (path, room, code) in sources() {
        let name = path.display();
        assert!(
            room == "accel" || room == "bench" || !code.contains("obvhs::"),
            "{name} names obvhs"
        );
        let kernels = path.components().any(|part| part.as_os_str() == "wide");
        assert!(
            ["embree", "memory"].contains(&room.as_str()) || kernels || !code.contains("unsafe "),
            "{name} is unsafe"
        );
    }
}

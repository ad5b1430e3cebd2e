//! Files that a scene refers to, and inputs.

use std::path::Path;

use solidtrace::ErrorKind;
use solidtrace::io::{ReadOptions, read_scene};
use solidtrace::scene::SceneDescription;

use super::{CAMERA, check, fails_as};

#[test]
fn files_are_looked_for_beside_the_scene() {
    fails_as(
        "test.ron",
        &format!("({CAMERA},\n objects: [Mesh(file: «\"none.obj\")])"),
        &["`none.obj`", "test.ron"],
    );
    fails_as(
        "test.ron",
        &format!(
            "({CAMERA}, objects: [], materials: {{\"a\": Diffuse(color: Image(file: «\"none.png\"))}})"
        ),
        &["`none.png`"],
    );
}

#[test]
fn files_outside_the_scenes_tree_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = |name: &str| {
        let path = root.path().join(name);
        std::fs::create_dir_all(&path).unwrap();
        path
    };
    let (scenes, assets, other) = (folder("scenes"), folder("assets"), folder("other"));
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for folder in [&scenes, &assets, &other] {
        std::fs::write(folder.join("girl.obj"), triangle).unwrap();
    }
    let load = |in_folder: &Path, file: &str, allow: &[&Path]| {
        let path = in_folder.join("test.ron");
        let marked = format!("({CAMERA}, objects: [Mesh(file: «\"{file}\")])");
        std::fs::write(&path, marked.replace('«', "")).unwrap();
        let options = ReadOptions {
            allow_paths: allow.iter().map(|p| p.to_path_buf()).collect(),
            ..ReadOptions::default()
        };
        let refusal = read_scene(&path, &options).err();
        let refusal = refusal.filter(|e| e.message().contains("outside"));
        if let Some(error) = &refusal {
            check(error, &marked, &[file, "--allow-path"]);
        }
        refusal.is_none()
    };
    assert!(load(&scenes, "girl.obj", &[]));
    assert!(load(&scenes, "../assets/girl.obj", &[]));
    assert!(!load(&scenes, "../other/girl.obj", &[]));
    assert!(load(&scenes, "../other/girl.obj", &[&other]));
    assert!(!load(&other, "../assets/girl.obj", &[]));
    assert!(!load(
        &scenes,
        other.join("girl.obj").to_str().unwrap(),
        &[]
    ));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(other.join("girl.obj"), scenes.join("link.obj")).unwrap();
        assert!(!load(&scenes, "link.obj", &[]));
    }
    let near = scenes.join("near.ron");
    let marked = format!("({CAMERA}, objects: [Mesh(file: «\"../assets/gril.obj\")])");
    std::fs::write(&near, marked.replace('«', "")).unwrap();
    let error = read_scene(&near, &ReadOptions::default()).unwrap_err();
    check(
        &error,
        &marked,
        &["`../assets/gril.obj`", "did you mean `girl.obj`?"],
    );
    assert_eq!(error.kind(), ErrorKind::Read);
}

#[test]
fn inputs_that_are_no_scene_are_named() {
    let options = ReadOptions::default();
    let missing = read_scene(Path::new("nowhere/none.ron"), &options).unwrap_err();
    assert_eq!(missing.kind(), ErrorKind::Read);
    assert!(missing.to_string().contains("nowhere/none.ron"));
    let picture = read_scene(Path::new("a.tiff"), &options).unwrap_err();
    assert!(picture.to_string().contains("`tiff`"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("latin1.ron");
    std::fs::write(&path, b"(film:\n \"\xe9\")").unwrap();
    let error = SceneDescription::read(&path).unwrap_err();
    let place = error.place().unwrap();
    assert_eq!((place.line, place.column), (Some(2), Some(3)));
    assert!(error.message().contains("0xe9"));
}

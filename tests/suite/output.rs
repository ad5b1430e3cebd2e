//! Files come out whole or not at all, and only where they may.

use std::fs;
use std::path::Path;

use solidtrace::ErrorKind;
use solidtrace::color::{Rgb, Tonemap};
use solidtrace::image::Image;
use solidtrace::io::{
    Precision, WriteOptions, check_image_path, check_writable, write_atomically, write_image,
};

const REPLACE: WriteOptions = WriteOptions {
    overwrite: true,
    tonemap: Tonemap::Srgb,
    precision: Precision::Float,
};

fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn the_extension_chooses_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::rgb(1, 1, &[Rgb::ONE]);
    for (name, magic) in [("a.exr", b"\x76\x2f\x31\x01"), ("a.PNG", b"\x89PNG")] {
        let path = folder.path().join(name);
        check_image_path(&path, false).unwrap();
        write_image(&path, &image, &WriteOptions::default()).unwrap();
        assert!(fs::read(&path).unwrap().starts_with(magic));
    }
    for name in ["a.jpg", "a", "a.exr.bak"] {
        let path = folder.path().join(name);
        for error in [
            write_image(&path, &image, &REPLACE).unwrap_err(),
            check_image_path(&path, true).unwrap_err(),
        ] {
            assert_eq!(error.kind(), ErrorKind::Usage);
            assert!(error.to_string().contains(".exr") && error.to_string().contains(".png"));
        }
    }
    assert_eq!(names_in(folder.path()), ["a.PNG", "a.exr"]);
}

#[test]
fn an_old_file_is_replaced_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.bin");
    check_writable(&path, false).unwrap();
    assert!(names_in(folder.path()).is_empty());
    write_atomically(&path, b"old", false).unwrap();
    for error in [
        write_atomically(&path, b"new", false).unwrap_err(),
        check_writable(&path, false).unwrap_err(),
    ] {
        assert_eq!(error.kind(), ErrorKind::Write);
        assert!(error.to_string().contains("--force"), "{error}");
        assert_eq!(error.place().unwrap().file, path);
    }
    assert_eq!(fs::read(&path).unwrap(), b"old");
    check_writable(&path, true).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"old");
    write_atomically(&path, b"new", true).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names_in(folder.path()), ["out.bin"]);
}

#[test]
fn what_cannot_be_written_is_an_error_before_and_after_the_render() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "old").unwrap();
    fs::create_dir(folder.path().join("taken.png")).unwrap();
    for (path, message) in [
        (file.join("out.png"), "is not a folder"),
        (folder.path().join("missing/out.png"), "does not exist"),
        (folder.path().join("taken.png"), "a folder has this name"),
        (folder.path().join(".."), "names no file"),
        (Path::new("/dev/null").to_owned(), "not a regular file"),
    ] {
        for overwrite in [false, true] {
            for error in [
                write_atomically(&path, b"new", overwrite).unwrap_err(),
                check_writable(&path, overwrite).unwrap_err(),
            ] {
                assert_eq!(error.kind(), ErrorKind::Write);
                assert!(error.message().contains(message), "{error}");
            }
        }
    }
    assert_eq!(fs::read(&file).unwrap(), b"old");
    assert_eq!(names_in(folder.path()), ["file", "taken.png"]);
}

#[test]
fn an_image_that_cannot_be_encoded_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["out.exr", "out.png"] {
        let path = folder.path().join(name);
        fs::write(&path, "old").unwrap();
        let mut image = Image::rgb(2, 1, &[Rgb::ONE; 2]);
        image.channels[2].values.pop();
        let error = write_image(&path, &image, &REPLACE).unwrap_err();
        assert_eq!(error.place().unwrap().file, path);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }
    assert_eq!(names_in(folder.path()), ["out.exr", "out.png"]);
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::process::Command;

    use super::*;

    const TARGET: &str = "SOLIDTRACE_TEST_TARGET";

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn a_new_file_has_the_permissions_of_any_other_and_an_old_one_keeps_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let ordinary = folder.path().join("ordinary");
        fs::write(&ordinary, "").unwrap();
        let path = folder.path().join("out");
        write_atomically(&path, b"new", false).unwrap();
        assert_eq!(mode(&path), mode(&ordinary));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        write_atomically(&path, b"newer", true).unwrap();
        assert_eq!(mode(&path), 0o640);
    }

    #[test]
    fn a_link_is_followed_and_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let target = elsewhere.path().join("target");
        fs::write(&target, "old").unwrap();
        let link = folder.path().join("link");
        symlink(&target, &link).unwrap();
        assert!(write_atomically(&link, b"new", false).is_err());
        write_atomically(&link, b"new", true).unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
        fs::remove_file(&target).unwrap();
        let error = write_atomically(&link, b"new", true).unwrap_err();
        assert!(error.message().contains("leads nowhere"), "{error}");
    }

    #[test]
    fn a_disk_that_fills_up_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        fs::write(&path, "old").unwrap();
        // A limit on the size of files stands for the full disk: the write fails half way.
        let child = Command::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" --exact output::unix::writes_a_megabyte --ignored"])
            .arg(std::env::current_exe().unwrap())
            .env(TARGET, &path)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&child.stdout);
        assert!(
            child.status.success() && text.contains("1 passed"),
            "{text}"
        );
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names_in(folder.path()), ["out"]);
    }

    #[test]
    #[ignore = "run by a_disk_that_fills_up_leaves_the_old_file_and_nothing_else"]
    fn writes_a_megabyte() {
        let Some(path) = std::env::var_os(TARGET) else {
            return;
        };
        let error = write_atomically(Path::new(&path), &vec![7; 1 << 20], true).unwrap_err();
        assert!(error.message().contains("too large"), "{error}");
    }
}

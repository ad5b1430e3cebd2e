//! Links the feature `embree` against an Embree outside the system's folders, where there is one.
//!
//! `SOLIDTRACE_EMBREE_PREFIX` names the folder of `libembree4.so`. `tests/with-embree.sh` sets it on systems whose
//! own Embree is too old; there the folder holds the C library, too, that this Embree was built for, and programs
//! that use it start with that library's dynamic linker.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=SOLIDTRACE_EMBREE_PREFIX");
    if env::var_os("CARGO_FEATURE_EMBREE").is_none() {
        return;
    }
    let Some(prefix) = env::var_os("SOLIDTRACE_EMBREE_PREFIX").map(PathBuf::from) else {
        return;
    };
    let folder = prefix.display();
    println!("cargo::rustc-link-search=native={folder}");
    // DT_RPATH, which is searched for the libraries of libraries too; DT_RUNPATH is not.
    println!("cargo::rustc-link-arg=-Wl,--disable-new-dtags,-rpath,{folder},-rpath-link,{folder}");
    if let Some(linker) = dynamic_linker(&prefix) {
        println!(
            "cargo::rustc-link-arg=-Wl,--dynamic-linker={}",
            linker.display()
        );
    }
}

/// The folder's own dynamic linker, such as `ld-linux-x86-64.so.2`.
fn dynamic_linker(prefix: &Path) -> Option<PathBuf> {
    let is_linker = |path: &PathBuf| {
        path.file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with("ld-linux"))
    };
    fs::read_dir(prefix)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .find(is_linker)
}

//! `solidtrace check`: its arbiter, what it finds wrong, and what it prints.

#[cfg(not(feature = "embree"))]
#[test]
fn without_embree_the_command_says_how_to_build_with_it() {
    for args in [&["check", "scene.ron", "--json"][..], &["check", "--help"]] {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_solidtrace"))
            .args(args)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("--features embree"), "{said}");
    }
}

#[cfg(feature = "embree")]
mod arbiter;
#[cfg(feature = "embree")]
mod command;

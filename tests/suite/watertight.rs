//! No ray leaves a closed mesh unseen. `cargo run --release --example watertight -- --rays 100000000`
//! is the long run of the same.

use crate::support::leaks::{cases, escaped};

#[test]
fn no_ray_escapes_from_a_closed_mesh() {
    for (name, case) in cases() {
        assert_eq!(escaped(&case, 200_000, 5), 0, "{name}");
    }
}

//! Temporary, replaced at merge: counts edges by their vertices' indices.

use std::collections::HashMap;
use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::geometry::Mesh;

pub(super) fn check_closed(path: &Path, _name: Option<&str>, mesh: &Mesh) -> Result<()> {
    let mut edges = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_insert(0) += 1;
        }
    }
    let open = |(&(from, to), &count): (&(&u32, &u32), &i32)| {
        count != 1 || edges.get(&(to, from)) != Some(&1)
    };
    if edges.iter().any(open) {
        return Err(Error::input("the mesh is not closed").at(Place::file(path)));
    }
    Ok(())
}

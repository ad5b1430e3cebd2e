//! Meshes that shall be operands of CSG must be closed; where one is not, its file's lines say where.

use std::path::Path;

use crate::error::{Place, Result};
use crate::geometry::Mesh;

use super::obj;

/// Checks that `mesh`, read from the model `path`, where it may have a `name`, is closed.
///
/// # Errors
/// Names the edges at which it is open, with lines of an OBJ file.
pub(super) fn check_closed(path: &Path, name: Option<&str>, mesh: &Mesh) -> Result<()> {
    let Some(openness) = mesh.openness() else {
        return Ok(());
    };
    let is_obj = (path.extension()).is_some_and(|extension| extension.eq_ignore_ascii_case("obj"));
    // Lines only help: a file that can no longer be read shall not hide what is wrong with the mesh.
    let lines = if is_obj && openness.open_edges() > 0 {
        obj::triangle_lines(path).unwrap_or_default()
    } else {
        Vec::new()
    };
    let line = |triangle: u32| lines.get(triangle as usize).copied();
    let first = (openness.edges.first()).and_then(|edge| line(edge.triangle));
    Err(openness.error(name, line).at(Place {
        line: first.map(|line| line as usize),
        ..Place::file(path)
    }))
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::check_closed;
    use crate::io::read_model;

    /// A cube without the face +x; faces begin in line 11, and one goes on in the next line.
    const OPEN: &str = "# a box without its last face\n\
        v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
        \nf 1 4 3 2\nf 5 6 7 8\nf 1 2 \\\n 6 5\nf 4 8 7 3\nf 1 5 8 4\n";

    #[test]
    fn open_edges_of_an_obj_file_have_their_lines() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("box.OBJ");
        let check = |text: &str| {
            std::fs::write(&path, text).unwrap();
            check_closed(&path, Some("box"), &read_model(&path).unwrap().meshes[0])
        };
        let error = check(OPEN).unwrap_err();
        let place = error.place().unwrap();
        assert_eq!((&place.file, place.line), (&path, Some(11)));
        let lines: Vec<&str> = error.message().lines().collect();
        assert_eq!(lines.len(), 5, "{error}");
        assert!(lines[0].starts_with("the mesh `box` is not closed: 4 boundary edges in 1 loop,"));
        // Triangles of the quads in lines 11, 12, 13 (and 14) and 15.
        for (line, end) in lines[1..].iter().zip([
            "(1, 1, -1) to (1, -1, -1), triangle 1, line 11",
            "(1, -1, 1) to (1, 1, 1), triangle 2, line 12",
            "(1, -1, -1) to (1, -1, 1), triangle 4, line 13",
            "(1, 1, 1) to (1, 1, -1), triangle 7, line 15",
        ]) {
            assert!(line.ends_with(end), "{line}: {end}");
        }
        assert_eq!(check(&format!("{OPEN}f 2 3 7 6\n")), Ok(()));
        let inverted = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n";
        assert!(
            check(inverted)
                .unwrap_err()
                .message()
                .contains("inside out")
        );
    }
}

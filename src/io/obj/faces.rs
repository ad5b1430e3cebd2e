//! The faces of an OBJ file, as triangles, and what else the prepass keeps for itself.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::error::Result;
use crate::geometry::triangulate;

use super::super::lines::{Line, Word};
use super::clean::Vertices;

/// What the prepass keeps for itself.
#[derive(Default)]
pub(super) struct Found {
    /// The names of materials that faces use, in order of first use.
    pub(super) slots: Vec<Slot>,
    /// For each triangle an index into `slots`.
    pub(super) triangle_slots: Vec<u32>,
    /// Arguments of `mtllib` with their lines.
    pub(super) libraries: Vec<(usize, String)>,
    /// Whether any corner has a texture coordinate.
    pub(super) uses_uvs: bool,
    /// Whether any corner has a normal.
    pub(super) uses_normals: bool,
    skipped: Tally,
    unknown: Tally,
}

/// A material's name and the line of the `usemtl` that brings it in; no name before the first.
#[derive(Clone, Default)]
pub(super) struct Slot {
    pub(super) name: String,
    pub(super) line: usize,
}

/// How many lines of a kind there are, with the first.
#[derive(Default)]
struct Tally {
    count: usize,
    line: usize,
    keyword: String,
}

/// Reads faces and what belongs to them.
#[derive(Default)]
pub(super) struct Faces {
    pub(super) found: Found,
    /// How many `v`, `vt` and `vn` lines came before this one: negative indices count back from here.
    seen: [usize; 3],
    material: Slot,
    /// The slot of `material`, once a face uses it.
    slot: Option<u32>,
    slot_of: HashMap<String, u32>,
    corners: Vec<[usize; 3]>,
    points: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Faces {
    /// Reads a line and appends the triangles of a face to `out`.
    pub(super) fn read(
        &mut self,
        line: Line<'_>,
        vertices: &Vertices,
        out: &mut Vec<u8>,
    ) -> Result<()> {
        let mut words = line.words();
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        match keyword.text {
            b"v" => self.seen[0] += 1,
            b"vt" => self.seen[1] += 1,
            b"vn" => self.seen[2] += 1,
            b"f" | b"fo" => {
                self.corners.clear();
                for word in words {
                    let corner = self.corner(line, word, vertices)?;
                    self.corners.push(corner);
                }
                self.face(line, keyword, vertices, out)?;
            }
            b"usemtl" => {
                self.material = Slot {
                    name: line.argument(),
                    line: line.number,
                };
                self.slot = self.slot_of.get(&self.material.name).copied();
            }
            b"mtllib" => (self.found.libraries).push((line.number, line.argument())),
            b"l" | b"p" | b"curv" | b"curv2" | b"surf" => self.found.skipped.add(line, keyword),
            // Grouping, display attributes, and what belongs to the free-form elements above.
            b"o" | b"g" | b"s" | b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp"
            | b"shadow_obj" | b"trace_obj" | b"usemap" | b"maplib" | b"ctech" | b"stech"
            | b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"parm" | b"trim" | b"hole"
            | b"scrv" | b"sp" | b"end" | b"con" => {}
            _ => self.found.unknown.add(line, keyword),
        }
        Ok(())
    }

    /// A corner's indices of position, coordinate and normal, counted from 0.
    fn corner(
        &mut self,
        line: Line<'_>,
        word: Word<'_>,
        vertices: &Vertices,
    ) -> Result<[usize; 3]> {
        // What is not given refers to the zeros that follow the file's own vertices.
        let mut corner = vertices.counts();
        for (kind, text) in word.text.split(|&b| b == b'/').enumerate() {
            if kind > 2 || (kind == 0 && text.is_empty()) {
                return Err(
                    (line.error(word, format!("{} is not a corner", word.shown())))
                        .help("write v, v/vt, v//vn or v/vt/vn"),
                );
            }
            if !text.is_empty() {
                corner[kind] = self.index(line, word, text, kind, vertices)?;
                self.found.uses_uvs |= kind == 1;
                self.found.uses_normals |= kind == 2;
            }
        }
        Ok(corner)
    }

    fn index(
        &self,
        line: Line<'_>,
        word: Word<'_>,
        text: &[u8],
        kind: usize,
        vertices: &Vertices,
    ) -> Result<usize> {
        let (total, seen) = (vertices.counts()[kind], self.seen[kind]);
        let Some(index) = integer(text) else {
            return Err(
                (line.error(word, format!("{} is not a corner", word.shown())))
                    .help("its indices are whole numbers"),
            );
        };
        let resolved = if index < 0 {
            usize::try_from(index.unsigned_abs())
                .ok()
                .and_then(|back| seen.checked_sub(back))
        } else {
            usize::try_from(index)
                .ok()
                .and_then(|i| i.checked_sub(1))
                .filter(|&i| i < total)
        };
        resolved.ok_or_else(|| {
            let name = ["v", "vt", "vn"][kind];
            let (message, help) = match index {
                0 => (
                    format!("{} has the {name} index 0", word.shown()),
                    "indices count from 1".to_owned(),
                ),
                1.. => (
                    format!(
                        "{} uses {name} {index}, but the file has {total}",
                        word.shown()
                    ),
                    format!("the file needs more `{name}` lines; it may be cut short"),
                ),
                _ => (
                    format!(
                        "{} uses {name} {index}, but only {seen} come before",
                        word.shown()
                    ),
                    "a negative index counts back from this line".to_owned(),
                ),
            };
            line.error(word, message).help(help)
        })
    }

    /// Hands on the triangles of `corners`.
    fn face(
        &mut self,
        line: Line<'_>,
        keyword: Word<'_>,
        vertices: &Vertices,
        out: &mut Vec<u8>,
    ) -> Result<()> {
        let count = self.corners.len();
        if count < 3 {
            return Err(
                (line.error(keyword, format!("the face has {count} corners")))
                    .help("a face needs at least 3"),
            );
        }
        self.triangles.clear();
        if count == 3 {
            self.triangles.push([0, 1, 2]);
        } else {
            self.points.clear();
            let point = |c: &[usize; 3]| vertices.positions[c[0]].as_dvec3();
            self.points.extend(self.corners.iter().map(point));
            triangulate(&self.points, &mut self.triangles);
        }
        let slot = self.current_slot();
        for triangle in &self.triangles {
            out.push(b'f');
            for &i in triangle {
                for (separator, index) in [b' ', b'/', b'/'].into_iter().zip(self.corners[i]) {
                    out.push(separator);
                    push_decimal(out, index + 1);
                }
            }
            out.push(b'\n');
            self.found.triangle_slots.push(slot);
        }
        Ok(())
    }

    fn current_slot(&mut self) -> u32 {
        *self.slot.get_or_insert_with(|| {
            let slot = self.found.slots.len() as u32;
            self.slot_of.insert(self.material.name.clone(), slot);
            self.found.slots.push(self.material.clone());
            slot
        })
    }
}

/// A whole number of at most 18 digits; faces are most of a file, so this is short and quick.
fn integer(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] | digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = digits.iter().fold(0, |n, d| 10 * n + i64::from(d - b'0'));
    Some(if negative { -value } else { value })
}

fn push_decimal(out: &mut Vec<u8>, mut n: usize) {
    let mut digits = [0; 20];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (n % 10) as u8;
        n /= 10;
        if n == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[start..]);
}

impl Tally {
    fn add(&mut self, line: Line<'_>, keyword: Word<'_>) {
        if self.count == 0 {
            self.line = line.number;
            self.keyword = keyword.shown();
        }
        self.count += 1;
    }

    fn warning(&self, file: &Path, what: &str) -> Option<String> {
        (self.count > 0).then(|| {
            format!(
                "{}:{}: {what}: {} lines ignored, the first begins with {}",
                file.display(),
                self.line,
                self.count,
                self.keyword
            )
        })
    }
}

impl Found {
    /// What the reader left out.
    pub(super) fn warnings(&self, file: &Path) -> Vec<String> {
        (self
            .skipped
            .warning(file, "points, lines and curves are not read")
            .into_iter())
        .chain(self.unknown.warning(file, "unknown keywords"))
        .collect()
    }
}

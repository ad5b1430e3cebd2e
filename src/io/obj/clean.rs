//! The prepass: checks every line that matters and passes on what `tobj` gets right.

use std::io::{BufRead, Read};
use std::path::Path;

use glam::Vec3;

use crate::error::{Error, Result};

use super::super::lines::{Line, Lines};
use super::super::read_file;
use super::faces::{Faces, Found};

/// Text is handed on in pieces of about this many bytes.
const PIECE: usize = 1 << 16;
/// Stands after the file's own vertices, for corners that lack a coordinate or a normal.
const MISSING: &[u8] = b"vt 0 0\nvn 0 0 0\n";

/// A stream of OBJ text that `tobj` reads correctly: all vertices, then all faces as triangles whose
/// corners have the same form throughout and count from the file's start.
///
/// Reads the file twice, vertices first, so that faces may name vertices that come after them.
pub(super) struct Cleaner<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    lines: Lines<'a>,
    stage: Stage,
    vertices: Vertices,
    faces: Faces,
    out: Vec<u8>,
    taken: usize,
    failure: Option<Error>,
}

enum Stage {
    Vertices,
    Faces,
}

/// The vertices of the whole file.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    uvs: usize,
    normals: usize,
}

impl<'a> Cleaner<'a> {
    pub(super) fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        Self {
            file,
            bytes,
            lines: Lines::new(file, bytes),
            stage: Stage::Vertices,
            vertices: Vertices::default(),
            faces: Faces::default(),
            out: Vec::new(),
            taken: 0,
            failure: None,
        }
    }

    /// What was found, once all has been read, or what stopped it.
    pub(super) fn finish(self) -> Result<Found> {
        self.failure.map_or(Ok(self.faces.found), Err)
    }

    /// Fills `out`; leaves it empty at the end only.
    fn refill(&mut self) -> Result<()> {
        while self.out.len() < PIECE {
            match (&self.stage, self.lines.next()) {
                (Stage::Vertices, Some(line)) => self.vertices.read(line, &mut self.out)?,
                (Stage::Vertices, None) => {
                    self.out.extend_from_slice(MISSING);
                    self.lines = Lines::new(self.file, self.bytes);
                    self.stage = Stage::Faces;
                }
                (Stage::Faces, Some(line)) => {
                    self.faces.read(line, &self.vertices, &mut self.out)?;
                }
                (Stage::Faces, None) => break,
            }
        }
        Ok(())
    }
}

/// For each triangle of the file the line of its face: a second reading, for errors about triangles.
pub(in crate::io) fn triangle_lines(file: &Path) -> Result<Vec<u32>> {
    let bytes = read_file(file)?;
    let mut out = Vec::new();
    let mut vertices = Vertices::default();
    let mut lines = Lines::new(file, &bytes);
    while let Some(line) = lines.next() {
        vertices.read(line, &mut out)?;
        out.clear();
    }
    let mut faces = Faces::default();
    let mut numbers = Vec::new();
    let mut lines = Lines::new(file, &bytes);
    while let Some(line) = lines.next() {
        let number = line.number as u32;
        faces.read(line, &vertices, &mut out)?;
        out.clear();
        numbers.resize(faces.found.triangle_slots.len(), number);
    }
    Ok(numbers)
}

impl Read for Cleaner<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Cleaner<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.taken == self.out.len() {
            self.out.clear();
            self.taken = 0;
            if let Err(e) = self.refill() {
                self.failure = Some(e);
                return Err(std::io::ErrorKind::InvalidData.into());
            }
        }
        Ok(&self.out[self.taken..])
    }

    fn consume(&mut self, count: usize) {
        self.taken += count;
    }
}

impl Vertices {
    fn read(&mut self, line: Line<'_>, out: &mut Vec<u8>) -> Result<()> {
        let mut words = line.words();
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        let (least, most) = match keyword.text {
            b"v" | b"vn" => (3, 3),
            b"vt" => (1, 2),
            _ => return Ok(()),
        };
        out.extend_from_slice(keyword.text);
        let mut values = [0.0; 3];
        let mut count = 0;
        for word in words.take(most) {
            values[count] = line.number(word)?;
            count += 1;
            out.push(b' ');
            out.extend_from_slice(word.text);
        }
        if count < least {
            return Err(line
                .error(keyword, format!("{} has {count} numbers", keyword.shown()))
                .help(format!("it needs {least}")));
        }
        for _ in count..most {
            out.extend_from_slice(b" 0");
        }
        out.push(b'\n');
        match keyword.text {
            b"v" => self.positions.push(Vec3::from_array(values)),
            b"vt" => self.uvs += 1,
            _ => self.normals += 1,
        }
        Ok(())
    }

    /// How many positions, coordinates and normals there are; the lines of [`MISSING`] come next.
    pub(super) fn counts(&self) -> [usize; 3] {
        [self.positions.len(), self.uvs, self.normals]
    }
}

//! Lines and words of text files, with their places for errors.

use std::path::Path;

use crate::error::{Error, Place, Result};

/// What most numbers that do not parse need to hear.
const NUMBER_HELP: &str = "write finite decimal numbers such as -0.25 or 1e-3";

/// The lines of a file: a byte-order mark is skipped, CRLF is a line's end, and a line that ends in `\`
/// goes on in the next (comments do not).
pub(super) struct Lines<'a> {
    file: &'a Path,
    rest: &'a [u8],
    number: usize,
    joined: Vec<u8>,
}

/// A line with its number, counted from 1; the first one's where several are joined.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) file: &'a Path,
    pub(super) number: usize,
    pub(super) text: &'a [u8],
}

/// What stands between white space, with its offset in the line.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    pub(super) start: usize,
    pub(super) text: &'a [u8],
}

impl<'a> Lines<'a> {
    pub(super) fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        Self {
            file,
            rest: without_bom(bytes),
            number: 0,
            joined: Vec::new(),
        }
    }

    /// The next line; borrows from here because joined lines are kept here.
    pub(super) fn next(&mut self) -> Option<Line<'_>> {
        let first = self.physical()?;
        let number = self.number;
        let mut text = first;
        if let Some(head) = continued(first) {
            self.joined.clear();
            self.joined.extend_from_slice(head);
            while let Some(more) = self.physical() {
                self.joined.push(b' ');
                let Some(head) = continued(more) else {
                    self.joined.extend_from_slice(more);
                    break;
                };
                self.joined.extend_from_slice(head);
            }
            text = &self.joined;
        }
        Some(Line {
            file: self.file,
            number,
            text,
        })
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n');
        let line = &self.rest[..end.unwrap_or(self.rest.len())];
        self.rest = end.map_or(&[], |end| &self.rest[end + 1..]);
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// `bytes` without UTF-8's byte-order mark.
pub(super) fn without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// The part before the continuation mark, if there is one. A comment may end in a folder's name: it is not continued.
fn continued(line: &[u8]) -> Option<&[u8]> {
    let head = line.strip_suffix(b"\\")?;
    (!line.trim_ascii_start().starts_with(b"#")).then_some(head)
}

impl<'a> Line<'a> {
    /// The words up to a comment.
    pub(super) fn words(self) -> Words<'a> {
        Words {
            text: self.text,
            at: 0,
        }
    }

    /// Everything from `word` to the line's end, for names with spaces.
    pub(super) fn tail(self, word: Word<'_>) -> String {
        String::from_utf8_lossy(self.text[word.start..].trim_ascii()).into_owned()
    }

    /// Everything after the keyword; empty if there is nothing.
    pub(super) fn argument(self) -> String {
        let text = self.text.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace);
        let tail = &text[end.unwrap_or(text.len())..];
        String::from_utf8_lossy(tail.trim_ascii()).into_owned()
    }

    /// The line as a place.
    pub(super) fn place(self) -> Place {
        Place::line(self.file, self.number, &String::from_utf8_lossy(self.text))
    }

    /// The place of byte `start` of the line.
    pub(super) fn place_at(self, start: usize) -> Place {
        let column = 1 + String::from_utf8_lossy(&self.text[..start]).chars().count();
        Place {
            column: Some(column),
            ..self.place()
        }
    }

    /// An error at a word.
    pub(super) fn error(self, word: Word<'_>, message: impl Into<String>) -> Error {
        Error::input(message).at(self.place_at(word.start))
    }

    /// The word as a finite number.
    pub(super) fn number(self, word: Word<'_>) -> Result<f32> {
        let parsed = std::str::from_utf8(word.text).ok();
        match parsed.and_then(|text| text.parse::<f32>().ok()) {
            Some(x) if x.is_finite() => Ok(x),
            Some(_) => Err(
                (self.error(word, format!("{} is not a finite number", word.shown())))
                    .help(NUMBER_HELP),
            ),
            None => Err(
                (self.error(word, format!("{} is not a number", word.shown()))).help(NUMBER_HELP),
            ),
        }
    }
}

impl Word<'_> {
    /// The word in quotes for a message; a long one is cut.
    pub(super) fn shown(self) -> String {
        let text = String::from_utf8_lossy(self.text);
        let mut shown: String = text
            .chars()
            .take(40)
            .flat_map(char::escape_default)
            .collect();
        if text.chars().nth(40).is_some() {
            shown.push_str("...");
        }
        format!("`{shown}`")
    }
}

/// Iterator over a line's words.
pub(super) struct Words<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Iterator for Words<'a> {
    type Item = Word<'a>;

    fn next(&mut self) -> Option<Word<'a>> {
        let rest = &self.text[self.at..];
        let start = self.at + rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = &self.text[start..];
        if rest[0] == b'#' {
            self.at = self.text.len();
            return None;
        }
        let length = rest.iter().position(u8::is_ascii_whitespace);
        self.at = start + length.unwrap_or(rest.len());
        Some(Word {
            start,
            text: &self.text[start..self.at],
        })
    }
}

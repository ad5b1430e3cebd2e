//! One error type for the whole crate: what is wrong, where, and what to do about it.

use std::fmt;
use std::path::{Path, PathBuf};

/// Result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// What kind of failure an [`Error`] reports; programs match on this, people read the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// A file or folder could not be read.
    Read,
    /// A file was read but what it holds is wrong.
    Input,
    /// A file or folder could not be written, or must not be.
    Write,
    /// An argument or setting is wrong.
    Usage,
}

/// A place inside a file: a line and column where known, else a pointer such as `/meshes/0`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// Column in characters, counted from 1.
    pub column: Option<usize>,
    /// JSON pointer or field path, for files without useful lines.
    pub pointer: Option<String>,
    /// The source line, shown with the column marked.
    pub excerpt: Option<String>,
}

impl Place {
    /// The file as a whole.
    pub fn file(file: impl AsRef<Path>) -> Self {
        Self {
            file: file.as_ref().to_owned(),
            ..Self::default()
        }
    }

    /// A line of a text file, with its text.
    pub fn line(file: impl AsRef<Path>, line: usize, excerpt: &str) -> Self {
        Self {
            line: Some(line),
            excerpt: Some(excerpt.to_owned()),
            ..Self::file(file)
        }
    }

    /// A line and column of a text file, with the line's text.
    pub fn column(file: impl AsRef<Path>, line: usize, column: usize, excerpt: &str) -> Self {
        Self {
            column: Some(column),
            ..Self::line(file, line, excerpt)
        }
    }

    /// The place `offset` bytes into `text`, the content of `file`.
    pub fn in_text(file: impl AsRef<Path>, text: &str, offset: usize) -> Self {
        let mut offset = offset.min(text.len());
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &text[..offset];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.matches('\n').count() + 1;
        let column = before[start..].chars().count() + 1;
        Self::column(
            file,
            line,
            column,
            text[start..].lines().next().unwrap_or(""),
        )
    }

    /// A JSON pointer or field path inside a file.
    pub fn pointer(file: impl AsRef<Path>, pointer: impl Into<String>) -> Self {
        Self {
            pointer: Some(pointer.into()),
            ..Self::file(file)
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        if let Some(pointer) = &self.pointer {
            write!(f, " at {pointer}")?;
        }
        let (Some(line), Some(excerpt)) = (self.line, &self.excerpt) else {
            return Ok(());
        };
        // A minified file can be one huge line: show the part around the mark.
        let mark = self.column.unwrap_or(1).saturating_sub(1);
        let start = mark.saturating_sub(80);
        let shown: String = excerpt
            .chars()
            .skip(start)
            .take(160)
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        let number = line.to_string();
        let gutter = " ".repeat(number.len());
        write!(f, "\n {gutter} |\n {number} | {shown}")?;
        if self.column.is_some() {
            write!(f, "\n {gutter} | {}^", " ".repeat(mark - start))?;
        }
        Ok(())
    }
}

/// What went wrong, where, and what to do. Made with [`Error::new`] and the builder methods.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error(Box<Parts>);

#[derive(Debug, Clone, PartialEq, Eq)]
struct Parts {
    kind: ErrorKind,
    message: String,
    place: Option<Place>,
    help: Option<String>,
}

impl Error {
    /// An error of `kind`; `message` names the offending value and starts in lower case.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self(Box::new(Parts {
            kind,
            message: message.into(),
            place: None,
            help: None,
        }))
    }

    /// A file's content is wrong.
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Input, message)
    }

    /// `path` could not be read because of `cause`.
    pub fn read(path: impl AsRef<Path>, cause: &std::io::Error) -> Self {
        let help = match cause.kind() {
            std::io::ErrorKind::NotFound => {
                "check the path; relative paths in a scene start at the scene file's folder"
            }
            std::io::ErrorKind::PermissionDenied => "check the file's permissions",
            _ => "check that it is a readable file",
        };
        Self::new(ErrorKind::Read, format!("cannot read the file: {cause}"))
            .at(Place::file(path))
            .help(help)
    }

    /// `path` could not be written because of `message`.
    pub fn write(path: impl AsRef<Path>, message: impl fmt::Display) -> Self {
        Self::new(
            ErrorKind::Write,
            format!("cannot write the file: {message}"),
        )
        .at(Place::file(path))
    }

    /// Says where; an inner place that is already known is kept.
    #[must_use]
    pub fn at(mut self, place: Place) -> Self {
        self.0.place.get_or_insert(place);
        self
    }

    /// Says what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(help.into());
        self
    }

    /// The kind of failure.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// The message alone, without place and help.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// Where, if known.
    pub fn place(&self) -> Option<&Place> {
        self.0.place.as_ref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.message)?;
        if let Some(place) = &self.0.place {
            write!(f, "\n --> {place}")?;
        }
        if let Some(help) = &self.0.help {
            write!(f, "\n help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

/// Help for a name that is not among `known`: the most similar one, or else all of them.
pub fn did_you_mean<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let distance = |name: &str| strsim::osa_distance(&found.to_lowercase(), &name.to_lowercase());
    let nearest = (known.iter()).min_by_key(|name| distance(name));
    match nearest {
        Some(name)
            if distance(name)
                <= (name.chars().count() / 3)
                    .max(1)
                    .min(name.len().saturating_sub(1)) =>
        {
            format!("did you mean `{name}`?")
        }
        Some(_) if known.len() <= 24 => format!("known here: {}", known.join(", ")),
        Some(_) => format!("{} names are known here, none of them similar", known.len()),
        None => "none is defined here".to_owned(),
    }
}

//! Scene files: RON, or the same model as JSON.
//!
//! The file becomes a tree whose nodes know their places, and the tree becomes a [`SceneDescription`], each value
//! checked where it is read, so that every error can point at what it is about.

mod camera;
mod fields;
mod materials;
mod objects;
mod operators;
mod parser;
mod sky;
mod strings;
mod textures;
mod transforms;
mod tree;
mod values;
mod view;

use std::panic::resume_unwind;
use std::path::Path;
use std::thread;

use serde::de::IgnoredAny;

use crate::error::{Error, ErrorKind, Place, Result};
use crate::scene::SceneDescription;
use crate::scene::description::{Offset, Source};

use self::fields::{Fields, named};
use self::parser::MAX_DEPTH;
use self::tree::{Fault, Node};
use super::read_file;

/// Stack for one more bracket inside the others, in bytes. What recurses (the parser, `ron`, dropping the tree) was
/// measured to take at most 1.3 KiB of it, and 9.7 KiB in a build without optimisation.
const STACK_PER_BRACKET: usize = 16 << 10;

impl SceneDescription {
    /// Reads and checks a scene file: `.json` is JSON, all else RON. Files that it names are not touched.
    ///
    /// # Errors
    /// Where the file cannot be read, or with the line and column of the first value that is wrong.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path)?;
        match std::str::from_utf8(&bytes) {
            Ok(text) => Self::from_text(path, text),
            Err(e) => {
                let valid = e.valid_up_to();
                let text = String::from_utf8_lossy(&bytes);
                Err(
                    Error::input(format!("the byte 0x{:02x} is not UTF-8", bytes[valid]))
                        .at(Place::in_text(path, &text, valid))
                        .help("save the file as UTF-8"),
                )
            }
        }
    }

    /// As [`SceneDescription::read`], with the content of `file` given: its extension says which format it is, and
    /// what the scene refers to is found relative to its folder.
    ///
    /// # Errors
    /// With the line and column of the first value that is wrong.
    pub fn from_text(file: impl AsRef<Path>, text: &str) -> Result<Self> {
        let source = Source {
            file: file.as_ref().to_owned(),
            text: text.strip_prefix('\u{feff}').unwrap_or(text).to_owned(),
        };
        let json = (source.file.extension()).is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let description = with_room_for(&source, || {
            let root = parser::parse(&source.text)?;
            conforms(&source.text, json)?;
            scene(&root)
        });
        match description? {
            Ok(description) => Ok(Self {
                source,
                ..description
            }),
            Err(fault) => {
                let error = Error::input(fault.message).at(source.place(Offset(fault.offset)));
                Err(match fault.help {
                    Some(help) => error.help(help),
                    None => error,
                })
            }
        }
    }
}

/// Calls `read` on a stack on which it cannot run out however deep the text nests: all readers of it recurse, and
/// none deeper than it has brackets, of which the parser bounds the depth. Only what is used of a stack takes memory.
fn with_room_for<T: Send>(source: &Source, read: impl FnOnce() -> T + Send) -> Result<T> {
    let brackets = source.text.bytes().filter(|b| b"([{".contains(b)).count();
    let stack = (64 + brackets.min(MAX_DEPTH)) * STACK_PER_BRACKET;
    thread::scope(|scope| {
        let builder = thread::Builder::new().stack_size(stack);
        let reader = builder.spawn_scoped(scope, read).map_err(|e| {
            let message = format!("no thread with a stack of {stack} bytes to read the scene: {e}");
            Error::new(ErrorKind::Read, message).at(Place::file(&source.file))
        })?;
        Ok((reader.join()).unwrap_or_else(|panic| resume_unwind(panic)))
    })
}

fn scene(root: &Node) -> tree::Result<SceneDescription> {
    let mut f = Fields::of(root, "Scene")?;
    let default = SceneDescription::default();
    let film = f.or("film", default.film, view::film)?;
    let integrator = f.or("integrator", default.integrator, view::integrator)?;
    let environment = f.or("environment", default.environment, view::environment)?;
    let mut cameras = Vec::new();
    cameras.extend(f.optional("camera", |node| camera::camera(node, None))?);
    cameras.extend(f.or("cameras", Vec::new(), |node| {
        named(node, |name, node| camera::camera(node, Some(&name.text)))
    })?);
    if cameras.is_empty() {
        // Not there, or misspelt: this says which.
        f.required("camera", |node| camera::camera(node, None))?;
    }
    let lights = f.or("lights", Vec::new(), |node| {
        node.items()?.iter().map(view::light).collect()
    })?;
    let textures = f.or("textures", Vec::new(), |node| {
        named(node, |name, node| {
            Ok((name.text.clone().into_owned(), node.texture()?))
        })
    })?;
    let materials = f.or("materials", Vec::new(), |all| {
        named(all, |name, node| materials::material(node, &name.text, all))
    })?;
    let definitions = f.or("definitions", Vec::new(), |node| {
        named(node, |name, node| {
            Ok((name.text.clone().into_owned(), objects::object(node)?))
        })
    })?;
    let objects = f.required("objects", |node| {
        node.items()?.iter().map(objects::object).collect()
    })?;
    f.finish()?;
    Ok(SceneDescription {
        film,
        integrator,
        cameras,
        environment,
        lights,
        textures,
        materials,
        objects,
        definitions,
        ..default
    })
}

/// Whether other readers of the format take the text as well: what the tree's parser tolerates beyond it is refused.
fn conforms(text: &str, json: bool) -> tree::Result<()> {
    let line_start = |line: usize| -> usize {
        let lines = text.split_inclusive('\n').map(str::len);
        lines.take(line.saturating_sub(1)).sum()
    };
    if json {
        return serde_json::from_str::<IgnoredAny>(text)
            .map(drop)
            .map_err(|e| {
                let offset = line_start(e.line()) + e.column().saturating_sub(1);
                let message = e.to_string();
                let message = message.split(" at line ").next().unwrap_or_default();
                Fault::new(offset, format!("not valid JSON: {message}"))
            });
    }
    // The depth of the tree is limited already, and `ron` takes time in proportion to the text at any depth.
    let options = ron::Options::default().without_recursion_limit();
    options.from_str::<IgnoredAny>(text).map(drop).map_err(|e| {
        let start = line_start(e.span.end.line);
        let column = e.span.end.col.saturating_sub(1);
        let offset = text[start..]
            .char_indices()
            .nth(column)
            .map_or(text.len(), |(i, _)| start + i);
        Fault::new(offset, format!("not valid RON: {}", e.code))
    })
}

//! A scene file's text as a tree whose every node knows where it stands.

use std::borrow::Cow;

/// What is wrong in a text, and where.
#[derive(Debug)]
pub(super) struct Fault {
    /// Bytes from the start of the text.
    pub(super) offset: usize,
    /// Names the offending value.
    pub(super) message: String,
    /// What to do about it.
    pub(super) help: Option<String>,
    /// The message says already which field it speaks of.
    pub(super) names_field: bool,
}

/// What reading gives.
pub(super) type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    pub(super) fn new(offset: usize, message: impl Into<String>) -> Self {
        Self {
            offset,
            message: message.into(),
            help: None,
            names_field: false,
        }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// A piece of text and where it starts.
#[derive(Debug)]
pub(super) struct Word<'t> {
    pub(super) offset: usize,
    pub(super) text: Cow<'t, str>,
}

/// A value with the bytes that spell it.
#[derive(Debug)]
pub(super) struct Node<'t> {
    pub(super) offset: usize,
    pub(super) source: &'t str,
    pub(super) value: Value<'t>,
}

#[derive(Debug)]
pub(super) enum Value<'t> {
    Number(f64),
    String(Cow<'t, str>),
    /// A bare word such as `true`, `None`, `Srgb`.
    Word(&'t str),
    /// `[..]`, or `(..)` with an optional name before it.
    List(Option<&'t str>, Vec<Node<'t>>),
    /// `{..}`, or `(a: ..)` with an optional name before it.
    Fields(Option<&'t str>, Vec<(Word<'t>, Node<'t>)>),
}

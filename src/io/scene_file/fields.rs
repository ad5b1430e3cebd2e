//! Reading records and choices from the tree, with an error for every field that is missing, unknown or repeated.

use crate::error::did_you_mean;

use super::tree::{Fault, Node, Result, Value, Word};

/// The fields of one record, taken one after the other by name.
pub(super) struct Fields<'n, 't> {
    /// What they describe, for messages.
    what: &'n str,
    offset: usize,
    entries: &'n [(Word<'t>, Node<'t>)],
    asked: Vec<&'static str>,
}

impl<'n, 't> Fields<'n, 't> {
    /// The fields of a record without a name, or called `what`.
    pub(super) fn of(node: &'n Node<'t>, what: &'n str) -> Result<Self> {
        let (name, body) = match &node.value {
            Value::Fields(name, entries) => (name, Body::Fields(entries)),
            Value::List(name, items) => (name, Body::Items(items)),
            _ => return Err(node.fault(&format!("the fields of `{what}`"))),
        };
        if name.is_some_and(|name| name != what) {
            return Err(node.fault(&format!("the fields of `{what}`")));
        }
        let choice = Choice {
            name: what,
            offset: node.offset,
            body,
        };
        choice.fields()
    }

    fn new(what: &'n str, offset: usize, entries: &'n [(Word<'t>, Node<'t>)]) -> Result<Self> {
        reject_duplicates(entries)?;
        Ok(Self {
            what,
            offset,
            entries,
            asked: Vec::new(),
        })
    }

    /// A field as it stands, if it is there.
    pub(super) fn raw(&mut self, name: &'static str) -> Option<&'n Node<'t>> {
        self.asked.push(name);
        let found = self.entries.iter().find(|(key, _)| key.text == name);
        found.map(|(_, node)| node)
    }

    /// A field that may be left out or `None`.
    pub(super) fn optional<T>(
        &mut self,
        name: &'static str,
        read: impl FnOnce(&'n Node<'t>) -> Result<T>,
    ) -> Result<Option<T>> {
        let node = self.raw(name).filter(|node| !node.is_none());
        node.map(|node| self.name_field(name, read(node)))
            .transpose()
    }

    /// A field that has a value where it is left out.
    pub(super) fn or<T>(
        &mut self,
        name: &'static str,
        default: T,
        read: impl FnOnce(&'n Node<'t>) -> Result<T>,
    ) -> Result<T> {
        let value = self.raw(name).map(|node| self.name_field(name, read(node)));
        value.unwrap_or(Ok(default))
    }

    /// A field that must be there.
    pub(super) fn required<T>(
        &mut self,
        name: &'static str,
        read: impl FnOnce(&'n Node<'t>) -> Result<T>,
    ) -> Result<T> {
        if let Some(node) = self.raw(name) {
            return self.name_field(name, read(node));
        }
        // A misspelt field is the likelier mistake than a forgotten one.
        let suspect = (self.entries.iter()).find(|(key, _)| {
            !self.asked.contains(&&*key.text) && did_you_mean(&key.text, [name]).starts_with("did")
        });
        Err(match suspect {
            Some((key, _)) => self.unknown(key),
            None => Fault::new(
                self.offset,
                format!("`{}` needs the field `{name}`, which is missing", self.what),
            ),
        })
    }

    /// Reports the fields that nobody asked for.
    pub(super) fn finish(self) -> Result<()> {
        let unknown = (self.entries.iter()).find(|(key, _)| !self.asked.contains(&&*key.text));
        unknown.map_or(Ok(()), |(key, _)| Err(self.unknown(key)))
    }

    fn unknown(&self, key: &Word) -> Fault {
        let message = format!("`{}` has no field `{}`", self.what, key.text);
        let help = if self.asked.is_empty() {
            "it has none at all".to_owned()
        } else {
            did_you_mean(&key.text, self.asked.iter().copied())
        };
        Fault::new(key.offset, message).help(help)
    }

    fn name_field<T>(&self, name: &str, result: Result<T>) -> Result<T> {
        result.map_err(|mut fault| {
            if !fault.names_field {
                fault.message = format!("`{name}` of `{}`: {}", self.what, fault.message);
                fault.names_field = true;
            }
            fault
        })
    }
}

/// One of several named alternatives, such as `Sphere(..)`, `{"Sphere": {..}}`, `Srgb` or `"Srgb"`.
pub(super) struct Choice<'n, 't> {
    /// Which one.
    pub(super) name: &'n str,
    /// Where the name is written.
    pub(super) offset: usize,
    body: Body<'n, 't>,
}

enum Body<'n, 't> {
    Items(&'n [Node<'t>]),
    Fields(&'n [(Word<'t>, Node<'t>)]),
    Value(&'n Node<'t>),
}

impl<'n, 't> Choice<'n, 't> {
    /// Reads the name; `what` says for messages what is being chosen.
    pub(super) fn of(node: &'n Node<'t>, what: &str) -> Result<Self> {
        let (name, offset, body) = match &node.value {
            Value::Word(name) => (*name, node.offset, Body::Items(&[])),
            Value::String(name) => (&**name, node.offset, Body::Items(&[])),
            Value::List(Some(name), items) => (*name, node.offset, Body::Items(items)),
            Value::Fields(Some(name), entries) => (*name, node.offset, Body::Fields(entries)),
            Value::Fields(None, entries) if entries.len() == 1 => {
                let (key, node) = &entries[0];
                let body = match &node.value {
                    Value::Fields(None, entries) => Body::Fields(entries),
                    _ => Body::Value(node),
                };
                (&*key.text, key.offset, body)
            }
            _ => return Err(node.fault(what)),
        };
        Ok(Self { name, offset, body })
    }

    /// What `read` makes of its fields, all of which it must know. The brackets may be left out with the fields.
    pub(super) fn record<T>(
        &self,
        read: impl FnOnce(&mut Fields<'n, 't>) -> Result<T>,
    ) -> Result<T> {
        let mut fields = self.fields()?;
        let value = read(&mut fields)?;
        fields.finish()?;
        Ok(value)
    }

    fn fields(&self) -> Result<Fields<'n, 't>> {
        let entries = match self.body {
            Body::Fields(entries) => entries,
            Body::Items([]) => &[],
            Body::Items([first, ..]) => {
                let message = format!("the fields of `{}` need their names", self.name);
                return Err(Fault::new(first.offset, message)
                    .help(format!("write `{}(name: value, ..)`", self.name)));
            }
            Body::Value(node) => return Err(node.fault(&format!("the fields of `{}`", self.name))),
        };
        Fields::new(self.name, self.offset, entries)
    }

    /// Its single value, for an alternative that wraps one.
    pub(super) fn value(&self) -> Result<&'n Node<'t>> {
        match self.body {
            Body::Items([only]) => Ok(only),
            Body::Value(node) => Ok(node),
            _ => Err(self.fault(format!("`{}` holds exactly one value", self.name))),
        }
    }

    /// `value`, for an alternative that is its name alone.
    pub(super) fn alone<T>(&self, value: T) -> Result<T> {
        self.record(|_| Ok(value))
    }

    /// An error at the name.
    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::new(self.offset, message)
    }

    /// The error for a name that is none of `known`.
    pub(super) fn unknown(&self, what: &str, known: &[&str]) -> Fault {
        self.fault(format!("`{}` is not {what}", self.name))
            .help(did_you_mean(self.name, known.iter().copied()))
    }
}

/// `{"name": value, ..}` in the order written.
pub(super) fn named<'n, 't, T>(
    node: &'n Node<'t>,
    read: impl Fn(&'n Word<'t>, &'n Node<'t>) -> Result<T>,
) -> Result<Vec<T>> {
    let Value::Fields(None, entries) = &node.value else {
        return Err(node.fault("names and what they stand for, `{\"name\": ..}`"));
    };
    reject_duplicates(entries)?;
    entries.iter().map(|(key, node)| read(key, node)).collect()
}

fn reject_duplicates(entries: &[(Word, Node)]) -> Result<()> {
    let mut seen = std::collections::HashSet::new();
    match entries.iter().find(|(key, _)| !seen.insert(&*key.text)) {
        Some((key, _)) => Err(
            Fault::new(key.offset, format!("`{}` is given twice", key.text))
                .help("remove or rename one of the two"),
        ),
        None => Ok(()),
    }
}

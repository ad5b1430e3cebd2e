//! A JSON value that knows where it stands, so that every error names its place.

use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Place, Result};

/// A value with its JSON pointer.
#[derive(Clone, Debug)]
pub(super) struct Json<'a> {
    file: &'a Path,
    value: &'a Value,
    pointer: String,
}

impl<'a> Json<'a> {
    /// The whole document.
    pub(super) fn root(file: &'a Path, value: &'a Value) -> Self {
        Self {
            file,
            value,
            pointer: String::new(),
        }
    }

    fn child(&self, value: &'a Value, key: impl std::fmt::Display) -> Self {
        Self {
            value,
            pointer: format!("{}/{key}", self.pointer),
            ..*self
        }
    }

    /// The file that holds it.
    pub(super) fn file(&self) -> &'a Path {
        self.file
    }

    /// An error at this value.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        Error::input(message).at(self.place())
    }

    /// This value's place.
    pub(super) fn place(&self) -> Place {
        Place::pointer(self.file, self.pointer.as_str())
    }

    /// A warning at this value.
    pub(super) fn warning(&self, what: &str) -> String {
        format!("{} at {}: {what}", self.file.display(), self.pointer)
    }

    fn is_not(&self, what: &str) -> Error {
        let mut shown: String = self.value.to_string().chars().take(40).collect();
        if self.value.is_array() || self.value.is_object() {
            shown.truncate(1);
            shown.push_str("...");
        }
        self.error(format!("{shown} is not {what}"))
    }

    /// The member `key`, if there is one.
    pub(super) fn get(&self, key: &str) -> Result<Option<Self>> {
        let object = (self.value.as_object()).ok_or_else(|| self.is_not("an object"))?;
        Ok(object.get(key).map(|value| self.child(value, key)))
    }

    /// The member `key`.
    pub(super) fn need(&self, key: &str) -> Result<Self> {
        (self.get(key)?).ok_or_else(|| self.error(format!("`{key}` is missing")))
    }

    /// The extension `name` of this object, if it has it.
    pub(super) fn extension(&self, name: &str) -> Result<Option<Self>> {
        (self.get("extensions")?).map_or(Ok(None), |extensions| extensions.get(name))
    }

    /// The elements of an array.
    pub(super) fn elements(&self) -> Result<impl Iterator<Item = Self> + use<'a>> {
        let array = (self.value.as_array()).ok_or_else(|| self.is_not("an array"))?;
        let this = self.clone();
        Ok((array.iter().enumerate()).map(move |(i, value)| this.child(value, i)))
    }

    /// The elements of the array `key`; none if it is missing.
    pub(super) fn list(&self, key: &str) -> Result<Vec<Self>> {
        Ok(match self.get(key)? {
            Some(array) => array.elements()?.collect(),
            None => Vec::new(),
        })
    }

    /// The element of the top-level (or extension's) array `key` here whose index is `reference`.
    pub(super) fn element(&self, key: &str, reference: &Self) -> Result<(usize, Self)> {
        let index = reference.count()?;
        let array = self.value.get(key).and_then(Value::as_array);
        let value = array.and_then(|array| array.get(index)).ok_or_else(|| {
            let length = array.map_or(0, Vec::len);
            reference.error(format!("there is no {key}[{index}]: the file has {length}"))
        })?;
        Ok((index, self.child(value, format_args!("{key}/{index}"))))
    }

    pub(super) fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.is_not("a string"))
    }

    pub(super) fn flag(&self) -> Result<bool> {
        self.value
            .as_bool()
            .ok_or_else(|| self.is_not("true or false"))
    }

    /// A whole number from 0.
    pub(super) fn count(&self) -> Result<usize> {
        // Some writers put whole numbers as 3.0.
        let whole = |x: f64| (x >= 0.0 && x.fract() == 0.0 && x < 9e15).then_some(x as u64);
        (self.value.as_u64())
            .or_else(|| self.value.as_f64().and_then(whole))
            .and_then(|n| usize::try_from(n).ok())
            .ok_or_else(|| self.is_not("a whole number from 0"))
    }

    /// A number that is finite as f32, too.
    pub(super) fn number(&self) -> Result<f64> {
        (self.value.as_f64())
            .filter(|&x| (x as f32).is_finite())
            .ok_or_else(|| self.is_not("a finite number"))
    }

    /// An array of `N` numbers.
    pub(super) fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        let numbers: Vec<f64> = self
            .elements()?
            .map(|x| x.number())
            .collect::<Result<_>>()?;
        let count = numbers.len();
        (numbers.try_into()).map_err(|_| self.error(format!("{count} numbers where {N} belong")))
    }

    /// The member `key` as a count, or `default`.
    pub(super) fn count_or(&self, key: &str, default: usize) -> Result<usize> {
        self.get(key)?.map_or(Ok(default), |value| value.count())
    }

    /// The member `key` as a number, or `default`.
    pub(super) fn number_or(&self, key: &str, default: f64) -> Result<f64> {
        self.get(key)?.map_or(Ok(default), |value| value.number())
    }

    /// The member `key` as numbers, or `default`.
    pub(super) fn numbers_or<const N: usize>(
        &self,
        key: &str,
        default: [f64; N],
    ) -> Result<[f64; N]> {
        self.get(key)?.map_or(Ok(default), |value| value.numbers())
    }

    /// The member `name`, if it is a string with something in it.
    pub(super) fn name(&self) -> Option<String> {
        let name = self.value.get("name")?.as_str()?;
        (!name.is_empty()).then(|| name.to_owned())
    }
}

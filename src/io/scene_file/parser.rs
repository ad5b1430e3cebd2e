//! From text to tree, for both formats: `Name(a: 1)` and `{"Name": {"a": 1}}` read alike, and so do `(1, 2)` and
//! `[1, 2]`. It is a little more lenient than either format; [`super::conforms`] is not.

use std::borrow::Cow;

use super::tree::{Fault, Node, Result, Value, Word};

/// Brackets inside one another. An operator in another takes two in RON, three in JSON, so there can be more than
/// 20,000 operators above an operand.
pub(super) const MAX_DEPTH: usize = 1 << 16;

/// Reads a whole text.
pub(super) fn parse(text: &str) -> Result<Node<'_>> {
    let mut parser = Parser {
        text,
        at: 0,
        depth: 0,
    };
    parser.skip_attributes()?;
    let node = parser.value()?;
    parser.skip_space()?;
    if parser.at < text.len() {
        return Err(parser.unexpected("the end of the file"));
    }
    Ok(node)
}

pub(super) struct Parser<'t> {
    pub(super) text: &'t str,
    pub(super) at: usize,
    depth: usize,
}

fn starts_word(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

fn continues_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

impl<'t> Parser<'t> {
    pub(super) fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    pub(super) fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    pub(super) fn consume(&mut self, token: &str) -> bool {
        let found = self.rest().starts_with(token);
        if found {
            self.at += token.len();
        }
        found
    }

    pub(super) fn take_while(&mut self, keep: impl Fn(char) -> bool) -> &'t str {
        let rest = self.rest();
        let taken = &rest[..rest.find(|c| !keep(c)).unwrap_or(rest.len())];
        self.at += taken.len();
        taken
    }

    pub(super) fn unexpected(&self, wanted: &str) -> Fault {
        let found = self
            .peek()
            .map_or("the end of the file".to_owned(), |c| format!("`{c}`"));
        Fault::new(self.at, format!("expected {wanted}, found {found}"))
    }

    /// White space and comments; block comments nest.
    fn skip_space(&mut self) -> Result<()> {
        loop {
            self.take_while(char::is_whitespace);
            if self.rest().starts_with("//") {
                self.take_while(|c| c != '\n');
            } else if self.rest().starts_with("/*") {
                let start = self.at;
                let mut open = 0_usize;
                loop {
                    if self.consume("/*") {
                        open += 1;
                    } else if self.consume("*/") {
                        open -= 1;
                        if open == 0 {
                            break;
                        }
                    } else if let Some(c) = self.peek() {
                        self.at += c.len_utf8();
                    } else {
                        return Err(Fault::new(start, "this comment is never closed")
                            .help("close it with `*/`"));
                    }
                }
            } else {
                return Ok(());
            }
        }
    }

    /// `#![enable(..)]` lines; what they may enable is for the format's own reader to say.
    fn skip_attributes(&mut self) -> Result<()> {
        self.skip_space()?;
        while self.consume("#!") {
            self.take_while(|c| c != ']');
            if !self.consume("]") {
                return Err(self.unexpected("`]` after an attribute"));
            }
            self.skip_space()?;
        }
        Ok(())
    }

    fn value(&mut self) -> Result<Node<'t>> {
        self.skip_space()?;
        let offset = self.at;
        let value = match self.peek() {
            _ if self.at_text() => Value::String(self.text()?),
            Some('(') => self.bracketed(None)?,
            Some('[') => Value::List(None, self.items(']', Self::value)?),
            Some('{') => Value::Fields(None, self.items('}', Self::entry)?),
            Some(c) if c.is_ascii_digit() || "+-.".contains(c) => self.number()?,
            Some(c) if starts_word(c) => self.word()?,
            _ => return Err(self.unexpected("a value")),
        };
        Ok(Node {
            offset,
            source: &self.text[offset..self.at],
            value,
        })
    }

    fn word(&mut self) -> Result<Value<'t>> {
        let word = self.take_while(continues_word);
        match word {
            "inf" => return Ok(Value::Number(f64::INFINITY)),
            "NaN" => return Ok(Value::Number(f64::NAN)),
            _ => {}
        }
        let after = self.at;
        self.skip_space()?;
        if self.peek() != Some('(') {
            self.at = after;
            return Ok(Value::Word(word));
        }
        let start = self.at;
        let value = self.bracketed(Some(word))?;
        // Some(x) is x: optional values may be written either way.
        match value {
            Value::List(Some("Some"), items) => match <[Node; 1]>::try_from(items) {
                Ok([only]) => Ok(only.value),
                Err(_) => Err(Fault::new(start, "`Some` holds exactly one value")),
            },
            value => Ok(value),
        }
    }

    /// What `(` opens: fields where a name and a colon follow, else a list.
    fn bracketed(&mut self, name: Option<&'t str>) -> Result<Value<'t>> {
        let start = self.at;
        self.at += 1;
        self.skip_space()?;
        let has_word = !self.take_while(continues_word).is_empty();
        self.skip_space()?;
        let named = has_word && self.peek() == Some(':');
        self.at = start;
        if named {
            Ok(Value::Fields(name, self.items(')', Self::entry)?))
        } else {
            Ok(Value::List(name, self.items(')', Self::value)?))
        }
    }

    /// The items of the bracket that opens here, up to `close`, a comma between any two.
    fn items<T>(&mut self, close: char, item: fn(&mut Self) -> Result<T>) -> Result<Vec<T>> {
        let start = self.at;
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(Fault::new(
                start,
                format!("more than {MAX_DEPTH} brackets inside one another"),
            ));
        }
        self.at += 1;
        let mut items = Vec::new();
        loop {
            self.skip_space()?;
            if self.peek() == Some(close) {
                break;
            }
            if self.peek().is_none() {
                let open = &self.text[start..=start];
                return Err(Fault::new(start, format!("this `{open}` is never closed"))
                    .help(format!("close it with `{close}`")));
            }
            items.push(item(self)?);
            self.skip_space()?;
            if !self.consume(",") && self.peek().is_some_and(|c| c != close) {
                return Err(self.unexpected(&format!("`,` or `{close}`")));
            }
        }
        self.at += 1;
        self.depth -= 1;
        Ok(items)
    }

    /// `name: value` or `"name": value`.
    fn entry(&mut self) -> Result<(Word<'t>, Node<'t>)> {
        let offset = self.at;
        let text = match self.peek() {
            _ if self.at_text() => self.text()?,
            Some(c) if starts_word(c) => Cow::Borrowed(self.take_while(continues_word)),
            _ => return Err(self.unexpected("a name")),
        };
        self.skip_space()?;
        if !self.consume(":") {
            return Err(self.unexpected(&format!("`:` after `{text}`")));
        }
        Ok((Word { offset, text }, self.value()?))
    }

    fn number(&mut self) -> Result<Value<'t>> {
        let offset = self.at;
        // A sign belongs to the number at its start and after an exponent.
        self.take_while(|c| "+-".contains(c));
        let mut last = ' ';
        while let Some(c) = self.peek() {
            if !(continues_word(c) || c == '.' || ("+-".contains(c) && "eE".contains(last))) {
                break;
            }
            last = c;
            self.at += c.len_utf8();
        }
        let source = &self.text[offset..self.at];
        let digits = source.replace('_', "");
        let whole = |prefix, radix| {
            let digits = digits.strip_prefix(prefix)?;
            u64::from_str_radix(digits, radix).ok().map(|n| n as f64)
        };
        let number = whole("0x", 16)
            .or_else(|| whole("0o", 8))
            .or_else(|| whole("0b", 2))
            .or_else(|| digits.parse().ok());
        (number.map(Value::Number))
            .ok_or_else(|| Fault::new(offset, format!("`{source}` is not a number")))
    }
}

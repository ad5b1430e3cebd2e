//! Text in quotes, with the escapes of both formats.

use std::borrow::Cow;

use super::parser::Parser;
use super::tree::{Fault, Result};

impl<'t> Parser<'t> {
    /// Whether `"`, or RON's `r"` or `r#"`, comes next.
    pub(super) fn at_text(&self) -> bool {
        let rest = self.rest();
        rest.starts_with('"') || rest.starts_with("r\"") || rest.starts_with("r#")
    }

    /// The text that starts here.
    pub(super) fn text(&mut self) -> Result<Cow<'t, str>> {
        if self.peek() == Some('"') {
            self.string()
        } else {
            self.raw_string()
        }
    }

    fn raw_string(&mut self) -> Result<Cow<'t, str>> {
        let offset = self.at;
        self.at += 1;
        let hashes = self.take_while(|c| c == '#');
        if !self.consume("\"") {
            return Err(self.unexpected("`\"`"));
        }
        let end = format!("\"{hashes}");
        let Some(length) = self.rest().find(&end) else {
            return Err(never_ends(offset));
        };
        let content = &self.rest()[..length];
        self.at += length + end.len();
        Ok(Cow::Borrowed(content))
    }

    fn string(&mut self) -> Result<Cow<'t, str>> {
        let offset = self.at;
        self.at += 1;
        let plain = self.take_while(|c| c != '"' && c != '\\');
        if self.consume("\"") {
            return Ok(Cow::Borrowed(plain));
        }
        let mut text = plain.to_owned();
        loop {
            text.push_str(self.take_while(|c| c != '"' && c != '\\'));
            if self.consume("\"") {
                return Ok(Cow::Owned(text));
            }
            if !self.consume("\\") {
                return Err(never_ends(offset));
            }
            text.push(self.escape()?);
        }
    }

    /// What follows a backslash, in either format's way.
    fn escape(&mut self) -> Result<char> {
        let start = self.at - 1;
        let fault = |end: usize| {
            Fault::new(
                start,
                format!("there is no escape `{}`", &self.text[start..end]),
            )
            .help("a backslash itself is written `\\\\`")
        };
        let c = self.peek().ok_or_else(|| fault(self.at))?;
        let hex = |range: std::ops::Range<usize>| {
            let digits = self.text.get(range)?;
            u32::from_str_radix(digits, 16).ok()
        };
        let at = self.at + c.len_utf8();
        let (code, end) = match c {
            'n' => (Some(0x0a), at),
            'r' => (Some(0x0d), at),
            't' => (Some(0x09), at),
            'b' => (Some(0x08), at),
            'f' => (Some(0x0c), at),
            '0' => (Some(0), at),
            '"' | '\\' | '/' | '\'' => (Some(u32::from(c)), at),
            'x' => (hex(at..at + 2), at + 2),
            'u' if self.text[at..].starts_with('{') => {
                let length = self.text[at..].find('}').unwrap_or(0);
                (hex(at + 1..(at + length).max(at + 1)), at + length + 1)
            }
            'u' => match hex(at..at + 4) {
                // The two halves of a pair, as UTF-16 has it.
                Some(high @ 0xd800..0xdc00) if self.text[at + 4..].starts_with("\\u") => {
                    let low = hex(at + 6..at + 10).filter(|low| (0xdc00..0xe000).contains(low));
                    let pair = low.map(|low| 0x10000 + ((high - 0xd800) << 10) + (low - 0xdc00));
                    (pair, at + 10)
                }
                code => (code, at + 4),
            },
            _ => (None, at),
        };
        let decoded = code.and_then(char::from_u32).ok_or_else(|| fault(at))?;
        self.at = end;
        Ok(decoded)
    }
}

fn never_ends(offset: usize) -> Fault {
    Fault::new(offset, "this text never ends").help("close it with `\"`")
}

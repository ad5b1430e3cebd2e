//! Where a document's bytes are: GLB chunks, data URIs, files beside it.

use std::borrow::Cow;
use std::path::Path;

use crate::error::{Error, Place, Result};

use super::super::read_file;
use super::json::Json;

/// A GLB file's JSON and binary chunks.
pub(super) struct Glb<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a GLB file (glTF 2.0 specification, section 4.4); chunks of other types are skipped.
pub(super) fn split_glb<'a>(file: &Path, bytes: &'a [u8]) -> Result<Glb<'a>> {
    let error = |message: String| Error::input(message).at(Place::file(file));
    let truncated = |message: String| error(message).help("the file is cut short; get it again");
    let word = |at: usize| {
        let bytes = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?) as usize)
    };
    if !bytes.starts_with(b"glTF") {
        let start = bytes[..bytes.len().min(4)].escape_ascii();
        return Err(error(format!("not a GLB file: it begins with `{start}`"))
            .help("a GLB file begins with `glTF`; text belongs in a .gltf file"));
    }
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(truncated(format!(
            "the GLB header has {} bytes of 12",
            bytes.len()
        )));
    };
    if version != 2 {
        return Err(error(format!("GLB version {version}")).help("only version 2 is read"));
    }
    let whole = bytes
        .get(..length)
        .filter(|b| b.len() >= 12)
        .ok_or_else(|| {
            truncated(format!(
                "the header says {length} bytes, the file has {}",
                bytes.len()
            ))
        })?;
    let mut glb = Glb {
        json: &[],
        binary: None,
    };
    let mut at = 12;
    let mut chunk = 0;
    while at < whole.len() {
        let (Some(size), Some(kind)) = (word(at), whole.get(at + 4..at + 8)) else {
            return Err(truncated(format!("chunk {chunk} has no whole header")));
        };
        let data = whole[at + 8..].get(..size).ok_or_else(|| {
            truncated(format!(
                "chunk {chunk} says {size} bytes, {} are left",
                whole.len() - at - 8
            ))
        })?;
        match (chunk, kind) {
            (0, b"JSON") => glb.json = data,
            (0, _) => return Err(error("the first chunk is not JSON".to_owned())),
            (1, b"BIN\0") => glb.binary = Some(data),
            _ => {}
        }
        at += 8 + size;
        chunk += 1;
    }
    if chunk == 0 {
        return Err(truncated("there is no JSON chunk".to_owned()));
    }
    Ok(glb)
}

/// The bytes of every buffer, each of its stated length.
pub(super) fn read_buffers<'a>(
    root: &Json<'a>,
    binary: Option<&'a [u8]>,
) -> Result<Vec<Cow<'a, [u8]>>> {
    let buffers = root.list("buffers")?.into_iter().enumerate();
    let read = |(i, buffer): (usize, Json<'a>)| {
        let length = buffer.need("byteLength")?.count()?;
        let data = match (buffer.get("uri")?, binary) {
            (Some(uri), _) => read_uri(&uri)?,
            (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
            (None, _) => {
                return Err(
                    buffer.error("the buffer has no `uri`, and there is no GLB chunk for it")
                );
            }
        };
        if data.len() < length {
            return Err((buffer.need("byteLength")?)
                .error(format!(
                    "the buffer should have {length} bytes, but has {}",
                    data.len()
                ))
                .help("the file is cut short, or another one is in its place"));
        }
        Ok(match data {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[..length]),
            Cow::Owned(mut bytes) => {
                bytes.truncate(length);
                Cow::Owned(bytes)
            }
        })
    };
    buffers.map(read).collect()
}

/// The bytes that a URI names: base64 data, or a file relative to the document.
pub(super) fn read_uri<'a>(uri: &Json<'a>) -> Result<Cow<'a, [u8]>> {
    let text = uri.text()?;
    if let Some(data) = text.strip_prefix("data:") {
        let (_, code) = data
            .split_once(";base64,")
            .ok_or_else(|| uri.error("a data URI that is not base64"))?;
        return (base64(code).map(Cow::Owned))
            .ok_or_else(|| uri.error("the data URI is not valid base64"));
    }
    let shown: String = text.chars().take(80).collect();
    if text.contains(':') {
        return Err((uri.error(format!("cannot read the URI `{shown}`")))
            .help("URIs can be relative file names or base64 data"));
    }
    let name = percent_decoded(text)
        .ok_or_else(|| uri.error(format!("the URI `{shown}` is not percent-encoded UTF-8")))?;
    let folder = uri.file().parent().unwrap_or(Path::new(""));
    read_file(&folder.join(&name)).map(Cow::Owned).map_err(|e| {
        Error::new(e.kind(), format!("`{name}`: {}", e.message()))
            .at(uri.place())
            .help("file names are relative to the glTF file's folder")
    })
}

fn percent_decoded(text: &str) -> Option<String> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        decoded.push(if b == b'%' {
            let mut digit = || char::from(bytes.next()?).to_digit(16);
            (16 * digit()? + digit()?) as u8
        } else {
            b
        });
    }
    String::from_utf8(decoded).ok()
}

/// RFC 4648, section 4; the padding may be missing.
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    for group in text.chunks(4) {
        let mut bits = 0_u32;
        for &c in group {
            let value = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        bits <<= 6 * (4 - group.len());
        let whole = match group.len() {
            4 => 3,
            3 => 2,
            2 => 1,
            _ => return None,
        };
        bytes.extend_from_slice(&bits.to_be_bytes()[1..=whole]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_agrees_with_the_test_vectors_of_rfc_4648() {
        for (plain, code) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(code).as_deref(), Some(plain.as_bytes()), "{code}");
        }
        assert_eq!(base64("+/+/"), Some(vec![0xFB, 0xFF, 0xBF]));
        assert_eq!(base64("Zm9v Zg=="), None);
        assert_eq!(base64("Zm9vZ"), None);
    }

    #[test]
    fn percent_codes_are_bytes_of_utf8() {
        assert_eq!(percent_decoded("a%20b%C3%A9").as_deref(), Some("a bé"));
        for bad in ["%FF", "%", "%2", "%zz", "%+1"] {
            assert_eq!(percent_decoded(bad), None, "{bad}");
        }
    }
}

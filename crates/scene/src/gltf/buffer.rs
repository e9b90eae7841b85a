//! Where the bytes of a glTF file are: in the file itself, after `base64,` in a URI, or in another file.

use std::borrow::Cow;
use std::io;
use std::path::Path;

use super::document;
use super::document::{Document, Fault};
use crate::error::Error;
use crate::messages::{printable, quoted};
use crate::reading::{Budget, ReadFile};

const GLB: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BINARY: &[u8] = b"BIN\0";

/// The JSON of a file, and its binary chunk if it is a `.glb` with one.
pub(super) fn chunks(content: &[u8]) -> Result<(&[u8], Option<&[u8]>), Error> {
    let Some(header) = content.strip_prefix(GLB) else { return Ok((content, None)) };
    let truncated = || Error::expected("a complete binary glTF", format!("a file cut off at {} bytes", content.len()));
    let (version, rest) = word(header).ok_or_else(truncated)?;
    if version != 2 {
        return Err(document::other_version(&version.to_string()));
    }
    let (length, _) = word(rest).ok_or_else(truncated)?;
    let mut remainder = content.get(12..length).ok_or_else(truncated)?;
    let mut next = || -> Result<(&[u8], &[u8]), Error> {
        let (length, after) = word(remainder).ok_or_else(truncated)?;
        let (kind, after) = after.split_at_checked(4).ok_or_else(truncated)?;
        let (chunk, after) = after.split_at_checked(length).ok_or_else(truncated)?;
        remainder = after;
        Ok((kind, chunk))
    };
    let (kind, json) = next()?;
    if kind != JSON {
        return Err(Error::expected("a chunk of JSON first", format!("{kind:?}")));
    }
    // Spaces fill the chunk up; some write zeros. Chunks of other kinds may follow, and are to be skipped.
    let json = &json[..json.len() - json.iter().rev().take_while(|&&byte| byte == 0).count()];
    loop {
        match next() {
            Ok((BINARY, binary)) => return Ok((json, Some(binary))),
            Ok(_) => {}
            Err(_) => return Ok((json, None)),
        }
    }
}

/// An integer of four bytes, the lowest first, and the bytes that follow it.
fn word(bytes: &[u8]) -> Option<(usize, &[u8])> {
    let (word, rest) = bytes.split_first_chunk::<4>()?;
    Some((usize::try_from(u32::from_le_bytes(*word)).ok()?, rest))
}

/// The content of every buffer; an error comes with its member.
pub(super) fn contents<'a>(
    document: &Document,
    binary: Option<&'a [u8]>,
    budget: &Budget,
    read: &mut ReadFile<'_>,
) -> Result<Vec<Cow<'a, [u8]>>, Fault> {
    let contents = document.buffers.iter().enumerate().map(|(index, buffer)| {
        let member = || format!("buffers[{index}]");
        let content = match (&buffer.uri, binary) {
            (None, Some(binary)) if index == 0 => Ok(Cow::Borrowed(binary)),
            (None, _) => Err(Error::expected("a `uri`", "none")),
            (Some(uri), _) => of_uri(uri, budget, read).map(Cow::Owned),
        };
        let content = content.map_err(|error| (member(), error))?;
        if content.len() < buffer.byte_length {
            let given = format!("{} bytes", content.len());
            return Err((member(), Error::expected(format!("{} bytes", buffer.byte_length), given)));
        }
        Ok(content)
    });
    contents.collect()
}

/// The data of a URI: inside it, or in the file it names.
pub(super) fn of_uri(uri: &str, budget: &Budget, read: &mut ReadFile<'_>) -> Result<Vec<u8>, Error> {
    match uri.strip_prefix("data:").map(|data| data.split_once(";base64,")) {
        Some(Some((_, data))) => {
            budget.take_many("data in URIs", data.len(), 1)?;
            base64(data)
        }
        Some(None) => Err(Error::expected("`;base64,` in a data URI", quoted(Some(uri)))),
        None => {
            let name = percent_decoded(uri);
            read(Path::new(&name)).map_err(|error| match error.kind() {
                io::ErrorKind::FileTooLarge => budget.exceeded(&format!("`{}`", printable(&name))),
                _ => Error::Unreadable { file: name.into(), reason: error.to_string() },
            })
        }
    }
}

/// Bytes from the 64 characters of RFC 4648.
fn base64(text: &str) -> Result<Vec<u8>, Error> {
    let digits = text.trim_end_matches('=');
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    let (mut bits, mut held) = (0_u32, 0);
    for (place, character) in digits.bytes().enumerate() {
        let digit = match character {
            b'A'..=b'Z' => character - b'A',
            b'a'..=b'z' => character - b'a' + 26,
            b'0'..=b'9' => character - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => {
                return Err(Error::expected("a digit of base 64", format!("byte {character:#04x} at place {place} of the data")));
            }
        };
        bits = bits << 6 | u32::from(digit);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held & 0xff) as u8);
        }
    }
    Ok(bytes)
}

/// A file's name from a URI: `%20` is a space.
fn percent_decoded(uri: &str) -> String {
    let (mut bytes, mut rest) = (Vec::with_capacity(uri.len()), uri.as_bytes());
    while let Some((&first, after)) = rest.split_first() {
        let code = after.get(..2).filter(|_| first == b'%').and_then(|code| std::str::from_utf8(code).ok());
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The bytes of a buffer view; an error comes with its member.
pub(super) fn view<'a>(document: &Document, buffers: &'a [Cow<'_, [u8]>], index: usize) -> Result<&'a [u8], Fault> {
    let member = format!("bufferViews[{index}]");
    let Some(view) = document.buffer_views.get(index) else {
        return Err((member, document::no_such("buffer view", index, document.buffer_views.len())));
    };
    let Some(buffer) = buffers.get(view.buffer) else {
        return Err((member, document::no_such("buffer", view.buffer, buffers.len())));
    };
    let end = view.byte_offset.checked_add(view.byte_length);
    end.and_then(|end| buffer.get(view.byte_offset..end)).ok_or_else(|| {
        let given = format!("{} bytes from {}", view.byte_length, view.byte_offset);
        (member, Error::expected(format!("bytes within the {} of the buffer", buffer.len()), given))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_is_read_as_rfc_4648_writes_it() {
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(text), Ok(bytes.as_bytes().to_vec()));
        }
        assert_eq!(base64("+/8A"), Ok(vec![0xfb, 0xff, 0x00]));
        assert!(base64("Zm 9").unwrap_err().to_string().contains("byte 0x20 at place 2"));
    }

    #[test]
    fn names_in_uris_are_decoded() {
        assert_eq!(percent_decoded("a%20b%c3%a9.bin"), "a bé.bin");
        assert_eq!(percent_decoded("100%"), "100%");
    }
}

//! Statements of text files, word by word, with errors that give the expected and the found word.

use std::borrow::Cow;

use crate::error::Error;
use crate::messages::quoted;
use crate::precision::{Coordinates, Digits, Written};

/// The words of a statement that are not read yet.
#[derive(Debug, Clone)]
pub(crate) struct Words<'a> {
    rest: &'a str,
    separator: fn(char) -> bool,
}

impl<'a> Words<'a> {
    /// Words separated by white space.
    pub(crate) const fn new(text: &'a str) -> Self {
        Self::separated(text, |c| c.is_ascii_whitespace())
    }

    /// Words separated by runs of the characters for which `separator` is true.
    pub(crate) const fn separated(text: &'a str, separator: fn(char) -> bool) -> Self {
        Self { rest: text, separator }
    }

    /// The next word, if there is one.
    pub(crate) fn next(&mut self) -> Option<&'a str> {
        self.rest = self.rest.trim_start_matches(self.separator);
        let (word, rest) = self.rest.split_at(self.rest.find(self.separator).unwrap_or(self.rest.len()));
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    /// All that is left, without the separators around it.
    pub(crate) fn remainder(&self) -> &'a str {
        self.rest.trim_matches(self.separator)
    }

    /// Whether nothing is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.remainder().is_empty()
    }

    /// The next word as a finite number, named by its argument.
    pub(crate) fn number(&mut self, what: &str) -> Result<f64, Error> {
        number(self.next(), what)
    }

    /// The next three words as coordinates, with how they are written, named by the argument.
    pub(crate) fn coordinates(&mut self, what: [&str; 3]) -> Result<Coordinates, Error> {
        let mut read = ([0.0; 3], [Written::Single; 3]);
        for (axis, what) in what.into_iter().enumerate() {
            let word = self.next();
            read.0[axis] = number(word, what)?;
            read.1[axis] = Written::Text(Digits::parse(word.unwrap_or_default()));
        }
        Ok(read)
    }

    /// The next word as an integer, named by its argument.
    pub(crate) fn integer(&mut self, what: &str) -> Result<i64, Error> {
        let word = self.next();
        word.and_then(|word| word.parse().ok()).ok_or_else(|| Error::expected(format!("an integer ({what})"), quoted(word)))
    }

    /// Nothing may be left.
    pub(crate) fn end(&self) -> Result<(), Error> {
        if self.is_empty() { Ok(()) } else { Err(Error::expected("the end of the line", quoted(Some(self.remainder())))) }
    }
}

/// A word as a finite number, named by its argument.
pub(crate) fn number(word: Option<&str>, what: &str) -> Result<f64, Error> {
    match word.map(str::parse::<f64>) {
        Some(Ok(number)) if number.is_finite() => Ok(number),
        Some(Ok(_)) => Err(Error::expected(format!("a finite number ({what})"), quoted(word))),
        _ => {
            let with_point = word.and_then(|word| word.replacen(',', ".", 1).parse::<f64>().ok());
            let is_comma = with_point.is_some() && word.is_some_and(|word| !word.ends_with(','));
            let given = if is_comma { format!("a decimal comma, {}", quoted(word)) } else { quoted(word) };
            let form = if is_comma { "with a decimal point " } else { "" };
            Err(Error::expected(format!("a number {form}({what})"), given))
        }
    }
}

/// A file without the byte order mark that some editors put before UTF-8.
pub(crate) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// A remark on a text, and the line, from 1, where it is first true.
type Remark = (usize, String);

/// The text of a file: UTF-8, or UTF-16 with its byte order mark, or else Latin-1, with a remark where it is no UTF-8. A mark, and
/// the byte with which DOS ends a text, are no part of it.
pub(crate) fn text_of(content: &[u8]) -> Result<(Cow<'_, str>, Option<Remark>), (usize, Error)> {
    let (text, remark) = match content {
        [0xff, 0xfe, rest @ ..] => utf_16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf_16(rest, u16::from_be_bytes),
        _ => match std::str::from_utf8(without_mark(content)) {
            Ok(text) => (Cow::Borrowed(text), None),
            Err(error) => {
                let bytes = without_mark(content);
                let (line, byte) = (line_of(bytes, error.valid_up_to()), bytes[error.valid_up_to()]);
                let remark = format!("the text is no UTF-8 (byte {byte:#04x}): read as Latin-1");
                (Cow::Owned(bytes.iter().copied().map(char::from).collect()), Some((line, remark)))
            }
        },
    };
    if let Some(place) = text.find('\0') {
        let given = "a byte 0: it is binary, or UTF-16 without a byte order mark";
        return Err((line_of(text.as_bytes(), place), Error::expected("a text of UTF-8, UTF-16 or Latin-1", given)));
    }
    Ok(match text {
        Cow::Borrowed(text) => (Cow::Borrowed(text.strip_suffix('\x1a').unwrap_or(text)), remark),
        text => (text, remark),
    })
}

fn utf_16(content: &[u8], unit: fn([u8; 2]) -> u16) -> (Cow<'static, str>, Option<Remark>) {
    let (units, half) = content.as_chunks::<2>();
    let decoded = char::decode_utf16(units.iter().copied().map(unit));
    let text: String = decoded.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    let broken = !half.is_empty() || text.contains(char::REPLACEMENT_CHARACTER);
    let remark = if broken { ", in which not all is a character" } else { "" };
    (Cow::Owned(text), Some((1, format!("the text is read as UTF-16{remark}"))))
}

/// The line, from 1, of a place in a text.
fn line_of(text: &[u8], place: usize) -> usize {
    let ends = |&index: &usize| text[index] == b'\n' || text[index] == b'\r' && text.get(index + 1) != Some(&b'\n');
    1 + (0..place).filter(ends).count()
}

/// The lines of a text, each ended by a line feed, a carriage return, or both; the last may be empty.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut remainder = Some(text);
    std::iter::from_fn(move || {
        let text = remainder?;
        let Some(end) = text.find(['\n', '\r']) else { return remainder.take() };
        let both = text[end..].starts_with("\r\n");
        remainder = Some(&text[end + 1 + usize::from(both)..]);
        Some(&text[..end])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_to_the_end_of_the_line() {
        let mut words = Words::new("  f\t1 -2   x y ");
        assert_eq!(words.next(), Some("f"));
        assert_eq!((words.integer("a"), words.number("b")), (Ok(1), Ok(-2.0)));
        assert!(words.end().unwrap_err().to_string().ends_with("found `x y`"));
        assert_eq!((words.remainder(), words.next(), words.next(), words.next()), ("x y", Some("x"), Some("y"), None));
        assert!(words.is_empty() && words.end().is_ok());
        assert_eq!(words.number("z").unwrap_err().to_string(), "expected a number (z), found the end of the line");
    }

    #[test]
    fn numbers_are_finite_doubles_to_the_last_digit() {
        assert_eq!(Words::new("0.1").number("x"), Ok(0.1));
        assert_eq!(Words::new("1.7976931348623157E308").number("x"), Ok(f64::MAX));
        for word in ["nan", "inf", "-Infinity", "1e999"] {
            let message = Words::new(word).number("x").unwrap_err().to_string();
            assert_eq!(message, format!("expected a finite number (x), found `{word}`"));
        }
        for word in ["1,5", "0x10", "1.0d3", "--1"] {
            assert!(matches!(Words::new(word).number("x"), Err(Error::Expected { .. })), "{word}");
        }
        assert!(Words::new("1.0").integer("n").is_err());
    }

    #[test]
    fn a_decimal_comma_is_named() {
        let message = |word| Words::new(word).number("x").unwrap_err().to_string();
        assert_eq!(message("1,5"), "expected a number with a decimal point (x), found a decimal comma, `1,5`");
        assert_eq!(message("1,"), "expected a number (x), found `1,`");
        for (word, value) in [("1.", 1.0), (".5", 0.5), ("+1e-3", 1e-3), ("-.5E1", -5.0)] {
            assert_eq!(Words::new(word).number("x"), Ok(value));
        }
    }

    #[test]
    fn what_is_no_utf_8_is_utf_16_with_a_mark_or_latin_1() {
        let text = "g Fu\u{df}boden\r\nv 1\n";
        let latin = b"# a\rg caf\xe9";
        let (little, big): (Vec<u8>, Vec<u8>) = (
            [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect(),
            [0xfe, 0xff].into_iter().chain(text.encode_utf16().flat_map(u16::to_be_bytes)).collect(),
        );
        let utf_16 = Some((1, "the text is read as UTF-16".to_owned()));
        assert_eq!(text_of(&little), Ok((text.into(), utf_16.clone())));
        assert_eq!(text_of(&big), Ok((text.into(), utf_16)));
        let remark = "the text is no UTF-8 (byte 0xe9): read as Latin-1";
        assert_eq!(text_of(latin), Ok(("# a\rg caf\u{e9}".into(), Some((2, remark.to_owned())))));
        assert_eq!(text_of(b"\xef\xbb\xbfa\x1a"), Ok(("a".into(), None)));
        let (line, error) = text_of(b"a\r\nb\0").unwrap_err();
        assert_eq!(line, 2);
        assert!(error.to_string().starts_with("expected a text of UTF-8, UTF-16 or Latin-1, found a byte 0"));
        // Half a character.
        let (text, remark) = text_of(&little[..7]).unwrap();
        assert_eq!((text.as_ref(), remark.unwrap().1.ends_with("not all is a character")), ("g ", true));
    }

    #[test]
    fn lines_end_with_either_character_or_both() {
        assert_eq!(lines("a\nb\r\n\rc\r").collect::<Vec<_>>(), ["a", "b", "", "c", ""]);
        assert_eq!(lines("").collect::<Vec<_>>(), [""]);
    }
}

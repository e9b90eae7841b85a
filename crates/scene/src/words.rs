//! Statements of text files, word by word, with errors that give the expected and the found word.

use std::borrow::Cow;

use crate::Error;

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
    pub(crate) fn rest(&self) -> &'a str {
        self.rest.trim_matches(self.separator)
    }

    /// Whether nothing is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.rest().is_empty()
    }

    /// The next word as a finite number; `what` names it.
    pub(crate) fn number(&mut self, what: &str) -> Result<f64, Error> {
        let word = self.next();
        match word.map(str::parse::<f64>) {
            Some(Ok(number)) if number.is_finite() => Ok(number),
            Some(Ok(_)) => Err(Error::expected(format!("a finite number ({what})"), quoted(word))),
            _ => Err(Error::expected(format!("a number ({what})"), quoted(word))),
        }
    }

    /// The next word as an integer; `what` names it.
    pub(crate) fn integer(&mut self, what: &str) -> Result<i64, Error> {
        let word = self.next();
        word.and_then(|word| word.parse().ok()).ok_or_else(|| Error::expected(format!("an integer ({what})"), quoted(word)))
    }

    /// Nothing may be left.
    pub(crate) fn end(&self) -> Result<(), Error> {
        if self.is_empty() { Ok(()) } else { Err(Error::expected("the end of the line", quoted(Some(self.rest())))) }
    }
}

/// A word as it is shown in messages.
pub(crate) fn quoted(word: Option<&str>) -> String {
    const LONGEST: usize = 60;
    let Some(word) = word else { return "the end of the line".to_owned() };
    match word.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("`{}...`", printable(&word[..end])),
        None => format!("`{}`", printable(word)),
    }
}

/// A text with the characters escaped that a terminal obeys rather than shows: control characters, and those that turn the
/// direction of writing.
///
/// ```
/// assert_eq!(radgrad_scene::printable("a\u{1b}[2Jb"), "a\\u{1b}[2Jb");
/// assert_eq!(radgrad_scene::printable("caf\u{e9}"), "caf\u{e9}");
/// ```
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        c.is_control() || turns
    };
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let escaped = |c: char| if obeyed(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(escaped).collect())
}

/// A file without the byte order mark that some editors put before UTF-8.
pub(crate) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// The text of a line that is to be understood, and so must be UTF-8; comments are cut off before.
pub(crate) fn decode(bytes: &[u8]) -> Result<&str, Error> {
    std::str::from_utf8(bytes).map_err(|error| {
        let place = error.valid_up_to();
        Error::expected("UTF-8 text", format!("byte {:#04x} at column {}", bytes[place], place + 1))
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
        assert_eq!((words.rest(), words.next(), words.next(), words.next()), ("x y", Some("x"), Some("y"), None));
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
    fn what_is_not_utf_8_is_named_by_its_byte() {
        let message = decode(b"g caf\xe9").unwrap_err().to_string();
        assert_eq!(message, "expected UTF-8 text, found byte 0xe9 at column 6");
    }
}

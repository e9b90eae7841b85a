//! Texts as messages show them: words of a file, numbers of bytes, and the name that was probably meant.

use std::borrow::Cow;
use std::fmt;

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

/// A number of bytes as people read it.
pub(crate) struct Bytes(pub(crate) u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = [("GiB", 30), ("MiB", 20), ("KiB", 10)];
        match units.iter().find(|(_, shift)| self.0 >> shift > 0) {
            Some((unit, shift)) if self.0.is_multiple_of(1 << shift) => write!(f, "{} {unit}", self.0 >> shift),
            Some((unit, shift)) => write!(f, "{:.1} {unit}", self.0 as f64 / (1_u64 << shift) as f64),
            None => write!(f, "{} bytes", self.0),
        }
    }
}

/// The names that there are in place of one that is not among them, and which of them was probably meant.
pub(crate) fn candidates<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 20;
    let names: Vec<&str> = names.collect();
    let is_near = |other: &&str| edits(name, other) <= other.len().div_ceil(2);
    let nearest = names.iter().copied().filter(is_near).min_by_key(|other| edits(name, other));
    let meant = nearest.map_or_else(String::new, |other| format!("did you mean `{}`? ", printable(other)));
    let mut shown: Vec<String> = names.iter().take(SHOWN).map(|other| format!("`{}`", printable(other))).collect();
    if let Some(more @ 1..) = names.len().checked_sub(SHOWN) {
        shown.push(format!("and {more} more"));
    }
    format!("{meant}there are {}", shown.join(", "))
}

/// The least number of letters to put in, take out or change between two words (Levenshtein), of the first 64.
fn edits(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().take(64).enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, b) in to.iter().enumerate() {
            let changed = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_for_people() {
        for (bytes, text) in [(7, "7 bytes"), (1 << 10, "1 KiB"), (1536, "1.5 KiB"), (256 << 20, "256 MiB"), (3 << 30, "3 GiB")] {
            assert_eq!(Bytes(bytes).to_string(), text);
        }
    }

    #[test]
    fn words_are_as_far_apart_as_letters_change() {
        for (from, to, distance) in [("", "abc", 3), ("kitten", "sitting", 3), ("ocluders", "occluders", 1), ("id", "id", 0)] {
            assert_eq!((edits(from, to), edits(to, from)), (distance, distance));
        }
    }
}

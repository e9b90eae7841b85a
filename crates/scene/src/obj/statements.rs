//! The statements of OBJ and MTL.

use std::borrow::Cow;

use crate::error::Error;
use crate::words::lines;

/// Calls `take` with the number of each statement's first line and with its text: comments cut off, continued lines joined,
/// blank ones left out.
pub(super) fn for_each_statement(text: &str, mut take: impl FnMut(usize, &str) -> Result<(), Error>) -> Result<(), Error> {
    let (mut first, mut joined) = (0, String::new());
    for (index, line) in lines(text).enumerate() {
        let bytes = line.as_bytes();
        let comment = (0..bytes.len()).find(|&i| bytes[i] == b'#' && (i == 0 || bytes[i - 1].is_ascii_whitespace()));
        let line = line[..comment.unwrap_or(line.len())].trim_ascii_end();
        if joined.is_empty() {
            first = index + 1;
        }
        if let Some(line) = line.strip_suffix('\\') {
            joined.push_str(line);
            joined.push(' ');
            continue;
        }
        // Nearly all lines are statements of their own.
        let statement = if joined.is_empty() { Cow::Borrowed(line) } else { Cow::Owned(std::mem::take(&mut joined) + line) };
        if !statement.trim_ascii().is_empty() {
            take(first, &statement)?;
        }
    }
    if joined.trim_ascii().is_empty() { Ok(()) } else { take(first, &joined) }
}

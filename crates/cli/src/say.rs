//! Messages of the program on the standard error: a closed or full one is no reason to stop.

use std::fmt::Display;
use std::io::Write;

use radgrad_scene::printable;

/// Writes a line after the program's name, with control characters escaped: names come from files.
pub(crate) fn say(text: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "radgrad: {}", printable(&text.to_string()));
}

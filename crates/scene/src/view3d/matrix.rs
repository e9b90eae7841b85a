//! A matrix of form factors in the text that `View3D` writes and other programs read.
//!
//! The first line is `View3D`, the version, the format (0 for text), whether the surfaces enclose a room, whether emittances are
//! in the factors, and the number of surfaces, padded to 30 columns; then the areas in one line, one line for each row of
//! factors, and the emittances in one line. The original gives factors to six decimals; here every number has as many digits as
//! its double needs.

use std::io::{self, Write};

use crate::error::Error;

/// The first line of a matrix without the number of surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MatrixHeader {
    /// Whether the surfaces enclose a room.
    pub enclosure: bool,
    /// Whether reflections between the surfaces are in the factors.
    pub emittances: bool,
}

/// The version whose format this is.
const VERSION: &str = "3.3";

/// Writes a square matrix: row i has the factors from surface i to each surface.
///
/// ```
/// use radgrad_scene::view3d::{MatrixHeader, write_matrix};
/// let mut text = Vec::new();
/// let rows = [[0.0, 0.25], [0.5, 0.0]];
/// write_matrix(&mut text, MatrixHeader { enclosure: true, ..MatrixHeader::default() }, &[2.0, 1.0], rows, &[0.9, 0.8])?;
/// assert_eq!(text, b"View3D 3.3 0 1 0 2            \n2.0 1.0\n0.0 0.25\n0.5 0.0\n0.9 0.8\n");
/// # Ok::<(), radgrad_scene::Error>(())
/// ```
///
/// # Errors
/// If the numbers of areas, rows, factors in a row and emittances are not the same, or writing fails.
pub fn write_matrix<R: AsRef<[f64]>>(
    mut out: impl Write,
    header: MatrixHeader,
    areas: &[f64],
    rows: impl IntoIterator<Item = R>,
    emittances: &[f64],
) -> Result<(), Error> {
    let expected = areas.len();
    let counted = |what, found| if found == expected { Ok(()) } else { Err(Error::Count { what, found, expected }) };
    counted("emittances", emittances.len())?;
    let [enclosure, included] = [header.enclosure, header.emittances].map(u8::from);
    let first = format!("View3D {VERSION} 0 {enclosure} {included} {expected}");
    writeln!(out, "{first:<30}").map_err(unwritable)?;
    write_line(&mut out, areas)?;
    let mut count = 0;
    for row in rows {
        counted("factors in a row", row.as_ref().len())?;
        write_line(&mut out, row.as_ref())?;
        count += 1;
    }
    counted("rows", count)?;
    write_line(&mut out, emittances)
}

fn write_line(out: &mut impl Write, numbers: &[f64]) -> Result<(), Error> {
    for (i, number) in numbers.iter().enumerate() {
        write!(out, "{}{number:?}", if i == 0 { "" } else { " " }).map_err(unwritable)?;
    }
    writeln!(out).map_err(unwritable)
}

fn unwritable(error: io::Error) -> Error {
    Error::Unwritable { reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_of_another_size_is_refused() {
        let write = |areas: &[f64], rows: &[&[f64]], emittances: &[f64]| {
            write_matrix(io::sink(), MatrixHeader::default(), areas, rows, emittances)
        };
        assert_eq!(write(&[1.0], &[&[0.0]], &[0.9]), Ok(()));
        assert_eq!(write(&[1.0], &[&[0.0]], &[]), Err(Error::Count { what: "emittances", found: 0, expected: 1 }));
        assert_eq!(write(&[1.0], &[&[0.0, 1.0]], &[0.9]), Err(Error::Count { what: "factors in a row", found: 2, expected: 1 }));
        assert_eq!(write(&[1.0], &[], &[0.9]), Err(Error::Count { what: "rows", found: 0, expected: 1 }));
    }

    #[test]
    fn factors_keep_every_digit() {
        let mut text = Vec::new();
        let factor = 0.1 + 0.2;
        write_matrix(&mut text, MatrixHeader::default(), &[1.0], [[factor]], &[1e-7]).unwrap();
        let text = String::from_utf8(text).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines[0].len(), lines[2].parse(), lines[3]), (30, Ok(factor), "1e-7"));
    }

    #[test]
    fn a_full_disk_is_reported() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let result = write_matrix(Full, MatrixHeader::default(), &[1.0], [[0.0]], &[0.9]);
        assert!(matches!(result, Err(Error::Unwritable { .. })));
    }
}

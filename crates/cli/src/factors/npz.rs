//! Factors as a `.npz` of numpy, as `scipy.sparse.load_npz` reads it: compressed rows, 12 bytes a factor and 8 a row.
//!
//! Such a file is a zip of arrays, each with a header of its own. Arrays are written one after the other, and a row at a time: what is in memory is one
//! row. Sizes are known before, sums of check after: they follow the data. All is in the form for more than 4 GB.

use std::io::{self, Write};

use crc32fast::Hasher;

/// The numbers of a row: other faces, ascending, and the factors.
pub(super) type Row = (Vec<usize>, Vec<f64>);

/// What takes the row of a face.
pub(super) type Take<'a> = &'a mut dyn FnMut(usize, Row) -> io::Result<()>;

/// Compressed rows of so many numbers, by a function that hands over the rows of all faces, in their order; with the share of each row's view that is open.
pub(super) struct Rows<'a> {
    pub(super) faces: usize,
    pub(super) numbers: usize,
    pub(super) open: Vec<f64>,
    pub(super) each: &'a dyn Fn(Take<'_>) -> io::Result<()>,
}

impl Rows<'_> {
    pub(super) fn write(&self, out: impl Write) -> io::Result<()> {
        let whole = |number: usize| i64::try_from(number).map_err(io::Error::other);
        let short = |number: usize| i32::try_from(number).map_err(io::Error::other);
        let mut zip = Zip { out, at: 0, crc: Hasher::new(), entries: Vec::new() };
        zip.array("format.npy", "|S3", "()", 3, |out| out.write(b"csr"))?;
        let faces = whole(self.faces)?;
        zip.array("shape.npy", "<i8", "(2,)", 16, |out| [faces; 2].iter().try_for_each(|count| out.write(&count.to_le_bytes())))?;
        zip.array("indptr.npy", "<i8", &format!("({},)", self.faces + 1), 8 * (self.faces + 1), |out| {
            let (mut next, mut end) = (0, 0_usize);
            (self.each)(&mut |face, (faces, _)| {
                // A face that only hides has an empty row.
                let before = whole(end)?.to_le_bytes();
                (next..=face).try_for_each(|_| out.write(&before))?;
                (next, end) = (face + 1, end + faces.len());
                Ok(())
            })?;
            let total = whole(end)?.to_le_bytes();
            (next..=self.faces).try_for_each(|_| out.write(&total))
        })?;
        let length = format!("({},)", self.numbers);
        zip.array("indices.npy", "<i4", &length, 4 * self.numbers, |out| {
            (self.each)(&mut |_, (faces, _)| faces.into_iter().try_for_each(|face| out.write(&short(face)?.to_le_bytes())))
        })?;
        zip.array("data.npy", "<f8", &length, 8 * self.numbers, |out| {
            (self.each)(&mut |_, (_, factors)| factors.into_iter().try_for_each(|factor| out.write(&factor.to_le_bytes())))
        })?;
        zip.array("open.npy", "<f8", &format!("({},)", self.open.len()), 8 * self.open.len(), |out| {
            self.open.iter().try_for_each(|share| out.write(&share.to_le_bytes()))
        })?;
        zip.end()
    }
}

/// An array of the zip.
struct Entry {
    name: &'static str,
    start: u64,
    size: u64,
    crc: u32,
}

/// A zip of stored files.
struct Zip<W> {
    out: W,
    at: u64,
    crc: Hasher,
    entries: Vec<Entry>,
}

/// What zip calls the version that it takes, flags (sums of check follow the data; names are UTF-8), stored, at the first time that there is.
const KIND: [u16; 5] = [45, 0x808, 0, 0, 0x21];

impl<W: Write> Zip<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.crc.update(bytes);
        self.at += bytes.len() as u64;
        self.out.write_all(bytes)
    }

    /// Numbers of 16, 32 and 64 bits.
    fn numbers(&mut self, short: &[u16], middle: &[u32], long: &[u64]) -> io::Result<()> {
        short.iter().try_for_each(|number| self.write(&number.to_le_bytes()))?;
        middle.iter().try_for_each(|number| self.write(&number.to_le_bytes()))?;
        long.iter().try_for_each(|number| self.write(&number.to_le_bytes()))
    }

    /// An array of so many bytes.
    fn array(
        &mut self,
        name: &'static str,
        kind: &str,
        shape: &str,
        bytes: usize,
        data: impl FnOnce(&mut Self) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        // With ten bytes before it and the end of its line a multiple of 64.
        let padding = 63 - (header.len() + 10) % 64;
        header.extend(std::iter::repeat_n(' ', padding).chain(['\n']));
        let (start, size) = (self.at, (header.len() + 10 + bytes) as u64);
        self.write(b"PK\x03\x04")?;
        self.numbers(&KIND, &[0, u32::MAX, u32::MAX], &[])?;
        self.numbers(&[short(name.len()), 20], &[], &[])?;
        self.write(name.as_bytes())?;
        self.numbers(&[1, 16], &[], &[size, size])?;
        self.crc = Hasher::new();
        let begin = self.at;
        self.write(b"\x93NUMPY\x01\x00")?;
        self.numbers(&[short(header.len())], &[], &[])?;
        self.write(header.as_bytes())?;
        data(self)?;
        let crc = std::mem::take(&mut self.crc).finalize();
        if self.at - begin != size {
            return Err(io::Error::other(format!("{name} has {} bytes in place of {size}", self.at - begin)));
        }
        self.entries.push(Entry { name, start, size, crc });
        self.write(b"PK\x07\x08")?;
        self.numbers(&[], &[crc], &[size, size])
    }

    /// The directory.
    fn end(mut self) -> io::Result<()> {
        let (entries, start) = (std::mem::take(&mut self.entries), self.at);
        for Entry { name, start, size, crc } in &entries {
            self.write(b"PK\x01\x02")?;
            self.numbers(&[45], &[], &[])?;
            self.numbers(&KIND, &[*crc, u32::MAX, u32::MAX], &[])?;
            self.numbers(&[short(name.len()), 28, 0, 0, 0], &[0, u32::MAX], &[])?;
            self.write(name.as_bytes())?;
            self.numbers(&[1, 24], &[], &[*size, *size, *start])?;
        }
        let (count, end) = (entries.len() as u64, self.at);
        self.write(b"PK\x06\x06")?;
        self.numbers(&[], &[], &[44])?;
        self.numbers(&[45, 45], &[0, 0], &[count, count, end - start, start])?;
        self.write(b"PK\x06\x07")?;
        self.numbers(&[], &[0], &[end])?;
        self.numbers(&[], &[1], &[])?;
        self.write(b"PK\x05\x06")?;
        self.numbers(&[0, 0, u16::MAX, u16::MAX], &[u32::MAX, u32::MAX], &[])?;
        self.numbers(&[0], &[], &[])?;
        self.out.flush()
    }
}

/// Lengths of names and headers: they are short.
fn short(length: usize) -> u16 {
    u16::try_from(length).unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_where_the_directory_says_also_those_of_faces_without_any() {
        // Face 0 and face 2 have no row.
        let each = |row: Take<'_>| {
            row(1, (vec![3], vec![0.25]))?;
            row(3, (vec![1, 2], vec![0.5, 0.125]))
        };
        let rows = Rows { faces: 5, numbers: 3, open: vec![1.0; 5], each: &each };
        let mut bytes = Vec::new();
        rows.write(&mut bytes).unwrap();
        let array = |name: &str| {
            let at = bytes.windows(name.len()).position(|window| window == name.as_bytes()).unwrap();
            let start = at + bytes[at..].iter().position(|byte| *byte == b'\n').unwrap() + 1;
            assert_eq!((start - (at + name.len() + 20)) % 64, 0, "{name}");
            &bytes[start..]
        };
        let whole = |name: &str, count: usize| {
            let numbers = array(name).chunks_exact(8).take(count).map(|number| i64::from_le_bytes(number.try_into().unwrap()));
            numbers.collect::<Vec<_>>()
        };
        assert_eq!(whole("indptr.npy", 6), [0, 0, 1, 1, 3, 3]);
        assert_eq!(whole("shape.npy", 2), [5, 5]);
        assert_eq!(array("indices.npy")[..12], [3, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(array("data.npy")[8..16], 0.5_f64.to_le_bytes());
        // The directory begins where its end says.
        let end = u64::from_le_bytes(bytes[bytes.len() - 50..bytes.len() - 42].try_into().unwrap());
        assert_eq!(bytes[usize::try_from(end).unwrap()..][..4], *b"PK\x01\x02");
        assert!(Rows { numbers: 2, ..rows }.write(io::sink()).is_err());
    }
}

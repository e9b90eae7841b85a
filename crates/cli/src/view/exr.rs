//! `OpenEXR`: scan lines of 32-bit floats without compression, any channels (the file layout of its version 2).

use std::io::{self, Write};

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const VERSION: u32 = 2;
/// Set where a name has more than 31 bytes.
const LONG_NAMES: u32 = 0x400;
const FLOAT: i32 = 2;

/// Writes channels, each a name and its values row by row from the upper left, and attributes that are texts.
pub(super) fn write(
    out: &mut dyn Write,
    size: [usize; 2],
    mut channels: Vec<(String, Vec<f64>)>,
    said: &[(&str, &str)],
) -> io::Result<()> {
    let too_large = |_| io::Error::other("more pixels than an EXR file has");
    let [width, height] = size;
    let [right, bottom] = [i32::try_from(width).map_err(too_large)? - 1, i32::try_from(height).map_err(too_large)? - 1];
    channels.sort_by(|a, b| a.0.cmp(&b.0));

    let mut header = Vec::new();
    header.extend(MAGIC);
    let long = channels.iter().any(|(name, _)| name.len() > 31);
    header.extend((VERSION | if long { LONG_NAMES } else { 0 }).to_le_bytes());
    let mut list = Vec::new();
    for (name, _) in &channels {
        list.extend(name.bytes().filter(|byte| *byte != 0));
        // End of the name; type; not perceptually linear, three bytes in reserve; every pixel.
        list.push(0);
        for number in [FLOAT, 0, 1, 1] {
            list.extend(number.to_le_bytes());
        }
    }
    list.push(0);
    let window = [0, 0, right, bottom].map(i32::to_le_bytes).concat();
    attribute(&mut header, "channels", "chlist", &list)?;
    attribute(&mut header, "compression", "compression", &[0])?;
    attribute(&mut header, "dataWindow", "box2i", &window)?;
    attribute(&mut header, "displayWindow", "box2i", &window)?;
    attribute(&mut header, "lineOrder", "lineOrder", &[0])?;
    attribute(&mut header, "pixelAspectRatio", "float", &1.0_f32.to_le_bytes())?;
    attribute(&mut header, "screenWindowCenter", "v2f", &[0; 8])?;
    attribute(&mut header, "screenWindowWidth", "float", &1.0_f32.to_le_bytes())?;
    for (name, text) in said {
        attribute(&mut header, name, "string", text.as_bytes())?;
    }
    header.push(0);
    out.write_all(&header)?;

    let row = 4 * width * channels.len();
    let first = header.len() + 8 * height;
    for line in 0..height {
        out.write_all(&((first + line * (8 + row)) as u64).to_le_bytes())?;
    }
    let row_bytes = i32::try_from(row).map_err(too_large)?;
    for (line, y) in (0..=bottom).enumerate() {
        out.write_all(&y.to_le_bytes())?;
        out.write_all(&row_bytes.to_le_bytes())?;
        for (_, values) in &channels {
            for value in &values[line * width..(line + 1) * width] {
                #[expect(clippy::cast_possible_truncation, reason = "the format's floats have 24 bits")]
                out.write_all(&(*value as f32).to_le_bytes())?;
            }
        }
    }
    Ok(())
}

fn attribute(header: &mut Vec<u8>, name: &str, kind: &str, value: &[u8]) -> io::Result<()> {
    let length = i32::try_from(value.len()).map_err(|_| io::Error::other("too many channels for an EXR file"))?;
    for text in [name, kind] {
        header.extend(text.bytes());
        header.push(0);
    }
    header.extend(length.to_le_bytes());
    header.extend(value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_its_channels_in_order_and_its_rows_where_the_table_says() {
        let mut file = Vec::new();
        let channels = vec![("R".to_owned(), vec![1.0, 2.0, 3.0, 4.0]), ("B".to_owned(), vec![5.0, 6.0, 7.0, 8.0])];
        write(&mut file, [2, 2], channels, &[("unit", "W/m2")]).unwrap();
        let said = b"unit\0string\0\x04\0\0\0W/m2";
        assert!(file.windows(said.len()).any(|part| part == said));
        assert_eq!(file[..8], [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]);
        let row = 8 + 2 * 2 * 4;
        let table = file.len() - 2 * row - 16;
        let offset = |line: usize| {
            let bytes: [u8; 8] = file[table + 8 * line..][..8].try_into().unwrap();
            usize::try_from(u64::from_le_bytes(bytes)).unwrap()
        };
        assert_eq!(offset(1) + row, file.len());
        let float = |at: usize| f32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        // B before R.
        assert_eq!([0, 4, 8, 12].map(|at| float(offset(1) + 8 + at)), [7.0, 8.0, 3.0, 4.0]);
        assert_eq!(file[offset(1)], 1);
    }
}

//! The field's values as a picture of one pixel a cell, 16 bits of grey from 0 to the largest value; that is in the text chunk
//! `white`. The first row of cells is at the bottom.

use std::io::Write;

use radgrad_scene::FieldCell;

pub(super) fn write(out: impl Write, cells: &[FieldCell], grid: usize) -> Result<(), png::EncodingError> {
    let side = u32::try_from(grid).map_err(|_| std::io::Error::other("a picture of more than 4294967295 pixels a side"))?;
    let white = cells.iter().map(|cell| cell.value).fold(0.0, f64::max);
    let mut encoder = png::Encoder::new(out, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.add_text_chunk("white".to_owned(), format!("{white:?}"))?;
    let rows = cells.chunks(grid).rev().flatten();
    let data: Vec<u8> = rows.flat_map(|cell| grey(cell.value, white).to_be_bytes()).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the whole range, and casts saturate")]
fn grey(value: f64, white: f64) -> u16 {
    if white > 0.0 { (value / white * f64::from(u16::MAX)).round() as u16 } else { 0 }
}

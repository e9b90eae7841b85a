//! Textures from PNG files.
//!
//! Grey or colour, 8 or 16 bits; three values a texel. They are decoded to linear light by the transfer curve of sRGB, as glTF
//! asks for, unless the file says that it has another: a `gAMA` chunk without an `sRGB` one is a power. The first row of the
//! file is the first of the texture.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::Texture;
use crate::error::Error;
use crate::messages::printable;
use crate::reading::Budget;

/// Whether a file starts as a PNG does.
pub(crate) fn is_png(content: &[u8]) -> bool {
    content.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// The format of a file that is no PNG by its first bytes, for people.
pub(crate) fn format_of(content: &[u8]) -> &'static str {
    let starts: [(&[u8], &str); 8] = [
        (b"\xff\xd8\xff", "a JPEG"),
        (b"GIF8", "a GIF"),
        (b"BM", "a BMP"),
        (b"II*\0", "a TIFF"),
        (b"MM\0*", "a TIFF"),
        (b"\xabKTX", "a KTX"),
        (b"#?RADIANCE", "a picture of Radiance"),
        (b"\x76\x2f\x31\x01", "an EXR"),
    ];
    match starts.iter().find(|(start, _)| content.starts_with(start)) {
        Some((_, name)) => name,
        None if content.starts_with(b"RIFF") && content.get(8..12) == Some(b"WEBP") => "a WebP",
        None => "of no known format",
    }
}

/// The texture of a file of this name, and whether it has transparent texels, which are taken as opaque. Its memory is taken from
/// the budget before it is used.
pub(crate) fn decode(content: &[u8], name: &str, budget: &Budget) -> Result<(Texture, bool), Error> {
    let refused = |rule: String| Error::Texture { texture: name.to_owned(), rule };
    let failed = |error: png::DecodingError| refused(format!("no PNG: {error}"));
    let bytes = usize::try_from(budget.remaining()).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new_with_limits(Cursor::new(content), Limits { bytes });
    decoder.set_transformations(Transformations::EXPAND);
    // Compressed texts and profiles may be large, and are of no use.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(failed)?;
    let info = reader.info();
    let (columns, rows) = (info.width, info.height);
    // Three doubles a texel, and the samples of the file, of up to eight bytes a texel.
    let memory = (u64::from(columns) * u64::from(rows)).saturating_mul(3 * 8 + 8);
    budget.take(&format!("texture `{}` of {columns} x {rows} texels", printable(name)), memory)?;
    let gamma = info.gama_chunk.filter(|_| info.srgb.is_none()).map(|gamma| f64::from(gamma.into_value()));
    if let Some(gamma) = gamma.filter(|gamma| *gamma <= 0.0) {
        return Err(refused(format!("its gamma is {gamma}: it must be above 0")));
    }
    let size = reader.output_buffer_size().ok_or_else(|| refused("it is too large for memory".to_owned()))?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(failed)?;
    let samples = match frame.color_type {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgba => 4,
        ColorType::Rgb | ColorType::Indexed => 3,
    };
    let deep = frame.bit_depth == BitDepth::Sixteen;
    let width = if deep { 2 } else { 1 };
    let sample = |bytes: &[u8]| match *bytes {
        [high, low] => f64::from(u16::from_be_bytes([high, low])) / 65535.0,
        [byte] => f64::from(byte) / 255.0,
        _ => 0.0,
    };
    let linear = |encoded: f64| match gamma {
        Some(gamma) => libm::pow(encoded, 1.0 / gamma),
        None if encoded <= 0.04045 => encoded / 12.92,
        None => libm::pow((encoded + 0.055) / 1.055, 2.4),
    };
    // Of 8 bits there are but few values.
    let table: Vec<f64> = (0..=255).map(|byte| linear(f64::from(byte) / 255.0)).collect();
    let value = |bytes: &[u8]| if let [byte] = *bytes { table[usize::from(byte)] } else { linear(sample(bytes)) };
    let (mut texels, mut transparent) = (Vec::with_capacity(3 * size / (samples * width)), false);
    for texel in bytes[..frame.buffer_size()].chunks_exact(samples * width) {
        let mut parts = texel.chunks_exact(width);
        if samples <= 2 {
            texels.extend([parts.next().map_or(0.0, value); 3]);
        } else {
            texels.extend(parts.by_ref().take(3).map(value));
        }
        transparent |= parts.next().is_some_and(|alpha| sample(alpha) < 1.0);
    }
    let [columns, rows] = [columns, rows].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
    Texture::new(name, [columns, rows], 3, texels).map(|texture| (texture, transparent))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(content: &[u8], name: &str) -> Result<(Texture, bool), Error> {
        super::decode(content, name, &Budget::new(1 << 20))
    }

    fn png(colour: ColorType, depth: BitDepth, data: &[u8], gamma: Option<u32>) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 2, 1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if let Some(gamma) = gamma {
            encoder.set_source_gamma(png::ScaledFloat::from_scaled(gamma));
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        file
    }

    #[test]
    fn colours_are_decoded_to_linear_light() {
        let (texture, transparent) = decode(&png(ColorType::Rgb, BitDepth::Eight, &[0, 255, 188, 10, 0, 0], None), "t").unwrap();
        assert_eq!((texture.size(), transparent), ([2, 1], false));
        let [first, second] = [0, 1].map(|column| texture.texel([column, 0]));
        assert_eq!(first[..2], [0.0, 1.0]);
        assert!((first[2] - 0.502_886_458_032_568_7).abs() < 1e-12, "{}", first[2]);
        assert!((second[0] - 10.0 / 255.0 / 12.92).abs() < 1e-16);
    }

    #[test]
    fn grey_sixteen_bits_alpha_and_gamma_are_read() {
        let deep = png(ColorType::Grayscale, BitDepth::Sixteen, &[0x80, 0, 0xff, 0xff], Some(100_000));
        let (texture, _) = decode(&deep, "t").unwrap();
        assert_eq!(texture.texel([0, 0]), [32768.0 / 65535.0; 3]);
        let clear = png(ColorType::GrayscaleAlpha, BitDepth::Eight, &[255, 255, 255, 7], Some(100_000));
        let (texture, transparent) = decode(&clear, "t").unwrap();
        assert_eq!((texture.texel([1, 0]), transparent), (&[1.0; 3][..], true));
    }

    #[test]
    fn a_file_cut_off_anywhere_is_refused() {
        let whole = png(ColorType::Rgb, BitDepth::Eight, &[1, 2, 3, 4, 5, 6], None);
        assert!(is_png(&whole));
        // The chunks after the last byte of the image are not needed.
        for length in 0..whole.len() - 20 {
            let error = decode(&whole[..length], "t.png").unwrap_err().to_string();
            assert!(error.starts_with("texture `t.png`: no PNG: "), "{length}: {error}");
        }
    }
}

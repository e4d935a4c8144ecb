//! Pictures of 16 bits a number as PNG files.

use std::io::{self, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Encoder, Filter};

use crate::dng::RawPicture;
use crate::error::MergeError;

/// Size of the parts of a file, bytes.
const CHUNK: usize = 1 << 20;

/// Writes a picture of one plane in grey, or of three in red, green and blue, with 16 bits a number.
///
/// # Errors
/// [`MergeError::Write`]; a file that was there is whole then.
pub fn write(path: &Path, picture: &RawPicture) -> Result<(), MergeError> {
    let wrong = |reason: String| MergeError::Write { file: path.to_owned(), reason };
    let ([width, height], planes) = (picture.size, picture.planes);
    let kind = match planes {
        1 => ColorType::Grayscale,
        3 => ColorType::Rgb,
        other => return Err(wrong(format!("a PNG has no {other} planes"))),
    };
    let count = width * height * planes;
    let sides = [width, height].map(u32::try_from);
    let ([Ok(width), Ok(height)], false) = (sides, count == 0 || picture.counts.len() != count) else {
        return Err(wrong(format!("{} numbers are no picture of {width} x {height} pixels", picture.counts.len())));
    };
    petzval_files::write(path, |file| -> io::Result<()> {
        let mut encoder = Encoder::new(file, width, height);
        encoder.set_color(kind);
        encoder.set_depth(BitDepth::Sixteen);
        // Noise hardly packs: differences of neighbours are no smaller, and more effort takes many times as long.
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::NoFilter);
        let mut writer = encoder.write_header()?;
        let mut data = writer.stream_writer_with_size(CHUNK)?;
        for counts in picture.counts.chunks(1 << 15) {
            data.write_all(&counts.iter().flat_map(|count| count.to_be_bytes()).collect::<Vec<u8>>())?;
        }
        data.finish()?;
        Ok(writer.finish()?)
    })
    .map_err(|error| wrong(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grey and coloured numbers come back; other planes and counts are refused.
    #[test]
    fn numbers_come_back() {
        let path = std::env::temp_dir().join(format!("petzval-png-{}.png", std::process::id()));
        for planes in [1, 3] {
            let counts: Vec<u16> = (0..300 * 200 * planes).map(|i| (i * 7919 % 65_536) as u16).collect();
            let picture = RawPicture { size: [300, 200], planes, counts };
            write(&path, &picture).unwrap();
            let mut reader =
                png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            let found = reader.next_frame(&mut bytes).unwrap();
            assert_eq!((found.width, found.height, found.bit_depth), (300, 200, BitDepth::Sixteen));
            let read: Vec<u16> = bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
            assert_eq!(read, picture.counts);
        }
        std::fs::remove_file(&path).unwrap();
        for (planes, count) in [(2, 4), (1, 3), (1, 0)] {
            assert!(write(&path, &RawPicture { size: [2, 1], planes, counts: vec![0; count] }).is_err());
        }
        assert!(!path.exists());
    }
}

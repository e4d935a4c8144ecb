//! Pictures of 16 bits a number as PNG files.
//!
//! Source: W3C, "Portable Network Graphics (PNG) Specification", third edition.

use std::io::{self, Write};
use std::path::Path;

use crate::dng::{RawPicture, write_counts};
use crate::error::MergeError;

/// Effort of the compression, of 10: noise hardly packs, and more takes many times as long.
const LEVEL: u8 = 1;

/// Writes a picture of one plane in grey, or of three in red, green and blue, with 16 bits a number.
///
/// # Errors
/// [`MergeError::Write`]; a file that was there is whole then.
pub fn write(path: &Path, picture: &RawPicture) -> Result<(), MergeError> {
    let wrong = |reason: String| MergeError::Write { file: path.to_owned(), reason };
    let ([width, height], planes) = (picture.size, picture.planes);
    let kind = match planes {
        1 => 0,
        3 => 2,
        other => return Err(wrong(format!("a PNG has no {other} planes"))),
    };
    let row = width * planes;
    if row == 0 || picture.counts.len() != row * height {
        return Err(wrong(format!("{} numbers are no picture of {width} x {height} pixels", picture.counts.len())));
    }
    let mut lines = Vec::with_capacity((2 * row + 1) * height);
    for counts in picture.counts.chunks(row) {
        // No filter.
        lines.push(0);
        write_counts(&mut lines, counts, u16::to_be_bytes).map_err(|error| wrong(error.to_string()))?;
    }
    let packed = miniz_oxide::deflate::compress_to_vec_zlib(&lines, LEVEL);
    let header = [&(width as u32).to_be_bytes()[..], &(height as u32).to_be_bytes(), &[16, kind, 0, 0, 0]].concat();
    petzval_files::write(path, |file| -> io::Result<()> {
        file.write_all(b"\x89PNG\r\n\x1a\n")?;
        write_chunk(file, *b"IHDR", &header)?;
        // A chunk's length has 31 bits.
        for part in packed.chunks(1 << 30) {
            write_chunk(file, *b"IDAT", part)?;
        }
        write_chunk(file, *b"IEND", &[])
    })
    .map_err(|error| wrong(error.to_string()))
}

fn write_chunk(file: &mut impl Write, kind: [u8; 4], data: &[u8]) -> io::Result<()> {
    let mut sum = crc32fast::Hasher::new();
    sum.update(&kind);
    sum.update(data);
    file.write_all(&(data.len() as u32).to_be_bytes())?;
    file.write_all(&kind)?;
    file.write_all(data)?;
    file.write_all(&sum.finalize().to_be_bytes())
}

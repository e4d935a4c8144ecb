//! Raw pictures of sensors as Digital Negatives: uncompressed TIFF files with the tags of the DNG specification 1.4.
//!
//! Source: Adobe, "Digital Negative (DNG) Specification", version 1.4.0.0, June 2012; TIFF 6.0; Exif 2.3 for the exposure.

use std::io::{self, Write};
use std::path::Path;

use crate::error::MergeError;

/// Numbers of a sensor's photosites, 16 bits each, as they are written into a file.
#[derive(Clone, Debug)]
pub struct RawPicture {
    /// Width and height, photosites.
    pub size: [usize; 2],
    /// Numbers of each photosite: 1, or 3 where every photosite tells three colours apart.
    pub planes: usize,
    /// The numbers, DN, first row at the top, the planes of a photosite together.
    pub counts: Vec<u16>,
}

/// The properties of a raw picture that a developing program needs.
#[derive(Clone, Debug)]
pub struct RawTags {
    /// The sensor's name.
    pub model: String,
    /// Columns and rows of the repeated pattern of colour filters, and the filters by rows: 0 red, 1 green, 2 blue. `None`: no mosaic.
    pub mosaic: Option<([u16; 2], Vec<u8>)>,
    /// DN without light.
    pub black_level_dn: u16,
    /// DN at saturation.
    pub white_level_dn: u16,
    /// Linear channels from CIE XYZ under D65, rows; `None`: a sensor without colours.
    pub channels_from_xyz: Option<[[f64; 3]; 3]>,
    /// The channels of white, the largest 1; `None`: a sensor without colours.
    pub neutral: Option<[f64; 3]>,
    /// Stops by which a developer is to make the picture brighter, so that it is exposed as its film speed says.
    pub baseline_stops: f64,
    /// Film speed, ISO.
    pub iso: f64,
    /// Exposure time, s.
    pub shutter_s: f64,
    /// F-number, where it is known.
    pub f_number: Option<f64>,
}

/// Denominator of rational numbers.
const PARTS: f64 = 1_000_000.0;
/// Bytes of a TIFF file, whose places are numbers of 32 bits.
const MOST_BYTES: usize = u32::MAX as usize - 65_536;

/// One field of a directory: tag, type, count, bytes.
struct Field(u16, u16, u32, Vec<u8>);

fn bytes(tag: u16, values: &[u8]) -> Field {
    Field(tag, 1, values.len() as u32, values.to_vec())
}

fn text(tag: u16, value: &str) -> Field {
    // The type is ASCII.
    let plain: String = value.chars().map(|one| if one.is_ascii() && !one.is_control() { one } else { '?' }).collect();
    let data: Vec<u8> = plain.bytes().chain([0]).collect();
    Field(tag, 2, data.len() as u32, data)
}

fn shorts(tag: u16, values: &[u16]) -> Field {
    Field(tag, 3, values.len() as u32, values.iter().flat_map(|value| value.to_le_bytes()).collect())
}

fn long(tag: u16, value: u32) -> Field {
    Field(tag, 4, 1, value.to_le_bytes().to_vec())
}

fn rationals(tag: u16, values: &[f64]) -> Field {
    let one = |value: &f64| {
        // The denominator is the finest with which the number fits.
        let parts = if *value * PARTS < f64::from(u32::MAX) { PARTS } else { 1.0 };
        [(value * parts).round() as u32, parts as u32]
    };
    let data = values.iter().flat_map(one).flat_map(u32::to_le_bytes).collect();
    Field(tag, 5, values.len() as u32, data)
}

fn signed_rationals(tag: u16, values: impl Iterator<Item = f64>) -> Field {
    let data: Vec<u8> =
        values.flat_map(|value| [(value * PARTS).round() as i32, PARTS as i32]).flat_map(i32::to_le_bytes).collect();
    Field(tag, 10, data.len() as u32 / 8, data)
}

/// A directory at a place in the file, with the values that do not fit into its fields behind it.
fn directory(mut fields: Vec<Field>, at: usize) -> Vec<u8> {
    fields.sort_by_key(|field| field.0);
    let head = 2 + 12 * fields.len() + 4;
    let (mut entries, mut behind) = (Vec::new(), Vec::new());
    for Field(tag, kind, count, mut data) in fields {
        entries.extend(tag.to_le_bytes());
        entries.extend(kind.to_le_bytes());
        entries.extend(count.to_le_bytes());
        if data.len() <= 4 {
            data.resize(4, 0);
            entries.extend(data);
        } else {
            entries.extend(((at + head + behind.len()) as u32).to_le_bytes());
            behind.extend(data);
            // Values begin at even places.
            behind.resize(behind.len().next_multiple_of(2), 0);
        }
    }
    let count = (entries.len() / 12) as u16;
    [count.to_le_bytes().to_vec(), entries, vec![0; 4], behind].concat()
}

/// The fields of the picture, but for the places of other parts of the file.
fn fields(picture: &RawPicture, tags: &RawTags) -> Vec<Field> {
    let (planes, [width, height]) = (picture.planes, picture.size);
    let each = |value: u16| vec![value; planes];
    // 32803: colour filter array; 34892: linear raw.
    let photometric = if tags.mosaic.is_some() { 32803 } else { 34892 };
    let mut list = vec![
        long(254, 0),
        long(256, width as u32),
        long(257, height as u32),
        shorts(258, &each(16)),
        shorts(259, &[1]),
        shorts(262, &[photometric]),
        text(271, "Petzval"),
        text(272, &tags.model),
        shorts(274, &[1]),
        shorts(277, &[planes as u16]),
        long(278, height as u32),
        long(279, (2 * picture.counts.len()) as u32),
        shorts(284, &[1]),
        text(305, concat!("Petzval ", env!("CARGO_PKG_VERSION"))),
        bytes(50706, &[1, 4, 0, 0]),
        bytes(50707, &[1, 1, 0, 0]),
        text(50708, &format!("Petzval {}", tags.model)),
        shorts(50713, &[1, 1]),
        shorts(50714, &each(tags.black_level_dn)),
        shorts(50717, &each(tags.white_level_dn)),
        signed_rationals(50730, [tags.baseline_stops].into_iter()),
    ];
    if let Some((repeat, pattern)) = &tags.mosaic {
        // Rows first.
        list.push(shorts(33421, &[repeat[1], repeat[0]]));
        list.push(bytes(33422, pattern));
        list.push(bytes(50710, &[0, 1, 2]));
        list.push(shorts(50711, &[1]));
    }
    if let Some(matrix) = tags.channels_from_xyz {
        list.push(signed_rationals(50721, matrix.into_iter().flatten()));
        // Illuminant 21 is D65.
        list.push(shorts(50778, &[21]));
    }
    if let Some(neutral) = tags.neutral {
        list.push(rationals(50728, &neutral));
    }
    list
}

fn exposure_fields(tags: &RawTags) -> Vec<Field> {
    let mut list = vec![
        rationals(33434, &[tags.shutter_s]),
        shorts(34855, &[tags.iso.round().clamp(1.0, f64::from(u16::MAX)) as u16]),
        bytes(36864, b"0230"),
    ];
    // The type of the version is "undefined".
    list[2].1 = 7;
    if let Some(f_number) = tags.f_number {
        list.push(rationals(33437, &[f_number]));
    }
    list
}

/// Writes a raw picture as DNG.
///
/// # Errors
/// [`MergeError::Write`]; a file that was there is whole then.
pub fn write(path: &Path, picture: &RawPicture, tags: &RawTags) -> Result<(), MergeError> {
    let wrong = |reason: String| MergeError::Write { file: path.to_owned(), reason };
    let [width, height] = picture.size;
    if picture.counts.len() != width * height * picture.planes || picture.counts.is_empty() {
        return Err(wrong(format!("{} numbers are no picture of {width} x {height} photosites", picture.counts.len())));
    }
    if 2 * picture.counts.len() > MOST_BYTES {
        return Err(wrong(format!("{width} x {height} photosites are more than a DNG's 4 GB")));
    }
    // The header, the picture's directory, the exposure's, the pixels. Lengths do not depend on the places that are entered.
    let with_places = |exposure_at: usize, pixels_at: usize| {
        let places = [long(34665, exposure_at as u32), long(273, pixels_at as u32)];
        directory(fields(picture, tags).into_iter().chain(places).collect(), 8)
    };
    let exposure_at = 8 + with_places(0, 0).len();
    let exposure = directory(exposure_fields(tags), exposure_at);
    let pixels_at = (exposure_at + exposure.len()).next_multiple_of(16);
    let mut head = [b"II*\0".as_slice(), &8_u32.to_le_bytes()].concat();
    head.extend(with_places(exposure_at, pixels_at));
    head.extend(exposure);
    head.resize(pixels_at, 0);
    petzval_files::write(path, |file| -> io::Result<()> {
        file.write_all(&head)?;
        write_counts(file, &picture.counts)
    })
    .map_err(|error| wrong(error.to_string()))
}

/// Writes numbers, the low byte first.
fn write_counts(file: &mut impl Write, counts: &[u16]) -> io::Result<()> {
    for part in counts.chunks(1 << 15) {
        let data: Vec<u8> = part.iter().flat_map(|value| value.to_le_bytes()).collect();
        file.write_all(&data)?;
    }
    Ok(())
}

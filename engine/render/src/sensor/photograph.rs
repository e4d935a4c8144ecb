//! A picture's file on a sensor, into a raw file.

use super::SensorError;
use super::expose::{Exposed, Picture, Summary, expose};
use super::exposure::ExposureRequest;
use super::response::Response;
use petzval_pictures::{channels, dng, png};
use std::path::Path;

/// The kinds of raw files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawFormat {
    /// A Digital Negative, with all that a developing program needs.
    Dng,
    /// The numbers, 16 bits each.
    Png,
    /// The numbers in single precision.
    Exr,
}

impl RawFormat {
    /// The kind by a file's ending.
    ///
    /// # Errors
    /// The ending is of none.
    pub fn of(file: &Path) -> Result<Self, SensorError> {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "dng" => Ok(Self::Dng),
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(SensorError::Picture(format!(
                "unknown raw format: {}: end its name in .dng, .png or .exr",
                file.display()
            ))),
        }
    }
}

/// Photographs an OpenEXR picture, scene-linear R, G and B, and writes the sensor's raw file.
///
/// # Errors
/// The picture cannot be read, the exposure is none, or the file cannot be written; a file that was there is whole then.
pub fn photograph(
    response: &Response,
    picture: &Path,
    request: &ExposureRequest,
    output: &Path,
) -> Result<Summary, SensorError> {
    let format = RawFormat::of(output)?;
    let read = channels::read(picture, &["R", "G", "B"], "A")?;
    let [red, green, blue] = [0, 1, 2].map(|i| read.needed[i].as_slice());
    let seen = Picture { size: read.size, channels: [red, green, blue] };
    let exposed = expose(response, seen, request).map_err(|error| match error {
        SensorError::Picture(what) => SensorError::Picture(format!("{}: {what}", picture.display())),
        other => other,
    })?;
    write(&exposed, format, output)?;
    Ok(exposed.summary)
}

/// Photographs a rendered picture, red, green, blue and alpha of each pixel, rows from below, and writes the sensor's raw file.
///
/// # Errors
/// The exposure is none, or the file cannot be written; a file that was there is whole then.
pub fn photograph_pixels(
    response: &Response,
    size: [usize; 2],
    pixels: &[f32],
    request: &ExposureRequest,
    output: &Path,
) -> Result<Summary, SensorError> {
    let format = RawFormat::of(output)?;
    let row = 4 * size[0].max(1);
    let channel = |i: usize| -> Vec<f32> {
        pixels.chunks(row).rev().flat_map(|line| line.iter().skip(i).step_by(4)).copied().collect()
    };
    let [red, green, blue] = [0, 1, 2].map(channel);
    let exposed = expose(response, Picture { size, channels: [&red, &green, &blue] }, request)?;
    write(&exposed, format, output)?;
    Ok(exposed.summary)
}

fn write(exposed: &Exposed, format: RawFormat, output: &Path) -> Result<(), SensorError> {
    let Exposed { raw, tags, .. } = exposed;
    match format {
        RawFormat::Dng => dng::write(output, raw, tags)?,
        RawFormat::Png => png::write(output, raw)?,
        RawFormat::Exr => {
            let names: &[&str] = if raw.planes == 1 { &["Y"] } else { &["R", "G", "B"] };
            let plane =
                |i: usize| raw.counts.iter().skip(i).step_by(raw.planes).map(|count| f32::from(*count)).collect();
            let planes = names.iter().enumerate().map(|(i, name)| ((*name).to_owned(), plane(i))).collect();
            let comments = format!(
                "Raw numbers of {}, DN: ISO {}, {} s, black {}, white {}.",
                tags.model, tags.iso, tags.shutter_s, tags.black_level_dn, tags.white_level_dn
            );
            channels::write(output, raw.size, planes, &comments)?;
        }
    }
    Ok(())
}

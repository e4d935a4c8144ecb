//! A picture of named channels into a file, and out of one.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use exr::error::UnitResult;
use exr::prelude::*;

use crate::error::MergeError;

/// Writes channels of so many pixels each, first row at the top, in single precision, compressed without loss; `comments`
/// stand in the file's header.
///
/// # Errors
/// [`MergeError::Write`].
pub fn write(
    path: &Path,
    [width, height]: [usize; 2],
    channels: Vec<(String, Vec<f32>)>,
    comments: &str,
) -> std::result::Result<(), MergeError> {
    let list =
        channels.into_iter().map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values))).collect();
    let attributes = LayerAttributes { comments: Some(comments.into()), ..LayerAttributes::default() };
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::FAST_LOSSLESS };
    let layer = Layer::new((width, height), attributes, encoding, AnyChannels::sort(list));
    replace(path, |file| Image::from_layer(layer).write().to_buffered(file))
}

/// The most pixels that are read.
const MOST_PIXELS: usize = 1 << 28;

/// Channels of a picture, each first row at the top.
#[derive(Debug)]
pub struct Channels {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// The channels that must be there, in the order in which they were asked for.
    pub needed: Vec<Vec<f32>>,
    /// The one that may be there.
    pub optional: Option<Vec<f32>>,
}

/// Reads channels by name from a file's first layer.
///
/// # Errors
/// [`MergeError::Read`]: the file is missing, broken off, or too large; one of the needed channels is missing; the pixels are not those of
/// the whole picture.
pub fn read(path: &Path, needed: &[&str], optional: &str) -> std::result::Result<Channels, MergeError> {
    let wrong = |reason: String| MergeError::Read { file: path.to_owned(), reason };
    let failed = |error: Error| wrong(error.to_string());
    let header = MetaData::read_from_file(path, false).map_err(failed)?;
    let pixels = header.headers.first().map_or(0, |first| first.layer_size.0.saturating_mul(first.layer_size.1));
    if pixels > MOST_PIXELS {
        return Err(wrong(format!("it has {pixels} pixels, more than {MOST_PIXELS}")));
    }
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let image = image.all_attributes().from_file(path).map_err(failed)?;
    let layer = &image.layer_data;
    let window = image.attributes.display_window;
    if layer.attributes.layer_position != window.position || layer.size != window.size {
        return Err(wrong("its data window is not that of the whole picture".to_owned()));
    }
    let named = |name: &str| {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name);
        channel.map(|channel| channel.sample_data.values_as_f32().collect::<Vec<f32>>())
    };
    let must = |name: &&str| named(name).ok_or_else(|| wrong(format!("it has no channel {name}")));
    let needed = needed.iter().map(must).collect::<std::result::Result<_, _>>()?;
    Ok(Channels { size: [layer.size.0, layer.size.1], needed, optional: named(optional) })
}

/// Replaces a file by the output of a function; the old file stays where that fails.
pub(crate) fn replace(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> UnitResult,
) -> std::result::Result<(), MergeError> {
    petzval_files::write(path, content)
        .map_err(|error: exr::error::Error| MergeError::Write { file: path.to_owned(), reason: error.to_string() })
}

//! A picture of named channels into a file.

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

/// Replaces a file by what a function writes; the old file stays where that fails.
pub(crate) fn replace(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> UnitResult,
) -> std::result::Result<(), MergeError> {
    petzval_files::write(path, content)
        .map_err(|error: exr::error::Error| MergeError::Write { file: path.to_owned(), reason: error.to_string() })
}

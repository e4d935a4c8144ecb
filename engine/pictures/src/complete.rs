//! A check that a file holds a whole picture.

use crate::error::MergeError;
use exr::block;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Width and height of an OpenEXR file all of whose chunks of pixels are there. They are read, not decompressed.
///
/// # Errors
/// [`MergeError::Read`].
pub fn size_of_complete(path: &Path) -> Result<[usize; 2], MergeError> {
    let wrong = |reason: String| MergeError::Read { file: path.to_owned(), reason };
    let file = File::open(path).map_err(|error| wrong(error.to_string()))?;
    let read = || -> exr::error::Result<[usize; 2]> {
        let reader = block::read(BufReader::with_capacity(1 << 20, file), false)?;
        let size = reader.headers().first().map_or([0; 2], |header| [header.layer_size.0, header.layer_size.1]);
        for chunk in reader.all_chunks(false)? {
            chunk?;
        }
        Ok(size)
    };
    read().map_err(|error| wrong(error.to_string()))
}

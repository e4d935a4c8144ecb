//! Pictures in OpenEXR files, as they come to be merged, photographed by a sensor, or read as an ST map.

use std::sync::OnceLock;

use petzval_pictures::{channels, complete, merge};

use super::{Scratch, one_line};

/// Memory that merging may take, bytes.
const MEMORY: u64 = 64 << 20;
/// Width and height of the picture that others are merged with.
const SIZE: [usize; 2] = [6, 4];

/// A picture with the channels of a small render.
///
/// # Panics
/// If it cannot be written.
pub fn picture() -> Vec<u8> {
    let scratch = Scratch::new("picture-template");
    let file = scratch.file("picture.exr");
    let values = |by: f32| (0..SIZE[0] * SIZE[1]).map(|i| by * i as f32).collect::<Vec<f32>>();
    let names = ["R", "G", "B", "A", "Debug Sample Count.X", "Combined.R", "Depth.Z"];
    let list =
        names.into_iter().zip(1u8..).map(|(name, i)| (format!("ViewLayer.{name}"), values(f32::from(i)))).collect();
    channels::write(&file, SIZE, list, "").unwrap_or_else(|error| panic!("{error}"));
    std::fs::read(&file).unwrap_or_else(|error| panic!("{error}"))
}

/// A picture is read, found whole and merged with another and with itself, or refused in one line.
pub fn merge_inputs(bytes: &[u8]) {
    static KEPT: OnceLock<Vec<u8>> = OnceLock::new();
    let kept = KEPT.get_or_init(picture);
    let scratch = Scratch::new("merge");
    let [given, other, output] = ["given.exr", "other.exr", "output.exr"].map(|name| scratch.file(name));
    assert!(std::fs::write(&given, bytes).is_ok() && std::fs::write(&other, kept).is_ok());
    if let Err(error) = complete::size_of_complete(&given) {
        one_line(&error);
    }
    match channels::read(&given, &["R", "G", "B"], "A") {
        Ok(read) => {
            let pixels = read.size[0] * read.size[1];
            assert!(read.needed.iter().chain(&read.optional).all(|values| values.len() == pixels), "{:?}", read.size);
        }
        Err(error) => one_line(&error),
    }
    for files in [[given.clone(), given.clone()], [other.clone(), given.clone()]] {
        match merge::merge(&files, &output, MEMORY) {
            Ok(merged) => {
                assert!(merged.samples >= 0.0, "{merged:?}");
                let again = complete::size_of_complete(&output);
                assert!(again.is_ok(), "what was merged cannot be read: {again:?}");
            }
            Err(error) => one_line(&error),
        }
    }
}

//! One of the pictures that are joined: its channels by pass, and its attributes about samples.

use crate::error::MergeError;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The pass that holds the number of samples of each pixel, as Cycles names it.
pub(crate) const COUNTS: &str = "Debug Sample Count";
/// Attribute: samples that every pixel has; missing where they have different ones.
const SAMPLES: &str = "petzval/samples";
/// Attribute: SEED:FIRST+COUNT, more of them with spaces between.
const RANGES: &str = "petzval/ranges";

/// Attribute: the data that decide the picture, whichever of its samples are taken: NAME=VALUE, more of them with "; " between.
const PICTURE: &str = "petzval/picture";

/// Attribute: the checksum of a view's red, behind it the view's name, then its view layer's. A file of one view has those of all.
const VIEW: &str = "petzval/view/";

/// A picture as it is read.
pub(crate) type Picture = Image<Layers<AnyChannels<FlatSamples>>>;

/// A picture to be joined with others.
pub(crate) struct PicturePart {
    pub(crate) file: PathBuf,
    pub(crate) picture: Picture,
    /// Layer and place in it of each channel, by its whole name ("ViewLayer.Combined.R").
    places: BTreeMap<String, (usize, usize)>,
    /// Names of view layers that hold the number of samples of each pixel.
    pub(crate) view_layers: Vec<String>,
    /// Samples that every pixel has; `None` where pixels have different counts.
    samples: Option<f64>,
    /// Seed, first sample and count of each range.
    pub(crate) ranges: Vec<(u64, u64, u64)>,
    /// The values that decide the picture, by name; empty where the file does not say them.
    pub(crate) picture_of: BTreeMap<String, String>,
    /// The view in stereo that it is of, where it has one alone and says which.
    pub(crate) view: Option<String>,
}

impl PicturePart {
    /// Reads a picture, if it fits into so many bytes of memory; gives the bytes that it took, too.
    pub(crate) fn read(file: &Path, memory_bytes: u64) -> std::result::Result<(Self, u64), MergeError> {
        let bytes = bytes_in_memory(file, memory_bytes)?;
        let failed = |error: Error| MergeError::Read { file: file.to_owned(), reason: error.to_string() };
        let picture: Picture = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_file(file)
            .map_err(failed)?;
        let mut places = BTreeMap::new();
        for (l, layer) in picture.layer_data.iter().enumerate() {
            for (c, channel) in layer.channel_data.list.iter().enumerate() {
                places.insert(whole_name(layer, &channel.name), (l, c));
            }
        }
        let suffix = format!(".{COUNTS}.");
        let view_layers = places.keys().filter_map(|name| Some(name.split_once(&suffix)?.0.to_owned())).collect();
        let text = |name: &str| {
            let of = |attributes: &std::collections::HashMap<Text, AttributeValue>| {
                attributes.iter().find(|(key, _)| **key == *name).and_then(|(_, value)| match value {
                    AttributeValue::Text(text) => Some(text.to_string()),
                    _ => None,
                })
            };
            of(&picture.attributes.other).or_else(|| picture.layer_data.iter().find_map(|l| of(&l.attributes.other)))
        };
        let samples = text(SAMPLES).and_then(|text| text.trim().parse().ok()).filter(|n: &f64| is_count(*n));
        let ranges = text(RANGES).map_or_else(Vec::new, |text| text.split_whitespace().filter_map(range).collect());
        let named = |text: &str| text.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
        let picture_of = text(PICTURE).map_or_else(BTreeMap::new, |text| text.split("; ").filter_map(named).collect());
        let (file, view) = (file.to_owned(), None);
        let mut part = Self { file, picture, places, view_layers, samples, ranges, picture_of, view };
        part.view = part.find_view();
        Ok((part, bytes))
    }

    /// The view whose red the file has, by the attributes; `None` where none or several have it.
    fn find_view(&self) -> Option<String> {
        let told = self.attributes().filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string().strip_prefix(VIEW)?.to_owned(), text.to_string())),
            _ => None,
        });
        let told: BTreeMap<String, String> = told.collect();
        let mut views = told.iter().filter_map(|(name, checksum)| {
            let (view, layer) = name.split_once('/')?;
            (self.checksum(layer)? == *checksum).then_some(view)
        });
        let first = views.next()?;
        views.all(|view| view == first).then(|| first.to_owned())
    }

    fn attributes(&self) -> impl Iterator<Item = (&Text, &AttributeValue)> {
        let of_layers = self.picture.layer_data.iter().flat_map(|layer| &layer.attributes.other);
        of_layers.chain(&self.picture.attributes.other)
    }

    /// The checksum of the red of a view layer, row by row from above; `None` where it is not there, or in several views.
    fn checksum(&self, layer: &str) -> Option<String> {
        let red = self.channel(&format!("{layer}.Combined.R")).or_else(|| self.channel("R"))?;
        let bytes: Vec<u8> = red.iter().flat_map(|value| value.to_le_bytes()).collect();
        Some(format!("{:08x}", crc32fast::hash(&bytes)))
    }

    /// Whole names of all channels.
    pub(crate) fn names(&self) -> impl Iterator<Item = &String> {
        self.places.keys()
    }

    pub(crate) fn size(&self) -> [usize; 2] {
        self.picture.layer_data.first().map_or([0; 2], |layer| [layer.size.x(), layer.size.y()])
    }

    /// True if the file's compression is lossless.
    pub(crate) fn is_lossless(&self) -> bool {
        use Compression as C;
        let lossless = |layer: &Layer<_>| {
            matches!(layer.encoding.compression, C::Uncompressed | C::RLE | C::ZIP1 | C::ZIP16 | C::PIZ)
        };
        self.picture.layer_data.iter().all(lossless)
    }

    /// The values of a channel by its name, row by row; `None`: there is none.
    pub(crate) fn channel(&self, name: &str) -> Option<Vec<f32>> {
        let &(layer, place) = self.places.get(name)?;
        let samples = &self.picture.layer_data[layer].channel_data.list[place].sample_data;
        Some(samples.values_as_f32().collect())
    }

    /// Puts others in their place; a channel that is kept in half precision stays so.
    pub(crate) fn set(&mut self, name: &str, values: Vec<f32>) {
        let Some(&(layer, place)) = self.places.get(name) else { return };
        let samples = &mut self.picture.layer_data[layer].channel_data.list[place].sample_data;
        *samples = match samples {
            FlatSamples::F16(_) => FlatSamples::F16(values.into_iter().map(f16::from_f32).collect()),
            FlatSamples::F32(_) => FlatSamples::F32(values),
            FlatSamples::U32(_) => FlatSamples::U32(values.into_iter().map(|value| value as u32).collect()),
        };
    }

    /// Samples of each pixel of a view layer, or of the whole picture.
    pub(crate) fn counts(&self, view_layer: Option<&str>) -> std::result::Result<Vec<f64>, MergeError> {
        let own = view_layer.and_then(|name| {
            let found = self.places.keys().find(|key| key.starts_with(&format!("{name}.{COUNTS}.")))?;
            self.channel(found)
        });
        if let Some(counts) = own {
            let counts: Vec<f64> = counts.into_iter().map(f64::from).collect();
            let is_good = counts.iter().copied().all(is_count);
            return if is_good { Ok(counts) } else { Err(MergeError::Counts(self.file.clone())) };
        }
        let [width, height] = self.size();
        let samples = self.samples.ok_or_else(|| MergeError::Counts(self.file.clone()))?;
        Ok(vec![samples; width * height])
    }

    /// Writes the number of samples, and their ranges, into the picture's attributes.
    pub(crate) fn tell(&mut self, samples: Option<f64>, ranges: &[(u64, u64, u64)]) {
        let told: Vec<String> = ranges.iter().map(|(seed, first, count)| format!("{seed}:{first}+{count}")).collect();
        let values = [(RANGES, (!told.is_empty()).then(|| told.join(" "))), (SAMPLES, samples.map(|n| format!("{n}")))];
        for (name, value) in values {
            let name = Text::from(name);
            self.picture.attributes.other.remove(&name);
            for layer in &mut self.picture.layer_data {
                layer.attributes.other.remove(&name);
                if let Some(value) = &value {
                    layer.attributes.other.insert(name.clone(), AttributeValue::Text(value.as_str().into()));
                }
            }
        }
    }

    /// Puts the checksums of the pixels that are there now in place of those of before, for the view that it is of.
    pub(crate) fn tell_view(&mut self) {
        let Some(view) = &self.view else { return };
        let own = format!("{VIEW}{view}/");
        let names: Vec<Text> = self.attributes().map(|(name, _)| name.clone()).collect();
        for name in names {
            let checksum = name.to_string().strip_prefix(&own).and_then(|layer| self.checksum(layer));
            let Some(checksum) = checksum else { continue };
            let of_layers = self.picture.layer_data.iter_mut().map(|layer| &mut layer.attributes.other);
            for attributes in of_layers.chain([&mut self.picture.attributes.other]) {
                if let Some(told) = attributes.get_mut(&name) {
                    *told = AttributeValue::Text(checksum.as_str().into());
                }
            }
        }
    }

    /// The samples that every pixel has, if it says so.
    pub(crate) fn even_samples(&self) -> Option<f64> {
        self.samples
    }
}

/// The bytes that a picture takes in memory, by its headers alone, which may say anything.
fn bytes_in_memory(file: &Path, memory_bytes: u64) -> std::result::Result<u64, MergeError> {
    let failed = |reason: String| MergeError::Read { file: file.to_owned(), reason };
    let length = std::fs::metadata(file).map_err(|error| failed(error.to_string()))?.len();
    let headers = MetaData::read_from_file(file, false).map_err(|error| failed(error.to_string()))?.headers;
    let of_header = |header: &Header| {
        let [width, height] = [header.layer_size.x(), header.layer_size.y()].map(|side| side as u64);
        width.saturating_mul(height).saturating_mul(header.channels.list.len() as u64 * size_of::<f32>() as u64)
    };
    let bytes = headers.iter().map(of_header).fold(0, u64::saturating_add);
    let [width, height] = headers.first().map_or([0; 2], |header| [header.layer_size.x(), header.layer_size.y()]);
    let too_large = |why: String| MergeError::TooLarge { file: file.to_owned(), width, height, bytes, why };
    if bytes / MOST_PACKED > length {
        return Err(too_large("the file is too short to hold them: it is damaged".into()));
    }
    if bytes > memory_bytes {
        return Err(too_large(format!("{} MB are free", memory_bytes / 1_000_000)));
    }
    Ok(bytes)
}

/// Bytes that a byte of a file can stand for. Deflate reaches 1032 (zlib's documentation); PIZ of one value somewhat more.
const MOST_PACKED: u64 = 10_000;

/// True if a number can be a number of samples.
fn is_count(samples: f64) -> bool {
    (0.0..=4_294_967_296.0).contains(&samples)
}

fn whole_name(layer: &Layer<AnyChannels<FlatSamples>>, channel: &Text) -> String {
    let channel = channel.to_string();
    let name = match &layer.attributes.layer_name {
        // In files of several parts the part's name may stand before the channel's, or instead of its beginning.
        Some(name) if !channel.contains('.') => format!("{name}.{channel}"),
        _ => channel,
    };
    // Views of one file have channels of the same names; each stands for itself.
    match layer.attributes.view_name.as_ref().map(ToString::to_string).filter(|view| !view.is_empty()) {
        Some(view) => format!("{view}:{name}"),
        None => name,
    }
}

fn range(text: &str) -> Option<(u64, u64, u64)> {
    let (seed, rest) = text.split_once(':')?;
    let (first, count) = rest.split_once('+')?;
    let (first, count): (u64, u64) = (first.parse().ok()?, count.parse().ok()?);
    // Its end is a number, too.
    first.checked_add(count)?;
    Some((seed.parse().ok()?, first, count))
}

#[cfg(test)]
mod tests {
    use super::range;

    #[test]
    fn ranges_end_at_numbers() {
        assert_eq!(range("3:10+5"), Some((3, 10, 5)));
        for none in ["3:10", "3+5", "3:18446744073709551615+5", "3:1+18446744073709551616", "-3:1+1"] {
            assert_eq!(range(none), None, "{none}");
        }
    }
}

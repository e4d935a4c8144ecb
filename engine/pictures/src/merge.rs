//! Renders of the same picture with other samples, joined into one: each pixel by its number of samples in each.
//!
//! A pass is the mean over a pixel's samples, so the whole is the mean of the parts by their counts. Where all parts hold the remainders
//! that their numbers leave out of the sums (the passes "Remainder" and "Remainder Fine") in files without loss, the joined picture is that
//! of one render with all the samples, to the last bit. Depth, position and normal are means over surfaces; mattes are joined by name.
//! Light of a kind of lobe is divided by its colour: it is joined times that, as far as the colour is there. Pass indices are those of the
//! most samples.

use crate::channels::replace;
use crate::error::MergeError;
use crate::mattes;
use crate::part::{COUNTS, PicturePart};
use petzval_files::one_line;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const COMBINED: &str = "Combined";
const REMAINDERS: [&str; 2] = ["Remainder", "Remainder Fine"];
/// The index passes by Blender's names, those of before version 5 included.
const INDICES: [&str; 4] = ["Object Index", "Material Index", "IndexOB", "IndexMA"];
/// The depth of pixels without a hit, and less than it.
const FARTHEST: f32 = 1e10;
const NEARLY_FARTHEST: f32 = 1e9;

/// Data of the merged picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// Mean samples a pixel.
    pub samples: f64,
    /// True if the picture is that of one render, to the last bit.
    pub is_exact: bool,
}

/// Joins pictures, and writes the whole with the first one's layers and attributes. They take no more than so many bytes of memory.
///
/// # Errors
/// [`MergeError`]; nothing is written then.
pub fn merge(files: &[PathBuf], output: &Path, memory_bytes: u64) -> Result<Merged, MergeError> {
    if files.len() < 2 {
        return Err(MergeError::TooFew(files.len()));
    }
    let (mut parts, mut left) = (Vec::new(), memory_bytes);
    for file in files {
        let (part, bytes) = PicturePart::read(file, left)?;
        left = left.saturating_sub(bytes);
        parts.push(part);
    }
    check(&parts)?;

    let names: Vec<String> = parts[0].names().cloned().collect();
    let view_layers = parts[0].view_layers.clone();
    let of_layer = |name: &str| view_layers.iter().find(|layer| name.starts_with(&format!("{layer}."))).cloned();
    let mut passes: BTreeMap<(Option<String>, String), Vec<String>> = BTreeMap::new();
    for name in &names {
        let layer = of_layer(name);
        let inside = layer.as_ref().map_or(name.as_str(), |layer| &name[layer.len() + 1..]);
        let pass = inside.rsplit_once('.').map_or("", |(pass, _)| pass);
        passes.entry((layer, pass.to_owned())).or_default().push(name.clone());
    }
    let layers: BTreeSet<Option<String>> = passes.keys().map(|(layer, _)| layer.clone()).collect();
    let (mut samples, mut is_exact) = (0.0, parts.iter().all(PicturePart::is_lossless));
    for layer in &layers {
        let counts = parts.iter().map(|part| part.counts(layer.as_deref())).collect::<Result<Vec<_>, _>>()?;
        let joining = Joining { counts: &counts, totals: totals(&counts) };
        samples = joining.totals.iter().sum::<f64>() / joining.totals.len().max(1) as f64;
        let mut done: Vec<(String, Vec<f32>)> = Vec::new();
        for ((of, pass), channels) in &passes {
            if of == layer {
                is_exact &= joining.pass(&parts, pass, channels, &mut done);
            }
        }
        for (name, values) in done {
            parts[0].set(&name, values);
        }
    }

    let even = parts.iter().map(PicturePart::even_samples).sum::<Option<f64>>();
    let ranges: Vec<_> = parts.iter().flat_map(|part| part.ranges.clone()).collect();
    let is_known = parts.iter().all(|part| !part.ranges.is_empty());
    parts[0].tell(even, if is_known { &ranges } else { &[] });
    parts[0].tell_view();
    write(&parts[0], output)?;
    Ok(Merged { samples, is_exact })
}

/// The pass by which a pass of light is divided.
fn colour_of(pass: &str) -> Option<String> {
    for (lobe, short) in [("Diffuse", "Diff"), ("Glossy", "Gloss"), ("Transmission", "Trans")] {
        if [format!("{lobe} Direct"), format!("{lobe} Indirect")].iter().any(|name| name == pass) {
            return Some(format!("{lobe} Color"));
        }
        if [format!("{short}Dir"), format!("{short}Ind")].iter().any(|name| name == pass) {
            return Some(format!("{short}Col"));
        }
    }
    None
}

fn write(part: &PicturePart, output: &Path) -> Result<(), MergeError> {
    use exr::prelude::WritableImage;
    // It may be one of those that were read: they are whole in memory.
    replace(output, |file| part.picture.write().to_buffered(file))
}

/// Checks that the files are parts of one picture, none of them twice.
fn check(parts: &[PicturePart]) -> Result<(), MergeError> {
    let first = &parts[0];
    let names: BTreeSet<&String> = first.names().collect();
    for part in &parts[1..] {
        let unlike = |what: String| MergeError::Unlike { file: part.file.clone(), what: one_line(&what) };
        if part.size() != first.size() {
            let ([w, h], [w0, h0]) = (part.size(), first.size());
            return Err(unlike(format!("it has {w} x {h} pixels, not {w0} x {h0}")));
        }
        let own: BTreeSet<&String> = part.names().collect();
        if let Some(name) = names.symmetric_difference(&own).next() {
            let (with, without) = if own.contains(*name) { (part, first) } else { (first, part) };
            let (with, without) = (with.file.display(), without.file.display());
            return Err(unlike(format!("the channel {name} is in {with}, not in {without}")));
        }
        if let (Some(view), Some(other)) = (&part.view, &first.view)
            && view != other
        {
            return Err(unlike(format!("it is the view '{view}', and {} is the view '{other}'", first.file.display())));
        }
        if let Some(what) = difference(first, part) {
            return Err(unlike(what));
        }
    }
    for (i, part) in parts.iter().enumerate() {
        for other in &parts[..i] {
            for (seed, first, count) in &part.ranges {
                let both = other.ranges.iter().find(|(s, f, c)| s == seed && *f < first + count && *first < f + c);
                if let Some((_, f, c)) = both {
                    return Err(MergeError::Twice {
                        file: part.file.clone(),
                        other: other.file.clone(),
                        seed: *seed,
                        range: [*f, f + c],
                    });
                }
            }
        }
    }
    Ok(())
}

/// The first thing in which the pictures of two parts differ, if they do.
fn difference(first: &PicturePart, part: &PicturePart) -> Option<String> {
    let mut names: Vec<&String> = first.picture_of.keys().chain(part.picture_of.keys()).collect();
    // Another lens has other settings, and another camera may have another scene: the cause first.
    let rank = |name: &String| match name.as_str() {
        "lens" => 0,
        "scene" => 2,
        _ => 1,
    };
    names.sort_by_key(|name| (rank(name), *name));
    let other = first.file.display();
    let named = names.into_iter().find_map(|name| {
        let (here, there) = (part.picture_of.get(name), first.picture_of.get(name));
        (here != there).then_some((name, here, there))
    });
    let (name, here, there) = named?;
    Some(match (here, there) {
        _ if first.picture_of.is_empty() || part.picture_of.is_empty() => {
            let silent = if part.picture_of.is_empty() { part } else { first };
            format!("{} does not say of which picture it is", silent.file.display())
        }
        // Digests tell nothing.
        (Some(here), Some(there)) if name.contains('.') => format!("{name} is {here}, and {there} in {other}"),
        _ => format!("its {name} is not that of {other}"),
    })
}

fn totals(counts: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; counts[0].len()];
    for part in counts {
        sum.iter_mut().zip(part).for_each(|(sum, n)| *sum += n);
    }
    sum
}

/// The passes of a view layer under way.
struct Joining<'a> {
    /// Samples by picture, then pixel.
    counts: &'a [Vec<f64>],
    totals: Vec<f64>,
}

impl Joining<'_> {
    /// Joins a pass; false if it is the picture, and is exact to its rounding only.
    fn pass(&self, parts: &[PicturePart], pass: &str, channels: &[String], done: &mut Vec<(String, Vec<f32>)>) -> bool {
        if REMAINDERS.contains(&pass) {
            // With the picture.
            return true;
        }
        if pass == COUNTS {
            done.extend(channels.iter().map(|name| (name.clone(), self.totals.iter().map(|n| *n as f32).collect())));
            return true;
        }
        if pass.starts_with("Crypto") {
            self.mattes(parts, pass, channels, done);
            return true;
        }
        if INDICES.contains(&pass) {
            done.extend(channels.iter().map(|name| (name.clone(), self.most(parts, name))));
            return true;
        }
        if let Some(colour) = colour_of(pass)
            && let Some(joined) =
                channels.iter().map(|name| self.over_colour(parts, name, pass, &colour)).collect::<Option<Vec<_>>>()
        {
            done.extend(channels.iter().cloned().zip(joined));
            return true;
        }
        let is_picture = pass == COMBINED || pass.is_empty();
        let mut is_exact = true;
        let mut plain = Vec::new();
        for name in channels {
            if !(is_picture && self.exact(parts, name, done)) {
                is_exact &= !is_picture;
                plain.push(name);
            }
        }
        let values: Vec<Vec<Vec<f32>>> =
            parts.iter().map(|part| plain.iter().filter_map(|name| part.channel(name)).collect()).collect();
        // What a pixel holds in which nothing was seen.
        let nothing = match pass {
            "Depth" => Some(FARTHEST),
            "Position" | "Normal" => Some(0.0),
            _ => None,
        };
        done.extend(plain.into_iter().cloned().zip(self.means(&values, nothing)));
        is_exact
    }

    /// Means of light that is divided by a colour, which stay that of the joined colour; `None` where no colour is there.
    fn over_colour(&self, parts: &[PicturePart], name: &str, pass: &str, colour: &str) -> Option<Vec<f32>> {
        let (before, channel) = name.rsplit_once(pass)?;
        let colour = format!("{before}{colour}{channel}");
        let (mut light, mut weights) = (vec![0.0; self.totals.len()], vec![0.0; self.totals.len()]);
        for (part, counts) in parts.iter().zip(self.counts) {
            let (values, colours) = (part.channel(name)?, part.channel(&colour)?);
            for i in 0..values.len() {
                let weight = f64::from(colours[i]) * counts[i];
                light[i] += f64::from(values[i]) * weight;
                weights[i] += weight;
            }
        }
        let over = |(light, weight): (&f64, &f64)| if *weight == 0.0 { 0.0 } else { (light / weight) as f32 };
        Some(light.iter().zip(&weights).map(over).collect())
    }

    /// The value by pixel that most samples have; of two that have as many, the lesser.
    fn most(&self, parts: &[PicturePart], name: &str) -> Vec<f32> {
        let values: Vec<Vec<f32>> = parts.iter().filter_map(|part| part.channel(name)).collect();
        let of_pixel = |i: usize| {
            let votes = |value: f32| -> f64 {
                values.iter().zip(self.counts).filter(|(own, _)| own[i] == value).map(|(_, counts)| counts[i]).sum()
            };
            let better = |a: f32, b: f32| if (votes(b), -b) > (votes(a), -a) { b } else { a };
            values.iter().map(|own| own[i]).reduce(better).unwrap_or(0.0)
        };
        (0..self.totals.len()).map(of_pixel).collect()
    }

    /// Means by counts of channels (by picture, then channel), together. Of means over surfaces, `nothing` where most
    /// of the samples saw none: the means of the pictures that saw some, unless those that did not have more samples.
    fn means(&self, values: &[Vec<Vec<f32>>], nothing: Option<f32>) -> Vec<Vec<f32>> {
        let channels = values.first().map_or(0, Vec::len);
        let mut out = vec![vec![0.0; self.totals.len()]; channels];
        let mut sums = vec![0.0; channels];
        for (i, &total) in self.totals.iter().enumerate() {
            sums.fill(0.0);
            let mut weight = 0.0;
            for (values, counts) in values.iter().zip(self.counts) {
                let is_nothing =
                    |value: f32, nothing: f32| value == nothing || (nothing > 0.0 && value > NEARLY_FARTHEST);
                if nothing.is_some_and(|nothing| values.iter().all(|channel| is_nothing(channel[i], nothing))) {
                    continue;
                }
                weight += counts[i];
                sums.iter_mut().zip(values).for_each(|(sum, channel)| *sum += f64::from(channel[i]) * counts[i]);
            }
            for (channel, sum) in sums.iter().enumerate() {
                out[channel][i] = match nothing {
                    Some(nothing) if 2.0 * weight < total || weight == 0.0 => nothing,
                    None if weight == 0.0 => values[0][channel][i],
                    _ => (sum / weight) as f32,
                };
            }
        }
        out
    }

    /// Joins a channel of the picture with the remainder of its sums; false if a part has no such remainder.
    fn exact(&self, parts: &[PicturePart], name: &str, done: &mut Vec<(String, Vec<f32>)>) -> bool {
        let Some((before, channel)) = name.rsplit_once(&format!("{COMBINED}.")) else { return false };
        let rests = REMAINDERS.map(|rest| format!("{before}{rest}.{channel}"));
        let mut sums = vec![0.0f64; self.totals.len()];
        for (part, counts) in parts.iter().zip(self.counts) {
            let (Some(values), Some(first), Some(second)) =
                (part.channel(name), part.channel(&rests[0]), part.channel(&rests[1]))
            else {
                return false;
            };
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum += f64::from(values[i]) * counts[i] + f64::from(first[i]) + f64::from(second[i]);
            }
        }
        let n = |i: usize| self.totals[i].max(1.0);
        let values: Vec<f32> = sums.iter().enumerate().map(|(i, sum)| (sum / n(i)) as f32).collect();
        // What is left out of the joined sums, for the next time.
        let rest = |i: usize| sums[i] - f64::from(values[i]) * self.totals[i];
        let first: Vec<f32> = (0..sums.len()).map(|i| rest(i) as f32).collect();
        let second = (0..sums.len()).map(|i| (rest(i) - f64::from(first[i])) as f32).collect();
        let [first_name, second_name] = rests;
        done.extend([(name.to_owned(), values), (first_name, first), (second_name, second)]);
        true
    }

    /// A pass of mattes: all of its layer's are joined when the first of them comes.
    fn mattes(&self, parts: &[PicturePart], pass: &str, channels: &[String], done: &mut Vec<(String, Vec<f32>)>) {
        let kind = pass.trim_end_matches(|c: char| c.is_ascii_digit());
        if pass != format!("{kind}00") {
            return;
        }
        let Some(before) = channels.first().and_then(|name| Some(name.rsplit_once(pass)?.0.to_owned())) else { return };
        // Two ranks in each pass: RG and BA, as Blender names channels of colours; RGBA in some case.
        let own = |level: usize, letter: char| {
            let name = |letter| format!("{before}{kind}{level:02}.{letter}");
            [name(letter), name(letter.to_ascii_lowercase())]
                .into_iter()
                .find(|name| parts[0].names().any(|known| known == name))
        };
        let mut ranks: Vec<[String; 2]> = Vec::new();
        while let (Some(r), Some(g), Some(b), Some(a)) = {
            let level = ranks.len() / 2;
            (own(level, 'R'), own(level, 'G'), own(level, 'B'), own(level, 'A'))
        } {
            ranks.extend([[r, g], [b, a]]);
        }
        let read = |part: &PicturePart| -> Vec<[Vec<f32>; 2]> {
            ranks.iter().map(|rank| rank.each_ref().map(|name| part.channel(name).unwrap_or_default())).collect()
        };
        let values: Vec<_> = parts.iter().map(read).collect();
        let pixels = self.totals.len();
        let mut out = vec![[vec![0.0; pixels], vec![0.0; pixels]]; ranks.len()];
        for i in 0..pixels {
            let of = |(values, counts): (&Vec<[Vec<f32>; 2]>, &Vec<f64>)| {
                (counts[i], values.iter().map(|[name, cover]| [name[i], cover[i]]).collect())
            };
            let parts: Vec<(f64, Vec<[f32; 2]>)> = values.iter().zip(self.counts).map(of).collect();
            for (out, rank) in out.iter_mut().zip(mattes::joined(&parts)) {
                (out[0][i], out[1][i]) = (rank[0], rank[1]);
            }
        }
        for (names, values) in ranks.into_iter().zip(out) {
            done.extend(names.into_iter().zip(values));
        }
    }
}

#[cfg(test)]
mod tests;

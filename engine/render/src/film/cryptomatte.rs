//! Cryptomatte (Friedman and Jones 2015; Psyop's specification 1.2.0): which objects, materials and assets a pixel sees,
//! each with the part of the pixel that it covers.
//!
//! Each ray that gets through the lens counts alike, as for the other passes of data, so that a matte is blurred as the
//! picture is. A name is known by its hash, a number whose bits also are those of an ordinary float.

use super::packed::{MOST_ROWS, Row};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Names kept for a pixel beyond those that are asked for: where there are more still, the weakest are forgotten, and
/// one that comes back begins anew.
const SPARE: usize = 10;
/// Blender's name for the material of an empty slot.
const NO_MATERIAL: &str = "default_surface";

/// The kind of name that a matte tells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteLayer {
    /// Objects by their own names.
    Object,
    /// Materials by their names; empty slots are `default_surface`.
    Material,
    /// Objects by their topmost parent.
    Asset,
    /// Objects by their pass index, of which a pixel has one: [`super::Film::most_seen`].
    ObjectIndex,
    /// Materials by their pass index, of which a pixel has one: [`super::Film::most_seen`].
    MaterialIndex,
}

/// The mattes that are kept.
#[derive(Clone, Debug, Default)]
pub struct Mattes {
    layers: Vec<(MatteLayer, IdTable)>,
    levels: usize,
}

/// The ids of one layer.
#[derive(Clone, Debug)]
struct IdTable {
    /// The ids, by instance or material.
    ids: Vec<u32>,
    names: BTreeMap<String, u32>,
}

impl Mattes {
    /// The mattes of a scene, each with the `levels` names that cover most of a pixel.
    pub fn new(scene: &Scene, layers: &[MatteLayer], levels: u32) -> Self {
        let owners = if layers.is_empty() { Vec::new() } else { scene.owners() };
        let indices = |layer: &MatteLayer| -> Option<Vec<u32>> {
            match layer {
                MatteLayer::ObjectIndex => Some(scene.instances.iter().map(|i| i.info.pass_index as u32).collect()),
                MatteLayer::MaterialIndex => Some(scene.materials.iter().map(|m| m.pass_index as u32).collect()),
                _ => None,
            }
        };
        let table = |layer: &MatteLayer| {
            if let Some(ids) = indices(layer) {
                return (*layer, IdTable { ids, names: BTreeMap::new() });
            }
            let names: Vec<&str> = match layer {
                MatteLayer::Object => scene.placed().iter().map(|i| i.object_name.as_str()).collect(),
                MatteLayer::Asset => scene.placed().iter().map(|i| i.asset_name.as_str()).collect(),
                // The first stands for empty slots.
                _ => std::iter::once(NO_MATERIAL)
                    .chain(scene.materials.iter().skip(1).map(|m| m.name.as_str()))
                    .collect(),
            };
            let ids: Vec<u32> = names.iter().map(|name| id(name)).collect();
            let names = names.iter().map(|&name| name.to_owned()).zip(ids.iter().copied()).collect();
            // What stands for a moment has its owner's.
            let ids = match layer {
                MatteLayer::Object | MatteLayer::Asset => owners.iter().map(|&owner| ids[owner as usize]).collect(),
                _ => ids,
            };
            (*layer, IdTable { ids, names })
        };
        Self { layers: layers.iter().map(table).collect(), levels: levels as usize }
    }

    /// True if no mattes are kept.
    pub fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }

    /// Passes of four channels that a layer fills.
    pub fn passes(&self) -> usize {
        self.levels.div_ceil(2)
    }

    fn table(&self, layer: MatteLayer) -> Option<(usize, &IdTable)> {
        let at = self.layers.iter().position(|(l, _)| *l == layer)?;
        Some((at, &self.layers[at].1))
    }

    /// The names of a layer with their ids, in alphabetical order.
    pub fn names(&self, layer: MatteLayer) -> Option<&BTreeMap<String, u32>> {
        self.table(layer).map(|(_, table)| &table.names)
    }
}

/// The id of a name: its hash, changed where its bits would be a float that is not finite, or too small to be kept.
pub fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    if matches!(hash >> 23 & 255, 0 | 255) { hash ^ 1 << 23 } else { hash }
}

/// MurmurHash3, 32 bits, seed 0 (Appleby 2011).
fn murmur3(bytes: &[u8]) -> u32 {
    let mix = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let little = |part: &[u8]| part.iter().rev().fold(0, |k, &byte| k << 8 | u32::from(byte));
    let blocks = bytes.chunks_exact(4);
    let tail = little(blocks.remainder());
    let mut h = blocks
        .fold(0u32, |h, block| (h ^ mix(little(block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64));
    h ^= mix(tail) ^ bytes.len() as u32;
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

/// The first hits of the rays of a part of the picture, while one thread notes them.
#[derive(Clone, Debug, Default)]
pub(super) struct MatteNotes {
    /// Rays that got through the lens, by pixel.
    rays: Vec<u32>,
    /// Pixel, instance and material of the rays that hit a surface.
    met: Vec<[u32; 3]>,
}

impl MatteNotes {
    pub(super) fn new(pixels: usize) -> Self {
        Self { rays: vec![0; pixels], met: Vec::new() }
    }

    /// Notes a ray of a pixel, with the instance and the material that it hit.
    #[inline]
    pub(super) fn add(&mut self, pixel: usize, met: Option<[u32; 2]>) {
        self.rays[pixel] += 1;
        if let Some([instance, material]) = met {
            self.met.push([pixel as u32, instance, material]);
        }
    }
}

/// Number of rays of a pixel that hit a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Count {
    pub pixel: u32,
    pub id: u32,
    pub rays: u32,
}

impl Row for Count {
    const COLUMNS: usize = 3;
    // Several names of each pixel.
    const MOST: usize = MOST_ROWS;
    const ZERO: Self = Self { pixel: 0, id: 0, rays: 0 };
    fn bits(&self, column: usize) -> u64 {
        u64::from([self.pixel, self.id, self.rays][column])
    }
    fn set(&mut self, column: usize, bits: u64) {
        *match column {
            0 => &mut self.pixel,
            1 => &mut self.id,
            _ => &mut self.rays,
        } = bits as u32;
    }
}

/// Sums of a part of the picture.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct MatteSums {
    #[serde(with = "super::packed")]
    rays: Vec<u32>,
    /// Counts by layer; in the order of pixels, in a pixel in that of ids.
    counts: Vec<Counts>,
}

/// Counts of a layer.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Counts(#[serde(with = "super::packed")] Vec<Count>);

impl MatteSums {
    /// True if they are sums of so many pixels, or of none, for these mattes.
    pub(super) fn fits(&self, mattes: &Mattes, pixels: usize) -> bool {
        let is_empty = self.rays.is_empty() && self.counts.is_empty();
        let (is_kept, layers) = (!mattes.is_empty(), mattes.layers.len());
        is_empty || is_kept && self.rays.len() == pixels && self.counts.len() == layers
    }

    pub(super) fn join(&mut self, mattes: &Mattes, notes: &MatteNotes) {
        self.rays.resize(notes.rays.len(), 0);
        self.rays.iter_mut().zip(&notes.rays).for_each(|(sum, add)| *sum += add);
        self.counts.resize(mattes.layers.len(), Counts::default());
        for (Counts(counts), (layer, table)) in self.counts.iter_mut().zip(&mattes.layers) {
            let id = |&[pixel, instance, material]: &[u32; 3]| {
                let is_material = matches!(layer, MatteLayer::Material | MatteLayer::MaterialIndex);
                let of = if is_material { material } else { instance };
                Count { pixel, id: table.ids[of as usize], rays: 1 }
            };
            counts.extend(notes.met.iter().map(id));
            counts.sort_unstable_by_key(|c| (c.pixel, c.id));
            counts.dedup_by(|c, kept| {
                let same = (c.pixel, c.id) == (kept.pixel, kept.id);
                kept.rays += if same { c.rays } else { 0 };
                same
            });
            forget_the_weakest(counts, mattes.levels + SPARE);
            counts.shrink_to_fit();
        }
    }

    /// The id that most of a pixel's rays hit; rays without a hit count as 0.
    pub(super) fn most_seen(&self, mattes: &Mattes, layer: MatteLayer, pixel: usize) -> u32 {
        let Some((at, _)) = mattes.table(layer) else { return 0 };
        let (Some(Counts(counts)), Some(&rays)) = (self.counts.get(at), self.rays.get(pixel)) else { return 0 };
        let start = counts.partition_point(|c| (c.pixel as usize) < pixel);
        let of_pixel = counts[start..].iter().take_while(|c| c.pixel as usize == pixel);
        let met: u64 = of_pixel.clone().map(|c| u64::from(c.rays)).sum();
        let unnamed: u64 = of_pixel.clone().filter(|c| c.id == 0).map(|c| u64::from(c.rays)).sum();
        // Of a file that was not written by a render, more may be met than there are.
        let nothing = u64::from(rays).saturating_sub(met) + unnamed;
        let most = of_pixel.filter(|c| c.id != 0).max_by_key(|c| (c.rays, std::cmp::Reverse(c.id)));
        most.filter(|c| u64::from(c.rays) > nothing).map_or(0, |c| c.id)
    }

    /// Ids and coverages of a pixel, strongest first; zero where there are no more.
    fn ranked(&self, layer: usize, pixel: usize, out: &mut [f32]) {
        let (Some(Counts(counts)), Some(&rays)) = (self.counts.get(layer), self.rays.get(pixel)) else { return };
        let start = counts.partition_point(|c| (c.pixel as usize) < pixel);
        let mut of_pixel: Vec<Count> =
            counts[start..].iter().copied().take_while(|c| c.pixel as usize == pixel).collect();
        of_pixel.sort_unstable_by_key(|c| (std::cmp::Reverse(c.rays), c.id));
        for (place, count) in out.chunks_exact_mut(2).zip(of_pixel) {
            place.copy_from_slice(&[f32::from_bits(count.id), count.rays as f32 / rays as f32]);
        }
    }
}

/// Keeps at most so many names of a pixel: those that most rays hit.
fn forget_the_weakest(counts: &mut Vec<Count>, most: usize) {
    if counts.chunk_by(|a, b| a.pixel == b.pixel).all(|of_pixel| of_pixel.len() <= most) {
        return;
    }
    let mut kept = Vec::with_capacity(counts.len());
    for of_pixel in counts.chunk_by_mut(|a, b| a.pixel == b.pixel) {
        if of_pixel.len() > most {
            of_pixel.sort_unstable_by_key(|c| (std::cmp::Reverse(c.rays), c.id));
            of_pixel[..most].sort_unstable_by_key(|c| c.id);
        }
        kept.extend_from_slice(&of_pixel[..of_pixel.len().min(most)]);
    }
    *counts = kept;
}

impl Mattes {
    /// Writes the ranked names of a pixel to the channels of all of a layer's passes.
    pub(super) fn write(&self, layer: MatteLayer, sums: &MatteSums, pixel: usize, channels: &mut [f32]) {
        if let Some((at, _)) = self.table(layer) {
            let filled = (2 * self.levels).min(channels.len());
            sums.ranked(at, pixel, &mut channels[..filled]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the reference implementation (SMHasher) for bytes of every length modulo four, and Cycles' names.
    #[test]
    fn hashes_are_murmurs() {
        assert_eq!(murmur3(b""), 0);
        assert_eq!(murmur3(b"test"), 0xba6b_d213);
        assert_eq!(murmur3(b"Hello, world!"), 0xc036_3e43);
        assert_eq!(murmur3(b"The quick brown fox jumps over the lazy dog"), 0x2e4f_f723);
        assert_eq!(id("default_surface"), 0x78d0_5529);
        assert_eq!(id("Wall"), 0x2c38_8f97);
        assert_eq!(id("W\u{e4}ll2"), 0xb229_c9dd);
    }

    /// Every id is a float that survives: the exponent is neither all zeros nor all ones.
    #[test]
    fn ids_are_ordinary_floats() {
        let changed = (0..2000).filter(|i| {
            let name = format!("object {i}");
            assert!(f32::from_bits(id(&name)).is_normal(), "{name}");
            id(&name) != murmur3(name.as_bytes())
        });
        assert!(changed.count() > 3);
    }

    fn mattes(names: u32, levels: usize) -> Mattes {
        let table = IdTable { ids: (0..names).map(|i| 1000 + i).collect(), names: BTreeMap::new() };
        Mattes { layers: vec![(MatteLayer::Object, table)], levels }
    }

    fn of_pixel(mattes: &Mattes, sums: &MatteSums, pixel: usize) -> Vec<(u32, f32)> {
        let mut out = vec![0.0; 4 * mattes.passes()];
        mattes.write(MatteLayer::Object, sums, pixel, &mut out);
        out.chunks_exact(2).map(|c| (c[0].to_bits(), c[1])).collect()
    }

    #[test]
    fn names_are_ranked_by_what_they_cover() {
        let mattes = mattes(9, 3);
        let mut sums = MatteSums::default();
        for _ in 0..2 {
            let mut notes = MatteNotes::new(2);
            notes.add(0, None);
            for instance in [5, 7, 7, 7, 2, 2, 8] {
                notes.add(1, Some([instance, 0]));
            }
            notes.add(1, None);
            sums.join(&mattes, &notes);
        }
        assert_eq!(of_pixel(&mattes, &sums, 0), [(0, 0.0); 4]);
        // The fourth place of the second pass is beyond the levels that were asked for.
        assert_eq!(of_pixel(&mattes, &sums, 1), [(1007, 0.375), (1002, 0.25), (1005, 0.125), (0, 0.0)]);
    }

    /// The index that most rays hit; rays without a hit, or with index 0, count as 0.
    #[test]
    fn an_index_is_that_of_most_rays() {
        let table = IdTable { ids: vec![0, 7, 300], names: BTreeMap::new() };
        let mattes = Mattes { layers: vec![(MatteLayer::ObjectIndex, table)], levels: 6 };
        let mut sums = MatteSums::default();
        let mut notes = MatteNotes::new(2);
        for met in [Some([1, 0]), Some([1, 0]), Some([2, 0]), Some([0, 0])] {
            notes.add(0, met);
            notes.add(1, met);
        }
        (0..2).for_each(|_| notes.add(1, None));
        sums.join(&mattes, &notes);
        assert_eq!([0, 1].map(|pixel| sums.most_seen(&mattes, MatteLayer::ObjectIndex, pixel)), [7, 0]);
    }

    /// If there are more names than fit, memory stays bounded, and those that cover most are still right.
    #[test]
    fn the_weakest_are_forgotten() {
        let mattes = mattes(500, 2);
        let mut sums = MatteSums::default();
        for pass in 0..40 {
            let mut notes = MatteNotes::new(1);
            for i in 0..16 {
                notes.add(
                    0,
                    Some([
                        if i < 8 {
                            499
                        } else if i < 13 {
                            3
                        } else {
                            4 + 3 * pass + i - 13
                        },
                        0,
                    ]),
                );
            }
            sums.join(&mattes, &notes);
            assert!(sums.counts[0].0.len() <= 2 + SPARE);
        }
        assert_eq!(of_pixel(&mattes, &sums, 0), [(1499, 0.5), (1003, 0.3125)]);
    }
}

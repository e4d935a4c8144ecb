//! Hair and other curves, checked once so that nothing later needs to.
//!
//! A strand is a Catmull-Rom curve through its keys (Catmull and Rom 1974), its first and its last key counted twice at the
//! ends; its radius follows the same curve. A segment goes from one key to the next and has the first one's number.

use super::SceneError;
use super::motion::Pose;
use glam::{Vec2, Vec3, Vec4};

/// The engine's name for the attribute that orients strands about themselves, object space.
pub const CURVE_NORMAL: &str = ".curve_normal";

/// The shape of a strand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveShape {
    /// A ribbon that faces whoever looks, its normal that of a round strand: this many even pieces a segment.
    Ribbon {
        /// Number of pieces, at least 1.
        pieces: u16,
    },
    /// A round strand, open at its ends.
    Thick,
    /// Round and straight from key to key: the body that a ball whose radius changes evenly sweeps, with round ends.
    ThickLinear,
}

/// Attribute values along strands.
#[derive(Clone, Debug)]
pub enum StrandValues {
    /// A value at each key; linear in between.
    ByKey(Vec<Vec4>),
    /// A value of each strand.
    ByStrand(Vec<Vec4>),
}

/// Curves as they arrive.
#[derive(Clone, Debug)]
pub struct CurvesDescription {
    /// The name for messages.
    pub name: String,
    /// Positions in object space, and radii.
    pub keys: Vec<Vec4>,
    /// Index of the first key by strand; then the number of keys.
    pub first_keys: Vec<u32>,
    /// The shape of the strands.
    pub shape: CurveShape,
    /// The number of the first strand: by theirs they get random numbers.
    pub first_number: u32,
    /// UV maps by name: for each strand the place of its root on the surface that it grows from.
    pub uv_maps: Vec<(String, Vec<Vec2>)>,
    /// Attributes by name, with values by key or by strand.
    pub attributes: Vec<(String, StrandValues)>,
    /// Positions of the keys, without radius, a frame before and a frame after; `None` where they keep their places.
    pub moved_keys: Option<[Vec<Vec3>; 2]>,
    /// Positions and radii at times that lie evenly over the time that the shutter is open; empty where they are constant.
    pub poses: Vec<Vec<Vec4>>,
}

/// Checked curves: every key finite, every radius at least zero.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Positions in object space, and radii.
    pub keys: Vec<Vec4>,
    /// Index of the first key by strand; then the number of keys.
    first_keys: Vec<u32>,
    /// The strand of each key whose number is a multiple of [`STRAND_STEP`].
    strand_at: Vec<u32>,
    /// The shape of the strands.
    pub shape: CurveShape,
    /// The numbers by strand that random numbers are made of.
    numbers: StrandNumbers,
    uv_maps: Vec<(String, Vec<Vec2>)>,
    attributes: Vec<(String, StrandValues)>,
    /// Positions of the keys a frame before and a frame after.
    pub moved_keys: Option<[Vec<Vec3>; 2]>,
    /// Positions and radii of the keys by time while the shutter is open; empty where nothing changes.
    pub(super) poses: Vec<Vec<Vec4>>,
}

/// The numbers of the strands, from which their random numbers are made.
#[derive(Clone, Debug)]
enum StrandNumbers {
    From(u32),
    Each(Vec<u32>),
}

/// One segment: the four keys that bend it, from before its start to behind its end.
#[derive(Clone, Copy, Debug)]
pub struct Controls(pub [Vec4; 4]);

impl Controls {
    /// The powers' coefficients of the curve, from the constant on.
    #[inline(always)]
    pub fn coefficients(&self) -> [Vec4; 4] {
        let [p, a, b, q] = self.0;
        [a, 0.5 * (b - p), p - 2.5 * a + 2.0 * b - 0.5 * q, 0.5 * (q - p) + 1.5 * (a - b)]
    }

    /// A part of the way to other control points.
    #[inline(always)]
    pub fn towards(&self, to: &Self, part: f32) -> Self {
        let mut now = *self;
        (0..4).for_each(|i| now.0[i] = now.0[i].lerp(to.0[i], part));
        now
    }

    /// Place and radius, `u` from 0 to 1.
    #[inline]
    pub fn at(&self, u: f32) -> Vec4 {
        let [a, b, c, d] = self.coefficients();
        a + u * (b + u * (c + u * d))
    }

    /// The derivative of place and radius by `u`.
    #[inline]
    pub fn slope(&self, u: f32) -> Vec4 {
        let [_, b, c, d] = self.coefficients();
        b + u * (2.0 * c + 3.0 * u * d)
    }

    /// The corners of the polygon that holds the curve (Bezier's).
    pub fn hull(&self) -> [Vec4; 4] {
        let [p, a, b, q] = self.0;
        [a, a + (b - p) / 6.0, b - (q - a) / 6.0, b]
    }
}

/// Keys between two entries of the table of strands.
const STRAND_STEP: usize = 32;

/// The last of some strands that begins at a key or before it, by the strands' first keys.
fn strand_among(first_keys: &[u32], key: u32) -> u32 {
    first_keys.partition_point(|&first| first <= key) as u32 - 1
}

impl Curves {
    /// Checks a description. The second value is a warning about strands left out.
    ///
    /// # Errors
    /// [`SceneError::BadCurves`].
    pub fn new(mut d: CurvesDescription) -> Result<(Self, Option<String>), SceneError> {
        let bad = |what: String| SceneError::BadCurves { curves: d.name.clone(), what };
        let (keys, strands) = (d.keys.len(), d.first_keys.len().saturating_sub(1));
        let rises = d.first_keys.windows(2).all(|pair| pair[0] <= pair[1]);
        if !rises || d.first_keys.first() != Some(&0) || d.first_keys.last().map(|&k| k as usize) != Some(keys) {
            return Err(bad(format!("its strands do not share out its {keys} keys")));
        }
        let fits = |len: usize, most: usize, what: &str| {
            if len == most { Ok(()) } else { Err(bad(format!("{len} values of {what}, where there should be {most}"))) }
        };
        for (name, values) in &d.uv_maps {
            fits(values.len(), strands, &format!("UV map '{name}'"))?;
        }
        for (name, values) in &d.attributes {
            match values {
                StrandValues::ByKey(values) => fits(values.len(), keys, &format!("attribute '{name}'"))?,
                StrandValues::ByStrand(values) => fits(values.len(), strands, &format!("attribute '{name}'"))?,
            }
        }
        for moved in d.moved_keys.iter().flatten() {
            fits(moved.len(), keys, "moved keys")?;
        }
        for pose in &d.poses {
            fits(pose.len(), keys, "keys over time")?;
        }
        if d.poses.len() == 1 {
            return Err(bad("one shape over time: give none, or several".into()));
        }
        let is_sound = |key: &Vec4| key.is_finite() && key.abs().max_element() <= 1e12;
        let keep: Vec<bool> = d
            .first_keys
            .windows(2)
            .map(|range| {
                let range = range[0] as usize..range[1] as usize;
                std::iter::once(&d.keys).chain(&d.poses).all(|keys| keys[range.clone()].iter().all(is_sound))
            })
            .collect();
        let dropped = keep.iter().filter(|&&kept| !kept).count();
        let warning = (dropped > 0).then(|| {
            format!(
                "curves '{}': {dropped} of {strands} strands have a key that is not finite or farther than 1e12 units; \
                 left out",
                d.name
            )
        });
        let mut numbers = StrandNumbers::From(d.first_number);
        if dropped > 0 {
            numbers = StrandNumbers::Each(
                (0u32..).zip(&keep).filter(|(_, kept)| **kept).map(|(i, _)| i.wrapping_add(d.first_number)).collect(),
            );
            d.keep_only(&keep);
        }
        for key in d.keys.iter_mut().chain(d.poses.iter_mut().flatten()) {
            key.w = key.w.max(0.0);
        }
        let CurvesDescription { keys, first_keys, shape, uv_maps, attributes, moved_keys, poses, .. } = d;
        let strand_at = (0..keys.len() as u32).step_by(STRAND_STEP).map(|key| strand_among(&first_keys, key)).collect();
        Ok((Self { keys, first_keys, strand_at, shape, numbers, uv_maps, attributes, moved_keys, poses }, warning))
    }

    /// True if the curves are ribbons.
    pub fn is_flat(&self) -> bool {
        matches!(self.shape, CurveShape::Ribbon { .. })
    }

    /// Number of strands.
    pub fn strand_count(&self) -> usize {
        self.first_keys.len() - 1
    }

    /// The keys of a strand.
    pub fn keys_of(&self, strand: u32) -> std::ops::Range<u32> {
        self.first_keys[strand as usize]..self.first_keys[strand as usize + 1]
    }

    /// Number of segments of all strands.
    pub fn segment_count(&self) -> usize {
        (0..self.strand_count() as u32).map(|strand| self.keys_of(strand).len().saturating_sub(1)).sum()
    }

    /// The strand of a segment.
    pub fn strand_of(&self, segment: u32) -> u32 {
        let at = segment as usize / STRAND_STEP;
        let low = self.strand_at[at] as usize;
        let end = self.strand_at.get(at + 1).map_or(self.first_keys.len(), |&high| high as usize + 1);
        low as u32 + strand_among(&self.first_keys[low..end], segment)
    }

    /// Place and radius of a key, as it is in a pose.
    #[inline]
    pub fn key(&self, key: u32, pose: Pose) -> Vec4 {
        let (time, key) = (pose.key as usize, key as usize);
        if self.poses.is_empty() {
            return self.keys[key];
        }
        self.poses[time][key].lerp(self.poses[time + 1][key], pose.part)
    }

    /// The control points of a segment of a strand, as they are in a pose.
    pub fn controls(&self, strand: u32, segment: u32, pose: Pose) -> Controls {
        let range = self.keys_of(strand);
        let key = |i: u32| self.key(i, pose);
        let before = if segment > range.start { segment - 1 } else { segment };
        let behind = (segment + 2).min(range.end - 1);
        if self.shape == CurveShape::ThickLinear {
            // The same line in even steps, so that it is run through evenly.
            let (a, b) = (key(segment), key(segment + 1));
            return Controls([a + a - b, a, b, b + b - a]);
        }
        Controls([key(before), key(segment), key(segment + 1), key(behind)])
    }

    /// The relative length along its strand of a place, 0 to 1, and the length of the strand; by straight lines between keys.
    pub fn intercept(&self, segment: u32, u: f32) -> (f32, f32) {
        let range = self.keys_of(self.strand_of(segment));
        let (mut before, mut length) = ([0.0; 2], 0.0);
        for i in range.start..range.end - 1 {
            if i == segment {
                before[0] = length;
            }
            length += (self.keys[i as usize + 1] - self.keys[i as usize]).truncate().length();
            if i == segment {
                before[1] = length;
            }
        }
        let [a, b] = before.map(|at| if length > 0.0 { at / length } else { 0.0 });
        (a + (b - a) * u, length)
    }

    /// The diameter at a place, even between keys, as it is in a pose.
    pub fn thickness(&self, segment: u32, u: f32, pose: Pose) -> f32 {
        let [a, b] = [0, 1].map(|next| self.key(segment + next, pose).w);
        2.0 * (a + (b - a) * u)
    }

    /// A random number of the segment's strand, 0 to 1, by the strand's number.
    pub fn random(&self, segment: u32) -> f32 {
        let strand = self.strand_of(segment);
        petzval_nodes::random_of_pair(match &self.numbers {
            StrandNumbers::From(first) => [first.wrapping_add(strand), 0],
            StrandNumbers::Each(each) => [each[strand as usize], 0],
        })
    }

    /// An attribute at a place; `None` where there is none of that name.
    pub fn attribute(&self, name: &str, segment: u32, u: f32) -> Option<Vec4> {
        let (_, values) = self.attributes.iter().find(|(own, _)| own == name)?;
        Some(match values {
            StrandValues::ByKey(values) => {
                let (a, b) = (values[segment as usize], values[segment as usize + 1]);
                a + (b - a) * u
            }
            StrandValues::ByStrand(values) => values[self.strand_of(segment) as usize],
        })
    }

    /// The UV map of that name, or the first where no name is given.
    pub fn uv_map(&self, name: Option<&str>) -> Option<usize> {
        match name {
            None => (!self.uv_maps.is_empty()).then_some(0),
            Some(name) => self.uv_maps.iter().position(|(own, _)| own == name),
        }
    }

    /// The place in a UV map of the root of a segment's strand.
    pub fn uv(&self, map: usize, segment: u32) -> Vec2 {
        self.uv_maps[map].1[self.strand_of(segment) as usize]
    }

    /// The corners of the box that holds the keys.
    pub(super) fn bounds(&self) -> [Vec3; 2] {
        let places = || self.keys.iter().map(|key| key.truncate());
        [places().fold(Vec3::MAX, Vec3::min), places().fold(Vec3::MIN, Vec3::max)]
    }
}

impl CurvesDescription {
    fn keep_only(&mut self, keep: &[bool]) {
        let by_key: Vec<bool> = self
            .first_keys
            .windows(2)
            .zip(keep)
            .flat_map(|(range, &kept)| std::iter::repeat_n(kept, (range[1] - range[0]) as usize))
            .collect();
        let mut first_keys = vec![0];
        for (range, _) in self.first_keys.windows(2).zip(keep).filter(|(_, kept)| **kept) {
            first_keys.push(first_keys[first_keys.len() - 1] + range[1] - range[0]);
        }
        self.first_keys = first_keys;
        retain(&mut self.keys, &by_key);
        self.poses.iter_mut().for_each(|pose| retain(pose, &by_key));
        self.uv_maps.iter_mut().for_each(|(_, values)| retain(values, keep));
        for (_, values) in &mut self.attributes {
            match values {
                StrandValues::ByKey(values) => retain(values, &by_key),
                StrandValues::ByStrand(values) => retain(values, keep),
            }
        }
        self.moved_keys.iter_mut().flatten().for_each(|moved| retain(moved, &by_key));
    }
}

fn retain<T: Copy>(list: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    list.retain(|_| *flags.next().expect("lengths were checked"));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_strands() -> CurvesDescription {
        let key = |x: f32, z: f32| Vec4::new(x, 0.0, z, 0.1);
        CurvesDescription {
            name: "hair".into(),
            keys: vec![key(0.0, 0.0), key(0.0, 1.0), key(0.0, 3.0), key(5.0, 0.0), key(5.0, 2.0)],
            first_keys: vec![0, 3, 5],
            shape: CurveShape::Thick,
            first_number: 7,
            uv_maps: vec![("UVMap".into(), vec![Vec2::new(0.1, 0.2), Vec2::new(0.3, 0.4)])],
            attributes: vec![("wet".into(), StrandValues::ByKey((0..5).map(|i| Vec4::splat(i as f32)).collect()))],
            moved_keys: None,
            poses: vec![],
        }
    }

    #[test]
    fn the_table_finds_the_strand_that_a_search_finds() {
        // Strands shorter and longer than a step of the table, some of them without keys.
        let lengths = [0u32, 1, 31, 0, 0, 32, 33, 2, 100, 3, 3, 0, 64, 5, 0];
        let mut first_keys = vec![0];
        first_keys.extend(lengths.iter().scan(0, |end, length| {
            *end += length;
            Some(*end)
        }));
        let total = first_keys[lengths.len()];
        let keys = (0..total).map(|i| Vec4::new(i as f32, 0.0, 0.0, 0.1)).collect();
        let description = CurvesDescription { keys, first_keys, uv_maps: vec![], attributes: vec![], ..two_strands() };
        let (curves, _) = Curves::new(description).unwrap();
        for key in 0..total {
            let strand = curves.strand_of(key);
            assert!(curves.keys_of(strand).contains(&key), "{key} {strand}");
        }
    }

    #[test]
    fn segments_know_their_strand_and_what_is_along_it() {
        let (curves, warning) = Curves::new(two_strands()).unwrap();
        assert!(warning.is_none());
        assert_eq!((curves.strand_count(), curves.segment_count()), (2, 3));
        assert_eq!([0, 1, 3].map(|segment| curves.strand_of(segment)), [0, 0, 1]);
        let (intercept, length) = curves.intercept(1, 0.5);
        assert!((intercept - 2.0 / 3.0).abs() < 1e-6 && (length - 3.0).abs() < 1e-6);
        assert!((curves.thickness(0, 0.3, Pose::default()) - 0.2).abs() < 1e-6);
        assert_eq!(curves.attribute("wet", 3, 0.5), Some(Vec4::splat(3.5)));
        assert_eq!(curves.uv(curves.uv_map(None).unwrap(), 3), Vec2::new(0.3, 0.4));
        // Through the keys, with the slope of the line between their neighbours.
        let controls = curves.controls(0, 1, Pose::default());
        assert!((controls.at(0.0) - curves.keys[1]).length() < 1e-6);
        assert!((controls.at(1.0) - curves.keys[2]).length() < 1e-6);
        assert_eq!(controls.slope(0.0).truncate(), Vec3::new(0.0, 0.0, 1.5));
    }

    #[test]
    fn strands_that_are_not_finite_are_left_out_and_the_others_keep_their_numbers() {
        let (whole, _) = Curves::new(two_strands()).unwrap();
        let mut d = two_strands();
        d.keys[1].x = f32::NAN;
        let (curves, warning) = Curves::new(d).unwrap();
        assert!(warning.unwrap().contains("curves 'hair': 1 of 2 strands"));
        assert_eq!((curves.strand_count(), curves.segment_count(), curves.keys.len()), (1, 1, 2));
        assert_eq!(curves.random(0), whole.random(3));
        assert_eq!(curves.uv(0, 0), Vec2::new(0.3, 0.4));
        assert_eq!(curves.attribute("wet", 0, 0.0), Some(Vec4::splat(3.0)));
    }

    #[test]
    fn arrays_that_do_not_fit_are_named() {
        let mut d = two_strands();
        d.uv_maps[0].1.pop();
        assert!(Curves::new(d).unwrap_err().to_string().contains("UV map 'UVMap'"));
        let mut d = two_strands();
        d.first_keys = vec![0, 4, 3, 5];
        assert!(Curves::new(d).unwrap_err().to_string().contains("share out"));
    }
}

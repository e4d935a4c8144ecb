//! Parts of a curve segment that have boxes of their own.
//!
//! A box along the axes around a strand that runs across them is mostly empty. Those of two halves have half of its surface together, those
//! of four quarters a quarter: a ray that passes the strand visits so many fewer leaves.

use super::bounds::Bounds;
use super::segment::SegmentCut;
use crate::scene::curves::Controls;
use glam::Vec4;
use std::ops::Range;

/// Number of times that a segment is halved at most.
const HALVINGS: u32 = 2;
/// A part is halved where the boxes of its halves have less than this share of its box's surface.
const WORTH_HALVING: f32 = 0.7;
/// Parts of all segments of a tree at most where segments are halved; a part takes some 60 bytes.
const MOST_PARTS: usize = 1 << 23;

/// Divides a segment of a tree with so many segments, and gives the parts, pieces each, with their boxes to `take`: boxes about all shapes
/// of the segment. Segments beyond the reach of single precision have no parts. `balls` is scratch.
pub(super) fn divide(
    cut: SegmentCut,
    shapes: &[Controls],
    segments: usize,
    balls: &mut Vec<Vec4>,
    take: &mut impl FnMut(Range<u16>, Bounds),
) {
    // Round pieces overlap, and what overlaps would be hit in both halves.
    let is_divided = matches!(cut, SegmentCut::Ribbon(_));
    let halvings = (1..=HALVINGS).rev().find(|&halvings| is_divided && segments << halvings <= MOST_PARTS).unwrap_or(0);
    let whole = 0..cut.pieces();
    let bounds = around(cut, shapes, &whole, balls);
    if bounds.is_within_reach() {
        halve(cut, shapes, (whole, bounds), halvings, balls, take);
    }
}

fn around(cut: SegmentCut, shapes: &[Controls], part: &Range<u16>, balls: &mut Vec<Vec4>) -> Bounds {
    balls.clear();
    shapes.iter().for_each(|controls| cut.add_balls(controls, part.clone(), balls));
    Bounds::around(balls)
}

fn halve(
    cut: SegmentCut,
    shapes: &[Controls],
    (part, bounds): (Range<u16>, Bounds),
    halvings: u32,
    balls: &mut Vec<Vec4>,
    take: &mut impl FnMut(Range<u16>, Bounds),
) {
    if halvings > 0 && part.len() > 1 {
        let middle = part.start + part.len() as u16 / 2;
        let halves = [part.start..middle, middle..part.end].map(|half| {
            let bounds = around(cut, shapes, &half, balls);
            (half, bounds)
        });
        if halves.iter().map(|(_, half)| half.half_area()).sum::<f32>() < WORTH_HALVING * bounds.half_area() {
            for half in halves {
                halve(cut, shapes, half, halvings - 1, balls, take);
            }
            return;
        }
    }
    take(part, bounds);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::curves::CurveShape;
    use glam::Vec3;

    const RIBBON: CurveShape = CurveShape::Ribbon { pieces: 5 };

    /// A straight segment with this chord.
    fn straight(chord: Vec3, radius: f32) -> Controls {
        Controls([-1.0, 0.0, 1.0, 2.0].map(|u| (u * chord).extend(radius)))
    }

    fn parts(shape: CurveShape, controls: &Controls, segments: usize) -> Vec<(Range<u16>, Bounds)> {
        let mut found = vec![];
        let shapes = std::slice::from_ref(controls);
        divide(SegmentCut::new(shape, shapes), shapes, segments, &mut vec![], &mut |part, bounds| {
            found.push((part, bounds))
        });
        found
    }

    #[test]
    fn parts_are_all_pieces_in_their_order() {
        for (chord, radius, number) in [(Vec3::ONE, 0.001, 4), (Vec3::X, 0.001, 1), (Vec3::ONE, 0.5, 1)] {
            let controls = straight(chord, radius);
            let found = parts(RIBBON, &controls, 100);
            assert_eq!(found.len(), number, "{chord} {radius}");
            let ends = found.iter().map(|(part, _)| part.end);
            assert!([0].into_iter().chain(ends.clone()).eq(found.iter().map(|(part, _)| part.start).chain([5])));
            for (part, bounds) in found {
                for i in 0..=10 {
                    let u = (f32::from(part.start) + 0.1 * i as f32 * part.len() as f32) / 5.0;
                    let place = bounds.middle().truncate() * 0.5 - controls.at(u).truncate();
                    let half = (bounds.high() - bounds.low()) * 0.5;
                    assert!(place.abs().cmple((half - radius + 1e-6).into()).all(), "{part:?} {u}");
                }
            }
        }
    }

    #[test]
    fn many_segments_and_round_ones_stay_whole() {
        let controls = straight(Vec3::ONE, 0.001);
        assert_eq!(parts(RIBBON, &controls, MOST_PARTS / 2).len(), 2);
        assert_eq!(parts(RIBBON, &controls, MOST_PARTS).len(), 1);
        assert_eq!(parts(CurveShape::Thick, &controls, 100).len(), 1);
        assert_eq!(parts(CurveShape::ThickLinear, &controls, 100).len(), 1);
        assert!(parts(RIBBON, &straight(Vec3::splat(1e20), 0.001), 100).is_empty());
    }
}

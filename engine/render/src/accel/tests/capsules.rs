//! Capsules around segments against the segments themselves.

use super::super::block::LANES;
use super::super::capsules::Capsules;
use super::super::segment::{RayFrame, SegmentCut, meet};
use super::*;
use crate::scene::curves::{Controls, CurveShape};
use fearless_simd::dispatch;
use glam::Vec4;

/// A segment anywhere within some units of the middle, as long as its keys are apart.
fn segment(i: u32, seed: u32) -> Controls {
    let [thick, ..] = sobol_burley::sample_4d(i, 9, seed);
    let radius = 0.002 * 10f32.powf(1.5 * thick);
    let [x, y, z, turn] = sobol_burley::sample_4d(i, 0, seed);
    let start = 4.0 * (Vec3A::new(x, y, z) - 0.5);
    let along = direction([turn, x]) * 0.3;
    Controls(std::array::from_fn(|key| {
        let bend = sobol_burley::sample_4d(i, 1 + key as u32, seed);
        let aside = 0.1 * (Vec3A::new(bend[0], bend[1], bend[2]) - 0.5);
        (start + along * key as f32 + aside).extend(radius * (0.5 + bend[3]))
    }))
}

fn capsules(of: &[Controls], shape: CurveShape) -> Capsules {
    let mut capsules = Capsules::NONE;
    for (lane, controls) in of.iter().enumerate() {
        let cut = SegmentCut::new(shape, std::slice::from_ref(controls));
        capsules.set(lane, &balls(cut, controls), 0);
    }
    capsules
}

fn balls(cut: SegmentCut, controls: &Controls) -> Vec<Vec4> {
    let mut balls = vec![];
    cut.add_balls(controls, 0..cut.pieces(), &mut balls);
    balls
}

/// True of a ray that runs along a strand where it passes: where a ribbon is seen so, its pieces end far from their chords.
fn is_along(controls: &Controls, u: f32, direction: Vec3A) -> bool {
    Vec3A::from_vec4(controls.slope(u)).normalize_or_zero().dot(direction).abs() > 0.9
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Every hit of a segment lies in its capsule, and not before the capsule's near distance; far from the origin too.
    #[test]
    fn capsules_hold_their_segments(
        seed in 0u32..60000, far in prop::sample::select(vec![0.0, 100.0, 10000.0]), count in 1usize..=LANES,
        shape in prop::sample::select(vec![CurveShape::Ribbon { pieces: 5 }, CurveShape::Thick, CurveShape::ThickLinear]),
    ) {
        let away = Vec3A::new(far, -far, 0.5 * far);
        let moved = |controls: Controls| Controls(controls.0.map(|key| key + away.extend(0.0)));
        let segments: Vec<Controls> = (0..count as u32).map(|i| moved(segment(i, seed))).collect();
        let capsules = capsules(&segments, shape);
        for i in 0..40 {
            let u = sobol_burley::sample_4d(i, 7, seed);
            let aim = segments[i as usize % count].at(u[2]);
            let [x, y, z, reach] = sobol_burley::sample_4d(i, 8, seed);
            let aside = 2.2 * aim.w * (Vec3A::new(x, y, z) - 0.5);
            let d = direction([u[0], u[1]]);
            let gaze = RayFrame::new(Vec3A::from_vec4(aim) + aside - d * 3.0 * u[3], d);
            let t_max = 6.0 * reach;
            let level = Level::new();
            let candidates = dispatch!(level, simd => capsules.meet(simd, &gaze, t_max));
            for (lane, controls) in segments.iter().enumerate() {
                let cut = SegmentCut::new(shape, std::slice::from_ref(controls));
                let both = dispatch!(level, simd => meet(simd, &gaze, controls.0, (cut, &(0..cut.pieces())), t_max));
                for met in both.into_iter().flatten() {
                    let near = candidates.as_ref().filter(|found| found.lanes >> lane & 1 != 0);
                    let near = near.map(|found| found.near[lane]);
                    prop_assert!(near.is_some_and(|near| near <= met.t), "lane {lane}: {met:?}, near {near:?}");
                }
            }
        }
    }

    /// Hits of segments that change their shape lie in the capsules on their way, at any part of it, where the second shape lies elsewhere and
    /// runs another way, by up to a right angle.
    #[test]
    fn capsules_on_their_way_hold_segments_on_theirs(
        seed in 0u32..60000, far in prop::sample::select(vec![0.0, 100.0, 10000.0]), part in 0f32..=1.0,
        shape in prop::sample::select(vec![CurveShape::Ribbon { pieces: 5 }, CurveShape::Thick, CurveShape::ThickLinear]),
    ) {
        let away = Vec3A::new(far, -far, 0.5 * far);
        let moved = |controls: Controls| Controls(controls.0.map(|key| key + away.extend(0.0)));
        // A strand that turns by more than a right angle between two times is shorter than wide in between, and its pieces' edges stick out.
        let turned = |[from, to]: [Controls; 2]| {
            let chord = |controls: &Controls| (controls.0[2] - controls.0[1]).truncate();
            let is_back = chord(&from).dot(chord(&to)) < 0.0;
            [from, if is_back { Controls([to.0[3], to.0[2], to.0[1], to.0[0]]) } else { to }]
        };
        let changes: Vec<[Controls; 2]> =
            (0..LANES as u32).map(|i| turned([i, i + 50].map(|number| moved(segment(number, seed))))).collect();
        let (mut from, mut to) = (Capsules::NONE, Capsules::NONE);
        for (lane, shapes) in changes.iter().enumerate() {
            let cut = SegmentCut::new(shape, shapes);
            let [at_first, at_last] = [0, 1].map(|end: usize| balls(cut, &shapes[end]));
            Capsules::set_both([&mut from, &mut to], lane, [&at_first, &at_last], 0);
        }
        let capsules = from.towards(&to, part);
        for i in 0..40 {
            let u = sobol_burley::sample_4d(i, 7, seed);
            let [start, end] = &changes[i as usize % LANES];
            let aimed_at = start.towards(end, part);
            let aim = aimed_at.at(u[2]);
            let [x, y, z, _] = sobol_burley::sample_4d(i, 8, seed);
            let aside = 2.2 * aim.w * (Vec3A::new(x, y, z) - 0.5);
            let d = direction([u[0], u[1]]);
            if is_along(&aimed_at, u[2], d) {
                continue;
            }
            let gaze = RayFrame::new(Vec3A::from_vec4(aim) + aside - d * 3.0 * u[3], d);
            let level = Level::new();
            let candidates = dispatch!(level, simd => capsules.meet(simd, &gaze, 6.0));
            for (lane, shapes) in changes.iter().enumerate() {
                let cut = SegmentCut::new(shape, shapes);
                let keys = shapes[0].towards(&shapes[1], part).0;
                let both = dispatch!(level, simd => meet(simd, &gaze, keys, (cut, &(0..cut.pieces())), 6.0));
                for met in both.into_iter().flatten() {
                    let near = candidates.as_ref().filter(|found| found.lanes >> lane & 1 != 0);
                    let near = near.map(|found| found.near[lane]);
                    prop_assert!(near.is_some_and(|near| near <= met.t), "lane {lane}: {met:?}, near {near:?}");
                }
            }
        }
    }
}

/// A ray through the box of a straight segment, but past it by twice its radius, does not hit its capsule; nor does one that ends
/// before it or begins behind it.
#[test]
fn capsules_are_tight() {
    let key = |i: i32| Vec3A::splat(0.3 * i as f32).extend(0.01);
    let straight = Controls([-1, 0, 1, 2].map(key));
    let capsules = capsules(&[straight], CurveShape::Ribbon { pieces: 5 });
    let across = Vec3A::new(1.0, -1.0, 0.0).normalize();
    let aside = across.cross(Vec3A::ONE.normalize());
    let lanes = |start: Vec3A, t_max: f32| {
        let gaze = RayFrame::new(start, across);
        let found = dispatch!(Level::new(), simd => capsules.meet(simd, &gaze, t_max));
        found.map_or(0, |found| found.lanes)
    };
    let middle = Vec3A::splat(0.15);
    assert_eq!(lanes(middle - across, 2.0), 1);
    assert_eq!(lanes(middle - across + 0.009 * aside, 2.0), 1);
    for side in [-1.0, 1.0] {
        assert_eq!(lanes(middle - across + 0.02 * side * aside, 2.0), 0);
    }
    assert_eq!(lanes(middle - across, 0.98), 0);
    assert_eq!(lanes(middle + 0.02 * across, 2.0), 0);
}

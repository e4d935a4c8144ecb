//! Segments of curves as the primitives of a tree.
//!
//! A leaf is up to eight segments, each with a bounding capsule and the numbers of its keys; keys are shared by neighbours. Where strands
//! change their shape while the shutter is open, a tree has the keys and the capsules at two times, and a ray is tested against what is
//! between.

use super::FROM_WITHIN;
use super::block::LANES;
use super::build::build;
use super::capsules::Capsules;
use super::divide::divide;
use super::segment::{RayFrame, SegmentCut, meet};
use super::traverse::lanes;
use super::tree::{LocalHit, Primitives, Tree, Visitor};
use crate::scene::curves::{Controls, Curves};
use crate::scene::mesh::Mesh;
use crate::scene::motion::{Pose, Poses};
use crate::scene::{Instance, Scene};
use arrayvec::ArrayVec;
use fearless_simd::Simd;
use glam::{Vec3A, Vec4};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// Leaves of up to eight segments.
#[derive(Debug, Default)]
pub(super) struct Segments {
    leaves: Vec<Capsules>,
    /// The first segment of each leaf; the others follow.
    firsts: Vec<u32>,
    /// The segments, in the order of the leaves.
    segments: Vec<Segment>,
    /// The keys of all strands; each strand's first key is repeated before it, and its last one behind it.
    keys: Vec<Vec4>,
    /// Keys and leaves at the end of the time that the tree is for; `None` where the strands keep their shape.
    to: Option<Box<Later>>,
}

/// Strands at a later time, in the order of the tree's own.
#[derive(Debug, Default)]
struct Later {
    leaves: Vec<Capsules>,
    keys: Vec<Vec4>,
}

/// A segment, or a part of one that is bounded by itself.
#[derive(Clone, Debug)]
struct Segment {
    /// The first of four in [`Segments::keys`].
    controls: u32,
    /// Index of the instance; undefined in trees of one mesh.
    instance: u32,
    strand: u32,
    /// Number of the segment in the curves.
    number: u32,
    cut: SegmentCut,
    /// The range of the segment's pieces.
    part: Range<u16>,
}

/// Factor of an instance on radii, as Cycles has it.
pub(crate) fn radius_scale(instance: &Instance) -> f32 {
    instance.to_render.matrix3.determinant().abs().cbrt()
}

/// Curves as a tree holds them.
struct Placed<'a> {
    /// Index of the instance; undefined in trees of one mesh.
    index: u32,
    /// The instance that places them in render space; `None`: in object space.
    instance: Option<&'a Instance>,
    curves: &'a Curves,
    /// The number of the shape that changes to the next; `None`: the strands as they are.
    change: Option<u32>,
}

impl<'a> Placed<'a> {
    fn in_object_space(curves: &'a Curves, change: Option<u32>) -> Self {
        Self { index: 0, instance: None, curves, change }
    }

    /// The keys of a strand, as the instance places them, at one end of a change of shape.
    fn keys(&self, strand: u32, end: f32) -> impl Iterator<Item = Vec4> + '_ {
        let larger = self.instance.map_or(1.0, radius_scale);
        self.curves.keys_of(strand).map(move |number| {
            let key = match self.change {
                Some(key) => self.curves.key(number, Pose { key, part: end }),
                None => self.curves.keys[number as usize],
            };
            match self.instance {
                Some(instance) => instance.to_render.transform_point3a(Vec3A::from_vec4(key)).extend(key.w * larger),
                None => key,
            }
        })
    }
}

impl Tree<Segments> {
    /// The tree of curves, all of which change their shape or none.
    fn of_curves(of: &[Placed<'_>]) -> Self {
        let to = of.iter().any(|placed| placed.change.is_some()).then(Box::default);
        let mut segments = Segments { to, ..Segments::default() };
        let mut boxes = Vec::new();
        // The keys of each strand, and of each segment its strand's number among them.
        let (mut strands, mut strand_of) = (Vec::new(), Vec::new());
        let mut balls = Vec::new();
        let total: usize = of.iter().map(|placed| placed.curves.keys.len()).sum();
        for placed in of {
            let &Placed { index: instance, curves, .. } = placed;
            for strand in 0..curves.strand_count() as u32 {
                let range = curves.keys_of(strand);
                if range.len() < 2 {
                    continue;
                }
                let base = segments.add_keys(placed, strand);
                strands.push(base as usize..segments.keys.len());
                for number in range.start..range.end - 1 {
                    let controls = base + number - range.start;
                    let shapes = segments.shapes(controls);
                    // Nothing is drawn between keys at one place.
                    if shapes.iter().all(|Controls(four)| four[1].truncate() == four[2].truncate()) {
                        continue;
                    }
                    let cut = SegmentCut::new(curves.shape, &shapes);
                    divide(cut, &shapes, total, &mut balls, &mut |part, bounds| {
                        boxes.push(bounds.naming([segments.segments.len() as u32, 0]));
                        segments.segments.push(Segment { controls, instance, strand, number, cut, part });
                        strand_of.push(strands.len() as u32 - 1);
                    });
                }
            }
        }
        let built = build(&mut boxes, LANES);
        segments.set_order(boxes.iter().map(|bounds| bounds.name()[0] as usize), &strands, &strand_of);
        drop(boxes);
        segments.firsts = built.leaves.iter().map(|leaf| leaf.start as u32).collect();
        let leaves = |end: usize| {
            built.leaves.par_iter().map(|leaf| segments.capsules(leaf.clone()).swap_remove(end)).collect::<Vec<_>>()
        };
        let later = segments.to.is_some().then(|| leaves(1));
        segments.leaves = leaves(0);
        if let (Some(to), Some(later)) = (&mut segments.to, later) {
            to.leaves = later;
        }
        Self { nodes: built.nodes, primitives: segments }
    }
}

impl Segments {
    /// Adds the keys of a strand; gives the number of the first of its controls.
    fn add_keys(&mut self, placed: &Placed<'_>, strand: u32) -> u32 {
        fn add(to: &mut Vec<Vec4>, own: impl Iterator<Item = Vec4>) -> usize {
            let base = to.len();
            to.push(Vec4::ZERO);
            to.extend(own);
            to[base] = to[base + 1];
            to.push(to[to.len() - 1]);
            base
        }
        if let Some(later) = &mut self.to {
            add(&mut later.keys, placed.keys(strand, 1.0));
        }
        add(&mut self.keys, placed.keys(strand, 0.0)) as u32
    }

    /// Puts segments into this order, and strands into that of their first segments: segments that one ray hits lie together in memory.
    fn set_order(&mut self, order: impl Iterator<Item = usize>, strands: &[Range<usize>], strand_of: &[u32]) {
        let mut segments = Vec::with_capacity(self.segments.len());
        let mut in_order = Vec::with_capacity(strands.len());
        let mut moved_to: Vec<Option<usize>> = vec![None; strands.len()];
        let mut count = 0;
        for old in order {
            let strand = strand_of[old] as usize;
            let from = &strands[strand];
            let to = *moved_to[strand].get_or_insert_with(|| {
                in_order.push(from.clone());
                count += from.len();
                count - from.len()
            });
            let controls = (self.segments[old].controls as usize - from.start + to) as u32;
            segments.push(Segment { controls, ..self.segments[old].clone() });
        }
        self.segments = segments;
        let ordered = |keys: &[Vec4]| in_order.iter().flat_map(|range| &keys[range.clone()]).copied().collect();
        self.keys = ordered(&self.keys);
        if let Some(later) = &mut self.to {
            later.keys = ordered(&later.keys);
        }
    }

    /// The capsules around some of the tree's segments, at each end of their change of shape.
    fn capsules(&self, of: Range<usize>) -> ArrayVec<Capsules, 2> {
        let [mut now, mut later] = [Capsules::NONE; 2];
        let mut balls = [Vec::new(), Vec::new()];
        for (lane, segment) in self.segments[of].iter().enumerate() {
            balls.iter_mut().for_each(Vec::clear);
            for (controls, balls) in self.shapes(segment.controls).iter().zip(&mut balls) {
                segment.cut.add_balls(controls, segment.part.clone(), balls);
            }
            match &balls {
                [balls, to] if to.is_empty() => now.set(lane, balls, segment.controls),
                [from, to] => Capsules::set_both([&mut now, &mut later], lane, [from, to], segment.controls),
            }
        }
        ArrayVec::from([now, later])
    }

    /// The shapes of the segment of the keys from `first` on: one, or those at both ends of a change.
    fn shapes(&self, first: u32) -> ArrayVec<Controls, 2> {
        let later = self.to.as_deref().map(|later| &later.keys);
        std::iter::once(&self.keys).chain(later).map(|keys| Controls(four(keys, first))).collect()
    }
}

/// The four keys from `first` on.
#[inline(always)]
fn four(keys: &[Vec4], first: u32) -> [Vec4; 4] {
    let first = first as usize;
    *keys[first..first + 4].first_chunk().expect("four")
}

impl Primitives for Segments {
    type Ray = RayFrame;
    type Coordinates = [f32; 2];

    #[inline(always)]
    fn ray(origin: Vec3A, direction: Vec3A) -> RayFrame {
        RayFrame::new(origin, direction)
    }

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        leaf: usize,
        part: Option<f32>,
        ray: &RayFrame,
        mut end: f32,
        visitor: &mut impl Visitor<[f32; 2]>,
    ) -> ControlFlow<(), f32> {
        let mut capsules = &self.leaves[leaf];
        let change = part.zip(self.to.as_deref());
        let now;
        if let Some((part, later)) = change {
            now = capsules.towards(&later.leaves[leaf], part);
            capsules = &now;
        }
        let Some(candidates) = capsules.meet(simd, ray, end) else { return ControlFlow::Continue(end) };
        let first = self.firsts[leaf] as usize;
        for lane in lanes(candidates.lanes) {
            let segment = &self.segments[first + lane];
            if candidates.near[lane] < end && visitor.wants(segment.instance, segment.strand) {
                // The leaf names the keys too: they are read from memory beside the segment, not after it.
                let mut controls = four(&self.keys, capsules.controls[lane]);
                if let Some((part, later)) = change {
                    let to = four(&later.keys, capsules.controls[lane]);
                    controls = Controls(controls).towards(&Controls(to), part).0;
                }
                let both = meet(simd, ray, controls, (segment.cut, &segment.part), end);
                for (way, met) in both.into_iter().enumerate() {
                    if let Some(met) = met {
                        let v = if way == 0 { met.v } else { met.v + FROM_WITHIN };
                        let (instance, number) = (segment.instance, segment.number);
                        end = visitor.meet(LocalHit { t: met.t, instance, number, coordinates: [met.u, v] }, end)?;
                    }
                }
            }
        }
        ControlFlow::Continue(end)
    }

    fn are_in(mesh: &Mesh) -> bool {
        mesh.curves.is_some()
    }

    fn in_render_space(scene: &Scene, instances: &[u32]) -> Tree<Self> {
        let curves = |&index: &u32| {
            let instance = &scene.instances[index as usize];
            let curves = scene.meshes[instance.mesh as usize].curves.as_deref()?;
            Some(Placed { index, instance: Some(instance), curves, change: None })
        };
        Tree::of_curves(&instances.iter().filter_map(curves).collect::<Vec<_>>())
    }

    fn in_object_space(mesh: &Mesh) -> Tree<Self> {
        let placed = mesh.curves.as_deref().map(|curves| Placed::in_object_space(curves, None));
        Tree::of_curves(placed.as_slice())
    }

    fn between_keys(mesh: &Mesh, _poses: &Poses, key: usize) -> Tree<Self> {
        let placed = mesh.curves.as_deref().map(|curves| Placed::in_object_space(curves, Some(key as u32)));
        Tree::of_curves(placed.as_slice())
    }
}

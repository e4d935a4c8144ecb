//! Segments of curves as the primitives of a tree.
//!
//! A leaf is up to eight segments, each with a bounding capsule and the numbers of its keys; keys are shared by neighbours.

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
use crate::scene::{Instance, Scene};
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

/// Curves of an instance in render space, or without instance in object space.
type Placed<'a> = (u32, Option<&'a Instance>, &'a Curves);

impl Tree<Segments> {
    /// The tree of curves.
    fn of_curves(of: &[Placed<'_>]) -> Self {
        let mut segments = Segments::default();
        let mut boxes = Vec::new();
        // The keys of each strand, and of each segment its strand's number among them.
        let (mut strands, mut strand_of) = (Vec::new(), Vec::new());
        let mut balls = Vec::new();
        let total: usize = of.iter().map(|(_, _, curves)| curves.keys.len()).sum();
        for &(instance, place, curves) in of {
            for strand in 0..curves.strand_count() as u32 {
                let range = curves.keys_of(strand);
                if range.len() < 2 {
                    continue;
                }
                let base = segments.add_keys(place, &curves.keys[range.start as usize..range.end as usize]);
                strands.push(base as usize..segments.keys.len());
                for number in range.start..range.end - 1 {
                    let controls = base + number - range.start;
                    let four = segments.controls(controls);
                    // Nothing is drawn between keys at one place.
                    if four[1].truncate() == four[2].truncate() {
                        continue;
                    }
                    let four = Controls(four);
                    let cut = SegmentCut::new(curves.shape, &four);
                    divide(cut, &four, total, &mut balls, &mut |part, bounds| {
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
        segments.leaves = built.leaves.into_par_iter().map(|leaf| segments.capsules(leaf)).collect();
        Self { nodes: built.nodes, primitives: segments }
    }
}

impl Segments {
    /// Adds the keys of a strand, as an instance places them; gives the number of the first of its controls.
    fn add_keys(&mut self, place: Option<&Instance>, own: &[Vec4]) -> u32 {
        let larger = place.map_or(1.0, radius_scale);
        let placed = |key: &Vec4| match place {
            Some(instance) => {
                let middle = instance.to_render.transform_point3a(Vec3A::from_vec4(*key));
                middle.extend(key.w * larger)
            }
            None => *key,
        };
        let base = self.keys.len() as u32;
        self.keys.extend(own.first().map(placed));
        self.keys.extend(own.iter().map(placed));
        self.keys.extend(own.last().map(placed));
        base
    }

    /// Puts segments into this order, and strands into that of their first segments: segments that one ray hits lie together in memory.
    fn set_order(&mut self, order: impl Iterator<Item = usize>, strands: &[Range<usize>], strand_of: &[u32]) {
        let mut segments = Vec::with_capacity(self.segments.len());
        let mut keys = Vec::with_capacity(self.keys.len());
        let mut moved_to: Vec<Option<usize>> = vec![None; strands.len()];
        for old in order {
            let strand = strand_of[old] as usize;
            let from = &strands[strand];
            let to = *moved_to[strand].get_or_insert_with(|| {
                keys.extend_from_slice(&self.keys[from.clone()]);
                keys.len() - from.len()
            });
            let controls = (self.segments[old].controls as usize - from.start + to) as u32;
            segments.push(Segment { controls, ..self.segments[old].clone() });
        }
        (self.segments, self.keys) = (segments, keys);
    }

    /// The capsules around some of the tree's segments.
    fn capsules(&self, of: Range<usize>) -> Capsules {
        let mut capsules = Capsules::NONE;
        let mut balls = Vec::new();
        for (lane, segment) in self.segments[of].iter().enumerate() {
            let controls = Controls(self.controls(segment.controls));
            segment.cut.balls(&controls, segment.part.clone(), &mut balls);
            capsules.set(lane, &balls, segment.controls);
        }
        capsules
    }

    #[inline(always)]
    fn controls(&self, first: u32) -> [Vec4; 4] {
        let first = first as usize;
        *self.keys[first..first + 4].first_chunk().expect("four")
    }
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
        _part: Option<f32>,
        ray: &RayFrame,
        mut end: f32,
        visitor: &mut impl Visitor<[f32; 2]>,
    ) -> ControlFlow<(), f32> {
        let capsules = &self.leaves[leaf];
        let Some(candidates) = capsules.meet(simd, ray, end) else { return ControlFlow::Continue(end) };
        let first = self.firsts[leaf] as usize;
        for lane in lanes(candidates.lanes) {
            let segment = &self.segments[first + lane];
            if candidates.near[lane] < end && visitor.wants(segment.instance, segment.strand) {
                // The leaf names the keys too: they are read from memory beside the segment, not after it.
                let controls = self.controls(capsules.controls[lane]);
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
        let curves = |&i: &u32| {
            let instance = &scene.instances[i as usize];
            Some((i, Some(instance), scene.meshes[instance.mesh as usize].curves.as_deref()?))
        };
        Tree::of_curves(&instances.iter().filter_map(curves).collect::<Vec<_>>())
    }

    fn in_object_space(mesh: &Mesh) -> Tree<Self> {
        Tree::of_curves(&mesh.curves.as_deref().map(|curves| (0, None, curves)).into_iter().collect::<Vec<_>>())
    }
}

//! Trees of curves, beside those of triangles: who has none pays nothing.
//!
//! A leaf is up to eight segments, each with a bounding capsule and the numbers of its keys; keys are shared by neighbours.

use super::beside::Forest;
use super::bounds::Bounds;
use super::build::build;
use super::capsules::Capsules;
use super::divide::divide;
use super::moving::MovingPlaces;
use super::node::{BoxRay, Node};
use super::places::{PlacedMesh, Within, placed};
use super::segment::{BothMet, CurveMet, RayFrame, SegmentCut, meet};
use super::source::Parts;
use super::traverse::{lanes, traverse};
use super::triangles::LANES;
use super::{FROM_WITHIN, Hit, Ray};
use crate::scene::curves::Curves;
use crate::scene::motion::Moving;
use crate::scene::{Instance, Scene};
use fearless_simd::Simd;
use glam::{Vec3A, Vec4};
use rayon::prelude::*;
use std::ops::{ControlFlow, Range};

/// All curves of a scene.
pub(super) struct CurveForest {
    /// The tree in render space of the curves that have one instance.
    common: CurveTree,
    /// The trees in object space of the other curves; by mesh.
    shared: Vec<CurveTree>,
    places: Vec<Node>,
    placed: Vec<PlacedMesh>,
    /// The instances that move.
    moving: Option<MovingPlaces>,
}

/// Segments and the nodes above them.
#[derive(Default)]
struct CurveTree {
    nodes: Vec<Node>,
    /// The leaves, each with capsules around some of the segments.
    leaves: Vec<Capsules>,
    /// The first segment of each leaf; the others follow.
    firsts: Vec<u32>,
    /// The segments, in the order of the leaves.
    segments: Vec<Segment>,
    /// The keys of all strands; each strand's first key is repeated before it, and its last one behind it.
    keys: Vec<Vec4>,
}

/// A segment, or a part of one that is bounded by itself.
#[derive(Clone)]
struct Segment {
    /// The first of four in [`CurveTree::keys`].
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

impl CurveForest {
    /// The trees of the scene's curves; `None` if it has none.
    pub(super) fn new(scene: &Scene, parts: &Parts) -> Option<Box<Self>> {
        if scene.meshes.iter().all(|mesh| mesh.curves.is_none()) {
            return None;
        }
        let curves_of = |&i: &u32| {
            let instance = &scene.instances[i as usize];
            scene.meshes[instance.mesh as usize].curves.as_deref().map(|curves| (i, Some(instance), curves))
        };
        let alone: Vec<_> = parts.alone.iter().filter_map(curves_of).collect();
        let several: Vec<u32> = parts.several.iter().copied().filter(|i| curves_of(i).is_some()).collect();
        let mut is_shared = vec![false; scene.meshes.len()];
        let moving = scene.moving.iter().map(|one| one.instance).filter(|i| curves_of(i).is_some());
        several.iter().copied().chain(moving).for_each(|i| is_shared[scene.instances[i as usize].mesh as usize] = true);
        let shared: Vec<CurveTree> = scene
            .meshes
            .par_iter()
            .zip(&is_shared)
            .map(|(mesh, &is_shared)| match mesh.curves.as_deref().filter(|_| is_shared) {
                Some(curves) => CurveTree::new(&[(0, None, curves)]),
                None => CurveTree::default(),
            })
            .collect();
        let bounds = |now: &Instance| shared[now.mesh as usize].bounds();
        let (places, placed) = placed(scene, &several, bounds);
        let moves = |one: &Moving| curves_of(&one.instance).is_some();
        let moving = MovingPlaces::new(scene, moves, bounds);
        Some(Box::new(Self { common: CurveTree::new(&alone), shared, places, placed, moving }))
    }

    pub(super) fn bounds(&self) -> Option<Bounds> {
        let places = self.places.first().map(Node::bounds);
        let moving = self.moving.as_ref().and_then(MovingPlaces::bounds);
        places.into_iter().chain(self.common.bounds()).chain(moving).reduce(|a, b| a.union(&b))
    }
}

impl Forest for CurveForest {
    #[inline(always)]
    fn closest_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        mut nearest: Option<Hit>,
        wanted: &impl Fn(u32) -> bool,
    ) -> Option<Hit> {
        let here = BoxRay::new(ray.origin, ray.direction);
        let mut t_max = nearest.map_or(ray.t_max, |hit| hit.t);
        let gaze = RayFrame::new(ray.origin, ray.direction);
        let _ = self.common.follow(
            simd,
            (&here, &gaze),
            t_max,
            #[inline(always)]
            |segment| wanted(segment.instance) && !ray.skip.is(segment.instance, segment.strand),
            #[inline(always)]
            |segment, both, mut end| {
                for (way, met) in both.into_iter().enumerate() {
                    if let Some(met) = met.filter(|met| met.t < end) {
                        (t_max, end) = (met.t, met.t);
                        nearest = Some(segment.hit(met, way, 1.0, segment.instance, ray.moment));
                    }
                }
                ControlFlow::Continue(end)
            },
        );
        if !self.places.is_empty() {
            let _ = traverse(
                simd,
                &self.places,
                &here,
                t_max,
                #[inline(always)]
                |leaf, end| {
                    t_max = self.try_placed(simd, &self.placed[leaf], ray, end, wanted, &mut nearest);
                    ControlFlow::Continue(t_max)
                },
            );
        }
        if let Some(moving) = &self.moving {
            let _ = traverse(
                simd,
                moving.nodes(ray.moment),
                &here,
                t_max,
                #[inline(always)]
                |leaf, end| {
                    let (placed, _) = moving.placed(leaf, ray.moment);
                    ControlFlow::Continue(self.try_placed(simd, &placed, ray, end, wanted, &mut nearest))
                },
            );
        }
        nearest
    }

    #[inline(always)]
    fn each_between_with<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut dyn FnMut(&Hit) -> bool,
    ) -> ControlFlow<()> {
        let mut pass = |hit: Hit| if pass(&hit) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
        let here = BoxRay::new(ray.origin, ray.direction);
        let gaze = RayFrame::new(ray.origin, ray.direction);
        self.common.follow(
            simd,
            (&here, &gaze),
            ray.t_max,
            #[inline(always)]
            |segment| wanted(segment.instance) && !ray.skip.is(segment.instance, segment.strand),
            #[inline(always)]
            |segment, both, end| {
                segment.pass_hits(both, 1.0, segment.instance, ray.moment, &mut pass)?;
                ControlFlow::Continue(end)
            },
        )?;
        if !self.places.is_empty() {
            traverse(
                simd,
                &self.places,
                &here,
                ray.t_max,
                #[inline(always)]
                |leaf, t_max| self.pass_placed(simd, &self.placed[leaf], ray, t_max, wanted, &mut pass),
            )?;
        }
        let Some(moving) = &self.moving else { return ControlFlow::Continue(()) };
        traverse(
            simd,
            moving.nodes(ray.moment),
            &here,
            ray.t_max,
            #[inline(always)]
            |leaf, t_max| self.pass_placed(simd, &moving.placed(leaf, ray.moment).0, ray, t_max, wanted, &mut pass),
        )
    }
}

impl CurveForest {
    /// The nearest curve of an instance, as [`Self::closest_with`]; gives the end of the ray from then on.
    #[inline(always)]
    fn try_placed<S: Simd>(
        &self,
        simd: S,
        placed: &PlacedMesh,
        ray: &Ray,
        mut t_max: f32,
        wanted: &impl Fn(u32) -> bool,
        nearest: &mut Option<Hit>,
    ) -> f32 {
        if wanted(placed.instance)
            && let Some((boxes, gaze, scale)) = enter(placed, ray)
        {
            let _ = self.shared[placed.mesh as usize].follow(
                simd,
                (&boxes, &gaze),
                t_max * scale,
                #[inline(always)]
                |segment| !ray.skip.is(placed.instance, segment.strand),
                #[inline(always)]
                |segment, both, mut end| {
                    for (way, met) in both.into_iter().enumerate() {
                        if let Some(met) = met.filter(|met| met.t < end) {
                            let hit = segment.hit(met, way, scale, placed.instance, ray.moment);
                            // Not so where the division rounds up.
                            t_max = t_max.min(hit.t);
                            end = met.t;
                            *nearest = Some(hit);
                        }
                    }
                    ControlFlow::Continue(end)
                },
            );
        }
        t_max
    }

    /// All curves of an instance, as [`Self::each_between_with`].
    #[inline(always)]
    fn pass_placed<S: Simd>(
        &self,
        simd: S,
        placed: &PlacedMesh,
        ray: &Ray,
        t_max: f32,
        wanted: &impl Fn(u32) -> bool,
        pass: &mut impl FnMut(Hit) -> ControlFlow<()>,
    ) -> ControlFlow<(), f32> {
        if wanted(placed.instance)
            && let Some((boxes, gaze, scale)) = enter(placed, ray)
        {
            self.shared[placed.mesh as usize].follow(
                simd,
                (&boxes, &gaze),
                t_max * scale,
                #[inline(always)]
                |segment| !ray.skip.is(placed.instance, segment.strand),
                #[inline(always)]
                |segment, both, end| {
                    segment.pass_hits(both, scale, placed.instance, ray.moment, pass)?;
                    ControlFlow::Continue(end)
                },
            )?;
        }
        ControlFlow::Continue(t_max)
    }
}

/// The ray in the object space of an instance, and how much longer distances are there.
#[inline(always)]
fn enter(placed: &PlacedMesh, ray: &Ray) -> Option<(BoxRay, RayFrame, f32)> {
    let Within { origin, direction, scale } = placed.enter(ray)?;
    Some((BoxRay::new(origin, direction), RayFrame::new(origin, direction), scale))
}

/// Factor of an instance on radii, as Cycles has it.
pub(crate) fn radius_scale(instance: &Instance) -> f32 {
    instance.to_render.matrix3.determinant().abs().cbrt()
}

impl Segment {
    /// Gives both hits of the segment to `pass`.
    #[inline(always)]
    fn pass_hits(
        &self,
        both: BothMet,
        scale: f32,
        instance: u32,
        moment: u16,
        pass: &mut impl FnMut(Hit) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        for (way, met) in both.into_iter().enumerate() {
            if let Some(met) = met {
                pass(self.hit(met, way, scale, instance, moment))?;
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn hit(&self, met: CurveMet, way: usize, scale: f32, instance: u32, moment: u16) -> Hit {
        let v = if way == 0 { met.v } else { met.v + FROM_WITHIN };
        Hit { t: met.t / scale, u: met.u, v, instance, triangle: self.number, moment }
    }
}

impl CurveTree {
    /// The tree of these curves: of instances, in render space, or in object space.
    fn new(of: &[(u32, Option<&Instance>, &Curves)]) -> Self {
        let mut tree = Self::default();
        let mut boxes = Vec::new();
        // The keys of each strand, and of each segment its strand's number among them.
        let (mut strands, mut strand_of) = (Vec::new(), Vec::new());
        let mut balls = Vec::new();
        let total: usize = of.iter().map(|(_, _, curves)| curves.keys.len()).sum();
        for &(i, instance, curves) in of {
            let larger = instance.map_or(1.0, radius_scale);
            let placed = |key: Vec4| match instance {
                Some(instance) => {
                    let place = instance.to_render.transform_point3a(Vec3A::from_vec4(key));
                    place.extend(key.w * larger)
                }
                None => key,
            };
            for strand in 0..curves.strand_count() as u32 {
                let range = curves.keys_of(strand);
                if range.len() < 2 {
                    continue;
                }
                let base = tree.keys.len() as u32;
                let own = || range.clone().map(|key| placed(curves.keys[key as usize]));
                tree.keys.extend(own().take(1));
                tree.keys.extend(own());
                tree.keys.extend(own().next_back());
                strands.push(base as usize..tree.keys.len());
                for number in range.start..range.end - 1 {
                    let controls = base + number - range.start;
                    let four = tree.controls(controls);
                    // Nothing is drawn between keys at one place.
                    if four[1].truncate() == four[2].truncate() {
                        continue;
                    }
                    let four = super::Controls(four);
                    let cut = SegmentCut::new(curves.shape, &four);
                    divide(cut, &four, total, &mut balls, &mut |part, bounds| {
                        boxes.push(bounds.naming([tree.segments.len() as u32, 0]));
                        tree.segments.push(Segment { controls, instance: i, strand, number, cut, part });
                        strand_of.push(strands.len() as u32 - 1);
                    });
                }
            }
        }
        let built = build(&mut boxes, LANES);
        tree.nodes = built.nodes;
        tree.set_order(boxes.iter().map(|bounds| bounds.name()[0] as usize), &strands, &strand_of);
        drop(boxes);
        tree.firsts = built.leaves.iter().map(|leaf| leaf.start as u32).collect();
        tree.leaves = built.leaves.into_par_iter().map(|leaf| tree.capsules(leaf)).collect();
        tree
    }

    /// Puts segments into this order, and strands into that of their first segments: what one ray hits lies together in memory.
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
            let controls = super::Controls(self.controls(segment.controls));
            segment.cut.balls(&controls, segment.part.clone(), &mut balls);
            capsules.set(lane, &balls, segment.controls);
        }
        capsules
    }

    fn bounds(&self) -> Option<Bounds> {
        self.nodes.first().map(Node::bounds)
    }

    #[inline(always)]
    fn controls(&self, first: u32) -> [Vec4; 4] {
        let first = first as usize;
        *self.keys[first..first + 4].first_chunk().expect("four")
    }

    /// Offers what a ray hits of wanted segments; `met` gives the ray's end from then on.
    #[inline(always)]
    fn follow<S: Simd>(
        &self,
        simd: S,
        (boxes, gaze): (&BoxRay, &RayFrame),
        t_max: f32,
        wanted: impl Fn(&Segment) -> bool,
        mut met: impl FnMut(&Segment, BothMet, f32) -> ControlFlow<(), f32>,
    ) -> ControlFlow<()> {
        traverse(
            simd,
            &self.nodes,
            boxes,
            t_max,
            #[inline(always)]
            |number, mut t_max| {
                let leaf = &self.leaves[number];
                if let Some(candidates) = leaf.meet(simd, gaze, t_max) {
                    let first = self.firsts[number] as usize;
                    for lane in lanes(candidates.lanes) {
                        let segment = &self.segments[first + lane];
                        if candidates.near[lane] < t_max && wanted(segment) {
                            // The leaf names the keys too: they are read from memory beside the segment, not after it.
                            let controls = self.controls(leaf.controls[lane]);
                            let both = meet(simd, gaze, controls, (segment.cut, &segment.part), t_max);
                            t_max = met(segment, both, t_max)?;
                        }
                    }
                }
                ControlFlow::Continue(t_max)
            },
        )
    }
}

//! Paths that advance together, step by step: all rays are traced, then all that hit a surface are looked at in the
//! order of their materials, then all shadow rays are traced. Each step does one kind of work on memory that stays in
//! the cache. The light of a path does not depend on which others go with it.

mod found;
mod place;
mod through;

use super::choice::{LensStrategy, MisContext};
use super::notes::{AovSink, NoAovs};
use super::{
    CAMERA_SETS, FastGi, FirstSurface, Limits, MOST_STEPS, PathResult, SETS_PER_STEP, mix, opening, transmittance,
};
use crate::Rgb;
use crate::accel::{Hit, Ray, offset_origin};
use crate::integrator::PreparedScene;
use crate::integrator::aimed::AimedLights;
use crate::integrator::subsurface::leave;
use crate::lights::Source;
use crate::nodes::{self, LaneValues, Layers, PathState, RayCone, View};
use crate::sampler::{KeptScramble, PathSampler};
use crate::scene::visibility::Rays;
use crate::shading::Past;
use crate::shading::mixture::Mixture;
use crate::shading::principled::Bsdf;
use crate::shading::{LobeDecomposition, Scattering};
use crate::surface::SurfacePoint;
use found::Found;
use glam::Vec3A;
use petzval_nodes::LANES;
use place::{ScatterPlace, Shadow};
use std::sync::Arc;
use through::{MediumEvent, MediumState, ShadowMedia, is_only_volume};

/// Memory for paths, used again and again. `VOLUMES`: media fill space; without them none of their code is in the
/// kernel.
pub struct Wavefront<N: AovSink = NoAovs, const VOLUMES: bool = false> {
    paths: Vec<Path>,
    results: Vec<PathResult>,
    notes: N,
    /// The paths that still go on, in the order of their numbers.
    live: Vec<u32>,
    hits: Vec<Option<Hit>>,
    meetings: Vec<SurfaceInteraction>,
    /// Numbers of the meetings by their materials.
    order: Vec<u32>,
    /// Number of meetings by material: all 0 between steps.
    counts: Vec<u32>,
    /// The materials that are hit in this step.
    met: Vec<u32>,
    shadows: Vec<Shadow<N::Of>>,
    /// True for the paths that go on.
    is_alive: Vec<bool>,
    /// The closures of the material that is being evaluated.
    layers: Layers,
    /// The values of the places of that material that are evaluated together.
    lanes: LaneValues,
    /// The media that each path is in; empty where there are no volumes.
    inside: Vec<MediumState>,
    /// The media of each shadow ray.
    veils: Vec<ShadowMedia>,
    /// The scramble of the random numbers that the last path took; most take theirs of the same.
    kept_scramble: KeptScramble,
    /// The lights that send rays to the lens, too.
    aimed: Option<Arc<AimedLights>>,
    /// The starts of paths on surfaces; empty where all paths begin with rays that are traced.
    starts: Vec<SurfaceStart>,
}

/// The start of a path at a point of a surface, as if a ray from outside had hit it: nothing stands before it.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceStart {
    /// The hit of the ray; `None`: it goes to the sky, past everything.
    pub hit: Option<Hit>,
    /// Width of the pixel on the surface, Blender units: bumps are asked that far apart.
    pub footprint: f32,
}

/// One path under way.
struct Path {
    ray: Ray,
    throughput: Rgb,
    chosen: MisContext,
    strategy: LensStrategy,
    way: PathState,
    /// True until something stands in the way that a transparent film is not seen through.
    is_on_film: bool,
    /// Distance since the last scattering, over surfaces passed unbent; densities by area need it.
    travelled: f32,
    /// The point where the ray was scattered.
    start: Vec3A,
    /// The instance that scattered the ray.
    from: u32,
    /// The cone about the ray; nothing where no material of the scene needs it.
    cone: RayCone,
    /// Least density of the directions that it was scattered in so far; infinite before the first.
    least_pdf: f32,
    /// The brightest channel of the throughput after the first scattering; 0 before it.
    first_throughput: f32,
    sampler: PathSampler,
}

/// A path at a surface that scatters light.
struct SurfaceInteraction {
    path: u32,
    point: SurfacePoint,
    /// Weight of the surface over the probability that it was not passed.
    kept: f32,
    view: View,
    /// Random numbers to choose a light and a place on it: of one set, so that the places on each light are stratified, too.
    u_light: [f32; 3],
    /// Probability of scattering, where paths that pass take a light sample, too, which is weighted by it; else 1.
    share: f32,
    next: Next,
}

/// The event that follows the light sample of a path at a surface.
#[derive(Clone, Copy)]
enum Next {
    /// The path is scattered.
    Scatter,
    /// The path goes through the surface, unbent.
    Pass(TransparentPassage),
    /// The path ends: it has passed as many surfaces as it may.
    End,
}

/// A path's way through a transparent surface.
#[derive(Clone, Copy)]
struct TransparentPassage {
    /// Transmittance over the probability of passing.
    weight: Rgb,
    /// Distance of the surface from the ray's origin.
    t: f32,
    /// False for the border of a volume alone, which is no surface.
    is_counted: bool,
}

/// The fewest places of one material that are evaluated together: below that, each by itself takes less time. The bits are the same.
const LEAST_LANES: usize = 3;

/// Least probability of scattering at a surface that lets a part of the light through with which the light sample does not depend on
/// whether the path passes, as in Cycles: less noise. With a smaller one a shadow ray would seldom be worth its time.
const LEAST_SHARE: f32 = 0.02;

impl Path {
    /// The past of a path in this state at a surface that it sees so.
    #[inline(always)]
    fn past(limits: &Limits, way: PathState, view: &View) -> Past {
        let pixel_width = if way.is_camera() { view.cone.at(view.distance) } else { 0.0 };
        Past { caustics: limits.caustics(way), is_blurred: way.diffuse > 0, pixel_width }
    }

    /// Goes through a surface.
    #[inline(always)]
    fn pass(&mut self, point: &SurfacePoint, TransparentPassage { weight, t, is_counted }: TransparentPassage) {
        if is_counted {
            self.way = self.way.passed();
        }
        self.throughput *= weight;
        self.travelled += t;
        let origin = offset_origin(point.position, -point.geometric_normal, point.position_error);
        self.ray = Ray { t_max: self.ray.t_max - t, ..point.leaving(origin, self.ray.direction) };
    }
}

impl Default for Wavefront {
    fn default() -> Self {
        Self::noting(NoAovs)
    }
}

impl<N: AovSink, const VOLUMES: bool> Wavefront<N, VOLUMES> {
    /// Sets of numbers used at each surface.
    const SETS: u32 = SETS_PER_STEP + if VOLUMES { 3 } else { 0 };

    /// Memory that notes more than the light as a whole, too.
    pub fn noting(notes: N) -> Self {
        Self {
            notes,
            paths: Vec::new(),
            results: Vec::new(),
            live: Vec::new(),
            hits: Vec::new(),
            meetings: Vec::new(),
            order: Vec::new(),
            counts: Vec::new(),
            met: Vec::new(),
            shadows: Vec::new(),
            is_alive: Vec::new(),
            layers: Layers::default(),
            lanes: LaneValues::default(),
            inside: Vec::new(),
            veils: Vec::new(),
            kept_scramble: KeptScramble::default(),
            aimed: None,
            starts: Vec::new(),
        }
    }

    /// The lights that send rays to the lens: paths of [`Self::start_led`] are weighted against these.
    #[must_use]
    pub fn beside(self, aimed: Option<Arc<AimedLights>>) -> Self {
        Self { aimed, ..self }
    }

    /// Forgets all paths and their results, and keeps the memory.
    pub fn clear(&mut self) {
        self.paths.clear();
        self.results.clear();
        self.notes.clear();
        self.live.clear();
        self.is_alive.clear();
        self.starts.clear();
    }

    /// Adds a path that begins with a ray from the camera; its number is the count of those before it.
    pub fn start(&mut self, ray: Ray, sampler: PathSampler) {
        self.start_by(LensStrategy::CameraAlone, ray, sampler);
    }

    /// Adds a path like [`Self::start`], whose ray has a known end. Either all paths begin so, or none.
    pub fn start_at(&mut self, start: SurfaceStart, ray: Ray, sampler: PathSampler) {
        self.starts.push(start);
        self.start(ray, sampler);
    }

    /// Adds a path like [`Self::start`], whose ray the camera leads to with this density per unit of etendue.
    pub fn start_led(&mut self, ray: Ray, density: f32, sampler: PathSampler) {
        self.start_by(LensStrategy::Camera { density }, ray, sampler);
    }

    /// Adds a path along a ray from the camera that a source has led to: it finds the light of that source alone, and is not scattered.
    pub fn start_aimed(&mut self, ray: Ray, sampler: PathSampler, source: Source) {
        self.start_by(LensStrategy::Aimed(source), ray, sampler);
    }

    fn start_by(&mut self, strategy: LensStrategy, ray: Ray, sampler: PathSampler) {
        self.live.push(self.paths.len() as u32);
        self.results.push(PathResult::default());
        self.notes.start();
        self.is_alive.push(true);
        self.paths.push(Path {
            ray,
            throughput: Rgb::ONE,
            chosen: MisContext::Alone,
            strategy,
            way: PathState::CAMERA,
            is_on_film: true,
            travelled: 0.0,
            start: ray.origin,
            from: 0,
            cone: RayCone::default(),
            least_pdf: f32::INFINITY,
            first_throughput: 0.0,
            sampler,
        });
    }

    /// The result of a path after all were followed.
    pub fn found(&self, path: usize) -> PathResult {
        self.results[path]
    }

    /// The notes on a path beside its result.
    #[inline]
    pub fn found_beside(&self, path: usize) -> &[Rgb] {
        self.notes.found(path)
    }

    /// Follows all paths to their ends.
    pub fn follow(&mut self, stage: &PreparedScene, limits: &Limits) {
        if VOLUMES {
            self.inside.clear();
            self.inside.extend(self.paths.iter().map(|path| MediumState::new(stage, path)));
        }
        if stage.needs_cones {
            for (i, path) in self.paths.iter_mut().enumerate() {
                path.cone = match self.starts.get(i) {
                    // The ray before it is none of the scene's.
                    Some(start) => RayCone { width: start.footprint, spread: 0.0 },
                    None => RayCone::camera(&stage.scene.viewport, &path.ray),
                };
            }
        }
        for step in 0..MOST_STEPS {
            if self.live.is_empty() {
                return;
            }
            if step == 0 && !self.starts.is_empty() {
                self.hits.clear();
                self.hits.extend(self.starts.iter().map(|start| start.hit));
            } else {
                self.trace(stage);
            }
            self.meet(stage, limits, step);
            self.sort(stage);
            self.scatter(stage, limits);
            self.shadow(stage, limits);
            let is_alive = &self.is_alive;
            self.live.retain(|&i| is_alive[i as usize]);
        }
    }

    /// Finds the hits of the rays.
    fn trace(&mut self, stage: &PreparedScene) {
        self.hits.clear();
        for &i in &self.live {
            let path = &self.paths[i as usize];
            self.results[i as usize].rays += 1;
            let rays = if VOLUMES { path.way.rays_with_volumes() } else { path.way.rays() };
            self.hits.push(stage.accel.closest(&path.ray, rays));
        }
    }

    /// Light that the rays found; keeps those alive that go on through a surface, and notes where others scatter.
    #[expect(clippy::too_many_lines, reason = "one loop over the rays of a wavefront: a kernel")]
    fn meet(&mut self, stage: &PreparedScene, limits: &Limits, step: u32) {
        self.meetings.clear();
        self.shadows.clear();
        if VOLUMES {
            self.veils.clear();
        }
        // Nothing lies before a surface that a path starts on.
        let starts = step == 0 && !self.starts.is_empty();
        for (&i, hit) in self.live.iter().zip(&self.hits) {
            let path = &mut self.paths[i as usize];
            let aimed = self.aimed.as_deref();
            let mut found = Found { path: i, result: &mut self.results[i as usize], notes: &mut self.notes };
            self.is_alive[i as usize] = false;
            if VOLUMES && !starts {
                path.sampler.jump_to(CAMERA_SETS + step * Self::SETS);
                let inside = &mut self.inside[i as usize];
                let shades = (&mut self.shadows, &mut self.veils);
                match inside.bring(stage, limits, aimed, path, hit.as_ref(), &mut found, shades) {
                    MediumEvent::Passed => {}
                    MediumEvent::Scattered => {
                        self.is_alive[i as usize] = true;
                        continue;
                    }
                    MediumEvent::Ended => continue,
                }
            }
            let Some(hit) = hit else {
                if !VOLUMES && !starts {
                    path.lamps_before(stage, limits, aimed, path.travelled + path.ray.t_max, &mut found);
                }
                path.sky(stage, limits, &mut found);
                continue;
            };
            path.sampler.jump_to(CAMERA_SETS + step * Self::SETS);
            let point = SurfacePoint::new(&stage.scene, hit, path.ray.direction);
            let [u0, u1, u_light, u_alpha] = path.sampler.next_4d_kept(&mut self.kept_scramble);
            let view = path.view(path.travelled + hit.t);
            let opening = opening(stage.around(), &point, &view);
            if starts {
                // What lies behind a surface is no part of it: as in Cycles, the path does not go on, and the surface has a hole.
                found.result.hit = true;
                found.result.hole += opening.light.element_sum() / 3.0;
            }
            // The film is opaque where a surface that glows alone stops a path.
            let is_film = limits.hide_sky && path.way.is_camera();
            let share = if is_film { 1.0 - opening.chance } else { opening.share };
            let is_scattered = u_alpha < share;
            // What is seen goes by the weights alone, however dark.
            let is_seen = starts || u_alpha < share.max(1.0 - opening.chance);
            let is_border = VOLUMES && share < 1.0 && is_only_volume(stage, &point);
            let is_split = share >= LEAST_SHARE && !is_border;
            if is_scattered && !VOLUMES && !starts {
                path.lamps_before(stage, limits, aimed, path.travelled + hit.t, &mut found);
            }
            found.result.hit |= is_seen;
            if !is_border && path.emission(stage, limits, aimed, (hit, &point, opening.rest), &mut found) {
                continue;
            }
            if is_seen && found.result.first.is_none() && (!VOLUMES || path.way.is_camera()) {
                found.result.first = Some(FirstSurface::from(&point));
                found.notes.finds(i, stage, &point, &view);
            }
            let next = if is_scattered {
                Next::Scatter
            } else if (is_border || limits.goes_on(path.way)) && !starts {
                Next::Pass(TransparentPassage {
                    weight: opening.light / (1.0 - share),
                    t: hit.t,
                    is_counted: !is_border,
                })
            } else {
                Next::End
            };
            // What only glows has nothing to scatter, and its normal may be noted.
            let may_scatter = stage.scene.materials[point.material as usize].scatters || found.notes.looks();
            if (is_scattered || is_split)
                && may_scatter
                && limits.scatters(path.way)
                && !path.strategy.is_aimed()
                && (!VOLUMES || self.inside[i as usize].may_scatter(limits))
            {
                let (kept, u_light) = (opening.rest / share, [u_light, u0, u1]);
                let share = if is_split { share } else { 1.0 };
                self.meetings.push(SurfaceInteraction { path: i, point, kept, view, u_light, share, next });
            } else if let Next::Pass(passage) = next {
                path.pass(&point, passage);
                if VOLUMES {
                    self.inside[i as usize].pass(&stage.scene, &point, path);
                }
                self.is_alive[i as usize] = true;
            }
        }
    }

    /// Sorts the meetings by material, the material that is hit first in front.
    fn sort(&mut self, stage: &PreparedScene) {
        self.counts.resize(stage.scene.materials.len(), 0);
        self.met.clear();
        for meeting in &self.meetings {
            let count = &mut self.counts[meeting.point.material as usize];
            if *count == 0 {
                self.met.push(meeting.point.material);
            }
            *count += 1;
        }
        // From here on, where in the order the next on this material goes.
        let mut next = 0;
        for &material in &self.met {
            next += std::mem::replace(&mut self.counts[material as usize], next);
        }
        self.order.clear();
        self.order.resize(self.meetings.len(), 0);
        for (i, meeting) in self.meetings.iter().enumerate() {
            let place = &mut self.counts[meeting.point.material as usize];
            self.order[*place as usize] = i as u32;
            *place += 1;
        }
        for &material in &self.met {
            self.counts[material as usize] = 0;
        }
    }

    /// Takes a sample of the lights at each surface, and chooses a direction to go on in.
    fn scatter(&mut self, stage: &PreparedScene, limits: &Limits) {
        if self.order.is_empty() {
            return;
        }
        let mut material = &stage.scene.materials[0];
        // What is the same for all meetings on a material, which come one after the other.
        let mut current = u32::MAX;
        let mut plain = None;
        let mut is_even = false;
        let mut mixture = Mixture::empty();
        // The meetings, by their places in the order, that the lanes hold.
        let mut in_lanes = 0..0;
        for number in 0..self.order.len() {
            let meeting = self.order[number] as usize;
            let SurfaceInteraction { path, point, kept, view, .. } = &self.meetings[meeting];
            if point.material != current {
                current = point.material;
                material = &stage.scene.materials[current as usize];
                plain = material.plain().zip(stage.plain_tables[current as usize].as_deref());
                is_even = plain.is_none() && material.graph.is_even();
                if is_even {
                    nodes::layers(material, stage.around(), point, view, &mut self.layers);
                }
            }
            let varies = !is_even && plain.is_none_or(|(plain, _)| plain.constants.is_none());
            if varies && !in_lanes.contains(&number) {
                let others = self.order[number..].iter().map(|&other| &self.meetings[other as usize]);
                let alike = others.take(LANES).take_while(|other| other.point.material == current);
                in_lanes = number..number + alike.clone().count();
                if in_lanes.len() >= LEAST_LANES {
                    let points = alike.map(|other| (&other.point, &other.view));
                    self.lanes.run(material, stage.around(), points);
                }
            }
            let lane = (varies && in_lanes.len() >= LEAST_LANES).then(|| number - in_lanes.start);
            let Path { ray, way, least_pdf, .. } = &self.paths[*path as usize];
            let (wo, past) = (-ray.direction, Path::past(limits, *way, view));
            let least_alpha = limits.approximations.least_alpha(*least_pdf);
            if let Some((plain, tables)) = plain {
                let at_point = || match lane {
                    Some(lane) => self.lanes.plain(material, plain, lane),
                    None => nodes::plain_values(material, plain, stage.around(), point, view),
                };
                let values = plain.constants.unwrap_or_else(at_point);
                let mut bsdf = Bsdf::with_caustics(tables, &values, point, wo, past.caustics);
                bsdf.scale(values.weight * kept);
                if least_alpha > 0.0 {
                    bsdf.widen(least_alpha);
                }
                self.go_on(stage, limits, meeting, None, &bsdf);
            } else {
                if let Some(lane) = lane {
                    self.lanes.layers(material, lane, &mut self.layers);
                } else if !is_even {
                    nodes::layers(material, stage.around(), point, view, &mut self.layers);
                }
                mix(&mut mixture, stage, &self.layers, point, wo, *kept, Some(past));
                if least_alpha > 0.0 {
                    mixture.widen(least_alpha);
                }
                self.go_on(stage, limits, meeting, self.layers.bent_normal, &mixture);
            }
        }
    }

    /// A light sample at a meeting, whose shading normal may be bent, and a direction; where that leads into a body, the same at the place
    /// where it comes out.
    #[inline(always)]
    #[expect(clippy::too_many_lines, reason = "a kernel, inlined")]
    fn go_on(
        &mut self,
        stage: &PreparedScene,
        limits: &Limits,
        meeting: usize,
        bent: Option<Vec3A>,
        bsdf: &(impl Scattering + LobeDecomposition),
    ) {
        let SurfaceInteraction { path: i, point, kept, view, u_light, share, next } = &self.meetings[meeting];
        let path = &mut self.paths[*i as usize];
        let mut found = Found { path: *i, result: &mut self.results[*i as usize], notes: &mut self.notes };
        let at = ScatterPlace {
            stage,
            limits,
            point,
            normal: bent.unwrap_or(point.shading_normal),
            share: *share,
            distance: view.distance,
        };
        found.notes.evaluates(*i, path.way, bsdf);
        if let Next::Scatter = next {
            found.notes.looks_at(*i, path.way, path.throughput, bsdf, view.distance);
        }
        let to = at.light(path, &mut found, &mut self.shadows, bsdf, *u_light);
        if VOLUMES {
            let scene = &stage.scene;
            self.inside[*i as usize].veil(scene, point, &self.shadows, &mut self.veils, *u_light);
        }
        match *next {
            Next::Scatter => {}
            Next::Pass(passage) => {
                path.pass(point, passage);
                if VOLUMES {
                    self.inside[*i as usize].pass(&stage.scene, point, path);
                }
                self.is_alive[*i as usize] = true;
                return;
            }
            Next::End => return,
        }
        // The first two choose the lobe and the direction in it.
        let [u2, u3, u_split, u_end] = path.sampler.next_4d_kept(&mut self.kept_scramble);
        if let Some(asked) = found.notes.occlusion(path.way) {
            at.occlusion((*i, path), asked, &mut self.shadows, bsdf, (*kept, view), [u2, u3]);
            if VOLUMES {
                let inside = &self.inside[*i as usize];
                inside.veil(&stage.scene, point, &self.shadows, &mut self.veils, [u3, u2, u_light[0]]);
            }
        }
        let is_ambient = matches!(limits.approximations.fast_gi, FastGi::Add { .. });
        if is_ambient {
            at.ambient(path, &found, &mut self.shadows, bsdf, [u2, u3]);
            if VOLUMES {
                self.inside[*i as usize].veil(
                    &stage.scene,
                    point,
                    &self.shadows,
                    &mut self.veils,
                    [u2, u3, u_light[1]],
                );
            }
        }
        let is_alive = &mut self.is_alive[*i as usize];
        let Some(entry) = bsdf.enter([u2, u3]) else {
            *is_alive = at.turn(path, &mut found, bsdf, to, [u_end, u_split, u2, u3]);
            if VOLUMES && *is_alive {
                self.inside[*i as usize].leave(&stage.scene, point, path);
            }
            return;
        };
        let mut sampler = path.sampler.aside();
        let ([u_light, u0, u1, _], [u2, u3, u_split, _]) = (sampler.next_4d(), sampler.next_4d());
        let Some((exit, light)) = leave(stage, point, &entry, &mut sampler, &mut found.result.rays) else { return };
        path.throughput *= light;
        let (at, bsdf) =
            (ScatterPlace { point: &exit, normal: exit.shading_normal, share: 1.0, ..at }, Mixture::exit(&exit));
        path.cone.spread = 0.0;
        let to = at.light(path, &mut found, &mut self.shadows, &bsdf, [u_light, u0, u1]);
        if VOLUMES {
            let inside = &self.inside[*i as usize];
            inside.veil(&stage.scene, &exit, &self.shadows, &mut self.veils, [u_light, u0, u1]);
        }
        if is_ambient {
            at.ambient(path, &found, &mut self.shadows, &bsdf, [u2, u3]);
            if VOLUMES {
                let inside = &self.inside[*i as usize];
                inside.veil(&stage.scene, &exit, &self.shadows, &mut self.veils, [u2, u3, u0]);
            }
        }
        *is_alive = at.turn(path, &mut found, &bsdf, to, [u_end, u_split, u2, u3]);
        if VOLUMES {
            let inside = &mut self.inside[*i as usize];
            if *is_alive {
                inside.leave(&stage.scene, &exit, path);
            }
        }
    }

    /// Adds the light whose way is free, as far as it is.
    fn shadow(&mut self, stage: &PreparedScene, limits: &Limits) {
        if VOLUMES {
            for (shadow, veil) in self.shadows.iter().zip(&self.veils) {
                let Shadow { path, light, way, of, .. } = shadow;
                let result = &mut self.results[*path as usize];
                let mut found = Found { path: *path, result, notes: &mut self.notes };
                found.result.rays += 1;
                let free = veil.light_through(stage, limits, shadow);
                found.add(*of, limits.clamp(*light * free, u32::from(way.depth)));
            }
            return;
        }
        for Shadow { path, ray, light, way, sets, of } in &self.shadows {
            let mut found = Found { path: *path, result: &mut self.results[*path as usize], notes: &mut self.notes };
            found.result.rays += 1;
            let mut left = limits.shadows_pass(*way);
            let cone = RayCone::pixel(&stage.scene.viewport);
            let free = stage.accel.light_through(ray, Rays::SHADOW, |hit| {
                if sets.blockers != 0 && !stage.scene.instances[hit.instance as usize].links.blocks_light_of(*sets) {
                    return Rgb::ONE;
                }
                if left == 0 {
                    return Rgb::ZERO;
                }
                left -= 1;
                transmittance(&stage.scene, hit, &View::along(ray, cone, hit.t, way.shadow()))
            });
            found.add(*of, limits.clamp(*light * free, u32::from(way.depth)));
        }
    }
}

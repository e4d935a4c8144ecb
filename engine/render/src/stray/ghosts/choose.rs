//! The choice of the ghosts that are bright enough to be seen.

use super::super::Watch;
use super::super::sources::Source;
use crate::camera::tools::straying::{Band, COLOURS, StrayLens};
use crate::luminance;
use glam::DVec2;
use petzval_optics::ghosts::beam::Beam;
use petzval_optics::ghosts::packet::{GhostTracer, Window};
use petzval_optics::ghosts::power;
use petzval_optics::trace::{ReflectedTracer, Tracer};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A ghost of a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// The number of the ghost's source.
    pub(super) source: usize,
    /// The number of the ghost's path.
    pub(super) path: usize,
    /// Luminance in the picture, evenly over its bounds.
    pub(super) value: f32,
    /// The part of the beam that gets along the path, at 550 nm.
    pub(super) window: Window,
    /// Corners of the ghost's bounds, pixels from the picture's lower left corner.
    pub(super) bounds: [DVec2; 2],
    /// Distance between the ghost's images at the ends of the spectrum, pixels.
    pub(super) spread_px: f64,
    /// Distance between the images of the source's edge and of its middle, pixels.
    pub(super) blur_px: f64,
    /// True if the ghost is so weak that it may be simulated coarsely.
    pub(super) is_coarse: bool,
}

/// The ends of the visible range, and the middle.
pub(super) const LINES_NM: [f64; 3] = [440.0, 550.0, 640.0];
/// Bounds hold a ghost's light unevenly; the brightest parts of most ghosts are no more than so many times as bright. Those of different
/// ghosts lie at different places: beyond their means, ghosts add up as squares do.
const PEAK: f32 = 4.0;
/// A ghost is simulated coarsely as long as the light that all such could add stays within so many tolerances: few colours and a coarse
/// grid leave a twentieth of its light in the wrong place: on a street at night none of the picture's error came of it, up to 16
/// tolerances.
const COARSE: f32 = 16.0;
/// Number of cells along each side of the picture in which the light that is left out is summed.
const CELLS: usize = 24;

/// All ghosts that reach the picture, of the pairs of a path and a source that are asked for by their numbers.
pub(super) fn candidates(
    lens: &StrayLens,
    paths: &[Vec<usize>],
    sources: &[Source],
    beams: &[Option<Beam>],
    is_asked: &(dyn Fn(usize, usize) -> bool + Sync),
    watch: &Watch<'_>,
) -> Option<Vec<Candidate>> {
    let looked = AtomicUsize::new(0);
    let tracer = lens.system().at_wavelength(LINES_NM[1]);
    let bands = lens.bands(COLOURS);
    let without_rims: Vec<Tracer> =
        bands.iter().map(|band| lens.system().at_wavelength(band.nm).without_rims()).collect();
    let of_path = |(number, turns): (usize, &Vec<usize>)| {
        let Some(path) = GhostTracer::new(&tracer, turns) else { return Vec::new() };
        let in_band = |(band, tracer): (&Band, &Tracer)| Some((*band, tracer.reflected(turns)?));
        let colours: Vec<(Band, ReflectedTracer)> = bands.iter().zip(&without_rims).filter_map(in_band).collect();
        let mut bundle = path.bundle();
        let mut found = Vec::new();
        for (source, beam) in beams.iter().enumerate() {
            let Some(beam) = beam.as_ref().filter(|_| is_asked(number, source)) else { continue };
            if watch.is_stopped() {
                break;
            }
            let Some(window) = path.window(beam, lens.film(), lens.pupil_part(), &mut bundle) else { continue };
            let Some((value, bounds)) = brightness(lens, &sources[source], beam, &colours, &window) else { continue };
            let (path, [spread_px, blur_px]) = (number, [0.0; 2]);
            found.push(Candidate { source, path, value, window, bounds, spread_px, blur_px, is_coarse: false });
        }
        let count = looked.fetch_add(1, Ordering::Relaxed) + 1;
        (watch.tell)(count as f64 / paths.len() as f64);
        found
    };
    let found: Vec<Vec<Candidate>> = paths.par_iter().enumerate().map(of_path).collect();
    (!watch.is_stopped()).then(|| found.concat())
}

/// Measures the separation of the images of these ghosts by wavelength and by place of the source.
pub(super) fn measure_spread(
    lens: &StrayLens,
    paths: &[Vec<usize>],
    sources: &[Source],
    beams: &[Option<Beam>],
    ghosts: &mut [Candidate],
) {
    let tracers = LINES_NM.map(|nm| lens.system().at_wavelength(nm));
    ghosts.sort_by_key(|one| (one.path, one.source));
    let mut by_path: Vec<&mut [Candidate]> = ghosts.chunk_by_mut(|a, b| a.path == b.path).collect();
    by_path.par_iter_mut().for_each(|of_path| {
        let turns = &paths[of_path[0].path];
        let paths: Vec<GhostTracer> = tracers.iter().filter_map(|tracer| GhostTracer::new(tracer, turns)).collect();
        let Ok([blue, green, red]) = <[GhostTracer; 3]>::try_from(paths) else { return };
        let mut bundles = [blue.bundle(), green.bundle(), red.bundle()];
        for one in of_path.iter_mut() {
            let known = one.window;
            let mut window = |k: usize, path: &GhostTracer, beam: &Beam| {
                path.window_near(beam, lens.film(), (&known, lens.pupil_part()), &mut bundles[k])
            };
            let apart = |a: Option<Window>, b: Option<Window>| {
                let (a, b) = (a?, b?);
                let apart = |k: usize| (lens.pixel(a.film[k]) - lens.pixel(b.film[k])).abs().max_element();
                Some(apart(0).max(apart(1)))
            };
            let Some(beam) = &beams[one.source] else { continue };
            one.spread_px = apart(window(0, &blue, beam), window(2, &red, beam)).unwrap_or(0.0);
            let (radius, place) = (f64::from(sources[one.source].radius_rad), sources[one.source].place);
            let edge = if radius > 0.0 { Beam::new(lens.system(), place.moved([radius, 0.0])) } else { None };
            one.blur_px = edge.and_then(|edge| apart(window(1, &green, &edge), Some(known))).unwrap_or(0.0);
        }
    });
    // An order that does not depend on brightness.
    ghosts.sort_by_key(|one| (one.source, one.path));
}

/// Luminance of a ghost in the picture, evenly over its bounds, and these in pixels; `None` where it lies outside.
fn brightness(
    lens: &StrayLens,
    source: &Source,
    beam: &Beam,
    colours: &[(Band, ReflectedTracer)],
    window: &Window,
) -> Option<(f32, [DVec2; 2])> {
    let [a, b] = window.film.map(|corner| lens.pixel(corner));
    let (low, high) = (a.min(b), a.max(b));
    if !(high.cmpge(DVec2::ZERO).all() && low.cmple(lens.size_px()).all()) {
        return None;
    }
    let size = (high - low).max(DVec2::ONE);
    let middle = 0.5 * (window.low + window.high);
    // Coatings reflect least in the middle of the spectrum.
    let seen = |(band, path): &(Band, ReflectedTracer)| {
        let left = power::along(lens.system(), path, beam.ray(middle)).map_or(0.0, |found| found.1);
        luminance(band.response * source.irradiance).max(0.0) * left as f32
    };
    let light = window.open_mm2 * lens.gain() * lens.px2_per_mm2();
    let value = colours.iter().map(seen).sum::<f32>() * (light / size.element_product()) as f32;
    (value > 0.0 && value.is_finite()).then_some((value, [low, high]))
}

/// Light of ghosts that lie over each other, by cell of the picture.
struct Overlaps {
    /// Sums of the ghosts' values, and of the squares of these.
    sums: Vec<[f32; 2]>,
}

impl Overlaps {
    fn new() -> Self {
        Self { sums: vec![[0.0; 2]; CELLS * CELLS] }
    }

    /// Bound of the light at a cell that has these sums.
    fn bound([sum, squares]: [f32; 2]) -> f32 {
        sum + (PEAK - 1.0) * squares.sqrt()
    }

    /// Adds so many ghosts alike to the cells where they lie, if the light there stays within `most`; true if they were added.
    fn add(&mut self, cells: &[usize], value: f32, count: f32, most: f32) -> bool {
        let with = |[sum, squares]: [f32; 2]| [sum + count * value, squares + count * value * value];
        let fits = cells.iter().all(|cell| Self::bound(with(self.sums[*cell])) <= most);
        if fits {
            cells.iter().for_each(|cell| self.sums[*cell] = with(self.sums[*cell]));
        }
        fits
    }

    /// Bound of the light anywhere.
    fn most(&self) -> f32 {
        self.sums.iter().map(|sums| Self::bound(*sums)).fold(0.0, f32::max)
    }
}

/// The ghosts that are simulated, and the most that the others could add to a pixel: the weakest go as long as the light that all of them
/// could add stays within the tolerance, wherever they lie over each other. Each stands for `count` ghosts.
pub(super) fn keep(mut found: Vec<Candidate>, count: f32, size_px: DVec2, tolerance: f32) -> (Vec<Candidate>, f32) {
    found.sort_by(|a, b| a.value.total_cmp(&b.value));
    let (mut left_out, mut coarse) = (Overlaps::new(), Overlaps::new());
    let mut kept = Vec::new();
    for mut one in found {
        let cells = |axis: usize| {
            let cell = |at: f64| ((at / size_px[axis] * CELLS as f64).max(0.0) as usize).min(CELLS - 1);
            cell(one.bounds[0][axis])..=cell(one.bounds[1][axis])
        };
        let places: Vec<usize> = cells(1).flat_map(|y| cells(0).map(move |x| y * CELLS + x)).collect();
        if left_out.add(&places, one.value, count, tolerance) {
            continue;
        }
        one.is_coarse = coarse.add(&places, one.value, count, COARSE * tolerance);
        kept.push(one);
    }
    (kept, left_out.most())
}

//! The choice of the ghosts that are bright enough to be seen.

use super::super::Watch;
use super::super::sources::Source;
use crate::camera::tools::straying::StrayLens;
use crate::luminance;
use glam::DVec2;
use petzval_optics::ghosts::beam::Beam;
use petzval_optics::ghosts::packet::{GhostTracer, Window};
use petzval_optics::ghosts::power;
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
    /// Corners of the ghost's bounds, pixels from the picture's lower left corner.
    pub(super) bounds: [DVec2; 2],
    /// Distance between the ghost's images at the ends of the spectrum, pixels.
    pub(super) spread_px: f64,
    /// Distance between the images of the source's edge and of its middle, pixels.
    pub(super) blur_px: f64,
    /// True if the ghost is so weak that it may be simulated coarsely.
    pub(super) is_coarse: bool,
}

/// The ends of what is seen, and the middle.
pub(super) const LINES_NM: [f64; 3] = [440.0, 550.0, 640.0];
/// Bounds hold a ghost's light unevenly; the brightest parts of most ghosts are no more than so many times as bright.
const PEAK: f32 = 4.0;
/// A ghost is simulated coarsely as long as what all such could add stays within so many tolerances: few colours and a coarse grid leave a
/// quarter of its light in the wrong place at most.
const COARSE: f32 = 4.0;
/// Number of cells along each side of the picture in which the light that is left out is summed.
const CELLS: usize = 24;

/// All ghosts of all sources that reach the picture.
pub(super) fn candidates(
    lens: &StrayLens,
    paths: &[Vec<usize>],
    sources: &[Source],
    beams: &[Option<Beam>],
    watch: &Watch<'_>,
) -> Option<Vec<Candidate>> {
    let looked = AtomicUsize::new(0);
    let tracers = LINES_NM.map(|nm| lens.system().at_wavelength(nm));
    let of_path = |(number, turns): (usize, &Vec<usize>)| {
        let paths: Vec<GhostTracer> = tracers.iter().filter_map(|tracer| GhostTracer::new(tracer, turns)).collect();
        let Ok([blue, green, red]) = <[GhostTracer; 3]>::try_from(paths) else { return Vec::new() };
        let mut bundles = [blue.bundle(), green.bundle(), red.bundle()];
        let mut found = Vec::new();
        for (source, beam) in beams.iter().enumerate() {
            let Some(beam) = beam else { continue };
            if watch.is_stopped() {
                break;
            }
            let mut window = |k: usize, path: &GhostTracer, beam: &Beam| {
                path.window(beam, lens.film(), lens.pupil_part(), &mut bundles[k])
            };
            let Some(middle) = window(1, &green, beam) else { continue };
            let Some((value, bounds)) = brightness(lens, &sources[source], beam, &green, &middle) else { continue };
            let apart = |a: &Option<Window>, b: &Option<Window>| match (a, b) {
                (Some(a), Some(b)) => {
                    let apart = |k: usize| (lens.pixel(a.film[k]) - lens.pixel(b.film[k])).abs().max_element();
                    apart(0).max(apart(1))
                }
                _ => 0.0,
            };
            let spread_px = apart(&window(0, &blue, beam), &window(2, &red, beam));
            let radius = f64::from(sources[source].radius_rad);
            let edge = (radius > 0.0).then(|| Beam::new(lens.system(), sources[source].place.moved([radius, 0.0])));
            let blur_px = edge.flatten().map_or(0.0, |edge| apart(&window(1, &green, &edge), &Some(middle)));
            found.push(Candidate { source, path: number, value, bounds, spread_px, blur_px, is_coarse: false });
        }
        let count = looked.fetch_add(1, Ordering::Relaxed) + 1;
        (watch.tell)(count as f64 / paths.len() as f64);
        found
    };
    let found: Vec<Vec<Candidate>> = paths.par_iter().enumerate().map(of_path).collect();
    (!watch.is_stopped()).then(|| found.concat())
}

/// Luminance of a ghost in the picture, evenly over its bounds, and these in pixels; `None` where it lies outside.
fn brightness(
    lens: &StrayLens,
    source: &Source,
    beam: &Beam,
    path: &GhostTracer,
    window: &Window,
) -> Option<(f32, [DVec2; 2])> {
    let [a, b] = window.film.map(|corner| lens.pixel(corner));
    let (low, high) = (a.min(b), a.max(b));
    if !(high.cmpge(DVec2::ZERO).all() && low.cmple(lens.size_px()).all()) {
        return None;
    }
    let size = (high - low).max(DVec2::ONE);
    let middle = 0.5 * (window.low + window.high);
    let open = path.open_path();
    let left = power::along(lens.system(), open, beam.ray(middle)).map_or(0.0, |found| found.1);
    let light = window.open_mm2 * left * lens.gain() * lens.px2_per_mm2();
    let value = luminance(source.irradiance) * (light / size.element_product()) as f32;
    (value > 0.0 && value.is_finite()).then_some((value, [low, high]))
}

/// The ghosts that are simulated, and the most that the others could add to a pixel: the weakest go as long as what all of them could add
/// stays within the tolerance, wherever they lie over each other.
pub(super) fn keep(mut found: Vec<Candidate>, size_px: DVec2, tolerance: f32) -> (Vec<Candidate>, f32) {
    found.sort_by(|a, b| a.value.total_cmp(&b.value));
    let [mut left_out, mut coarse] = [[[0.0f32; CELLS]; CELLS]; 2];
    let mut kept = Vec::new();
    for mut one in found {
        let cells = |axis: usize| {
            let cell = |at: f64| ((at / size_px[axis] * CELLS as f64).max(0.0) as usize).min(CELLS - 1);
            cell(one.bounds[0][axis])..=cell(one.bounds[1][axis])
        };
        let places = || cells(1).flat_map(|y| cells(0).map(move |x| (x, y)));
        let light = PEAK * one.value;
        let fits = |sums: &[[f32; CELLS]; CELLS], most: f32| {
            places().map(|(x, y)| sums[y][x]).fold(0.0, f32::max) + light <= most
        };
        if fits(&left_out, tolerance) {
            places().for_each(|(x, y)| left_out[y][x] += light);
            continue;
        }
        one.is_coarse = fits(&coarse, COARSE * tolerance);
        if one.is_coarse {
            places().for_each(|(x, y)| coarse[y][x] += light);
        }
        kept.push(one);
    }
    // An order that does not depend on brightness.
    kept.sort_by_key(|one| (one.source, one.path));
    (kept, left_out.as_flattened().iter().copied().fold(0.0, f32::max))
}

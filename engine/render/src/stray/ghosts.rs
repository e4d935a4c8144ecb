//! The picture of all ghosts of some sources.
//!
//! The place and brightness of the ghost are found first, for every source and every path with reflections; the weakest are left out, as
//! many as together stay below a bound. The others are traced as grids ([`petzval_optics::ghosts::packet`]) in as many wavelengths as their
//! colours lie apart, and their pieces laid on the picture.

mod choose;
mod forecast;
mod raster;

use super::sources::Source;
use super::{Picture, Reflections, Watch};
use crate::camera::tools::straying::StrayLens;
use choose::{Candidate, LINES_NM, candidates, keep, measure_spread};
pub use forecast::expected_seconds;
use petzval_optics::ghosts::beam::Beam;
use petzval_optics::ghosts::packet::{GhostTracer, Grid};
use raster::{Triangle, lay};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::HashMap;

/// A cell of a grid is about so many pixels wide, if it needs no more of them than [`MOST_CELLS`].
const CELL_PX: f64 = 24.0;
const LEAST_CELLS: usize = 12;
const MOST_CELLS: usize = 48;
/// The width of a cell, pixels, for ghosts that are simulated coarsely.
const COARSE_PX: f64 = 48.0;
const LEAST_COARSE_CELLS: usize = 8;
/// Margin about the window at 550 nm, parts of its width, within which a ghost is traced coarsely at other wavelengths.
const COARSE_MARGIN: f64 = 0.1;
/// Images of a ghost in two neighbouring bands of the spectrum lie at most so far apart, if it needs no more than [`MOST_BANDS`].
const BAND_PX: f64 = 2.0;
const LEAST_BANDS: usize = 6;
const MOST_BANDS: usize = 24;
const COARSE_BAND_PX: f64 = 4.0;
const LEAST_COARSE_BANDS: usize = 3;
const MOST_COARSE_BANDS: usize = 8;
/// Ghosts of a source that blurs them less are those of its middle.
const BLUR_PX: f64 = 1.5;
/// The part of the progress in which ghosts are looked for.
const LOOKING: f64 = 0.3;
/// Number of ghosts that are traced before their pieces are laid: memory.
const AT_ONCE: usize = 16;

/// A report on the simulation of ghosts.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GhostReport {
    /// Number of sources that were looked at.
    pub sources: usize,
    /// Ghosts of all sources that reach the film.
    pub found: usize,
    /// Ghosts that were simulated.
    pub simulated: usize,
    /// Bound of the light that the others could add to a pixel, in the picture's units: nearly everywhere, for places where several are
    /// brightest at once may have more.
    pub left_out: f32,
    /// The largest such bound that may be left out.
    pub tolerance: f32,
}

/// The light of all ghosts of so many reflections, as it is added to the picture. The ghosts left out stay below `tolerance`, in the
/// picture's units. `None` where `watch` stopped it.
pub fn ghosts(
    lens: &StrayLens,
    sources: &[Source],
    reflections: Reflections,
    tolerance: f32,
    watch: &Watch<'_>,
) -> Option<(Picture, GhostReport)> {
    let size = lens.size_px();
    let mut picture = Picture { width: size.x as u32, height: size.y as u32, light: Vec::new() };
    picture.light.resize(picture.width as usize * picture.height as usize, crate::Rgb::ZERO);
    let beams: Vec<Option<Beam>> = sources.iter().map(|one| Beam::new(lens.system(), one.place)).collect();
    let turns = turns(lens, reflections);
    let tell = |part: f64| (watch.tell)(LOOKING * part);
    let found = candidates(lens, &turns, sources, &beams, &|_, _| true, &Watch { tell: &tell, ..*watch })?;
    let mut report = GhostReport { sources: sources.len(), found: found.len(), tolerance, ..GhostReport::default() };
    let (mut kept, left_out) = keep(found, 1.0, size, tolerance);
    measure_spread(lens, &turns, sources, &beams, &mut kept);
    (report.simulated, report.left_out) = (kept.len(), left_out);
    let paths = Paths::new(lens, &turns, &kept);
    let all: f64 = kept.iter().map(work).sum();
    let mut done = 0.0;
    for some in kept.chunks(AT_ONCE) {
        if watch.is_stopped() {
            return None;
        }
        (watch.tell)(LOOKING + (1.0 - LOOKING) * done / all);
        done += some.iter().map(work).sum::<f64>();
        let triangles = |one: &Candidate| triangles(lens, &sources[one.source], one, &paths);
        let found: Vec<Vec<Triangle>> = some.par_iter().map(triangles).collect();
        lay(&found, &mut picture);
    }
    Some((picture, report))
}

/// The surfaces at which light turns, of all paths.
fn turns(lens: &StrayLens, reflections: Reflections) -> Vec<Vec<usize>> {
    reflections.counts().iter().flat_map(|count| lens.system().reflecting_paths(LINES_NM[1], *count)).collect()
}

/// The paths in the bands that they are asked for.
struct Paths {
    /// Tracers by number of bands and path.
    tracers: HashMap<(usize, usize), Vec<GhostTracer>>,
}

impl Paths {
    fn new(lens: &StrayLens, turns: &[Vec<usize>], kept: &[Candidate]) -> Self {
        let asked = Self::asked(kept);
        let traced = |&(count, number): &(usize, usize)| {
            let bands = lens.bands(count);
            let path = |nm| GhostTracer::new(&lens.system().at_wavelength(nm), &turns[number]);
            ((count, number), bands.iter().filter_map(|band| path(band.nm)).collect())
        };
        Self { tracers: asked.par_iter().map(traced).collect() }
    }

    /// The numbers of bands and paths that these ghosts need, each pair once.
    fn asked(kept: &[Candidate]) -> Vec<(usize, usize)> {
        let mut asked: Vec<(usize, usize)> = kept.iter().map(|one| (bands(one), one.path)).collect();
        asked.sort_unstable();
        asked.dedup();
        asked
    }
}

/// Number of cells along each side of a ghost's grid.
fn side(one: &Candidate) -> usize {
    let (cell_px, least) = if one.is_coarse { (COARSE_PX, LEAST_COARSE_CELLS) } else { (CELL_PX, LEAST_CELLS) };
    (((one.bounds[1] - one.bounds[0]).max_element() / cell_px) as usize).clamp(least, MOST_CELLS)
}

/// Number of rays of a ghost, about: the measure of its cost.
fn work(one: &Candidate) -> f64 {
    bands(one) as f64 * (side(one) as f64).powi(2)
}

/// Number of bands into which a ghost is divided.
fn bands(one: &Candidate) -> usize {
    // Each band comes from another place of the source.
    let for_blur = if one.blur_px > BLUR_PX { 2.0 * one.blur_px } else { 0.0 };
    let (band_px, least, most) = match one.is_coarse {
        true => (COARSE_BAND_PX, LEAST_COARSE_BANDS, MOST_COARSE_BANDS),
        false => (BAND_PX, LEAST_BANDS, MOST_BANDS),
    };
    ((one.spread_px / band_px).max(for_blur).ceil() as usize).clamp(least, most)
}

/// A place in a disc of this radius for each of so many bands: neighbours in the spectrum lie far apart, and all lie evenly.
fn within(band: usize, count: usize, radius: f64) -> [f64; 2] {
    // Vogel's spiral, in an order that leaps: 7 shares no factor with the usual counts.
    let place = (band * 7) % count;
    let place = if count.is_multiple_of(7) { band } else { place };
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let ((sin, cos), r) = ((place as f64 * golden).sin_cos(), radius * ((place as f64 + 0.5) / count as f64).sqrt());
    [r * cos, r * sin]
}

/// A ghost's pieces in pixels and colours.
fn triangles(lens: &StrayLens, source: &Source, one: &Candidate, paths: &Paths) -> Vec<Triangle> {
    let mut found = Vec::new();
    let count = bands(one);
    let side = side(one);
    let picture = [glam::DVec2::ZERO, lens.size_px()];
    for (i, (tracer, band)) in paths.tracers[&(count, one.path)].iter().zip(lens.bands(count)).enumerate() {
        let mut bundle = tracer.bundle();
        let place = match one.blur_px > BLUR_PX {
            true => source.place.moved(within(i, count, f64::from(source.radius_rad))),
            false => source.place,
        };
        let Some(beam) = &Beam::new(lens.system(), place) else { continue };
        let known = (&one.window, lens.pupil_part());
        let window = match one.is_coarse {
            true => Some(one.window.widened(COARSE_MARGIN)),
            false => tracer.window_near(beam, lens.film(), known, &mut bundle),
        };
        let Some(window) = window else { continue };
        // For light of one square millimetre: what it is where it lies on one square pixel.
        let colour = band.response * source.irradiance * (lens.gain() * lens.px2_per_mm2()) as f32;
        tracer.pieces(
            lens.system(),
            (beam, lens.film()),
            Grid { window: &window, side, is_coarse: one.is_coarse },
            &mut bundle,
            &mut |piece| {
                let corners = piece.corners.map(|corner| lens.pixel(corner));
                let low = corners[0].min(corners[1]).min(corners[2]);
                let high = corners[0].max(corners[1]).max(corners[2]);
                if high.cmpge(picture[0]).all() && low.cmple(picture[1]).all() {
                    let light = colour * piece.light_mm2 as f32;
                    found.push(Triangle { corners: corners.map(|corner| corner.as_vec2()), light });
                }
            },
        );
    }
    found
}

/// The results of a look at some of the sources.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Glimpse {
    /// The value that the brightest ghost has in the picture, luminance; 0 where none reaches the film.
    pub brightest: f32,
    /// Number of sources that were looked at.
    pub sources: usize,
    /// Paths of each that were tried.
    pub paths: usize,
    /// Ghosts that a picture with this tolerance, in its units, would have of these sources.
    pub simulated: usize,
}

/// The ghosts of some sources as they would be, without making their picture. Those of two reflections are looked at: the brightest
/// is one of them.
pub fn glimpse(lens: &StrayLens, sources: &[Source], reflections: Reflections, tolerance: f32) -> Glimpse {
    let beams: Vec<Option<Beam>> = sources.iter().map(|one| Beam::new(lens.system(), one.place)).collect();
    let two = turns(lens, Reflections::Two);
    let found = candidates(lens, &two, sources, &beams, &|_, _| true, &Watch::NONE).unwrap_or_default();
    let brightest = found.iter().map(|one| one.value).fold(0.0, f32::max);
    let (kept, _) = keep(found, 1.0, lens.size_px(), tolerance);
    let paths = turns(lens, reflections).len();
    Glimpse { brightest, sources: sources.len(), paths, simulated: kept.len() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use crate::luminance;
    use glam::{DVec2, DVec3};
    use petzval_optics::ghosts::ranking::ranked;
    use petzval_optics::system::FocalLength;

    /// The picture of a far source has the light that the ghosts have one by one.
    #[test]
    fn the_picture_has_the_light_of_all_ghosts() {
        let lens_path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses/double-gauss-f2-tronnier.lens").into();
        let d = CameraDescription { lens_path, wavelength_nm: Some(550.0), ..CameraDescription::default() }.with(|c| {
            c.lens.focal_length = FocalLength::Millimetres(50.0);
            c.lens.f_number = Some(4.0);
        });
        let lens = StrayLens::new(&d, 360, 240).unwrap();
        let angle = 8f64.to_radians();
        let towards = DVec3::new(0.0, angle.sin(), -angle.cos());
        let place = lens.source(towards, f64::INFINITY);
        let source = Source { place, irradiance: crate::Rgb::ONE, radius_rad: 0.0, towards, pixel: None };
        let (picture, report) = ghosts(&lens, &[source], Reflections::Two, 1e-9, &Watch::NONE).unwrap();
        let found: f64 = picture.light.iter().map(|l| f64::from(luminance(*l))).sum();
        let system = lens.system();
        let beam = Beam::new(system, place).unwrap();
        let is_film = |at: DVec2| at.x.abs() < 18.0 && at.y.abs() < 12.0;
        let all =
            ranked(system, &system.at_wavelength(550.0), &beam, (lens.film(), is_film), 2, lens.pupil_part(), 1e-3);
        let expected = all.iter().map(|one| one.on_film_mm2).sum::<f64>() * lens.gain() * lens.px2_per_mm2();
        // Pixels' centres stand for pixels.
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected} {report:?}");
    }
}

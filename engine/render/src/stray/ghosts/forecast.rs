//! The forecast of the time that ghosts take.

use super::super::sources::Source;
use super::super::{Picture, Reflections, Watch};
use super::choose::{Candidate, candidates, keep, measure_spread};
use super::raster::{Triangle, lay};
use super::{AT_ONCE, Paths, triangles, turns, work};
use crate::camera::tools::straying::StrayLens;
use petzval_optics::ghosts::beam::Beam;
use rayon::prelude::*;
use std::time::Instant;

/// Most pairs of a source and a path that are looked at.
const MOST_LOOKS: usize = 640;
/// Most ghosts that are traced.
const MOST_GHOSTS: usize = 3 * AT_ONCE;

/// The ghosts of some of all pairs of a source and a path.
struct Look {
    paths: Vec<Vec<usize>>,
    /// The ghosts that would be simulated.
    kept: Vec<Candidate>,
    /// Part of the paths that were looked at, and of the pairs.
    path_part: f64,
    part: f64,
    /// Wall time of a look at that part of all pairs, s.
    seconds: f64,
}

impl Look {
    /// `None` where there is nothing to look at.
    fn new(
        lens: &StrayLens,
        all: &[Vec<usize>],
        sources: &[Source],
        beams: &[Option<Beam>],
        tolerance: f32,
    ) -> Option<Self> {
        // Of every so many paths one, with every so many sources, in turns. Neighbours in the list of paths turn at the same surface: steps
        // over them meet every surface.
        let pairs = (all.len() * sources.len()) as f64;
        let step = ((pairs / MOST_LOOKS as f64).sqrt().round() as usize).clamp(1, all.len().max(1));
        let paths: Vec<Vec<usize>> = all.iter().skip(step / 2).step_by(step).cloned().collect();
        let is_asked = |path: usize, source: usize| (path + source).is_multiple_of(step);
        let looks = (0..paths.len()).map(|path| (0..sources.len()).filter(|&source| is_asked(path, source)).count());
        let (path_part, part) = (paths.len() as f64 / all.len() as f64, looks.sum::<usize>() as f64 / pairs);
        if part.is_nan() || part == 0.0 {
            return None;
        }
        let look = |is_asked: &(dyn Fn(usize, usize) -> bool + Sync)| {
            let start = Instant::now();
            let found = candidates(lens, &paths, sources, beams, is_asked, &Watch::NONE).unwrap_or_default();
            (start.elapsed().as_secs_f64(), found)
        };
        // Paths are prepared once for all sources.
        let (paths_s, _) = look(&|_, _| false);
        let (both_s, found) = look(&is_asked);
        let seconds = (both_s - paths_s).max(0.0) + paths_s * part / path_part;
        let (kept, _) = keep(found, part.recip() as f32, lens.size_px(), tolerance);
        Some(Self { paths, kept, path_part, part, seconds })
    }
}

/// Wall time that [`super::ghosts`] will take with the same arguments, s: some paths of some sources are looked at, and some of their ghosts
/// traced.
pub fn expected_seconds(lens: &StrayLens, sources: &[Source], reflections: Reflections, tolerance: f32) -> f64 {
    let beams: Vec<Option<Beam>> = sources.iter().map(|one| Beam::new(lens.system(), one.place)).collect();
    let Some(look) = Look::new(lens, &turns(lens, reflections), sources, &beams, tolerance) else { return 0.0 };
    let Look { paths: some, mut kept, path_part, part, seconds: looking_s } = look;
    let start = Instant::now();
    measure_spread(lens, &some, sources, &beams, &mut kept);
    let measuring_s = start.elapsed().as_secs_f64();
    let traced: Vec<Candidate> = kept.iter().step_by(kept.len().div_ceil(MOST_GHOSTS).max(1)).copied().collect();
    let start = Instant::now();
    let paths = Paths::new(lens, &some, &traced);
    let asked = Paths::asked(&kept).len() as f64 / paths.tracers.len().max(1) as f64;
    let preparing_s = start.elapsed().as_secs_f64() * asked * part / path_part;
    let size = lens.size_px();
    let mut picture = Picture { width: size.x as u32, height: size.y as u32, light: Vec::new() };
    picture.light.resize(picture.width as usize * picture.height as usize, crate::Rgb::ZERO);
    let start = Instant::now();
    for some in traced.chunks(AT_ONCE) {
        let found: Vec<Vec<Triangle>> =
            some.par_iter().map(|one| triangles(lens, &sources[one.source], one, &paths)).collect();
        lay(&found, &mut picture);
    }
    let sum = |ghosts: &[Candidate]| ghosts.iter().map(work).sum::<f64>();
    let tracing_s = start.elapsed().as_secs_f64() * sum(&kept) / sum(&traced).max(1.0);
    (looking_s + measuring_s + preparing_s + tracing_s) / part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::CameraDescription;
    use glam::DVec3;

    /// Lamps of different brightness all over a field: the part that is looked at has as many ghosts to simulate, and as much work, as its
    /// part of all; by a count, for times differ from run to run. Two hundred of some thousand ghosts are looked at: a tenth is the
    /// spread of such a count, of their work it is more.
    #[test]
    fn the_look_at_some_ghosts_tells_of_all() {
        let lens_path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses/nikkor-z-50-f1.8.lens").into();
        let d = CameraDescription { lens_path, ..CameraDescription::default() }.with(|c| {
            c.lens.f_number = Some(8.0);
        });
        let lens = StrayLens::new(&d, 320, 180).unwrap();
        let lamp = |i: usize| {
            let (across, up) = (0.3 * ((i as f64 * 0.618) % 1.0 - 0.5), 0.2 * ((i as f64 * 0.414) % 1.0 - 0.5));
            let towards = DVec3::new(across, up, -1.0).normalize();
            let irradiance = crate::Rgb::splat(10f32.powf(-2.0 * ((i as f32 * 0.732) % 1.0)));
            let place = lens.source(towards, 1e4);
            Source { place, irradiance, radius_rad: 0.001, towards, pixel: None }
        };
        let sources: Vec<Source> = (0..60).map(lamp).collect();
        let beams: Vec<Option<Beam>> = sources.iter().map(|one| Beam::new(lens.system(), one.place)).collect();
        let all = turns(&lens, Reflections::Two);
        for tolerance in [1e-3, 1e-4, 1e-5] {
            let found = candidates(&lens, &all, &sources, &beams, &|_, _| true, &Watch::NONE).unwrap();
            let (mut whole, _) = keep(found, 1.0, lens.size_px(), tolerance);
            measure_spread(&lens, &all, &sources, &beams, &mut whole);
            let mut look = Look::new(&lens, &all, &sources, &beams, tolerance).unwrap();
            measure_spread(&lens, &look.paths, &sources, &beams, &mut look.kept);
            let sum = |ghosts: &[Candidate]| ghosts.iter().map(work).sum::<f64>();
            let ratio = sum(&look.kept) / look.part / sum(&whole);
            let count = look.kept.len() as f64 / look.part / whole.len() as f64;
            println!("{tolerance} {} {} {} {ratio} {count}", look.part, whole.len(), look.kept.len());
            assert!((0.75..1.25).contains(&ratio) && (0.75..1.25).contains(&count), "{tolerance} {ratio} {count}");
        }
    }
}

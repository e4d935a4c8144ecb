//! The ghosts of a source one by one, the brightest first: the place of each on the film, its size and its brightness.

use glam::DVec2;

use super::beam::Beam;
use super::packet::{GhostTracer, Grid};
use crate::focus::FilmFrame;
use crate::system::System;
use crate::trace::Tracer;

/// A path with reflections, and the ghost that it makes of a source.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// The surfaces that reflect, in the order of the light.
    pub turns: Vec<usize>,
    /// The light that gets to the film's plane for one of irradiance before the lens, mm².
    pub light_mm2: f64,
    /// The part of that light on the film.
    pub on_film_mm2: f64,
    /// The middle of the light (u, v), mm from the picture's middle.
    pub centre_mm: DVec2,
    /// Radius of an even disc of the same width: √2 of the root mean square distance from the middle.
    pub radius_mm: f64,
    /// The irradiance on that disc, for one before the lens.
    pub irradiance: f64,
}

/// Cells along each side of a grid.
const SIDE: usize = 32;

/// The part of a triangle that the film has, by the middles of its sixteen parts.
fn part_on_film([a, b, c]: &[DVec2; 3], is_film: &impl Fn(DVec2) -> bool) -> f64 {
    let at = |i: u32, j: u32, third: f64| {
        let (u, v) = ((f64::from(i) + third) / PARTS, (f64::from(j) + third) / PARTS);
        *a + (*b - *a) * u + (*c - *a) * v
    };
    // Upright parts, and between them those that stand on their heads.
    let upright = (0..4).flat_map(|i| (0..4 - i).map(move |j| (i, j, 1.0 / 3.0)));
    let turned = (0..3).flat_map(|i| (0..3 - i).map(move |j| (i, j, 2.0 / 3.0)));
    let inside = upright.chain(turned).filter(|(i, j, third)| is_film(at(*i, *j, *third))).count();
    inside as f64 / (PARTS * PARTS)
}

/// Number of parts into which each side of a piece is cut to find the share of the piece on the film.
const PARTS: f64 = 4.0;

/// All ghosts of a beam at the tracer's wavelength with so many reflections, 2 or 4. `is_film` tells which points (u, v), mm, the
/// film has, `least_radius_mm` is the smallest disc that is told apart from a point; `part` as [`GhostTracer::window`] has it.
pub fn ranked(
    system: &System,
    tracer: &Tracer,
    beam: &Beam,
    (film, is_film): (&FilmFrame, impl Fn(DVec2) -> bool),
    reflections: usize,
    part: f64,
    least_radius_mm: f64,
) -> Vec<Ranked> {
    let one = |turns: Vec<usize>| {
        let path = GhostTracer::new(tracer, &turns)?;
        let mut bundle = path.bundle();
        let window = path.window(beam, film, part, &mut bundle)?;
        let (mut light, mut on_film, mut moment, mut square) = (0.0, 0.0, DVec2::ZERO, 0.0);
        path.pieces(
            system,
            (beam, film),
            Grid { window: &window, side: SIDE, is_coarse: false },
            &mut bundle,
            &mut |piece| {
                let middle = piece.corners.iter().sum::<DVec2>() / 3.0;
                light += piece.light_mm2;
                on_film += piece.light_mm2 * part_on_film(&piece.corners, &is_film);
                moment += middle * piece.light_mm2;
                square += middle.length_squared() * piece.light_mm2;
            },
        );
        if !(light > 0.0) {
            return None;
        }
        let centre_mm = moment / light;
        let variance = (square / light - centre_mm.length_squared()).max(0.0);
        let radius_mm = (2.0 * variance).sqrt().max(least_radius_mm);
        let irradiance = light / (std::f64::consts::PI * radius_mm * radius_mm);
        Some(Ranked { turns, light_mm2: light, on_film_mm2: on_film, centre_mm, radius_mm, irradiance })
    };
    let mut found: Vec<Ranked> =
        system.reflecting_paths(tracer.wavelength_nm(), reflections).into_iter().filter_map(one).collect();
    found.sort_by(|a, b| b.irradiance.total_cmp(&a.irradiance));
    found
}

//! Cases for the tests of several rays at once.

use super::PupilMap;
use crate::focus::FilmPlane;
use crate::formats::lens;
use crate::glass::Catalogue;
use crate::system::{LensSettings, System};
use glam::Vec3;

/// Rounds of eight rays on each map.
pub(super) const ROUNDS: usize = 4000;

/// A plain map, one of a stop with six blades and one of a tilted film; with the film, and a name.
pub(super) fn for_each_map(check: impl Fn(&PupilMap, &FilmPlane, &str)) {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses"));
    let prescription = lens::read(folder.join("double-gauss-f1.35.lens").as_path(), Catalogue::shipped()).unwrap();
    for (blades, tilt_rad) in [(0, 0.0), (6, 0.0), (0, 0.1)] {
        let settings = LensSettings { blades, ..LensSettings::default() };
        let system = System::new(&prescription, &settings).unwrap();
        let film = FilmPlane { tilt_rad, ..FilmPlane::upright(system.film_z_published_mm()) };
        let map = PupilMap::new(&system.at_wavelength(550.0), &system, &film, 18.0, 12.0);
        check(&map, &film, &format!("{blades} blades, tilted by {tilt_rad}"));
    }
}

/// A number from 0 to 1 of ray `i` of a round: the numbers fill that range evenly, others for every step `by`.
pub(super) fn part(round: usize, i: usize, by: f64) -> f32 {
    ((round * 8 + i) as f64 * by).fract() as f32
}

/// A point of 36 x 24 mm of film.
pub(super) fn place(film: &FilmPlane, [u, v]: [f32; 2]) -> Vec3 {
    film.point(f64::from(u - 0.5) * 36.0, f64::from(v - 0.5) * 24.0).as_vec3()
}

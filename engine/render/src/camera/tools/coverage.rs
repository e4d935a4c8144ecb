//! The part of a picture that a lens lights, and the film for which a lens is made.

use crate::camera::CameraError;
use crate::camera::description::{CameraDescription, FocusSettings, Model};
use crate::camera::lens::setup::{D_LINE_NM, Setup};
use crate::sampler::evenly::Evenly;
use petzval_optics::analysis::Analysis;
use petzval_optics::focus::{FilmPlane, Focus};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::system::{FocalLength, System};
use petzval_optics::trace::{Ray as LensRay, Tracer, Travel};
use serde::Serialize;

/// Places of a picture that are looked at, across and up.
const PLACES: [usize; 2] = [33, 19];
/// Places along the film's half diagonal where the edge of the light is looked for.
const RADII: usize = 200;
/// A circle that was found is looked at again on a film so many times as wide.
const WIDER: f64 = 1.5;
/// Rays from each place.
const RAYS: u32 = 24;
/// The dark part of a picture that is not worth a word: the last light of a corner.
const UNSEEN: f64 = 0.01;
/// Sides of a film that every lens and every retina has room for, mm.
const ANY_MM: f64 = 1e-3;

/// The part of a picture that a lens lights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// The part of the picture where no light arrives, 0 to 1.
    pub dark_part: f64,
    /// Diameter of the circle on an upright film that the lens lights, mm; no more than the picture's diagonal.
    pub lit_diameter_mm: f64,
    /// The dark part of the picture, its cause, and the remedy; `None` if the lens lights the picture.
    pub complaint: Option<String>,
}

impl CameraDescription {
    /// The part of a picture of that many pixels that the lens lights, by exact rays at the camera's wavelength. A model without rims
    /// lights all of it.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn coverage(&self, [width, height]: [u32; 2]) -> Result<Coverage, CameraError> {
        let setup = Setup::new(self, width, height)?;
        let half_mm = [0.5 * setup.info.picture_width_mm, 0.5 * setup.info.picture_height_mm];
        let diagonal_mm = 2.0 * half_mm[0].hypot(half_mm[1]);
        if !matches!(self.model, Model::Lens | Model::ImageBased) {
            return Ok(Coverage { dark_part: 0.0, lit_diameter_mm: diagonal_mm, complaint: None });
        }
        let tracer = setup.system.at_wavelength(self.wavelength_nm.unwrap_or(D_LINE_NM));
        let upright = FilmPlane { tilt_rad: 0.0, swing_rad: 0.0, shift_mm: [0.0; 2], ..setup.film };
        let dark_part = dark_part(&tracer, &setup.system, &setup.film, half_mm);
        let lit_diameter_mm = lit_diameter_mm(&tracer, &setup.system, &upright, half_mm);
        let complaint = (dark_part > UNSEEN).then(|| {
            let is_moved = setup.film != upright;
            let moved = is_moved && self::dark_part(&tracer, &setup.system, &upright, half_mm) <= UNSEEN;
            self.complaint(&setup, dark_part, lit_diameter_mm, moved)
        });
        Ok(Coverage { dark_part, lit_diameter_mm, complaint })
    }

    fn complaint(&self, setup: &Setup, dark_part: f64, lit_diameter_mm: f64, moved: bool) -> String {
        let percent = 100.0 * dark_part;
        let what = if moved {
            let film = &self.film;
            let is_turned = film.tilt_rad != 0.0 || film.swing_rad != 0.0;
            let is_shifted = film.shift_mm != [0.0; 2];
            let by = match (is_turned, is_shifted) {
                (true, true) => "tilted and shifted so far",
                (true, false) => "tilted so far",
                _ => "shifted so far",
            };
            let where_to = if is_turned && reaches_glass(setup) {
                "the film runs into the last glass"
            } else {
                "the film reaches beyond what the lens lights"
            };
            format!("{by}, {where_to}, and {percent:.0} % of the picture stays black: turn or shift it less")
        } else {
            format!(
                "{percent:.0} % of the picture stays black: the lens lights a circle of {lit_diameter_mm:.1} mm, and the picture takes \
                 {:.1} x {:.1} mm: set Film to Of the Lens (--film lens), make the film smaller, or choose a lens for larger film",
                setup.info.picture_width_mm, setup.info.picture_height_mm
            )
        };
        format!("Camera '{}': {what}", self.object_name)
    }

    /// Width and height of the film for which the lens is made, at its present size, mm: by its file, or if that has none, a film of the
    /// picture's shape whose corners see the half field of its design.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn film_of_lens_mm(&self, [width, height]: [u32; 2]) -> Result<[f64; 2], CameraError> {
        // The film that is set has no part in it.
        let at_infinity = self.clone().with(|c| {
            c.focus = FocusSettings::default();
            (c.film.width_mm, c.film.height_mm) = (ANY_MM, ANY_MM);
        });
        let setup = Setup::new(&at_infinity, width, height)?;
        let reading = self.lens_file()?;
        let prescription = &reading.prescription;
        if let Some(film_mm) = prescription.metadata.film_mm {
            let is_zoomed = setup.info.zoom_range_mm.is_some();
            let published = at_infinity.clone().with(|c| c.lens.focal_length = FocalLength::AsPublished);
            let efl = |setup: &Setup| Paraxial::new(&setup.system, D_LINE_NM).efl_mm;
            let scale = match efl(&setup).zip(efl(&Setup::new(&published, width, height)?)) {
                Some((now, then)) if !is_zoomed => (now / then).abs(),
                _ => 1.0,
            };
            return Ok(film_mm.map(|side| side * scale));
        }
        let focus = Focus::at_infinity(&setup.system, D_LINE_NM);
        let corner_mm = Analysis::new(&setup.system, focus, &[D_LINE_NM], 0, 0.0)
            .and_then(|analysis| analysis.chief_ray(analysis.half_field_deg()))
            .map(|chief| chief.height_mm.abs())
            .filter(|height| *height > 0.0);
        let corner_mm = corner_mm.ok_or_else(|| {
            self.error(format!("nothing says how large the film of '{}' is: set a film size", setup.info.lens_name))
        })?;
        let shape = [f64::from(width), self.rows_high(height)];
        Ok(shape.map(|side| 2.0 * corner_mm * side / shape[0].hypot(shape[1])))
    }
}

/// The part of a film's picture where no ray arrives.
fn dark_part(tracer: &Tracer, system: &System, film: &FilmPlane, half_mm: [f64; 2]) -> f64 {
    let map = PupilMap::new(tracer, system, film, half_mm[0], half_mm[1]);
    let along = |i: usize, count: usize| 2.0 * (i as f64 + 0.5) / count as f64 - 1.0;
    let places: Vec<[f64; 2]> = (0..PLACES[1])
        .flat_map(|row| (0..PLACES[0]).map(move |column| [along(column, PLACES[0]), along(row, PLACES[1])]))
        .map(|[x, y]| [x * half_mm[0], y * half_mm[1]])
        .collect();
    let lit = lit(tracer, &map, film, &places);
    lit.iter().filter(|lit| !**lit).count() as f64 / lit.len() as f64
}

/// The diameter of the circle, no larger than the picture's diagonal, beyond which no light arrives along the diagonal.
fn lit_diameter_mm(tracer: &Tracer, system: &System, film: &FilmPlane, half_mm: [f64; 2]) -> f64 {
    let found = lit_within_mm(tracer, system, film, half_mm);
    // The pupil map of a film that is far too large is coarse.
    let part = WIDER * found / (2.0 * half_mm[0].hypot(half_mm[1]));
    if part > 0.0 && part < 1.0 { lit_within_mm(tracer, system, film, half_mm.map(|half| half * part)) } else { found }
}

fn lit_within_mm(tracer: &Tracer, system: &System, film: &FilmPlane, half_mm: [f64; 2]) -> f64 {
    let map = PupilMap::new(tracer, system, film, half_mm[0], half_mm[1]);
    let places: Vec<[f64; 2]> = (1..=RADII).map(|i| half_mm.map(|half| half * i as f64 / RADII as f64)).collect();
    let farthest = lit(tracer, &map, film, &places).iter().rposition(|lit| *lit);
    farthest.map_or(0.0, |i| 2.0 * places[i][0].hypot(places[i][1]))
}

/// For each of these places of the film, true if any of some rays arrives there.
fn lit(tracer: &Tracer, map: &PupilMap, film: &FilmPlane, places: &[[f64; 2]]) -> Vec<bool> {
    let points = Evenly::<2>::default();
    let mut bundle = tracer.bundle(Travel::FromFilm);
    for &[u, v] in places {
        let origin = film.point(u, v);
        for i in 0..RAYS {
            let aim = map.sample(origin, points.point(i));
            bundle.push(LensRay { origin, direction: (aim.target - origin).normalize() });
        }
    }
    tracer.trace(&mut bundle);
    let rays = RAYS as usize;
    (0..places.len()).map(|place| (place * rays..(place + 1) * rays).any(|i| bundle.result(i).is_ok())).collect()
}

/// True if a corner of the picture lies before the last vertex of the lens.
fn reaches_glass(setup: &Setup) -> bool {
    let [u, v] = [0.5 * setup.info.picture_width_mm, 0.5 * setup.info.picture_height_mm];
    let last_z_mm = setup.system.last_vertex_z_mm();
    let side = (setup.film.z_mm - last_z_mm).signum();
    [[u, v], [u, -v], [-u, v], [-u, -v]].iter().any(|&[u, v]| side * (setup.film.point(u, v).z - last_z_mm) <= 0.0)
}

#[cfg(test)]
mod tests;

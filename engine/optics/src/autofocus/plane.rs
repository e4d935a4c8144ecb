//! The film on which three points are sharp: Scheimpflug's, but through their images by exact rays.

use glam::DVec3;
use thiserror::Error;

use super::{Autofocus, AutofocusError, Subject, Weighted};
use crate::focus::FilmPlane;

/// A film turned further than this from upright is none, degrees.
const STEEPEST_DEG: f64 = 80.0;
/// Twice a triangle's area over the square of its longest side: below this its corners lie on a line.
const FLATTEST: f64 = 1e-4;
/// Planes are fitted again until they stay; a few times will do.
const MOST_STEPS: usize = 60;
/// Part of the image's distance that is no change.
const SETTLED: f64 = 1e-11;

/// An error by which no film makes three points sharp.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SharpPlaneError {
    /// One of the points has no sharp image.
    #[error("sharp point {number} of 3: {source}")]
    Point {
        /// Number of the point, from 1.
        number: usize,
        /// The reason why the point has none.
        source: AutofocusError,
    },
    /// The points, or their images, lie on one line: many planes go through them.
    #[error("the three sharp points lie on one line, or look so to the lens; move one of them off it")]
    Collinear,
    /// The film would stand nearly along the axis.
    #[error("the film would be turned by more than {STEEPEST_DEG} degrees; choose points less in line with the lens")]
    TooSteep,
    /// No plane goes through the images that are sharp on it.
    #[error("no flat film makes all three points sharp; choose points nearer to each other, or stop down")]
    Unsettled,
}

impl Autofocus {
    /// The flat film, unshifted, on which all three are as sharp as a move of the film along the axis can make them.
    ///
    /// # Errors
    /// [`SharpPlaneError`].
    pub fn film_through(&self, subjects: [Subject; 3]) -> Result<FilmPlane, SharpPlaneError> {
        if let [Subject::Point(a), Subject::Point(b), Subject::Point(c)] = subjects
            && is_line([a, b, c])
        {
            return Err(SharpPlaneError::Collinear);
        }
        let of = |number: usize| move |source| SharpPlaneError::Point { number: number + 1, source };
        let mut beams: [Vec<Weighted>; 3] = Default::default();
        for (number, subject) in subjects.into_iter().enumerate() {
            beams[number] = self.beam(subject).map_err(of(number))?;
        }
        // Where a spot is smallest depends on how its film is turned, and that on where the spots are.
        let mut film = FilmPlane::upright(0.0);
        let mut images = [DVec3::ZERO; 3];
        for _ in 0..MOST_STEPS {
            let mut moved = 0.0f64;
            for (number, beam) in beams.iter().enumerate() {
                let image = self.of_beam(beam, &film).map_err(of(number))?.image_mm;
                moved = moved.max((image - images[number]).length());
                images[number] = image;
            }
            film = through(images)?;
            if moved < SETTLED * (film.z_mm - self.last_z_mm).abs().max(self.length_mm) {
                return Ok(film);
            }
        }
        Err(SharpPlaneError::Unsettled)
    }
}

/// The film through three points.
fn through([a, b, c]: [DVec3; 3]) -> Result<FilmPlane, SharpPlaneError> {
    if is_line([a, b, c]) {
        return Err(SharpPlaneError::Collinear);
    }
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let away = normal * 1f64.copysign(normal.z);
    // The film's third axis is Rx(tilt) Ry(swing) z = (sin swing, −sin tilt cos swing, cos tilt cos swing).
    let (tilt_rad, swing_rad) = ((-away.y).atan2(away.z), away.x.clamp(-1.0, 1.0).asin());
    let steepest = STEEPEST_DEG.to_radians();
    if tilt_rad.abs() > steepest || swing_rad.abs() > steepest {
        return Err(SharpPlaneError::TooSteep);
    }
    Ok(FilmPlane { tilt_rad, swing_rad, ..FilmPlane::upright(a.dot(away) / away.z) })
}

fn is_line([a, b, c]: [DVec3; 3]) -> bool {
    let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
    // NaN is no triangle either.
    !((b - a).cross(c - a).length() > FLATTEST * longest)
}

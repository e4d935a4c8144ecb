//! A lens set to the frame of Blender's own camera: the angle between the chief rays of the picture's edges, along
//! its larger side, is the same.

use crate::camera::lens::setup::Setup;
use crate::camera::{CameraDescription, CameraError};
use petzval_optics::system::FocalLength;
use serde::{Deserialize, Serialize};

/// The settings that may be changed to frame like Blender's camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Framed {
    /// The lens is scaled, a zoom lens zoomed; the film becomes Blender's sensor.
    #[serde(rename = "FOCAL_LENGTH")]
    ByFocalLength,
    /// The film becomes larger or smaller, the lens stays.
    #[serde(rename = "FILM")]
    ByFilm,
}

/// The settings that frame like Blender's camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Framing {
    /// Focal length, mm; `None`: as it was.
    pub focal_length_mm: Option<f64>,
    /// Width of the picture, mm.
    pub film_width_mm: f64,
    /// Height of the picture, mm.
    pub film_height_mm: f64,
    /// Shift of the lens against the film, mm.
    pub shift_mm: [f64; 2],
    /// Angle along the larger side.
    pub angle_rad: f64,
    /// True if the rays through the middle of the exit pupil reach the film's edges; where they do not, the picture is dim or dark towards
    /// them.
    pub reaches_edges: bool,
}

/// The factor by which a step widens a bracket, and the limit of widening.
const WIDER: f64 = 1.25;
const FARTHEST: f64 = 1e3;
/// Steps by which the bracket is narrowed, at most: halvings to rounding.
const HALVINGS: usize = 60;
/// Difference of an angle that is rounding, rad.
const ROUNDING_RAD: f64 = 1e-11;
/// Tolerance of an angle, rad: a value this near to the end of a zoom is its end.
const SAME: f64 = 1e-6;

impl CameraDescription {
    /// The settings with which this lens, focused as it is, has the frame of the pinhole of Blender's own focal length, sensor and shift.
    ///
    /// # Errors
    /// [`CameraError`]; it names the frames that the lens can reach.
    pub fn framed_like_blender(&self, size: [u32; 2], by: Framed) -> Result<Framing, CameraError> {
        if !self.model.is_of_lens() {
            return Err(self.error("it has no lens to set; choose a camera model that is made from a lens file"));
        }
        let search = Search::new(self, size, by);
        let range = Setup::new(self, size[0], size[1])?.info.zoom_range_mm.filter(|_| by == Framed::ByFocalLength);
        let value = match range {
            Some([short, long]) => search.within(short, long)?,
            None => search.anywhere()?,
        };
        let d = search.described(value);
        let info = Setup::new(&d, size[0], size[1])?.info;
        let seen =
            if f64::from(size[0]) >= d.rows_high(size[1]) { info.fov_horizontal_rad } else { info.fov_vertical_rad };
        Ok(Framing {
            focal_length_mm: (by == Framed::ByFocalLength).then_some(value),
            film_width_mm: d.film.width_mm,
            film_height_mm: d.film.height_mm,
            shift_mm: d.film.shift_mm,
            angle_rad: search.wanted_rad,
            reaches_edges: seen.is_some(),
        })
    }
}

struct Search<'a> {
    d: &'a CameraDescription,
    size: [u32; 2],
    by: Framed,
    wanted_rad: f64,
}

impl<'a> Search<'a> {
    fn new(d: &'a CameraDescription, size: [u32; 2], by: Framed) -> Self {
        let (width, height) = (f64::from(size[0]), d.rows_high(size[1]));
        let larger = d.perspective.film_width_mm * (height / width).max(1.0);
        let shift = d.perspective.shift[if width >= height { 0 } else { 1 }];
        let edge = |at: f64| ((at + shift) * larger / d.perspective.focal_length_mm).atan();
        Self { d, size, by, wanted_rad: edge(0.5) - edge(-0.5) }
    }

    /// The camera with a focal length or a width of the film.
    fn described(&self, value: f64) -> CameraDescription {
        let width = match self.by {
            Framed::ByFocalLength => self.d.perspective.film_width_mm,
            Framed::ByFilm => value,
        };
        let aspect = self.d.rows_high(self.size[1]) / f64::from(self.size[0]);
        let larger = width * aspect.max(1.0);
        self.d.clone().with(|c| {
            if self.by == Framed::ByFocalLength {
                c.lens.focal_length = FocalLength::Millimetres(value);
            }
            (c.film.width_mm, c.film.height_mm) = (width, width * aspect);
            c.film.shift_mm = c.perspective.shift.map(|shift| shift * larger);
        })
    }

    /// The angle that is framed with this value; infinite where no ray of the picture's edge comes through the surfaces, or the film is too
    /// large to be.
    fn angle(&self, value: f64) -> Result<f64, CameraError> {
        let [width, height] = self.size;
        let d = self.described(value);
        let setup = match Setup::new(&d, width, height) {
            Ok(setup) => setup,
            Err(CameraError::Setting { .. }) if self.by == Framed::ByFilm => return Ok(f64::INFINITY),
            Err(error) => return Err(error),
        };
        let edge = match f64::from(width) >= d.rows_high(height) {
            true => [0.5 * setup.info.picture_width_mm, 0.0],
            false => [0.0, 0.5 * setup.info.picture_height_mm],
        };
        Ok(setup.angle_without_rims(&d, edge.map(|x| -x), edge).unwrap_or(f64::INFINITY))
    }

    /// Finds the focal length within the range of a zoom.
    fn within(&self, short: f64, long: f64) -> Result<f64, CameraError> {
        let (widest, narrowest) = (self.angle(short)?, self.angle(long)?);
        if self.wanted_rad > widest + SAME || self.wanted_rad < narrowest - SAME {
            return Err(self.d.error(format!(
                "its zoom from {short:.2} to {long:.2} mm sees {:.2} to {:.2} degrees on this film, Blender's camera {:.2}: choose another lens or film",
                widest.to_degrees(), narrowest.to_degrees(), self.wanted_rad.to_degrees()
            )));
        }
        self.between(short, long)
    }

    /// Finds the size of a lens that may be scaled without limit, or of a film.
    fn anywhere(&self) -> Result<f64, CameraError> {
        // Larger lenses see less, larger films more.
        let factor = if self.by == Framed::ByFocalLength { WIDER } else { WIDER.recip() };
        let start = match self.by {
            Framed::ByFocalLength => self.d.perspective.focal_length_mm,
            Framed::ByFilm => self.d.film.width_mm,
        };
        let step = |from: f64, by: f64, is_wide: bool| -> Result<f64, CameraError> {
            let mut value = from;
            while (self.angle(value)? >= self.wanted_rad) == is_wide
                && (from / FARTHEST..from * FARTHEST).contains(&value)
            {
                value *= by;
            }
            Ok(value)
        };
        let narrow = step(start, factor, true)?;
        let wide = step(narrow, factor.recip(), false)?;
        self.between(wide, narrow)
    }

    /// Finds the value between one that sees as much or more and one that sees less: by the secant of the angle over one over the value,
    /// which is nearly straight, one end's difference halved where the other stays (the Illinois method); halving where nothing is seen.
    fn between(&self, mut wide: f64, mut narrow: f64) -> Result<f64, CameraError> {
        let beyond = |value: f64| Ok::<f64, CameraError>(self.angle(value)? - self.wanted_rad);
        let (mut over, mut under) = (beyond(wide)?, beyond(narrow)?);
        let mut best = if over.abs() < under.abs() { (wide, over) } else { (narrow, under) };
        let mut before_was_wide = None;
        for _ in 0..HALVINGS {
            if best.1.abs() < ROUNDING_RAD || wide == narrow {
                break;
            }
            let (a, b) = (wide.recip(), narrow.recip());
            let secant = (a - over * (b - a) / (under - over)).recip();
            let is_within = over.is_finite() && secant > wide.min(narrow) && secant < wide.max(narrow);
            let value = if is_within { secant } else { (wide * narrow).sqrt() };
            let off = beyond(value)?;
            if off.abs() < best.1.abs() {
                best = (value, off);
            }
            let is_wide = off >= 0.0;
            if is_wide {
                (wide, over) = (value, off);
                under *= if before_was_wide == Some(true) { 0.5 } else { 1.0 };
            } else {
                (narrow, under) = (value, off);
                over *= if before_was_wide == Some(false) { 0.5 } else { 1.0 };
            }
            before_was_wide = Some(is_wide);
        }
        let (found, off) = best;
        if off.abs() > SAME {
            let seen = self.angle(narrow)?;
            let seen = if seen.is_finite() { seen.to_degrees() } else { 0.0 };
            return Err(self.d.error(format!(
                "the lens sees {seen:.2} degrees at most, Blender's camera {:.2}: choose a wider lens, or a longer focal length in Blender",
                self.wanted_rad.to_degrees()
            )));
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests;

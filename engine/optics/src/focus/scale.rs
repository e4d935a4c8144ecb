//! The reference point of a focus distance, and the relation by which it moves the film.

use super::{Conjugates, FocusError};
use crate::paraxial::Paraxial;
use crate::system::System;
use serde::Deserialize;

/// The point of the axis that focus distances are counted from. It stays where it is in the world while the lens is
/// focused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Anchor {
    /// The centre of the entrance pupil: the film moves.
    #[default]
    EntrancePupil,
    /// The vertex of the first surface: the film moves.
    FrontVertex,
    /// The point where the axis intersects the film: the lens moves as a whole (unit focusing), and distances are those on the scale of its
    /// barrel.
    Film,
}

/// The relation of focus distance U and film distance V (Wu et al. 2011, §4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Relation {
    /// Paraxial conjugates; U is counted from the anchor.
    #[default]
    Exact,
    /// 1/U + 1/V = 1/f with U counted from the object principal plane, whatever the anchor, and V from the image
    /// principal plane. In air these are the same conjugates counted from elsewhere; where the film lies in another
    /// medium, as in eyes, the relation leaves its index out.
    Thin,
}

/// The meaning of focus distances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Focusing {
    /// The point that distances are counted from, and that stays put.
    pub anchor: Anchor,
    /// The relation by which focus distances move the film.
    pub relation: Relation,
}

impl Focusing {
    /// The z in lens space (mm) at which the film shows points `distance_mm` away; the distance may be infinite.
    ///
    /// A film as the anchor has two solutions for each distance; this is the one in which the image is no larger than
    /// the object.
    ///
    /// # Errors
    /// [`FocusError`].
    pub fn film_z_mm(&self, system: &System, wavelength_nm: f64, distance_mm: f64) -> Result<f64, FocusError> {
        if !(distance_mm > 0.0) {
            return Err(FocusError::NotPositive { distance_mm });
        }
        let conjugates = Conjugates::new(system, wavelength_nm);
        if !(conjugates.matrix.c < 0.0) {
            return Err(FocusError::NoRealImage);
        }
        if self.relation == Relation::Thin {
            let thin = ThinRelation::new(system, wavelength_nm)?;
            return conjugates.real(thin.film_z_mm(distance_mm)?);
        }
        if distance_mm == f64::INFINITY {
            return conjugates.real(conjugates.image_z_mm(1.0, 0.0));
        }
        match self.anchor {
            Anchor::EntrancePupil => {
                let pupil_z = conjugates.pupil_z_mm.ok_or(FocusError::NoEntrancePupil)?;
                conjugates.film_z_mm(distance_mm, pupil_z)
            }
            Anchor::FrontVertex => conjugates.film_z_mm(distance_mm, 0.0),
            Anchor::Film => conjugates.film_z_at_mm(distance_mm),
        }
    }

    /// The distance in mm that a film at `film_z_mm` shows sharp: the inverse of [`Self::film_z_mm`].
    ///
    /// Infinite if the film stands in the focal plane, negative if the sharp plane would lie behind the anchor.
    pub fn distance_mm(&self, system: &System, wavelength_nm: f64, film_z_mm: f64) -> f64 {
        if self.relation == Relation::Thin {
            return ThinRelation::new(system, wavelength_nm).map_or(f64::INFINITY, |t| t.distance_mm(film_z_mm));
        }
        let object_z = Conjugates::new(system, wavelength_nm).object_z_mm(film_z_mm);
        let origin_z = self.origin_z_mm(system, wavelength_nm, film_z_mm);
        if object_z.is_finite() { origin_z - object_z } else { f64::INFINITY }
    }

    /// The anchor in lens space, mm, for a film at `film_z_mm`. An entrance pupil at infinity is stood for by the front
    /// vertex.
    pub fn origin_z_mm(&self, system: &System, wavelength_nm: f64, film_z_mm: f64) -> f64 {
        match self.anchor {
            Anchor::EntrancePupil => Paraxial::new(system, wavelength_nm).entrance_pupil.z_mm.unwrap_or(0.0),
            Anchor::FrontVertex => 0.0,
            Anchor::Film => film_z_mm,
        }
    }
}

impl Conjugates {
    /// The film for an object at `distance_mm` from a fixed point of the axis.
    pub(super) fn film_z_mm(&self, distance_mm: f64, from_z_mm: f64) -> Result<f64, FocusError> {
        // The object must lie before the object focal point and before the lens.
        let nearest_mm = from_z_mm - self.front_focus_z_mm().min(0.0);
        if distance_mm <= nearest_mm {
            return Err(FocusError::TooClose { distance_mm, nearest_mm });
        }
        self.real(self.image_z_mm(distance_mm - from_z_mm, 1.0))
    }

    /// The film for an object at `distance_mm` from the film. Newton: with the film y behind the focal point, along the
    /// light, the object lies f f′ / y before its own, and the two add up to the excess of the distance over that between the
    /// focal points.
    fn film_z_at_mm(&self, distance_mm: f64) -> Result<f64, FocusError> {
        let power = -self.matrix.c;
        let (front, rear) = (self.front_focus_z_mm(), self.image_z_mm(1.0, 0.0));
        // Positive: more film distance is more distance; after a mirror the film comes nearer to the object.
        let product = self.image_index / (power * power);
        // The object lies before the lens, and the image is no larger than it.
        let most = match front > 0.0 {
            true => (product.abs() / front).min(product.abs().sqrt()),
            false => product.abs().sqrt(),
        };
        let nearest_mm = rear - front + most * self.towards_film + product.abs() / most;
        if distance_mm < nearest_mm {
            return Err(FocusError::TooClose { distance_mm, nearest_mm });
        }
        let over = distance_mm - (rear - front);
        let y = 2.0 * product.abs() / (over + (over * over - 4.0 * product).max(0.0).sqrt());
        self.real(rear + y * self.towards_film)
    }

    fn front_focus_z_mm(&self) -> f64 {
        self.matrix.d / self.matrix.c
    }

    /// The film's place, if it is behind the lens.
    pub(super) fn real(&self, film_z_mm: f64) -> Result<f64, FocusError> {
        let is_real = film_z_mm.is_finite() && (film_z_mm - self.last_z_mm) * self.towards_film > 0.0;
        if is_real { Ok(film_z_mm) } else { Err(FocusError::NoRealImage) }
    }
}

/// 1/U + 1/V = 1/f.
struct ThinRelation {
    focal_mm: f64,
    image_principal_z_mm: f64,
    towards_film: f64,
}

impl ThinRelation {
    fn new(system: &System, wavelength_nm: f64) -> Result<Self, FocusError> {
        let info = Paraxial::new(system, wavelength_nm);
        match (info.efl_mm, info.image_principal_plane_mm) {
            (Some(focal_mm), Some(image_principal_z_mm)) => {
                Ok(Self { focal_mm, image_principal_z_mm, towards_film: system.light_direction_at_film() })
            }
            _ => Err(FocusError::NoRealImage),
        }
    }

    fn film_z_mm(&self, distance_mm: f64) -> Result<f64, FocusError> {
        let f = self.focal_mm;
        if distance_mm <= f {
            return Err(FocusError::TooClose { distance_mm, nearest_mm: f });
        }
        // V = f U / (U − f), in a form that infinity passes.
        Ok(self.image_principal_z_mm + self.towards_film * f / (1.0 - f / distance_mm))
    }

    fn distance_mm(&self, film_z_mm: f64) -> f64 {
        let film_distance = (film_z_mm - self.image_principal_z_mm) * self.towards_film;
        let over = film_distance - self.focal_mm;
        // A film at the focal plane to within rounding sees infinity.
        if over.abs() <= 1e-13 * film_distance.abs() { f64::INFINITY } else { self.focal_mm * film_distance / over }
    }
}

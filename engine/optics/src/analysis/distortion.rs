//! Chief rays of fields on the film, and foci of the rays about them: distortion, field curvature with astigmatism, lateral colour.

use glam::{DVec2, DVec3};

use serde::Serialize;

use super::{Analysis, FieldView};
use crate::trace::Ray;

/// Rays beside the middle one, in radii of the entrance pupil: near enough to tell its own focus.
const BESIDE: f64 = 1e-4;

/// The ray of a field through the middle of the stop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChiefRay {
    /// Angle of the field from the axis, counted at the entrance pupil.
    pub angle_deg: f64,
    /// Height at which the chief ray hits the film, tangential, mm from the axis, at the main wavelength.
    pub height_mm: f64,
    /// Height of the chief ray in a picture without distortion, by the tangent of the angle; `None` from 90 degrees on.
    pub straight_height_mm: Option<f64>,
    /// Height of the chief ray in a picture whose heights go with the angle itself (f-theta).
    pub even_height_mm: f64,
    /// The place at which the rays beside it in the plane of the field cross it, along z from the film; `None`: nowhere.
    pub tangential_focus_mm: Option<f64>,
    /// The place at which the rays beside it at right angles to the plane of the field cross it, along z from the film; `None`: nowhere.
    pub sagittal_focus_mm: Option<f64>,
    /// Height at each wavelength, from that at the main one. `None`: the wavelength has no such ray.
    pub colour_mm: Vec<Option<f64>>,
}

impl Analysis<'_> {
    /// The chief ray of a field; `None`: no ray of the main wavelength goes through the middle of the stop to the film.
    ///
    /// Rims count for the beam, but not for its middle ray: a mirror in front may hide it.
    pub fn chief_ray(&self, angle_deg: f64) -> Option<ChiefRay> {
        let view = self.view(angle_deg)?;
        let height = |line: usize| {
            let out = self.chief_out(line, &view)?;
            Some(self.turned(DVec2::from(self.film.frame().meet(&out)?)).y)
        };
        let height_mm = height(self.main)?;
        let slope_mm = self.height_by_slope_mm();
        let [tangential_focus_mm, sagittal_focus_mm] = [DVec2::Y, DVec2::X].map(|axis| self.focus_beside(&view, axis));
        let angle = angle_deg.to_radians();
        Some(ChiefRay {
            angle_deg,
            height_mm,
            straight_height_mm: (angle_deg.abs() < 90.0).then(|| slope_mm * angle.tan()),
            even_height_mm: slope_mm * angle,
            tangential_focus_mm,
            sagittal_focus_mm,
            colour_mm: (0..self.lines.len()).map(|line| height(line).map(|height| height - height_mm)).collect(),
        })
    }

    /// Height on the film by the tangent of the field's angle, mm, where both are small: EFL for an object at infinity.
    pub fn height_by_slope_mm(&self) -> f64 {
        // The middle ray of a small angle is the paraxial one through the pupil, exact to the square of the angle.
        const SMALL_DEG: f64 = 1e-3;
        let line = &self.lines[self.main];
        let landing = |angle_deg: f64| {
            let field = self.field(angle_deg);
            let at = line.probe.aim(&field, DVec2::ZERO, DVec2::ZERO).unwrap_or(DVec2::ZERO);
            let out = line.probe.tracer.from_scene(line.probe.origin.ray(&field, at)).ok();
            out.and_then(|out| self.film.frame().meet(&out)).map_or(DVec2::ZERO, DVec2::from)
        };
        // The axis lands beside the middle where an element is out of place.
        let [above, below] = [SMALL_DEG, -SMALL_DEG].map(landing);
        self.turned(0.5 * (above - below)).y / SMALL_DEG.to_radians().tan()
    }

    /// The place at which the rays on both sides of the middle one along an axis of the field's plane are nearest to it, along z from the
    /// film.
    fn focus_beside(&self, view: &FieldView, axis: DVec2) -> Option<f64> {
        let line = &self.lines[self.main];
        let chief = self.chief(self.main, view)?;
        let step = axis * (BESIDE * line.probe.pupil_radius_mm);
        let out = |at: DVec2| line.probe.tracer.from_scene(line.probe.origin.ray(&view.field, at)).ok();
        let [a, b, middle] = [out(chief - step)?, out(chief + step)?, out(chief)?];
        let film = self.film.frame().meet(&middle)?;
        let at_film = self.film.point(film[0], film[1]);
        // How the rays of the pair part along the middle one, of what lies across it.
        let across = |v: DVec3| v - middle.direction * v.dot(middle.direction);
        let near = |ray: &Ray| {
            let along = middle.direction.dot(at_film - ray.origin) / middle.direction.dot(ray.direction);
            (ray.origin + ray.direction * along, ray.direction / middle.direction.dot(ray.direction))
        };
        let ((a, to_a), (b, to_b)) = (near(&a), near(&b));
        let (apart, parting) = (across(b - a), across(to_b - to_a));
        let way = -apart.dot(parting) / parting.length_squared();
        Some(way * middle.direction.z).filter(|z| z.is_finite())
    }
}

//! A lens with its adjustments before its film, beside a calibration.

use glam::{DVec2, DVec3};

use super::{LensState, Search};
use crate::chief_rays::{FilmChiefRays, direction_at, turned};
use crate::paraxial::Paraxial;
use crate::prescription::Prescription;
use crate::prescription::moving::Part;
use crate::system::System;

/// A lens with its adjustments, before its film.
pub(super) struct SetLens {
    pub(super) lens: Prescription,
    pub(super) scale: f64,
    pub(super) system: System,
    pub(super) rays: FilmChiefRays,
    pub(super) pupil_z_mm: f64,
    pub(super) film_z_mm: f64,
    pub(super) distance_mm: Option<f64>,
}

impl SetLens {
    /// The points that both the lens and the calibration see.
    pub(super) fn common(&self, search: &Search<'_>, points: &[DVec2]) -> Vec<DVec2> {
        let is_lit = |point: &DVec2| {
            let film = search.film_mm(*point);
            self.rays.at(film, None).is_some_and(|chief| self.rays.is_through(film, &chief))
        };
        let is_seen = |point: &DVec2| search.task.calibration.unproject(*point).is_ok();
        let both = points.iter().filter(|point| is_seen(point) && is_lit(point));
        both.filter(|point| self.off(search, **point).is_some()).copied().collect()
    }

    /// The residual at a point: from it to the point at which the calibration sees the same direction, pixels.
    pub(super) fn off(&self, search: &Search<'_>, point: DVec2) -> Option<DVec2> {
        let calibration = search.task.calibration;
        let chief = self.rays.at(search.film_mm(point), None)?;
        let origin = turned(chief.scene.origin - DVec3::Z * self.pupil_z_mm);
        let direction = turned(chief.scene.direction);
        let seen = direction_at(origin, direction, self.distance_mm, calibration.is_flat())?;
        Some(calibration.project(seen).ok()? - point)
    }

    fn film_distance_mm(&self) -> f64 {
        self.film_z_mm - self.system.last_vertex_z_mm()
    }

    pub(super) fn state(&self, wavelength_nm: f64) -> LensState {
        LensState {
            efl_mm: Paraxial::new(&self.system, wavelength_nm).efl_mm,
            focus_distance_mm: self.distance_mm,
            film_distance_mm: self.film_distance_mm(),
        }
    }

    pub(super) fn into_prescription(self) -> Prescription {
        let film_distance_mm = self.film_distance_mm();
        let mut lens = self.lens;
        let last = lens.surfaces.len() - 1;
        let moves = lens.moving.as_ref().is_some_and(|moving| moving.parts().contains(&Part::gap(last)));
        if !moves {
            lens.surfaces[last].thickness_mm = film_distance_mm;
        }
        lens
    }
}

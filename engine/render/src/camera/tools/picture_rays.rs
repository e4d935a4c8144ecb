//! The ray at which each point of a lens's picture looks: the chief ray of its film point, in the camera's own space.
//!
//! Camera space is OpenCV's: x right, y down, z ahead, millimetres, its origin the centre of projection. Points are pixels from the picture's
//! upper left corner. A lens has no one centre, as its entrance pupil wanders with the field: [`Centre`] says which point counts as such.

use crate::camera::lens::setup::{D_LINE_NM, Setup};
use crate::camera::{CameraDescription, CameraError};
use glam::{DVec2, DVec3};
use petzval_optics::chief_rays::{
    ChiefRayError, FilmChiefRay, FilmChiefRays, direction_at, nearest_on_axis_mm, turned,
};
use petzval_optics::focus::FilmPlane;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::System;
use petzval_optics::trace::Ray as LensRay;
use rayon::prelude::*;
use serde::Deserialize;

/// Cells over the picture's larger side, at whose corners its rays are looked at; and where fewer nodes than these are lit.
const CELLS: u32 = 64;
const FINE_CELLS: u32 = 256;
const FEW: usize = 400;

/// The point of the axis that counts as the centre of projection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Centre {
    /// The entrance pupil of rays near the axis, which stands at the origin of the camera that renders the lens.
    #[default]
    Pupil,
    /// The point that is nearest to the chief rays of the whole picture, by least squares of their distances.
    Nearest,
}

/// An error by which there are no rays.
#[derive(Debug, thiserror::Error)]
pub enum PictureRaysError {
    /// The camera cannot photograph.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The lens has no chief rays.
    #[error(transparent)]
    ChiefRays(#[from] ChiefRayError),
    /// No light comes to the film.
    #[error("lens '{0}' lights nothing of this film by its chief rays; make the film smaller, or change the focus")]
    Dark(String),
}

/// A ray of a picture point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureRay {
    /// The point, pixels from the picture's upper left corner.
    pub point_px: DVec2,
    /// A point of the ray on the first surface of the lens, camera space, mm.
    pub origin_mm: DVec3,
    /// The unit direction into the scene, camera space.
    pub direction: DVec3,
    /// True if no rim of the lens stops the ray.
    pub is_lit: bool,
    /// The part of the picture that a node of the grid stands for.
    pub weight: f64,
}

/// A picture of a lens by its chief rays.
pub struct PictureRays {
    /// The lens as it is set and focused.
    pub system: System,
    chief: FilmChiefRays,
    film: FilmPlane,
    /// Vacuum wavelength of the rays, nm.
    pub wavelength_nm: f64,
    /// Width and height of the picture, pixels.
    pub size_px: [u32; 2],
    /// Width and height of the picture on the film, mm.
    pub picture_mm: [f64; 2],
    /// The entrance pupil of rays near the axis, z in lens space.
    pub pupil_z_mm: f64,
    /// The centre of projection, z in lens space.
    pub centre_z_mm: f64,
    /// The plane that is sharp, z in lens space; `None`: at infinity.
    pub sharp_z_mm: Option<f64>,
}

impl PictureRays {
    /// The rays of a camera with a lens, at its wavelength or the d line, for a picture of that many pixels.
    ///
    /// # Errors
    /// [`PictureRaysError`].
    pub fn new(d: &CameraDescription, size_px: [u32; 2], centre: Centre) -> Result<Self, PictureRaysError> {
        if !d.model.is_of_lens() {
            let what = "only a lens has chief rays; choose a camera model that is made from a lens file";
            return Err(d.error(what).into());
        }
        d.check(size_px[0], size_px[1])?;
        let Setup { info, system, film, .. } = Setup::new(d, size_px[0], size_px[1])?;
        let wavelength_nm = d.wavelength_nm.unwrap_or(D_LINE_NM);
        let chief = FilmChiefRays::new(&system, wavelength_nm, film)?;
        let pupil_z_mm = Paraxial::new(&system, wavelength_nm).entrance_pupil.z_mm.unwrap_or(0.0);
        let mut rays = Self {
            chief,
            film,
            wavelength_nm,
            size_px,
            picture_mm: [info.picture_width_mm, info.picture_height_mm],
            pupil_z_mm,
            centre_z_mm: pupil_z_mm,
            sharp_z_mm: info.focus_distance_mm.map(|distance| pupil_z_mm - distance),
            system,
        };
        let lit = rays.lit_grid();
        if lit.is_empty() {
            return Err(PictureRaysError::Dark(rays.system.name().to_owned()));
        }
        if centre == Centre::Nearest {
            let in_lens: Vec<LensRay> = lit.iter().map(|ray| rays.in_lens(ray)).collect();
            rays.centre_z_mm = nearest_on_axis_mm(&in_lens).unwrap_or(pupil_z_mm);
        }
        Ok(rays)
    }

    /// True if nothing but the distance from the axis counts.
    pub fn is_symmetric(&self) -> bool {
        self.system.is_rotationally_symmetric() && self.film.tilt_rad == 0.0 && self.film.swing_rad == 0.0
    }

    /// The point of the picture where the axis of the lens intersects the film, pixels.
    pub fn axis_px(&self) -> DVec2 {
        let [u, v] = self.film.shift_mm.map(|shift| -shift);
        let parts = DVec2::new(0.5 - u / self.picture_mm[0], 0.5 + v / self.picture_mm[1]);
        parts * DVec2::new(f64::from(self.size_px[0]), f64::from(self.size_px[1]))
    }

    /// The film point of a picture point, mm: the picture on the film is turned by half a turn.
    fn film_mm(&self, point_px: DVec2) -> DVec2 {
        let [w, h] = self.size_px.map(f64::from);
        DVec2::new((0.5 - point_px.x / w) * self.picture_mm[0], (point_px.y / h - 0.5) * self.picture_mm[1])
    }

    /// The ray of a picture point; `None`: there is none. `near`: that of a point beside it, and is set to this one's.
    fn ray(&self, point_px: DVec2, near: &mut Option<FilmChiefRay>) -> Option<PictureRay> {
        let film = self.film_mm(point_px);
        let found = self.chief.at(film, near.as_ref())?;
        *near = Some(found);
        Some(PictureRay {
            point_px,
            origin_mm: turned(found.scene.origin - DVec3::Z * self.centre_z_mm),
            direction: turned(found.scene.direction),
            is_lit: self.chief.is_through(film, &found),
            weight: 0.0,
        })
    }

    /// The ray of a picture point; `None`: there is none.
    pub fn at(&self, point_px: DVec2) -> Option<PictureRay> {
        self.ray(point_px, &mut None)
    }

    /// A ray in lens space.
    pub fn in_lens(&self, ray: &PictureRay) -> LensRay {
        LensRay { origin: turned(ray.origin_mm) + DVec3::Z * self.centre_z_mm, direction: turned(ray.direction) }
    }

    /// The rays of the nodes of a grid over the picture with its edges, by row from the top. Nodes without a ray are left out; weights are
    /// by the picture's area, and all of it has one.
    fn grid(&self, cells: u32) -> Vec<PictureRay> {
        let larger = f64::from(self.size_px[0].max(self.size_px[1]));
        let [columns, rows] =
            self.size_px.map(|side| ((f64::from(cells) * f64::from(side) / larger).ceil() as u32).max(4));
        let part = |i: u32, n: u32| f64::from(i) / f64::from(n);
        let share = |i: u32, n: u32| if i == 0 || i == n { 0.5 } else { 1.0 } / f64::from(n);
        let row = |j: u32| {
            let mut near = None;
            let of = |i: u32| {
                let parts = DVec2::new(part(i, columns), part(j, rows));
                let point = parts * DVec2::new(f64::from(self.size_px[0]), f64::from(self.size_px[1]));
                let ray = self.ray(point, &mut near);
                ray.map(|ray| PictureRay { weight: share(i, columns) * share(j, rows), ..ray })
            };
            (0..=columns).filter_map(of).collect::<Vec<_>>()
        };
        (0..=rows).into_par_iter().flat_map_iter(row).collect()
    }

    /// The rays of those nodes of a grid over the picture, with its edges, that the lens lights.
    pub fn lit_grid(&self) -> Vec<PictureRay> {
        let lit = |cells: u32| self.grid(cells).into_iter().filter(|ray| ray.is_lit).collect::<Vec<_>>();
        let found = lit(CELLS);
        // The picture of a lens in a film that is far too large is a small circle.
        if found.len() < FEW { lit(FINE_CELLS) } else { found }
    }

    /// The rays of the middles of all pixels, by row from the top; `None`: the lens does not light it.
    pub fn pixels(&self) -> Vec<Option<PictureRay>> {
        let row = |y: u32| {
            let mut near = None;
            let of = |x: u32| {
                let point = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                self.ray(point, &mut near).filter(|ray| ray.is_lit)
            };
            (0..self.size_px[0]).map(of).collect::<Vec<_>>()
        };
        (0..self.size_px[1]).into_par_iter().flat_map_iter(row).collect()
    }

    /// The direction from the centre of projection to where a ray is at a distance, mm, `None` for infinity: on the plane across the axis if
    /// `is_flat`, else on the sphere. `None`: it does not come there.
    pub fn direction_to(ray: &PictureRay, distance_mm: Option<f64>, is_flat: bool) -> Option<DVec3> {
        direction_at(ray.origin_mm, ray.direction, distance_mm, is_flat)
    }

    /// The distance at which the lens is sharp, from the centre of projection, mm; `None`: at infinity.
    pub fn sharp_mm(&self) -> Option<f64> {
        self.sharp_z_mm.map(|z| self.centre_z_mm - z)
    }
}

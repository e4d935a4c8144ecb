//! Gaussian properties of a lens at one wavelength (Wu et al. 2011, §3.2.2).

use serde::Serialize;

use crate::first_order::{ParaxialSurface, between_vertices, front_of, rear_of};
use crate::surface::Section;
use crate::system::System;

/// The image of the stop on one side of the lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pupil {
    /// Place of the pupil in lens space; `None`: at infinity (telecentric).
    pub z_mm: Option<f64>,
    /// Diameter of the pupil; `None`: infinite.
    pub diameter_mm: Option<f64>,
}

/// Principal and focal planes, pupils, focal length. Planes in lens space; lengths in mm; `None` is infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct Paraxial {
    /// Vacuum wavelength for which the other values hold.
    pub wavelength_nm: f64,
    /// Focal length on the image side, n′ / power; positive if the lens converges.
    pub efl_mm: Option<f64>,
    /// Distance from the last vertex to the image focal point, signed along z.
    pub bfd_mm: Option<f64>,
    /// Distance from the first vertex to the object focal point, signed along z.
    pub ffd_mm: Option<f64>,
    /// z of the object principal plane, of the scene's side.
    pub object_principal_plane_mm: Option<f64>,
    /// z of the image principal plane, of the film's side.
    pub image_principal_plane_mm: Option<f64>,
    /// z of the object focal plane, of the scene's side.
    pub object_focal_plane_mm: Option<f64>,
    /// z of the image focal plane, of the film's side.
    pub image_focal_plane_mm: Option<f64>,
    /// The stop seen from the scene.
    pub entrance_pupil: Pupil,
    /// The stop seen from the film.
    pub exit_pupil: Pupil,
    /// 1 / |power| over the diameter of the entrance pupil.
    pub f_number: Option<f64>,
    /// Diameter of the diaphragm's opening.
    pub stop_diameter_mm: f64,
    /// Image of infinity, or the published film plane for a lens without power.
    pub film_z_mm: f64,
    /// Radius of the Petzval surface, −1 / (n′ P); negative is hollow towards the lens.
    pub petzval_radius_mm: Option<f64>,
    /// Distance from the first vertex to the film.
    pub total_track_mm: f64,
    /// Number of surfaces of the lens.
    pub surfaces: usize,
}

/// Planes farther away than this many times the size of the lens are at infinity, and powers so small are none:
/// the rest is the rounding of sums that should be 0.
const INFINITE: f64 = 1e12;

impl Paraxial {
    /// The properties at a vacuum wavelength in nm, in the y-z plane.
    pub fn new(system: &System, wavelength_nm: f64) -> Self {
        Self::in_section(system, Section::Y, wavelength_nm)
    }

    /// The properties in one section; they differ if the lens has toroids. Decentres and tilts are left out.
    pub fn in_section(system: &System, section: Section, wavelength_nm: f64) -> Self {
        let surfaces = system.thin_in(section, wavelength_nm);
        let size = size_mm(system);
        let whole = between_vertices(&surfaces);
        let last_z = system.last_vertex_z_mm();
        let image_index = surfaces.last().map_or(1.0, |s| s.to);
        let finite = |x: f64| (x.abs() < INFINITE * size).then_some(x);
        let focal = finite(-1.0 / whole.c);
        let bfd_mm = focal.map(|f| whole.a * f * image_index);
        let ffd_mm = focal.map(|f| -whole.d * f);
        let entrance_pupil = entrance_pupil(system, &surfaces);
        let exit_pupil = exit_pupil(system, &surfaces);
        let f_number = focal.and_then(|f| Some(f.abs() / entrance_pupil.diameter_mm?));
        let last = surfaces.len().saturating_sub(1);
        let petzval: f64 = surfaces.iter().map(|s| s.curvature * (s.to - s.from) / (s.to * s.from)).sum::<f64>()
            + surfaces[..last].iter().map(|s| s.petzval_onward).sum::<f64>();
        let film_z_mm = bfd_mm.map_or(system.film_z_published_mm(), |bfd| last_z + bfd);
        Self {
            wavelength_nm,
            efl_mm: focal.map(|f| f * image_index.abs()),
            bfd_mm,
            ffd_mm,
            object_principal_plane_mm: focal.map(|f| f - whole.d * f),
            image_principal_plane_mm: focal.map(|f| last_z + (whole.a - 1.0) * f * image_index),
            object_focal_plane_mm: ffd_mm,
            image_focal_plane_mm: bfd_mm.map(|bfd| last_z + bfd),
            entrance_pupil,
            exit_pupil,
            f_number,
            stop_diameter_mm: 2.0 * system.stop_semi_diameter_mm(),
            film_z_mm,
            petzval_radius_mm: finite(-1.0 / (image_index * petzval)),
            total_track_mm: film_z_mm,
            surfaces: system.surface_count(),
        }
    }
}

/// The size of the lens, against which lengths count as infinite.
fn size_mm(system: &System) -> f64 {
    system.surfaces().iter().map(|s| s.thickness_mm.abs() + s.semi_diameter_mm).sum()
}

/// The stop through the surfaces before it: (y, ν) from the first vertex hits its centre if A y + B ν = 0.
fn entrance_pupil(system: &System, surfaces: &[ParaxialSurface]) -> Pupil {
    let front = front_of(surfaces, system.stop());
    let finite = |x: f64| (x.abs() < INFINITE * size_mm(system)).then_some(x);
    let diameter = 2.0 * system.stop_semi_diameter_mm();
    Pupil { z_mm: finite(front.b / front.a), diameter_mm: finite(diameter / front.a.abs()) }
}

/// The stop through itself and the surfaces after it: (0, ν) there leaves the last vertex as (B ν, D ν).
fn exit_pupil(system: &System, surfaces: &[ParaxialSurface]) -> Pupil {
    let rear = rear_of(surfaces, system.stop());
    let finite = |x: f64| (x.abs() < INFINITE * size_mm(system)).then_some(x);
    let image_index = surfaces.last().map_or(1.0, |s| s.to);
    let diameter = 2.0 * system.stop_semi_diameter_mm();
    let from_last = finite(-rear.b / rear.d * image_index);
    Pupil { z_mm: from_last.map(|z| system.last_vertex_z_mm() + z), diameter_mm: finite(diameter / rear.d.abs()) }
}

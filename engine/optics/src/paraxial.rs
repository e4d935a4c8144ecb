//! Gaussian properties and Seidel sums of a lens at one wavelength (Wu et al. 2011, §3.2.2).

use crate::first_order::{Thin, between_vertices, front_of, rear_of};
use crate::system::System;

/// The image of the stop on one side of the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pupil {
    /// Its place in lens space; `None`: at infinity (telecentric).
    pub z_mm: Option<f64>,
    /// Its diameter; `None`: infinite.
    pub diameter_mm: Option<f64>,
}

/// Everything that `petzval lens info` shows. Planes in lens space; lengths in mm; `None` is infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct Paraxial {
    /// Vacuum wavelength.
    pub wavelength_nm: f64,
    /// Focal length on the image side, n′ / power; positive if the lens converges.
    pub efl_mm: Option<f64>,
    /// From the last vertex to the image focal point, signed along z.
    pub bfd_mm: Option<f64>,
    /// From the first vertex to the object focal point, signed along z.
    pub ffd_mm: Option<f64>,
    /// Object principal plane.
    pub object_principal_plane_mm: Option<f64>,
    /// Image principal plane.
    pub image_principal_plane_mm: Option<f64>,
    /// Object focal plane.
    pub object_focal_plane_mm: Option<f64>,
    /// Image focal plane.
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
    /// Seidel sums S_I to S_V in mm, for the marginal ray at the present opening and [`Self::seidel_field_deg`].
    pub seidel: Option<[f64; 5]>,
    /// Field angle of the chief ray of the sums.
    pub seidel_field_deg: f64,
    /// From the first vertex to the film.
    pub total_track_mm: f64,
    /// Number of surfaces.
    pub surfaces: usize,
}

/// Seidel sums are taken at the design's half field, but no farther out than this: beyond, a third-order sum means
/// little.
const WIDEST_SEIDEL_FIELD_DEG: f64 = 30.0;
/// The field of the Seidel sums where a lens file does not say its own.
const USUAL_FIELD_DEG: f64 = 20.0;
/// Planes farther away than this many times the size of the lens are at infinity, and powers so small are none:
/// what is left is the rounding of sums that should be 0.
const INFINITE: f64 = 1e12;

impl Paraxial {
    /// The properties at a vacuum wavelength in nm.
    pub fn new(system: &System, wavelength_nm: f64) -> Self {
        let surfaces = system.thin(wavelength_nm);
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
        let petzval: f64 = surfaces.iter().map(|s| s.curvature * (s.to - s.from) / (s.to * s.from)).sum();
        let film_z_mm = bfd_mm.map_or(system.film_z_published_mm(), |bfd| last_z + bfd);
        let half_field = system.half_field_deg().filter(|d| *d > 0.0).unwrap_or(USUAL_FIELD_DEG);
        let seidel_field_deg = half_field.min(WIDEST_SEIDEL_FIELD_DEG);
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
            seidel: seidel(system, wavelength_nm, seidel_field_deg.to_radians()),
            seidel_field_deg,
            total_track_mm: film_z_mm,
            surfaces: system.surface_count(),
        }
    }
}

/// The size of the lens, against which lengths count as infinite.
fn size_mm(system: &System) -> f64 {
    system.surfaces().iter().map(|s| s.thickness_mm.abs() + s.semi_diameter_mm).sum()
}

/// The stop through the surfaces before it: (y, ν) from the first vertex meets its centre if A y + B ν = 0.
fn entrance_pupil(system: &System, surfaces: &[Thin]) -> Pupil {
    let front = front_of(surfaces, system.stop());
    let finite = |x: f64| (x.abs() < INFINITE * size_mm(system)).then_some(x);
    let diameter = 2.0 * system.stop_semi_diameter_mm();
    Pupil { z_mm: finite(front.b / front.a), diameter_mm: finite(diameter / front.a.abs()) }
}

/// The stop through itself and the surfaces after it: (0, ν) there leaves the last vertex as (B ν, D ν).
fn exit_pupil(system: &System, surfaces: &[Thin]) -> Pupil {
    let rear = rear_of(surfaces, system.stop());
    let finite = |x: f64| (x.abs() < INFINITE * size_mm(system)).then_some(x);
    let image_index = surfaces.last().map_or(1.0, |s| s.to);
    let diameter = 2.0 * system.stop_semi_diameter_mm();
    let from_last = finite(-rear.b / rear.d * image_index);
    Pupil { z_mm: from_last.map(|z| system.last_vertex_z_mm() + z), diameter_mm: finite(diameter / rear.d.abs()) }
}

/// Seidel sums S_I to S_V in mm for the marginal ray from infinity at the present opening and the chief ray from
/// `field_rad` (Welford, *Aberrations of Optical Systems*, §8; conics as fourth-order terms of the sag).
///
/// `None` if the entrance pupil is at infinity.
pub fn seidel(system: &System, wavelength_nm: f64, field_rad: f64) -> Option<[f64; 5]> {
    let surfaces = system.thin(wavelength_nm);
    let pupil = entrance_pupil(system, &surfaces);
    let (pupil_z, marginal) = (pupil.z_mm?, pupil.diameter_mm? / 2.0);
    let slope = field_rad.tan();
    let mut ray = [marginal, 0.0];
    let mut chief = [-pupil_z * slope, slope];
    let lagrange = chief[0] * ray[1] - chief[1] * ray[0];
    let mut sums = [0.0; 5];
    for (s, asphericity) in surfaces.iter().zip(system.surfaces().iter().map(|s| s.shape.asphericity())) {
        let refracted = |[y, nu]: [f64; 2]| [y, nu - y * s.curvature * (s.to - s.from)];
        let (ray2, chief2) = (refracted(ray), refracted(chief));
        let terms = surface_sums(s, asphericity, ray, ray2, chief, lagrange);
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += term;
        }
        let travel = |[y, nu]: [f64; 2]| [y + nu / s.to * s.thickness_mm, nu];
        (ray, chief) = (travel(ray2), travel(chief2));
    }
    Some(sums)
}

/// One surface's part. `ray` and `chief` are (y, n u) before it, `ray2` after it.
fn surface_sums(s: &Thin, asphericity: f64, ray: [f64; 2], ray2: [f64; 2], chief: [f64; 2], lagrange: f64) -> [f64; 5] {
    let (n, n2, c) = (s.from, s.to, s.curvature);
    let ([y, nu], [yc, nuc]) = (ray, chief);
    // Snell's invariants n i of both rays.
    let (a, ac) = (nu + n * c * y, nuc + n * c * yc);
    let delta = ray2[1] / (n2 * n2) - nu / (n * n);
    let inverse = 1.0 / n2 - 1.0 / n;
    let inverse_square = 1.0 / (n2 * n2) - 1.0 / (n * n);
    let asphere = asphericity * (n2 - n);
    [
        -a * a * y * delta + asphere * y.powi(4),
        -a * ac * y * delta + asphere * y.powi(3) * yc,
        -ac * ac * y * delta + asphere * y * y * yc * yc,
        -lagrange * lagrange * c * inverse,
        // The form without a division by A, which is 0 where the marginal ray meets the surface at right angles.
        -ac * (ac * ac * inverse_square * y - (ac * y - lagrange) * yc * c * inverse) + asphere * y * yc.powi(3),
    ]
}

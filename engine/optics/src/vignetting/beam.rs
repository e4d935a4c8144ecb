//! Rays of one field through a lens without its rims, and their distances from the rims.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};

use crate::field::{Field, Origin};
use crate::paraxial::Paraxial;
use crate::prescription::{Metadata, NextMedium, Place, Prescription, SurfaceRow};
use crate::system::{Element, LensSettings, Surface, System};
use crate::trace::Tracer;
use crate::vector::Vector;

/// Surfaces without a rim reach so many lengths of the lens from the axis, if their shape does.
const WITHOUT_RIM: f64 = 1e6;
/// Rays past the rim of the stop. More find a rim that cuts between them; the error goes with the square.
const RIM_RAYS: u32 = 64;
/// Rays are aimed to this part of the stop's radius.
const AIMED: f64 = 1e-9;
/// Newton's method is done or lost after so many steps, each halved so often before it is given up.
const MOST_STEPS: u32 = 30;
const MOST_HALVINGS: u32 = 12;
/// Slopes are taken over this part of the entrance pupil's radius.
const DIFFERENCE: f64 = 1e-5;
/// The reach that stands for a ray that is lost behind the stop, in radii of a rim.
pub(super) const LOST: f64 = 4.0;

/// The path of a ray.
pub(crate) struct RayPassage {
    /// The point at which it hits the stop, in radii of its opening.
    pub(crate) stop: DVec2,
    /// The ray's largest distance from the axis at the other surfaces, in radii of the rim there.
    pub(super) reach: f64,
    /// The surface where that is.
    pub(super) surface: usize,
    /// The point at which it hits the first surface.
    first: DVec3,
}

/// The rays past the rim of the stop.
pub(super) struct RimOfBeam {
    /// The points at which they hit the first surface: rays of a neighbouring field through the same places are near its own, however much
    /// the beam is foreshortened.
    pub(super) points: Vec<DVec3>,
    /// The largest reach of all.
    pub(super) reach: f64,
    /// The surface where that is.
    pub(super) surface: usize,
}

/// A lens without its rims.
pub(crate) struct RimlessLens<'a> {
    system: &'a System,
    pub(crate) tracer: Tracer,
    pub(crate) origin: Origin,
    pub(crate) pupil_radius_mm: f64,
}

impl<'a> RimlessLens<'a> {
    /// A probe for the object plane at `object_z_mm`; `None`: at infinity. There is no probe if the entrance pupil is there.
    pub(crate) fn new(system: &'a System, wavelength_nm: f64, object_z_mm: Option<f64>) -> Option<Self> {
        let pupil = Paraxial::new(system, wavelength_nm).entrance_pupil;
        Some(Self {
            system,
            tracer: without_rims(system)?.at_wavelength(wavelength_nm),
            origin: Origin { object_z_mm, pupil_z_mm: pupil.z_mm? },
            pupil_radius_mm: pupil.diameter_mm? / 2.0,
        })
    }

    /// No field is wider, in degrees: a plane is seen under less than 90.
    pub(super) fn widest_deg(&self) -> f64 {
        if self.origin.object_z_mm.is_some() { 89.9 } else { 180.0 }
    }

    /// The path of the ray of `field` that crosses its plane at `at`; the error is the index of the surface that ends it before the stop.
    pub(crate) fn pass(&self, field: &Field, at: DVec2) -> Result<RayPassage, usize> {
        let surfaces = self.system.surfaces();
        let mut hits = Vec::with_capacity(surfaces.len());
        let result = self.tracer.from_scene_recording(self.origin.ray(field, at), &mut hits);
        let stop = self.system.stop();
        let (reach, surface) = match result {
            Err(lost) if lost.surface <= stop => return Err(lost.surface),
            Err(lost) => (LOST, lost.surface),
            Ok(_) => (0.0, stop),
        };
        let mut passage = RayPassage { stop: DVec2::ZERO, reach, surface, first: hits[0] };
        passage.stop = from_axis(&surfaces[stop], hits[stop]) / self.system.stop_semi_diameter_mm();
        for (i, (s, hit)) in surfaces.iter().zip(&hits).enumerate().filter(|(i, _)| *i != stop) {
            let reach = from_axis(s, *hit).length() / s.semi_diameter_mm;
            if reach > passage.reach {
                (passage.reach, passage.surface) = (reach, i);
            }
        }
        Ok(passage)
    }

    /// The approximate points at which rays along the axis cross the plane of their field to pass the rim of the stop.
    pub(crate) fn paraxial_rim(&self) -> Vec<DVec2> {
        let spread = self.origin.object_z_mm.map_or(1.0, |z| z / (z - self.origin.pupil_z_mm));
        rim_targets().map(|target| target * (self.pupil_radius_mm * spread)).collect()
    }

    /// The rays of `field` past the rim of the stop, looked for from `starts`; a surface that keeps some from there.
    pub(super) fn rim_of_beam(&self, field: &Field, starts: &[DVec2]) -> Result<RimOfBeam, usize> {
        let mut rim = RimOfBeam { points: Vec::with_capacity(starts.len()), reach: 0.0, surface: self.system.stop() };
        for (target, start) in rim_targets().zip(starts) {
            let at = self.aim(field, target, *start)?;
            let passage = self.pass(field, at)?;
            if passage.reach > rim.reach {
                (rim.reach, rim.surface) = (passage.reach, passage.surface);
            }
            rim.points.push(passage.first);
        }
        Ok(rim)
    }

    /// The point at which the ray of `field` that hits the stop at `target` crosses its plane, by Newton's method from `start`; the error
    /// is a surface that keeps rays from there.
    pub(crate) fn aim(&self, field: &Field, target: DVec2, start: DVec2) -> Result<DVec2, usize> {
        let miss = |at: DVec2| self.pass(field, at).map(|passage| passage.stop - target);
        let difference = self.pupil_radius_mm * DIFFERENCE;
        let (mut at, mut off) = (start, miss(start)?);
        let mut in_the_way = self.system.stop();
        for _ in 0..MOST_STEPS {
            if off.length() <= AIMED {
                return Ok(at);
            }
            let slope = |axis: DVec2| miss(at + axis * difference).map(|missed| (missed - off) / difference);
            let step = DMat2::from_cols(slope(DVec2::X)?, slope(DVec2::Y)?).inverse() * -off;
            let mut nearer = |halvings: u32| {
                let next = at + step * 0.5f64.powi(halvings as i32);
                let missed = miss(next).inspect_err(|surface| in_the_way = *surface).ok()?;
                (missed.length() < off.length()).then_some((next, missed))
            };
            let Some(better) = (0..MOST_HALVINGS).find_map(&mut nearer) else { return Err(in_the_way) };
            (at, off) = better;
        }
        Err(in_the_way)
    }
}

/// Points of the rim of the stop, in its radii.
fn rim_targets() -> impl Iterator<Item = DVec2> {
    (0..RIM_RAYS).map(|i| DVec2::from_angle(TAU * f64::from(i) / f64::from(RIM_RAYS)))
}

/// A hit in lens space, from the axis of its surface.
fn from_axis(s: &Surface, hit: DVec3) -> DVec2 {
    s.pose.point_in(Vector::<f64>::from_f64(hit.with_z(hit.z - s.z_mm))).of(0).truncate()
}

/// A copy of the lens in which every surface is as large as its shape allows.
fn without_rims(system: &System) -> Option<System> {
    let size: f64 = system.surfaces().iter().map(|s| s.thickness_mm.abs() + s.semi_diameter_mm).sum();
    let row = |s: &Surface| SurfaceRow {
        shape: s.shape,
        pose: s.pose,
        thickness_mm: s.thickness_mm,
        behind: match &s.element {
            Element::Refract { to, .. } => NextMedium::Medium(to.clone()),
            Element::Reflect { .. } => NextMedium::Mirror,
        },
        semi_diameter_mm: s.shape.reach_mm().min(WITHOUT_RIM * size),
        obstruction_mm: 0.0,
        coating: Some(s.coating.clone()),
        place: Place::default(),
    };
    let prescription = Prescription {
        name: system.name().to_owned(),
        surfaces: system.surfaces().iter().map(row).collect(),
        stop: system.stop(),
        metadata: Metadata::default(),
        film_radius_mm: None,
        moving: None,
        source_file: String::new(),
    };
    System::new(&prescription, &LensSettings::default()).ok()
}

//! The image of a point by a lens, as designers report it: [`spot`]s, [`fan`]s, [`wavefront`]s, transfer functions ([`mtf`]), the
//! diffraction image of a point ([`psf`]), [`distortion`] with field curvature and lateral colour, and [`illumination`].
//!
//! All of it by exact rays. A field is a direction of view, counted at the entrance pupil; its light is a parallel beam, or comes
//! from a point of the plane that is sharp. On the film *tangential* is the direction of the field's azimuth, *sagittal* that at right
//! angles to it; at the azimuth of +y they are v and u.

pub mod distortion;
pub mod fan;
pub mod illumination;
pub mod mtf;
pub mod psf;
pub mod spot;
pub mod transmission;
pub mod wavefront;
mod waves;

use glam::{DVec2, DVec3};

use crate::autofocus::{Autofocus, AutofocusError, Subject};
use crate::drawing::Drawing;
use crate::field::{Field, Origin};
use crate::focus::{FilmFrame, FilmPlane, Focus};
use crate::system::System;
use crate::trace::{Ray, Tracer, Travel};
use crate::vignetting::{FieldWindow, RimlessLens};

/// Angles are not followed in shorter steps, in degrees.
const SHORTEST_STEP_DEG: f64 = 1e-3;

/// Light of one wavelength through the lens as it is set.
struct AnalysedWavelength<'a> {
    wavelength_nm: f64,
    tracer: Tracer,
    probe: RimlessLens<'a>,
}

/// A lens at one focus, looked at in some wavelengths.
pub struct Analysis<'a> {
    system: &'a System,
    focus: Focus,
    film: FilmPlane,
    lines: Vec<AnalysedWavelength<'a>>,
    main: usize,
    azimuth: DVec2,
}

/// A field, and the place where its beam enters the lens.
#[derive(Clone, Copy, Debug)]
struct FieldView {
    field: Field,
    window: FieldWindow,
}

/// A ray on the film.
#[derive(Clone, Copy, Debug)]
struct FilmHit {
    /// The ray behind the last surface.
    out: Ray,
    /// The point on the film, (u, v), mm.
    film: DVec2,
    /// The light it stands for; a point radiates as a matt surface does.
    weight: f64,
}

impl<'a> Analysis<'a> {
    /// The analysis for light of these vacuum wavelengths in nm, all of one weight; `main` is the number of that by which beams are found
    /// and distortion is counted. `azimuth_rad` is that of the fields, from +x towards +y.
    ///
    /// `None` where the entrance pupil lies at infinity, or there is no such wavelength: fields are counted at the pupil.
    pub fn new(
        system: &'a System,
        focus: Focus,
        wavelengths_nm: &[f64],
        main: usize,
        azimuth_rad: f64,
    ) -> Option<Self> {
        wavelengths_nm.get(main)?;
        let line = |&wavelength_nm: &f64| {
            let probe = RimlessLens::new(system, wavelength_nm, focus.object_plane_mm)?;
            Some(AnalysedWavelength { wavelength_nm, tracer: system.at_wavelength(wavelength_nm), probe })
        };
        let film = FilmPlane {
            curvature_per_mm: system.film_radius_mm().map_or(0.0, f64::recip),
            ..FilmPlane::upright(focus.film_z_mm)
        };
        let lines = wavelengths_nm.iter().map(line).collect::<Option<_>>()?;
        Some(Self { system, focus, film, lines, main, azimuth: DVec2::from_angle(azimuth_rad) })
    }

    /// The film at this z in lens space; the object plane stays.
    pub fn with_film_at(mut self, z_mm: f64) -> Self {
        self.film.z_mm = z_mm;
        self
    }

    /// The film where the spot of the axis is smallest, all wavelengths together, instead of the paraxial image.
    ///
    /// # Errors
    /// [`AutofocusError`].
    pub fn at_best_focus(mut self) -> Result<Self, AutofocusError> {
        let lines: Vec<(f64, f64)> = self.wavelengths_nm().map(|nm| (nm, 1.0)).collect();
        let subject = match self.focus.object_plane_mm {
            Some(z) => Subject::Point(DVec3::Z * z),
            None => Subject::Direction(DVec3::NEG_Z),
        };
        self.film.z_mm = Autofocus::new(self.system, &lines).film(subject, &self.film)?.film_z_mm;
        Ok(self)
    }

    /// The film on which rays are counted, in lens space: that of the focus, unless [`Self::with_film_at`] or [`Self::at_best_focus`] moved
    /// it.
    pub fn film(&self) -> FilmPlane {
        self.film
    }

    /// Half of the field that the lens is for, or as it stands sees: as [`crate::drawing::Drawing::usual_angles_deg`] has it.
    pub fn half_field_deg(&self) -> f64 {
        let angles = Drawing::usual_angles_deg(self.system, &self.focus, self.lines[self.main].wavelength_nm);
        angles.last().copied().unwrap_or(0.0)
    }

    /// The vacuum wavelengths of the analysis in nm, in the order in which they were given.
    pub fn wavelengths_nm(&self) -> impl Iterator<Item = f64> {
        self.lines.iter().map(|line| line.wavelength_nm)
    }

    /// Radius of the first dark ring of the diffraction pattern of a lens without aberrations, at the main wavelength, on the axis:
    /// 0.61 λ / NA. `None` without a working f-number.
    pub fn airy_radius_mm(&self) -> Option<f64> {
        let wavelength_mm = self.lines[self.main].wavelength_nm * 1e-6;
        self.focus.working_f_number.map(|f_number| 1.219_669_9 * wavelength_mm * f_number)
    }

    fn field(&self, angle_deg: f64) -> Field {
        Field::new(angle_deg.to_radians(), self.azimuth.to_array())
    }

    /// The field at an angle; `None` where nothing comes through from there. The beam is followed from the axis outwards, in steps
    /// that are halved where it is lost.
    fn view(&self, angle_deg: f64) -> Option<FieldView> {
        let probe = &self.lines[self.main].probe;
        let mut window = FieldWindow::about(probe.paraxial_rim().into_iter())?.find(probe, &self.field(0.0))?.window;
        let (mut here, mut step) = (0.0, angle_deg);
        while here != angle_deg {
            let next = if (angle_deg - here).abs() <= step.abs() { angle_deg } else { here + step };
            match window.find(probe, &self.field(next)) {
                Some(found) => {
                    (here, window) = (next, found.window);
                    step *= 2.0;
                }
                None if step.abs() < SHORTEST_STEP_DEG => return None,
                None => step *= 0.5,
            }
        }
        Some(FieldView { field: self.field(angle_deg), window })
    }

    /// Rays of a field, `side` by `side` evenly over its window, that come through at the line's wavelength and hit the film.
    fn landings(&self, line: usize, view: &FieldView, side: usize) -> Vec<FilmHit> {
        let AnalysedWavelength { tracer, probe, .. } = &self.lines[line];
        let mut bundle = tracer.bundle(Travel::FromScene);
        let mut weights = Vec::with_capacity(side * side);
        for i in 0..side * side {
            let ray = probe.origin.ray(&view.field, view.place([i % side, i / side], side));
            weights.push(weight(&probe.origin, &view.field, &ray));
            bundle.push(ray);
        }
        tracer.trace(&mut bundle);
        let frame = self.film.frame();
        let landing = |(i, weight): (usize, f64)| {
            let out = bundle.result(i).ok()?;
            Some(FilmHit { out, film: DVec2::from(frame.meet(&out)?), weight })
        };
        weights.into_iter().enumerate().filter_map(landing).collect()
    }

    /// The point at which the ray through the middle of the stop crosses the plane of its field, at the line's wavelength, whether a rim
    /// stops it or not; `None`: there is no such ray.
    fn chief(&self, line: usize, view: &FieldView) -> Option<DVec2> {
        self.lines[line].probe.aim(&view.field, DVec2::ZERO, view.window.centre).ok()
    }

    /// The chief ray of a view as it leaves the lens, at the line's wavelength.
    fn chief_out(&self, line: usize, view: &FieldView) -> Option<Ray> {
        let probe = &self.lines[line].probe;
        probe.tracer.from_scene(probe.origin.ray(&view.field, self.chief(line, view)?)).ok()
    }

    /// (u, v) by sagittal and tangential parts.
    fn turned(&self, film: DVec2) -> DVec2 {
        // As a reader has it: the tangential direction upwards, the sagittal to the right.
        DVec2::new(film.dot(self.sagittal()), film.dot(self.azimuth))
    }

    fn sagittal(&self) -> DVec2 {
        -self.azimuth.perp()
    }

    /// The film where it is touched at (u, v).
    fn touching(&self, film: DVec2) -> Touching {
        let frame = self.film.frame();
        Touching::new(&frame, film, [self.sagittal(), self.azimuth])
    }
}

impl FieldView {
    /// The middle of a cell of the window, of `side` by `side`.
    fn place(&self, cell: [usize; 2], side: usize) -> DVec2 {
        let unit = |i: usize| (2 * i + 1) as f64 / side as f64 - 1.0;
        self.window.centre + self.window.half * DVec2::new(unit(cell[0]), unit(cell[1]))
    }
}

/// Light of a place of the field's plane: by the solid angle, seen from a point, and the slant of the surface that it lies on.
fn weight(origin: &Origin, field: &Field, ray: &Ray) -> f64 {
    if origin.object_z_mm.is_none() {
        return 1.0;
    }
    let slant = ray.direction.dot(field.along) / field.along.z.abs().max(f64::MIN_POSITIVE);
    ray.direction.z.abs() * slant.powi(3)
}

/// The plane that touches the film at a place, in lens space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touching {
    /// The point of contact on the film, in lens space, mm.
    point: DVec3,
    /// Unit vectors in the plane.
    sagittal: DVec3,
    tangential: DVec3,
}

impl Touching {
    /// The plane that touches the film at (u, v), with directions of the film's coordinates that are to lie in the plane.
    pub(crate) fn new(frame: &FilmFrame, film: DVec2, [sagittal, tangential]: [DVec2; 2]) -> Self {
        let place = frame.at(film.x, film.y);
        // Of the film's own two directions what lies in the plane: light that comes along the axis sees them as they are.
        let along = |d: DVec2| d.extend(0.0).reject_from_normalized(place.normal).normalize_or(DVec3::X);
        let tangential = along(tangential);
        // At right angles to it, also where the film is steep in between.
        let side = along(sagittal);
        let sagittal = side.reject_from_normalized(tangential).normalize_or(DVec3::X);
        Self { point: place.point, sagittal, tangential }
    }

    /// The point at which a ray crosses the plane: sagittal and tangential, mm.
    fn crossing(&self, ray: &Ray) -> DVec2 {
        let normal = self.sagittal.cross(self.tangential);
        let t = (self.point - ray.origin).dot(normal) / ray.direction.dot(normal);
        let from = ray.origin + ray.direction * t - self.point;
        DVec2::new(from.dot(self.sagittal), from.dot(self.tangential))
    }

    /// Cosines of a direction to the sagittal and the tangential direction.
    pub(crate) fn cosines(&self, direction: DVec3) -> DVec2 {
        DVec2::new(direction.dot(self.sagittal), direction.dot(self.tangential))
    }

    /// The vector in the plane with these sagittal and tangential cosines.
    pub(crate) fn direction(&self, cosines: DVec2) -> DVec3 {
        self.sagittal * cosines.x + self.tangential * cosines.y
    }

    /// The place, lens space.
    pub(crate) fn point(&self) -> DVec3 {
        self.point
    }
}

/// Sum of weights and the mean place.
fn centroid(landings: impl Iterator<Item = (DVec2, f64)>) -> (f64, DVec2) {
    let (sum, at) = landings.fold((0.0, DVec2::ZERO), |(sum, at), (film, w)| (sum + w, at + film * w));
    (sum, if sum > 0.0 { at / sum } else { DVec2::ZERO })
}

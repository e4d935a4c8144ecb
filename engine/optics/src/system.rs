//! A lens placed in lens space for one focal length and one opening; immutable.

mod groups;

use std::sync::Arc;

use serde::Deserialize;
use thiserror::Error;

use crate::coating::{Coating, Split, parts_glass_from_air};
use crate::diaphragm::{ApertureMask, Diaphragm, DiaphragmError};
use crate::first_order::{Matrix, ParaxialSurface, between_vertices, front_of};
use crate::glass::{Medium, line_nm};
use crate::prescription::{NextMedium, Prescription, PrescriptionError};
use crate::surface::{Pose, Section, Shape};

/// The focal length that the lens is scaled to: radii, thicknesses and apertures all scale (Wu et al. 2011, §4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum FocalLength {
    /// The focal length of the lens file.
    #[default]
    AsPublished,
    /// The focal length of the lens file times this factor.
    Scale(f64),
    /// The focal length at d, n′ / power, in mm: a zoom lens is zoomed to it, another is scaled.
    Millimetres(f64),
}

/// The user's settings of a lens. The default: as published, wide open, round, coated as its file says.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LensSettings {
    /// The focal length to which the lens is zoomed or scaled.
    pub focal_length: FocalLength,
    /// |efl| / diameter of the entrance pupil at d; `None`: wide open.
    pub f_number: Option<f64>,
    /// The diameter of the entrance pupil at d, mm, as it is given for eyes; it goes before the f-number.
    pub pupil_diameter_mm: Option<f64>,
    /// Blades of the diaphragm; fewer than 3: round.
    pub blades: u32,
    /// Turn of the diaphragm, from x towards y.
    pub blade_rotation_rad: f64,
    /// Curvature of the blades: 0 straight, 1 the full circle.
    pub blade_curvature: f64,
    /// A mask in the diaphragm instead of blades, turned like them.
    pub aperture_mask: Option<Arc<ApertureMask>>,
    /// Thin films wherever glass meets air; `None`: as the lens file has them.
    pub coating: Option<Coating>,
}

impl LensSettings {
    /// These settings with the stop at another f-number, `None` for wide open, whatever set it before.
    #[must_use]
    pub fn opened(self, f_number: Option<f64>) -> Self {
        Self { f_number, pupil_diameter_mm: None, ..self }
    }
}

/// An error by which no system can be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SystemError {
    /// The prescription makes no lens.
    #[error(transparent)]
    Prescription(#[from] PrescriptionError),
    /// Scale or focal length is not a positive number.
    #[error("the {what} is {value}; give a number larger than 0")]
    NotPositive {
        /// The name of the setting in the message.
        what: &'static str,
        /// The value of the setting.
        value: f64,
    },
    /// The blades make no diaphragm.
    #[error(transparent)]
    Diaphragm(#[from] DiaphragmError),
    /// The lens does not focus parallel light, so no focal length or f-number can be asked of it.
    #[error("the lens has no focal length (its power is 0); scale it by a factor and leave the f-number to it")]
    Afocal,
    /// A zoom does not reach the focal length.
    #[error(
        "the lens zooms from {from_mm:.1} to {to_mm:.1} mm, and {asked_mm} mm were asked for; stay within, or scale the lens"
    )]
    BeyondZoom {
        /// The focal length that was asked for.
        asked_mm: f64,
        /// The shortest focal length of the lens.
        from_mm: f64,
        /// The longest focal length of the lens.
        to_mm: f64,
    },
}

/// Powers below this part of 1/track are rounding.
const NO_POWER: f64 = 1e-12;

/// The action of a surface on light.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    /// Refraction between media, which may be the same.
    Refract {
        /// Medium on the scene side.
        from: Medium,
        /// Medium on the film side.
        to: Medium,
    },
    /// Reflection in a medium.
    Reflect {
        /// The medium that the light stays in.
        medium: Medium,
    },
}

impl Element {
    /// The medium on the film side, seen from this surface; of a mirror that on both sides.
    pub fn behind(&self) -> &Medium {
        match self {
            Self::Refract { to: medium, .. } | Self::Reflect { medium } => medium,
        }
    }
}

/// One surface in its place. Lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Shape of the surface.
    pub shape: Shape,
    /// Pose of the surface at its place on the axis.
    pub pose: Pose,
    /// Vertex in lens space.
    pub z_mm: f64,
    /// Signed distance to the next vertex; the last to the film as published.
    pub thickness_mm: f64,
    /// Half of the clear diameter.
    pub semi_diameter_mm: f64,
    /// Half of the diameter of a central obstruction, or 0.
    pub obstruction_mm: f64,
    /// Refraction or reflection at the surface, with the media beside it.
    pub element: Element,
    /// Thin films on the surface.
    pub coating: Coating,
}

impl Surface {
    /// The split of light of a vacuum wavelength that comes to the surface under an angle with this cosine, from the scene's side or from
    /// the film's. A mirror of which nothing is known reflects everything; a gradient counts by its index on the axis.
    pub fn split(&self, wavelength_nm: f64, cos_incidence: f64, towards_film: bool) -> Split {
        let (from, to) = match &self.element {
            Element::Refract { from, to } => (from, to),
            Element::Reflect { medium } => {
                return self.coating.mirrored(medium.index(wavelength_nm).abs(), wavelength_nm, cos_incidence);
            }
        };
        let indices = [from, to].map(|medium| medium.index(wavelength_nm).abs());
        let [from, to] = if towards_film { indices } else { [indices[1], indices[0]] };
        self.coating.split(from, to, wavelength_nm, cos_incidence)
    }
}

fn is_glass_in_air(element: &Element) -> bool {
    matches!(element, Element::Refract { from, to } if parts_glass_from_air(from, to))
}

/// A lens in lens space: z = 0 at the first vertex, light travels towards +z, millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    name: String,
    surfaces: Vec<Surface>,
    stop: usize,
    diaphragm: Diaphragm,
    scale: f64,
    widest_f_number: Option<f64>,
    f_number: Option<f64>,
    requested_f_number: Option<f64>,
    film_radius_mm: Option<f64>,
    half_field_deg: Option<f64>,
}

impl System {
    /// Scales the prescription and closes its diaphragm.
    ///
    /// An f-number smaller than the clear aperture of the stop allows is clamped to the widest one:
    /// [`Self::f_number_was_clamped`] says so. Groups that move stand where infinity is sharp.
    pub fn new(prescription: &Prescription, settings: &LensSettings) -> Result<Self, SystemError> {
        if let Some(moving) = &prescription.moving {
            return Self::with_groups(prescription, moving, settings, 0.0);
        }
        prescription.check()?;
        check_settings(settings)?;
        let published = place(prescription, 1.0);
        let scale = match settings.focal_length {
            FocalLength::AsPublished => 1.0,
            FocalLength::Scale(factor) => factor,
            FocalLength::Millimetres(f) => {
                let image_index = image_index(&published, line_nm::D);
                f / (image_index * focal_length_mm(&published).ok_or(SystemError::Afocal)?).abs()
            }
        };
        let surfaces = if scale == 1.0 { published } else { place(prescription, scale) };
        let stop = prescription.stop;
        let clear = surfaces[stop].semi_diameter_mm;
        let widest_f_number = widest_f_number(&surfaces, stop);
        // The f-number is the focal length over the pupil's diameter.
        let of_pupil = settings.pupil_diameter_mm.and_then(|mm| Some(focal_length_mm(&surfaces)?.abs() / mm));
        if settings.pupil_diameter_mm.is_some() && of_pupil.is_none() {
            return Err(SystemError::Afocal);
        }
        let asked = of_pupil.or(settings.f_number);
        let f_number = match (asked, widest_f_number) {
            (None, widest) => widest,
            (Some(asked), Some(widest)) => Some(asked.max(widest)),
            (Some(_), None) => return Err(SystemError::Afocal),
        };
        let opening = match (f_number, widest_f_number) {
            (Some(now), Some(widest)) => clear * (widest / now),
            _ => clear,
        };
        let diaphragm = diaphragm(settings, opening)?;
        let system = Self {
            name: prescription.name.clone(),
            surfaces,
            stop,
            diaphragm,
            scale,
            widest_f_number,
            f_number,
            requested_f_number: asked,
            film_radius_mm: prescription.film_radius_mm.map(|r| r * scale),
            half_field_deg: prescription.metadata.half_field_deg,
        };
        Ok(match &settings.coating {
            Some(coating) => system.coated(coating),
            None => system,
        })
    }

    /// This lens with a mask in its diaphragm instead of blades, turned by `rotation_rad` from x towards y.
    pub fn with_aperture_mask(mut self, mask: Arc<ApertureMask>, rotation_rad: f64) -> Result<Self, SystemError> {
        if !rotation_rad.is_finite() {
            return Err(DiaphragmError::Rotation(rotation_rad).into());
        }
        self.diaphragm = Diaphragm::masked(self.diaphragm.radius_mm(), mask, rotation_rad);
        Ok(self)
    }

    /// This lens with another coating wherever glass meets air.
    #[must_use]
    pub fn coated(mut self, coating: &Coating) -> Self {
        for surface in &mut self.surfaces {
            if is_glass_in_air(&surface.element) {
                surface.coating = coating.clone();
            }
        }
        self
    }

    /// The names of the coatings on surfaces where glass meets air, and on mirrors, each once.
    pub fn coatings(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for surface in &self.surfaces {
            let is_mirror = matches!(surface.element, Element::Reflect { .. });
            let name = surface.coating.name();
            if (is_glass_in_air(&surface.element) || is_mirror) && !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        names
    }

    /// The name of the lens: that in its file, else that of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of surfaces, the stop among them.
    pub fn surface_count(&self) -> usize {
        self.surfaces.len()
    }

    /// The surfaces, scene side first.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Index of the surface with the diaphragm.
    pub fn stop(&self) -> usize {
        self.stop
    }

    /// The diaphragm's opening as it is set.
    pub fn diaphragm(&self) -> &Diaphragm {
        &self.diaphragm
    }

    /// Vertex of surface `i` (less than [`Self::surface_count`]) in lens space, mm.
    pub fn vertex_z_mm(&self, i: usize) -> f64 {
        self.surfaces[i].z_mm
    }

    fn last(&self) -> &Surface {
        &self.surfaces[self.surfaces.len() - 1]
    }

    /// Vertex of the last surface in lens space, mm.
    pub fn last_vertex_z_mm(&self) -> f64 {
        self.last().z_mm
    }

    /// Half of the clear diameter of the last surface, mm.
    pub fn rear_radius_mm(&self) -> f64 {
        self.last().semi_diameter_mm
    }

    /// The film's place as published, in lens space, mm.
    pub fn film_z_published_mm(&self) -> f64 {
        self.last().z_mm + self.last().thickness_mm
    }

    /// Radius of the film's curvature in mm, signed as a surface's; `None`: plane.
    pub fn film_radius_mm(&self) -> Option<f64> {
        self.film_radius_mm
    }

    /// Half of the field of view that the design is for, in degrees, where the file says so.
    pub fn half_field_deg(&self) -> Option<f64> {
        self.half_field_deg
    }

    /// Radius of the diaphragm's opening in mm: of the circle through the corners, if it has blades.
    pub fn stop_semi_diameter_mm(&self) -> f64 {
        self.diaphragm.radius_mm()
    }

    /// |efl| / diameter of the entrance pupil at d, with the stop at its clear aperture; infinite without power.
    ///
    /// A rim in front of the stop may limit the axial beam further.
    pub fn widest_f_number(&self) -> f64 {
        self.widest_f_number.unwrap_or(f64::INFINITY)
    }

    /// The f-number in force, at d; infinite without power.
    pub fn f_number(&self) -> f64 {
        self.f_number.unwrap_or(f64::INFINITY)
    }

    /// True if a wider opening was asked for than the clear aperture of the stop allows.
    pub fn f_number_was_clamped(&self) -> bool {
        matches!((self.requested_f_number, self.f_number), (Some(asked), Some(now)) if asked < now)
    }

    /// The factor from published millimetres to those of this system.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The direction in which light arrives at the film along the axis: +1, or −1 after an odd number of mirrors.
    pub fn light_direction_at_film(&self) -> f64 {
        let mirrors = self.surfaces.iter().filter(|s| matches!(s.element, Element::Reflect { .. })).count();
        if mirrors % 2 == 0 { 1.0 } else { -1.0 }
    }

    /// Index of the medium before the film.
    pub fn image_index(&self, wavelength_nm: f64) -> f64 {
        image_index(&self.surfaces, wavelength_nm)
    }

    /// True if nothing changes when the lens is turned about its axis, but for the blades of the diaphragm: no surface
    /// is a toroid, none is decentred or tilted.
    pub fn is_rotationally_symmetric(&self) -> bool {
        self.surfaces.iter().all(|s| s.shape.is_rotationally_symmetric() && s.pose.is_identity())
    }

    /// True if the path of a ray depends on its wavelength.
    pub fn is_dispersive(&self) -> bool {
        let ends = [line_nm::F, line_nm::C];
        self.surfaces.iter().any(|s| match &s.element {
            Element::Refract { from, to } => {
                let [a, b] = ends.map(|nm| from.index(nm) / to.index(nm));
                a != b
            }
            Element::Reflect { .. } => false,
        })
    }

    /// True if the index of some medium changes from place to place.
    pub fn has_gradients(&self) -> bool {
        self.surfaces.iter().any(|s| s.element.behind().gradient().is_some())
    }

    /// The surfaces as Gaussian optics sees them, in the y-z plane.
    pub(crate) fn thin(&self, wavelength_nm: f64) -> Vec<ParaxialSurface> {
        self.thin_in(Section::Y, wavelength_nm)
    }

    /// The surfaces as Gaussian optics sees them in one section. Decentres and tilts are left out.
    pub(crate) fn thin_in(&self, section: Section, wavelength_nm: f64) -> Vec<ParaxialSurface> {
        thin(&self.surfaces, section, wavelength_nm)
    }
}

/// The diaphragm of these settings in a stop of this radius, mm.
fn diaphragm(settings: &LensSettings, radius_mm: f64) -> Result<Diaphragm, DiaphragmError> {
    let (curvature, rotation_rad) = (settings.blade_curvature, settings.blade_rotation_rad);
    let bladed = Diaphragm::checked(radius_mm, settings.blades, curvature, rotation_rad)?;
    Ok(match &settings.aperture_mask {
        Some(mask) => Diaphragm::masked(radius_mm, mask.clone(), rotation_rad),
        None => bladed,
    })
}

fn check_settings(settings: &LensSettings) -> Result<(), SystemError> {
    let positive = |what, value: f64| {
        let good = value.is_finite() && value > 0.0;
        if good { Ok(()) } else { Err(SystemError::NotPositive { what, value }) }
    };
    match settings.focal_length {
        FocalLength::AsPublished => {}
        FocalLength::Scale(factor) => positive("scale of the lens", factor)?,
        FocalLength::Millimetres(f) => positive("focal length in mm", f)?,
    }
    if let Some(f_number) = settings.f_number {
        positive("f-number", f_number)?;
    }
    if let Some(diameter_mm) = settings.pupil_diameter_mm {
        positive("pupil's diameter in mm", diameter_mm)?;
    }
    Ok(())
}

fn place(prescription: &Prescription, scale: f64) -> Vec<Surface> {
    let mut z_mm = 0.0;
    let mut medium = Medium::air();
    let assumed = prescription.assumed_coating();
    let mut placed = Vec::with_capacity(prescription.surfaces.len());
    for row in &prescription.surfaces {
        let element = match &row.behind {
            NextMedium::Mirror => Element::Reflect { medium: medium.clone() },
            NextMedium::Medium(to) => {
                let to = if scale == 1.0 { to.clone() } else { to.scaled(scale) };
                Element::Refract { from: medium, to }
            }
        };
        // As the next surface sees it.
        medium = element.behind().seen_from(row.thickness_mm * scale);
        placed.push(Surface {
            shape: if scale == 1.0 { row.shape } else { row.shape.scaled(scale) },
            pose: row.pose.scaled(scale),
            z_mm,
            thickness_mm: row.thickness_mm * scale,
            semi_diameter_mm: row.semi_diameter_mm * scale,
            obstruction_mm: row.obstruction_mm * scale,
            coating: match &row.coating {
                None if is_glass_in_air(&element) => assumed.clone(),
                known => known.clone().unwrap_or_default(),
            },
            element,
        });
        z_mm += row.thickness_mm * scale;
    }
    placed
}

fn thin(surfaces: &[Surface], section: Section, wavelength_nm: f64) -> Vec<ParaxialSurface> {
    let mut sign = 1.0;
    let one = |s: &Surface| {
        let (from, to) = match &s.element {
            Element::Refract { from, to } => (sign * from.index(wavelength_nm), sign * to.index(wavelength_nm)),
            Element::Reflect { medium } => {
                let index = sign * medium.index(wavelength_nm);
                sign = -sign;
                (index, -index)
            }
        };
        let behind = s.element.behind();
        let (onward, petzval_onward) = match behind.gradient() {
            None => (Matrix::travel(s.thickness_mm, to), 0.0),
            Some(gradient) => gradient.paraxial(behind.base_index(wavelength_nm).copysign(to), s.thickness_mm),
        };
        ParaxialSurface { curvature: s.shape.curvature_at_vertex(section), from, to, onward, petzval_onward }
    };
    surfaces.iter().map(one).collect()
}

/// Index of the last medium; of air if there is no surface.
fn image_index(surfaces: &[Surface], wavelength_nm: f64) -> f64 {
    surfaces.last().map_or(1.0, |s| s.element.behind().index(wavelength_nm))
}

/// 1 / power at d in mm; `None` without power.
fn focal_length_mm(surfaces: &[Surface]) -> Option<f64> {
    let power = -between_vertices(&thin(surfaces, Section::Y, line_nm::D)).c;
    let track: f64 = surfaces.iter().map(|s| s.thickness_mm.abs() + s.semi_diameter_mm).sum();
    (power.abs() * track > NO_POWER).then(|| 1.0 / power)
}

/// |efl| / diameter of the entrance pupil at d.
///
/// The entrance pupil is the stop seen through the surfaces before it: a ray of height y there hits the stop at
/// the height A y, so the pupil's diameter is the stop's over |A|.
fn widest_f_number(surfaces: &[Surface], stop: usize) -> Option<f64> {
    let thin = thin(surfaces, Section::Y, line_nm::D);
    let magnification = front_of(&thin, stop).a.abs();
    let f_number = focal_length_mm(surfaces)?.abs() * magnification / (2.0 * surfaces[stop].semi_diameter_mm);
    f_number.is_finite().then_some(f_number)
}

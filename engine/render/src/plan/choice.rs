//! The simulation of a camera that a plan has chosen.

use super::PlanOptions;
use crate::camera::lens::setup::D_LINE_NM;
use crate::camera::{CameraDescription, EnabledEffects, Model, Spectrum};
use crate::pipeline::Pipeline;
use petzval_optics::system::LensSettings;

/// The kind of camera that stands for the one that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraKind {
    /// The camera as it was given: it has no lens that could be planned.
    Given,
    /// The lens, every ray traced through its surfaces.
    Exact,
    /// Gaussian optics: by the measure, nothing that they leave out can be seen.
    Gaussian,
    /// A pinhole: everything is sharp.
    Pinhole {
        /// Focal length of the pinhole that frames the same picture, mm.
        focal_length_mm: f64,
        /// Width of the film, mm.
        film_width_mm: f64,
        /// The shift, as Blender counts it.
        shift: [f64; 2],
    },
}

impl CameraKind {
    /// Name of the camera model in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Given => "as given",
            Self::Exact => "exact",
            Self::Gaussian => "gaussian",
            Self::Pinhole { .. } => "pinhole",
        }
    }
}

/// The simulation of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraChoice {
    /// The kind of camera that makes the rays.
    pub way: CameraKind,
    /// The pipeline by which samples are made.
    pub pipeline: Pipeline,
    /// Wavelengths of the film; `None` is one wavelength.
    pub spectrum: Option<Spectrum>,
    /// F-number of a round opening of equal area, if the opening's shape does not matter.
    pub round_f_number: Option<f64>,
    /// The effects of the traced lens that are shown.
    pub shown: EnabledEffects,
    /// True if samples are taken all through the time that the shutter is open.
    pub is_moving: bool,
    /// True if reflections between the lens's surfaces are looked for.
    pub ghosts: bool,
    /// True if the picture is spread by [`crate::stray::diffraction`], of the camera as it was given.
    pub diffraction: bool,
    /// True if the picture is spread by [`crate::stray::glare`].
    pub glare: bool,
    /// True if light is lost at surfaces and in glasses.
    pub transmission: bool,
}

impl CameraChoice {
    /// The camera as it is.
    pub(super) fn given(wishes: &PlanOptions, is_moving: bool, has_colours: bool, transmission: bool) -> Self {
        Self {
            way: CameraKind::Given,
            pipeline: wishes.pipeline.of_packets(None),
            spectrum: has_colours.then_some(Spectrum::Visible),
            round_f_number: None,
            shown: EnabledEffects::default(),
            is_moving,
            ghosts: false,
            diffraction: false,
            glare: false,
            transmission,
        }
    }

    /// Wavelengths that the film tells apart.
    pub fn wavelengths(&self) -> usize {
        self.spectrum.map_or(1, Spectrum::count)
    }

    pub(super) fn applied(&self, d: &CameraDescription) -> CameraDescription {
        if self.way == CameraKind::Given {
            let line_nm = d.wavelength_nm.or(self.spectrum.is_none().then_some(D_LINE_NM));
            let (shown, transmission) = (self.shown, self.transmission);
            return CameraDescription { wavelength_nm: line_nm, shown, transmission, ..d.clone() };
        }
        let mut d = CameraDescription { shown: self.shown, transmission: self.transmission, ..d.clone() };
        match self.spectrum {
            Some(spectrum) => (d.spectrum, d.wavelength_nm) = (spectrum, None),
            None => d.wavelength_nm = Some(d.wavelength_nm.unwrap_or(D_LINE_NM)),
        }
        if self.round_f_number.is_some() {
            d.lens = LensSettings { blades: 0, aperture_mask: None, ..d.lens }.opened(self.round_f_number);
        }
        match self.way {
            CameraKind::Given | CameraKind::Exact => {}
            CameraKind::Gaussian => d.model = Model::Thick,
            CameraKind::Pinhole { focal_length_mm, film_width_mm, shift } => {
                d.model = Model::Pinhole;
                (d.perspective.focal_length_mm, d.perspective.film_width_mm) = (focal_length_mm, film_width_mm);
                d.perspective.shift = shift;
            }
        }
        d
    }
}

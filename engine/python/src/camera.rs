//! Camera descriptions, read by attribute.

use crate::error::{Error, bad_camera, invalid};
use crate::gil::without_gil;
use crate::setting::coating;
use glam::{DMat4, DVec3};
use petzval_optics::diaphragm::ApertureMask;
use petzval_optics::focus::{Anchor, Focusing, Relation};
use petzval_render::camera::exposure::PhysicalExposure;
use petzval_render::camera::precision::Precision;
use petzval_render::camera::scattering::Scattering;
use petzval_render::camera::{self, CameraDescription, EnabledEffects, Model, Spectrum};
use pyo3::prelude::*;
use serde_json::json;
use std::sync::Arc;

/// A 4 x 4 matrix as Blender gives it, row by row.
#[derive(FromPyObject)]
#[pyo3(transparent)]
pub(crate) struct Matrix4([[f64; 4]; 4]);

impl From<Matrix4> for DMat4 {
    fn from(m: Matrix4) -> Self {
        DMat4::from_cols_array_2d(&m.0).transpose()
    }
}

/// A square grey picture: eight bits a value, rows from below.
#[derive(FromPyObject)]
pub(crate) struct PyApertureMask {
    name: String,
    side: usize,
    values: Vec<u8>,
}

impl PyApertureMask {
    /// `whose` names what has the mask, for messages.
    pub(crate) fn read(&self, whose: &str) -> Result<Arc<ApertureMask>, Error> {
        let values: Vec<f32> = self.values.iter().map(|&value| f32::from(value) / 255.0).collect();
        let mask = ApertureMask::new(self.side, &values);
        mask.map(Arc::new).map_err(|e| bad_camera(format!("{whose}, image '{}': {e}", self.name)))
    }
}

#[derive(FromPyObject)]
pub(crate) struct PyCamera {
    object_name: String,
    model: String,
    matrix_world: Matrix4,
    pinhole_focal_length_mm: f64,
    pinhole_film_width_mm: f64,
    pinhole_shift: (f64, f64),
    pixel_aspect: f64,
    lens_path: String,
    focal_length_mm: Option<f64>,
    focal_scale: Option<f64>,
    f_number: Option<f64>,
    pupil_diameter_mm: Option<f64>,
    blades: u32,
    blade_rotation_rad: f64,
    blade_curvature: f64,
    aperture_mask: Option<PyApertureMask>,
    coating: Option<String>,
    exposes_by_f_number: bool,
    focus_distance: Option<f64>,
    anchor: String,
    focus_relation: String,
    focus_point_world: Option<(f64, f64, f64)>,
    film_distance_mm: Option<f64>,
    film_width_mm: f64,
    film_height_mm: f64,
    tilt_rad: f64,
    swing_rad: f64,
    shift_mm: (f64, f64),
    scale_mm_per_unit: (f64, f64, f64),
    wavelength_nm: Option<f64>,
    spectrum: String,
    precision: String,
    roughness_nm: f64,
    cleanliness: f64,
    veiling_index: f64,
    /// Shutter (s), film speed (ISO), lumens of a watt.
    exposure: Option<(f64, f64, f64)>,
    orthographic_width: f64,
    clip: (f64, f64),
}

impl TryFrom<PyCamera> for CameraDescription {
    type Error = Error;

    fn try_from(c: PyCamera) -> Result<Self, Error> {
        let model = match c.model.as_str() {
            "LENS" => Model::Lens,
            "PINHOLE" => Model::Pinhole,
            "THIN" => Model::Thin,
            "THICK" => Model::Thick,
            "PARAXIAL" => Model::Paraxial,
            "IMAGE_BASED" => Model::ImageBased,
            "ORTHOGRAPHIC" => Model::Orthographic,
            other => {
                return Err(invalid(format!(
                    "camera '{}': there is no camera model '{other}'; use LENS, IMAGE_BASED, PARAXIAL, THICK, THIN, PINHOLE or ORTHOGRAPHIC",
                    c.object_name
                )));
            }
        };
        let spectrum = match c.spectrum.as_str() {
            "VISIBLE" => Spectrum::Visible,
            "THREE" => Spectrum::Three,
            other => {
                let what = format!("camera '{}': there is no spectrum '{other}'; use VISIBLE or THREE", c.object_name);
                return Err(invalid(what));
            }
        };
        let precision = match c.precision.as_str() {
            "AUTO" => Precision::Auto,
            "F32" => Precision::Single,
            "F64" => Precision::Double,
            other => {
                let what = format!("camera '{}': there is no precision '{other}'; use AUTO, F32 or F64", c.object_name);
                return Err(invalid(what));
            }
        };
        let aperture_mask = match &c.aperture_mask {
            Some(mask) => Some(mask.read(&format!("camera '{}'", c.object_name))?),
            None => None,
        };
        let coating = c.coating.as_deref().map(coating).transpose()?;
        let anchor = match c.anchor.as_str() {
            "ENTRANCE_PUPIL" => Anchor::EntrancePupil,
            "FRONT_VERTEX" => Anchor::FrontVertex,
            "FILM" => Anchor::Film,
            other => {
                return Err(invalid(format!(
                    "camera '{}': there is no anchor '{other}'; use ENTRANCE_PUPIL, FRONT_VERTEX or FILM",
                    c.object_name
                )));
            }
        };
        let relation = match c.focus_relation.as_str() {
            "EXACT" => Relation::Exact,
            "THIN" => Relation::Thin,
            other => {
                return Err(invalid(format!(
                    "camera '{}': there is no focus relation '{other}'; use EXACT or THIN",
                    c.object_name
                )));
            }
        };
        let (sx, sy, sz) = c.scale_mm_per_unit;
        Ok(CameraDescription {
            object_name: c.object_name,
            model,
            matrix_world: c.matrix_world.into(),
            pinhole_focal_length_mm: c.pinhole_focal_length_mm,
            pinhole_film_width_mm: c.pinhole_film_width_mm,
            pinhole_shift: [c.pinhole_shift.0, c.pinhole_shift.1],
            pixel_aspect: c.pixel_aspect,
            lens_path: c.lens_path.into(),
            focal_length_mm: c.focal_length_mm,
            focal_scale: c.focal_scale,
            f_number: c.f_number,
            pupil_diameter_mm: c.pupil_diameter_mm,
            blades: c.blades,
            blade_rotation_rad: c.blade_rotation_rad,
            blade_curvature: c.blade_curvature,
            aperture_mask,
            coating,
            transmission: false,
            exposes_by_f_number: c.exposes_by_f_number,
            focus_distance: c.focus_distance,
            focusing: Focusing { anchor, relation },
            focus_point_world: c.focus_point_world.map(|(x, y, z)| DVec3::new(x, y, z)),
            film_distance_mm: c.film_distance_mm,
            film_width_mm: c.film_width_mm,
            film_height_mm: c.film_height_mm,
            tilt_rad: c.tilt_rad,
            swing_rad: c.swing_rad,
            shift_mm: [c.shift_mm.0, c.shift_mm.1],
            scale_mm_per_unit: DVec3::new(sx, sy, sz),
            wavelength_nm: c.wavelength_nm,
            spectrum,
            shown: EnabledEffects::default(),
            scattering: Scattering {
                roughness_nm: c.roughness_nm,
                cleanliness: c.cleanliness,
                veiling_index: c.veiling_index,
            },
            precision,
            exposure: c.exposure.map(|(shutter_s, iso, lumens_per_watt)| PhysicalExposure {
                shutter_s,
                iso,
                lumens_per_watt,
            }),
            orthographic_width: c.orthographic_width,
            clip: c.clip.into(),
        })
    }
}

/// Data of the camera for the panel and the viewport.
#[pyfunction]
pub(crate) fn camera_info_json(py: Python<'_>, camera: PyCamera, width: u32, height: u32) -> Result<String, Error> {
    let description: CameraDescription = camera.try_into()?;
    let i = without_gil(py, || camera::lens_info(&description, width, height))??;
    Ok(json!({
        "lens_name": i.lens_name,
        "surfaces": i.surfaces,
        "efl_mm": i.efl_mm,
        "bfd_mm": i.bfd_mm,
        "f_number": i.f_number,
        "t_number": i.t_number,
        "coatings": i.coatings,
        "coating_is_assumed": i.coating_is_assumed,
        "unknown_absorption": i.unknown_absorption,
        "widest_f_number": i.widest_f_number,
        "f_number_was_clamped": i.f_number_was_clamped,
        "film_z_mm": i.film_z_mm,
        "film_distance_mm": i.film_distance_mm,
        "focus_distance_mm": i.focus_distance_mm,
        "focus_scale_mm": i.focus_scale_mm,
        "magnification": i.magnification,
        "fov_horizontal_rad": i.fov_horizontal_rad,
        "fov_vertical_rad": i.fov_vertical_rad,
        "fov_diagonal_rad": i.fov_diagonal_rad,
        "picture_width_mm": i.picture_width_mm,
        "picture_height_mm": i.picture_height_mm,
        "viewport_focal_length_mm": i.viewport_focal_length_mm,
        "viewport_sensor_width_mm": i.picture_width_mm,
        "viewport_shift": i.viewport_shift,
        "entrance_pupil_diameter_mm": i.entrance_pupil_diameter_mm,
        "zoom_range_mm": i.zoom_range_mm,
        "focuses_inside": i.focuses_inside,
        "remarks": i.remarks,
        "beyond_range": i.beyond_range,
    })
    .to_string())
}

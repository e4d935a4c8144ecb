//! A camera model fitted to a lens: its calibration, and its distance from the lens's own rays.

use crate::camera::CameraDescription;
use crate::camera::tools::picture_rays::{Centre, PictureRay, PictureRays, PictureRaysError};
use glam::DVec2;
use petzval_optics::calibration::{Calibration, CameraToFit, FitError, FittedCalibration, Model, SeenDirection, fit};
use petzval_optics::paraxial::Paraxial;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Distances at which a scene is looked at that is not where the model is exact, mm; infinity last.
const DISTANCES_MM: [f64; 2] = [1e3, 1e4];

/// The model that is asked for.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedCameraOptions {
    /// The model's name.
    pub model: String,
    /// The coefficients that are found, by name; `None`: those that the lens's symmetry leaves.
    pub coefficients: Option<Vec<String>>,
    /// The centre of projection.
    pub centre: Centre,
}

/// An error by which no model is fitted.
#[derive(Debug, thiserror::Error)]
pub enum FittedCameraError {
    /// There are no rays.
    #[error(transparent)]
    Rays(#[from] PictureRaysError),
    /// There is no such model.
    #[error("there is no camera model '{asked}'; use one of {known}")]
    Unknown {
        /// The name that was asked for.
        asked: String,
        /// The names of those that are fitted.
        known: String,
    },
    /// The model does not fit.
    #[error("lens '{lens}': {problem}")]
    Fit {
        /// Name of the lens.
        lens: String,
        /// The reason.
        problem: FitError,
    },
}

/// A model fitted to a lens.
pub struct FittedCamera {
    /// The rays of the lens.
    pub rays: PictureRays,
    /// The model.
    pub calibration: Calibration,
    /// The report.
    pub report: FittedCameraReport,
}

/// A fitted model. Lengths in mm, angles in degrees, points in pixels from the picture's upper left corner; null where there is none.
#[derive(Serialize)]
pub struct FittedCameraReport {
    name: String,
    efl_mm: Option<f64>,
    wavelength_nm: f64,
    /// The focus distance from the entrance pupil; null: infinity.
    focus_distance_mm: Option<f64>,
    size_px: [u32; 2],
    picture_mm: [f64; 2],
    model: &'static str,
    parameters: Map<String, Value>,
    /// The parameters that were found; the others are as without distortion.
    free: Vec<&'static str>,
    /// The part of the picture that the lens lights by its chief rays, where the model was fitted.
    lit: f64,
    /// Residuals: the place where the model sees the lens's direction of a point, from that point.
    rms_px: f64,
    worst_px: f64,
    worst_at_px: [f64; 2],
    worst_angle_deg: f64,
    largest_angle_deg: f64,
    /// The angle up to which the model is valid all around; null: it has no fold.
    valid_to_deg: Option<f64>,
    /// The part of the whole picture in which the model has directions, and why not in the rest.
    covered: f64,
    reason: Option<String>,
    horizontal_field_deg: Option<f64>,
    vertical_field_deg: Option<f64>,
    /// The centre of projection and the entrance pupil of rays near the axis, from the first vertex, positive behind it.
    centre_z_mm: f64,
    pupil_z_mm: f64,
    /// The least and the largest distance from the centre at which chief rays come nearest to the axis, positive behind it.
    wander_mm: [f64; 2],
    /// Residuals for scenes at other distances.
    elsewhere: Vec<Elsewhere>,
    rays: usize,
    steps: usize,
}

/// Residuals for a scene at another distance than that at which the model is exact.
#[derive(Serialize)]
struct Elsewhere {
    /// Null: infinity.
    distance_mm: Option<f64>,
    rms_px: f64,
    worst_px: f64,
}

/// A map's channels by name, each by row from the top.
pub type MapChannels = Vec<(String, Vec<f32>)>;

/// Fits a model to the lens of a camera whose picture has that many pixels.
///
/// # Errors
/// [`FittedCameraError`].
pub fn fitted_camera(
    d: &CameraDescription,
    size_px: [u32; 2],
    options: &FittedCameraOptions,
) -> Result<FittedCamera, FittedCameraError> {
    let model = Model::ALL.into_iter().find(|model| model.name() == options.model).ok_or_else(|| {
        let known: Vec<&str> = Model::ALL.into_iter().filter(|model| model.is_fitted()).map(Model::name).collect();
        FittedCameraError::Unknown { asked: options.model.clone(), known: known.join(", ") }
    })?;
    let rays = PictureRays::new(d, size_px, options.centre)?;
    let wrong = |problem: FitError| FittedCameraError::Fit { lens: rays.system.name().to_owned(), problem };
    let lit = rays.lit_grid();
    let seen = seen(&lit, rays.sharp_mm(), model.is_flat());
    let camera = CameraToFit {
        model,
        size_px,
        focal_px: focal_px(&rays, model.is_flat()),
        centre_px: rays.axis_px().to_array(),
        is_symmetric: rays.is_symmetric(),
        coefficients: options.coefficients.clone(),
    };
    let FittedCalibration { calibration, free, steps } = fit(&camera, &seen).map_err(wrong)?;
    let report = report(&rays, &lit, &calibration, free, steps);
    Ok(FittedCamera { rays, calibration, report })
}

fn seen(rays: &[PictureRay], distance_mm: Option<f64>, is_flat: bool) -> Vec<SeenDirection> {
    let whole: f64 = rays.iter().map(|ray| ray.weight).sum();
    let of = |ray: &PictureRay| {
        // What never comes to the distance goes on for ever.
        let direction = PictureRays::direction_to(ray, distance_mm, is_flat).unwrap_or(ray.direction);
        SeenDirection { point_px: ray.point_px, direction, weight: ray.weight / whole }
    };
    rays.iter().map(of).collect()
}

/// Pixels for a radian about the axis, by rays near it; those of the paraxial focal length where there are none.
fn focal_px(rays: &PictureRays, is_flat: bool) -> [f64; 2] {
    let along = |axis: DVec2, i: usize| {
        let step = axis * (0.01 * f64::from(rays.size_px[i]));
        let direction = |at: DVec2| PictureRays::direction_to(&rays.at(at)?, rays.sharp_mm(), is_flat);
        let (a, b) = (direction(rays.axis_px() - step)?, direction(rays.axis_px() + step)?);
        let focal = 2.0 * step.length() / a.cross(b).length().atan2(a.dot(b));
        focal.is_finite().then_some(focal)
    };
    let efl_mm = Paraxial::new(&rays.system, rays.wavelength_nm).efl_mm.map_or(rays.picture_mm[0], f64::abs);
    let paraxial = |i: usize| efl_mm * f64::from(rays.size_px[i]) / rays.picture_mm[i];
    [along(DVec2::X, 0).unwrap_or_else(|| paraxial(0)), along(DVec2::Y, 1).unwrap_or_else(|| paraxial(1))]
}

/// Root of the mean square of residuals, the largest, and its place.
struct Misfit {
    rms_px: f64,
    worst_px: f64,
    worst_at: usize,
}

/// Residuals at rays; directions that the model does not see are left out.
fn misfit(calibration: &Calibration, seen: &[SeenDirection]) -> Misfit {
    let (mut sum, mut weight) = (0.0, 0.0);
    let mut found = Misfit { rms_px: 0.0, worst_px: 0.0, worst_at: 0 };
    for (i, one) in seen.iter().enumerate() {
        let Ok(point) = calibration.project(one.direction) else { continue };
        let off = (point - one.point_px).length();
        sum += one.weight * off * off;
        weight += one.weight;
        if off > found.worst_px {
            (found.worst_px, found.worst_at) = (off, i);
        }
    }
    if weight > 0.0 {
        found.rms_px = (sum / weight).sqrt();
    }
    found
}

fn report(
    rays: &PictureRays,
    lit: &[PictureRay],
    calibration: &Calibration,
    free: Vec<&'static str>,
    steps: usize,
) -> FittedCameraReport {
    let model = calibration.model();
    let at = |distance_mm: Option<f64>| seen(lit, distance_mm, model.is_flat());
    let here = misfit(calibration, &at(rays.sharp_mm()));
    let angle_deg = |ray: &PictureRay| ray.direction.truncate().length().atan2(ray.direction.z).to_degrees();
    let survey = calibration.survey();
    let [horizontal, vertical] = survey.field_rad.map(|field| field.map(f64::to_degrees));
    let slope = |ray: &PictureRay| ray.direction.truncate().length();
    let steepest = lit.iter().map(slope).fold(0.0, f64::max);
    let nearest = |ray: &PictureRay| {
        let (o, d) = (ray.origin_mm, ray.direction);
        let across = d.truncate();
        // Where the ray comes nearest to the axis, seen from the centre; along the axis it is nowhere in particular.
        let z = o.z - d.z * o.truncate().dot(across) / across.length_squared();
        (slope(ray) > 0.1 * steepest && z.is_finite()).then_some(-z)
    };
    let ends = lit
        .iter()
        .filter_map(nearest)
        .fold(None, |ends: Option<[f64; 2]>, z| Some(ends.map_or([z; 2], |[low, high]| [low.min(z), high.max(z)])));
    let sharp = rays.sharp_mm();
    let others = DISTANCES_MM.map(Some).into_iter().chain([None]);
    let is_other = |distance: &Option<f64>| match (distance, sharp) {
        (Some(a), Some(b)) => (a / b - 1.0).abs() > 1e-3,
        (a, b) => a.is_some() != b.is_some(),
    };
    let elsewhere = |distance_mm: Option<f64>| {
        let Misfit { rms_px, worst_px, .. } = misfit(calibration, &at(distance_mm));
        Elsewhere { distance_mm, rms_px, worst_px }
    };
    let worst = &lit[here.worst_at];
    FittedCameraReport {
        name: rays.system.name().to_owned(),
        efl_mm: Paraxial::new(&rays.system, rays.wavelength_nm).efl_mm,
        wavelength_nm: rays.wavelength_nm,
        focus_distance_mm: rays.sharp_z_mm.map(|z| rays.pupil_z_mm - z),
        size_px: rays.size_px,
        picture_mm: rays.picture_mm,
        model: model.name(),
        parameters: super::calibration::parameters(calibration),
        free,
        lit: lit.iter().map(|ray| ray.weight).sum(),
        rms_px: here.rms_px,
        worst_px: here.worst_px,
        worst_at_px: worst.point_px.to_array(),
        worst_angle_deg: angle_deg(worst),
        largest_angle_deg: lit.iter().map(angle_deg).fold(0.0, f64::max),
        valid_to_deg: survey.fold_rad.map(f64::to_degrees),
        covered: survey.covered,
        reason: survey.reason.map(|reason| reason.to_string()),
        horizontal_field_deg: horizontal,
        vertical_field_deg: vertical,
        centre_z_mm: rays.centre_z_mm,
        pupil_z_mm: rays.pupil_z_mm,
        wander_mm: ends.unwrap_or_default(),
        elsewhere: others.filter(is_other).map(elsewhere).collect(),
        rays: lit.len(),
        steps,
    }
}

impl FittedCamera {
    /// The ray map: for each pixel the origin of its ray (on the first surface of the lens) in mm and its unit direction, camera space (x
    /// right, y down, z ahead, from the centre of projection), and an A of 1; all 0 where the lens lights nothing.
    pub fn ray_map(pixels: &[Option<PictureRay>]) -> MapChannels {
        let channel = |name: &str, of: fn(&PictureRay) -> f64| {
            let values = pixels.iter().map(|ray| ray.as_ref().map_or(0.0, |ray| of(ray) as f32)).collect();
            (name.to_owned(), values)
        };
        vec![
            channel("origin.X", |ray| ray.origin_mm.x),
            channel("origin.Y", |ray| ray.origin_mm.y),
            channel("origin.Z", |ray| ray.origin_mm.z),
            channel("direction.X", |ray| ray.direction.x),
            channel("direction.Y", |ray| ray.direction.y),
            channel("direction.Z", |ray| ray.direction.z),
            channel("A", |_| 1.0),
        ]
    }

    /// The residual map: for each pixel the place where the model sees the lens's direction of it, from its middle, pixels to the right and
    /// down, and an A of 1; all 0 where the lens lights nothing or the model sees nothing.
    pub fn residual_map(&self, pixels: &[Option<PictureRay>]) -> MapChannels {
        let of = |ray: &PictureRay| {
            let is_flat = self.calibration.model().is_flat();
            let direction = PictureRays::direction_to(ray, self.rays.sharp_mm(), is_flat)?;
            self.calibration.project(direction).ok().map(|point| point - ray.point_px)
        };
        let off: Vec<Option<DVec2>> = pixels.iter().map(|ray| ray.as_ref().and_then(of)).collect();
        let channel = |name: &str, part: fn(&DVec2) -> f64| {
            (name.to_owned(), off.iter().map(|off| off.as_ref().map_or(0.0, |off| part(off) as f32)).collect())
        };
        vec![channel("X", |off| off.x), channel("Y", |off| off.y), channel("A", |_| 1.0)]
    }
}

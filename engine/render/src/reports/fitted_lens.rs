//! A lens adjusted to a measured calibration: the residuals before and after, and its file.

use petzval_optics::formats;
use petzval_optics::formats::calibration::{self, CalibrationFileError};
use petzval_optics::glass::Catalogue;
use petzval_optics::lens_fit::{
    Adjusted, FittedGap, GapsToFit, LensFit, LensFitError, LensMisfit, LensState, LensToFit, Tolerance, fit,
};
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{LensSettings, System};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Parts by which the shapes of pixels, and of a film and a picture, may differ: calibrations have errors of their own.
const SHAPE: f64 = 0.01;
/// Focal lengths that are farther apart than this part are of two lenses.
const APART: f64 = 0.25;
/// Lines of a header that are of the lens as it was published.
const PUBLISHED: [&str; 5] = ["focal_length", "back_focus", "differs", "first_choice", "film"];

/// Gaps that are adjusted.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum GapTolerance {
    /// Millimetres.
    Millimetres(f64),
    /// A part of the gap.
    Part(f64),
}

/// A calibration, and the options of a lens's fit to it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedLensOptions {
    /// The file of calibrations.
    pub calibration: PathBuf,
    /// The camera's name in the file; `None` is the only one.
    pub camera: Option<String>,
    /// Width and height of a pixel, µm.
    pub pixel_pitch_um: Option<[f64; 2]>,
    /// Width and height of the sensor, where the pixels' size is not given; `None`: the film of the lens file.
    pub film_mm: Option<[f64; 2]>,
    /// Vacuum wavelength of the rays.
    pub wavelength_nm: f64,
    /// The distance of focus from the entrance pupil; `None`: infinity.
    pub focus_distance_mm: Option<f64>,
    /// The names of the adjustments.
    pub adjust: Vec<String>,
    /// The tolerance of gaps; `None`: they stay.
    pub gaps: Option<GapTolerance>,
    /// The surfaces before gaps; `None`: all.
    pub surfaces: Option<Vec<usize>>,
}

/// An error by which a lens is not adjusted.
#[derive(Debug, thiserror::Error)]
pub enum FittedLensError {
    /// The file of calibrations is missing or wrong.
    #[error(transparent)]
    File(#[from] CalibrationFileError),
    /// An option cannot be.
    #[error("{0}")]
    Option(String),
    /// The lens cannot be adjusted.
    #[error("lens '{lens}': {problem}")]
    Fit {
        /// Name of the lens.
        lens: String,
        /// The reason.
        problem: LensFitError,
    },
}

/// An adjusted lens.
pub struct FittedLens {
    /// The report.
    pub report: FittedLensReport,
    /// The file.
    pub text: String,
    /// The parts of the lens that a lens file cannot hold.
    pub lost: Vec<String>,
}

/// An adjusted lens. Lengths in mm, or µm by their names; null where there is none.
#[derive(Serialize)]
pub struct FittedLensReport {
    name: String,
    calibration: String,
    model: &'static str,
    size_px: [u32; 2],
    pixel_pitch_um: [f64; 2],
    wavelength_nm: f64,
    /// The part of the picture that was compared: the part that both see.
    compared: f64,
    points: usize,
    before: Compared,
    after: Compared,
    scale: f64,
    gaps: Vec<Gap>,
    /// Pairs of adjustments that do the same to the picture.
    alike: Vec<[String; 2]>,
    steps: usize,
}

/// A lens beside a calibration.
#[derive(Serialize)]
struct Compared {
    rms_px: f64,
    worst_px: f64,
    worst_at_px: [f64; 2],
    rms_um: f64,
    worst_um: f64,
    efl_mm: Option<f64>,
    /// The focus distance from the entrance pupil; null: infinity.
    focus_distance_mm: Option<f64>,
    /// The film from the last vertex.
    film_distance_mm: f64,
}

impl Compared {
    fn new(misfit: &LensMisfit, state: &LensState) -> Self {
        Self {
            rms_px: misfit.rms_px,
            worst_px: misfit.worst_px,
            worst_at_px: misfit.worst_at_px.to_array(),
            rms_um: 1e3 * misfit.rms_mm,
            worst_um: 1e3 * misfit.worst_mm,
            efl_mm: state.efl_mm,
            focus_distance_mm: state.focus_distance_mm,
            film_distance_mm: state.film_distance_mm,
        }
    }
}

/// A gap that was adjusted.
#[derive(Serialize)]
struct Gap {
    surface: usize,
    before_mm: f64,
    after_mm: f64,
    /// The tolerance.
    tolerance_mm: f64,
    /// True if it stopped at the end of its tolerance.
    is_at_end: bool,
    /// The change of the picture by all of the tolerance, root of the mean square.
    effect_px: f64,
}

impl Gap {
    fn new(gap: &FittedGap) -> Self {
        let [before_mm, after_mm] = gap.gap_mm;
        Self {
            surface: gap.surface,
            before_mm,
            after_mm,
            tolerance_mm: gap.tolerance_mm,
            is_at_end: (after_mm - before_mm).abs() >= 0.999 * gap.tolerance_mm,
            effect_px: gap.effect_px,
        }
    }
}

/// Adjusts a lens to a calibration.
///
/// # Errors
/// [`FittedLensError`].
pub fn fitted_lens(
    lens: &Prescription,
    settings: &LensSettings,
    options: &FittedLensOptions,
) -> Result<FittedLens, FittedLensError> {
    let file = calibration::read(&options.calibration)?;
    let camera = file.camera(options.camera.as_deref())?;
    let calibration = &camera.calibration;
    let size_px = calibration.size_px();
    let pitch_mm = pitch_mm(lens, settings, size_px, calibration.focal_px(), options)?;
    let task = LensToFit {
        prescription: lens,
        settings,
        calibration,
        pitch_mm,
        wavelength_nm: options.wavelength_nm,
        focus_distance_mm: options.focus_distance_mm,
        adjusted: &options.adjust.iter().map(|name| adjusted(name)).collect::<Result<Vec<_>, _>>()?,
        gaps: options.gaps.map(|tolerance| GapsToFit {
            tolerance: match tolerance {
                GapTolerance::Millimetres(mm) => Tolerance::Millimetres(mm),
                GapTolerance::Part(part) => Tolerance::Part(part),
            },
            surfaces: options.surfaces.clone(),
        }),
    };
    let found = fit(&task).map_err(|problem| FittedLensError::Fit { lens: lens.name.clone(), problem })?;
    let report = FittedLensReport {
        name: lens.name.clone(),
        calibration: file.file.clone(),
        model: calibration.model().name(),
        size_px,
        pixel_pitch_um: pitch_mm.map(|mm| 1e3 * mm),
        wavelength_nm: options.wavelength_nm,
        compared: found.part,
        points: found.points,
        before: Compared::new(&found.misfit[0], &found.state[0]),
        after: Compared::new(&found.misfit[1], &found.state[1]),
        scale: found.scale,
        gaps: found.gaps.iter().map(Gap::new).collect(),
        alike: found.alike.iter().map(|(a, b, _)| [a.clone(), b.clone()]).collect(),
        steps: found.steps,
    };
    let source = options.calibration.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
    let written = named(&found, &report, &source);
    let (text, lost) = formats::lens::write(&written, Catalogue::shipped());
    Ok(FittedLens { report, text, lost })
}

fn adjusted(name: &str) -> Result<Adjusted, FittedLensError> {
    let known = || Adjusted::ALL.map(Adjusted::name).join(", ");
    let found = Adjusted::ALL.into_iter().find(|one| one.name() == name);
    found.ok_or_else(|| FittedLensError::Option(format!("nothing called '{name}' is adjusted; name {}", known())))
}

/// Width and height of a pixel, mm, as they are given or follow from the sensor's size.
fn pitch_mm(
    lens: &Prescription,
    settings: &LensSettings,
    size_px: [u32; 2],
    focal_px: Option<[f64; 2]>,
    options: &FittedLensOptions,
) -> Result<[f64; 2], FittedLensError> {
    let wrong = |what: String| Err(FittedLensError::Option(what));
    let [width, height] = size_px.map(f64::from);
    let pitch = match (options.pixel_pitch_um, options.film_mm.or(lens.metadata.film_mm)) {
        (Some(um), _) => um.map(|um| 1e-3 * um),
        (None, None) => {
            return wrong(format!(
                "nothing says how large the sensor is: a calibration has pixels alone, and '{}' names no film: give --pixel-pitch-um or --film",
                lens.name
            ));
        }
        (None, Some([film_width, film_height])) => {
            let (picture, film) = (width / height, film_width / film_height);
            if (picture / film - 1.0).abs() > SHAPE {
                return wrong(format!(
                    "the calibration's picture of {width} x {height} pixels has another shape than a film of {film_width} x {film_height} mm \
                     ({picture:.4} and {film:.4}): give --pixel-pitch-um, or the sensor's own size as --film"
                ));
            }
            // Sizes of sensors are rounded: pixels are square.
            [film_width / width; 2]
        }
    };
    let (Some([fx, fy]), Ok(system)) = (focal_px, System::new(lens, settings)) else { return Ok(pitch) };
    let shape = fx * pitch[0] / (fy * pitch[1]);
    if system.is_rotationally_symmetric() && (shape - 1.0).abs() > SHAPE {
        return wrong(format!(
            "the calibration's pixels are not of this shape: its focal lengths are {fx:.2} and {fy:.2} pixels, which a lens that is symmetric about \
             its axis sees with pixels {:.4} times as high as wide: give --pixel-pitch-um WIDTH,HEIGHT",
            fx / fy
        ));
    }
    let efl = petzval_optics::paraxial::Paraxial::new(&system, options.wavelength_nm).efl_mm.map(f64::abs);
    let measured = fx * pitch[0];
    // In an eye a picture is smaller by the index before its film.
    let power = efl.map(|efl| efl / system.image_index(options.wavelength_nm).abs());
    if let Some(own) = power.filter(|own| (measured / own - 1.0).abs() > APART) {
        return wrong(format!(
            "the calibration's focal length is {measured:.2} mm with pixels {:.4} um wide, and that of '{}' {own:.2} mm: give the sensor's size as \
             --pixel-pitch-um or --film, the zoom as --focal-length, or another lens",
            1e3 * pitch[0],
            lens.name
        ));
    }
    Ok(pitch)
}

/// The adjusted lens with a header that names its origin.
fn named(found: &LensFit, report: &FittedLensReport, source: &str) -> Prescription {
    let mut lens = found.prescription.clone();
    let FittedLensReport { model, size_px: [width, height], before, after, .. } = report;
    lens.name = format!("{}, fitted to {source}", lens.name);
    let all = &mut lens.metadata.all;
    all.retain(|(key, _)| !PUBLISHED.contains(&key.as_str()));
    let [across, up] = report.pixel_pitch_um;
    let side = |count: &u32, um: f64| 1e-3 * um * f64::from(*count);
    let mut line = |key: &str, text: String| all.push((key.to_owned(), text));
    line("film", format!("{} x {}", side(width, across), side(height, up)));
    let mm = |efl: Option<f64>| efl.map_or("none".to_owned(), |mm| format!("{mm:.4} mm"));
    line(
        "fitted",
        format!(
            "to {source} ({model}, {width} x {height} pixels of {across:.4} x {up:.4} um) by chief rays at {:.1} nm: focal length {} to {}, film \
             {:.4} to {:.4} mm behind the last vertex; left over rms {:.3} to {:.3} pixels, at most {:.3} to {:.3}",
            report.wavelength_nm,
            mm(before.efl_mm),
            mm(after.efl_mm),
            before.film_distance_mm,
            after.film_distance_mm,
            before.rms_px,
            after.rms_px,
            before.worst_px,
            after.worst_px
        ),
    );
    for gap in &report.gaps {
        let (surface, from, to) = (gap.surface, gap.before_mm, gap.after_mm);
        line(
            "fitted",
            format!("gap behind surface {surface} {from:.4} to {to:.4} mm, before the whole lens was scaled"),
        );
    }
    lens
}

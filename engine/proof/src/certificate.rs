//! The certificate of a proof: the fates of all cells, with all data for a check.

use petzval_optics::focus::{FilmPlane, GroupsError, focused};
use petzval_optics::glass::{Dispersion, Medium, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{Element, LensSettings, System};
use petzval_optics::trace::{Action, Travel};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::chart::Chart;
use crate::column::{Cell, Column, Cut};
use crate::partition::{Proof, ProofError, ProofOptions, prove};
use crate::passage::Fate;

/// The word by which a certificate and its version are known.
pub const FORMAT: &str = "petzval lens proof 1";

/// The request of a certificate.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertificateOptions {
    /// Radius of the film's disc, mm; `None`: half of the diagonal of the lens file's film, else the image of its half field, else 21.6.
    pub film_radius_mm: Option<f64>,
    /// Focus distance from the entrance pupil, mm; `None`: infinity.
    pub focus_distance_mm: Option<f64>,
    /// The shortest and the longest wavelength, nm.
    pub wavelengths_nm: [f64; 2],
    /// Part of the volume that may be left undecided.
    pub undecided: f64,
    /// Time limit, s: the proof ends with the cells that are decided by then.
    pub seconds: f64,
    /// Number of threads, 0: one for each processor.
    pub threads: usize,
}

/// An error by which there is no certificate.
#[derive(Debug, Error)]
pub enum CertificateError {
    /// The lens cannot be set or focused.
    #[error(transparent)]
    Focus(#[from] GroupsError),
    /// The lens has something that is not covered.
    #[error("lens '{lens}': {why}")]
    Proof {
        /// Name of the lens.
        lens: String,
        /// The kind of surface or glass that no proof covers.
        why: ProofError,
    },
}

/// A surface on the way from the film, with the numbers that the tracer has.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CertificateSurface {
    surface: usize,
    curvature_per_mm: f64,
    conic: f64,
    terms: Vec<(u32, f64)>,
    to_here_mm: f64,
    side: f64,
    clear_squared_mm2: f64,
    obstruction_squared_mm2: f64,
    is_stop: bool,
    /// "refract", "pass" or "reflect".
    action: &'static str,
    /// Media that the ray leaves and enters, by their places in `media`.
    media: [usize; 2],
}

/// A medium by its formula.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct CertificateMedium {
    name: String,
    formula: &'static str,
    numbers: Vec<f64>,
    /// True if the index is one over that of the formula.
    is_reciprocal: bool,
    index_shift: f64,
    /// Null where there is no end.
    range_nm: [Option<f64>; 2],
}

/// A cell: zone, fractions from and to, word, and of a stopped one surface, reason, and whether all surfaces before were passed.
type CertificateCell = (usize, f64, f64, &'static str, Option<usize>, Option<&'static str>, Option<bool>);

/// A column: slab, lower and upper bounds of the floor, cuts, cells.
type CertificateColumn = (usize, [f64; 3], [f64; 3], Vec<Cut>, Vec<CertificateCell>);

/// The certificate, but for the hashes of files, which whoever writes it adds.
#[derive(Clone, Debug, Serialize)]
pub struct Certificate {
    format: &'static str,
    name: String,
    /// Factor from the file's millimetres to these.
    scale: f64,
    f_number: Option<f64>,
    focal_length_mm: Option<f64>,
    film_radius_mm: f64,
    film_z_mm: f64,
    film_curvature_per_mm: f64,
    disc_radius_mm: f64,
    last_vertex_z_mm: f64,
    wavelengths_nm: [f64; 2],
    opening_mm: f64,
    surfaces: Vec<CertificateSurface>,
    media: Vec<CertificateMedium>,
    /// (k₀ mm, k₁) by slab.
    centres: Vec<[f64; 2]>,
    undecided: f64,
    passes: f64,
    stopped: f64,
    /// Part of the volume by the surface that stops it.
    stopped_by_surface: Vec<f64>,
    seconds: f64,
    columns: Vec<CertificateColumn>,
}

/// Proves the fates of the rays of a lens, as a certificate.
///
/// # Errors
/// [`CertificateError`].
pub fn certificate(
    lens: &Prescription,
    settings: &LensSettings,
    options: &CertificateOptions,
) -> Result<Certificate, CertificateError> {
    let (system, focus) = focused(lens, settings, line_nm::D, options.focus_distance_mm)?;
    let film_curvature_per_mm = system.film_radius_mm().map_or(0.0, f64::recip);
    let film = FilmPlane { curvature_per_mm: film_curvature_per_mm, ..FilmPlane::upright(focus.film_z_mm) };
    let asked = ProofOptions {
        film_radius_mm: options.film_radius_mm.unwrap_or_else(|| film_radius_mm(lens, &system)),
        wavelengths_nm: options.wavelengths_nm,
        undecided: options.undecided,
        seconds: options.seconds,
        threads: options.threads,
    };
    let proof =
        prove(&system, &film, &asked).map_err(|why| CertificateError::Proof { lens: system.name().to_owned(), why })?;
    Ok(written(&system, &proof))
}

/// Half of the diagonal of the film that the file names, else how high its half field is imaged, else that of 36 × 24 mm.
fn film_radius_mm(lens: &Prescription, system: &System) -> f64 {
    const FULL_FRAME_MM: f64 = 21.6;
    let scale = system.scale();
    let of_file = lens.metadata.film_mm.map(|[width, height]| 0.5 * width.hypot(height) * scale);
    let paraxial = Paraxial::new(system, line_nm::D);
    let of_field =
        system.half_field_deg().zip(paraxial.efl_mm).map(|(deg, efl)| efl.abs() * deg.min(60.0).to_radians().tan());
    let radius = of_file.or(of_field).unwrap_or(FULL_FRAME_MM);
    system.film_radius_mm().map_or(radius, |retina| radius.min(0.8 * retina.abs()))
}

fn medium(medium: &Medium) -> CertificateMedium {
    let (dispersion, is_reciprocal) = match medium.dispersion() {
        Dispersion::Reciprocal(other) => (&**other, true),
        other => (other, false),
    };
    let (formula, numbers) = dispersion.words().unwrap_or(("none", Vec::new()));
    CertificateMedium {
        name: medium.name().to_owned(),
        formula,
        numbers,
        is_reciprocal,
        index_shift: medium.index_shift(),
        range_nm: medium.range_nm().map(|nm| (nm > 0.0 && nm.is_finite()).then_some(nm)),
    }
}

#[expect(clippy::too_many_lines, reason = "a field for each fact")]
fn written(system: &System, proof: &Proof) -> Certificate {
    let Chart { film_radius_mm, film_z_mm, film_curvature_per_mm, disc_radius_mm, last_z_mm, wavelengths_nm } =
        proof.chart;
    let middle = system.at_wavelength(0.5 * (wavelengths_nm[0] + wavelengths_nm[1]));
    let steps = middle.steps(Travel::FromFilm);
    let last = steps.len() - 1;
    let mut media: Vec<CertificateMedium> = Vec::new();
    let mut place = |found: &Medium| {
        let found = medium(found);
        media.iter().position(|known| *known == found).unwrap_or_else(|| {
            media.push(found);
            media.len() - 1
        })
    };
    let surfaces = steps.iter().enumerate().map(|(i, step)| {
        let profile = step.shape.profile();
        let media = match &system.surfaces()[last - i].element {
            Element::Refract { from, to } => [place(to), place(from)],
            Element::Reflect { medium } => [place(medium); 2],
        };
        let action = match step.action {
            Action::Refract(_) => "refract",
            Action::Pass => "pass",
            Action::Reflect => "reflect",
        };
        CertificateSurface {
            surface: last - i,
            curvature_per_mm: profile.base.curvature,
            conic: profile.base.conic,
            terms: profile.terms(),
            to_here_mm: step.to_here,
            side: step.side,
            clear_squared_mm2: step.clear_squared,
            obstruction_squared_mm2: step.obstruction_squared,
            is_stop: step.is_stop,
            action,
            media,
        }
    });
    let surfaces: Vec<CertificateSurface> = surfaces.collect();
    let whole = proof.chart.whole_volume();
    let stopped_at = |surface: usize| {
        let counts = |fate: Fate| matches!(fate, Fate::Stopped { step, .. } if last - step == surface);
        let of = |column: &Column| column.volume(&proof.chart, proof.centres[column.slab], counts);
        proof.columns.iter().map(of).sum::<f64>() / whole
    };
    let stopped_by_surface: Vec<f64> = (0..=last).map(stopped_at).collect();
    let paraxial = Paraxial::new(system, line_nm::D);
    Certificate {
        format: FORMAT,
        name: system.name().to_owned(),
        scale: system.scale(),
        f_number: Some(system.f_number()).filter(|n| n.is_finite()),
        focal_length_mm: paraxial.efl_mm,
        film_radius_mm,
        film_z_mm,
        film_curvature_per_mm,
        disc_radius_mm,
        last_vertex_z_mm: last_z_mm,
        wavelengths_nm,
        opening_mm: system.diaphragm().radius_mm(),
        surfaces,
        media,
        centres: proof.centres.iter().map(|centre| [centre.at_axis_mm, centre.slope]).collect(),
        undecided: proof.undecided,
        passes: proof.passes,
        stopped: stopped_by_surface.iter().sum(),
        stopped_by_surface,
        seconds: proof.seconds,
        columns: proof.columns.iter().map(|column| written_column(column, last)).collect(),
    }
}

fn written_column(column: &Column, last: usize) -> CertificateColumn {
    let cell = |cell: &Cell| {
        let Cell { zone, from, to, fate } = *cell;
        match fate {
            Fate::Passes => (zone, from, to, "passes", None, None, None),
            Fate::Undecided => (zone, from, to, "undecided", None, None, None),
            Fate::Stopped { step, reason, is_first } => {
                (zone, from, to, "stopped", Some(last - step), Some(reason.name()), Some(is_first))
            }
        }
    };
    let cells = column.cells.iter().map(cell).collect();
    (column.slab, column.floor.low, column.floor.high, column.cuts.clone(), cells)
}

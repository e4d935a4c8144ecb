//! The ghosts of a far source.

use super::{ReportError, check_wavelength};
use glam::{DVec2, DVec3};
use petzval_optics::focus::{FilmPlane, focused};
use petzval_optics::ghosts::beam::{Beam, Source};
use petzval_optics::ghosts::ranking::Ranked;
use petzval_optics::ghosts::{brute, ranking};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::LensSettings;
use serde::Serialize;

/// Largest number of rays: more take hours.
const MOST_RAYS: usize = 100_000_000;
/// A disc is told apart from a point where its radius is this part of the film's diagonal.
const LEAST_PART: f64 = 1e-3;

/// A far source, and the film on which its ghosts fall.
#[derive(Clone, Debug)]
pub struct GhostSource {
    /// Angle to the axis.
    pub angle_deg: f64,
    /// Azimuth, from right to up.
    pub azimuth_deg: f64,
    /// Vacuum wavelength of the source's light.
    pub wavelength_nm: f64,
    /// Focus distance from the entrance pupil; `None` is infinity.
    pub focus_distance_mm: Option<f64>,
    /// Width and height of the film; `None`: the lens file's, or 36 by 24.
    pub film_mm: Option<[f64; 2]>,
    /// Number of reflections of a path at most: 2 or 4.
    pub reflections: usize,
    /// Rays of a count without choice of paths; 0: none is made.
    pub brute_force_rays: usize,
    /// Seed of that count.
    pub seed: u64,
}

/// The ghosts of a source whose light has the irradiance one before the lens.
#[derive(Serialize)]
pub struct GhostsReport {
    name: String,
    wavelength_nm: f64,
    f_number: Option<f64>,
    focus_distance_mm: Option<f64>,
    angle_deg: f64,
    azimuth_deg: f64,
    film_mm: [f64; 2],
    reflections: usize,
    /// Light of all ghosts on the film.
    on_film_mm2: f64,
    /// The ghosts, the brightest first.
    ghosts: Vec<ReportedGhost>,
    brute_force: Option<BruteForce>,
}

/// A ghost, as [`Ranked`].
#[derive(Serialize)]
struct ReportedGhost {
    surfaces: Vec<usize>,
    irradiance: f64,
    radius_mm: f64,
    /// Right and up from the picture's middle.
    centre_mm: [f64; 2],
    light_mm2: f64,
    on_film_mm2: f64,
}

impl From<&Ranked> for ReportedGhost {
    fn from(ghost: &Ranked) -> Self {
        Self {
            surfaces: ghost.turns.clone(),
            irradiance: ghost.irradiance,
            radius_mm: ghost.radius_mm,
            // The picture on the film is turned by half a turn.
            centre_mm: [-ghost.centre_mm.x, -ghost.centre_mm.y],
            light_mm2: ghost.light_mm2,
            on_film_mm2: ghost.on_film_mm2,
        }
    }
}

/// The light on the film by number of reflections, counted ray by ray.
#[derive(Serialize)]
struct BruteForce {
    rays: usize,
    on_film_mm2: Vec<f64>,
    /// Standard error of each number of `on_film_mm2`.
    error_mm2: Vec<f64>,
}

impl GhostSource {
    fn check(&self, film_mm: [f64; 2]) -> Result<(), ReportError> {
        check_wavelength(self.wavelength_nm)?;
        let what = if !(-90.0..=90.0).contains(&self.angle_deg) || !self.azimuth_deg.is_finite() {
            format!("a source at {} degrees: give an angle from -90 to 90 to the axis", self.angle_deg)
        } else if ![2, 4].contains(&self.reflections) {
            format!("{} reflections: give 2 or 4", self.reflections)
        } else if self.brute_force_rays > MOST_RAYS {
            format!("{} rays: give {MOST_RAYS} at most", self.brute_force_rays)
        } else if !film_mm.iter().all(|side| *side > 0.0 && side.is_finite()) {
            format!("a film of {} x {} mm: give two lengths", film_mm[0], film_mm[1])
        } else {
            return Ok(());
        };
        Err(ReportError::OutOfRange(what))
    }

    /// Direction towards the source, lens space.
    fn towards(&self) -> DVec3 {
        let across = DVec2::from_angle(self.azimuth_deg.to_radians()) * self.angle_deg.to_radians().sin();
        DVec3::new(across.x, across.y, -self.angle_deg.to_radians().cos())
    }
}

/// Finds the ghosts of a source.
///
/// # Errors
/// [`ReportError`].
pub fn ghosts(lens: &Prescription, settings: &LensSettings, source: &GhostSource) -> Result<GhostsReport, ReportError> {
    let film_mm = source.film_mm.or(lens.metadata.film_mm).unwrap_or([36.0, 24.0]);
    source.check(film_mm)?;
    let (system, focus) = focused(lens, settings, source.wavelength_nm, source.focus_distance_mm)?;
    let half = DVec2::from(film_mm) * 0.5;
    let is_film = |at: DVec2| at.abs().cmple(half).all();
    let curvature_per_mm = system.film_radius_mm().map_or(0.0, f64::recip);
    let film = FilmPlane { curvature_per_mm, ..FilmPlane::upright(focus.film_z_mm) }.frame();
    let beam = Beam::new(&system, Source::Far(source.towards())).ok_or_else(|| ReportError::Lens {
        lens: system.name().to_owned(),
        why: "the lens has no front glass".to_owned(),
    })?;
    let tracer = system.at_wavelength(source.wavelength_nm);
    let paraxial = Paraxial::new(&system, source.wavelength_nm);
    let front_mm = 2.0 * system.surfaces()[0].semi_diameter_mm;
    let part = paraxial.entrance_pupil.diameter_mm.map_or(1.0, |mm| (mm / front_mm).min(1.0));
    let least_mm = LEAST_PART * DVec2::from(film_mm).length();
    let found = ranking::ranked(&system, &tracer, &beam, (&film, is_film), source.reflections, part, least_mm);
    let brute_force = (source.brute_force_rays > 0).then(|| {
        let random = splitmix64(source.seed);
        let arrived = brute::arrived(&system, &tracer, &beam, &film, is_film, source.brute_force_rays, random);
        BruteForce {
            rays: source.brute_force_rays,
            on_film_mm2: arrived.light_mm2.to_vec(),
            error_mm2: arrived.error_mm2.to_vec(),
        }
    });
    Ok(GhostsReport {
        name: system.name().to_owned(),
        wavelength_nm: source.wavelength_nm,
        f_number: paraxial.f_number,
        focus_distance_mm: source.focus_distance_mm.filter(|mm| mm.is_finite()),
        angle_deg: source.angle_deg,
        azimuth_deg: source.azimuth_deg,
        film_mm,
        reflections: source.reflections,
        on_film_mm2: found.iter().map(|ghost| ghost.on_film_mm2).sum(),
        ghosts: found.iter().map(ReportedGhost::from).collect(),
        brute_force,
    })
}

/// Uniform random numbers (splitmix64, Steele, Lea and Flood 2014).
fn splitmix64(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

//! Tolerances: the effects of deviations of radii, thicknesses, indices and places of elements on the picture, one by one and all together.
//!
//! All together is by the Monte Carlo method: lenses whose deviations are drawn at random within their tolerances, each refocused as it
//! would be in use. The same seed gives the same lenses for any number of threads.

use super::{LensReport, ReportError, ReportedLens, within};
use petzval_optics::analysis::Analysis;
use petzval_optics::deviation::{Deviation, DeviationKind};
use petzval_optics::focus::Focus;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{FocalLength, LensSettings, System};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

const MOST_TRIALS: usize = 100_000;
const MOST_RAYS_OF_A_SIDE: usize = 200;
/// Parts of the lenses whose measures are at least as good.
const PARTS: [f64; 5] = [0.1, 0.5, 0.8, 0.9, 0.98];
/// Steps of the search for the best focus of groups that move: the golden section leaves 0.618 of the interval at each.
const STEPS: usize = 18;
/// The interval of that search, as a part of the way of the groups.
const TRAVEL: f64 = 0.25;
const GOLDEN: f64 = 0.618_033_988_75;
/// Displacement of the film by which the best film is found, as a part of the depth of focus: the mean square of a spot is a parabola.
const ASIDE: f64 = 1.0;

/// The quantity that is adjusted to make up for deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Compensator {
    /// No compensator.
    None,
    /// The distance of the film from the last vertex.
    BackFocus,
    /// The lens's own focusing: groups that move, or if it has none, the film.
    Focus,
}

/// The distribution of a deviation within its tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Distribution {
    /// A normal one whose double standard deviation is the tolerance, cut off there.
    Normal,
    /// All sizes alike.
    Uniform,
}

/// Options of the report on tolerances.
#[derive(Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ToleranceOptions {
    /// The tolerance of radii of curvature, per cent.
    radius_percent: f64,
    /// The tolerance of thicknesses and gaps, mm.
    thickness_mm: f64,
    /// The tolerance of indices.
    index: f64,
    /// The tolerance of the places of elements, mm.
    decenter_mm: f64,
    /// The tolerance of the tilts of elements, degrees.
    tilt_deg: f64,
    /// Number of lenses drawn at random.
    trials: usize,
    seed: u64,
    /// Frequency of the MTF, line pairs/mm.
    frequency_per_mm: f64,
    /// Number of rays over the width of a beam.
    rays: usize,
    compensator: Compensator,
    distribution: Distribution,
}

/// The measures of a lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Measures {
    /// Root mean square radius of the spots, over all fields, mm.
    rms_mm: f64,
    /// The lowest contrast of sagittal and tangential lines over the fields.
    mtf: f64,
    /// Distortion from f tan θ of the largest field, per cent; 0 without a field off the axis.
    distortion_percent: f64,
    /// Displacement of the film that makes up for the deviations, mm, or of groups as a part of their way.
    compensation: f64,
}

/// The effect of one deviation.
#[derive(Serialize)]
struct Sensitivity {
    #[serde(flatten)]
    deviation: Deviation,
    /// Size of the deviation, in the unit of its kind: a radius by per cent.
    size: f64,
    /// Measures with the deviation added, and taken away; `None`: the lens passes no light then.
    plus: Option<Measures>,
    minus: Option<Measures>,
}

/// The measures that a part of the lenses reach.
#[derive(Serialize)]
struct Quantile {
    part: f64,
    rms_mm: f64,
    mtf: f64,
    /// Distance of the distortion from the nominal one.
    distortion_percent: f64,
}

/// The result of the report.
#[derive(Serialize)]
pub(super) struct ToleranceResult {
    fields_deg: Vec<f64>,
    options: ToleranceOptions,
    nominal: Measures,
    /// One by one, the worst first.
    sensitivities: Vec<Sensitivity>,
    /// The lenses drawn at random; `None`: the lens passes no light.
    trials: Vec<Option<Measures>>,
    quantiles: Vec<Quantile>,
}

impl LensReport for ToleranceOptions {
    const NAME: &'static str = "tolerance";
    type Found = ToleranceResult;

    fn check(&self) -> Result<(), ReportError> {
        within(self.trials, MOST_TRIALS, "lenses")?;
        within(self.rays, MOST_RAYS_OF_A_SIDE, "rays over the width of a beam")?;
        let tolerances = [self.radius_percent, self.thickness_mm, self.index, self.decenter_mm, self.tilt_deg];
        if !tolerances.iter().all(|size| (0.0..=50.0).contains(size)) {
            return Err(ReportError::OutOfRange("tolerances are from 0 to 50".to_owned()));
        }
        let is_good = (1e-6..=1e6).contains(&self.frequency_per_mm);
        let what = || ReportError::OutOfRange(format!("a frequency of {} lines/mm", self.frequency_per_mm));
        is_good.then_some(()).ok_or_else(what)
    }

    fn find(&self, subject: ReportedLens<'_>) -> Result<ToleranceResult, ReportError> {
        let bench = Bench::new(self, &subject)?;
        let wrong = || ReportError::Lens {
            lens: subject.system.name().to_owned(),
            why: "nothing comes through it from some of the fields".to_owned(),
        };
        let nominal = bench.measured(&[]).ok_or_else(wrong)?;
        let deviations = bench.lens.deviations();
        let sized = |one: &Deviation| (*one, bench.size(one.kind));
        let known: Vec<(Deviation, f64)> = deviations.iter().map(sized).filter(|(_, size)| *size > 0.0).collect();
        let mut sensitivities: Vec<Sensitivity> = known
            .par_iter()
            .map(|&(deviation, size)| Sensitivity {
                deviation,
                size: if deviation.kind == DeviationKind::Radius { 100.0 * size } else { size },
                plus: bench.measured(&[(deviation, size)]),
                minus: bench.measured(&[(deviation, -size)]),
            })
            .collect();
        let worst = |one: &Sensitivity| {
            [one.plus, one.minus].iter().map(|m| m.map_or(f64::INFINITY, |m| m.rms_mm)).fold(0.0, f64::max)
        };
        sensitivities.sort_by(|a, b| worst(b).total_cmp(&worst(a)));
        let trial = |number: usize| {
            let mut random = Random::new(self.seed, number as u64);
            let by: Vec<_> = known.iter().map(|&(one, size)| (one, size * random.within(self.distribution))).collect();
            bench.measured(&by)
        };
        let trials: Vec<Option<Measures>> = (0..self.trials).into_par_iter().map(trial).collect();
        let quantiles = PARTS.map(|part| quantile(&trials, &nominal, part)).into();
        Ok(ToleranceResult {
            fields_deg: bench.fields_deg,
            options: self.clone(),
            nominal,
            sensitivities,
            trials,
            quantiles,
        })
    }
}

/// The lens on which deviations are tried.
struct Bench<'a> {
    options: &'a ToleranceOptions,
    /// The lens without parts that move.
    lens: Prescription,
    /// The lens with its groups at a travel of the focus, if they focus it.
    by_travel: Option<Box<dyn Fn(f64) -> Prescription + Sync + 'a>>,
    settings: LensSettings,
    scale: f64,
    focus: Focus,
    /// The film from the last vertex.
    film_mm: f64,
    /// Depth of focus in which a spot grows by as much as a pixel would show, mm.
    aside_mm: f64,
    wavelengths_nm: Vec<f64>,
    main: usize,
    azimuth_rad: f64,
    fields_deg: Vec<f64>,
}

impl<'a> Bench<'a> {
    fn new(options: &'a ToleranceOptions, subject: &ReportedLens<'a>) -> Result<Self, ReportError> {
        let (lens, settings) = System::standing(subject.lens, subject.lens_settings, 0.0)?;
        let focuses_inside = subject.lens.moving.as_ref().is_some_and(|moving| moving.focuses());
        let is_near = subject.settings.focus_distance_mm.is_some_and(f64::is_finite);
        if focuses_inside && is_near {
            let why = "it focuses inside: its tolerances are those at infinity: leave out --focus-distance".to_owned();
            return Err(ReportError::Lens { lens: subject.system.name().to_owned(), why });
        }
        let (published, own) = (subject.lens, subject.lens_settings);
        let by_travel = focuses_inside.then(|| -> Box<dyn Fn(f64) -> Prescription + Sync + 'a> {
            let rest = lens.clone();
            Box::new(move |travel| {
                System::standing(published, own, travel).map_or_else(|_| rest.clone(), |found| found.0)
            })
        });
        let scale = subject.system.scale();
        let analysis = &subject.analysis;
        let film = analysis.film();
        let focus = Focus::new(subject.system, subject.main_nm, subject.settings.focus_distance_mm)?;
        // A beam of this f-number is as wide as the Airy disc so far from its focus.
        let f_number = focus.working_f_number.unwrap_or(4.0);
        let aside_mm = ASIDE * 2.0 * f_number * f_number * subject.main_nm * 1e-6;
        let both = |angle: &f64| if *angle == 0.0 { vec![0.0] } else { vec![*angle, -*angle] };
        Ok(Self {
            options,
            lens,
            by_travel,
            settings: LensSettings { focal_length: FocalLength::Scale(scale), ..settings },
            scale,
            film_mm: film.z_mm - subject.system.last_vertex_z_mm(),
            focus,
            aside_mm,
            wavelengths_nm: analysis.wavelengths_nm().collect(),
            main: subject.settings.main(),
            azimuth_rad: subject.settings.azimuth_deg.to_radians(),
            // What is out of place is not the same on both sides.
            fields_deg: subject.fields_deg.iter().flat_map(both).collect(),
        })
    }

    /// The tolerance of a kind, in its unit.
    fn size(&self, kind: DeviationKind) -> f64 {
        let o = self.options;
        match kind {
            DeviationKind::Radius => o.radius_percent / 100.0,
            DeviationKind::Thickness => o.thickness_mm,
            DeviationKind::Index => o.index,
            DeviationKind::DecenterX | DeviationKind::DecenterY => o.decenter_mm,
            DeviationKind::TiltX | DeviationKind::TiltY => o.tilt_deg,
        }
    }

    /// The measures of the lens with deviations, refocused; `None` where nothing comes through from a field.
    fn measured(&self, by: &[(Deviation, f64)]) -> Option<Measures> {
        let by: Vec<(Deviation, f64)> = by.iter().map(|&(one, size)| (one, self.published(one.kind, size))).collect();
        let system = |lens: &Prescription| System::new(&lens.deviated(&by), &self.settings).ok();
        match (self.options.compensator, &self.by_travel) {
            (Compensator::None, _) => self.on_film(&system(&self.lens)?, 0.0, 0.0),
            (Compensator::Focus, Some(lens_at)) => {
                let at = |travel: f64| {
                    let system = system(&lens_at(travel))?;
                    let analysis = self.analysis(&system, 0.0)?;
                    self.mean_square(&analysis)
                };
                let travel = lowest(at)?;
                self.on_film(&system(&lens_at(travel))?, 0.0, travel)
            }
            _ => {
                let system = system(&self.lens)?;
                let at = |moved_mm: f64| self.mean_square(&self.analysis(&system, moved_mm)?);
                let [before, here, behind] = [at(-self.aside_mm)?, at(0.0)?, at(self.aside_mm)?];
                let bend = before - 2.0 * here + behind;
                let moved_mm = if bend > 0.0 { 0.5 * self.aside_mm * (before - behind) / bend } else { 0.0 };
                self.on_film(&system, moved_mm, moved_mm)
            }
        }
    }

    /// The size of a deviation of the lens as published.
    fn published(&self, kind: DeviationKind, size: f64) -> f64 {
        match kind {
            DeviationKind::Thickness | DeviationKind::DecenterX | DeviationKind::DecenterY => size / self.scale,
            _ => size,
        }
    }

    fn analysis<'s>(&self, system: &'s System, moved_mm: f64) -> Option<Analysis<'s>> {
        let film_z_mm = system.last_vertex_z_mm() + self.film_mm + moved_mm;
        let focus = Focus { film_z_mm, ..self.focus };
        Analysis::new(system, focus, &self.wavelengths_nm, self.main, self.azimuth_rad)
    }

    /// The mean square radius of the spots, mm².
    fn mean_square(&self, analysis: &Analysis<'_>) -> Option<f64> {
        let squares =
            self.fields_deg.iter().map(|&angle| Some(analysis.spot(angle, self.options.rays)?.rms_mm.powi(2)));
        Some(squares.sum::<Option<f64>>()? / self.fields_deg.len() as f64)
    }

    fn on_film(&self, system: &System, moved_mm: f64, compensation: f64) -> Option<Measures> {
        let analysis = self.analysis(system, moved_mm)?;
        let rms_mm = self.mean_square(&analysis)?.sqrt();
        let contrast = |&angle: &f64| {
            let found = analysis.mtf(angle, self.options.frequency_per_mm, 2).ok()?;
            Some(found.sagittal.contrast[1].min(found.tangential.contrast[1]))
        };
        let mtf = self.fields_deg.iter().map(contrast).try_fold(1.0f64, |least, one| Some(least.min(one?)))?;
        let largest = self.fields_deg.iter().fold(0.0, |most: f64, angle| most.max(*angle));
        let distortion_percent = if largest > 0.0 && largest < 90.0 {
            let [above, below] = [largest, -largest].map(|angle| analysis.chief_ray(angle));
            let height_mm = 0.5 * (above?.height_mm - below?.height_mm);
            let straight_mm = analysis.height_by_slope_mm() * largest.to_radians().tan();
            100.0 * (height_mm / straight_mm - 1.0)
        } else {
            0.0
        };
        let found = Measures { rms_mm, mtf, distortion_percent, compensation };
        [rms_mm, mtf, distortion_percent].iter().all(|one| one.is_finite()).then_some(found)
    }
}

/// The travel at which a value is lowest, by the golden section.
fn lowest(at: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let (mut low, mut high) = (-TRAVEL, TRAVEL);
    let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut of_a, mut of_b) = (at(a)?, at(b)?);
    for _ in 0..STEPS {
        if of_a < of_b {
            (high, b, of_b) = (b, a, of_a);
            a = inner(low, high)[0];
            of_a = at(a)?;
        } else {
            (low, a, of_a) = (a, b, of_b);
            b = inner(low, high)[1];
            of_b = at(b)?;
        }
    }
    Some(0.5 * (low + high))
}

/// The measures that this part of the lenses reach, each by itself; those that pass no light reach none.
fn quantile(trials: &[Option<Measures>], nominal: &Measures, part: f64) -> Quantile {
    let at = |measure: &dyn Fn(&Measures) -> f64, none: f64| {
        let mut values: Vec<f64> = trials.iter().map(|one| one.as_ref().map_or(none, measure)).collect();
        values.sort_by(f64::total_cmp);
        let place = ((part * values.len() as f64).ceil() as usize).clamp(1, values.len());
        values[place - 1]
    };
    Quantile {
        part,
        rms_mm: at(&|one| one.rms_mm, f64::INFINITY),
        mtf: -at(&|one| -one.mtf, 0.0),
        distortion_percent: at(&|one| (one.distortion_percent - nominal.distortion_percent).abs(), f64::INFINITY),
    }
}

/// Random numbers of a lens (splitmix64: Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn new(seed: u64, number: u64) -> Self {
        let mut start = Self(seed);
        let mixed = start.bits();
        Self(mixed ^ number.wrapping_mul(0xd134_2543_de82_ef95))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A uniform number from 0 to 1, without 0.
    fn unit(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// A number from -1 to 1 by the distribution.
    fn within(&mut self, distribution: Distribution) -> f64 {
        match distribution {
            Distribution::Uniform => 2.0 * self.unit() - 1.0,
            Distribution::Normal => loop {
                // Box and Muller 1958; half a tolerance is a standard deviation.
                let radius = (-2.0 * self.unit().ln()).sqrt();
                let value = 0.5 * radius * (std::f64::consts::TAU * self.unit()).cos();
                if value.abs() <= 1.0 {
                    return value;
                }
            },
        }
    }
}

#[cfg(test)]
mod tests;

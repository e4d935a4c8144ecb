//! A lens of a lensfun database, and its calibrations between those that were measured.

use super::distortion::{Distortion, DistortionModel};
use super::lateral_colour::{LateralColour, LateralColourModel};
use super::vignetting::{Vignetting, VignettingModel};
use super::{Projection, Sensor};

/// A measured distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistortionRow {
    /// The marked focal length, mm.
    pub focal_mm: f64,
    /// The measured focal length, mm; where the database has none, the marked one by the formula's scale on the axis, as lensfun takes it.
    pub real_focal_mm: f64,
    /// The formula and its terms.
    pub model: DistortionModel,
}

/// A measured lateral colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralColourRow {
    /// The marked focal length, mm.
    pub focal_mm: f64,
    /// The formula and its terms.
    pub model: LateralColourModel,
}

/// A measured vignetting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VignettingRow {
    /// The marked focal length, mm.
    pub focal_mm: f64,
    /// The f-number.
    pub f_number: f64,
    /// The distance of focus, m.
    pub distance_m: f64,
    /// The formula and its terms.
    pub model: VignettingModel,
}

/// Measurements with one sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationSet {
    /// The sensor.
    pub sensor: Sensor,
    /// Distortions, in the order of the database.
    pub distortion: Vec<DistortionRow>,
    /// Lateral colours, in the order of the database.
    pub lateral_colour: Vec<LateralColourRow>,
    /// Vignettings, in the order of the database.
    pub vignetting: Vec<VignettingRow>,
}

/// A lens of a lensfun database.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibratedLens {
    /// The maker.
    pub maker: String,
    /// The model, by the first name in its file that is in no other language than English.
    pub model: String,
    /// The mounts.
    pub mounts: Vec<String>,
    /// The projection of the picture without distortion; `None`: a panoramic one.
    pub projection: Option<Projection>,
    /// The shortest and the longest marked focal length, mm.
    pub focal_range_mm: [f64; 2],
    /// Centre of the calibration, right and down from the middle of the picture, in halves of its short side.
    pub centre: [f64; 2],
    /// Measurements, one entry a sensor, in the order of the database.
    pub sets: Vec<CalibrationSet>,
    /// The file and its line.
    pub place: (String, u32),
}

/// A sensor may be so much larger than the calibration's, as crop factors are rounded (lensfun's `lens.cpp`).
const SAME_CROP: f64 = 0.96;
/// Power of the inverse distance that weights measured vignettings (Shepard 1968, as lensfun has it).
const SHEPARD_POWER: f64 = 3.5;
/// Distances of vignetting up to which a measurement stands for itself, and from which there is none.
const MEASURED: f64 = 1e-4;
const TOO_FAR: f64 = 1.0;

/// Maker and model; the maker only once.
pub(super) fn full_name(maker: &str, model: &str) -> String {
    let begins = model.to_lowercase().starts_with(&maker.to_lowercase());
    if begins { model.to_owned() } else { format!("{maker} {model}") }
}

impl CalibratedLens {
    /// Maker and model; the maker only once.
    pub fn name(&self) -> String {
        full_name(&self.maker, &self.model)
    }

    /// The measured marked focal length that is nearest to a focal length, both mm; that itself where nothing was measured.
    pub fn nearest_marked_mm(&self, focal_mm: f64) -> f64 {
        let distortions = self.sets.iter().flat_map(|set| set.distortion.iter().map(|row| row.focal_mm));
        let lights = self.sets.iter().flat_map(|set| set.vignetting.iter().map(|row| row.focal_mm));
        let nearest = |found: f64, next: f64| {
            if (next - focal_mm).abs() < (found - focal_mm).abs() { next } else { found }
        };
        distortions.chain(lights).reduce(nearest).unwrap_or(focal_mm)
    }

    /// The set that was measured with the largest sensor that is no smaller than the camera's, and fulfils `has`.
    fn set(&self, crop_factor: f64, has: impl Fn(&CalibrationSet) -> bool) -> Option<&CalibrationSet> {
        let ratio = |set: &CalibrationSet| crop_factor / set.sensor.crop_factor;
        self.sets.iter().filter(|set| has(set) && ratio(set) >= SAME_CROP).min_by(|a, b| ratio(a).total_cmp(&ratio(b)))
    }

    /// Distortion on a camera of this crop factor at a marked focal length: between measured ones interpolated, beyond them that of the
    /// nearest. `None`: none was measured with a sensor as large.
    pub fn distortion(&self, crop_factor: f64, focal_mm: f64) -> Option<Distortion> {
        let set = self.set(crop_factor, |set| !set.distortion.is_empty())?;
        let first = set.distortion.first()?.model;
        let kind = std::mem::discriminant(&first);
        let rows = set.distortion.iter().filter(|row| std::mem::discriminant(&row.model) == kind);
        let near = Neighbours::about(rows, focal_mm, |row| row.focal_mm)?;
        let real_focal_mm = near.between(|row| row.real_focal_mm);
        let model = first.with_terms(|i| {
            let power = first.scale_power(i);
            near.scaled(power, |row| row.focal_mm, |row| row.model.terms()[i])
        });
        Some(Distortion { model, focal_mm: near.focal_mm, real_focal_mm, sensor: set.sensor })
    }

    /// The focal length by the measurement of distortion, mm; the marked one where there is none.
    fn real_focal_mm(&self, crop_factor: f64, focal_mm: f64) -> f64 {
        self.distortion(crop_factor, focal_mm).map_or(focal_mm, |distortion| distortion.real_focal_mm)
    }

    /// Lateral colour on a camera of this crop factor at a marked focal length, interpolated as distortion is.
    pub fn lateral_colour(&self, crop_factor: f64, focal_mm: f64) -> Option<LateralColour> {
        let set = self.set(crop_factor, |set| !set.lateral_colour.is_empty())?;
        let first = set.lateral_colour.first()?.model;
        let kind = std::mem::discriminant(&first);
        let rows = set.lateral_colour.iter().filter(|row| std::mem::discriminant(&row.model) == kind);
        let near = Neighbours::about(rows, focal_mm, |row| row.focal_mm)?;
        let model = first.with_terms(|i| {
            let power = first.scale_power(i);
            std::array::from_fn(|channel| near.scaled(power, |row| row.focal_mm, |row| row.model.terms()[i][channel]))
        });
        let real_focal_mm = self.real_focal_mm(crop_factor, focal_mm);
        Some(LateralColour { model, focal_mm: near.focal_mm, real_focal_mm, sensor: set.sensor })
    }

    /// Vignetting on a camera of this crop factor at a marked focal length, an f-number and a distance: the measured ones weighted by
    /// how near they are (Shepard's method, as lensfun's `InterpolateVignetting`). `None`: none was measured near, or with a sensor as
    /// large.
    pub fn vignetting(&self, crop_factor: f64, focal_mm: f64, f_number: f64, distance_m: f64) -> Option<Vignetting> {
        let set = self.set(crop_factor, |set| !set.vignetting.is_empty())?;
        let first = set.vignetting.first()?.model;
        let kind = std::mem::discriminant(&first);
        let real_focal_mm = self.real_focal_mm(crop_factor, focal_mm);
        let found = |model, apart| Some(Vignetting { model, real_focal_mm, sensor: set.sensor, apart });
        let (mut terms, mut weights, mut nearest) = ([0.0; 3], 0.0, f64::INFINITY);
        for row in set.vignetting.iter().filter(|row| std::mem::discriminant(&row.model) == kind) {
            let apart = self.apart(row, focal_mm, f_number, distance_m);
            if apart < MEASURED {
                return found(row.model, 0.0);
            }
            nearest = nearest.min(apart);
            let weight = apart.powf(-SHEPARD_POWER);
            for (i, (sum, term)) in terms.iter_mut().zip(row.model.terms()).enumerate() {
                *sum += weight * term * row.focal_mm.powf(first.scale_power(i));
            }
            weights += weight;
        }
        let terms = std::array::from_fn(|i| terms[i] / (weights * focal_mm.powf(first.scale_power(i))));
        let is_known = nearest <= TOO_FAR && terms.iter().all(|term: &f64| term.is_finite());
        is_known.then(|| found(first.with_terms(terms), nearest)).flatten()
    }

    /// The distance of a measured vignetting from a setting (`__vignetting_dist` in lensfun's `lens.cpp`).
    fn apart(&self, row: &VignettingRow, focal_mm: f64, f_number: f64, distance_m: f64) -> f64 {
        let [shortest, longest] = self.focal_range_mm;
        let range = if longest != shortest { longest - shortest } else { 1.0 };
        let focal = (row.focal_mm - focal_mm) / range;
        let aperture = 4.0 / row.f_number - 4.0 / f_number;
        let distance = 0.1 / row.distance_m - 0.1 / distance_m;
        (focal * focal + aperture * aperture + distance * distance).sqrt()
    }
}

/// The measurements about a focal length: up to two above it and two below.
struct Neighbours<'a, R> {
    /// The second above, the first above, the first below, the second below; where one side is missing the other is on both.
    rows: [Option<&'a R>; 4],
    /// The measured row that stands for itself, where the focal length was measured or lies beyond all.
    alone: Option<&'a R>,
    /// The part of the way from the first above to the first below.
    t: f64,
    /// The focal length that the result is of, mm: that of the row beyond all.
    focal_mm: f64,
}

impl<'a, R> Neighbours<'a, R> {
    /// The rows about a focal length; `None`: there is no row.
    ///
    /// A row as near as one before it takes the second place, as in lensfun's `__insert_spline`.
    fn about(rows: impl Iterator<Item = &'a R>, focal_mm: f64, focal_of: impl Fn(&R) -> f64) -> Option<Self> {
        let mut found: [Option<&R>; 4] = [None; 4];
        let mut apart = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
        for row in rows {
            let d = focal_mm - focal_of(row);
            if d == 0.0 {
                return Some(Self { rows: [None; 4], alone: Some(row), t: 0.0, focal_mm });
            }
            let (first, second, is_nearer, is_second) =
                if d < 0.0 { (1, 0, d > apart[1], d > apart[0]) } else { (2, 3, d < apart[2], d < apart[3]) };
            if is_nearer {
                (apart[second], found[second]) = (apart[first], found[first]);
                (apart[first], found[first]) = (d, Some(row));
            } else if is_second {
                (apart[second], found[second]) = (d, Some(row));
            }
        }
        match (found[1], found[2]) {
            (Some(above), Some(below)) => {
                let t = (focal_mm - focal_of(above)) / (focal_of(below) - focal_of(above));
                Some(Self { rows: found, alone: None, t, focal_mm })
            }
            (alone, other) => {
                let alone = alone.or(other)?;
                Some(Self { rows: [None; 4], alone: Some(alone), t: 0.0, focal_mm: focal_of(alone) })
            }
        }
    }

    /// A value of the rows at the focal length: a cubic between the two nearest with the slopes of their neighbours (`_lf_interpolate`).
    fn between(&self, value: impl Fn(&R) -> f64) -> f64 {
        if let Some(row) = self.alone {
            return value(row);
        }
        let [before, Some(from), Some(to), after] = self.rows.map(|row| row.map(&value)) else { return 0.0 };
        let t = self.t;
        let slope_from = before.map_or(to - from, |before| 0.5 * (to - before));
        let slope_to = after.map_or(to - from, |after| 0.5 * (after - from));
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * from
            + (t3 - 2.0 * t2 + t) * slope_from
            + (3.0 * t2 - 2.0 * t3) * to
            + (t3 - t2) * slope_to
    }

    /// [`Neighbours::between`] of a value that goes with a power of the focal length.
    fn scaled(&self, power: f64, focal_of: impl Fn(&R) -> f64, value: impl Fn(&R) -> f64) -> f64 {
        let scale = |focal_mm: f64| if power == 0.0 { 1.0 } else { focal_mm.powf(power) };
        match self.alone {
            Some(row) => value(row),
            None => self.between(|row| value(row) * scale(focal_of(row))) / scale(self.focal_mm),
        }
    }
}

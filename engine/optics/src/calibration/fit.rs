//! The parameters of a model that fit directions seen at points of a picture: least squares of the distances, pixels, between the points and
//! those at which the model sees the directions.
//!
//! The search is made again where the best parameters of a formula fold within the picture, within the range in which the model can be
//! inverted: a step after which a direction of the picture lies beyond a fold is not taken. A model that was found does not fold where it
//! was asked for.

use super::setup::Formula;
use super::{Calibration, CalibrationError, Model};
use crate::least_squares::{Parameter, minimise};
use glam::{DVec2, DVec3};
use thiserror::Error;

/// Parameters that say where the picture's plane lies; all others are coefficients.
const FRAME: [&str; 7] = ["fx", "fy", "cx", "cy", "c", "d", "e"];

/// The least determinant of a distortion's derivative in a search that stays away from folds, parts of that of a fisheye.
const LEAST_SLOPE: f64 = 0.05;

/// A direction that is seen at a point of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenDirection {
    /// The point, pixels from the picture's upper left corner.
    pub point_px: DVec2,
    /// The direction, camera space, of any length.
    pub direction: DVec3,
    /// The part of the picture that it stands for; the sum over all is one.
    pub weight: f64,
}

/// The knowledge of a camera before its model is fitted, and the parameters that are to be found.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraToFit {
    /// The model.
    pub model: Model,
    /// Width and height of the picture, pixels.
    pub size_px: [u32; 2],
    /// Focal lengths across and down, pixels, at which the search starts.
    pub focal_px: [f64; 2],
    /// The point where the axis intersects the picture, pixels from its upper left corner.
    pub centre_px: [f64; 2],
    /// True if nothing but the distance from the axis counts, and pixels are square: then one focal length serves for both directions, and the
    /// principal point stays on the axis.
    pub is_symmetric: bool,
    /// The coefficients that are to be found, by name, the others staying as they are without distortion; `None`: those that the symmetry
    /// leaves.
    pub coefficients: Option<Vec<String>>,
}

/// A model that was fitted.
#[derive(Clone, Debug)]
pub struct FittedCalibration {
    /// The model with its parameters.
    pub calibration: Calibration,
    /// The names of the parameters that were found.
    pub free: Vec<&'static str>,
    /// Steps of the search.
    pub steps: usize,
}

/// The reason why a model cannot be fitted.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FitError {
    /// The model is none that is fitted.
    #[error("the model {} is not fitted; use one of {}", .0.name(), fitted_names())]
    Model(Model),
    /// There is no such coefficient.
    #[error("the model {} has no coefficient '{name}'; it has {}", .model.name(), .model.coefficients().join(", "))]
    Coefficient {
        /// The model.
        model: Model,
        /// The name that was asked for.
        name: String,
    },
    /// There are fewer directions than parameters.
    #[error("{seen} points of the picture are lit, too few for {parameters} parameters; make the film smaller")]
    TooFew {
        /// Directions that are seen.
        seen: usize,
        /// Parameters to be found.
        parameters: usize,
    },
    /// The model has no place for some of the directions.
    #[error(
        "the model {} cannot see all of the lit picture, which looks up to {largest_deg:.1} degrees from the axis; use one that can, as fisheye",
        .model.name()
    )]
    NotSeen {
        /// The model.
        model: Model,
        /// The largest angle from the axis.
        largest_deg: f64,
    },
    /// The parameters make no camera.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
}

fn fitted_names() -> String {
    let fitted = Model::ALL.into_iter().filter(|model| model.is_fitted());
    fitted.map(Model::name).collect::<Vec<_>>().join(", ")
}

impl Model {
    /// True if [`fit`] finds its parameters.
    pub fn is_fitted(self) -> bool {
        self.undistorted([1.0; 2], [0.0; 2]).is_some() || self.is_f_theta()
    }

    fn is_f_theta(self) -> bool {
        matches!(self, Self::FThetaToAngle | Self::FThetaToPixels)
    }

    /// The names of its coefficients: of the parameters that are neither a focal length nor the principal point, nor a shear of the pixels.
    pub fn coefficients(self) -> Vec<&'static str> {
        self.parameter_names().iter().copied().filter(|name| !FRAME.contains(name)).collect()
    }

    /// The coefficients that are found where none are named.
    fn usual_coefficients(self, is_symmetric: bool) -> Vec<&'static str> {
        let (radial, others): (&[_], &[_]) = match self {
            Self::OpenCv => (&["k1", "k2", "k3"], &["p1", "p2"]),
            Self::ThinPrismFisheye => (&["k1", "k2", "k3", "k4"], &["p1", "p2", "sx1", "sy1"]),
            Self::RadTanThinPrismFisheye => {
                (&["k0", "k1", "k2", "k3", "k4", "k5"], &["p0", "p1", "s0", "s1", "s2", "s3"])
            }
            Self::Fisheye => (&["k1", "k2", "k3", "k4"], &["alpha"]),
            Self::Omni => (&["xi", "k1", "k2"], &["p1", "p2"]),
            // Odd powers make a function that is smooth on the axis.
            Self::FThetaToAngle | Self::FThetaToPixels => (&["k1", "k3", "k5", "k7"], &[]),
            _ => return self.coefficients(),
        };
        if is_symmetric { radial.to_vec() } else { [radial, others].concat() }
    }
}

/// A parameter to be found: its places in the model's list, which share one value, and its name.
struct Free {
    places: Vec<usize>,
    name: &'static str,
    parameter: Parameter,
}

/// The model whose places of these directions are nearest to the given ones.
///
/// # Errors
/// [`FitError`].
pub fn fit(camera: &CameraToFit, seen: &[SeenDirection]) -> Result<FittedCalibration, FitError> {
    if !camera.model.is_fitted() {
        return Err(FitError::Model(camera.model));
    }
    let free = free_parameters(camera, seen)?;
    if 2 * seen.len() < free.len() || seen.is_empty() {
        return Err(FitError::TooFew { seen: seen.len(), parameters: free.len() });
    }
    let values = start(camera);
    let first = Calibration::new(camera.model, camera.size_px, &values)?;
    if seen.iter().any(|one| first.project(one.direction).is_err()) {
        let angle = |one: &SeenDirection| one.direction.truncate().length().atan2(one.direction.z).to_degrees();
        let largest_deg = seen.iter().map(angle).fold(0.0, f64::max);
        return Err(FitError::NotSeen { model: camera.model, largest_deg });
    }
    let search = Search { camera, seen, free: &free };
    let frame = free.iter().filter(|one| FRAME.contains(&one.name)).count().max(1);
    let by_one: Vec<usize> = (frame..=free.len()).collect();
    // By the formula alone; if that folds in the picture, from there with what keeps it from it; and within its fold, one coefficient more at
    // a time and all at once, where one way may end before the other does.
    let all = vec![free.len()];
    let ways = [
        (by_one.clone(), Bound::None),
        (all.clone(), Bound::Slope(1e4)),
        (all, Bound::Slope(1e6)),
        (by_one, Bound::Fold),
        (vec![frame, free.len()], Bound::Fold),
    ];
    let (mut best, mut steps): (Option<(f64, Vec<f64>)>, usize) = (None, 0);
    let mut before = values.clone();
    for (counts, bound) in ways {
        let from = if bound == Bound::Fold { &values } else { &before };
        let (found, now) = search.through(from, &counts, bound);
        steps += now;
        if let Some(all) = search.residuals(&found, Bound::Fold) {
            let sum: f64 = all.iter().map(|r| r * r).sum();
            if best.as_ref().is_none_or(|(least, _)| sum < 0.999 * least) {
                best = Some((sum, found.clone()));
            }
            if bound == Bound::None {
                break;
            }
        }
        before = found;
    }
    let (_, values) = best.unwrap_or((0.0, values));
    let calibration = Calibration::new(camera.model, camera.size_px, &values)?;
    Ok(FittedCalibration { calibration, free: free.iter().map(|one| one.name).collect(), steps })
}

/// A search for parameters.
struct Search<'a> {
    camera: &'a CameraToFit,
    seen: &'a [SeenDirection],
    free: &'a [Free],
}

impl Search<'_> {
    /// The best parameters with the first so many of them free, for one count after the other; and steps.
    fn through(&self, start: &[f64], counts: &[usize], bound: Bound) -> (Vec<f64>, usize) {
        let (mut values, mut steps) = (start.to_vec(), 0);
        for now in counts.iter().map(|&count| &self.free[..count]) {
            let parameters: Vec<Parameter> =
                now.iter().map(|one| Parameter { start: values[one.places[0]], ..one.parameter }).collect();
            let with = |found: &[f64]| {
                let mut all = values.clone();
                for (one, value) in now.iter().zip(found) {
                    one.places.iter().for_each(|&place| all[place] = *value);
                }
                all
            };
            let Some(found) = minimise(&parameters, |found| self.residuals(&with(found), bound)) else { break };
            (values, steps) = (with(&found.values), steps + found.steps);
        }
        (values, steps)
    }

    /// Residuals of a model: distances of directions' places by the model from their places by the lens, pixels by the root of the weight:
    /// x and y of each, and the cost of a bound. `None`: some direction has no place.
    fn residuals(&self, values: &[f64], bound: Bound) -> Option<Vec<f64>> {
        let CameraToFit { model, size_px, .. } = *self.camera;
        let mut all = Vec::with_capacity(3 * self.seen.len());
        let formula = if bound == Bound::Fold { None } else { Formula::new(model, size_px, values) };
        let Some(formula) = formula else {
            let calibration = Calibration::new(model, size_px, values).ok()?;
            for one in self.seen {
                let off = (calibration.project(one.direction).ok()? - one.point_px) * one.weight.sqrt();
                all.extend([off.x, off.y]);
            }
            return Some(all);
        };
        for one in self.seen {
            let (point, slope) = formula.project(one.direction)?;
            let off = (point - one.point_px) * one.weight.sqrt();
            all.extend([off.x, off.y]);
            if let Bound::Slope(cost_px) = bound {
                // A picture whose heights go with the angle shrinks a plane's by the fourth power of the cosine, about.
                let cosine = if model.is_flat() { one.direction.z / one.direction.length() } else { 1.0 };
                let short = (LEAST_SLOPE * cosine.powi(4) - slope).max(0.0) / cosine.powi(4);
                all.push(cost_px * short * one.weight.sqrt());
            }
        }
        Some(all)
    }
}

/// The cost that keeps a search from formulas that fold.
#[derive(Clone, Copy, PartialEq)]
enum Bound {
    /// No bound.
    None,
    /// The cost of slopes that are flat or turned over, pixels.
    Slope(f64),
    /// Points beyond a fold have no place.
    Fold,
}

/// The parameters at which the search starts: the lens about its axis, without distortion.
fn start(camera: &CameraToFit) -> Vec<f64> {
    let CameraToFit { model, focal_px, centre_px, .. } = camera;
    let names = model.parameter_names();
    let place = |name: &str| names.iter().position(|known| *known == name);
    if model.is_f_theta() {
        let mut all = vec![0.0; names.len()];
        let focal = 0.5 * (focal_px[0] + focal_px[1]);
        all[..2].copy_from_slice(centre_px);
        all[2] = focal_px[0] / focal_px[1];
        all[5] = if *model == Model::FThetaToPixels { focal } else { focal.recip() };
        return all;
    }
    let mut all = model.undistorted(*focal_px, *centre_px).unwrap_or_default();
    let middling: &[(&str, f64)] = match model {
        Model::Fov => &[("omega", 0.5)],
        Model::DoubleSphere | Model::Eucm => &[("alpha", 0.5)],
        Model::Omni => &[("xi", 1.0)],
        _ => &[],
    };
    for (name, value) in middling {
        if let Some(place) = place(name) {
            all[place] = *value;
        }
    }
    if *model == Model::Omni {
        // On the axis a direction is shortened by one and xi.
        all[..2].iter_mut().for_each(|focal| *focal *= 2.0);
    }
    all
}

fn free_parameters(camera: &CameraToFit, seen: &[SeenDirection]) -> Result<Vec<Free>, FitError> {
    let CameraToFit { model, is_symmetric, .. } = *camera;
    let names = model.parameter_names();
    let start = start(camera);
    let place = |name: &str| names.iter().position(|known| *known == name);
    let mut free = Vec::new();
    let mut add = |wanted: &[&str], scale: f64, bounds: [f64; 2]| {
        let places: Vec<usize> = wanted.iter().filter_map(|name| place(name)).collect();
        if let Some(&first) = places.first() {
            let parameter = Parameter { start: start[first], scale, bounds };
            free.push(Free { places, name: names[first], parameter });
        }
    };
    let any = [f64::NEG_INFINITY, f64::INFINITY];
    let above_zero = [f64::MIN_POSITIVE, f64::INFINITY];
    if is_symmetric {
        add(&["fx", "fy"], camera.focal_px[0], above_zero);
    } else {
        add(&["fx"], camera.focal_px[0], above_zero);
        add(&["fy"], camera.focal_px[1], above_zero);
        add(&["cx"], 1.0, any);
        add(&["cy"], 1.0, any);
        add(&["c"], 1.0, above_zero);
    }
    let wanted: Vec<&'static str> = match &camera.coefficients {
        None => model.usual_coefficients(is_symmetric),
        Some(asked) => {
            let known = model.coefficients();
            let of = |name: &String| known.iter().find(|known| *known == name).copied();
            let missing = |name: &String| FitError::Coefficient { model, name: name.clone() };
            asked.iter().map(|name| of(name).ok_or_else(|| missing(name))).collect::<Result<_, _>>()?
        }
    };
    let centre = DVec2::from(camera.centre_px);
    let farthest_px = seen.iter().map(|one| (one.point_px - centre).length()).fold(1.0, f64::max);
    let focal = 0.5 * (camera.focal_px[0] + camera.focal_px[1]);
    let radius = plane_radius(model, seen);
    for name in wanted {
        let (scale, bounds) = coefficient(model, name, radius, farthest_px, focal);
        add(&[name], scale, bounds);
    }
    Ok(free)
}

/// The largest radius of the directions in the plane before distortion.
fn plane_radius(model: Model, seen: &[SeenDirection]) -> f64 {
    let is_by_angle = !matches!(model, Model::OpenCv | Model::Fov | Model::Division);
    let radius = |one: &SeenDirection| {
        let d = one.direction;
        let across = d.truncate().length();
        if is_by_angle { across.atan2(d.z) } else { across / d.z }
    };
    seen.iter().map(radius).filter(|r| r.is_finite()).fold(1e-3, f64::max)
}

/// A change of a coefficient that counts, and its bounds.
fn coefficient(model: Model, name: &str, radius: f64, farthest_px: f64, focal_px: f64) -> (f64, [f64; 2]) {
    let any = [f64::NEG_INFINITY, f64::INFINITY];
    let number = name.trim_start_matches(char::is_alphabetic).parse::<i32>().unwrap_or(1);
    match (model, name) {
        (Model::FThetaToPixels, _) => (focal_px * radius.powi(1 - number), any),
        (Model::FThetaToAngle, _) => (radius * farthest_px.powi(-number), any),
        (_, "omega") => (1.0, [0.0, std::f64::consts::PI * (1.0 - 1e-9)]),
        (Model::DoubleSphere, "xi") => (1.0, [-1.0 + 1e-9, 1.0 - 1e-9]),
        (_, "xi") => (1.0, [0.0, f64::INFINITY]),
        (_, "alpha") if matches!(model, Model::DoubleSphere | Model::Eucm) => (1.0, [0.0, 1.0]),
        (_, "alpha" | "tau_x" | "tau_y") => (0.1, any),
        (_, "beta") => (1.0, [1e-9, f64::INFINITY]),
        // A denominator's coefficients are of the powers of the numerator's.
        (Model::OpenCv, "k4" | "k5" | "k6") => (radius.powi(-2 * (number - 3)), any),
        (Model::RadTanThinPrismFisheye, name) if name.starts_with('k') => (radius.powi(-2 * (number + 1)), any),
        (_, name) if name.starts_with('k') => (radius.powi(-2 * number), any),
        // Decentring and prisms are of the second power, or the fourth.
        _ => (0.1 / radius, any),
    }
}

#[cfg(test)]
mod tests;

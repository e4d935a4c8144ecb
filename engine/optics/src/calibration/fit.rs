//! The parameters of a model that fit directions seen at points of a picture: least squares of the distances, pixels, between the points and
//! those at which the model sees the directions.
//!
//! Where the best parameters of a formula fold within the picture, the search is made again within what the model can turn round: a step
//! after which a direction of the picture lies beyond a fold is not taken. A model that was found does not fold where it was asked for.

use super::{Calibration, CalibrationError, Model};
use crate::least_squares::{Parameter, minimise};
use glam::{DVec2, DVec3};
use thiserror::Error;

/// Parameters that say where the picture's plane lies; all others are coefficients.
const FRAME: [&str; 7] = ["fx", "fy", "cx", "cy", "c", "d", "e"];

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

/// What is known of a camera before its model is fitted, and which parameters are to be found.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraToFit {
    /// The model.
    pub model: Model,
    /// Width and height of the picture, pixels.
    pub size_px: [u32; 2],
    /// Pixels for a radian about the axis, across and down: where the search starts.
    pub focal_px: [f64; 2],
    /// Where the axis meets the picture, pixels from its upper left corner.
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

/// The model whose sight of these directions is nearest to where they are seen.
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
    // By the formula alone first; if it folds in the picture, one coefficient more at a time and all at once within its fold, where one way
    // may end before the other does.
    let ways = [(by_one.clone(), true), (by_one, false), (vec![frame, free.len()], false)];
    let (mut best, mut steps): (Option<(f64, Vec<f64>)>, usize) = (None, 0);
    for (counts, is_by_formula) in ways {
        let (values, now) = search.through(&values, &counts, is_by_formula);
        steps += now;
        let Some(sum) = search.residuals(&values, false).map(|all| all.iter().map(|r| r * r).sum::<f64>()) else {
            continue;
        };
        if best.as_ref().is_none_or(|(least, _)| sum < 0.999 * least) {
            best = Some((sum, values));
        }
        if is_by_formula {
            break;
        }
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
    fn through(&self, start: &[f64], counts: &[usize], is_by_formula: bool) -> (Vec<f64>, usize) {
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
            let Some(found) = minimise(&parameters, |found| self.residuals(&with(found), is_by_formula)) else { break };
            (values, steps) = (with(&found.values), steps + found.steps);
        }
        (values, steps)
    }

    /// Distances of what a model sees from where it is seen, pixels by the root of the weight: x and y of each. `None`: some direction lies
    /// beyond what the model can turn round; by its formula alone it has a place there, too.
    fn residuals(&self, values: &[f64], is_by_formula: bool) -> Option<Vec<f64>> {
        let calibration = Calibration::new(self.camera.model, self.camera.size_px, values).ok()?;
        let mut all = Vec::with_capacity(2 * self.seen.len());
        for one in self.seen {
            let point = match is_by_formula {
                true => calibration.by_formula(one.direction)?,
                false => calibration.project(one.direction).ok()?,
            };
            let off = (point - one.point_px) * one.weight.sqrt();
            all.extend([off.x, off.y]);
        }
        Some(all)
    }
}

impl Calibration {
    /// [`Calibration::project`] by the formula of a distortion alone, also beyond its fold; of one that leads from the picture, the point.
    fn by_formula(&self, direction: DVec3) -> Option<DVec2> {
        if self.is_from_picture {
            return self.project(direction).ok();
        }
        let distorted = self.warp.formula(self.chart.point(direction.normalize())?);
        let on_film = self.film * distorted.extend(1.0);
        (on_film.z > 0.0).then(|| on_film.truncate() / on_film.z)
    }
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
mod tests {
    use super::*;

    /// Points of a picture with the directions of a camera.
    fn seen_by(camera: &Calibration) -> Vec<SeenDirection> {
        let [w, h] = camera.size_px().map(f64::from);
        let point = |i: u32| DVec2::new(w * f64::from(i % 17) / 16.0, h * f64::from(i / 17) / 11.0);
        let of = |point_px: DVec2| {
            let direction =
                camera.unproject(point_px).unwrap_or_else(|why| panic!("{:?}: {why}", camera.model())) * 3.0;
            SeenDirection { point_px, direction, weight: 1.0 / 204.0 }
        };
        (0..204).map(|i| of(point(i))).collect()
    }

    fn to_fit(model: Model, focal_px: f64, is_symmetric: bool) -> CameraToFit {
        let (size_px, centre_px) = ([480, 320], [240.0, 160.0]);
        CameraToFit { model, size_px, focal_px: [focal_px; 2], centre_px, is_symmetric, coefficients: None }
    }

    /// Each model's own directions give its parameters back, from a start without distortion and a focal length that is 3 % off.
    #[test]
    fn a_model_is_found_again() {
        let cases: [(Model, &[f64]); 10] = [
            (Model::OpenCv, &[420.0, 420.0, 240.0, 160.0, -0.3, 0.15, 0.0, 0.0, 0.02]),
            (Model::Fisheye, &[210.0, 210.0, 240.0, 160.0, 0.05, -0.02, 0.012, -0.003]),
            (Model::ThinPrismFisheye, &[300.0, 300.0, 240.0, 160.0, 0.05, -0.02, 0.0, 0.0, 0.012, -0.003]),
            (Model::RadTanThinPrismFisheye, &[300.0, 300.0, 240.0, 160.0, 0.05, -0.02, 0.01, -0.003, 1e-3, -1e-4]),
            (Model::Fov, &[300.0, 300.0, 240.0, 160.0, 0.9]),
            (Model::Division, &[300.0, 300.0, 240.0, 160.0, -0.2]),
            (Model::DoubleSphere, &[300.0, 300.0, 240.0, 160.0, -0.2, 0.6]),
            (Model::Eucm, &[300.0, 300.0, 240.0, 160.0, 0.6, 1.1]),
            (Model::FThetaToPixels, &[240.0, 160.0, 1.0, 0.0, 0.0, 200.0, 0.0, -8.0, 0.0, 0.5]),
            (Model::FThetaToAngle, &[240.0, 160.0, 1.0, 0.0, 0.0, 5e-3, 0.0, 1e-9]),
        ];
        for (model, given) in cases {
            let mut parameters = given.to_vec();
            parameters.resize(model.parameter_names().len(), 0.0);
            let camera = Calibration::new(model, [480, 320], &parameters).unwrap();
            let seen = seen_by(&camera);
            let focal = camera.focal_px().unwrap()[0] * 1.03;
            let found = fit(&to_fit(model, focal, true), &seen).unwrap();
            let off =
                seen.iter().map(|one| (found.calibration.project(one.direction).unwrap() - one.point_px).length());
            // Coefficients of several powers make up for each other: what counts is where they put the points.
            let worst = off.fold(0.0, f64::max);
            assert!(worst < 1e-5, "{}: {worst} px, {:?}", model.name(), found.calibration.parameters());
            let apart = found.calibration.parameters().iter().zip(&parameters).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 2e-3 * focal, "{}", model.name());
        }
    }

    /// A camera without symmetry: each focal length, the principal point and what decentres are found.
    #[test]
    fn a_decentred_camera_is_found_again() {
        let mut parameters = vec![420.0, 423.0, 243.7, 156.2, -0.3, 0.15, 0.006, -0.005, 0.0];
        parameters.resize(18, 0.0);
        let camera = Calibration::new(Model::OpenCv, [480, 320], &parameters).unwrap();
        let found = fit(&to_fit(Model::OpenCv, 400.0, false), &seen_by(&camera)).unwrap();
        let apart = found.calibration.parameters().iter().zip(&parameters).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-4, "{:?}", found.calibration.parameters());
        assert_eq!(found.free, ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "p1", "p2"]);
    }

    /// Directions of a fisheye of 140 degrees, to which a polynomial of the tangent is fitted: what is found does not fold in the picture.
    #[test]
    fn what_is_found_does_not_fold() {
        let camera =
            Calibration::new(Model::Fisheye, [480, 320], &[230.0, 230.0, 240.0, 160.0, 0.0, 0.0, 0.0, 0.0, 0.0])
                .unwrap();
        let found = fit(&to_fit(Model::OpenCv, 230.0, true), &seen_by(&camera)).unwrap();
        assert_eq!(found.calibration.survey().covered, 1.0, "{:?}", found.calibration.parameters());
    }

    #[test]
    fn what_cannot_be_fitted_is_named() {
        let fisheye = |focal: f64| {
            let parameters = [focal, focal, 240.0, 160.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            seen_by(&Calibration::new(Model::Fisheye, [480, 320], &parameters).unwrap())
        };
        let wrong = |camera: &CameraToFit, seen: &[SeenDirection]| fit(camera, seen).unwrap_err();
        let opencv = to_fit(Model::OpenCv, 150.0, true);
        // The corners are 288 pixels from the middle.
        assert!(
            matches!(wrong(&opencv, &fisheye(150.0)), FitError::NotSeen { largest_deg, .. } if (largest_deg - 110.2).abs() < 0.1)
        );
        let seen = fisheye(400.0);
        assert!(matches!(wrong(&to_fit(Model::StMap, 400.0, true), &seen), FitError::Model(_)));
        assert_eq!(wrong(&opencv, &seen[..1]), FitError::TooFew { seen: 1, parameters: 4 });
        let asked = CameraToFit { coefficients: Some(vec!["k9".into()]), ..opencv };
        let text = wrong(&asked, &seen).to_string();
        assert!(text.starts_with("the model opencv has no coefficient 'k9'; it has k1, k2, p1"), "{text}");
    }
}

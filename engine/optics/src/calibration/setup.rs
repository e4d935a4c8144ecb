//! The steps of a model from its parameters.

use super::chart::Chart;
use super::planar::{Brown, Distortion, TdeAnamorphic, TdeRadial};
use super::radial::{EVEN_POWERS, HIGHEST_POWER, Radial};
use super::st_map::StMap;
use super::warp::Warp;
use super::{Calibration, CalibrationError, Model};
use crate::lensfun::Projection;
use glam::{DMat2, DMat3, DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A focal length of fewer widths of the picture is one in other units: a whole sphere in a picture has 0.16.
const LEAST_FOCAL: f64 = 0.01;
/// Cosine of the tilt of a sensor that is as good as seen from the side.
const EDGE_ON: f64 = 1e-3;

/// The steps of a model.
struct Steps {
    chart: Chart,
    distortion: Distortion,
    is_from_picture: bool,
    film: DMat3,
}

pub(super) fn of_parameters(
    model: Model,
    size_px: [u32; 2],
    parameters: &[f64],
) -> Result<Calibration, CalibrationError> {
    check(model, size_px, parameters)?;
    let steps = steps(model, size_px, parameters)?;
    finished(model, size_px, parameters, steps)
}

/// A model's formula alone, without the bounds within which it can be turned round.
pub(super) struct Formula(Steps);

impl Formula {
    /// The formula of a model that leads from directions to the picture; `None`: these are no parameters of such.
    pub(super) fn new(model: Model, size_px: [u32; 2], parameters: &[f64]) -> Option<Self> {
        check(model, size_px, parameters).ok()?;
        steps(model, size_px, parameters).ok().filter(|steps| !steps.is_from_picture).map(Self)
    }

    /// The point at which a direction is seen, pixels, and the determinant of the distortion's derivative there.
    pub(super) fn project(&self, direction: DVec3) -> Option<(DVec2, f64)> {
        let (distorted, slope) = self.0.distortion.at(self.0.chart.point(direction.try_normalize()?)?);
        let on_film = self.0.film * distorted.extend(1.0);
        (on_film.z > 0.0).then(|| (on_film.truncate() / on_film.z, slope.determinant()))
    }
}

pub(super) fn of_st_map(
    size_px: [u32; 2],
    places: &[Option<[f32; 2]>],
    parameters: &[f64],
) -> Result<Calibration, CalibrationError> {
    check(Model::StMap, size_px, parameters)?;
    let [width, height] = size_px.map(|side| side as usize);
    if width < 2 || height < 2 || places.len() != width * height {
        return Err(CalibrationError::StMap("is no picture of at least 2 x 2 pixels"));
    }
    let [w, h] = size_px.map(f64::from);
    let of = |place: &Option<[f32; 2]>| {
        place.map(|[s, t]| DVec2::new(f64::from(s) * w, (1.0 - f64::from(t)) * h)).filter(|place| place.is_finite())
    };
    let places: Vec<_> = places.iter().map(of).collect();
    if places.iter().all(Option::is_none) {
        return Err(CalibrationError::StMap("has no place that is in the picture"));
    }
    let [fx, fy, cx, cy] = [parameters[0], parameters[1], parameters[2], parameters[3]];
    let map = StMap::new([width, height], places, DVec2::new(fx, fy), DVec2::new(cx, cy));
    let film = DMat3::from_translation(0.5 * DVec2::new(w, h));
    let distortion = Distortion::StMap(Arc::new(map));
    finished(
        Model::StMap,
        size_px,
        parameters,
        Steps { chart: Chart::Perspective, distortion, is_from_picture: true, film },
    )
}

fn finished(
    model: Model,
    size_px: [u32; 2],
    parameters: &[f64],
    steps: Steps,
) -> Result<Calibration, CalibrationError> {
    let Steps { chart, distortion, is_from_picture, film } = steps;
    let slope = distortion.at(DVec2::ZERO).1;
    // Turned over in both directions its determinant is positive, too.
    if !(slope.determinant() > 0.0 && slope.x_axis.x + slope.y_axis.y > 0.0) {
        return Err(match model {
            Model::StMap => CalibrationError::StMap("shows nothing in its middle, or mirrors it"),
            _ => CalibrationError::FoldsAtCentre,
        });
    }
    let film_inverse = film.inverse();
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[x, y]| {
        let corner = film_inverse * DVec2::new(x * f64::from(size_px[0]), y * f64::from(size_px[1])).extend(1.0);
        (corner.truncate() / corner.z).length()
    });
    let size = corners.into_iter().filter(|corner| corner.is_finite()).fold(0.0, f64::max);
    let size = if size > 0.0 { size } else { 1.0 };
    let reach = match (&distortion, is_from_picture) {
        // Up to its own edges.
        (Distortion::StMap(_), _) => size,
        (_, true) => f64::INFINITY,
        (_, false) => chart.reach(),
    };
    let warp = Warp::new(distortion, reach, size);
    let parameters = parameters.to_vec();
    Ok(Calibration { model, parameters, size_px, chart, warp, is_from_picture, film, film_inverse })
}

/// Checks the parameters that all models have in common.
fn check(model: Model, size_px: [u32; 2], parameters: &[f64]) -> Result<(), CalibrationError> {
    let names = model.parameter_names();
    if parameters.len() != names.len() {
        return Err(CalibrationError::Count { model, expected: names.len(), found: parameters.len() });
    }
    if size_px.contains(&0) {
        return Err(CalibrationError::NoPixels(size_px[0], size_px[1]));
    }
    for (&name, &value) in names.iter().zip(parameters) {
        if !value.is_finite() {
            return Err(CalibrationError::NotFinite { name, value });
        }
        let side = |axis: usize| f64::from(size_px[axis]);
        let is_length = matches!(name, "fx" | "fy" | "focal_cm" | "film_width_cm" | "film_height_cm" | "pixel_aspect");
        if is_length && value <= 0.0 {
            return Err(CalibrationError::Range { name, value, expected: "it must be above zero" });
        }
        let axis = usize::from(name.ends_with('y'));
        let is_small = match name {
            "fx" | "fy" => value < LEAST_FOCAL * side(axis),
            // Exactly 0 is a picture cut off there.
            "cx" | "cy" => value > 0.5 && value <= 1.0 && side(axis) > 16.0,
            _ => false,
        };
        if is_small {
            return Err(CalibrationError::Units { name, value, side_px: size_px[axis] });
        }
    }
    Ok(())
}

fn pinhole(p: &[f64]) -> DMat3 {
    DMat3::from_cols_array(&[p[0], 0.0, 0.0, 0.0, p[1], 0.0, p[2], p[3], 1.0])
}

fn even(k: &[f64]) -> Radial {
    let mut all = [0.0; EVEN_POWERS];
    all[..k.len()].copy_from_slice(k);
    if all == [0.0; EVEN_POWERS] { Radial::Identity } else { Radial::Even(all) }
}

fn in_range(name: &'static str, value: f64, is_right: bool, expected: &'static str) -> Result<(), CalibrationError> {
    if is_right { Ok(()) } else { Err(CalibrationError::Range { name, value, expected }) }
}

/// The steps of each model, by the formula of its source.
#[expect(clippy::too_many_lines, reason = "an arm for each model")]
fn steps(model: Model, size_px: [u32; 2], p: &[f64]) -> Result<Steps, CalibrationError> {
    let forward = |chart, distortion| Ok(Steps { chart, distortion, is_from_picture: false, film: pinhole(p) });
    let radial = |chart, radial| forward(chart, Distortion::Radial(radial));
    match model {
        Model::OpenCv => {
            let (n, d) = ([p[4], p[5], p[8]], [p[9], p[10], p[11]]);
            let rational = if n == [0.0; 3] && d == [0.0; 3] { Radial::Identity } else { Radial::Rational(n, d) };
            let brown = Brown {
                first: Radial::Identity,
                radial: rational,
                tangential: [p[6], p[7]],
                prism: [p[12], p[13], p[14], p[15]],
            };
            let film = pinhole(p) * tilt(p[16], p[17])?;
            Ok(Steps { film, ..forward(Chart::Perspective, brown.simplest())? })
        }
        Model::Fisheye => {
            let mut film = pinhole(p);
            film.y_axis.x = p[0] * p[8];
            Ok(Steps { film, ..radial(Chart::Angle, even(&p[4..8]))? })
        }
        Model::ThinPrismFisheye => {
            let brown = Brown {
                first: Radial::Identity,
                radial: even(&[p[4], p[5], p[8], p[9]]),
                tangential: [p[6], p[7]],
                prism: [p[10], 0.0, p[11], 0.0],
            };
            forward(Chart::Angle, brown.simplest())
        }
        Model::RadTanThinPrismFisheye => {
            let brown = Brown {
                first: even(&p[4..10]),
                radial: Radial::Identity,
                // Its p0 is of x, as p2 of OpenCV.
                tangential: [p[11], p[10]],
                prism: [p[12], p[13], p[14], p[15]],
            };
            forward(Chart::Angle, brown.simplest())
        }
        Model::Fov => {
            in_range("omega", p[4], p[4] >= 0.0 && p[4] < PI, "it is an angle in radians, from 0 to less than pi")?;
            radial(Chart::Perspective, Radial::Fov(p[4]))
        }
        Model::Division => {
            let distortion = Distortion::Radial(Radial::Rational([0.0; 3], [p[4], 0.0, 0.0]));
            Ok(Steps { is_from_picture: true, ..forward(Chart::Perspective, distortion)? })
        }
        Model::Equirectangular => {
            let [w, h] = size_px.map(f64::from);
            let film = pinhole(&[w / (2.0 * PI), h / PI, 0.5 * w, 0.5 * h]);
            let distortion = Distortion::Radial(Radial::Identity);
            Ok(Steps { chart: Chart::Sphere, distortion, is_from_picture: false, film })
        }
        Model::DoubleSphere => {
            in_range("xi", p[4], p[4].abs() < 1.0, "it is between -1 and 1")?;
            in_range("alpha", p[5], (0.0..=1.0).contains(&p[5]), "it is between 0 and 1")?;
            radial(Chart::DoubleSphere(p[4], p[5]), Radial::Identity)
        }
        Model::Eucm => {
            in_range("alpha", p[4], (0.0..=1.0).contains(&p[4]), "it is between 0 and 1")?;
            in_range("beta", p[5], p[5] > 0.0, "it must be above zero")?;
            radial(Chart::Enhanced(p[4], p[5]), Radial::Identity)
        }
        Model::Omni => {
            in_range("xi", p[4], p[4] >= 0.0, "it must not be below zero")?;
            let brown =
                Brown { first: Radial::Identity, radial: even(&p[5..7]), tangential: [p[7], p[8]], prism: [0.0; 4] };
            forward(Chart::Unified(p[4]), brown.simplest())
        }
        Model::FThetaToAngle | Model::FThetaToPixels => {
            let mut powers = [0.0; HIGHEST_POWER];
            powers.copy_from_slice(&p[5..]);
            // x = c x' + d y', y = e x' + y'
            let film = DMat3::from_cols_array(&[p[2], p[4], 0.0, p[3], 1.0, 0.0, p[0], p[1], 1.0]);
            if !(film.determinant() > 0.0) {
                return Err(CalibrationError::FoldsAtCentre);
            }
            let distortion = Distortion::Radial(Radial::Powers(powers));
            let is_from_picture = model == Model::FThetaToAngle;
            Ok(Steps { chart: Chart::Angle, distortion, is_from_picture, film })
        }
        Model::TdeRadial | Model::TdeAnamorphic => tde(model, size_px, p),
        Model::Lensfun(projection) => {
            let mut powers = [0.0; HIGHEST_POWER];
            powers[0] = 1.0;
            powers[1..7].copy_from_slice(&p[4..10]);
            let radial = if powers[1..].iter().any(|c| *c != 0.0) { Radial::Powers(powers) } else { Radial::Identity };
            let brown = Brown { first: Radial::Identity, radial, tangential: [p[10], p[11]], prism: [0.0; 4] };
            let is_pinhole = projection == Projection::Rectilinear;
            forward(if is_pinhole { Chart::Perspective } else { Chart::Round(projection) }, brown.simplest())
        }
        Model::StMap => Err(CalibrationError::StMap("is missing")),
    }
}

/// The turn of a sensor about its middle and the view of it from the lens, as OpenCV's `computeTiltProjectionMatrix`, after Louhichi and
/// others 2007.
fn tilt(tau_x: f64, tau_y: f64) -> Result<DMat3, CalibrationError> {
    if tau_x == 0.0 && tau_y == 0.0 {
        return Ok(DMat3::IDENTITY);
    }
    // The matrices of OpenCV turn the other way round than glam's.
    let turn = DMat3::from_rotation_y(-tau_y) * DMat3::from_rotation_x(-tau_x);
    let (r13, r23, r33) = (turn.z_axis.x, turn.z_axis.y, turn.z_axis.z);
    if !(r33 > EDGE_ON) {
        return Err(CalibrationError::SingularTilt { tau_x, tau_y });
    }
    let view = DMat3::from_cols_array(&[r33, 0.0, 0.0, 0.0, r33, 0.0, -r13, -r23, 1.0]);
    Ok(view * turn)
}

/// The plane is the distorted picture in halves of the film back's diagonal from the lens's centre, y up; that of the projection has y down.
fn tde(model: Model, size_px: [u32; 2], p: &[f64]) -> Result<Steps, CalibrationError> {
    let [focal, width, height, centre_x, centre_y] = [p[0], p[1], p[2], p[3], p[4]];
    let unit_cm = 0.5 * width.hypot(height);
    let [px_x, px_y] = [f64::from(size_px[0]) / width, f64::from(size_px[1]) / height];
    let to_pixels = DMat3::from_cols_array(&[
        unit_cm * px_x,
        0.0,
        0.0,
        0.0,
        -unit_cm * px_y,
        0.0,
        (0.5 * width + centre_x) * px_x,
        (0.5 * height - centre_y) * px_y,
        1.0,
    ]);
    let to_plane = unit_cm / focal;
    // In a plane with y down and unit distance before the lens, so that chart and distortion agree.
    let flip = DMat2::from_diagonal(DVec2::new(1.0, -1.0));
    let film = to_pixels * DMat3::from_mat2(flip);
    let distortion = if model == Model::TdeRadial {
        in_range("bending", p[12], p[12] > -1.0, "it is above -1")?;
        let radial = TdeRadial {
            c: [p[5], p[8]],
            u: [p[6], p[9]],
            v: [p[7], p[10]],
            bending: TdeRadial::bending(p[11].to_radians(), p[12]),
        };
        Distortion::TdeRadial(radial.seen_from_ahead(to_plane))
    } else {
        in_range("squeeze_x", p[17], p[17] > 0.0, "it must be above zero")?;
        in_range("squeeze_y", p[18], p[18] > 0.0, "it must be above zero")?;
        let rotation = DMat2::from_angle(p[16].to_radians());
        let pixels = DMat2::from_diagonal(DVec2::new(p[5], 1.0));
        let squeeze = DMat2::from_diagonal(DVec2::new(p[17], p[18]));
        let anamorphic = TdeAnamorphic {
            coefficients: [[p[6], p[8], p[10], p[12], p[14]], [p[7], p[9], p[11], p[13], p[15]]],
            before: (pixels * rotation).inverse() * flip,
            after: flip * (rotation * squeeze * pixels) * to_plane,
        };
        Distortion::TdeAnamorphic(anamorphic)
    };
    Ok(Steps { chart: Chart::Perspective, distortion, is_from_picture: true, film })
}

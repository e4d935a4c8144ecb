//! Projections of panoramic cameras: directions onto the points of a flat picture, and back, as Blender's panoramic cameras have them.
//!
//! Directions are in camera space: x right, y up, looking along -z. Picture points are fractions of the picture's width and height from its
//! centre, right and up.

use glam::{DVec2, DVec3};
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A projection by its formula, with the settings of Blender's camera for it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE", deny_unknown_fields)]
pub enum Projection {
    /// Longitude across, latitude up.
    Equirectangular {
        /// Longitudes of the picture's left and right edge, to the right of the camera's axis.
        longitude_rad: [f64; 2],
        /// Latitudes of the picture's bottom and top edge.
        latitude_rad: [f64; 2],
    },
    /// A quarter of a circle both ways, as a face of a cube map in which angles are even.
    EquiangularCubemapFace,
    /// The reflection in a ball, seen from far away.
    MirrorBall,
    /// The angle from the axis grows as the distance from the picture's centre.
    FisheyeEquidistant {
        /// Angle of the field over the picture's width and height.
        field_rad: f64,
    },
    /// The solid angle about the axis grows as the area in the picture.
    FisheyeEquisolid {
        /// Focal length.
        focal_length_mm: f64,
        /// Angle of the field, beyond which nothing is seen.
        field_rad: f64,
        /// Width and height of the whole picture on the sensor.
        sensor_mm: [f64; 2],
    },
    /// The angle from the axis is a polynomial of the distance from the picture's centre.
    FisheyeLensPolynomial {
        /// The coefficients of the distance's powers 0 to 4, radians by millimetres; negative, as Blender has them.
        coefficients: [f64; 5],
        /// Angle of the field, beyond which nothing is seen.
        field_rad: f64,
        /// Width and height of the whole picture on the sensor.
        sensor_mm: [f64; 2],
    },
    /// Longitude across, height on an upright cylinder of radius one up.
    CentralCylindrical {
        /// Longitudes of the picture's left and right edge, to the right of the camera's axis.
        longitude_rad: [f64; 2],
        /// Heights of the picture's bottom and top edge on the cylinder.
        height: [f64; 2],
    },
}

/// The picture of a panoramic camera.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panorama {
    /// The projection of the picture without its shift.
    pub projection: Projection,
    /// Shift over the projection, fractions of the picture's width and height.
    pub shift: [f64; 2],
}

/// Steps of Newton's method for the inverse of a polynomial, and the change that ends it, mm.
const STEPS: usize = 32;
const LAST_STEP_MM: f64 = 1e-9;

impl Panorama {
    /// The unit direction that a picture point shows; `None` where the projection shows nothing.
    #[inline]
    pub fn direction(&self, p: DVec2) -> Option<DVec3> {
        let p = p + DVec2::from(self.shift);
        let between = |[begin, end]: [f64; 2], at: f64| begin + (end - begin) * (at + 0.5);
        let direction = match self.projection {
            Projection::Equirectangular { longitude_rad, latitude_rad } => {
                let (across, along) = between(longitude_rad, p.x).sin_cos();
                let (up, level) = between(latitude_rad, p.y).sin_cos();
                DVec3::new(level * across, up, -level * along)
            }
            Projection::EquiangularCubemapFace => {
                let [x, y] = [p.x, p.y].map(|at| (at * FRAC_PI_2).tan());
                DVec3::new(x, y, -1.0).normalize()
            }
            Projection::MirrorBall => {
                let on_ball = 2.0 * p;
                let depth = 1.0 - on_ball.length_squared();
                if depth < 0.0 {
                    return None;
                }
                (2.0 * depth.sqrt() * on_ball).extend(1.0 - 2.0 * depth)
            }
            Projection::FisheyeEquidistant { field_rad } => {
                let r = 2.0 * p;
                return (r.length_squared() <= 1.0).then(|| at_angle(0.5 * field_rad * r.length(), r));
            }
            Projection::FisheyeEquisolid { focal_length_mm, field_rad, sensor_mm } => {
                let r = p * DVec2::from(sensor_mm);
                let most = 2.0 * focal_length_mm * (0.25 * field_rad).sin();
                let sine = r.length() / (2.0 * focal_length_mm);
                return (r.length() <= most && sine <= 1.0).then(|| at_angle(2.0 * sine.asin(), r));
            }
            Projection::FisheyeLensPolynomial { coefficients, field_rad, sensor_mm } => {
                let r = p * DVec2::from(sensor_mm);
                let angle = -polynomial(&coefficients, r.length());
                return (angle.abs() <= 0.5 * field_rad).then(|| at_angle(angle, r));
            }
            Projection::CentralCylindrical { longitude_rad, height } => {
                let (across, along) = between(longitude_rad, p.x).sin_cos();
                DVec3::new(across, between(height, p.y), -along).normalize()
            }
        };
        Some(direction)
    }

    /// The picture point of a direction of any length; `None` where it has none. Points beyond the picture's edges are as Cycles gives them.
    pub fn place(&self, d: DVec3) -> Option<DVec2> {
        let share = |[begin, end]: [f64; 2], at: f64| (at - begin) / (end - begin) - 0.5;
        let d = d.try_normalize()?;
        let longitude = d.x.atan2(-d.z);
        let across = d.truncate().normalize_or_zero();
        let angle = d.truncate().length().atan2(-d.z);
        let p = match self.projection {
            Projection::Equirectangular { longitude_rad, latitude_rad } => {
                DVec2::new(share(longitude_rad, longitude), share(latitude_rad, d.y.clamp(-1.0, 1.0).asin()))
            }
            Projection::EquiangularCubemapFace => DVec2::new(d.x, d.y).map(|side| side.atan2(-d.z) / FRAC_PI_2),
            Projection::MirrorBall => {
                let depth = (0.5 * (1.0 - d.z)).max(0.0).sqrt();
                d.truncate() / (4.0 * depth)
            }
            Projection::FisheyeEquidistant { field_rad } => across * angle / field_rad,
            Projection::FisheyeEquisolid { focal_length_mm, sensor_mm, .. } => {
                across * (2.0 * focal_length_mm * (0.5 * angle).sin()) / DVec2::from(sensor_mm)
            }
            Projection::FisheyeLensPolynomial { coefficients, sensor_mm, .. } => {
                across * distance_at(&coefficients, angle) / DVec2::from(sensor_mm)
            }
            Projection::CentralCylindrical { longitude_rad, height } => {
                DVec2::new(share(longitude_rad, longitude), share(height, d.y / d.x.hypot(d.z)))
            }
        };
        let p = p - DVec2::from(self.shift);
        p.is_finite().then_some(p)
    }

    /// The angle between the directions of the picture's centre and of a point so far right and up of it: the angle that a pixel of that
    /// width and height subtends there; that of an equirectangular picture of the whole sphere where the centre shows nothing.
    pub fn step_rad(&self, step: DVec2) -> [f64; 2] {
        let [across, up] = [DVec2::new(step.x, 0.0), DVec2::new(0.0, step.y)];
        let turned = |step: DVec2| Some(self.direction(DVec2::ZERO)?.angle_between(self.direction(step)?));
        let whole = step * DVec2::new(8.0, 4.0) * FRAC_PI_4;
        [turned(across).unwrap_or(whole.x), turned(up).unwrap_or(whole.y)]
    }

    /// Checks that the settings are numbers, and sizes and angles of the field above zero.
    ///
    /// # Errors
    /// The first wrong setting by its name in Blender, and the remedy.
    pub fn check(&self) -> Result<(), String> {
        let positive = |name: &str, value: f64| {
            let is_good = value > 0.0 && value.is_finite();
            is_good.then_some(()).ok_or_else(|| format!("{name} is {value}; set it above zero"))
        };
        let finite = |name: &str, values: &[f64]| match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(format!("{name} is {value}; give a number, or look at its driver")),
            None => Ok(()),
        };
        let sensor =
            |sensor_mm: [f64; 2]| sensor_mm.into_iter().try_for_each(|side| positive("the sensor's size", side));
        finite("the picture's shift", &self.shift)?;
        match self.projection {
            Projection::EquiangularCubemapFace | Projection::MirrorBall => Ok(()),
            Projection::Equirectangular { longitude_rad, latitude_rad } => {
                finite("a longitude", &longitude_rad)?;
                finite("a latitude", &latitude_rad)
            }
            Projection::FisheyeEquidistant { field_rad } => positive("the field of view", field_rad),
            Projection::FisheyeEquisolid { focal_length_mm, field_rad, sensor_mm } => {
                positive("the fisheye's focal length", focal_length_mm)?;
                positive("the field of view", field_rad)?;
                sensor(sensor_mm)
            }
            Projection::FisheyeLensPolynomial { coefficients, field_rad, sensor_mm } => {
                finite("a coefficient of the fisheye's polynomial", &coefficients)?;
                positive("the field of view", field_rad)?;
                sensor(sensor_mm)
            }
            Projection::CentralCylindrical { longitude_rad, height } => {
                finite("a longitude", &longitude_rad)?;
                finite("a height on the cylinder", &height)
            }
        }
    }
}

/// The direction at an angle from the camera's axis, towards `r` in the picture.
fn at_angle(angle_rad: f64, r: DVec2) -> DVec3 {
    let (across, along) = angle_rad.sin_cos();
    (r.try_normalize().unwrap_or(DVec2::X) * across).extend(-along)
}

fn polynomial(coefficients: &[f64; 5], r: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, k| sum * r + k)
}

/// The distance from the picture's centre at which a polynomial shows an angle from the axis, mm; NaN where it has none.
fn distance_at(coefficients: &[f64; 5], angle_rad: f64) -> f64 {
    let [k0, k1, k2, k3, k4] = *coefficients;
    let mut r = (-angle_rad - k0) / k1;
    for _ in 0..STEPS {
        let slope = polynomial(&[k1, 2.0 * k2, 3.0 * k3, 4.0 * k4, 0.0], r);
        let step = (-angle_rad - polynomial(coefficients, r)) / slope;
        r += step;
        if step.is_nan() || step.abs() <= LAST_STEP_MM {
            break;
        }
    }
    r
}

#[cfg(test)]
mod tests;

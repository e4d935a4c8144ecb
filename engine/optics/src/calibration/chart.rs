//! Directions as points of a plane, before distortion.

use crate::lensfun::Projection;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// A projection of directions to a plane whose axes are those of the picture: x right, y down; the direction straight ahead is the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Chart {
    /// `(x, y) / z`.
    Perspective,
    /// The angle from the axis as radius.
    Angle,
    /// A sphere seen from behind its middle (Mei and Rives 2007): `(x, y) / (z + xi |d|)`.
    Unified(f64),
    /// `(x, y) / (alpha sqrt(beta (x^2 + y^2) + z^2) + (1 - alpha) z)` (Khomutenko, Garcia and Martinet 2016, eq. 6).
    Enhanced(f64, f64),
    /// Two spheres (Usenko, Demmel and Cremers 2018, eq. 40).
    DoubleSphere(f64, f64),
    /// Longitude and latitude downwards.
    Sphere,
    /// A round projection of lensfun's other than a pinhole's.
    Round(Projection),
}

impl Chart {
    /// The point of a unit direction; `None` where the projection has none.
    pub(super) fn point(self, d: DVec3) -> Option<DVec2> {
        let across = d.truncate();
        match self {
            Self::Perspective => (d.z > 0.0).then(|| across / d.z),
            Self::Angle => {
                let sine = across.length();
                let angle = sine.atan2(d.z);
                if sine > 0.0 {
                    Some(across * (angle / sine))
                } else {
                    // Straight behind lies on a circle, not in a point.
                    (d.z > 0.0).then_some(DVec2::ZERO)
                }
            }
            Self::Unified(xi) => {
                let least = if xi <= 1.0 { -xi } else { -xi.recip() };
                (d.z > least).then(|| across / (d.z + xi))
            }
            Self::Enhanced(alpha, beta) => {
                let far = (beta * across.length_squared() + d.z * d.z).sqrt();
                (d.z > -lowest(alpha) * far).then(|| across / (alpha * far + (1.0 - alpha) * d.z))
            }
            Self::DoubleSphere(xi, alpha) => {
                let w1 = lowest(alpha);
                let w2 = (w1 + xi) / (2.0 * w1 * xi + xi * xi + 1.0).sqrt();
                let z = xi + d.z;
                let far = (across.length_squared() + z * z).sqrt();
                (d.z > -w2).then(|| across / (alpha * far + (1.0 - alpha) * z))
            }
            Self::Sphere => Some(DVec2::new(d.x.atan2(d.z), d.y.clamp(-1.0, 1.0).asin())),
            Self::Round(projection) => {
                let sine = across.length();
                let height = projection.height(sine.atan2(d.z))?;
                Some(if sine > 0.0 { across * (height / sine) } else { DVec2::ZERO })
            }
        }
    }

    /// The unit direction of a point; `None` where the projection has none.
    pub(super) fn direction(self, q: DVec2) -> Option<DVec3> {
        let r2 = q.length_squared();
        let direction = match self {
            Self::Perspective => q.extend(1.0),
            Self::Angle => {
                let angle = r2.sqrt();
                let (sin, cos) = angle.sin_cos();
                if angle >= PI {
                    return None;
                }
                let ratio = if angle > 1e-8 { sin / angle } else { 1.0 };
                (q * ratio).extend(cos)
            }
            Self::Unified(xi) => {
                let root = (1.0 + (1.0 - xi * xi) * r2).sqrt();
                let stretch = (xi + root) / (1.0 + r2);
                (q * stretch).extend(stretch - xi)
            }
            Self::Enhanced(alpha, beta) => {
                let root = (1.0 - (2.0 * alpha - 1.0) * beta * r2).sqrt();
                q.extend((1.0 - beta * alpha * alpha * r2) / (alpha * root + 1.0 - alpha))
            }
            Self::DoubleSphere(xi, alpha) => {
                let root = (1.0 - (2.0 * alpha - 1.0) * r2).sqrt();
                let z = (1.0 - alpha * alpha * r2) / (alpha * root + 1.0 - alpha);
                let stretch = (z * xi + (z * z + (1.0 - xi * xi) * r2).sqrt()) / (z * z + r2);
                (q * stretch).extend(stretch * z - xi)
            }
            Self::Sphere => {
                if q.x.abs() > PI || q.y.abs() > 0.5 * PI {
                    return None;
                }
                let (up, ahead) = q.y.sin_cos();
                let (right, on) = q.x.sin_cos();
                DVec3::new(right * ahead, up, on * ahead)
            }
            Self::Round(projection) => {
                let height = r2.sqrt();
                let (sin, cos) = projection.angle_rad(height)?.sin_cos();
                if height > 0.0 { (q * (sin / height)).extend(cos) } else { DVec3::Z }
            }
        };
        // A root of what is negative is where the projection ends.
        direction.try_normalize()
    }

    /// The radius beyond which the plane has no directions.
    pub(super) fn reach(self) -> f64 {
        let or_all = |square: f64| if square > 0.0 { square.sqrt().recip() } else { f64::INFINITY };
        match self {
            Self::Perspective => f64::INFINITY,
            Self::Angle => PI,
            // Beyond its corners.
            Self::Sphere => 2.0 * PI,
            Self::Unified(xi) => or_all(xi * xi - 1.0),
            Self::Enhanced(alpha, beta) => or_all(beta * (2.0 * alpha - 1.0)),
            Self::DoubleSphere(_, alpha) => or_all(2.0 * alpha - 1.0),
            Self::Round(projection) => projection.reach(),
        }
    }
}

/// The cosine, negated, down to which a sphere is seen (Usenko, Demmel and Cremers 2018, eq. 43).
fn lowest(alpha: f64) -> f64 {
    if alpha <= 0.5 { alpha / (1.0 - alpha) } else { (1.0 - alpha) / alpha }
}

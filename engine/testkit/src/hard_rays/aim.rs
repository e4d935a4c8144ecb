//! Rays aimed at a place of a surface.

use super::dice::Dice;
use crate::exact::{Case, Profile, ProfileAt, Shape, profile_at};

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn plus_times(a: [f64; 3], b: [f64; 3], x: f64) -> [f64; 3] {
    [a[0] + b[0] * x, a[1] + b[1] * x, a[2] + b[2] * x]
}

pub(super) fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// A place on a surface, as near to it as machine numbers come.
pub(super) struct Place {
    pub(super) shape: Shape,
    pub(super) point: [f64; 3],
    /// Normal of unit length, towards +z at the vertex.
    pub(super) normal: [f64; 3],
}

/// Distance from its axis that a conic reaches, in mm.
pub(super) fn reach(curvature: f64, conic: f64) -> f64 {
    let squared = (1.0 + conic) * curvature * curvature;
    if squared > 0.0 { 1.0 / squared.sqrt() } else { f64::INFINITY }
}

impl Place {
    /// A place on a conic's vertex sheet, `r` from the axis at the `angle` of that cosine and sine.
    pub(super) fn on_conic(curvature: f64, conic: f64, r: f64, angle: [f64; 2]) -> Self {
        let shape = Shape::Conic { curvature, conic };
        Self::on(shape, r * angle[0], r * angle[1]).expect("r is within the conic's reach")
    }

    /// The place over (x, y); `None` where the surface does not reach.
    pub(super) fn on(shape: Shape, x: f64, y: f64) -> Option<Self> {
        let profile = shape.profile();
        let z = match &shape {
            Shape::Conic { .. } | Shape::Asphere(_) => profile_at(&profile, (x * x + y * y).sqrt())?.sag,
            Shape::Toroid { curvature_x: c, .. } => {
                let sag = profile_at(&profile, y.abs())?.sag;
                let rest = 1.0 - c * sag;
                let squared = rest * rest - c * c * x * x;
                if !(squared > 0.0) {
                    return None;
                }
                (sag * (2.0 - c * sag) + c * x * x) / (1.0 + squared.sqrt())
            }
        };
        let point = [x, y, z];
        let (_, gradient) = function(&shape, &profile, point)?;
        Some(Self { normal: unit(gradient), shape, point })
    }

    /// A ray to this place from `distance` away, cos i = `cosine` on the side of `side`, in any plane of incidence.
    pub(super) fn ray(self, dice: &mut Dice, cosine: f64, side: f64, distance: f64) -> Case {
        let across = self.tangent(dice);
        let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
        let direction = plus_times(across.map(|x| x * sine), self.normal, side * cosine);
        self.ray_along(direction, side, distance)
    }

    /// A ray to this place along `direction`.
    pub(super) fn ray_along(self, direction: [f64; 3], side: f64, distance: f64) -> Case {
        let direction = unit(direction);
        Case {
            origin: plus_times(self.point, direction, -distance),
            shape: self.shape,
            direction,
            side,
            n1: 1.0,
            n2: 1.5,
            mirror: false,
            semi_diameter: None,
            obstruction: 0.0,
        }
    }

    /// Any direction along the surface.
    pub(super) fn tangent(&self, dice: &mut Dice) -> [f64; 3] {
        loop {
            let v = dice.direction();
            let across = plus_times(v, self.normal, -dot(v, self.normal));
            if dot(across, across) > 0.01 {
                return unit(across);
            }
        }
    }
}

/// A surface's function and its gradient; `None` where a profile has ended.
fn function(shape: &Shape, profile: &Profile, [x, y, z]: [f64; 3]) -> Option<(f64, [f64; 3])> {
    match shape {
        Shape::Conic { .. } | Shape::Asphere(_) => {
            let ProfileAt { sag, slope, .. } = profile_at(profile, (x * x + y * y).sqrt())?;
            Some((z - sag, [-slope * x, -slope * y, 1.0]))
        }
        Shape::Toroid { curvature_x: c, .. } => {
            let ProfileAt { sag, slope, .. } = profile_at(profile, y.abs())?;
            let value = z - sag - 0.5 * c * (x * x + z * z - sag * sag);
            Some((value, [-c * x, -slope * y * (1.0 - c * sag), 1.0 - c * z]))
        }
    }
}

/// Places looked at along a ray for further crossings.
const LOOKS: u32 = 300;

/// True if the ray crosses the surface once within `radius` of the axis and `length` of `t`, and not nearly along it.
pub(super) fn is_crossed_once(case: &Case, t: f64, radius: f64, length: f64) -> bool {
    let profile = case.shape.profile();
    let mut was_below = None;
    let mut crossings = 0;
    for i in 0..=LOOKS {
        let at = t + length * (2.0 * f64::from(i) / f64::from(LOOKS) - 1.0);
        let point = plus_times(case.origin, case.direction, at);
        let is_near = point[0] * point[0] + point[1] * point[1] < radius * radius;
        let Some((value, gradient)) = function(&case.shape, &profile, point).filter(|_| is_near) else {
            was_below = None;
            continue;
        };
        let is_below = value < 0.0;
        if was_below.is_some_and(|was| was != is_below) {
            crossings += 1;
            if dot(unit(gradient), case.direction) * case.side < 0.05 {
                return false;
            }
        }
        was_below = Some(is_below);
    }
    crossings == 1
}

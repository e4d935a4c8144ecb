//! A surface about a hit in machine numbers: gradient, curvature, and how each of its numbers moves it.
//!
//! Nothing cancels here: the hit is exact, and only changes are wanted.

use super::case::{Case, Profile, Shape};

pub(crate) type Triple = [f64; 3];

pub(super) fn dot(a: Triple, b: Triple) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn norm(a: Triple) -> f64 {
    dot(a, a).sqrt()
}

pub(super) fn plus_times(a: Triple, b: Triple, x: f64) -> Triple {
    [a[0] + b[0] * x, a[1] + b[1] * x, a[2] + b[2] * x]
}

/// Changes by a change of one number of the surface by 1.
#[derive(Clone, Copy)]
pub(super) struct Derivative {
    /// Value of the number.
    pub(super) number: f64,
    /// Change of the surface's function G at the hit.
    pub(super) value: f64,
    /// Change of N, its gradient.
    pub(super) gradient: Triple,
    /// Change of the second derivatives by x, y and z. Of conics only, for hits near infinity: elsewhere it is lost
    /// beside the others.
    pub(super) bend: Triple,
}

/// A surface about a point of it.
pub(super) struct Local {
    /// The gradient N, not of unit length.
    pub(super) gradient: Triple,
    /// Second derivatives of G; symmetric.
    hessian: [Triple; 3],
    /// Derivatives by the case's numbers, in the order of [`Case::for_each_number`].
    pub(super) numbers: Vec<Derivative>,
    /// 1 − (1 + k) c² r² of an asphere's or a toroid's profile, which ends at 0, and the derivative by r.
    pub(super) profile_end: Option<(f64, f64)>,
}

/// A profile at a distance r from its axis.
pub(crate) struct ProfileAt {
    /// The sag z in mm.
    pub(crate) sag: f64,
    /// The slope over the distance: (dz/dr) / r.
    pub(crate) slope: f64,
    /// The derivative of `slope`, divided by r.
    bend: f64,
    /// The numbers c, k and the terms: the number, its derivative of `sag` and of `slope`.
    numbers: Vec<[f64; 3]>,
    /// √(1 − (1 + k) c² r²)
    weight: f64,
}

/// The profile at `r`; `None` where it has ended. The same on every machine, as `powi` need not be.
pub(crate) fn profile_at(profile: &Profile, r: f64) -> Option<ProfileAt> {
    let Profile { curvature: c, conic: k, terms } = profile;
    let u = r * r;
    let inside = 1.0 - (1.0 + k) * c * c * u;
    if !(inside > 0.0) {
        return None;
    }
    let w = inside.sqrt();
    let conic_sag = c * u / (1.0 + w);
    let mut at = ProfileAt {
        sag: conic_sag,
        slope: c / w,
        bend: c * c * c * (1.0 + k) / (w * w * w),
        numbers: vec![
            [*c, u / ((1.0 + w) * w), 1.0 / (w * w * w)],
            [*k, c * conic_sag * conic_sag / (2.0 * w), c * c * c * u / (2.0 * w * w * w)],
        ],
        weight: w,
    };
    for &(power, a) in terms {
        let p = f64::from(power);
        let below = (2..power).fold(1.0, |product, _| product * r);
        let (height, slope) = (below * r * r, p * below);
        at.sag += a * height;
        at.slope += a * slope;
        at.bend += if r > 0.0 { a * slope * (p - 2.0) / (r * r) } else { 0.0 };
        at.numbers.push([a, height, slope]);
    }
    Some(at)
}

impl Local {
    /// The surface of `case` about the point `p`; `None` where the profile has ended.
    #[expect(clippy::too_many_lines, reason = "an arm for each shape")]
    pub(super) fn new(case: &Case, p: Triple) -> Option<Self> {
        let [x, y, z] = p;
        Some(match &case.shape {
            Shape::Conic { curvature: c, conic: k } => {
                let squares = x * x + y * y + (1.0 + k) * z * z;
                Self {
                    gradient: [-c * x, -c * y, 1.0 - (1.0 + k) * c * z],
                    hessian: [[-c, 0.0, 0.0], [0.0, -c, 0.0], [0.0, 0.0, -c * (1.0 + k)]],
                    numbers: vec![
                        Derivative {
                            number: *c,
                            value: -0.5 * squares,
                            gradient: [-x, -y, -(1.0 + k) * z],
                            bend: [-1.0, -1.0, -(1.0 + k)],
                        },
                        Derivative {
                            number: *k,
                            value: -0.5 * c * z * z,
                            gradient: [0.0, 0.0, -c * z],
                            bend: [0.0, 0.0, -c],
                        },
                    ],
                    profile_end: None,
                }
            }
            Shape::Asphere(profile) => {
                let r = x.hypot(y);
                let ProfileAt { slope: e, bend: b, numbers, weight, .. } = profile_at(profile, r)?;
                let derivative = |[number, sag, slope]: Triple| Derivative {
                    number,
                    value: -sag,
                    gradient: [-slope * x, -slope * y, 0.0],
                    bend: [0.0; 3],
                };
                Self {
                    gradient: [-e * x, -e * y, 1.0],
                    hessian: [[-e - b * x * x, -b * x * y, 0.0], [-b * x * y, -e - b * y * y, 0.0], [0.0; 3]],
                    numbers: numbers.into_iter().map(derivative).collect(),
                    profile_end: Some(end(profile, r, weight)),
                }
            }
            Shape::Toroid { profile, curvature_x: c } => {
                let ProfileAt { sag: g, slope: e, bend: b, numbers, weight } = profile_at(profile, y.abs())?;
                let rest = 1.0 - c * g;
                let rise = e * y;
                let derivative = |[number, sag, slope]: Triple| Derivative {
                    number,
                    value: -sag * rest,
                    gradient: [0.0, -slope * y * rest + rise * c * sag, 0.0],
                    bend: [0.0; 3],
                };
                let across = Derivative {
                    number: *c,
                    value: -0.5 * (x * x + z * z - g * g),
                    gradient: [-x, rise * g, -z],
                    bend: [0.0; 3],
                };
                Self {
                    gradient: [-c * x, -rise * rest, 1.0 - c * z],
                    hessian: [[-c, 0.0, 0.0], [0.0, -(e + b * y * y) * rest + c * rise * rise, 0.0], [0.0, 0.0, -c]],
                    numbers: numbers.into_iter().map(derivative).chain([across]).collect(),
                    profile_end: Some(end(profile, y, weight)),
                }
            }
        })
    }

    /// The derivative of N along `v`.
    pub(super) fn bend(&self, v: Triple) -> Triple {
        self.hessian.map(|row| dot(row, v))
    }

    /// The sum over the surface's numbers of the effects of a change by 1, by `change`, for changes as large as they.
    pub(super) fn sum(&self, change: impl Fn(&Derivative) -> f64) -> f64 {
        self.numbers.iter().map(|number| (number.number * change(number)).abs()).sum()
    }
}

fn end(profile: &Profile, r: f64, weight: f64) -> (f64, f64) {
    (weight * weight, -2.0 * (1.0 + profile.conic) * profile.curvature * profile.curvature * r)
}

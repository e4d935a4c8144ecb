//! The margins by which an outcome is not another one.

use super::big::{Big, dot as big_dot, plus_times as big_plus_times, to_f64};
use super::inputs::{Inputs, Surface};
use super::local::{Local, Triple, dot, norm, plus_times};
use super::trace::{Hit, Status};

/// The margins of a ray: for each check that it came to, the relative change of the case's numbers that would turn its
/// result: positive if the ray passed the check, negative if it failed, infinite if it was not made.
///
/// A vector counts by its length, so that the rounding of every component does. A size of 1e-16 means that rounding in
/// `f64` may turn the outcome, 1e-7 that rounding in `f32` may; a tracer that is good to some ulps may fail within some
/// times that. Estimates on the small side: a change of any one number by less turns nothing, by ten times as much
/// nearly always does, but for conics of huge k and for hits near infinity, whose margins may be far too small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Margin of q = B² − A C, or of its equivalent where there is no conic: does the ray hit the surface?
    pub discriminant: f64,
    /// Margin of N_z, and of the end of a profile: does the ray hit the vertex sheet?
    pub sheet: f64,
    /// Margin of the distance from the rim.
    pub aperture: f64,
    /// Margin of the distance from the rim of the central obstruction.
    pub obstruction: f64,
    /// Margin of cos² i′: is there a refracted ray?
    pub radicand: f64,
}

impl Margins {
    const NONE: Self = Self {
        discriminant: f64::INFINITY,
        sheet: f64::INFINITY,
        aperture: f64::INFINITY,
        obstruction: f64::INFINITY,
        radicand: f64::INFINITY,
    };

    /// The size of the smallest: the status is safe from smaller relative changes of the case.
    pub fn nearest(&self) -> f64 {
        let Self { discriminant, sheet, aperture, obstruction, radicand } = self;
        [discriminant, sheet, aperture, obstruction, radicand].iter().fold(f64::INFINITY, |least, m| least.min(m.abs()))
    }

    pub(super) fn of_hit(inputs: &Inputs, hit: &Hit, status: Status) -> Self {
        let case = &inputs.case;
        let d = to_f64(&inputs.direction);
        let point = to_f64(&hit.point);
        let mut margins = Self::NONE;
        let gradient = hit.gradient.to_f64();
        let n = to_f64(&hit.normal).map(|x| x * gradient);
        let Some(about) = Changes::new(inputs, point, hit.t.to_f64()) else { return margins };
        let cosine = hit.cosine.to_f64();
        let slope = cosine * gradient;
        let bend = about.local.bend(d);
        let curvature = hit.bend.abs();
        margins.discriminant = if slope == 0.0 {
            0.0
        } else {
            slope * slope / (2.0 * slope * about.slope + 2.0 * curvature * about.value)
        };
        // The change that turns `value`, which moves by `rate` with t and, t kept, by `fixed` with the numbers.
        let turning = |value: f64, fixed: f64, rate: f64| {
            let shift = (value / rate).abs();
            let along = (shift * slope / about.value).max(shift * shift * curvature / (2.0 * about.value));
            (value.abs() / fixed).min(if along.is_nan() { f64::INFINITY } else { along }) * value.signum()
        };

        let moved = about.moved;
        let upwards = norm(about.local.bend([0.0, 0.0, 1.0])) * moved;
        let sheet = turning(n[2], 1.0 + upwards + about.local.sum(|p| p.gradient[2]), bend[2]);
        margins.sheet = sheet;
        if let Some((end, change)) = about.local.profile_end {
            margins.sheet = sheet.min(turning(end, 1.0 + change.abs() * moved, change * norm(d)));
        }
        if status == Status::WrongSheet {
            return margins;
        }

        let r = point[0].hypot(point[1]);
        let outwards = if r > 0.0 { (point[0] * d[0] + point[1] * d[1]) / r } else { 1.0 };
        let squared = hit.point[0].squared() + hit.point[1].squared();
        // Without the cancellation of two near radii.
        let inside = |rim: f64| ((Big::new(rim).squared() - &squared) / Big::new(rim + r)).to_f64();
        if let Some(semi) = case.semi_diameter {
            margins.aperture = turning(inside(semi), moved + semi, outwards);
        }
        if status == Status::OutsideAperture {
            return margins;
        }
        if case.obstruction > 0.0 {
            margins.obstruction = turning(-inside(case.obstruction), moved + case.obstruction, outwards);
        }
        if status == Status::Obstructed {
            return margins;
        }

        if let Some(radicand) = hit.radicand.as_ref().filter(|_| inputs.n1 != inputs.n2) {
            let m = case.n1 / case.n2;
            // cos i moves with N by (side D − cos i N / |N|) / |N|.
            let lever = plus_times(d.map(|x| x * case.side), n, -cosine / gradient).map(|x| x / gradient);
            let twist = norm(about.local.bend(lever)) * moved + about.local.sum(|p| dot(p.gradient, lever));
            let fixed = 1.0 + 4.0 * m * m * (1.0 - cosine * cosine) + 2.0 * m * m * cosine * (2.0 + twist);
            margins.radicand = turning(radicand.to_f64(), fixed, 2.0 * m * m * cosine * dot(lever, bend));
        }
        margins
    }

    pub(super) fn of_miss(inputs: &Inputs, discriminant: Option<&Big>, nearest: Option<&Big>) -> Self {
        let foot = -big_dot(&inputs.origin, &inputs.direction);
        let is_conic = matches!(inputs.surface, Surface::Conic(_));
        // Of a conic, everything is about the point nearest the vertex, as it exists for every ray.
        let t = nearest.filter(|_| !is_conic).unwrap_or(&foot);
        let point = big_plus_times(&inputs.origin, &inputs.direction, t);
        let d = to_f64(&inputs.direction);
        let about = Changes::new(inputs, to_f64(&point), t.to_f64());
        let (Some(at), Some(about)) = (inputs.surface.at(&point), about) else {
            // The ray passes by a profile that ends: no root was near.
            return Self { sheet: -1.0, ..Self::NONE };
        };
        let value = at.value.to_f64().abs();
        if !is_conic {
            return Self { discriminant: -value / about.value, ..Self::NONE };
        }
        let slope = big_dot(&at.gradient, &inputs.direction).to_f64();
        let bend = dot(d, about.local.bend(d)).abs();
        let q = discriminant.map_or(0.0, Big::to_f64);
        if q >= 0.0 {
            // No crossing short of infinity: there is one for any A but 0, and for a plane if B turns.
            let is_flat = inputs.case.shape.profile().curvature == 0.0;
            let margin = if is_flat { -slope.abs() / (1.0 + slope.abs()) } else { 0.0 };
            return Self { discriminant: margin, ..Self::NONE };
        }
        let kc = inputs.case.shape.profile();
        let bending = 4.0 * (kc.conic * kc.curvature).abs() + kc.curvature.abs();
        let scale = 2.0 * slope.abs() * about.slope + 2.0 * bend * about.value + 2.0 * value * bending;
        Self { discriminant: q / scale, ..Self::NONE }
    }
}

/// Changes about a point of the ray by relative changes of the case by 1, taken as if they could add up.
struct Changes {
    local: Local,
    /// Change of the surface's function at the hit.
    value: f64,
    /// Change of N · D.
    slope: f64,
    /// Change of the place of the point, t kept.
    moved: f64,
}

impl Changes {
    fn new(inputs: &Inputs, point: Triple, t: f64) -> Option<Self> {
        let local = Local::new(&inputs.case, point)?;
        let d = to_f64(&inputs.direction);
        let moved = norm(to_f64(&inputs.origin)) + t.abs() + norm(point);
        let steepness = norm(local.gradient);
        let value = steepness * moved + local.sum(|p| p.value) + point[2].abs();
        let slope = 2.0 * steepness + norm(local.bend(d)) * moved + local.sum(|p| dot(p.gradient, d));
        Some(Self { local, value, slope, moved })
    }
}

//! A distortion that can be turned round: both ways between the plane before it and the plane behind it.

use super::limit::Limit;
use super::planar::Distortion;
use super::radial::Radial;
use glam::DVec2;

/// Steps of Newton's method, and halvings of one.
const MOST_STEPS: u32 = 60;
const MOST_HALVINGS: i32 = 12;
/// Parts of the picture's size that count as nothing: a few of the last bits.
const NOTHING: f64 = 4e-15;
/// Parts of the way from the middle at which a place is looked for that Newton's method did not find at once.
const FIRST_PART: f64 = 1.0 / 16.0;
const LEAST_PART: f64 = 1e-5;

/// A distortion with the part of its plane in which it can be turned round.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    distortion: Distortion,
    limit: Limit,
    /// About the size of the picture in the plane.
    size: f64,
}

impl Warp {
    /// `reach`: radius of the plane, which may be infinite; `size`: about that of the picture in it.
    pub(super) fn new(distortion: Distortion, reach: f64, size: f64) -> Self {
        let limit = Limit::new(&distortion, reach, size);
        Self { distortion, limit, size }
    }

    pub(super) fn limit(&self) -> &Limit {
        &self.limit
    }

    /// The distorted point; `None` beyond the limit.
    pub(super) fn forth(&self, q: DVec2) -> Option<DVec2> {
        if matches!(self.distortion, Distortion::Radial(Radial::Identity)) {
            return self.limit.holds(&self.distortion, q).then_some(q);
        }
        let value = self.limit.holds(&self.distortion, q).then(|| self.distortion.at(q).0)?;
        value.is_finite().then_some(value)
    }

    /// The point within the limit that is distorted to `target`; `None` if there is none.
    pub(super) fn back(&self, target: DVec2) -> Option<DVec2> {
        if !target.is_finite() {
            return None;
        }
        match self.distortion.radial() {
            Some(Radial::Identity) => self.limit.holds(&self.distortion, target).then_some(target),
            Some(radial) => self.radially(radial, target),
            None => {
                let start = DVec2::ZERO;
                self.newton(start, target).or_else(|| self.along_line_from_middle(target))
            }
        }
    }

    /// The inverse by Newton's method for the radius, kept between bounds: within the limit the distorted radius grows with the radius.
    fn radially(&self, radial: &Radial, target: DVec2) -> Option<DVec2> {
        let wanted = target.length();
        if wanted == 0.0 {
            return Some(DVec2::ZERO);
        }
        let value = |r: f64| r * radial.at(r).0;
        let limit = self.limit.least();
        let mut high = if limit.is_finite() { limit } else { 2.0 * wanted.max(self.size) };
        while limit.is_infinite() && value(high) < wanted {
            high *= 2.0;
            if high > 1e6 * self.size.max(wanted) {
                return None;
            }
        }
        if !(value(high) > wanted) {
            return None;
        }
        let mut low = 0.0;
        let mut r = (wanted / radial.at(0.0).0).min(high);
        let mut missed = wanted;
        for _ in 0..2 * MOST_STEPS {
            let (ratio, slope) = radial.at(r);
            let off = r * ratio - wanted;
            if off > 0.0 {
                high = r;
            } else {
                low = r;
            }
            if off.abs() <= NOTHING * wanted || high - low <= NOTHING * r {
                break;
            }
            let newton = r - off / slope;
            // Near a pole Newton's steps are of no use: what is missed must halve, or the bracket is halved.
            let is_quick = newton > low && newton < high && 2.0 * off.abs() <= missed;
            missed = off.abs();
            r = if is_quick { newton } else { 0.5 * (low + high) };
        }
        Some(target * (r / wanted))
    }

    /// The inverse by Newton's method with steps that are shortened until they bring the point nearer and stay within the limit.
    fn newton(&self, start: DVec2, target: DVec2) -> Option<DVec2> {
        let enough = NOTHING * (self.size + target.length());
        let mut q = start;
        let (value, mut slope) = self.distortion.at(q);
        let mut off = value - target;
        for _ in 0..MOST_STEPS {
            if off.length() <= enough {
                return Some(q);
            }
            let full = slope.inverse() * -off;
            if !full.is_finite() {
                return None;
            }
            let nearer = (0..MOST_HALVINGS).find_map(|halvings| {
                let next = q + full * 0.5f64.powi(halvings);
                if !self.limit.holds(&self.distortion, next) {
                    return None;
                }
                let (value, slope) = self.distortion.at(next);
                let missed = value - target;
                (missed.length() < off.length()).then_some((next, missed, slope))
            });
            match nearer {
                Some(found) => (q, off, slope) = found,
                // As near as numbers of this precision come.
                None => return (off.length() <= 64.0 * enough).then_some(q),
            }
        }
        (off.length() <= 64.0 * enough).then_some(q)
    }

    /// The inverse by following the straight line of targets from the middle's to the wanted one.
    fn along_line_from_middle(&self, target: DVec2) -> Option<DVec2> {
        let mut q = DVec2::ZERO;
        let begin = self.distortion.at(q).0;
        let (mut done, mut part) = (0.0, FIRST_PART);
        while done < 1.0 {
            let next = f64::min(done + part, 1.0);
            match self.newton(q, begin.lerp(target, next)) {
                Some(found) => {
                    (q, done) = (found, next);
                    part *= 2.0;
                }
                None => part *= 0.25,
            }
            if part < LEAST_PART {
                return None;
            }
        }
        Some(q)
    }
}

//! The crossing of a surface by all rays of a cell: where they hit it, and the normal there.

use crate::taylor::Taylor;
use petzval_optics::surface::{Asphere, Conic, Shape};

/// Three models: a place in mm or a direction.
pub(super) type Triple<const N: usize> = [Taylor<N>; 3];

/// Hits of the rays of a cell.
pub(super) struct Hits<const N: usize> {
    pub(super) point: Triple<N>,
    pub(super) normal: Triple<N>,
    /// |N|²
    pub(super) normal_squared: Taylor<N>,
    /// |N · D|
    pub(super) cosine: Taylor<N>,
    /// True if it is proved that all hits lie on the vertex sheet.
    pub(super) on_sheet: bool,
    /// True if it is proved that none does.
    pub(super) off_sheet: bool,
}

/// The crossing as far as it can be told.
pub(super) enum Met<const N: usize> {
    /// All rays hit the surface as given.
    All(Box<Hits<N>>),
    /// No ray hits it.
    None,
    /// Neither is proved.
    Unknown,
}

/// Newton's steps for an asphere's polynomial; each doubles the digits and the degrees that are right, so these are enough for any that
/// converges at all.
const STEPS: usize = 6;

pub(super) fn dot<const N: usize>(a: &Triple<N>, b: &Triple<N>) -> Taylor<N> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The surface crossed by rays from `p` along `d` (unit) with sign(N · D) = `side`, in its own coordinates.
pub(super) fn cross<const N: usize>(shape: &Shape, p: &Triple<N>, d: &Triple<N>, side: f64) -> Met<N> {
    match shape {
        Shape::Conic(conic) => cross_conic(conic, p, d, side),
        Shape::Asphere(asphere) => cross_asphere(asphere, p, d, side),
        Shape::Toroid(_) => Met::Unknown,
    }
}

/// The t of [`Conic::meet`] and |N · D|, or the discriminant of a ray that misses.
fn conic_root<const N: usize>(
    shape: &Conic,
    p: &Triple<N>,
    d: &Triple<N>,
    side: f64,
) -> Result<(Taylor<N>, Taylor<N>), Met<N>> {
    let (c, k) = (shape.curvature, shape.conic);
    let mut a = Taylor::constant(c);
    let (mut along, mut across) = (dot(p, d), p[0].squared() + p[1].squared() + p[2].squared());
    if k != 0.0 {
        a = (d[2].squared().times(k).plus(1.0)).times(c);
        along = along + (p[2] * d[2]).times(k);
        across = across + p[2].squared().times(k);
    }
    let b = along.times(c) - d[2];
    let cc = across.times(c) - p[2].times(2.0);
    let q = b.squared() - a * cc;
    if q.bounds().is_below(0.0) {
        return Err(Met::None);
    }
    let cosine = q.sqrt();
    let first = cosine.times(side) - b;
    let second = -b - cosine.times(side);
    // C / first = second / A; the one whose divisor is the larger.
    let t = match first.middle().abs() >= a.middle().abs() {
        true => cc / first,
        false => second / a,
    };
    Ok((t, cosine))
}

fn along<const N: usize>(p: &Triple<N>, d: &Triple<N>, t: Taylor<N>) -> Triple<N> {
    [p[0] + d[0] * t, p[1] + d[1] * t, p[2] + d[2] * t]
}

fn cross_conic<const N: usize>(shape: &Conic, p: &Triple<N>, d: &Triple<N>, side: f64) -> Met<N> {
    let (c, k) = (shape.curvature, shape.conic);
    let (t, cosine) = match conic_root(shape, p, d, side) {
        Ok(root) => root,
        Err(met) => return met,
    };
    let mut point = along(p, d, t);
    let mut upright = -(point[2].times(c + k * c)).plus(-1.0);
    // c + k c is rounded.
    upright = upright.widened(point[2].size() * (c * k).abs() * 4.0 * f64::EPSILON);
    let sheet = upright.bounds();
    let on_sheet = sheet.is_above(0.0);
    if on_sheet {
        // On the vertex sheet z and N's z depend on the distance from the axis alone, which keeps the remainder small.
        let squared = point[0].squared() + point[1].squared();
        let weight = inside(shape, &squared).sqrt();
        upright = upright.or(weight);
        point[2] = point[2].or(squared.times(c) / weight.plus(1.0));
    }
    let normal = [point[0].times(-c), point[1].times(-c), upright];
    let normal_squared = if k == 0.0 { Taylor::constant(1.0) } else { dot(&normal, &normal) };
    if !cosine.remainder().is_finite() || !point[2].remainder().is_finite() {
        return Met::Unknown;
    }
    Met::All(Box::new(Hits { point, normal, normal_squared, cosine, on_sheet, off_sheet: sheet.is_below(0.0) }))
}

/// 1 − (1 + k) c² u. The factor is rounded three times.
fn inside<const N: usize>(shape: &Conic, squared: &Taylor<N>) -> Taylor<N> {
    let (c, k) = (shape.curvature, shape.conic);
    let factor = (1.0 + k) * c * c;
    let rounded = (1.0 + k.abs()) * c * c * 4.0 * f64::EPSILON;
    (-squared.times(factor)).plus(1.0).widened(squared.size() * rounded)
}

/// Sag and slope over the distance, (dz/dr) / r, at r² = `squared`.
fn profile<const N: usize>(shape: &Asphere, terms: &[(u32, f64)], squared: &Taylor<N>) -> [Taylor<N>; 2] {
    let c = shape.base.curvature;
    let weight = inside(&shape.base, squared).sqrt();
    let mut sag = squared.times(c) / weight.plus(1.0);
    let mut slope = weight.reciprocal().times(c);
    if c == 0.0 {
        (sag, slope) = (Taylor::constant(0.0), Taylor::constant(0.0));
    }
    let highest = terms.iter().map(|(power, _)| *power).max().unwrap_or(0);
    // aₚ rᵖ⁻² by Horner's rule in u: even powers, then odd ones with a root.
    for odd in [0, 1] {
        let coefficient = |power: u32| terms.iter().find(|(p, _)| *p == power).map_or(0.0, |(_, a)| *a);
        let mut powers: Vec<u32> = (2..=highest).filter(|p| p % 2 == odd).collect();
        if powers.iter().all(|p| coefficient(*p) == 0.0) {
            continue;
        }
        let mut sum = Taylor::constant(0.0);
        let mut change = Taylor::constant(0.0);
        while let Some(power) = powers.pop() {
            let a = coefficient(power);
            sum = (sum * *squared).plus(a);
            // p aₚ is rounded.
            let scaled = f64::from(power) * a;
            change = (change * *squared).plus(scaled).widened(scaled.abs() * f64::EPSILON);
        }
        if odd == 1 {
            let radius = root_from_zero(squared);
            (sum, change) = (sum * radius, change * radius);
        }
        sag = sag + sum * *squared;
        slope = slope + change;
    }
    [sag, slope]
}

/// √u of a u that is not below 0 even where its bounds are.
fn root_from_zero<const N: usize>(squared: &Taylor<N>) -> Taylor<N> {
    let root = squared.sqrt();
    let high = squared.bounds().high.max(0.0).sqrt() * (1.0 + 4.0 * f64::EPSILON);
    root.or(Taylor::within(0.5 * high, 0.5 * high))
}

/// A root of z − sag(x² + y²) along the rays near that of the conicoid.
///
/// The polynomial T comes from Newton's method and may be any. Along each ray the function F has |F(T)| ≤ E, and on T ± h its slope has the
/// sign `side` and the size m > 0 at least: if E ≤ m h there is one root in there, and no more than one.
fn cross_asphere<const N: usize>(shape: &Asphere, p: &Triple<N>, d: &Triple<N>, side: f64) -> Met<N> {
    let Ok((start, _)) = conic_root(&shape.base, p, d, side) else { return Met::Unknown };
    if !start.remainder().is_finite() {
        return Met::Unknown;
    }
    let terms = shape.terms();
    let function = |t: Taylor<N>| {
        let at = along(p, d, t);
        let across = at[0] * d[0] + at[1] * d[1];
        let [sag, slope] = profile(shape, &terms, &(at[0].squared() + at[1].squared()));
        (at[2] - sag, d[2] - across * slope)
    };
    let near = Taylor::near_root(start, function, STEPS);
    let (value, _) = function(near);
    let error = value.size();
    // Wide enough for slopes down to a quarter.
    let reach = 4.0 * error;
    let (_, slope) = function(near.widened(reach));
    let least = slope.times(side).bounds().low;
    if !(error <= 0.5 * least * reach) || !reach.is_finite() {
        return Met::Unknown;
    }
    let t = near.widened(error / least * (1.0 + 8.0 * f64::EPSILON));
    let mut point = along(p, d, t);
    let squared = point[0].squared() + point[1].squared();
    let [sag, slope] = profile(shape, &terms, &squared);
    point[2] = point[2].or(sag);
    let normal = [-(point[0] * slope), -(point[1] * slope), Taylor::constant(1.0)];
    let normal_squared = (squared * slope.squared()).plus(1.0);
    let cosine = dot(&normal, d).times(side);
    if !cosine.bounds().is_above(0.0) {
        return Met::Unknown;
    }
    Met::All(Box::new(Hits { point, normal, normal_squared, cosine, on_sheet: true, off_sheet: false }))
}

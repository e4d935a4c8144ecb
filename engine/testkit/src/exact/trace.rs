//! The outcome of a ray at one surface, in exact numbers.

use super::big::{Big, Vector, dot, norm, plus_times, times, to_f64, unit};
use super::case::Case;
use super::inputs::{BigConic, Inputs, Surface};
use super::local::{Local, dot as dot_f64};
use super::margins::Margins;
use super::search;

/// The status of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The ray passed the surface.
    Ok,
    /// The ray hits no part of the surface with the right sign of N · D.
    Missed,
    /// The ray hits the mathematical surface off the vertex sheet only; never said of aspheres, which have no other sheet.
    WrongSheet,
    /// The hit lies outside of the clear aperture.
    OutsideAperture,
    /// The hit lies inside of the central obstruction.
    Obstructed,
    /// Total internal reflection at the hit.
    TotalInternalReflection,
}

/// The hit of a ray on a surface.
#[derive(Clone, Debug)]
pub struct Hit {
    /// Distance from the origin along the unit direction, in mm; negative if it lies behind.
    pub t: Big,
    /// The hit, in mm.
    pub point: Vector,
    /// N / |N|, N towards +z at the vertex.
    pub normal: Vector,
    /// |N|, N the gradient of the surface's function as [`super::Shape`] writes it, halved for conics.
    pub gradient: Big,
    /// cos i = |N · D| / |N|.
    pub cosine: Big,
    /// cos² i′ = 1 − (n1 / n2)² (1 − cos² i), below 0 at total internal reflection; `None` for a mirror.
    pub radicand: Option<Big>,
    /// The second derivative along the ray of the function that N is the gradient of; of conics −A.
    pub(super) bend: f64,
}

/// The outcome of a ray, exactly.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The status of the ray. The checks come in the order of [`Status`]; the first that fails names the loss.
    pub status: Status,
    /// The hit on the surface; `None` if it missed, present also if it was lost afterwards.
    pub hit: Option<Hit>,
    /// The unit direction afterwards, of a ray that passed.
    pub direction: Option<Vector>,
    /// (N · D)² at the hit; of conics this is B² − A C, known of misses too, and then below 0.
    pub discriminant: Option<Big>,
    /// The margins by which the outcome is not another one.
    pub margins: Margins,
}

/// The crossing of a ray with a surface, if there is one.
pub(super) enum Crossing {
    Met {
        t: Big,
        /// N · D: the derivative of the surface's function along the ray.
        slope: Big,
    },
    /// B² − A C of a conic, if it was formed.
    Missed {
        discriminant: Option<Big>,
        /// The place along the ray nearest to meeting the surface.
        nearest: Option<Big>,
    },
}

/// The outcome of the ray of `case`.
///
/// A conic takes 12 µs on one core and the other shapes 45 to 65 µs; a million hard rays of every category took half a minute on two.
///
/// # Panics
/// If a number of the case is not finite, or the direction is 0.
pub fn trace(case: &Case) -> Truth {
    trace_inputs(&Inputs::new(case))
}

/// The outcome of the ray of `case` with another origin and direction, exact as given: one that comes from a surface before. The direction is
/// of any length but 0; margins count the case's own origin and direction, which should be the nearest machine numbers.
///
/// # Panics
/// As [`trace`].
pub fn trace_from(case: &Case, origin: &Vector, direction: &Vector) -> Truth {
    trace_inputs(&Inputs { origin: origin.clone(), direction: unit(direction), ..Inputs::new(case) })
}

pub(super) fn trace_inputs(inputs: &Inputs) -> Truth {
    let crossing = match &inputs.surface {
        Surface::Conic(conic) => meet_conic(conic, &inputs.origin, &inputs.direction, inputs.case.side),
        Surface::Asphere(_) | Surface::Toroid(..) => search::meet(inputs),
    };
    match crossing {
        Crossing::Met { t, slope } => at_hit(inputs, t, slope),
        Crossing::Missed { discriminant, nearest } => {
            let margins = Margins::of_miss(inputs, discriminant.as_ref(), nearest.as_ref());
            Truth { status: Status::Missed, hit: None, direction: None, discriminant, margins }
        }
    }
}

/// The crossing of sign(N · D) = `side`: of A t² + 2 B t + C = 0 the root with A t + B = −side √(B² − A C).
pub(super) fn meet_conic(conic: &BigConic, p: &Vector, d: &Vector, side: f64) -> Crossing {
    let BigConic { c, k } = conic;
    let kz = k * &d[2];
    let a = c * (Big::new(1.0) + &kz * &d[2]);
    let b = c * (dot(p, d) + kz * &p[2]) - &d[2];
    let cc = c * (dot(p, p) + k * p[2].squared()) - p[2].times_power_of_two(1);
    let q = b.squared() - &a * &cc;
    if q.is_negative() {
        let nearest = Some(-(b / a));
        return Crossing::Missed { discriminant: Some(q), nearest };
    }
    let slope = if side < 0.0 { -q.sqrt() } else { q.sqrt() };
    let is_rising = (b.is_negative() && side > 0.0) || (b.is_positive() && side < 0.0);
    let t = match (is_rising, a.is_zero()) {
        (true, _) => cc / (&slope - b),
        (false, false) => -(b + &slope) / a,
        // The crossing is at infinity.
        (false, true) => return Crossing::Missed { discriminant: Some(q), nearest: None },
    };
    Crossing::Met { t, slope }
}

fn at_hit(inputs: &Inputs, t: Big, slope: Big) -> Truth {
    let case = &inputs.case;
    let point = plus_times(&inputs.origin, &inputs.direction, &t);
    let gradient = match inputs.surface.at(&point) {
        Some(at) => at.gradient,
        None => unreachable!("a search ends where the surface is"),
    };
    let length = norm(&gradient);
    let inverse = Big::new(1.0) / &length;
    let normal = times(&gradient, &inverse);
    let cosine = slope.abs() * &inverse;
    let squared = point[0].squared() + point[1].squared();
    let is_outside = case.semi_diameter.is_some_and(|semi| squared > Big::new(semi).squared());
    let is_obstructed = squared < Big::new(case.obstruction).squared();
    let ratio = &inputs.n1 / &inputs.n2;
    let one = Big::new(1.0);
    let radicand = (!case.mirror).then(|| {
        if inputs.n1 == inputs.n2 { cosine.squared() } else { &one - ratio.squared() * (&one - cosine.squared()) }
    });
    let status = if gradient[2].is_negative() {
        Status::WrongSheet
    } else if is_outside {
        Status::OutsideAperture
    } else if is_obstructed {
        Status::Obstructed
    } else if radicand.as_ref().is_some_and(Big::is_negative) {
        Status::TotalInternalReflection
    } else {
        Status::Ok
    };
    let along = if case.side < 0.0 { -Big::new(1.0) } else { one };
    let direction = (status == Status::Ok).then(|| match &radicand {
        None => plus_times(&inputs.direction, &normal, &-(along * &cosine).times_power_of_two(1)),
        Some(_) if inputs.n1 == inputs.n2 => inputs.direction.clone(),
        Some(radicand) => {
            let bend = along * (radicand.sqrt() - &ratio * &cosine);
            plus_times(&times(&inputs.direction, &ratio), &normal, &bend)
        }
    });
    let bend = bend_along(inputs, &point);
    let hit = Hit { t, point, normal, gradient: length, cosine, radicand, bend };
    let margins = Margins::of_hit(inputs, &hit, status);
    Truth { status, discriminant: Some(slope.squared()), hit: Some(hit), direction, margins }
}

fn bend_along(inputs: &Inputs, point: &Vector) -> f64 {
    if let Surface::Conic(BigConic { c, k }) = &inputs.surface {
        // Exact, as all depends on it where it is nearly 0.
        return -(c * (Big::new(1.0) + k * inputs.direction[2].squared())).to_f64();
    }
    let d = to_f64(&inputs.direction);
    Local::new(&inputs.case, to_f64(point)).map_or(0.0, |local| dot_f64(d, local.bend(d)))
}

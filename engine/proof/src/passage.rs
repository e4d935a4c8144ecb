//! The way of all rays of a cell through the surfaces.

use crate::cross::{Met, Triple, cross, dot};
use crate::taylor::Taylor;
use petzval_optics::surface::{Failure, Shape};
use petzval_optics::trace::{Action, Step};

/// The fate of all rays of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Each ray hits every surface on its vertex sheet within its clear aperture, outside of its obstruction and inside of the
    /// diaphragm's opening, and is refracted or reflected there.
    Passes,
    /// No ray gets past a surface.
    Stopped {
        /// Index of the step of the surface on the way.
        step: usize,
        /// The reason why no ray gets past it.
        reason: StopReason,
        /// True if each ray has passed all surfaces before; false if some or all may have been stopped there already.
        is_first: bool,
    },
    /// Neither is proved.
    Undecided,
}

/// The reason why no ray of a cell gets past a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The reason of the tracer.
    Failure(Failure),
    /// Each ray misses the surface or hits it outside of the clear aperture.
    Beside,
}

impl StopReason {
    /// The word for the reason in certificates.
    pub fn name(self) -> &'static str {
        match self {
            Self::Failure(failure) => failure.name(),
            Self::Beside => "beside",
        }
    }
}

/// The interface of a step for a cell of wavelengths: m = n / n′ and m² − 1, as [`petzval_optics::interface::Interface`] has them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indices<const N: usize> {
    pub(super) ratio: Taylor<N>,
    pub(super) excess: Taylor<N>,
}

impl<const N: usize> Indices<N> {
    /// The interface from index `from` to index `to`.
    pub(super) fn between(from: Taylor<N>, to: Taylor<N>) -> Self {
        let inverse = to.reciprocal();
        Self { ratio: from * inverse, excess: (from - to) * (from + to) * inverse.squared() }
    }
}

/// The rays of a cell behind a surface.
#[derive(Clone, Copy, Debug)]
pub struct Beam<const N: usize> {
    /// A point on each ray, seen from the vertex, mm.
    pub point: [Taylor<N>; 3],
    /// The unit directions.
    pub direction: [Taylor<N>; 3],
}

/// A rim, a blade or an obstruction as wide as rounding may make it, as part of its own width: the tracer squares in f64.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// Takes `beam` through `steps`; `indices` hold the interfaces that refract. Returns the fate, and the beam behind the last surface that it was followed
/// through: all of them if every ray passes.
#[expect(clippy::too_many_lines, reason = "one surface after the other, with all of its checks in their order")]
pub(super) fn pass<const N: usize>(
    steps: &[Step],
    indices: &[Option<Indices<N>>],
    opening_mm: f64,
    mut beam: Beam<N>,
) -> (Fate, Beam<N>) {
    let mut all_pass = true;
    for (i, (step, index)) in steps.iter().zip(indices).enumerate() {
        let stopped = |reason| (Fate::Stopped { step: i, reason, is_first: all_pass }, beam);
        let failed = |reason| stopped(StopReason::Failure(reason));
        let mut here = beam;
        here.point[2] = here.point[2].plus(step.to_here);
        let hits = match cross(&step.shape, &here.point, &here.direction, step.side) {
            Met::All(hits) => hits,
            Met::None => return failed(Failure::Missed),
            Met::Unknown => {
                return if is_beside(step, &here) { stopped(StopReason::Beside) } else { (Fate::Undecided, beam) };
            }
        };
        if hits.off_sheet {
            return failed(Failure::WrongSheet);
        }
        let squared = hits.point[0].squared() + hits.point[1].squared();
        let off_axis = squared.bounds();
        let (rim, obstruction) = (step.clear_squared, step.obstruction_squared);
        if off_axis.is_above(rim * (1.0 + ROUNDED)) {
            let reason = StopReason::Failure(Failure::OutsideAperture);
            return stopped(if hits.on_sheet { reason } else { StopReason::Beside });
        }
        let mut is_through = hits.on_sheet && off_axis.is_below(rim * (1.0 - ROUNDED));
        if obstruction > 0.0 {
            if off_axis.is_below(obstruction * (1.0 - ROUNDED)) && hits.on_sheet {
                return failed(Failure::Obstructed);
            }
            is_through = is_through && off_axis.is_above(obstruction * (1.0 + ROUNDED));
        }
        if step.is_stop {
            let opening = opening_mm * opening_mm;
            if off_axis.is_above(opening * (1.0 + ROUNDED)) {
                return failed(Failure::BladeStop);
            }
            is_through = is_through && off_axis.is_below(opening * (1.0 - ROUNDED));
        }
        let n = &hits.normal;
        let d = beam.direction;
        let direction = match (&step.action, index) {
            (Action::Pass, _) => d,
            (Action::Reflect, _) => {
                let twice = (hits.cosine / hits.normal_squared).times(2.0 * step.side);
                [0, 1, 2].map(|axis| d[axis] - n[axis] * twice)
            }
            (Action::Refract(_), Some(Indices { ratio, excess })) => {
                let incident = hits.cosine * *ratio;
                let radicand = incident.squared() - hits.normal_squared * *excess;
                if radicand.bounds().is_below(0.0) {
                    return failed(Failure::TotalInternalReflection);
                }
                let bend = excess.times(step.side) / (radicand.sqrt() + incident);
                [0, 1, 2].map(|axis| d[axis] * *ratio - n[axis] * bend)
            }
            (Action::Refract(_), None) => return (Fate::Undecided, beam),
        };
        let behind = Beam { point: hits.point, direction: of_unit_length(direction) };
        if !behind.direction.iter().all(|x| x.remainder().is_finite()) {
            return (Fate::Undecided, beam);
        }
        beam = behind;
        all_pass = all_pass && is_through;
    }
    (if all_pass { Fate::Passes } else { Fate::Undecided }, beam)
}

/// The directions with their z from x and y, where that says more: the rests of the three then do not grow apart.
fn of_unit_length<const N: usize>(d: Triple<N>) -> Triple<N> {
    let along = (d[0].squared() + d[1].squared()).times(-1.0).plus(1.0).sqrt();
    let z = d[2].bounds();
    if z.is_above(0.0) {
        [d[0], d[1], d[2].or(along)]
    } else if z.is_below(0.0) {
        [d[0], d[1], d[2].or(-along)]
    } else {
        d
    }
}

/// True if it is proved that no ray of the beam comes through the disc of the clear aperture: outside of it at every z between those of
/// the vertex and of the rim. Of spheres and conicoids, whose sag rises from the one to the other.
fn is_beside<const N: usize>(step: &Step, beam: &Beam<N>) -> bool {
    let Shape::Conic(conic) = &step.shape else { return false };
    let Some(sag) = conic.sag_mm(step.clear_squared.sqrt()) else { return false };
    let slack = sag.abs() * 1e-12;
    let z = Taylor::within(0.5 * sag, 0.5 * sag.abs() + slack);
    let t = (z - beam.point[2]) / beam.direction[2];
    let [x, y] = [0, 1].map(|axis| beam.point[axis] + beam.direction[axis] * t);
    (x.squared() + y.squared()).bounds().is_above(step.clear_squared * (1.0 + ROUNDED))
}

/// A beam from `from` towards `to`, seen from the vertex of the first step, mm; its points are those of `to`.
pub(super) fn aimed<const N: usize>(from: &Triple<N>, to: &Triple<N>) -> Beam<N> {
    let along: Triple<N> = [0, 1, 2].map(|axis| to[axis] - from[axis]);
    let inverse = dot(&along, &along).sqrt().reciprocal();
    Beam { point: *to, direction: along.map(|x| x * inverse) }
}

//! Traces hard rays in f64, in f32 and by the paper's printed equations, and holds them against the exact tracer.

// Each of its two users, the test and the example, leaves some of it unused.
#![allow(dead_code, unreachable_pub)]

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use petzval_optics::single_surface::{Outcome, SingleSurface};
use petzval_optics::surface::{Asphere, Conic, Failure, Shape, Toroid};
use petzval_testkit::exact::{self, Case, Precision, Profile, Status, Truth};
use petzval_testkit::hard_rays::Category;

/// The tracer of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// The stable form in f64.
    F64,
    /// The stable form in f32, on the same ray with all its numbers rounded to f32.
    F32,
    /// The paper's equations in f64.
    Printed,
}

impl By {
    pub const ALL: [Self; 3] = [Self::F64, Self::F32, Self::Printed];

    fn precision(self) -> Precision {
        if self == Self::F32 { Precision::F32 } else { Precision::F64 }
    }

    /// 2⁻⁵² or 2⁻²³.
    pub fn epsilon(self) -> f64 {
        if self == Self::F32 { f64::from(f32::EPSILON) } else { f64::EPSILON }
    }
}

/// Errors of vectors: in units in the last place of their length, and in those of the error that the data allow.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    ulps: Vec<f32>,
    /// The largest, over the effect on it of a change of one input by one unit in its last place (and no less than one
    /// unit of its own).
    pub worst_over_data: f64,
}

impl Errors {
    fn note(&mut self, error: f64, sensitivity: f64, ulp: f64) {
        self.ulps.push((error / ulp) as f32);
        self.worst_over_data = self.worst_over_data.max(error / sensitivity.max(ulp));
    }

    fn join(&mut self, other: Self) {
        self.ulps.extend(other.ulps);
        self.worst_over_data = self.worst_over_data.max(other.worst_over_data);
    }

    pub fn median(&mut self) -> f64 {
        if self.ulps.is_empty() {
            return 0.0;
        }
        let middle = self.ulps.len() / 2;
        f64::from(*self.ulps.select_nth_unstable_by(middle, f32::total_cmp).1)
    }

    pub fn worst(&self) -> f64 {
        self.ulps.iter().fold(0.0, |worst: f64, x| worst.max(f64::from(*x)))
    }
}

/// The results of the rays of one category.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub rays: u64,
    /// Rays lost by the exact tracer's word.
    pub lost: u64,
    /// Rays of another status than the exact one.
    pub other_status: u64,
    /// Largest relative change of the data, in roundings, that would have been needed to turn such a status.
    pub worst_margin: f64,
    /// The case of the largest such change.
    pub worst_case: Option<(Category, u64)>,
    pub point: Errors,
    pub direction: Errors,
    /// Answers with a number that is none.
    pub not_finite: u64,
}

impl Tally {
    fn join(&mut self, other: Self) {
        self.rays += other.rays;
        self.lost += other.lost;
        self.other_status += other.other_status;
        if other.worst_margin > self.worst_margin {
            (self.worst_margin, self.worst_case) = (other.worst_margin, other.worst_case);
        }
        self.point.join(other.point);
        self.direction.join(other.direction);
        self.not_finite += other.not_finite;
    }
}

fn profile(profile: &Profile) -> Asphere {
    Asphere::new(Conic { curvature: profile.curvature, conic: profile.conic }, &profile.terms)
}

/// The case as the tracer takes it.
pub fn surface(case: &Case) -> SingleSurface {
    SingleSurface {
        shape: match &case.shape {
            exact::Shape::Conic { curvature, conic } => Shape::Conic(Conic { curvature: *curvature, conic: *conic }),
            exact::Shape::Asphere(terms) => Shape::Asphere(profile(terms)),
            exact::Shape::Toroid { profile: terms, curvature_x } => {
                Shape::Toroid(Toroid { profile: profile(terms), across: *curvature_x })
            }
        },
        side: case.side,
        from: case.n1,
        to: case.n2,
        is_mirror: case.mirror,
        semi_diameter_mm: case.semi_diameter.unwrap_or(f64::INFINITY),
        obstruction_mm: case.obstruction,
    }
}

fn status(outcome: &Outcome) -> Option<Status> {
    Some(match outcome.direction {
        Ok(_) => Status::Ok,
        Err(Failure::Missed) => Status::Missed,
        Err(Failure::WrongSheet) => Status::WrongSheet,
        Err(Failure::OutsideAperture) => Status::OutsideAperture,
        Err(Failure::Obstructed) => Status::Obstructed,
        Err(Failure::TotalInternalReflection) => Status::TotalInternalReflection,
        Err(Failure::BladeStop | Failure::NotConverged) => return None,
    })
}

fn compare(by: By, case: &Case, truth: &Truth, outcome: &Outcome, tally: &mut Tally) {
    tally.rays += 1;
    tally.lost += u64::from(truth.status != Status::Ok);
    let is_finite = outcome.direction.is_none_or_finite() && outcome.hit.is_none_or(|hit| hit.point.is_finite());
    tally.not_finite += u64::from(!is_finite);
    if status(outcome) != Some(truth.status) {
        tally.other_status += 1;
        tally.worst_margin = tally.worst_margin.max(truth.margins.nearest() / by.epsilon());
        return;
    }
    let sensitivity = exact::sensitivity(case, truth, by.precision());
    let ulp = |v: &exact::Vector| exact::ulp_of(exact::norm(v).to_f64(), by.precision());
    if let (Some(hit), Some(exact)) = (outcome.hit, &truth.hit) {
        let error = exact::error_norm(hit.point.to_array(), &exact.point);
        // A hit on the vertex itself has no last place; the ray's own length stands in.
        let smallest = exact::ulp_of(DVec3::from(case.origin).length(), by.precision()) * f64::EPSILON;
        tally.point.note(error, sensitivity.point, ulp(&exact.point).max(smallest).max(f64::MIN_POSITIVE));
    }
    if let (Ok(direction), Some(exact)) = (outcome.direction, &truth.direction) {
        tally.direction.note(exact::error_norm(direction.to_array(), exact), sensitivity.direction, by.epsilon());
    }
}

trait NoneOrFinite {
    fn is_none_or_finite(&self) -> bool;
}

impl NoneOrFinite for Result<DVec3, Failure> {
    fn is_none_or_finite(&self) -> bool {
        self.is_err() || self.is_ok_and(|d| d.is_finite())
    }
}

/// One ray by all three ways.
pub fn measure_case(category: Category, seed: u64, index: u64, tallies: &mut [Tally; 3]) {
    let case = category.case(seed, index);
    let single = case.as_f32();
    let truth = exact::trace(&case);
    for (by, tally) in By::ALL.into_iter().zip(tallies) {
        let rounded = by == By::F32;
        let (case, truth) = if rounded { (&single, &exact::trace(&single)) } else { (&case, &truth) };
        let (origin, direction) = (DVec3::from(case.origin), DVec3::from(case.direction));
        let surface = surface(case);
        let outcome = match by {
            By::F64 => Some(surface.trace::<f64>(origin, direction)),
            By::F32 => Some(surface.trace::<f32>(origin, direction)),
            By::Printed => surface.trace_as_printed(origin, direction),
        };
        let before = tally.worst_margin;
        if let Some(outcome) = outcome {
            compare(by, case, truth, &outcome, tally);
        }
        if tally.worst_margin > before {
            tally.worst_case = Some((category, index));
        }
    }
}

/// Relative number of rays of a category for about as much time: the iterated shapes are slower to trace exactly.
fn share(category: Category) -> u64 {
    use Category::{Asphere, Cylinder, StrongAsphere, Toroid};
    if matches!(category, Asphere | StrongAsphere | Toroid | Cylinder) { 1 } else { 5 }
}

/// The tallies of [`By::ALL`] for each category, by about `rays` rays of all categories on all cores.
pub fn measure(rays: u64, seed: u64) -> Vec<(Category, [Tally; 3])> {
    const CHUNK: u64 = 500;
    let shares: u64 = Category::ALL.into_iter().map(share).sum();
    let of = |category: Category| (rays * share(category)).div_ceil(shares);
    let chunks: Vec<(usize, u64, u64)> = Category::ALL
        .into_iter()
        .enumerate()
        .flat_map(|(place, category)| {
            let count = of(category);
            (0..count).step_by(CHUNK as usize).map(move |first| (place, first, (first + CHUNK).min(count)))
        })
        .collect();
    let all: Mutex<Vec<[Tally; 3]>> = Mutex::new(vec![Default::default(); Category::ALL.len()]);
    let next = AtomicU64::new(0);
    let work = || {
        while let Some(&(place, first, last)) = chunks.get(next.fetch_add(1, Ordering::Relaxed) as usize) {
            let mut tallies: [Tally; 3] = Default::default();
            (first..last).for_each(|index| measure_case(Category::ALL[place], seed, index, &mut tallies));
            let mut all = all.lock().unwrap();
            for (sum, tally) in all[place].iter_mut().zip(tallies) {
                sum.join(tally);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    Category::ALL.into_iter().zip(all.into_inner().unwrap()).collect()
}

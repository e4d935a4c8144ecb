//! Exact rays through a lens, surface by surface, and rays in machine numbers beside them.

use glam::DVec3;
use petzval_optics::lane::Real;
use petzval_optics::prescription::{NextMedium, Prescription};
use petzval_optics::surface::{Asphere, Shape};
use petzval_optics::trace::{Failure, Ray, Tracer};
use petzval_optics::vector::Vector;
use petzval_testkit::exact::{self, Big, Case, Precision, Profile, Status, Truth};

use super::Compared;

/// The bound of docs/numerics.md on errors at a single surface: so many times the effect of one unit in the last place of one of the data.
const LARGEST_OVER_DATA: f64 = 10.0;
/// Roundings of a place or direction between surfaces: three products, their sum and a shift, into the surface's axes and out of them.
const ROUNDINGS: f64 = 8.0;
/// The largest part of a length that the bound of an error may be: beyond, the moved rays by which it is found say nothing of the errors between.
const TOLD: f64 = 1e-2;

/// The direction in which rays go through a lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    FromScene,
    FromFilm,
}

/// A surface and the media about it, as rays that go one way come to it.
struct Station {
    /// The case but for its ray.
    case: Case,
    /// Distance along the axis from the vertex of the surface before to this one, mm; 0 of the first.
    to_here_mm: f64,
    /// The surface's axes, and its vertex, seen from the vertex on the axis.
    axes: [[f64; 3]; 3],
    moved: [f64; 3],
    /// Number of the surface, from the scene.
    surface: usize,
}

/// The surfaces in the order of one way through a lens.
pub(super) struct Chain {
    stations: Vec<Station>,
    way: Way,
    /// z of the first station's vertex in lens space.
    start_z_mm: f64,
}

/// A ray that is seen from a vertex on the axis.
#[derive(Clone)]
struct ExactRay {
    point: exact::Vector,
    direction: exact::Vector,
}

/// The passage of an exact ray at a surface.
pub(super) struct Passage {
    case: Case,
    truth: Truth,
    /// Place and direction before the surface.
    before: ExactRay,
    /// The hit, if the surface was met.
    hit: Option<exact::Vector>,
    /// The new direction, if the ray passed.
    direction: Option<exact::Vector>,
}

/// Bounds of the errors of a place, mm, and of a direction; infinite where the data do not tell whether the ray comes so far.
#[derive(Clone, Copy, Debug, Default)]
struct Bound {
    place_mm: f64,
    direction: f64,
}

impl Bound {
    /// The bound of what the data do not tell.
    const NONE: Self = Self { place_mm: f64::INFINITY, direction: f64::INFINITY };

    fn is_told(self, scale_mm: f64) -> bool {
        self.place_mm <= TOLD * scale_mm && self.direction <= TOLD
    }

    fn add(&mut self, place_mm: f64, direction: f64) {
        self.place_mm += place_mm;
        self.direction += direction;
    }
}

fn big(v: [f64; 3]) -> exact::Vector {
    v.map(Big::new)
}

fn plus(a: &exact::Vector, b: &exact::Vector) -> exact::Vector {
    [0, 1, 2].map(|i| &a[i] + &b[i])
}

fn minus(a: &exact::Vector, b: &exact::Vector) -> exact::Vector {
    [0, 1, 2].map(|i| &a[i] - &b[i])
}

fn moved_by(a: &exact::Vector, b: DVec3) -> exact::Vector {
    plus(a, &big(b.to_array()))
}

fn distance(a: &exact::Vector, b: &exact::Vector) -> f64 {
    exact::norm(&minus(a, b)).to_f64()
}

fn length(a: &exact::Vector) -> f64 {
    exact::norm(a).to_f64()
}

fn profile(profile: &Asphere) -> Profile {
    Profile { curvature: profile.base.curvature, conic: profile.base.conic, terms: profile.terms() }
}

fn exact_shape(shape: &Shape) -> exact::Shape {
    match shape {
        Shape::Conic(conic) => exact::Shape::Conic { curvature: conic.curvature, conic: conic.conic },
        Shape::Asphere(asphere) => exact::Shape::Asphere(profile(asphere)),
        Shape::Toroid(toroid) => exact::Shape::Toroid { profile: profile(&toroid.profile), curvature_x: toroid.across },
    }
}

impl Station {
    fn turned_in(&self, v: &exact::Vector) -> exact::Vector {
        self.axes.map(|axis| exact::dot(v, &big(axis)))
    }

    fn turned_out(&self, v: &exact::Vector) -> exact::Vector {
        [0, 1, 2].map(|i| {
            let part = |axis: usize| &v[axis] * Big::new(self.axes[axis][i]);
            part(0) + part(1) + part(2)
        })
    }

    fn pass(&self, ray: &ExactRay) -> Passage {
        let point = self.turned_in(&minus(&ray.point, &big(self.moved)));
        let direction = self.turned_in(&ray.direction);
        let (origin, heading) = (exact::to_f64(&point), exact::to_f64(&direction));
        let case = Case { origin, direction: heading, ..self.case.clone() };
        let truth = exact::trace_from(&case, &point, &direction);
        let hit = truth.hit.as_ref().map(|hit| plus(&self.turned_out(&hit.point), &big(self.moved)));
        let direction = truth.direction.as_ref().map(|direction| self.turned_out(direction));
        Passage { case, truth, before: ray.clone(), hit, direction }
    }
}

impl Passage {
    /// The ray that goes on.
    fn behind(&self) -> Option<ExactRay> {
        Some(ExactRay { point: self.hit.clone()?, direction: self.direction.clone()? })
    }
}

impl Chain {
    /// The surfaces of a lens whose media have the indices `after` behind each; `last_z_mm` is where the lens has its last vertex.
    pub(super) fn new(lens: &Prescription, after: &[f64], way: Way, last_z_mm: f64) -> Self {
        let is_from_film = way == Way::FromFilm;
        let (mut side, mut before_mm) = (1.0, 0.0);
        let mut stations = Vec::new();
        for (i, row) in lens.surfaces.iter().enumerate() {
            let mirror = row.behind == NextMedium::Mirror;
            let before = if i == 0 { 1.0 } else { after[i - 1] };
            let side_after = if mirror { -side } else { side };
            let vector = |v: [f64; 3]| Vector::<f64>::from_f64(DVec3::from(v));
            stations.push(Station {
                case: Case {
                    shape: exact_shape(&row.shape),
                    origin: [0.0; 3],
                    direction: [0.0, 0.0, 1.0],
                    side: if is_from_film { -side_after } else { side },
                    n1: if is_from_film { after[i] } else { before },
                    n2: if is_from_film { before } else { after[i] },
                    mirror,
                    semi_diameter: Some(row.semi_diameter_mm),
                    obstruction: row.obstruction_mm,
                },
                to_here_mm: if is_from_film { -row.thickness_mm } else { before_mm },
                axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                    .map(|axis| row.pose.direction_out(vector(axis)).of(0).to_array()),
                moved: row.pose.point_out(vector([0.0; 3])).of(0).to_array(),
                surface: i,
            });
            (side, before_mm) = (side_after, row.thickness_mm);
        }
        if is_from_film {
            stations.reverse();
            if let Some(first) = stations.first_mut() {
                first.to_here_mm = 0.0;
            }
        }
        Self { stations, way, start_z_mm: if is_from_film { last_z_mm } else { 0.0 } }
    }

    /// The passages of a ray, as far as it comes.
    pub(super) fn passages_of(&self, ray: Ray) -> Vec<Passage> {
        let mut point = big(ray.origin.to_array());
        point[2] = &point[2] - Big::new(self.start_z_mm);
        self.passages(0, &ExactRay { point, direction: big(ray.direction.to_array()) })
    }

    /// The passages of a ray that is seen from the vertex of station `first`, from there on.
    fn passages(&self, first: usize, ray: &ExactRay) -> Vec<Passage> {
        let mut ray = ray.clone();
        let mut found: Vec<Passage> = Vec::new();
        for (i, station) in self.stations.iter().enumerate().skip(first) {
            if i > first {
                ray.point[2] = &ray.point[2] - Big::new(station.to_here_mm);
            }
            let passage = station.pass(&ray);
            let behind = passage.behind();
            found.push(passage);
            match behind {
                Some(next) => ray = next,
                None => break,
            }
        }
        found
    }

    /// Bounds of the errors before and behind each surface that the ray comes to.
    fn bounds(&self, passages: &[Passage], precision: Precision) -> Vec<[Bound; 2]> {
        let epsilon = epsilon(precision);
        let mut bounds = vec![[Bound::default(); 2]; passages.len()];
        for (i, passage) in passages.iter().enumerate() {
            let Some(hit) = &passage.hit else { break };
            let local = exact::sensitivity(&passage.case, &passage.truth, precision);
            let come_mm = if i == 0 { self.start_z_mm } else { self.stations[i].to_here_mm };
            let lengths = length(&passage.before.point) + length(hit) + come_mm.abs();
            let place_mm = LARGEST_OVER_DATA * local.point + ROUNDINGS * epsilon * lengths;
            let turn = LARGEST_OVER_DATA * local.direction.max(epsilon) + ROUNDINGS * epsilon;
            bounds[i][1].add(place_mm, turn);
            if let Some(behind) = passage.behind()
                && i + 1 < passages.len()
            {
                self.grow(i + 1, &behind, [place_mm, turn], passages, &mut bounds);
            }
        }
        bounds
    }

    /// Adds to the bounds from station `next` on what errors of a ray that comes from the station before grow to.
    fn grow(
        &self,
        next: usize,
        ray: &ExactRay,
        [place_mm, turn]: [f64; 2],
        passages: &[Passage],
        bounds: &mut [[Bound; 2]],
    ) {
        // Across the ray alone: along it a place is the same ray.
        let (u, v) = DVec3::from(exact::to_f64(&ray.direction)).normalize().any_orthonormal_pair();
        for axis in [u, v] {
            for (by_mm, by) in [(place_mm, 0.0), (0.0, turn)] {
                let mut moved = ExactRay {
                    point: moved_by(&ray.point, axis * by_mm),
                    direction: moved_by(&ray.direction, axis * by),
                };
                moved.point[2] = &moved.point[2] - Big::new(self.stations[next].to_here_mm);
                let moved = self.passages(next, &moved);
                for (j, there) in passages.iter().enumerate().skip(next) {
                    let [before, behind] = &mut bounds[j];
                    let Some(here) = moved.get(j - next) else {
                        (*before, *behind) = (Bound::NONE, Bound::NONE);
                        continue;
                    };
                    before.add(
                        distance(&here.before.point, &there.before.point),
                        distance(&here.before.direction, &there.before.direction),
                    );
                    let apart = |a: &Option<exact::Vector>, b: &Option<exact::Vector>| match (a, b) {
                        (Some(a), Some(b)) => distance(a, b),
                        (None, None) => 0.0,
                        _ => f64::INFINITY,
                    };
                    behind.add(apart(&here.hit, &there.hit), apart(&here.direction, &there.direction));
                }
            }
        }
    }

    /// Asserts that a ray ends as the exact one, or ends where the data do not tell.
    pub(super) fn compare<R: Real>(&self, tracer: &Tracer<R>, ray: Ray, passages: &[Passage]) -> Compared {
        let precision = if size_of::<R>() == size_of::<f32>() { Precision::F32 } else { Precision::F64 };
        let mut hits = Vec::new();
        let result = match self.way {
            Way::FromScene => tracer.from_scene_recording(ray, &mut hits),
            Way::FromFilm => tracer.from_film_recording(ray, &mut hits),
        };
        let bounds = self.bounds(passages, precision);
        let mut compared = Compared::default();
        let mut z = Big::new(self.start_z_mm);
        for (i, (passage, [before, behind])) in passages.iter().zip(bounds).enumerate() {
            let station = &self.stations[i];
            let what = || format!("{precision:?} {:?} surface {}: {ray:?}", self.way, station.surface);
            z = z + Big::new(station.to_here_mm);
            let scale_mm = length(&passage.before.point) + passage.case.semi_diameter.unwrap_or(0.0);
            if !before.is_told(scale_mm) {
                break;
            }
            // The relative change of the data that all errors so far amount to.
            let change = before.place_mm / scale_mm + before.direction;
            let is_sure = passage.truth.margins.nearest() > LARGEST_OVER_DATA * (epsilon(precision) + change);
            let lost = result.err().filter(|lost| lost.surface == station.surface).map(|lost| lost.reason);
            let is_same = match (passage.truth.status, lost) {
                (Status::Ok, lost) => lost.is_none(),
                (_, None) => false,
                // Of an asphere or a toroid the mathematical surface goes on beyond its rim, and may be met there or not.
                (status, Some(reason)) => {
                    !matches!(passage.case.shape, exact::Shape::Conic { .. }) || is_same(status, reason)
                }
            };
            let status = passage.truth.status;
            assert!(is_same || !is_sure, "{}: the exact ray is {status:?}, the other lost by {lost:?}", what());
            if lost.is_some() {
                compared.losses += u64::from(is_same);
            }
            let (Some(hit), Some(direction), Some(found)) = (&passage.hit, &passage.direction, hits.get(i)) else {
                break;
            };
            if !is_same || lost.is_some() || !behind.is_told(scale_mm) {
                break;
            }
            let mut truth = hit.clone();
            truth[2] = &truth[2] + &z;
            let error = exact::error_norm(found.to_array(), &truth);
            // Hits are told in f64 from the vertex of the first surface.
            let allowed = behind.place_mm + ROUNDINGS * f64::EPSILON * (length(&truth) + z.to_f64().abs());
            assert!(error <= allowed, "{}: the hit is off by {error:e} mm, {allowed:e} allowed", what());
            compared.hits += 1;
            if i + 1 == self.stations.len()
                && let Ok(out) = result
            {
                let whole = exact::norm(direction);
                let truth = [0, 1, 2].map(|k| &direction[k] / &whole);
                let (error, allowed) = (exact::error_norm(out.direction.to_array(), &truth), behind.direction);
                assert!(error <= allowed, "{}: the direction is off by {error:e}, {allowed:e} allowed", what());
                assert!((out.direction.length() - 1.0).abs() < 1e-15, "{}: no unit vector", what());
                compared.directions += 1;
            }
        }
        compared
    }
}

fn epsilon(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => f64::from(f32::EPSILON),
        Precision::F64 => f64::EPSILON,
    }
}

/// True if a reason is that of the exact ray. A diaphragm that is as wide as its surface's rim stops what the rim stops.
fn is_same(status: Status, reason: Failure) -> bool {
    match status {
        Status::Ok => false,
        Status::Missed => matches!(reason, Failure::Missed | Failure::NotConverged),
        Status::WrongSheet => reason == Failure::WrongSheet,
        Status::OutsideAperture => matches!(reason, Failure::OutsideAperture | Failure::BladeStop),
        Status::Obstructed => reason == Failure::Obstructed,
        Status::TotalInternalReflection => reason == Failure::TotalInternalReflection,
    }
}

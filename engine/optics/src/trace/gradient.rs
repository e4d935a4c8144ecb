//! Rays in a medium whose index changes from place to place: they bend on the way from surface to surface.
//!
//! With t for the length over the index and T = dR/dt, of length n, the equation of rays is d²R/dt² = n ∇n. It is solved
//! by Runge and Kutta's method in the form of Sharma, Kumar and Ghatak (Appl. Opt. 21, 984, 1982, eqs. 9 to 13), in steps
//! of equal t. Every ray takes the same steps at every wavelength and in every register, until the next surface is nearer
//! than one of them; the last is then as long as it must be for the ray to end on the surface.

use glam::DVec3;

use crate::diaphragm::Diaphragm;
use crate::glass::{Medium, line_nm};
use crate::interface::Interfaces;
use crate::lane::{Lane, Mask, Real};
use crate::surface::Pose;
use crate::system::Surface;
use crate::vector::Vector;

use super::step::{Intersection, Step};

/// Steps are as short as it takes for the place at the other end to change by less than this when they are halved, in
/// lengths of the way: 1e-10 mm in an eye's lens.
const TOLERANCE: f64 = 3e-11;
/// Numbers of steps that are tried for a way along the axis.
const STEPS: [u32; 17] = [2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512];
/// A ray that needs so many times the steps of the axis does not arrive.
const LONGEST: u32 = 4;
/// Each mends the last step as Newton's method does: the first leaves a part of the step that is its bend, 1e-2 at most.
const LANDINGS: f64 = 4.0;
/// Polynomials have no meaning far outside of their lens: there is no ray where the index is less than this.
const LEAST_INDEX: f64 = 0.3;

/// The media on both sides of a surface, at least one of which is a gradient, as rays on one way see them.
#[derive(Clone, Debug)]
pub(super) struct Gradients<R> {
    before: Option<(LocalMedium<R>, March<R>)>,
    behind: Option<LocalMedium<R>>,
    /// The indices before and behind the surface without the gradients.
    pub(super) indices: [R; 2],
}

/// A medium in the coordinates of a surface's vertex on the axis.
#[derive(Clone, Debug)]
struct LocalMedium<R> {
    /// Coefficients by powers of r², each by powers of z.
    rows: Box<[Box<[R]>]>,
    /// The vertex of the surface that the medium follows, and how that surface stands there.
    vertex_z: R,
    pose: Option<Pose<R>>,
    /// Distance from that vertex to where z is 0.
    from: R,
}

/// The length of a ray's steps in t, and their largest number.
#[derive(Clone, Copy, Debug)]
struct March<R> {
    step: R,
    most: u32,
}

/// A medium whose index changes from place to place, in numbers for a tracer on another processor. Lengths in mm, seen from the vertex
/// of the surface that a ray comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct GradientNumbers {
    /// Coefficients by powers of r², each by powers of z.
    pub rows: Vec<Vec<f64>>,
    /// z of the vertex of the surface that the medium follows.
    pub vertex_z: f64,
    /// Pose of the surface that the medium follows; `None`: on the axis, upright.
    pub pose: Option<Pose>,
    /// Distance along the axis from that vertex to the place at which the z of the powers is 0.
    pub from: f64,
    /// Length of a ray's steps over the index, mm; 0 of a medium that a ray only enters.
    pub step: f64,
    /// The greatest number of a ray's steps; 0 of a medium that a ray only enters.
    pub most_steps: u32,
}

/// The media on both sides of a surface, one of which is a gradient at least, as rays on one way see them.
#[derive(Clone, Debug, PartialEq)]
pub struct GradientsBeside {
    /// The medium before the surface, if it is a gradient.
    pub before: Option<GradientNumbers>,
    /// The medium behind the surface, if it is a gradient.
    pub behind: Option<GradientNumbers>,
    /// The indices before and behind without the gradients.
    pub indices: [f64; 2],
}

/// A gradient between two surfaces, in lens space.
pub(super) struct Gap {
    field: LocalMedium<f64>,
    march: March<f64>,
}

impl Gap {
    /// The media behind the surfaces, but for the last, that are gradients.
    pub(super) fn all(surfaces: &[Surface]) -> Vec<Option<Self>> {
        let mut follows = 0;
        let gap = |i: usize| {
            if matches!(surfaces[i].element, crate::system::Element::Refract { .. }) {
                follows = i;
            }
            let next = surfaces.get(i + 1)?;
            let medium = surfaces[follows].element.behind();
            let gradient = medium.gradient()?;
            let origin = &surfaces[follows];
            let field = LocalMedium {
                rows: gradient.rows().into_iter().map(Vec::into_boxed_slice).collect(),
                vertex_z: origin.z_mm,
                pose: Some(origin.pose).filter(|pose| !pose.is_identity()),
                from: gradient.from_mm(),
            };
            let march = March::new(&field, medium, &surfaces[i], next);
            Some(Self { field, march })
        };
        (0..surfaces.len()).map(gap).collect()
    }
}

impl Gradients<f64> {
    /// The gaps before and behind a surface on the way of the ray, the surface's vertex, and the indices without gradients.
    pub(super) fn at(before: Option<&Gap>, behind: Option<&Gap>, z_mm: f64, indices: [f64; 2]) -> Option<Self> {
        let field = |gap: &Gap| LocalMedium { vertex_z: gap.field.vertex_z - z_mm, ..gap.field.clone() };
        let is_any = before.is_some() || behind.is_some();
        is_any.then(|| Self { before: before.map(|gap| (field(gap), gap.march)), behind: behind.map(field), indices })
    }

    pub(super) fn cast<R: Real>(&self) -> Gradients<R> {
        Gradients {
            before: self
                .before
                .as_ref()
                .map(|(field, march)| (field.cast(), March { step: R::from_f64(march.step), most: march.most })),
            behind: self.behind.as_ref().map(LocalMedium::cast),
            indices: self.indices.map(R::from_f64),
        }
    }

    /// The gradients in numbers for a tracer on another processor.
    pub(super) fn numbers(&self) -> GradientsBeside {
        let numbers = |field: &LocalMedium<f64>, march: Option<&March<f64>>| GradientNumbers {
            rows: field.rows.iter().map(|row| row.to_vec()).collect(),
            vertex_z: field.vertex_z,
            pose: field.pose,
            from: field.from,
            step: march.map_or(0.0, |march| march.step),
            most_steps: march.map_or(0, |march| march.most),
        };
        GradientsBeside {
            before: self.before.as_ref().map(|(field, march)| numbers(field, Some(march))),
            behind: self.behind.as_ref().map(|field| numbers(field, None)),
            indices: self.indices,
        }
    }

    /// Places on the way of a ray from `p` along `d` to the surface of `step`, from the vertex of which they are seen;
    /// neither the start nor the end.
    pub(super) fn places(&self, step: &Step, p: Vector<f64>, d: Vector<f64>) -> Vec<DVec3> {
        self.stations(step, p, d).iter().skip(1).map(|flight| flight.at.of(0)).collect()
    }
}

impl<R: Real> Step<R> {
    /// [`Self::pass`] with `gradients` beside the surface; `numbers` are then the indices before and behind it without the shifts that the
    /// gradients add.
    #[inline(always)]
    pub(super) fn pass_gradients<L: Lane<Real = R>>(
        &self,
        mut p: Vector<L>,
        d: Vector<L>,
        diaphragm: &Diaphragm<R>,
        numbers: Option<[L; 2]>,
        gradients: &Gradients<R>,
    ) -> Intersection<L> {
        p.z = p.z + self.to_here;
        let bases = numbers.unwrap_or_else(|| gradients.bases(p.x));
        let (p, d, arrives) = gradients.carry(self, p, d, bases[0]);
        let mut crossing = self.meet(p, d);
        crossing.met = crossing.met & arrives;
        let place = match &self.pose {
            Some(pose) => pose.point_out(crossing.point),
            None => crossing.point,
        };
        let interface = Interfaces::between(gradients.indices_at(place, bases));
        self.act(self.own(p, d).1, crossing, diaphragm, Some(interface))
    }
}

impl<R: Real> Gradients<R> {
    /// The length that the way of one ray from `p` along `d` to the surface of `step` would have in a medium of the index that is
    /// before the vertex of that surface: its optical path over that index. `None` where the medium before is no gradient.
    pub(super) fn reduced_length(&self, step: &Step<R>, p: Vector<R>, d: Vector<R>) -> Option<R> {
        let (field, march) = self.before.as_ref()?;
        let base = self.indices[0];
        let square = |at: Vector<R>| field.index(at, base) * field.index(at, base);
        let half = R::from_f64(0.5);
        // ∫ n ds = ∫ n² dt, by Simpson's rule.
        let way = |from: &Flight<R>, t: R| {
            let (middle, end) = (from.after(field, base, t * half), from.after(field, base, t));
            (square(from.at) + square(middle.at) * R::from_f64(4.0) + square(end.at)) * R::from_f64(1.0 / 6.0) * t
        };
        let stations = self.stations(step, p, d);
        let here = *stations.last()?;
        let whole = stations[1..].iter().zip(&stations).fold(R::ZERO, |sum, (_, from)| sum + way(from, march.step));
        let (mut t, mut last) = (R::ZERO, here);
        for _ in 0..LANDINGS as u32 {
            t = t + step.meet(last.at, last.direction()).t / field.index(last.at, base);
            last = here.after(field, base, t);
        }
        let vertex = field.index(Vector { x: R::ZERO, y: R::ZERO, z: R::ZERO }, base);
        Some((whole + way(&here, t)) / vertex)
    }

    /// The points at which one ray from `p` along `d` begins each of its steps, the last, shorter one to the surface of `step` included;
    /// none where the medium before is no gradient.
    fn stations(&self, step: &Step<R>, p: Vector<R>, d: Vector<R>) -> Vec<Flight<R>> {
        let Some((field, march)) = &self.before else { return Vec::new() };
        let base = self.indices[0];
        let mut found = vec![Flight { at: p, pace: d * field.index(p, base) }];
        let mut here = found[0];
        for _ in 0..march.most {
            let crossing = step.meet(here.at, here.direction());
            if crossing.met && crossing.t <= march.step * field.index(here.at, base) {
                break;
            }
            here = here.after(field, base, march.step);
            found.push(here);
        }
        found
    }

    /// The indices without gradients, in all lanes.
    #[inline(always)]
    pub(super) fn bases<L: Lane<Real = R>>(&self, like: L) -> [L; 2] {
        self.indices.map(|index| like.like(index))
    }

    /// Carries rays from `p` along `d`, in the coordinates of the vertex of `step`, to where they need only go straight on
    /// to hit its surface, by some roundings; and which of them come so far.
    #[inline(always)]
    pub(super) fn carry<L: Lane<Real = R>>(
        &self,
        step: &Step<R>,
        p: Vector<L>,
        d: Vector<L>,
        base: L,
    ) -> (Vector<L>, Vector<L>, L::Mask) {
        let zero = p.x.like(R::ZERO);
        let Some((field, march)) = &self.before else { return (p, d, zero.at_most(zero)) };
        let length = zero.like(march.step);
        let (one, last) = (zero.like(R::ONE), zero.like(R::from_f64(LANDINGS)));
        let mut here = Flight { at: p, pace: d * field.index(p, base) };
        // Where the last step begins, how long it is, and how often it was mended.
        let (mut from, mut t, mut landings) = (here, zero, zero);
        let mut is_near = zero.less(zero);
        // One loop for both, so that the surface's code is there once.
        for _ in 0..march.most {
            let crossing = step.meet(here.at, here.direction());
            let index = field.index(here.at, base);
            from = Flight::select(is_near, from, here);
            t = L::select(is_near, t, zero);
            is_near = is_near | (crossing.met & crossing.t.at_most(length * index));
            t = L::select(is_near, t + crossing.t / index, length);
            here = Flight::select(landings.less(last), from.after(field, base, t), here);
            landings = landings + L::select(is_near, one, zero);
            if landings.at_least(last).all() {
                break;
            }
        }
        (here.at, here.direction(), landings.at_least(last))
    }

    /// The indices on both sides of a place on the surface.
    #[inline(always)]
    pub(super) fn indices_at<L: Lane<Real = R>>(&self, place: Vector<L>, [before, behind]: [L; 2]) -> [L; 2] {
        [
            self.before.as_ref().map_or(before, |(field, _)| field.index(place, before)),
            self.behind.as_ref().map_or(behind, |field| field.index(place, behind)),
        ]
    }
}

/// Rays on their way: where they are, and T.
#[derive(Clone, Copy)]
struct Flight<L> {
    at: Vector<L>,
    pace: Vector<L>,
}

impl<L: Lane> Flight<L> {
    #[inline(always)]
    fn select(mask: L::Mask, yes: Self, no: Self) -> Self {
        Self { at: Vector::select(mask, yes.at, no.at), pace: Vector::select(mask, yes.pace, no.pace) }
    }

    #[inline(always)]
    fn direction(&self) -> Vector<L> {
        let one = self.pace.x.like(L::Real::ONE);
        self.pace * (one / self.pace.length_squared().sqrt())
    }

    /// A step of `length` in t.
    #[inline(always)]
    fn after(&self, field: &LocalMedium<L::Real>, base: L, length: L) -> Self {
        let part = |x: f64| length * L::Real::from_f64(x);
        let Self { at, pace } = *self;
        let a = field.pull(at, base) * length;
        let b = field.pull(at + pace * part(0.5) + a * part(0.125), base) * length;
        let c = field.pull(at + pace * length + b * part(0.5), base) * length;
        let [two, four, sixth] = [2.0, 4.0, 1.0 / 6.0].map(|x| length.like(L::Real::from_f64(x)));
        Self { at: at + (pace + (a + b * two) * sixth) * length, pace: pace + (a + b * four + c) * sixth }
    }
}

/// The sum of a field's terms at a place, and its changes with z and with r².
struct LocalSums<L> {
    value: L,
    by_z: L,
    by_square: L,
}

impl LocalMedium<f64> {
    fn cast<R: Real>(&self) -> LocalMedium<R> {
        let row = |row: &[f64]| row.iter().map(|&a| R::from_f64(a)).collect();
        LocalMedium {
            rows: self.rows.iter().map(|numbers| row(numbers)).collect(),
            vertex_z: R::from_f64(self.vertex_z),
            pose: self.pose.map(|pose| pose.cast()),
            from: R::from_f64(self.from),
        }
    }
}

impl<R: Real> LocalMedium<R> {
    /// A place in the medium's own coordinates.
    #[inline(always)]
    fn inside<L: Lane<Real = R>>(&self, place: Vector<L>) -> Vector<L> {
        let mut p = Vector { z: place.z - self.vertex_z, ..place };
        if let Some(pose) = &self.pose {
            p = pose.point_in(p);
        }
        Vector { z: p.z - self.from, ..p }
    }

    /// Horner's rule, for z in each row and for r² over the rows.
    #[inline(always)]
    fn sums<L: Lane<Real = R>>(&self, p: Vector<L>) -> LocalSums<L> {
        let square = p.x * p.x + p.y * p.y;
        let zero = square.like(R::ZERO);
        let mut sums = LocalSums { value: zero, by_z: zero, by_square: zero };
        for row in self.rows.iter().rev() {
            let (mut value, mut by_z) = (zero, zero);
            for a in row.iter().rev() {
                by_z = by_z * p.z + value;
                value = value * p.z + *a;
            }
            sums.by_square = sums.by_square * square + sums.value;
            sums.value = sums.value * square + value;
            sums.by_z = sums.by_z * square + by_z;
        }
        sums
    }

    #[inline(always)]
    fn index<L: Lane<Real = R>>(&self, place: Vector<L>, base: L) -> L {
        (base + self.sums(self.inside(place)).value).most(base.like(R::from_f64(LEAST_INDEX)))
    }

    /// n ∇n at a place, 1/mm: d²R/dt² of a ray, with t the length over the index.
    #[inline(always)]
    fn pull<L: Lane<Real = R>>(&self, place: Vector<L>, base: L) -> Vector<L> {
        let p = self.inside(place);
        let sums = self.sums(p);
        let index = (base + sums.value).most(base.like(R::from_f64(LEAST_INDEX)));
        let across = index * (sums.by_square + sums.by_square);
        let pull = Vector { x: p.x * across, y: p.y * across, z: index * sums.by_z };
        match &self.pose {
            Some(pose) => pose.direction_out(pull),
            None => pull,
        }
    }
}

impl March<f64> {
    /// Steps for the way from one surface to the next, short enough for all rays that its rims let through.
    fn new(field: &LocalMedium<f64>, medium: &Medium, from: &Surface, to: &Surface) -> Self {
        let base = medium.base_index(line_nm::D);
        let semi = from.semi_diameter_mm.min(to.semi_diameter_mm);
        let sag = |s: &Surface| s.shape.rim_sag_mm(semi).unwrap_or(0.0);
        let edge = from.thickness_mm + sag(to) - sag(from);
        // Where surfaces touch, a ray may still cross from one rim towards the other.
        let span = from.thickness_mm.abs().max(edge.abs()).max(semi * 1e-3);
        let onward = if from.thickness_mm < 0.0 { -1.0 } else { 1.0 };
        let middle = Vector::from_f64(DVec3::new(0.0, 0.0, from.z_mm + 0.5 * from.thickness_mm));
        let whole = span / field.index(middle, base);
        let mut starts = Vec::new();
        for height in [0.0, 0.5, 1.0] {
            for slope in [0.0, -0.5, 0.5] {
                for across in [0.0, 0.5] {
                    let at = Vector::from_f64(DVec3::new(0.0, height * semi, from.z_mm));
                    let d = Vector::from_f64(DVec3::new(across, slope, onward).normalize());
                    starts.push(Flight { at, pace: d * field.index(at, base) });
                }
            }
        }
        let end = |start: &Flight<f64>, steps: u32| {
            (0..steps).fold(*start, |flight, _| flight.after(field, base, whole / f64::from(steps))).at.of(0)
        };
        let is_enough = |steps: u32| {
            starts.iter().all(|start| (end(start, steps) - end(start, 2 * steps)).length() <= TOLERANCE * span)
        };
        let steps = STEPS.into_iter().find(|steps| is_enough(*steps)).unwrap_or(STEPS[STEPS.len() - 1]);
        Self { step: whole / f64::from(steps), most: LONGEST * steps + 12 }
    }
}

//! A surface as a ray comes to it: the hit, the rims, the new direction.

use crate::diaphragm::Diaphragm;
use crate::interface::{Interface, Interfaces, reflect};
use crate::lane::{Lane, Mask, Real};
use crate::surface::{Conic, Crossing, Failure, Pose, Shape};
use crate::system::Surface;
use crate::vector::Vector;

/// The change of a ray's direction at a surface.
#[derive(Clone, Copy, Debug)]
pub enum Action<R> {
    /// Refraction between two media.
    Refract(Interface<R>),
    /// No change of direction: the medium is the same on both sides.
    Pass,
    /// Reflection.
    Reflect,
}

/// One surface, ready for rays of one wavelength in one direction of travel. Lengths in mm.
#[derive(Clone, Copy, Debug)]
pub struct Step<R = f64> {
    /// The shape of the surface.
    pub shape: Shape<R>,
    /// Pose of the surface; `None` if it stands on the axis, upright.
    pub pose: Option<Pose<R>>,
    /// The number added to z when the ray leaves the surface before: from its vertex to this one.
    pub to_here: R,
    /// sign(N · D) of the crossing that is meant.
    pub side: R,
    /// Square of the semi-diameter of the clear aperture, mm².
    pub clear_squared: R,
    /// Square of the radius of the central obstruction, mm²; 0 without one.
    pub obstruction_squared: R,
    /// The change of the ray's direction.
    pub action: Action<R>,
    /// True if the diaphragm is here.
    pub is_stop: bool,
    /// True if a ray from the surface before may start so far away, in radii, that it must be carried first.
    pub is_far: bool,
}

/// Beyond so many radii of curvature between surfaces, a ray is carried to its point nearest the vertex: larger
/// loses that many units in the last place, smaller costs time.
const FAR_RADII: f64 = 16.0;

impl Step {
    pub(super) fn cast<R: Real>(&self) -> Step<R> {
        let real = R::from_f64;
        Step {
            shape: self.shape.cast(),
            pose: self.pose.map(|pose| pose.cast()),
            to_here: real(self.to_here),
            side: real(self.side),
            clear_squared: real(self.clear_squared),
            obstruction_squared: real(self.obstruction_squared),
            action: match self.action {
                Action::Refract(interface) => Action::Refract(interface.cast()),
                Action::Pass => Action::Pass,
                Action::Reflect => Action::Reflect,
            },
            is_stop: self.is_stop,
            is_far: self.is_far,
        }
    }
}

impl<R: Real> Step<R> {
    /// The direction of light along the axis behind the surface, as seen by rays on this way.
    pub(super) fn side_after(&self) -> R {
        if matches!(self.action, Action::Reflect) { -self.side } else { self.side }
    }

    /// This step again if it is of the usual kind, a sphere or plane between two media, upright and not the stop, and
    /// `is_far` or not: with constants in it that the compiler sees.
    #[inline(always)]
    pub(super) fn plain(&self, is_far: bool) -> Option<Self> {
        match (self.shape, self.action) {
            (Shape::Conic(conic), Action::Refract(interface))
                if conic.conic == R::ZERO && self.pose.is_none() && !self.is_stop && self.is_far == is_far =>
            {
                let shape = Shape::Conic(Conic { conic: R::ZERO, ..conic });
                Some(Self { shape, pose: None, action: Action::Refract(interface), is_stop: false, is_far, ..*self })
            }
            _ => None,
        }
    }

    /// The hits of rays from `p` along `d`, seen from the vertex on the axis, on the surface, in its own coordinates.
    #[inline(always)]
    pub(super) fn meet<L: Lane<Real = R>>(&self, p: Vector<L>, d: Vector<L>) -> Crossing<L> {
        let (p, d) = self.own(p, d);
        match self.is_far {
            true => self.shape.meet_from_afar(p, d, self.side),
            false => self.shape.meet(p, d, self.side),
        }
    }

    /// A place and a direction in the surface's own coordinates.
    #[inline(always)]
    pub(super) fn own<L: Lane<Real = R>>(&self, p: Vector<L>, d: Vector<L>) -> (Vector<L>, Vector<L>) {
        match &self.pose {
            Some(pose) => (pose.point_in(p), pose.direction_in(d)),
            None => (p, d),
        }
    }

    /// The rays from `p` of the vertex before along `d` through this surface, where no medium beside it is a gradient.
    /// Points on a rim pass. Where there are `numbers`, each lane has its own wavelength: ratio and excess of its interface.
    #[inline(always)]
    pub(super) fn pass<L: Lane<Real = R>>(
        &self,
        mut p: Vector<L>,
        mut d: Vector<L>,
        diaphragm: &Diaphragm<R>,
        numbers: Option<[L; 2]>,
    ) -> Intersection<L> {
        p.z = p.z + self.to_here;
        (p, d) = self.own(p, d);
        let crossing = match self.is_far {
            true => self.shape.meet_from_afar(p, d, self.side),
            false => self.shape.meet(p, d, self.side),
        };
        let interfaces = numbers.map(|[ratio, excess]| Interfaces { ratio, excess });
        self.act(d, crossing, diaphragm, interfaces)
    }

    /// The passage of rays that have come to the surface along `d`, in its own coordinates.
    #[inline(always)]
    pub(super) fn act<L: Lane<Real = R>>(
        &self,
        d: Vector<L>,
        crossing: Crossing<L>,
        diaphragm: &Diaphragm<R>,
        interfaces: Option<Interfaces<L>>,
    ) -> Intersection<L> {
        let Vector { x, y, .. } = crossing.point;
        let squared = x * x + y * y;
        let is_transmitted;
        let mut direction = d;
        let zero = squared.like(R::ZERO);
        let all = zero.at_most(zero);
        match &self.action {
            Action::Refract(interface) => {
                (direction, is_transmitted) = match interfaces {
                    None => interface.refract(d, &crossing, self.side),
                    Some(lanes) => lanes.refract(d, &crossing, self.side, true),
                }
            }
            Action::Pass => is_transmitted = all,
            Action::Reflect => {
                direction = reflect(d, &crossing, self.side);
                is_transmitted = all;
            }
        }
        let mut point = crossing.point;
        if let Some(pose) = &self.pose {
            (point, direction) = (pose.point_out(point), pose.direction_out(direction));
        }
        Intersection {
            crossing,
            // Written so that NaN, too, is outside.
            is_inside: squared.at_most(squared.like(self.clear_squared)),
            is_unobstructed: squared.at_least(squared.like(self.obstruction_squared)),
            is_open: if self.is_stop { diaphragm.are_open(x, y) } else { all },
            is_transmitted,
            point,
            direction,
        }
    }
}

/// The passage of rays at a surface, one in each lane. The other numbers of rays that did not pass are undefined.
pub(super) struct Intersection<L: Lane> {
    /// The hits, in the surface's own coordinates.
    pub(super) crossing: Crossing<L>,
    is_inside: L::Mask,
    is_unobstructed: L::Mask,
    is_open: L::Mask,
    is_transmitted: L::Mask,
    /// The hit from the vertex on the axis.
    pub(super) point: Vector<L>,
    pub(super) direction: Vector<L>,
}

impl<L: Lane> Intersection<L> {
    #[inline(always)]
    pub(super) fn passed(&self) -> L::Mask {
        self.crossing.met & self.is_inside & self.is_unobstructed & self.is_open & self.is_transmitted
    }

    /// The fates of the rays, as bits.
    #[inline(always)]
    pub(super) fn fates(&self) -> Fates {
        Fates {
            passed: self.passed().bits(),
            met: self.crossing.met.bits(),
            wrong_sheet: self.crossing.wrong_sheet.bits(),
            not_converged: self.crossing.not_converged.bits(),
            inside: self.is_inside.bits(),
            unobstructed: self.is_unobstructed.bits(),
            open: self.is_open.bits(),
        }
    }
}

/// The fates of rays at a surface: a bit for each, in the order of the lanes.
pub(super) struct Fates {
    passed: u64,
    met: u64,
    wrong_sheet: u64,
    not_converged: u64,
    inside: u64,
    unobstructed: u64,
    open: u64,
}

impl Fates {
    /// The reason why ray `i` did not pass; `None` if it did.
    pub(super) fn failure(&self, i: usize) -> Option<Failure> {
        let is = |bits: u64| bits >> i & 1 != 0;
        if is(self.passed) {
            return None;
        }
        let reasons = [
            (is(self.wrong_sheet), Failure::WrongSheet),
            (is(self.not_converged), Failure::NotConverged),
            (!is(self.met), Failure::Missed),
            (!is(self.inside), Failure::OutsideAperture),
            (!is(self.unobstructed), Failure::Obstructed),
            (!is(self.open), Failure::BladeStop),
        ];
        let first = reasons.iter().find(|(applies, _)| *applies);
        Some(first.map_or(Failure::TotalInternalReflection, |(_, reason)| *reason))
    }
}

/// True if a ray from `from` may start many radii of `to` away from its vertex.
pub(super) fn is_far(from: &Surface, to: &Surface, thickness_mm: f64) -> bool {
    let sag = |s: &Surface| s.shape.rim_sag_mm(s.semi_diameter_mm).map_or(s.semi_diameter_mm, f64::abs);
    let along = thickness_mm.abs() + sag(from) + sag(to);
    let across = from.semi_diameter_mm + to.semi_diameter_mm;
    let radii = along.hypot(across) * to.shape.steepness();
    // Written so that NaN, too, is far.
    !(radii <= FAR_RADII)
}

//! Aspheres: a conicoid of revolution and a polynomial of the distance from the axis, to the power of 20.

use super::iterate::{Along, Profiled, Root, rising_root};
use super::{Conic, Crossing};
use crate::lane::{Lane, Real};
use crate::vector::Vector;

/// The highest power of the distance from the axis.
pub const LAST_POWER: u32 = 20;
const EVEN: usize = 10;
const ODD: usize = 9;

/// z = c r² / (1 + √(1 − (1 + k) c² r²)) + Σ aₚ rᵖ for p from 2 to 20.
///
/// Standard aspheres have even powers only; odd ones cost a square root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asphere<R = f64> {
    /// The conicoid to which the terms are added.
    pub base: Conic<R>,
    /// a₂, a₄ … a₂₀ in mm^(1 − p).
    even: [R; EVEN],
    /// a₃, a₅ … a₁₉.
    odd: [R; ODD],
    /// Number of even terms that count; the rest are 0.
    even_count: usize,
    odd_count: usize,
}

/// The profile at r² = u.
pub(super) struct AsphereProfile<L> {
    pub(super) sag: L,
    /// w = √(1 − (1 + k) c² u), the cosine of a sphere's slope; 0 where the conicoid has ended.
    pub(super) weight: L,
    /// 2 w dz/du = w z′ / r.
    pub(super) slope: L,
}

impl Asphere {
    /// `base` with `terms` (power, coefficient in mm^(1 − power)), powers 2 to 20; terms of other powers are
    /// left out.
    pub fn new(base: Conic, terms: &[(u32, f64)]) -> Self {
        let (mut even, mut odd) = ([0.0; EVEN], [0.0; ODD]);
        for &(power, coefficient) in terms.iter().filter(|(power, _)| (2..=LAST_POWER).contains(power)) {
            let place = power as usize / 2 - 1;
            if power % 2 == 0 { even[place] += coefficient } else { odd[place] += coefficient }
        }
        let count = |terms: &[f64]| terms.iter().rposition(|a| *a != 0.0).map_or(0, |last| last + 1);
        let (even_count, odd_count) = (count(&even), count(&odd));
        Self { base, even, odd, even_count, odd_count }
    }

    /// The polynomial terms of this surface on another conicoid.
    pub fn with_base(&self, base: Conic) -> Self {
        Self { base, ..*self }
    }

    /// (power, coefficient) of the terms that are not 0, by power.
    pub fn terms(&self) -> Vec<(u32, f64)> {
        let even = self.even.iter().zip(0u32..).map(|(a, i)| (2 * i + 2, *a));
        let odd = self.odd.iter().zip(0u32..).map(|(a, i)| (2 * i + 3, *a));
        let mut all: Vec<(u32, f64)> = even.chain(odd).filter(|(_, a)| *a != 0.0).collect();
        all.sort_by_key(|(power, _)| *power);
        all
    }

    /// Sag z in mm at `radius_mm` from the axis; `None` where the surface does not reach.
    pub fn sag_mm(&self, radius_mm: f64) -> Option<f64> {
        self.base.sag_mm(radius_mm).map(|_| self.profile(radius_mm * radius_mm).sag)
    }

    /// c + 2 a₂.
    pub(super) fn curvature_at_vertex(&self) -> f64 {
        self.base.curvature + 2.0 * self.even[0]
    }

    pub(super) fn asphericity(&self) -> f64 {
        let Conic { curvature, conic } = self.base;
        let vertex = self.curvature_at_vertex();
        let departure = if vertex == curvature { 0.0 } else { curvature.powi(3) - vertex.powi(3) };
        conic * curvature.powi(3) + departure + 8.0 * self.even[1]
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        let terms: Vec<(u32, f64)> =
            self.terms().into_iter().map(|(power, a)| (power, a / factor.powi(power as i32 - 1))).collect();
        Self::new(self.base.scaled(factor), &terms)
    }

    pub(super) fn cast<R: Real>(&self) -> Asphere<R> {
        Asphere {
            base: self.base.cast(),
            even: self.even.map(R::from_f64),
            odd: self.odd.map(R::from_f64),
            even_count: self.even_count,
            odd_count: self.odd_count,
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        let numbers = self.even.iter().chain(&self.odd).chain([&self.base.curvature, &self.base.conic]);
        numbers.into_iter().all(|x| x.is_finite())
    }
}

impl<R: Real> Asphere<R> {
    /// The value and derivative by u of Σ aⱼ uʲ, j from 0.
    #[inline(always)]
    fn horner<L: Lane<Real = R>>(terms: &[R], u: L) -> (L, L) {
        let mut value = u.like(R::ZERO);
        let mut slope = value;
        for a in terms.iter().rev() {
            slope = slope * u + value;
            value = value * u + *a;
        }
        (value, slope)
    }

    /// Beyond the rim of the conicoid the sag goes on as c u, so that an iteration may look there and come back.
    #[inline(always)]
    pub(super) fn profile<L: Lane<Real = R>>(&self, u: L) -> AsphereProfile<L> {
        let Conic { curvature: c, conic: k } = self.base;
        let zero = u.like(R::ZERO);
        let weight = (-(u * ((R::ONE + k) * c * c) - R::ONE)).most(zero).sqrt();
        let base = u * c / (weight + R::ONE);
        let (sum, change) = Self::horner(&self.even[..self.even_count], u);
        let (mut polynomial, mut slope) = (sum * u, sum + change * u);
        if self.odd_count > 0 {
            let (sum, change) = Self::horner(&self.odd[..self.odd_count], u);
            let radius = u.sqrt();
            polynomial = polynomial + radius * u * sum;
            slope = slope + radius * (sum * R::from_f64(1.5) + change * u);
        }
        AsphereProfile { sag: base + polynomial, weight, slope: (slope + slope) * weight + c }
    }

    /// See [`super::Shape::meet`]: Newton's method from the hit of the conicoid.
    #[inline(always)]
    pub(super) fn meet<L: Lane<Real = R>>(&self, p: Vector<L>, d: Vector<L>, side: R) -> Crossing<L> {
        let base = self.base.meet(p, d, side);
        let start = L::select(base.met, base.t, p.x.like(R::ZERO));
        let root = rising_root(start, side, size(p, start), &RayToAsphere { shape: self, p, d });
        let point = p + d * root.t;
        let AsphereProfile { weight, slope, .. } = self.profile(point.x * point.x + point.y * point.y);
        let normal = Vector { x: -(point.x * slope), y: -(point.y * slope), z: weight };
        let mut crossing = at_root(root, point, normal, d, side);
        crossing.wrong_sheet = base.wrong_sheet & !crossing.met;
        crossing
    }
}

struct RayToAsphere<'a, L: Lane> {
    shape: &'a Asphere<L::Real>,
    p: Vector<L>,
    d: Vector<L>,
}

impl<L: Lane> Profiled<L> for RayToAsphere<'_, L> {
    #[inline(always)]
    fn along(&self, t: L) -> Along<L> {
        let d = self.d;
        let at = self.p + d * t;
        let AsphereProfile { sag, weight, slope } = self.shape.profile(at.x * at.x + at.y * at.y);
        Along {
            value: (at.z - sag) * weight,
            slope: d.z * weight - (at.x * d.x + at.y * d.y) * slope,
            terms: (at.z.abs() + sag.abs()) * weight,
        }
    }
}

/// The length of the interval that an iteration searches, from the point nearest the vertex and its first guess.
#[inline(always)]
pub(super) fn size<L: Lane>(p: Vector<L>, start: L) -> L {
    let size = p.length_squared().sqrt() + start.abs();
    size + size
}

/// The crossing at a root that was iterated to.
#[inline(always)]
pub(super) fn at_root<L: Lane>(
    root: Root<L>,
    point: Vector<L>,
    normal: Vector<L>,
    d: Vector<L>,
    side: L::Real,
) -> Crossing<L> {
    let zero = root.t.like(L::Real::ZERO);
    let cosine = normal.dot(d) * side;
    Crossing {
        t: root.t,
        point,
        normal,
        normal_squared: normal.length_squared(),
        cosine_squared: cosine * cosine,
        cosine,
        met: root.converged & cosine.at_least(zero) & normal.z.greater(zero) & root.t.is_finite(),
        wrong_sheet: zero.less(zero),
        not_converged: root.not_converged,
    }
}

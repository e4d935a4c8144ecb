//! The opening of the diaphragm: round, a regular polygon of straight or curved blades, or of a mask's shape.
//!
//! A polygon is inscribed in the round opening of the same f-number: its corners touch the circle of the stop's
//! radius. So the f-number, the bounds and the planes of focus do not depend on the blades, and fewer blades pass
//! less light (six blades 17 % less), as they do when blades close over a round opening. Curved blades bulge outwards
//! between the corners: each side is an arc of the radius R / curvature, R the stop's radius, so that curvature 0 is
//! the polygon and curvature 1 the full circle.

mod mask;

use std::f64::consts::TAU;
use std::sync::Arc;

use thiserror::Error;

use crate::lane::{Lane, Mask, Real};

pub use mask::{ApertureMask, MaskError};

/// Largest number of blades: more look round.
const MOST_BLADES: u32 = 64;

/// No lane holds more numbers.
const WIDEST_LANE: usize = 16;

/// An error by which blades make no diaphragm.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum DiaphragmError {
    /// The number of blades is larger than that of any diaphragm.
    #[error("{0} blades; give 3 to {MOST_BLADES}, or 0 for a round opening")]
    Blades(u32),
    /// The turn of the blades is no angle.
    #[error("the rotation of the blades is {0} rad; give a finite angle")]
    Rotation(f64),
    /// Blades that bend inwards, or out of the circle.
    #[error("the curvature of the blades is {0}; give 0 (straight) to 1 (round)")]
    Curvature(f64),
}

/// The diaphragm's opening, centred on the axis in the plane of the stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Diaphragm<R = f64> {
    radius_mm: R,
    apothem_mm: R,
    rotation_rad: f64,
    curvature: f64,
    /// Half of the inverse distance from an arc's centre to its chord, in 1/mm; 0 if the blades are straight.
    bulge: R,
    /// Unit vectors from the centre to the middle of each side; empty if round.
    sides: Vec<[R; 2]>,
    mask: Option<Arc<Masked>>,
}

/// A mask in its place.
#[derive(Clone, Debug, PartialEq)]
struct Masked {
    shape: Arc<ApertureMask>,
    radius_mm: f64,
    /// Cosine of the rotation.
    cos: f64,
    sin: f64,
}

impl Diaphragm {
    /// A round opening with this radius.
    pub fn round(radius_mm: f64) -> Self {
        let apothem_mm = radius_mm;
        Self { radius_mm, apothem_mm, rotation_rad: 0.0, curvature: 0.0, bulge: 0.0, sides: Vec::new(), mask: None }
    }

    /// The opening of a mask whose width spans the circle of `radius_mm`, turned by `rotation_rad` (finite).
    pub fn masked(radius_mm: f64, shape: Arc<ApertureMask>, rotation_rad: f64) -> Self {
        let (sin, cos) = rotation_rad.sin_cos();
        let mask = Some(Arc::new(Masked { shape, radius_mm, cos, sin }));
        Self { rotation_rad, mask, ..Self::round(radius_mm) }
    }

    /// A copy of this diaphragm without its mask: the circle that holds the mask.
    pub(crate) fn without_mask(&self) -> Self {
        Self { mask: None, ..self.clone() }
    }

    /// The mask that shapes the opening, turned by [`Self::rotation_rad`], its width spanning the circle of [`Self::radius_mm`].
    pub fn mask(&self) -> Option<&ApertureMask> {
        self.mask.as_ref().map(|mask| &*mask.shape)
    }

    /// True if a mask shapes the opening.
    pub fn is_masked(&self) -> bool {
        self.mask.is_some()
    }

    /// An opening of `blades` straight blades in the circle of `radius_mm`; one corner lies at `rotation_rad` from
    /// the x axis towards y. Fewer than three blades: round.
    pub fn polygon(radius_mm: f64, blades: u32, rotation_rad: f64) -> Self {
        Self::bladed(radius_mm, blades, 0.0, rotation_rad)
    }

    /// An opening of `blades` curved blades in the circle of `radius_mm`; one corner lies at `rotation_rad` from the x axis towards y.
    /// `curvature` goes from 0 (straight, [`Self::polygon`]) to 1 (the full circle); it is taken into that range. Fewer than three blades,
    /// or the full circle: round.
    pub fn bladed(radius_mm: f64, blades: u32, curvature: f64, rotation_rad: f64) -> Self {
        // Below a millionth an arc leaves its chord by less than f32 holds of the radius, and its centre is too far.
        let curvature = if curvature > 1e-6 { curvature } else { 0.0 };
        if curvature >= 1.0 {
            return Self::round(radius_mm);
        }
        if blades < 3 {
            return Self::round(radius_mm);
        }
        let step = TAU / f64::from(blades);
        let side = |i: u32| {
            let (y, x) = (rotation_rad + (f64::from(i) + 0.5) * step).sin_cos();
            [x, y]
        };
        let sides = (0..blades).map(side).collect();
        let (sin, cos) = (0.5 * step).sin_cos();
        let bent = curvature * sin;
        let bulge = if curvature > 0.0 { 0.5 * curvature / (radius_mm * (1.0 - bent * bent).sqrt()) } else { 0.0 };
        Self { radius_mm, apothem_mm: radius_mm * cos, rotation_rad, curvature, bulge, sides, mask: None }
    }

    /// [`Self::bladed`] of a user's settings: the blades at most 64, the curvature in 0 to 1, the rotation finite.
    pub fn checked(radius_mm: f64, blades: u32, curvature: f64, rotation_rad: f64) -> Result<Self, DiaphragmError> {
        if blades > MOST_BLADES {
            return Err(DiaphragmError::Blades(blades));
        }
        if !rotation_rad.is_finite() {
            return Err(DiaphragmError::Rotation(rotation_rad));
        }
        if !(0.0..=1.0).contains(&curvature) {
            return Err(DiaphragmError::Curvature(curvature));
        }
        Ok(Self::bladed(radius_mm, blades, curvature, rotation_rad))
    }

    /// Radius of the circle through the corners, in mm.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Number of blades; 0 if round or masked.
    pub fn blades(&self) -> u32 {
        self.sides.len() as u32
    }

    /// Distance from the axis to the middle of a blade's edge, in mm: where the opening is narrowest.
    pub fn inner_radius_mm(&self) -> f64 {
        if self.blades() > 0 && self.curvature > 0.0 {
            let (radius, centre, _) = self.arc();
            return centre + radius;
        }
        self.apothem_mm
    }

    /// Angle of one corner from the x axis towards y, in rad.
    pub fn rotation_rad(&self) -> f64 {
        self.rotation_rad
    }

    /// Curvature of the blades: 0 straight, and less than 1, which is round.
    pub fn curvature(&self) -> f64 {
        self.curvature
    }

    /// Distance from the axis to the chord between two corners, mm; the radius of a round opening.
    pub fn apothem_mm(&self) -> f64 {
        self.apothem_mm
    }

    /// Half of the inverse distance from the centre of a blade's arc to its chord, in 1/mm; 0 if the blades are straight.
    pub fn bulge(&self) -> f64 {
        self.bulge
    }

    /// Unit vectors from the centre to the middle of each blade's edge; empty if round.
    pub fn sides(&self) -> &[[f64; 2]] {
        &self.sides
    }

    /// One curved blade: radius of its arc and signed place of its centre towards the side (mm), and half of the angle it spans (rad).
    fn arc(&self) -> (f64, f64, f64) {
        let radius = self.radius_mm / self.curvature;
        let half_angle = (self.curvature * (0.5 * TAU / f64::from(self.blades())).sin()).asin();
        (radius, self.apothem_mm - radius * half_angle.cos(), half_angle)
    }

    /// Area of the opening in mm²; of a mask, to a hundredth of the area of the cells on its rim.
    pub fn area_mm2(&self) -> f64 {
        if let Some(mask) = &self.mask {
            return 4.0 * mask.shape.open_part() * self.radius_mm * self.radius_mm;
        }
        match self.blades() {
            0 => 0.5 * TAU * self.radius_mm * self.radius_mm,
            blades if self.curvature > 0.0 => {
                let (radius, centre, half_angle) = self.arc();
                f64::from(blades) * radius * (radius * half_angle + centre * half_angle.sin())
            }
            blades => {
                let half_side = (self.radius_mm * self.radius_mm - self.apothem_mm * self.apothem_mm).sqrt();
                f64::from(blades) * half_side * self.apothem_mm
            }
        }
    }

    /// A point (x, y) in mm of the opening, evenly, by two numbers in [0, 1).
    pub fn sample(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        if let Some(mask) = &self.mask {
            let [x, y] = mask.shape.sample([u, v]).map(|x| x * mask.radius_mm);
            return [mask.cos * x - mask.sin * y, mask.sin * x + mask.cos * y];
        }
        let out = v.sqrt() * self.radius_mm;
        let blades = self.blades();
        if blades == 0 {
            let (sin, cos) = (TAU * u).sin_cos();
            return [out * cos, out * sin];
        }
        // A blade's triangle, then a point of it.
        let place = u * f64::from(blades);
        let first = place.floor();
        let along = place - first;
        if self.curvature > 0.0 {
            let [x, y] = self.on_arc(first, along);
            return [v.sqrt() * x, v.sqrt() * y];
        }
        let corner = |i: f64| (self.rotation_rad + i * TAU / f64::from(blades)).sin_cos();
        let ((y, x), (y2, x2)) = (corner(first), corner(first + 1.0));
        [out * (x + (x2 - x) * along), out * (y + (y2 - y) * along)]
    }

    /// The point (x, y) in mm of the arc of blade `blade` up to which the part `along` of its sector's area lies.
    fn on_arc(&self, blade: f64, along: f64) -> [f64; 2] {
        let (radius, centre, half_angle) = self.arc();
        // Seen from the axis, the arc up to the angle a about its own centre sweeps (radius a + centre sin a) radius / 2,
        // which is odd in a and nearly straight: a few steps of Newton's reach rounding.
        let swept = |angle: f64| radius * angle + centre * angle.sin();
        let wanted = (2.0 * along - 1.0) * swept(half_angle);
        let mut angle = (2.0 * along - 1.0) * half_angle;
        for _ in 0..4 {
            let step = (wanted - swept(angle)) / (radius + centre * angle.cos());
            angle = (angle + step).clamp(-half_angle, half_angle);
        }
        let (sin, cos) = angle.sin_cos();
        let (out, across) = (centre + radius * cos, radius * sin);
        let (ny, nx) = (self.rotation_rad + (blade + 0.5) * TAU / f64::from(self.blades())).sin_cos();
        [out * nx - across * ny, out * ny + across * nx]
    }

    /// This diaphragm in numbers of another kind.
    pub fn cast<R: Real>(&self) -> Diaphragm<R> {
        Diaphragm {
            radius_mm: R::from_f64(self.radius_mm),
            apothem_mm: R::from_f64(self.apothem_mm),
            rotation_rad: self.rotation_rad,
            curvature: self.curvature,
            bulge: R::from_f64(self.bulge),
            sides: self.sides.iter().map(|side| side.map(R::from_f64)).collect(),
            mask: self.mask.clone(),
        }
    }
}

impl Masked {
    /// True at the points that are open. One lane after the other, in f64: a lookup gains nothing from lanes, and so comes out alike in
    /// all.
    #[cold]
    fn are_open<L: Lane>(&self, x_mm: L, y_mm: L) -> L::Mask {
        let mut is_open = [L::Real::ZERO; WIDEST_LANE];
        for (i, is_open) in is_open.iter_mut().enumerate().take(L::WIDTH) {
            let [x, y] = [x_mm, y_mm].map(|x| x.of(i).to_f64() / self.radius_mm);
            if self.shape.is_open(self.cos * x + self.sin * y, self.cos * y - self.sin * x) {
                *is_open = L::Real::ONE;
            }
        }
        x_mm.like(L::Real::ONE).at_most(x_mm.load(&is_open[..L::WIDTH]))
    }
}

impl<R: Real> Diaphragm<R> {
    /// True if the point (x, y) in mm lies in the opening; its rim counts as open.
    pub fn is_open(&self, x_mm: R, y_mm: R) -> bool {
        self.are_open::<R>(x_mm, y_mm)
    }

    /// True where the points (x, y) in mm lie in the opening; its rim counts as open.
    #[inline(always)]
    pub fn are_open<L: Lane<Real = R>>(&self, x_mm: L, y_mm: L) -> L::Mask {
        let squared = x_mm * x_mm + y_mm * y_mm;
        let within = |radius: R| squared.at_most(squared.like(radius * radius));
        let mut is_open = within(self.radius_mm);
        if let Some(mask) = &self.mask {
            return is_open & mask.are_open(x_mm, y_mm);
        }
        if !self.sides.is_empty() && !within(self.apothem_mm).all() {
            if self.curvature == 0.0 {
                for [nx, ny] in &self.sides {
                    is_open = is_open & (x_mm * *nx + y_mm * *ny).at_most(squared.like(self.apothem_mm));
                }
                return is_open;
            }
            // Inside of the disc of each arc, its equation divided by the distance s from its centre to its chord: with
            // b = 1 / 2s, a the apothem, R the stop's radius and w the way towards the side,
            // b (x² + y²) + (1 - 2ab) w <= a + b (R² - 2a²). Every term stays small as the arc straightens.
            let (a, b) = (self.apothem_mm, self.bulge);
            let slope = R::from_f64(1.0) - (a + a) * b;
            let bound = squared.like(a + b * (self.radius_mm * self.radius_mm - (a + a) * a));
            let bulged = squared * b;
            for [nx, ny] in &self.sides {
                is_open = is_open & (bulged + (x_mm * *nx + y_mm * *ny) * slope).at_most(bound);
            }
        }
        is_open
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    #[test]
    fn corners_touch_the_circle_and_sides_cut_it() {
        let six = Diaphragm::polygon(2.0, 6, 0.0);
        assert!(six.is_open(1.999_999, 0.0));
        assert!(!six.is_open(1.9, 1.9 * 0.5));
        assert!(six.is_open(0.0, 1.732));
        assert!(!six.is_open(0.0, 1.733));
    }

    #[test]
    fn the_rim_of_a_round_opening_is_open() {
        assert!(Diaphragm::round(5.0).is_open(3.0, 4.0));
        assert!(!Diaphragm::round(5.0).is_open(3.0, 4.000_001));
        assert_eq!(Diaphragm::polygon(1.0, 2, 0.3).blades(), 0);
    }

    #[test]
    fn samples_lie_in_the_opening_and_fill_it() {
        for shape in [Diaphragm::round(2.0), Diaphragm::polygon(2.0, 5, 0.4)] {
            let n = 200;
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
            let (mut sum, mut squares) = ([0.0; 2], 0.0);
            for i in 0..n * n {
                let [x, y] = shape.sample([at(i % n), at(i / n)]);
                assert!(shape.is_open(x * (1.0 - 1e-12), y * (1.0 - 1e-12)));
                sum = [sum[0] + x, sum[1] + y];
                squares += x * x + y * y;
            }
            // The middle is the middle; the mean square is that of a disc, or of a polygon:
            // (3 apothem^2 + half side^2) / 6.
            let count = f64::from(n * n);
            let half_side = (4.0 - shape.apothem_mm * shape.apothem_mm).sqrt();
            let expected = match shape.blades() {
                0 => 2.0,
                _ => 0.5 * (shape.apothem_mm * shape.apothem_mm + half_side * half_side / 3.0),
            };
            assert!(sum.iter().all(|s| (s / count).abs() < 1e-3) && (squares / count - expected).abs() < 1e-3);
        }
        assert!((Diaphragm::polygon(1.0, 4, 0.1).area_mm2() - 2.0).abs() < 1e-14);
    }

    #[test]
    fn curved_blades_lie_between_the_polygon_and_the_circle() {
        // Five blades of radius 2: on the middle of a side the arc bulges by its sagitta r - sqrt(r² - h²).
        let shape = Diaphragm::bladed(2.0, 5, 0.6, 0.0);
        let half = 0.1 * TAU;
        let (r, h) = (2.0 / 0.6, 2.0 * half.sin());
        let reach = 2.0 * half.cos() + r - (r * r - h * h).sqrt();
        let at = |out: f64| shape.is_open(out * half.cos(), out * half.sin());
        assert!(at(reach - 1e-9) && !at(reach + 1e-9));
        assert!(shape.is_open(2.0 - 1e-9, 0.0) && !shape.is_open(2.0 + 1e-9, 0.0));
        assert_eq!(Diaphragm::bladed(2.0, 5, 1.0, 0.3), Diaphragm::round(2.0));
        assert_eq!(Diaphragm::bladed(2.0, 5, 0.0, 0.3), Diaphragm::polygon(2.0, 5, 0.3));
        // Nearly straight and nearly round agree with what they tend to: the area's slope in the curvature is below R².
        let area = |curvature| Diaphragm::bladed(1.0, 5, curvature, 0.0).area_mm2();
        assert!((area(2e-6) - area(0.0)).abs() < 2e-6 && (area(1.0 - 1e-9) - 0.5 * TAU).abs() < 1e-8);
    }

    #[test]
    fn samples_of_curved_blades_are_even() {
        // The area by counting a grid (400² points, its error below 0.5 %), and the second moment by both.
        for (blades, curvature) in [(3, 0.9), (6, 0.5), (24, 0.2)] {
            let shape = Diaphragm::bladed(1.0, blades, curvature, 0.37);
            let n = 400;
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
            let (mut count, mut counted, mut sampled) = (0.0, 0.0, 0.0);
            for i in 0..n * n {
                let (x, y) = (2.0 * at(i % n) - 1.0, 2.0 * at(i / n) - 1.0);
                if shape.is_open(x, y) {
                    count += 1.0;
                    counted += x * x + y * y;
                }
                let [x, y] = shape.sample([at(i % n), at(i / n)]);
                assert!(shape.is_open(x * (1.0 - 1e-9), y * (1.0 - 1e-9)));
                sampled += x * x + y * y;
            }
            let all = f64::from(n * n);
            assert!((4.0 * count / all / shape.area_mm2() - 1.0).abs() < 5e-3);
            assert!((sampled / all - counted / count).abs() < 2e-3);
        }
    }

    /// Points of samples fill every shape of opening evenly.
    #[test]
    fn openings_are_filled_evenly() {
        let side = 32;
        let ring = (0..side * side).map(|i| {
            let [x, y] = [i % side, i / side].map(|k| (2 * k + 1) as f32 / side as f32 - 1.0);
            if (0.4..0.9).contains(&x.hypot(y)) { 1.0 } else { 0.0 }
        });
        let ring = ApertureMask::new(side, &ring.collect::<Vec<f32>>()).unwrap();
        for (name, shape) in [
            ("round opening", Diaphragm::round(1.0)),
            ("polygon", Diaphragm::polygon(1.0, 5, 0.4)),
            ("curved blades", Diaphragm::bladed(1.0, 7, 0.6, 0.2)),
            ("mask", Diaphragm::masked(1.0, ring.into(), 0.3)),
        ] {
            sampling::places(
                name,
                1 << 16,
                [[-1.0, 1.0]; 2],
                |random| Some(shape.sample([random.number(), random.number()]).map(|x| x as f32)),
                |[x, y]| if shape.is_open(x.into(), y.into()) { 1.0 / shape.area_mm2() } else { 0.0 },
            );
        }
    }

    #[test]
    fn a_turned_polygon_keeps_its_area() {
        let n = 400;
        for blades in [3, 5, 8] {
            for rotation in [0.0, 0.37] {
                let shape = Diaphragm::polygon(1.0, blades, rotation);
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
                let open = (0..n * n).filter(|i| shape.is_open(at(i % n), at(i / n))).count();
                let area = 4.0 * open as f64 / f64::from(n * n);
                let exact = 0.5 * f64::from(blades) * (TAU / f64::from(blades)).sin();
                assert!((area - exact).abs() < 5e-3, "{blades}: {area} {exact}");
            }
        }
    }
}

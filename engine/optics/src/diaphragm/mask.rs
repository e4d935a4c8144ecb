//! An opening of any shape, given as a square grey picture.

use std::fmt;

use serde::de::Visitor;
use serde::{Deserialize, Deserializer};
use thiserror::Error;

/// The widest picture, in values a side.
const WIDEST: usize = 8192;
/// Openings below this part of the picture count as closed.
const LEAST_PART: f64 = 1e-6;
/// Points a side at which a cell on the rim is tried for its area.
const TRIES: usize = 8;
/// Number of times, at most, that a sample on a closed part is drawn again.
const MOST_DRAWS: u32 = 1000;

/// An error by which a picture makes no diaphragm.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MaskError {
    /// No square, or a very large one.
    #[error("the aperture mask of {values} values is no square of {side} a side; give 1 to {WIDEST} values a side")]
    NotSquare {
        /// Number of values along a side.
        side: usize,
        /// Number of values in all.
        values: usize,
    },
    /// A value is no brightness.
    #[error("the aperture mask holds a value that is not finite; give numbers from 0 to 1")]
    NotFinite,
    /// No value is brighter than half.
    #[error("the aperture mask is dark; light passes where it is brighter than half")]
    Dark,
}

/// A square grey picture whose width spans the diameter of the stop. Between the middles of its values it is
/// interpolated bilinearly; light passes where it is brighter than half, and within the circle of the stop.
#[derive(Clone, PartialEq, Deserialize)]
#[serde(try_from = "GreyPicture")]
pub struct ApertureMask {
    side: usize,
    /// Brightness less a half, rows from below.
    values: Vec<f32>,
    /// Cells between the middles of values that may be open: up to which of `cells` those of each row reach, and their
    /// columns. A cell reaches from one value's middle to the next, the first and last past the picture's edge.
    row_ends: Vec<u32>,
    cells: Vec<u32>,
    open_part: f64,
    /// A point of the opening, in radii of the stop: that of samples which none of many draws hits.
    open_point: [f64; 2],
}

/// A square grey picture of eight bits a value, rows from below, as a user's settings have it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GreyPicture {
    /// Name of the picture, for messages.
    name: String,
    side: usize,
    #[serde(deserialize_with = "bytes")]
    values: Vec<u8>,
}

impl TryFrom<GreyPicture> for ApertureMask {
    type Error = String;

    fn try_from(picture: GreyPicture) -> Result<Self, String> {
        let values: Vec<f32> = picture.values.iter().map(|&value| f32::from(value) / 255.0).collect();
        Self::new(picture.side, &values).map_err(|error| format!("image '{}': {error}", picture.name))
    }
}

/// A field of bytes; serde takes a `Vec<u8>` for a sequence of numbers.
fn bytes<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<u8>, D::Error> {
    struct Bytes;
    impl Visitor<'_> for Bytes {
        type Value = Vec<u8>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("bytes")
        }

        fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Vec<u8>, E> {
            Ok(bytes.to_vec())
        }
    }
    from.deserialize_bytes(Bytes)
}

impl fmt::Debug for ApertureMask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ApertureMask").field("side", &self.side).field("open_part", &self.open_part).finish()
    }
}

impl ApertureMask {
    /// The mask of `side` times `side` values from 0 (closed) to 1 (open), rows from below, each from left to right as
    /// seen from behind the film.
    pub fn new(side: usize, values: &[f32]) -> Result<Self, MaskError> {
        if !(1..=WIDEST).contains(&side) || values.len() != side * side {
            return Err(MaskError::NotSquare { side, values: values.len() });
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(MaskError::NotFinite);
        }
        let values = values.iter().map(|value| value - 0.5).collect();
        let row_ends = Vec::with_capacity(side + 1);
        let mut mask = Self { side, values, row_ends, cells: Vec::new(), open_part: 0.0, open_point: [f64::NAN; 2] };
        for row in 0..=side {
            for column in 0..=side {
                let open = mask.open_part_of_cell(column, row);
                // A cell that is open between the points tried is kept as well: its samples are drawn exactly.
                if let Some(open) = open {
                    mask.cells.push(column as u32);
                    mask.open_part += open;
                    if open > 0.0 && mask.open_point[0].is_nan() {
                        let point = mask.open_tries([column, row]).next();
                        mask.open_point = point.unwrap_or(mask.open_point);
                    }
                }
            }
            mask.row_ends.push(mask.cells.len() as u32);
        }
        mask.open_part /= (side * side) as f64;
        if mask.open_part < LEAST_PART { Err(MaskError::Dark) } else { Ok(mask) }
    }

    /// Number of values along a side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// The picture's brightness less a half, rows from below.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The open part of the square, within a hundredth of the area of the cells on its rim.
    pub(super) fn open_part(&self) -> f64 {
        self.open_part
    }

    fn value(&self, column: usize, row: usize) -> f64 {
        f64::from(self.values[row * self.side + column])
    }

    /// The open part of a cell; `None` if it cannot be open.
    fn open_part_of_cell(&self, column: usize, row: usize) -> Option<f64> {
        let last = self.side - 1;
        let ends = |cell: usize| [cell.saturating_sub(1), cell.min(last)];
        let corners = ends(row).map(|row| ends(column).map(|column| self.value(column, row)));
        // A bilinear function is largest and smallest at corners.
        if corners.iter().flatten().all(|&value| value <= 0.0) {
            return None;
        }
        // The cell's sides in radii of the stop, from its nearest to its farthest corner.
        let sides = [column, row].map(|cell| [-0.5, 0.5].map(|s| 2.0 * (cell as f64 + s) / self.side as f64 - 1.0));
        let nearest = sides.map(|[low, high]| 0f64.clamp(low, high));
        let farthest = sides.map(|[low, high]| low.abs().max(high.abs()));
        if nearest[0].hypot(nearest[1]) >= 1.0 {
            return None;
        }
        // Nearly all cells of a picture lie wholly in the opening.
        if farthest[0].hypot(farthest[1]) < 1.0 && corners.iter().flatten().all(|&value| value > 0.0) {
            return Some(1.0);
        }
        Some(self.open_tries([column, row]).count() as f64 / (TRIES * TRIES) as f64)
    }

    /// The points of a cell that are tried and open, in radii of the stop.
    fn open_tries(&self, cell: [usize; 2]) -> impl Iterator<Item = [f64; 2]> + '_ {
        let at = move |i: usize, j: usize| self.place(cell, [i, j].map(|i| (i as f64 + 0.5) / TRIES as f64));
        let tries = (0..TRIES * TRIES).map(move |i| at(i % TRIES, i / TRIES));
        tries.filter(|&[x, y]| x * x + y * y <= 1.0 && self.is_open(x, y))
    }

    /// The point of a cell at `within` (0 to 1) in radii of the stop.
    fn place(&self, cell: [usize; 2], within: [f64; 2]) -> [f64; 2] {
        let at = |i: usize| 2.0 * (cell[i] as f64 - 0.5 + within[i]) / self.side as f64 - 1.0;
        [at(0), at(1)]
    }

    /// True if the point, in radii of the stop, is brighter than half; points outside of the picture are as its edge.
    pub(super) fn is_open(&self, x: f64, y: f64) -> bool {
        let last = (self.side - 1) as f64;
        let locate = |x: f64| {
            let place = (0.5 * (x + 1.0) * self.side as f64 - 0.5).clamp(0.0, last);
            // A cast takes NaN to 0.
            let cell = place as usize;
            (cell, (cell + 1).min(self.side - 1), place - cell as f64)
        };
        let ((left, right, u), (below, above, v)) = (locate(x), locate(y));
        let along = |row: usize| self.value(left, row) * (1.0 - u) + self.value(right, row) * u;
        along(below) * (1.0 - v) + along(above) * v > 0.0
    }

    /// A point of the opening in radii of the stop, evenly, by two numbers in [0, 1).
    ///
    /// A cell that may be open and a point of it; one that is closed is drawn again by numbers made from the first,
    /// which leaves the others as even as they were.
    pub(super) fn sample(&self, u: [f64; 2]) -> [f64; 2] {
        let mut numbers = u;
        for draw in 1..=MOST_DRAWS {
            let [x, y] = self.candidate(numbers);
            if x * x + y * y <= 1.0 && self.is_open(x, y) {
                return [x, y];
            }
            numbers = [0u8, 1].map(|axis| again(u, draw, axis));
        }
        self.open_point
    }

    fn candidate(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let place = v * self.cells.len() as f64;
        let row = self.row_ends.partition_point(|&end| f64::from(end) <= place).min(self.side);
        let start = if row == 0 { 0 } else { self.row_ends[row - 1] };
        let count = f64::from(self.row_ends[row] - start);
        let across = (place - f64::from(start)) / count;
        let along = u * count;
        let column = self.cells[start as usize + along as usize];
        self.place([column as usize, row], [along.fract(), across])
    }
}

/// A number in [0, 1) that looks unlike `u`, the same on every machine: the bits are mixed after each number that goes
/// in (Steele, Lea and Flood 2014, the finalizer of SplitMix64).
fn again(u: [f64; 2], draw: u32, axis: u8) -> f64 {
    let mut state = 0u64;
    for number in [u[0].to_bits(), u[1].to_bits(), u64::from(draw), u64::from(axis)] {
        state = (state ^ number).wrapping_add(0x9E37_79B9_7F4A_7C15);
        state = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        state ^= state >> 31;
    }
    (state >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of a function of the point in radii.
    fn picture(side: usize, value: impl Fn(f64, f64) -> f32) -> Vec<f32> {
        let at = |i: usize| (2.0 * i as f64 + 1.0) / side as f64 - 1.0;
        (0..side * side).map(|i| value(at(i % side), at(i / side))).collect()
    }

    /// Samples of an opening that is a tiny part of its cells lie in it.
    #[test]
    fn tiny_openings_are_sampled() {
        // In the middle of four values one is a little brighter than a half, the others are dark: the opening is a corner's tip.
        for bright in [0.5004, 0.51, 0.6] {
            let values = picture(8, |x, y| if x > 0.0 && x < 0.2 && y > 0.0 && y < 0.2 { bright } else { 0.0 });
            let Ok(mask) = ApertureMask::new(8, &values) else { continue };
            for i in 0..200 {
                let [x, y] = mask.sample([f64::from(i) / 200.0, f64::from(i * 7 % 200) / 200.0]);
                assert!(x * x + y * y <= 1.0 && mask.is_open(x, y), "{bright}: {x} {y}");
            }
        }
    }

    #[test]
    fn between_the_middles_of_values_it_is_bilinear() {
        // The middles lie at -0.5 and 0.5: bright on the right and above.
        let mask = ApertureMask::new(2, &[0.0, 0.6, 0.2, 1.0]).unwrap();
        // Below, 0.6 of the way from 0: half at 0.833 of the way; above, half at 0.375.
        for (x, y) in [(-0.5 + 0.5 / 0.6, -0.5), (-0.5 + 0.3 / 0.8, 0.5)] {
            assert!(mask.is_open(x + 1e-6, y) && !mask.is_open(x - 1e-6, y), "{x} {y}");
        }
        // In the middle 0.45; past the outer middles as there.
        assert!(!mask.is_open(0.0, 0.0) && mask.is_open(0.99, -0.99) && !mask.is_open(-0.99, 0.99));
    }

    /// A large white mask takes time in proportion to its values, not 64 times that.
    #[test]
    fn a_white_mask_is_the_round_opening() {
        let mask = ApertureMask::new(1024, &vec![1.0; 1024 * 1024]).unwrap();
        let circle = std::f64::consts::FRAC_PI_4;
        assert!((mask.open_part() / circle - 1.0).abs() < 1e-5, "{}", mask.open_part());
        // Cells that lie wholly in the opening are not tried, but come to what tries would give.
        let half = ApertureMask::new(64, &picture(64, |x, _| f32::from(u8::from(x > 0.0)))).unwrap();
        let inside = half.open_part_of_cell(50, 32);
        assert_eq!((inside, half.open_part_of_cell(10, 32), half.open_part_of_cell(0, 0)), (Some(1.0), None, None));
    }

    #[test]
    fn a_ramp_opens_the_half_disc_beyond_its_middle() {
        // Value (x + 1) / 2 - 0.1 is half at x = 0.2, exactly, since it is linear.
        let mask = ApertureMask::new(64, &picture(64, |x, _| (0.5 * (x + 1.0) - 0.1) as f32)).unwrap();
        let segment = 0.2f64.acos() - 0.2 * (1.0f64 - 0.04).sqrt();
        // 8 x 8 points in each of some 100 cells on the rim of 2000: an error below a thousandth.
        assert!((4.0 * mask.open_part() / segment - 1.0).abs() < 2e-3, "{}", mask.open_part());
        let n = 400;
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        let (mut sum, mut squares) = ([0.0; 2], 0.0);
        for i in 0..n * n {
            let [x, y] = mask.sample([at(i % n), at(i / n)]);
            assert!(x > 0.2 - 1e-6 && x.hypot(y) <= 1.0);
            sum = [sum[0] + x, sum[1] + y];
            squares += y * y;
        }
        // Centroid and second moment of a circle's segment by one-dimensional integrals.
        let m = 100_000;
        let integral = |f: &dyn Fn(f64) -> f64| {
            (0..m).map(|i| f(0.2 + 0.8 * (f64::from(i) + 0.5) / f64::from(m))).sum::<f64>() * 0.8 / f64::from(m)
        };
        let half = |x: f64| (1.0 - x * x).sqrt();
        let x_mean = integral(&|x| 2.0 * x * half(x)) / segment;
        let y_square = integral(&|x| 2.0 / 3.0 * half(x).powi(3)) / segment;
        let count = (n * n) as f64;
        // Of 160 000 points of an even grid some 15 000 are drawn again at random, with a spread of a half: they move the
        // means by 15 000^0.5 / 160 000 / 2 = 4e-4; four times that.
        let found = [sum[0] / count - x_mean, sum[1] / count, squares / count - y_square];
        assert!(found.iter().all(|difference| difference.abs() < 1.6e-3), "{found:?}");
    }

    #[test]
    fn what_makes_no_opening_is_refused() {
        assert_eq!(ApertureMask::new(2, &[1.0; 3]), Err(MaskError::NotSquare { side: 2, values: 3 }));
        assert_eq!(ApertureMask::new(0, &[]), Err(MaskError::NotSquare { side: 0, values: 0 }));
        assert_eq!(ApertureMask::new(1, &[f32::NAN]), Err(MaskError::NotFinite));
        // Half is not brighter than half.
        assert_eq!(ApertureMask::new(2, &[0.5; 4]), Err(MaskError::Dark));
        // Only the picture's corners are bright: they lie outside of the circle.
        assert_eq!(
            ApertureMask::new(99, &picture(99, |x, y| f32::from(u8::from(x.abs() + y.abs() > 1.8)))),
            Err(MaskError::Dark)
        );
        assert!(ApertureMask::new(1, &[1.0]).is_ok());
    }
}

//! Overlap of a pupil with itself when it is shifted, for any direction and length of the shift.
//!
//! Lines in the direction of the shift cut the pupil into intervals; the overlap of two intervals is piecewise linear in the shift, so
//! the sum over all lines is exact where the pupil's edges are straight between them. Lines lie between all corners: the kinks that
//! straight edges make, from which their spikes come, are there without blur. The kept value is (1 − overlap) / shift: it has a
//! limit for small shifts, the pupil's breadth across the direction over its area.

use std::f64::consts::PI;

use glam::DVec2;

use super::outline::Outline;

/// Strips across the pupil, at least.
const STRIPS: usize = 768;
/// Largest number of corners that are all ends of strips: if there are more, only those where the edge turns, or turns back, are.
const MANY: usize = 400;
/// The turn of the edge at a corner, sine.
const TURN: f64 = 0.03;
/// Places of lines in a strip (Gauss).
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Lengths of a shift in direction cosines, evenly in their logarithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shifts {
    /// The smallest length.
    pub first: f64,
    /// Number of lengths to each doubling.
    pub per_octave: f64,
    /// Number of lengths in all.
    pub count: usize,
}

impl Shifts {
    /// Length number `i`, counted from 0.
    pub fn at(&self, i: usize) -> f64 {
        self.first * (i as f64 / self.per_octave).exp2()
    }

    /// The first that is not smaller.
    fn above(&self, shift: f64) -> usize {
        ((shift / self.first).log2() * self.per_octave).ceil().clamp(0.0, self.count as f64) as usize
    }
}

/// An edge that a line in the direction of the shift can cross: across and along the direction.
struct CrossedEdge {
    low: DVec2,
    high: DVec2,
}

/// (1 − overlap) / shift for each shift, per direction cosine, in direction `number` of `count` over half a turn from the first of the
/// outline's directions on; the overlap is 1 for the shift 0.
pub fn loss_per_shift(outline: &Outline, [number, count]: [usize; 2], shifts: &Shifts) -> Vec<f32> {
    let along = DVec2::from_angle(PI * number as f64 / count as f64);
    // (across, along) the direction.
    let turned = |corner: &DVec2| DVec2::new(along.perp_dot(*corner), along.dot(*corner));
    let mut edges = Vec::new();
    let mut ends = Vec::new();
    let corners: usize = outline.polygons.iter().map(Vec::len).sum();
    for polygon in &outline.polygons {
        let turned: Vec<DVec2> = polygon.iter().map(turned).collect();
        let n = turned.len();
        for i in 0..n {
            let (before, here, after) = (turned[(i + n - 1) % n], turned[i], turned[(i + 1) % n]);
            let turn = (here - before).normalize_or_zero().perp_dot((after - here).normalize_or_zero());
            // Where the edge turns back, intervals begin and end.
            let turns_back = (here.x - before.x) * (after.x - here.x) <= 0.0;
            if corners <= MANY || turns_back || turn.abs() > TURN {
                ends.push(here.x);
            }
            let (low, high) = if here.x < after.x { (here, after) } else { (after, here) };
            if low.x < high.x {
                edges.push(CrossedEdge { low, high });
            }
        }
    }
    let span = edges.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], e| [a.min(e.low.x), b.max(e.high.x)]);
    // Thinner towards the ends, where a round edge turns away.
    let part = |i: usize| 0.5 - 0.5 * (PI * i as f64 / STRIPS as f64).cos();
    ends.extend((0..=STRIPS).map(|i| span[0] + (span[1] - span[0]) * part(i)));
    ends.sort_by(f64::total_cmp);
    edges.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));

    let mut sum = Ramps::new(shifts);
    let (mut waiting, mut active): (usize, Vec<usize>) = (0, Vec::new());
    let mut cuts: Vec<f64> = Vec::new();
    for strip in ends.windows(2) {
        let width = strip[1] - strip[0];
        if width <= 0.0 {
            continue;
        }
        for part in GAUSS {
            let line = strip[0] + width * part;
            while waiting < edges.len() && edges[waiting].low.x <= line {
                active.push(waiting);
                waiting += 1;
            }
            active.retain(|&i| edges[i].high.x > line);
            cuts.clear();
            cuts.extend(active.iter().map(|&i| {
                let CrossedEdge { low, high } = &edges[i];
                low.y + (high.y - low.y) * ((line - low.x) / (high.x - low.x))
            }));
            cuts.sort_by(f64::total_cmp);
            sum.add(&cuts, 0.5 * width);
        }
    }
    sum.loss_per_shift()
}

/// A sum of ramps max(0, s − b) for shifts s.
struct Ramps<'a> {
    shifts: &'a Shifts,
    /// The area of the overlap at shift 0.
    area: f64,
    /// The loss of the overlap: slope and constant of ramps that begin before each shift, and after the one before.
    steps: Vec<[f64; 2]>,
}

impl<'a> Ramps<'a> {
    fn new(shifts: &'a Shifts) -> Self {
        Self { shifts, area: 0.0, steps: vec![[0.0; 2]; shifts.count + 1] }
    }

    fn ramp(&mut self, begin: f64, slope: f64) {
        let i = if begin <= 0.0 { 0 } else { self.shifts.above(begin) };
        self.steps[i][0] += slope;
        self.steps[i][1] -= slope * begin;
    }

    /// The intervals of a line that stands for a width.
    fn add(&mut self, cuts: &[f64], width: f64) {
        for one in cuts.chunks_exact(2) {
            let length = one[1] - one[0];
            self.area += width * length;
            // With itself: what is lost grows with the shift until all is.
            self.ramp(0.0, width);
            self.ramp(length, -width);
        }
        // One interval shifted onto a later one: what is gained again.
        for (i, one) in cuts.chunks_exact(2).enumerate() {
            for other in cuts.chunks_exact(2).skip(i + 1) {
                self.ramp(other[0] - one[1], -width);
                self.ramp(other[0] - one[0], width);
                self.ramp(other[1] - one[1], width);
                self.ramp(other[1] - one[0], -width);
            }
        }
    }

    fn loss_per_shift(&self) -> Vec<f32> {
        let mut line = [0.0; 2];
        let each = (0..self.shifts.count).map(|i| {
            line = [line[0] + self.steps[i][0], line[1] + self.steps[i][1]];
            let shift = self.shifts.at(i);
            ((line[0] + line[1] / shift) / self.area.max(f64::MIN_POSITIVE)) as f32
        });
        each.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHIFTS: Shifts = Shifts { first: 1e-5, per_octave: 8.0, count: 160 };

    fn of(polygons: Vec<Vec<DVec2>>, angle: f64) -> Vec<f64> {
        let count = 36_000;
        let number = (angle / PI * f64::from(count)).round() as usize;
        loss_per_shift(&Outline { polygons }, [number, count as usize], &SHIFTS).iter().map(|&x| f64::from(x)).collect()
    }

    fn overlap(loss: &[f64], i: usize) -> f64 {
        1.0 - loss[i] * SHIFTS.at(i)
    }

    /// A square of side 1: (1 − |s cos|) (1 − |s sin|).
    #[test]
    fn a_square_overlaps_as_a_product() {
        let square = Outline::regular(0.5f64.sqrt(), 4, PI / 4.0);
        for angle in [0.0, 0.001 * PI, 0.3 * PI, 0.5 * PI, 0.9 * PI] {
            let loss = of(vec![square.clone()], angle);
            for i in 0..SHIFTS.count {
                let s = SHIFTS.at(i);
                let [x, y] = [s * angle.cos(), s * angle.sin()].map(|x| (1.0 - x.abs()).max(0.0));
                // Two lines stand for the strip of a corner, where the overlap is no straight line.
                assert!((overlap(&loss, i) - x * y).abs() < 2e-5, "{angle} {s}: {} {}", overlap(&loss, i), x * y);
            }
        }
    }

    /// A disc: 2/π (acos ν − ν √(1 − ν²)); its small shifts lose 4 / π of the shift over the diameter.
    #[test]
    fn a_disc_overlaps_as_a_lens() {
        let loss = of(vec![Outline::regular(0.5, 2000, 0.0)], 0.7);
        for i in 0..SHIFTS.count {
            let nu = SHIFTS.at(i);
            let truth = if nu < 1.0 { 2.0 / PI * (nu.acos() - nu * (1.0 - nu * nu).sqrt()) } else { 0.0 };
            assert!((overlap(&loss, i) - truth).abs() < 5e-5, "{nu}: {} {truth}", overlap(&loss, i));
        }
        assert!((loss[0] * PI / 4.0 - 1.0).abs() < 1e-4, "{}", loss[0]);
    }

    /// The overlap of a pupil with a hole (a frame): that of both squares, less that of one with the other, twice.
    #[test]
    fn a_hole_is_taken_off() {
        let ring =
            vec![Outline::regular(0.5f64.sqrt(), 4, PI / 4.0), Outline::regular(0.25 * 2f64.sqrt(), 4, PI / 4.0)];
        let loss = of(ring, 0.0);
        for i in 0..SHIFTS.count {
            let s = SHIFTS.at(i);
            let with = |a: f64, b: f64| (0.5 * (a + b) - s).clamp(0.0, a.min(b));
            let truth = with(1.0, 1.0) - 2.0 * 0.5 * with(1.0, 0.5) + 0.5 * with(0.5, 0.5);
            // Both shifts of the hole against the square, to the left and to the right, are alike.
            assert!((overlap(&loss, i) - truth / 0.75).abs() < 3e-6, "{s}: {} {}", overlap(&loss, i), truth / 0.75);
        }
    }
}

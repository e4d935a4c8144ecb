//! A column of rays: all parts of the way to the disc's rim over a floor, cut where their fate changes.
//!
//! Rays found in f64 say where to cut; nothing rests on them. A cut is a polynomial of second degree over the floor, so that the thin
//! layer between passing and stopped rays is as thin as the third derivatives of their border, not as the floor is wide.

use crate::chart::{Centre, Chart, Floor};
use crate::passage::{Beam, Fate, Indices, pass};
use crate::table::{COUNTS, MONOMIALS, VARIABLES};
use crate::taylor::Taylor;
use petzval_optics::trace::{Step, Tracer};

/// Coefficients of the models of cells: of third order. Fewer make smaller floors, more take longer for each.
pub(super) const CELL: usize = COUNTS[3];

/// Number of coefficients of a cut.
pub const CUT_TERMS: usize = 10;

/// The powers of the floor's three numbers in the terms of a cut: 1, the three, the products of two.
pub const CUT_POWERS: [[u8; VARIABLES]; CUT_TERMS] = [
    [0, 0, 0, 0],
    [1, 0, 0, 0],
    [0, 1, 0, 0],
    [0, 0, 1, 0],
    [2, 0, 0, 0],
    [1, 1, 0, 0],
    [1, 0, 1, 0],
    [0, 2, 0, 0],
    [0, 1, 1, 0],
    [0, 0, 2, 0],
];

/// A surface over a floor: coefficients by [`CUT_POWERS`] of ε in −1 to 1.
pub type Cut = [f64; CUT_TERMS];

/// Places along the way to the rim at which a ray is tried first. More find smaller openings.
const TRIALS: usize = 33;
/// Halvings between two trials.
const HALVINGS: usize = 26;
/// A layer about a fitted border is this much wider than the worst miss of the fit, and wider by [`LEAST_LAYER`].
const LAYER: f64 = 1.5;
const LEAST_LAYER: f64 = 2e-6;
/// Halvings of a zone, at most.
const DEEPEST: usize = 14;
/// Halvings of a layer, at most.
const DEEPEST_LAYER: usize = 3;

/// Thinnest pieces of a floor over which the fate changes unevenly, as part of the way.
const COARSE: f64 = 1.0 / 24.0;

/// Cuts in a row that decide nothing, at most.
const STRIKES: usize = 2;

/// The rays of a column between two parts of the way.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// The cell lies between cut `zone` and the next, from the fraction `from` of the way between them to the fraction `to`.
    pub zone: usize,
    /// Lower fraction.
    pub from: f64,
    /// Upper fraction.
    pub to: f64,
    /// The proved fate.
    pub fate: Fate,
}

/// A column with the proved fates of its cells.
#[derive(Clone, Debug)]
pub struct Column {
    /// Index of the centre from which the way to the rim is counted.
    pub slab: usize,
    /// The floor.
    pub floor: Floor,
    /// Cuts by rising part of the way, from 0 to 1; they do not touch.
    pub cuts: Vec<Cut>,
    /// The cells by rising part of the way, without a gap.
    pub cells: Vec<Cell>,
    /// Volume of the cells that are undecided, mm⁴ nm.
    pub undecided: f64,
    /// The dimension of the floor across which halves of it would leave less undecided.
    pub(super) split: usize,
}

/// The lens as proofs see it at the wavelengths of a floor.
pub(super) struct View<'a> {
    pub(super) chart: &'a Chart,
    pub(super) steps: &'a [Step],
    pub(super) opening_mm: f64,
    pub(super) indices: &'a [Option<Indices<CELL>>],
    /// Tracers for the shortest, the middle and the longest wavelength of the floor.
    pub(super) tracers: [&'a Tracer; 3],
    /// Layers thinner than this part of the way are not cut again.
    pub(super) thinnest: f64,
}

/// The value of a cut at ε.
pub fn cut_value(cut: &Cut, [a, b, c]: [f64; 3]) -> f64 {
    let monomials = [1.0, a, b, c, a * a, a * b, a * c, b * b, b * c, c * c];
    cut.iter().zip(monomials).map(|(x, y)| x * y).sum()
}

fn model(cut: &Cut) -> Taylor<CELL> {
    Taylor::polynomial(CUT_POWERS.iter().zip(cut.iter().copied()))
}

const fn flat(value: f64) -> Cut {
    let mut cut = [0.0; CUT_TERMS];
    cut[0] = value;
    cut
}

/// The parts at which the fate changes, at each of the 27 nodes of a floor.
struct Nodes {
    changes: Vec<Vec<f64>>,
}

/// ε of node `i`.
fn node(i: usize) -> [f64; 3] {
    [i % 3, i / 3 % 3, i / 9].map(|k| k as f64 - 1.0)
}

impl Nodes {
    fn new(view: &View<'_>, centre: Centre, floor: &Floor) -> Self {
        let changes_at = |i: usize| {
            let [r, u, _] = floor.at(node(i));
            let passes = |s: f64| view.tracers[i / 9].from_film(view.chart.ray(centre, r, u, s)).is_ok();
            let mut found = Vec::new();
            let mut before = (0.0, passes(0.0));
            for trial in 1..=TRIALS {
                let s = trial as f64 / TRIALS as f64;
                let now = passes(s);
                if now != before.1 {
                    let (mut low, mut high) = (before.0, s);
                    for _ in 0..HALVINGS {
                        let middle = 0.5 * (low + high);
                        if passes(middle) == before.1 { low = middle } else { high = middle }
                    }
                    found.push(0.5 * (low + high));
                }
                before = (s, now);
            }
            found
        };
        Self { changes: (0..27).map(changes_at).collect() }
    }

    /// Number of changes, if it is the same at all nodes.
    fn count(&self) -> Option<usize> {
        let count = self.changes[0].len();
        self.changes.iter().all(|all| all.len() == count).then_some(count)
    }

    /// The cut that fits the `k`-th change best, and its worst miss.
    fn fit(&self, k: usize) -> (Cut, f64) {
        let value = |i: usize| self.changes[i][k];
        let sum = |weight: &dyn Fn([f64; 3]) -> f64| (0..27).map(|i| weight(node(i)) * value(i)).sum::<f64>();
        let mut cut = flat(0.0);
        // Least squares: on three levels 1, ε, ε² − 2/3 and the products of two ε are orthogonal.
        for (term, powers) in cut.iter_mut().zip(&CUT_POWERS).skip(1) {
            let power = |e: [f64; 3], i: usize| e[i].powi(i32::from(powers[i]));
            let is_square = powers.contains(&2);
            let is_product = !is_square && powers.iter().sum::<u8>() == 2;
            let monomial = |e: [f64; 3]| power(e, 0) * power(e, 1) * power(e, 2);
            *term = match (is_square, is_product) {
                (true, _) => sum(&|e| monomial(e) - 2.0 / 3.0) / 6.0,
                (_, true) => sum(&monomial) / 12.0,
                _ => sum(&monomial) / 18.0,
            };
        }
        cut[0] = sum(&|_| 1.0) / 27.0 - (cut[4] + cut[7] + cut[9]) * 2.0 / 3.0;
        let miss = (0..27).map(|i| (cut_value(&cut, node(i)) - value(i)).abs()).fold(0.0, f64::max);
        (cut, miss)
    }

    /// The unevenness of the changes along each dimension: the gain of a cut over half of it.
    fn unevenness(&self) -> [f64; 3] {
        let stride = [1, 3, 9];
        [0, 1, 2].map(|i| {
            let starts = (0..27).filter(|n| node(*n)[i] < 0.0);
            starts
                .map(|n| {
                    let line = [0, 1, 2].map(|k| &self.changes[n + k * stride[i]]);
                    let count = line[1].len();
                    if line.iter().any(|all| all.len() != count) {
                        return 1.0;
                    }
                    (0..count).map(|k| (line[0][k] - 2.0 * line[1][k] + line[2][k]).abs()).sum::<f64>()
                })
                .sum()
        })
    }
}

/// The ends of a zone that are borders of passing rays.
#[derive(Clone, Copy)]
struct Near {
    low: bool,
    high: bool,
}

struct Prover<'a> {
    view: &'a View<'a>,
    centre: Centre,
    floor: Floor,
    cuts: Vec<Cut>,
    cells: Vec<Cell>,
    /// Pieces thinner than this part of the way are not cut again.
    thinnest: f64,
    /// Sizes of the highest terms of thick undecided cells, by dimension.
    blurred: [f64; 3],
}

impl Column {
    /// Proves fates of the rays over `floor`.
    pub(super) fn prove(view: &View<'_>, slab: usize, centre: Centre, floor: Floor) -> Self {
        let nodes = Nodes::new(view, centre, &floor);
        let mut prover = Prover {
            view,
            centre,
            floor,
            cuts: vec![flat(0.0)],
            cells: Vec::new(),
            thinnest: COARSE,
            blurred: [0.0; 3],
        };
        let mut layers: Vec<bool> = Vec::new();
        let mut is_open = false;
        let fits: Vec<(Cut, f64)> = (0..nodes.count().unwrap_or(0)).map(|k| nodes.fit(k)).collect();
        let half_layer = |miss: f64| LAYER * miss + LEAST_LAYER;
        if nodes.count().is_some() {
            // Pieces much thinner than the layer that is left anyway are not worth their time.
            let widest = fits.iter().map(|(_, miss)| half_layer(*miss)).fold(0.0, f64::max);
            prover.thinnest = (0.5 * widest).max(view.thinnest).min(COARSE);
        }
        for (fit, miss) in fits {
            let half = half_layer(miss);
            for (offset, is_layer) in [(-half, false), (half, true)] {
                let mut cut = fit;
                cut[0] += offset;
                let last = prover.cuts[prover.cuts.len() - 1];
                if is_below(&last, &cut) && is_below(&cut, &flat(1.0)) {
                    prover.cuts.push(cut);
                    layers.push(is_layer || is_open);
                    is_open = false;
                } else {
                    is_open = true;
                }
            }
        }
        prover.cuts.push(flat(1.0));
        layers.push(is_open);
        let last = layers.len() - 1;
        for (zone, is_layer) in layers.iter().enumerate() {
            let near = Near { low: zone > 0, high: zone < last };
            let deepest = if *is_layer && layers.len() > 1 { DEEPEST_LAYER } else { DEEPEST };
            prover.piece((zone, [0.0, 1.0]), near, deepest, 0);
        }
        prover.cells.sort_by(|a, b| a.zone.cmp(&b.zone).then(a.from.total_cmp(&b.from)));
        let Prover { cuts, cells, blurred, .. } = prover;
        let mut column = Self { slab, floor, cuts, cells: joined(cells), undecided: 0.0, split: 0 };
        column.undecided = column.volume(view.chart, centre, |fate| fate == Fate::Undecided);
        let uneven = nodes.unevenness();
        let largest = |scores: [f64; 3]| (0..3).max_by(|a, b| scores[*a].total_cmp(&scores[*b]));
        let blurs = blurred.iter().sum::<f64>() > 0.0;
        column.split = largest(if blurs && nodes.count().is_some() { blurred } else { uneven }).unwrap_or(0);
        if !blurs && uneven.iter().all(|x| *x == 0.0) {
            let [shortest, longest] = view.chart.wavelengths_nm;
            let whole = [view.chart.film_radius_mm, 2.0, longest - shortest];
            let size = |i: usize| (floor.high[i] - floor.low[i]) / whole[i];
            column.split = largest([0, 1, 2].map(size)).unwrap_or(0);
        }
        column
    }

    /// Volume of the cells with a fate that `counts`, mm⁴ nm.
    pub fn volume(&self, chart: &Chart, centre: Centre, counts: impl Fn(Fate) -> bool) -> f64 {
        let of_cell = |cell: &Cell| {
            chart.volume(centre, &self.floor, |epsilon| {
                let [low, high] = [0, 1].map(|i| cut_value(&self.cuts[cell.zone + i], epsilon));
                [cell.from, cell.to].map(|f| low + f * (high - low))
            })
        };
        self.cells.iter().filter(|cell| counts(cell.fate)).map(of_cell).sum()
    }

    /// The cell's part of the way at ε of the floor and `across` in −1 to 1 between its cuts.
    pub fn part(&self, cell: &Cell, epsilon: [f64; 3], across: f64) -> f64 {
        let [low, high] = [0, 1].map(|i| cut_value(&self.cuts[cell.zone + i], epsilon));
        let fraction = 0.5 * (cell.from + cell.to) + 0.5 * (cell.to - cell.from) * across;
        low + fraction * (high - low)
    }
}

/// Neighbours of one fate as one cell.
fn joined(cells: Vec<Cell>) -> Vec<Cell> {
    let mut all: Vec<Cell> = Vec::new();
    for cell in cells {
        match all.last_mut() {
            Some(last) if last.zone == cell.zone && last.fate == Fate::Undecided && cell.fate == last.fate => {
                last.to = cell.to;
            }
            _ => all.push(cell),
        }
    }
    all
}

/// True if a cut lies below another over all of the floor, by more than rounding.
fn is_below(low: &Cut, high: &Cut) -> bool {
    let difference: Cut = std::array::from_fn(|i| high[i] - low[i]);
    model(&difference).bounds().is_above(1e-9)
}

/// The part of the way in a cell as a model: between the fractions by the fourth variable.
pub(super) fn part_model(cuts: &[Cut], zone: usize, [from, to]: [f64; 2]) -> Taylor<CELL> {
    let (low, high) = (model(&cuts[zone]), model(&cuts[zone + 1]));
    let slack = 4.0 * f64::EPSILON;
    let fraction = Taylor::variable(0.5 * (from + to), 0.5 * (to - from), VARIABLES - 1).widened(slack);
    low + (high - low) * fraction
}

impl Prover<'_> {
    /// The fate of the rays between two fractions of a zone, and the beam as far as it was followed.
    fn fate(&self, zone: usize, [from, to]: [f64; 2]) -> (Fate, Beam<CELL>) {
        let s = part_model(&self.cuts, zone, [from, to]);
        let beam = self.view.chart.beam(self.centre, &self.floor, s);
        pass(self.view.steps, self.view.indices, self.view.opening_mm, beam)
    }

    /// Proves a piece of a zone, in pieces of it where it must. After so many `strikes`, cuts that decided nothing, the floor is too wide
    /// rather than the piece too thick.
    fn piece(&mut self, (zone, [from, to]): (usize, [f64; 2]), near: Near, deeper: usize, strikes: usize) -> bool {
        let (fate, reached) = self.fate(zone, [from, to]);
        let thickness = (self.cuts[zone + 1][0] - self.cuts[zone][0]) * (to - from);
        if fate != Fate::Undecided {
            self.cells.push(Cell { zone, from, to, fate });
            return true;
        }
        let weights = blur(&reached);
        // A piece that is blurred most by its own thickness is cut whatever the cuts before it did.
        let strikes = if weights[..3].iter().all(|weight| *weight < weights[VARIABLES - 1]) { 0 } else { strikes };
        if thickness < self.thinnest || deeper == 0 || strikes == STRIKES {
            self.cells.push(Cell { zone, from, to, fate });
            if thickness > 4.0 * self.thinnest {
                self.note_blur(weights, thickness);
            }
            return false;
        }
        // Near a border the pieces grow thinner towards it.
        let share = match near {
            Near { low: true, high: false } => 0.25,
            Near { low: false, high: true } => 0.75,
            _ => 0.5,
        };
        let middle = from + share * (to - from);
        let below = (zone, [from, middle], Near { high: false, ..near });
        let above = (zone, [middle, to], Near { low: false, ..near });
        let (first, second) = if near.low && !near.high { (above, below) } else { (below, above) };
        let is_first = self.piece((first.0, first.1), first.2, deeper - 1, strikes + 1);
        let is_second = self.piece((second.0, second.1), second.2, deeper - 1, if is_first { 0 } else { strikes + 1 });
        is_first || is_second
    }

    /// Notes along which dimension of the floor the models of a thick cell are blurred.
    fn note_blur(&mut self, weights: [f64; VARIABLES], thickness: f64) {
        let sum: f64 = weights[..3].iter().sum::<f64>() + f64::MIN_POSITIVE;
        for (blurred, weight) in self.blurred.iter_mut().zip(weights) {
            *blurred += thickness * weight / sum;
        }
    }
}

/// Sizes of the models' terms of the highest degree by variable, at the last surface that they reach: the gain of a cut across it.
fn blur(reached: &Beam<CELL>) -> [f64; VARIABLES] {
    let mut weights = [0.0; VARIABLES];
    for model in reached.point.iter().chain(&reached.direction) {
        for (c, powers) in model.highest_terms() {
            for (weight, power) in weights.iter_mut().zip(powers) {
                *weight += c.abs() * f64::from(power);
            }
        }
    }
    weights
}

impl<const N: usize> Taylor<N> {
    /// Coefficients of the highest degree, with their powers.
    fn highest_terms(&self) -> impl Iterator<Item = (f64, [u8; VARIABLES])> {
        let first = COUNTS.iter().rev().find(|count| **count < N).copied().unwrap_or(0);
        (first..N).map(|i| (self.coefficients()[i], MONOMIALS.powers[i]))
    }
}

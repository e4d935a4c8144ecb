//! Tables of arbitrary density: by alias (constant time) and by rows of an image.

/// Indices chosen in proportion to given weights, in constant time (Vose 1991).
#[derive(Clone, Debug)]
pub struct AliasTable {
    bins: Vec<Bin>,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    keep: f32,
    alias: u32,
    probability: f32,
}

impl AliasTable {
    /// The table of these weights; `None` if no weight is positive and finite, since then nothing can be chosen.
    pub fn new(weights: &[f32]) -> Option<Self> {
        let usable = |w: f32| if w.is_finite() && w > 0.0 { w as f64 } else { 0.0 };
        let total: f64 = weights.iter().map(|&w| usable(w)).sum();
        if total <= 0.0 {
            return None;
        }
        let n = weights.len();
        let mut scaled: Vec<f64> = weights.iter().map(|&w| usable(w) * n as f64 / total).collect();
        let mut bins: Vec<Bin> = scaled
            .iter()
            .enumerate()
            .map(|(i, &s)| Bin { keep: 1.0, alias: i as u32, probability: (s / n as f64) as f32 })
            .collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| scaled[i] < 1.0);
        while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
            bins[s].keep = scaled[s] as f32;
            bins[s].alias = l as u32;
            scaled[l] -= 1.0 - scaled[s];
            if scaled[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        Some(Self { bins })
    }

    /// The chosen index, its probability, and a fresh uniform number made from the rest of `u`.
    #[inline]
    pub fn sample(&self, u: f32) -> (usize, f32, f32) {
        let n = self.bins.len();
        let x = u * n as f32;
        let i = (x as u32 as usize).min(n - 1);
        let part = (x - i as f32).clamp(0.0, 1.0 - f32::EPSILON);
        let bin = self.bins[i];
        if part < bin.keep {
            (i, bin.probability, (part / bin.keep).min(1.0 - f32::EPSILON))
        } else {
            let rest = ((part - bin.keep) / (1.0 - bin.keep)).clamp(0.0, 1.0 - f32::EPSILON);
            (bin.alias as usize, self.bins[bin.alias as usize].probability, rest)
        }
    }

    /// The probability of an index.
    #[inline]
    pub fn probability(&self, index: usize) -> f32 {
        self.bins[index].probability
    }
}

/// A density over the unit square, constant in each cell of a grid, sampled by inversion: neighbouring numbers give
/// neighbouring points, which an alias table would tear apart.
#[derive(Clone, Debug)]
pub struct Grid2d {
    width: usize,
    height: usize,
    rows: Cumulative,
    marginal: Cumulative,
}

impl Grid2d {
    /// The distribution of `width * height` weights, rows first; `None` where none is positive.
    pub fn new(weights: &[f32], width: usize, height: usize) -> Option<Self> {
        let (rows, sums) = Cumulative::new(weights, width);
        let (marginal, total) = Cumulative::new(&sums, height);
        (total[0] > 0.0).then_some(Self { width, height, rows, marginal })
    }

    /// A point of the unit square and its density there.
    pub fn sample(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let (y, dy, py) = self.marginal.invert(0, u[1]);
        let (x, dx, px) = self.rows.invert(y, u[0]);
        let pdf = px * py * (self.width * self.height) as f32;
        ([(x as f32 + dx) / self.width as f32, (y as f32 + dy) / self.height as f32], pdf)
    }

    /// The density at a point of the unit square.
    pub fn pdf(&self, p: [f32; 2]) -> f32 {
        // By way of 32 bits, which a processor converts to in one step.
        let x = ((p[0] * self.width as f32) as u32 as usize).min(self.width - 1);
        let y = ((p[1] * self.height as f32) as u32 as usize).min(self.height - 1);
        self.rows.probability(y, x) * self.marginal.probability(0, y) * (self.width * self.height) as f32
    }
}

/// Distributions of equally many steps, one after the other, as cumulative sums that end in 1. A guide says for each
/// of as many equal parts of the unit interval at which step to look first, so that inversion takes a step or two on
/// average (Chen and Asau 1974).
#[derive(Clone, Debug)]
struct Cumulative {
    steps: usize,
    // `steps + 1` each.
    sums: Vec<f32>,
    // `steps` each.
    guide: Vec<u32>,
}

impl Cumulative {
    /// The sums of lists of `steps` weights each; also returns the total of each list.
    fn new(weights: &[f32], steps: usize) -> (Self, Vec<f32>) {
        let count = weights.len() / steps.max(1);
        let mut this = Self { steps, sums: Vec::with_capacity((steps + 1) * count), guide: Vec::new() };
        this.guide.reserve(steps * count);
        let totals = weights.chunks_exact(steps).map(|w| this.push(w)).collect();
        (this, totals)
    }

    fn push(&mut self, weights: &[f32]) -> f32 {
        let total: f64 = weights.iter().map(|&w| w.max(0.0) as f64).sum();
        let first = self.sums.len();
        let mut sum = 0.0;
        self.sums.push(0.0);
        for (i, &w) in weights.iter().enumerate() {
            sum += w.max(0.0) as f64;
            // Without any weight it is never chosen; spread it evenly to stay a distribution.
            self.sums.push(if total > 0.0 { (sum / total) as f32 } else { (i + 1) as f32 / weights.len() as f32 });
        }
        let sums = &self.sums[first..];
        let mut step = 0;
        for part in 0..self.steps {
            let u = part as f32 / self.steps as f32;
            while step < self.steps - 1 && sums[step + 1] <= u {
                step += 1;
            }
            self.guide.push(step as u32);
        }
        total as f32
    }

    fn probability(&self, which: usize, step: usize) -> f32 {
        let at = which * (self.steps + 1) + step;
        self.sums[at + 1] - self.sums[at]
    }

    /// The step that holds `u`, the place within it, and its probability.
    fn invert(&self, which: usize, u: f32) -> (usize, f32, f32) {
        let sums = &self.sums[which * (self.steps + 1)..][..self.steps + 1];
        let last = self.steps - 1;
        let part = ((u * self.steps as f32) as u32 as usize).min(last);
        let first = (self.guide[which * self.steps + part] as usize).min(last);
        // How many of the next two it has passed is no branch: any processor would guess it wrong half of the time.
        let passed = usize::from(sums[first + 1] <= u) + usize::from(sums[(first + 2).min(last + 1)] <= u);
        let mut i = (first + passed).min(last);
        while i < last && sums[i + 1] <= u {
            i += 1;
        }
        // The last steps may have no weight.
        while i > 0 && (sums[i + 1] <= sums[i] || sums[i] > u) {
            i -= 1;
        }
        let p = sums[i + 1] - sums[i];
        let part = if p > 0.0 { ((u - sums[i]) / p).clamp(0.0, 1.0 - f32::EPSILON) } else { 0.5 };
        (i, part, p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    #[test]
    fn alias_choices_follow_the_weights() {
        let weights = [0.0, 3.0, 1.0, 0.0, 4.0, f32::NAN, 1e-3];
        let table = AliasTable::new(&weights).unwrap();
        let n = 200_000;
        let mut counts = [0usize; 7];
        let mut rest_sum = 0.0;
        for k in 0..n {
            let (i, p, rest) = table.sample((k as f32 + 0.5) / n as f32);
            assert!(p > 0.0 && (0.0..1.0).contains(&rest));
            counts[i] += 1;
            rest_sum += rest as f64;
        }
        for (i, &c) in counts.iter().enumerate() {
            // Stratified input: counts are within one or two of their share per piece of the table.
            assert!((c as f32 / n as f32 - table.probability(i)).abs() < 1e-4, "{i}: {c}");
        }
        let probabilities: Vec<f64> = (0..7).map(|i| table.probability(i).into()).collect();
        sampling::choices("alias table", 1 << 16, &probabilities, |random| {
            Some(table.sample(random.numbers::<1>()[0]).0)
        });
        assert!((rest_sum / n as f64 - 0.5).abs() < 1e-2);
        assert_eq!(counts[0] + counts[3] + counts[5], 0);
        assert!(AliasTable::new(&[0.0, -1.0]).is_none());
        assert!(AliasTable::new(&[]).is_none());
    }

    #[test]
    fn grid_density_is_that_of_its_samples() {
        let weights = [0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 5.0, 0.5, 0.0];
        let grid = Grid2d::new(&weights, 3, 3).unwrap();
        let total: f32 = weights.iter().sum();
        for (i, w) in weights.iter().enumerate() {
            let p = [(i % 3) as f32 / 3.0 + 0.1, (i / 3) as f32 / 3.0 + 0.1];
            assert!((grid.pdf(p) - 9.0 * w / total).abs() < 1e-4);
        }
        sampling::places(
            "grid",
            1 << 16,
            [[0.0, 1.0]; 2],
            |random| {
                let (p, pdf) = grid.sample(random.numbers());
                assert!(pdf > 0.0 && (pdf - grid.pdf(p)).abs() < 1e-4 * pdf, "{p:?}");
                Some(p)
            },
            |p| grid.pdf(p).into(),
        );
        assert!(Grid2d::new(&[0.0; 4], 2, 2).is_none());
    }
}

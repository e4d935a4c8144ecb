//! Even nodes along an axis, cubics between them, and the filling of missing nodes.

/// An interval with nodes at equal steps, both ends among them.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeAxis {
    start: f64,
    step: f64,
    nodes: usize,
}

/// A place so far outside, in steps, is rounding.
const ROUNDING: f64 = 1e-6;

impl NodeAxis {
    /// An axis of at least four nodes.
    pub(super) fn new(start: f64, end: f64, nodes: usize) -> Self {
        let nodes = nodes.max(4);
        // An interval of no length has a place all the same.
        let length = (end - start).max(f64::MIN_POSITIVE);
        Self { start, step: length / (nodes - 1) as f64, nodes }
    }

    /// One node, at 0.
    pub(super) fn single() -> Self {
        Self { start: 0.0, step: 1.0, nodes: 1 }
    }

    pub(super) fn nodes(&self) -> usize {
        self.nodes
    }

    pub(super) fn at(&self, node: usize) -> f64 {
        self.start + self.step * node as f64
    }

    /// The nodes and the places midway between them.
    pub(super) fn halves(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { start, step, nodes } = *self;
        (0..2 * nodes - 1).map(move |half| start + step * 0.5 * half as f64)
    }

    /// The nodes that count at `x` and their weights; `None` outside of the interval.
    #[inline]
    pub(super) fn stencil(&self, x: f64) -> Option<Stencil> {
        match self.nodes {
            1 => Some(Stencil { first: 0, weights: [1.0, 0.0, 0.0, 0.0], count: 1 }),
            nodes => Stencil::cubic((x - self.start) / self.step, nodes),
        }
    }
}

/// Neighbouring nodes and their weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil {
    first: usize,
    weights: [f32; 4],
    count: usize,
}

impl Stencil {
    /// Lagrange's cubic through the four nodes about `place`, counted in steps; at the ends it leans inwards. `None`
    /// outside of 0 to `nodes` − 1.
    #[inline]
    pub(super) fn cubic(place: f64, nodes: usize) -> Option<Self> {
        let last = (nodes - 1) as f64;
        // Written so that NaN, too, is outside.
        if !(place >= -ROUNDING && place <= last + ROUNDING) {
            return None;
        }
        let first = (place as usize).saturating_sub(1).min(nodes - 4);
        let x = (place - first as f64) as f32;
        let (a, b, c, d) = (x, x - 1.0, x - 2.0, x - 3.0);
        let weights = [b * c * d * (-1.0 / 6.0), a * c * d * 0.5, a * b * d * -0.5, a * b * c * (1.0 / 6.0)];
        Some(Self { first, weights, count: 4 })
    }

    #[inline]
    pub(super) fn first(&self) -> usize {
        self.first
    }

    #[inline]
    pub(super) fn weights(&self) -> [f32; 4] {
        self.weights
    }

    #[inline]
    pub(super) fn nodes(&self) -> impl Iterator<Item = (usize, f32)> {
        let first = self.first;
        self.weights[..self.count].iter().enumerate().map(move |(i, &weight)| (first + i, weight))
    }
}

/// Rounds of filling that still carry a parabola on; nodes farther out count for no ray.
const ROUNDS: usize = 3;

/// The rows of a square of `side`, the missing ones continued from their neighbours; `lost` where that is too far.
pub(super) fn fill_gaps<const N: usize>(mut rows: Vec<Option<[f64; N]>>, side: usize, lost: [f64; N]) -> Vec<[f64; N]> {
    let steps = [(1, 0), (-1, 0), (0, 1), (0, -1)];
    for _ in 0..ROUNDS {
        let continued = |place: usize| {
            let neighbour = |(dx, dy): (isize, isize), by: isize| {
                let x = (place % side).checked_add_signed(dx * by).filter(|&x| x < side)?;
                let y = (place / side).checked_add_signed(dy * by).filter(|&y| y < side)?;
                rows[y * side + x]
            };
            let (mut sum, mut count) = ([0.0; N], 0.0);
            for step in steps {
                let Some(((a, b), c)) = neighbour(step, 1).zip(neighbour(step, 2)).zip(neighbour(step, 3)) else {
                    continue;
                };
                (0..N).for_each(|i| sum[i] += 3.0 * (a[i] - b[i]) + c[i]);
                count += 1.0;
            }
            (count > 0.0).then(|| sum.map(|number| number / count))
        };
        let round: Vec<_> = rows.iter().enumerate().map(|(i, row)| row.or_else(|| continued(i))).collect();
        rows = round;
    }
    rows.into_iter().map(|row| row.unwrap_or(lost)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced_up_to_the_ends() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.1 * x * x * x;
        let axis = NodeAxis::new(-1.0, 3.0, 9);
        for i in 0..=100 {
            let x = -1.0 + 4.0 * f64::from(i) / 100.0;
            let sum: f64 = axis.stencil(x).unwrap().nodes().map(|(n, w)| f64::from(w) * cubic(axis.at(n))).sum();
            // Weights in f32 of values up to 5.
            assert!((sum - cubic(x)).abs() < 3e-6, "{x}: {sum}");
        }
        assert!(axis.stencil(-1.01).is_none() && axis.stencil(3.01).is_none() && axis.stencil(f64::NAN).is_none());
    }

    #[test]
    fn gaps_are_continued_by_parabolas() {
        let side = 8;
        let parabola = |i: usize| {
            let (x, y) = ((i % side) as f64, (i / side) as f64);
            [1.0 + 0.3 * x * x - 0.2 * y * y + 0.5 * x * y]
        };
        let rows = (0..side * side).map(|i| (i % side < 6).then(|| parabola(i))).collect();
        for (i, row) in fill_gaps(rows, side, [f64::NAN]).into_iter().enumerate() {
            assert!((row[0] - parabola(i)[0]).abs() < 1e-9, "{i}");
        }
    }
}

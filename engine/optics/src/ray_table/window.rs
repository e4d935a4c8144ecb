//! The part of the pupil's plane that film points see, as a rectangle that moves and changes smoothly with them.

use glam::DVec2;

/// Powers of the film's coordinates, to the third together: a pupil walks and shrinks about so.
const TERMS: usize = 10;

/// Sides of the rectangle: left, low, right, high.
type Sides = [f64; 4];

/// A rectangle on the reference plane for each film point, in mm.
#[derive(Clone, Debug)]
pub(super) struct PlaneWindow {
    /// The film's middle in the film's coordinates, and one over half of its sides.
    middle: DVec2,
    per_half: DVec2,
    /// The share in the four sides, by power.
    terms: [Sides; TERMS],
}

/// Part of its side by which a window is larger than needed.
const MARGIN: f64 = 0.01;

impl PlaneWindow {
    /// The window that holds `bounds` (low, high) at all their film points, none far larger than needed; `glass`, a
    /// square of that half side, if there are none. `is_radial`: the film's second coordinate does not count.
    pub(super) fn around(bounds: &[(DVec2, [DVec2; 2])], is_radial: bool, glass: f64) -> Self {
        let places = bounds.iter().map(|(film, _)| *film);
        let low = places.clone().fold(DVec2::INFINITY, DVec2::min);
        let high = places.fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut window = Self { middle: DVec2::ZERO, per_half: DVec2::ZERO, terms: [[0.0; 4]; TERMS] };
        window.terms[0] = [-glass, -glass, glass, glass];
        if bounds.is_empty() {
            return window;
        }
        let half = 0.5 * (high - low);
        let per_half = |side: f64| if side > 0.0 { 1.0 / side } else { 0.0 };
        window.middle = 0.5 * (low + high);
        window.per_half = DVec2::new(per_half(half.x), if is_radial { 0.0 } else { per_half(half.y) });
        let sides = |[low, high]: [DVec2; 2]| [low.x, low.y, high.x, high.y];
        window.terms = least_squares(bounds.iter().map(|&(film, bounds)| (window.powers(film), sides(bounds))));
        let (mut out, mut size) = ([f64::NEG_INFINITY; 4], 0.0f64);
        for &(film, bounds) in bounds {
            let [left, low, right, high] = window.sides(film);
            let [needed_left, needed_low, needed_right, needed_high] = sides(bounds);
            let beyond = [left - needed_left, low - needed_low, needed_right - right, needed_high - high];
            (0..4).for_each(|i| out[i] = out[i].max(beyond[i]));
            size = size.max(right - left).max(high - low);
        }
        let [left, low, right, high] = out.map(|by| by + MARGIN * size);
        for (side, by) in window.terms[0].iter_mut().zip([-left, -low, right, high]) {
            *side += by;
        }
        window
    }

    /// 1, x, y, x², ... of a film point, each coordinate from −1 to 1; zero for terms of a coordinate that has no extent.
    #[inline]
    fn powers(&self, film: DVec2) -> [f64; TERMS] {
        let DVec2 { x, y } = (film - self.middle) * self.per_half;
        [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
    }

    #[inline]
    fn sides(&self, film: DVec2) -> Sides {
        let mut sides = [0.0; 4];
        for (power, term) in self.powers(film).iter().zip(&self.terms) {
            (0..4).for_each(|i| sides[i] += power * term[i]);
        }
        sides
    }

    /// The window's low corner for a film point, and its sides; both sides are above 0, else nothing is seen.
    #[inline]
    pub(super) fn at(&self, film: DVec2) -> (DVec2, DVec2) {
        let [left, low, right, high] = self.sides(film);
        (DVec2::new(left, low), DVec2::new(right - left, high - low))
    }
}

/// The factors of the powers that come nearest to all sides, by Cholesky's way through the normal equations: to the
/// third power between −1 and 1 they are sound, and a touch of weight on the factors themselves settles those that
/// nothing asks for.
fn least_squares(points: impl Iterator<Item = ([f64; TERMS], Sides)>) -> [Sides; TERMS] {
    let mut matrix = [[0.0; TERMS]; TERMS];
    let mut right = [[0.0; 4]; TERMS];
    let mut count = 0.0;
    for (powers, sides) in points {
        count += 1.0;
        for i in 0..TERMS {
            (0..TERMS).for_each(|j| matrix[i][j] += powers[i] * powers[j]);
            (0..4).for_each(|side| right[i][side] += powers[i] * sides[side]);
        }
    }
    (0..TERMS).for_each(|i| matrix[i][i] += 1e-9 * count);
    for i in 0..TERMS {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let rest = matrix[i][j] - dot;
            matrix[i][j] = if i == j { rest.sqrt() } else { rest / matrix[j][j] };
        }
        let pivot = matrix[i][i];
        let (solved, rest) = right.split_at_mut(i);
        for (side, value) in rest[0].iter_mut().enumerate() {
            let dot: f64 = matrix[i].iter().zip(solved.iter()).map(|(factor, sides)| factor * sides[side]).sum();
            *value = (*value - dot) / pivot;
        }
    }
    for i in (0..TERMS).rev() {
        let (rest, solved) = right.split_at_mut(i + 1);
        for (side, value) in rest[i].iter_mut().enumerate() {
            let below = matrix[i + 1..].iter().zip(solved.iter());
            let dot: f64 = below.map(|(row, sides)| row[i] * sides[side]).sum();
            *value = (*value - dot) / matrix[i][i];
        }
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pupil that walks and shrinks is held, with little to spare.
    #[test]
    fn it_holds_what_it_must() {
        let bounds: Vec<_> = (0..=40)
            .flat_map(|i| (0..=40).map(move |j| DVec2::new(f64::from(i) - 15.0, 0.3 * f64::from(j))))
            .map(|film| {
                let half = DVec2::new(6.0 - 0.005 * film.length_squared(), 5.0 + 1e-4 * film.x.powi(3));
                (film, [film * 0.7 - half, film * 0.7 + half])
            })
            .collect();
        let window = PlaneWindow::around(&bounds, false, 1.0);
        for &(film, [low, high]) in &bounds {
            let (corner, sides) = window.at(film);
            assert!(corner.cmple(low).all() && (corner + sides).cmpge(high).all(), "{film}");
            // Cubics are followed: what is left are two margins of a hundredth of the largest side, 13 mm.
            assert!((sides - (high - low)).max_element() < 0.28, "{film} {sides}");
        }
    }
}

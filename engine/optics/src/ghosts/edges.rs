//! The edge of the part of a beam that gets through: the cells of a grid that its edge crosses, cut along it.
//!
//! Each cell is parted once more; along the sides of the parts whose ends fare differently the edge is found by halving. Between two
//! such points it is taken for straight.

use glam::DVec2;

/// Parts of a cell along each side, and points.
const PARTS: usize = 3;
const POINTS: usize = PARTS + 1;
/// Sides of a cell's parts: those along x, then those along y.
const SIDES: usize = 2 * PARTS * POINTS;
/// The value in place of a crossing's number where the edge does not cross this side.
const NONE: u32 = u32::MAX;

/// A ray that gets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PassedRay {
    /// The point on the beam's disc, in radii.
    pub(super) at: DVec2,
    /// The point on the film, mm.
    pub(super) film: DVec2,
}

/// Cells that an edge crosses.
pub(super) struct Edges {
    /// Rays by cell and point.
    points: Vec<Option<PassedRay>>,
    /// The number of the crossing found, by cell and side.
    sides: Vec<[u32; SIDES]>,
    crossings: Vec<PassedRay>,
}

/// A side that an edge crosses.
struct Crossed {
    inside: PassedRay,
    outside: DVec2,
}

/// The points at the ends of a side.
fn ends(side: usize) -> [usize; 2] {
    let along_x = PARTS * POINTS;
    match side.checked_sub(along_x) {
        None => {
            let first = side / PARTS * POINTS + side % PARTS;
            [first, first + 1]
        }
        Some(side) => [side, side + POINTS],
    }
}

impl Edges {
    /// Finds the edges in cells at these corners, all of one size, by so many halvings of a part's side. `trace` returns the points on the film of rays through points of the
    /// disc.
    pub(super) fn find(
        cells: &[DVec2],
        size: DVec2,
        halvings: usize,
        mut trace: impl FnMut(&[DVec2]) -> Vec<Option<DVec2>>,
    ) -> Self {
        let part = size / PARTS as f64;
        let of_cell = |corner: &DVec2| {
            let corner = *corner;
            (0..POINTS * POINTS).map(move |i| corner + part * DVec2::new((i % POINTS) as f64, (i / POINTS) as f64))
        };
        let places: Vec<DVec2> = cells.iter().flat_map(of_cell).collect();
        let found = trace(&places);
        let points: Vec<Option<PassedRay>> =
            found.iter().zip(&places).map(|(film, at)| film.map(|film| PassedRay { at: *at, film })).collect();
        let mut sides = vec![[NONE; SIDES]; cells.len()];
        let mut crossed = Vec::new();
        for (cell, sides) in sides.iter_mut().enumerate() {
            let first = cell * POINTS * POINTS;
            for (side, number) in sides.iter_mut().enumerate() {
                let [a, b] = ends(side).map(|i| first + i);
                let (inside, outside) = match (points[a], points[b]) {
                    (Some(a), None) => (a, places[b]),
                    (None, Some(b)) => (b, places[a]),
                    _ => continue,
                };
                *number = crossed.len() as u32;
                crossed.push(Crossed { inside, outside });
            }
        }
        for _ in 0..halvings {
            let middles: Vec<DVec2> = crossed.iter().map(|side| 0.5 * (side.inside.at + side.outside)).collect();
            for ((side, at), film) in crossed.iter_mut().zip(&middles).zip(trace(&middles)) {
                match film {
                    Some(film) => side.inside = PassedRay { at: *at, film },
                    None => side.outside = *at,
                }
            }
        }
        // The edge lies between both.
        let crossing = |side: Crossed| PassedRay { at: 0.5 * (side.inside.at + side.outside), ..side.inside };
        Self { points, sides, crossings: crossed.into_iter().map(crossing).collect() }
    }

    /// Calls `each` with the corners of every part's piece that gets through, in their order around it.
    pub(super) fn polygons(&self, each: &mut impl FnMut(&[PassedRay])) {
        let mut polygon = Vec::with_capacity(8);
        for (cell, sides) in self.sides.iter().enumerate() {
            let point = |i: usize| self.points[cell * POINTS * POINTS + i];
            for part in 0..PARTS * PARTS {
                let (x, y) = (part % PARTS, part / PARTS);
                let corner = y * POINTS + x;
                let around = [corner, corner + 1, corner + POINTS + 1, corner + POINTS];
                let along_y = PARTS * POINTS + corner;
                let between = [y * PARTS + x, along_y + 1, (y + 1) * PARTS + x, along_y];
                polygon.clear();
                for (corner, side) in around.into_iter().zip(between) {
                    polygon.extend(point(corner));
                    polygon.extend(self.crossings.get(sides[side] as usize));
                }
                if polygon.len() > 2 {
                    each(&polygon);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells about a circle hold its area: chords of an eighteenth of the radius leave out less than 1e-3 of the area that they cut.
    #[test]
    fn a_circle_is_cut_along_its_edge() {
        let cells: Vec<DVec2> = (0..144).map(|i| DVec2::new((i % 12) as f64, (i / 12) as f64) / 6.0 - 1.0).collect();
        let size = DVec2::splat(1.0 / 6.0);
        let inside = |at: &DVec2| (at.length() <= 0.9).then_some(*at * 10.0);
        let edges = Edges::find(&cells, size, 5, |points| points.iter().map(inside).collect());
        let (mut on_disc, mut on_film) = (0.0, 0.0);
        edges.polygons(&mut |polygon| {
            let area = |point: fn(&PassedRay) -> DVec2| {
                let next = |i: usize| point(&polygon[(i + 1) % polygon.len()]);
                (0..polygon.len()).map(|i| point(&polygon[i]).perp_dot(next(i))).sum::<f64>() / 2.0
            };
            (on_disc, on_film) = (on_disc + area(|p| p.at), on_film + area(|p| p.film));
        });
        let expected = std::f64::consts::PI * 0.81;
        assert!((on_disc / expected - 1.0).abs() < 1.5e-3, "{on_disc} {expected}");
        // Places on the film are those of the last rays that got through, half of a 96th of a cell farther in.
        assert!((on_film / (100.0 * expected) - 1.0).abs() < 4e-3, "{on_film}");
    }
}

//! The clear pupil as a place of the film sees it, in direction cosines: polygons.
//!
//! A lattice of rays tells open from closed, and where neighbours differ the edge between them is found by halving. The corners of
//! the polygons lie on the edge to rounding, so that straight edges stay straight, for the light that goes far aside is
//! made by straight edges.

use glam::{DVec2, DVec3};

use crate::analysis::Touching;
use crate::focus::FilmFrame;
use crate::pupil_map::PupilMap;
use crate::trace::{Ray, Tracer, Travel};

/// Rays over the width of the pupil: openings narrower than a part in so many of it may be missed.
const LATTICE: usize = 384;
/// Rays by which the pupil is first found.
const LOOKS: u32 = 1024;
/// Margin around the pupil, as a part of its width, and number of times that it grows.
const MARGIN: f64 = 0.05;
const GROWTHS: u32 = 6;
/// Halvings of a cell's side: to rounding.
const HALVINGS: u32 = 34;

/// A pupil's edge. Direction cosines are those to the film's two directions, right and up, times the index before the film.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Closed polygons, one after the other; points in an odd number of them are open.
    pub polygons: Vec<Vec<DVec2>>,
}

impl Outline {
    /// The pupil of `tracer` as the film's place (u, v) sees it, in a medium of that index; edges are held to `tolerance`, in direction
    /// cosines. `None`: no light arrives.
    pub fn seen_from(
        tracer: &Tracer,
        map: &PupilMap,
        frame: &FilmFrame,
        place: DVec2,
        index: f64,
        tolerance: f64,
    ) -> Option<Self> {
        let seen = FilmView::new(tracer, map, frame, place)?;
        let mut window = seen.window;
        for _ in 0..GROWTHS {
            let lattice = Lattice::new(&seen, window);
            if lattice.is_closed_around() {
                let mut polygons = lattice.loops(&seen);
                polygons.iter_mut().for_each(|polygon| *polygon = simplified(polygon, tolerance / index));
                polygons.retain(|polygon| polygon.len() > 2);
                polygons.iter_mut().flatten().for_each(|corner| *corner *= index);
                return (!polygons.is_empty()).then_some(Self { polygons });
            }
            let more = 0.25 * (window[1] - window[0]);
            window = [window[0] - more, window[1] + more];
        }
        None
    }

    /// A regular polygon with one corner at `rotation_rad`, or a circle of many corners.
    pub fn regular(radius: f64, corners: usize, rotation_rad: f64) -> Vec<DVec2> {
        let angle = |i: usize| rotation_rad + std::f64::consts::TAU * i as f64 / corners as f64;
        (0..corners).map(|i| DVec2::from_angle(angle(i)) * radius).collect()
    }

    /// The open area: that of all polygons, holes taken off.
    pub fn area(&self) -> f64 {
        // The sense of turning tells holes.
        self.polygons.iter().map(|polygon| signed_area(polygon)).sum::<f64>().abs()
    }

    /// The largest extent along either direction.
    pub fn width(&self) -> f64 {
        let corners = self.polygons.iter().flatten();
        let ends = corners.map(|&c| (c, c)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        ends.map_or(0.0, |(low, high)| (high - low).max_element())
    }
}

fn signed_area(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    0.5 * polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}

/// A place of the film that looks at the lens.
struct FilmView<'a> {
    tracer: &'a Tracer,
    touching: Touching,
    normal: DVec3,
    /// Range of direction cosines of the light.
    window: [DVec2; 2],
}

impl<'a> FilmView<'a> {
    fn new(tracer: &'a Tracer, map: &PupilMap, frame: &FilmFrame, place: DVec2) -> Option<Self> {
        let film = frame.at(place.x, place.y);
        let touching = Touching::new(frame, place, [DVec2::X, DVec2::Y]);
        let mut bundle = tracer.bundle(Travel::FromFilm);
        let mut directions = Vec::new();
        // The plastic number's powers fill a square evenly.
        for i in 0..LOOKS {
            let u = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2].map(|a| (0.5 + a * f64::from(i)).fract());
            let direction = (map.sample(film.point, u).target - film.point).normalize_or(film.normal);
            directions.push(direction);
            bundle.push(Ray { origin: film.point, direction });
        }
        tracer.trace(&mut bundle);
        let open = (0..directions.len()).filter(|&i| bundle.is_through(i)).map(|i| directions[i]);
        let normal = film.normal * directions[0].dot(film.normal).signum();
        let cosines = |d: DVec3| -touching.cosines(d);
        let ends = open.map(|d| (cosines(d), cosines(d))).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        let margin = ((ends.1 - ends.0) * MARGIN).max(DVec2::splat(1e-9));
        Some(Self { tracer, touching, normal, window: [ends.0 - margin, ends.1 + margin] })
    }

    /// The openness by direction of the light, in direction cosines: true if the light gets through.
    fn are_open(&self, cosines: &[DVec2]) -> Vec<bool> {
        let mut bundle = self.tracer.bundle(Travel::FromFilm);
        let mut is_real = Vec::with_capacity(cosines.len());
        for at in cosines {
            let along = 1.0 - at.length_squared();
            is_real.push(along > 0.0);
            let direction = self.normal * along.max(0.0).sqrt() + self.touching.direction(-*at);
            bundle.push(Ray { origin: self.touching.point(), direction });
        }
        self.tracer.trace(&mut bundle);
        is_real.into_iter().enumerate().map(|(i, is_real)| is_real && bundle.is_through(i)).collect()
    }
}

/// Open and closed points of a window.
struct Lattice {
    low: DVec2,
    step: DVec2,
    is_open: Vec<bool>,
}

/// A side of the lattice's cells: its lower or left point, and true if it goes up.
type Side = (usize, bool);

impl Lattice {
    fn new(seen: &FilmView<'_>, [low, high]: [DVec2; 2]) -> Self {
        let step = (high - low) / (LATTICE - 1) as f64;
        let mut lattice = Self { low, step, is_open: Vec::new() };
        let places: Vec<DVec2> = (0..LATTICE * LATTICE).map(|i| lattice.place(i)).collect();
        lattice.is_open = seen.are_open(&places);
        lattice
    }

    fn place(&self, i: usize) -> DVec2 {
        self.low + self.step * DVec2::new((i % LATTICE) as f64, (i / LATTICE) as f64)
    }

    fn is_closed_around(&self) -> bool {
        let on_rim = |i: usize| {
            let last = LATTICE - 1;
            [i % LATTICE, i / LATTICE].iter().any(|&k| k == 0 || k == last)
        };
        !(0..self.is_open.len()).any(|i| on_rim(i) && self.is_open[i])
    }

    /// The edge as closed polygons, with the open side on their left.
    fn loops(&self, seen: &FilmView<'_>) -> Vec<Vec<DVec2>> {
        let (sides, points) = self.crossings(seen);
        let number = |side: Side| sides.binary_search(&side).ok();
        // Where the edge goes on from each crossing.
        let mut next = vec![None; sides.len()];
        for row in 0..LATTICE - 1 {
            for column in 0..LATTICE - 1 {
                let first = row * LATTICE + column;
                for (from, to) in self.ways(first, seen) {
                    if let (Some(from), Some(to)) = (number(from), number(to)) {
                        next[from] = Some(to);
                    }
                }
            }
        }
        let mut loops = Vec::new();
        for start in 0..sides.len() {
            let mut polygon = Vec::new();
            let mut here = start;
            while let Some(after) = next[here].take() {
                polygon.push(points[here]);
                here = after;
            }
            if here == start && polygon.len() > 2 {
                loops.push(polygon);
            }
        }
        loops
    }

    /// The sides whose ends differ, in order, with the crossings of the edge.
    fn crossings(&self, seen: &FilmView<'_>) -> (Vec<Side>, Vec<DVec2>) {
        let mut sides: Vec<Side> = Vec::new();
        for i in 0..self.is_open.len() {
            if i % LATTICE + 1 < LATTICE && self.is_open[i] != self.is_open[i + 1] {
                sides.push((i, false));
            }
            if i / LATTICE + 1 < LATTICE && self.is_open[i] != self.is_open[i + LATTICE] {
                sides.push((i, true));
            }
        }
        let end = |&(i, is_up): &Side| if is_up { i + LATTICE } else { i + 1 };
        // Open, closed.
        let mut ends: Vec<[DVec2; 2]> = sides
            .iter()
            .map(|side| {
                let (a, b) = (side.0, end(side));
                let (a, b) = if self.is_open[a] { (a, b) } else { (b, a) };
                [a, b].map(|i| self.place(i))
            })
            .collect();
        for _ in 0..HALVINGS {
            let middles: Vec<DVec2> = ends.iter().map(|[a, b]| (*a + *b) * 0.5).collect();
            for ((pair, is_open), middle) in ends.iter_mut().zip(seen.are_open(&middles)).zip(middles) {
                pair[usize::from(!is_open)] = middle;
            }
        }
        (sides, ends.into_iter().map(|[a, b]| (a + b) * 0.5).collect())
    }

    /// The ways of the edge through the cell above and right of a point, open on its left: none, one or two ways.
    fn ways(&self, first: usize, seen: &FilmView<'_>) -> Vec<(Side, Side)> {
        let corners = [first, first + 1, first + 1 + LATTICE, first + LATTICE].map(|i| self.is_open[i]);
        // Counter-clockwise from below.
        let sides = [(first, false), (first + 1, true), (first + LATTICE, false), (first, true)];
        // Going round the cell, the edge comes in where open turns to closed behind it: it enters at a side whose first corner is
        // closed and whose second is open, seen counter-clockwise, and has the open corner on its left.
        let ins: Vec<usize> = (0..4).filter(|&i| corners[i] && !corners[(i + 1) % 4]).collect();
        let outs: Vec<usize> = (0..4).filter(|&i| !corners[i] && corners[(i + 1) % 4]).collect();
        match (ins.as_slice(), outs.as_slice()) {
            ([one], [other]) => vec![(sides[*one], sides[*other])],
            ([a, b], [c, d]) => {
                // Two open corners across: the middle tells whether they are joined.
                let middle = self.place(first) + 0.5 * self.step;
                let is_joined = seen.are_open(&[middle])[0];
                // Around each open corner, or around each closed one: the out after or before the in.
                let after = |i: usize| [*c, *d].into_iter().find(|&o| o == (i + 1) % 4).unwrap_or(*c);
                let before = |i: usize| [*c, *d].into_iter().find(|&o| o == (i + 3) % 4).unwrap_or(*d);
                let out = |i: usize| if is_joined { after(i) } else { before(i) };
                vec![(sides[*a], sides[out(*a)]), (sides[*b], sides[out(*b)])]
            }
            _ => Vec::new(),
        }
    }
}

/// The polygon without corners that lie within the tolerance of the chords that stay (Douglas and Peucker 1973).
fn simplified(polygon: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let n = polygon.len();
    let far = (0..n).max_by(|&a, &b| {
        let from = |i: usize| polygon[i].distance_squared(polygon[0]);
        from(a).total_cmp(&from(b))
    });
    let Some(far) = far.filter(|&far| far > 0) else { return polygon.to_vec() };
    let mut is_kept = vec![false; n + 1];
    is_kept[0] = true;
    is_kept[far] = true;
    let at = |i: usize| polygon[i % n];
    let mut spans = vec![(0, far), (far, n)];
    while let Some((from, to)) = spans.pop() {
        let (a, b) = (at(from), at(to));
        let along = (b - a).normalize_or_zero();
        let off = |i: &usize| if along == DVec2::ZERO { at(*i).distance(a) } else { along.perp_dot(at(*i) - a).abs() };
        let Some(worst) = (from + 1..to).max_by(|i, j| off(i).total_cmp(&off(j))) else { continue };
        if off(&worst) > tolerance {
            is_kept[worst] = true;
            spans.extend([(from, worst), (worst, to)]);
        }
    }
    (0..n).filter(|&i| is_kept[i]).map(at).collect()
}

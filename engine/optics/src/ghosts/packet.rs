//! A ghost as it lies on the film: a beam's rays traced along a path with reflections as a grid that the lens warps.
//!
//! Between the rays of a small cell light spreads evenly, so a cell's light over the area that it covers on the film is the irradiance
//! there, however the grid is folded (Hullin et al. 2011, "Physically-based real-time lens flare rendering", section 4). Cells on the edge
//! of the light that rims and diaphragm let through are cut along it ([`super::edges`]). Power changes slowly over the beam: it is known
//! exactly at a few points and evened out between them.

use glam::DVec2;

use super::beam::Beam;
use super::edges::Edges;
use super::power;
use crate::focus::FilmFrame;
use crate::system::System;
use crate::trace::{Bundle, ReflectedTracer, Tracer, Travel};

/// The fewest and the most rays along the beam's width by which the part of the beam that gets through is found.
const SEARCH: [usize; 2] = [24, 256];
/// Rays of the search on the narrowest part that is to be found.
const ON_PART: f64 = 6.0;
/// Margin about a known window, parts of its width, within which the window of a beam like it is looked for.
const NEAR: f64 = 0.2;
/// Points along a side at which the power is known, and by how much it may be off at places between them (parts of the window) for these
/// to be enough. Rays with the power of each surface take most of a ghost's time.
const POWER_SIDES: [(usize, f64); 3] = [(4, 0.01), (7, 0.03), (13, 0.05)];
/// Points along a side of a weak ghost: as few as a parabola needs.
const COARSE_POWER_SIDE: usize = 3;
/// Points along a side where those are too few.
const FINE_POWER_SIDE: usize = 33;
/// Halvings by which the edge of a ghost is found: to a hundredth of a cell, and coarsely to a tenth.
const HALVINGS: usize = 5;
const COARSE_HALVINGS: usize = 2;
const PROBES: [DVec2; 6] = [
    DVec2::new(0.25, 0.25),
    DVec2::new(0.72, 0.28),
    DVec2::new(0.28, 0.74),
    DVec2::new(0.75, 0.75),
    DVec2::new(0.5, 0.42),
    DVec2::new(0.58, 0.09),
];

/// The rays by which a ghost is traced.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// The part of the beam that is traced.
    pub window: &'a Window,
    /// Number of cells along each side of the window.
    pub side: usize,
    /// True for a weak ghost: its edge and its power are found by few rays.
    pub is_coarse: bool,
}

/// A piece of a ghost on the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// A triangle (u, v), mm from the picture's middle; of no size where only its place is known.
    pub corners: [DVec2; 3],
    /// The light on the piece for one of irradiance in the middle of the beam's disc, mm².
    pub light_mm2: f64,
}

/// The part of a beam that gets along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Low corner, in radii of the beam's disc.
    pub low: DVec2,
    /// High corner, in radii of the beam's disc.
    pub high: DVec2,
    /// Bounds of the ghost of that part on the film: low and high corner, mm.
    pub film: [DVec2; 2],
    /// The light that gets to the film's plane were nothing lost by reflection, mm² as in [`Piece::light_mm2`].
    pub open_mm2: f64,
}

impl Window {
    /// The window with a margin of that part of its width on each side, within the beam's disc.
    #[must_use]
    pub fn widened(&self, part: f64) -> Self {
        let margin = part * (self.high - self.low);
        let (low, high) = ((self.low - margin).max(DVec2::NEG_ONE), (self.high + margin).min(DVec2::ONE));
        Self { low, high, ..*self }
    }
}

/// One path at one wavelength, ready for beams.
pub struct GhostTracer {
    exact: ReflectedTracer,
    /// The tracer without rims: power is known beyond them too.
    open: ReflectedTracer,
    single: Tracer<f32>,
}

impl GhostTracer {
    /// The path of that lens that turns round at these surfaces; `None` if there is none.
    pub fn new(tracer: &Tracer, turns: &[usize]) -> Option<Self> {
        let exact = tracer.reflected(turns)?;
        let open = tracer.without_rims().reflected(turns)?;
        let single = exact.tracer().cast::<f32>();
        Some(Self { exact, open, single })
    }

    /// The path through the lens with its rims.
    pub fn path(&self) -> &ReflectedTracer {
        &self.exact
    }

    /// An empty bundle for [`Self::window`] and [`Self::pieces`].
    pub fn bundle(&self) -> Bundle<f32> {
        self.single.bundle(Travel::FromScene)
    }

    /// The path as if the lens had no rims.
    pub fn open_path(&self) -> &ReflectedTracer {
        &self.open
    }

    /// The part of a beam that gets to the film; `None` if none was found. The search finds parts at least `part` of the beam's width wide:
    /// about as wide as the entrance pupil.
    pub fn window(&self, beam: &Beam, film: &FilmFrame, part: f64, bundle: &mut Bundle<f32>) -> Option<Window> {
        let whole = [DVec2::splat(-1.0), DVec2::splat(1.0)];
        let rays = (ON_PART / part.max(1e-3)).ceil() as usize;
        let found = self.search(beam, film, whole, rays.clamp(SEARCH[0], SEARCH[1]), bundle)?;
        // A small part is looked at again.
        let is_small = (found.high - found.low).max_element() < 0.5;
        let again = if is_small { self.search(beam, film, [found.low, found.high], SEARCH[0], bundle) } else { None };
        Some(again.unwrap_or(found))
    }

    /// The window of a beam whose window is about a known one: at a near wavelength, or from a place close by. As [`Self::window`], at a
    /// fraction of its cost.
    pub fn window_near(
        &self,
        beam: &Beam,
        film: &FilmFrame,
        (known, part): (&Window, f64),
        bundle: &mut Bundle<f32>,
    ) -> Option<Window> {
        let Window { low, high, .. } = known.widened(NEAR);
        let is_inside = |found: &Window| {
            let low_is_in = found.low.cmpgt(low) | found.low.cmple(DVec2::NEG_ONE);
            (low_is_in & (found.high.cmplt(high) | found.high.cmpge(DVec2::ONE))).all()
        };
        let near = self.search(beam, film, [low, high], SEARCH[0], bundle).filter(is_inside);
        near.or_else(|| self.window(beam, film, part, bundle))
    }

    fn search(
        &self,
        beam: &Beam,
        film: &FilmFrame,
        [low, high]: [DVec2; 2],
        side: usize,
        bundle: &mut Bundle<f32>,
    ) -> Option<Window> {
        let step = (high - low) / (side - 1) as f64;
        let place = |i: usize| low + step * DVec2::new((i % side) as f64, (i / side) as f64);
        let places = trace(&self.single, beam, film, (0..side * side).map(place), bundle);
        let mut found: Option<Window> = None;
        for (i, hit) in places.iter().enumerate() {
            let Some(hit) = *hit else { continue };
            let at = place(i);
            let light = beam.light_mm2(at) * step.x * step.y;
            found = Some(match found {
                None => Window { low: at, high: at, film: [hit, hit], open_mm2: light },
                Some(w) => Window {
                    low: w.low.min(at),
                    high: w.high.max(at),
                    film: [w.film[0].min(hit), w.film[1].max(hit)],
                    open_mm2: w.open_mm2 + light,
                },
            });
        }
        let w = found?;
        Some(Window { low: (w.low - step).max(low), high: (w.high + step).min(high), ..w })
    }

    /// Calls `each` with the pieces of a ghost.
    pub fn pieces(
        &self,
        system: &System,
        (beam, film): (&Beam, &FilmFrame),
        Grid { window, side, is_coarse }: Grid<'_>,
        bundle: &mut Bundle<f32>,
        each: &mut impl FnMut(Piece),
    ) {
        let power = self.power(system, beam, window, is_coarse);
        let step = (window.high - window.low) / side as f64;
        let place = |x: f64, y: f64| window.low + step * DVec2::new(x, y);
        let row = side + 1;
        let corners = (0..row * row).map(|i| place((i % row) as f64, (i / row) as f64));
        let hits = trace(&self.single, beam, film, corners, bundle);
        let mut on_edge = Vec::new();
        for i in 0..side * side {
            let (x, y) = (i % side, i / side);
            let first = y * row + x;
            let corners = [hits[first], hits[first + 1], hits[first + row + 1], hits[first + row]];
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                let at = place(x as f64, y as f64);
                let middle = at + 0.5 * step;
                let light_mm2 = 0.5 * beam.light_mm2(middle) * step.x * step.y * power.at(middle);
                each(Piece { corners: [a, b, c], light_mm2 });
                each(Piece { corners: [a, c, d], light_mm2 });
            } else if corners.iter().any(Option::is_some) {
                on_edge.push([x as f64, y as f64]);
            }
        }
        let on_edge: Vec<DVec2> = on_edge.iter().map(|at| place(at[0], at[1])).collect();
        let halvings = if is_coarse { COARSE_HALVINGS } else { HALVINGS };
        let edges = Edges::find(&on_edge, step, halvings, |points| {
            trace(&self.single, beam, film, points.iter().copied(), bundle)
        });
        edges.polygons(&mut |polygon| {
            for i in 2..polygon.len() {
                let [a, b, c] = [polygon[0], polygon[i - 1], polygon[i]];
                let middle = (a.at + b.at + c.at) / 3.0;
                let area = 0.5 * (b.at - a.at).perp_dot(c.at - a.at).abs();
                let light_mm2 = beam.light_mm2(middle) * area * power.at(middle);
                each(Piece { corners: [a.film, b.film, c.film], light_mm2 });
            }
        });
    }

    /// The part of the power that gets along the path, over a window.
    fn power(&self, system: &System, beam: &Beam, window: &Window, is_coarse: bool) -> Power {
        let exact = |at: DVec2| power::along(system, &self.open, beam.ray(at)).map(|found| found.1);
        if is_coarse {
            return Power::new(window, COARSE_POWER_SIDE, exact);
        }
        let size = window.high - window.low;
        let probes = PROBES.map(|probe| window.low + size * probe);
        let known = probes.map(exact);
        for (side, tolerance) in POWER_SIDES {
            let even = Power::new(window, side, exact);
            let is_near = |(at, power): (&DVec2, &Option<f64>)| {
                power.is_none_or(|power| (even.at(*at) - power).abs() <= tolerance * power.max(even.mean()))
            };
            if probes.iter().zip(&known).all(is_near) {
                return even;
            }
        }
        // Where light begins to be reflected as a whole nothing is smooth.
        Power::new(window, FINE_POWER_SIDE, exact)
    }
}

/// Traces rays through points of the disc to the film.
fn trace(
    tracer: &Tracer<f32>,
    beam: &Beam,
    film: &FilmFrame,
    points: impl Iterator<Item = DVec2>,
    bundle: &mut Bundle<f32>,
) -> Vec<Option<DVec2>> {
    bundle.clear();
    points.for_each(|at| bundle.push(beam.ray(at)));
    tracer.trace(bundle);
    let hit = |i: usize| bundle.result(i).ok().and_then(|ray| film.meet(&ray)).map(DVec2::from);
    (0..bundle.len()).map(hit).collect()
}

/// The part of the power that gets along a path, on a lattice of nodes over a window and interpolated between them.
struct Power {
    low: DVec2,
    per_radius: DVec2,
    side: usize,
    nodes: Vec<f64>,
}

impl Power {
    fn new(window: &Window, side: usize, exact: impl Fn(DVec2) -> Option<f64>) -> Self {
        let size = window.high - window.low;
        let last = (side - 1) as f64;
        let place = |i: usize| DVec2::new((i % side) as f64, (i / side) as f64);
        let known: Vec<Option<f64>> = (0..side * side).map(|i| exact(window.low + size * place(i) / last)).collect();
        // Where not even a lens without rims has a ray, the nearest counts.
        let nearest = |i: usize| {
            let far = |k: &usize| place(*k).distance_squared(place(i));
            let near = (0..known.len()).filter(|k| known[*k].is_some()).min_by(|a, b| far(a).total_cmp(&far(b)));
            near.and_then(|k| known[k]).unwrap_or(0.0)
        };
        let nodes = (0..known.len()).map(|i| known[i].unwrap_or_else(|| nearest(i))).collect();
        Self { low: window.low, per_radius: last / size, side, nodes }
    }

    fn mean(&self) -> f64 {
        self.nodes.iter().sum::<f64>() / self.nodes.len() as f64
    }

    /// The power at a point, by Catmull and Rom's cubics, which are exact for parabolas: straight lines would count too much, for the
    /// reflectance of a coating grows with the square of the angle. At the ends a row goes on as a parabola.
    fn at(&self, at: DVec2) -> f64 {
        let last = (self.side - 1) as f64;
        let place = ((at - self.low) * self.per_radius).clamp(DVec2::ZERO, DVec2::splat(last));
        let cell = place.min(DVec2::splat(last - 1e-9)).floor();
        let [x, y] = (place - cell).to_array();
        let (column, row) = (cell.x as usize, cell.y as usize);
        let in_row = |row: usize| cubic(self.side, column, x, |i| self.nodes[row * self.side + i]);
        cubic(self.side, row, y, in_row).max(0.0)
    }
}

/// The cubic interpolation of `side` nodes, between node `cell` and the next at the part `t` of the way.
fn cubic(side: usize, cell: usize, t: f64, node: impl Fn(usize) -> f64) -> f64 {
    let (b, c) = (node(cell), node(cell + 1));
    // Beyond the ends as a parabola through the last three.
    let a = if cell == 0 { 3.0 * b - 3.0 * c + node(2) } else { node(cell - 1) };
    let d = if cell + 2 < side { node(cell + 2) } else { 3.0 * c - 3.0 * b + node(side - 3) };
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

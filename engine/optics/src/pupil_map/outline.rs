//! Finds the outline of the clear pupil by tracing.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::trace::{Ray, Tracer, Travel};

use super::ellipse::{Ellipse, conjugate_rotate};

/// Corners of an outline. More follow the tips of a cat's eye closer and take longer to trace.
pub(super) const ANGLES: usize = 96;
/// The outline is traced to this part of its radius.
const PRECISION: f64 = 1e-3;
/// Points across the rear glass that are tried where no light was found near its last place.
const SCAN: usize = 1024;
/// Rows and columns of points that are tried where the pupil need not lie on the meridian.
const SCAN_ACROSS: usize = 64;

/// Radii of the clear pupil about the centre of its ellipse and in units of it, at equal angles.
#[derive(Clone, Debug)]
pub(super) struct PupilOutline {
    pub(super) outer: [f64; ANGLES],
    pub(super) inner: [f64; ANGLES],
}

impl PupilOutline {
    /// Grows the outline until it holds `other`.
    pub(super) fn join(&mut self, other: &Self) {
        for i in 0..ANGLES {
            self.outer[i] = self.outer[i].max(other.outer[i]);
            self.inner[i] = self.inner[i].min(other.inner[i]);
        }
    }
}

/// A test, by tracers, of the targets that are clear.
pub(super) struct TargetProbe {
    /// Tracers without obstructions and masks: the pupil's hole is found apart, and the outline of a mask's circle
    /// holds all of its openings.
    open: Vec<Tracer>,
    /// Tracers with their obstructions, if there are any.
    obstructed: Vec<Tracer>,
    reference_z: f64,
    glass_radius: f64,
}

fn passes(tracers: &[Tracer], film: DVec3, target: DVec3) -> bool {
    let towards = target - film;
    let direction = towards / towards.length();
    tracers.iter().any(|t| t.from_film(Ray { origin: film, direction }).is_ok())
}

impl TargetProbe {
    pub(super) fn new(tracers: &[Tracer], reference_z: f64, glass_radius: f64) -> Self {
        let is_obstructed = tracers.iter().any(Tracer::has_obstructions);
        Self {
            open: tracers.iter().map(|t| t.without_obstructions().without_mask()).collect(),
            obstructed: if is_obstructed { tracers.iter().map(Tracer::without_mask).collect() } else { Vec::new() },
            reference_z,
            glass_radius,
        }
    }

    fn is_open(&self, film: DVec3, target: DVec2) -> bool {
        passes(&self.open, film, target.extend(self.reference_z))
    }

    /// The middle of the clear pupil and its chords through there, for film points at (radius, azimuth) and `film_z`,
    /// each near the one before. `None` where no light arrives.
    ///
    /// For a lens that is symmetric about its axis the middle lies on the meridian; else it `is_sought_across`, too.
    pub(super) fn ellipses(
        &self,
        film_z: f64,
        films: impl Iterator<Item = (f64, f64)>,
        is_sought_across: bool,
    ) -> Vec<Option<Ellipse>> {
        let mut last: Option<Ellipse> = None;
        let mut drift = DVec2::ZERO;
        films
            .map(|(radius, azimuth)| {
                let meridian = DVec2::from_angle(azimuth);
                let film = (meridian * radius).extend(film_z);
                let is_clear = |v: DVec2| self.is_open(film, meridian.rotate(v));
                let guess = last.map_or(DVec2::ZERO, |ellipse| ellipse.centre + drift);
                let width = last.map_or(self.glass_radius, |ellipse| 2.0 * ellipse.semi_axes.max_element());
                let start = self.clear_point(guess, width, is_sought_across, is_clear)?;
                let (mut centre, mut along) = self.middle(start, DVec2::X, width, is_clear);
                let across = if is_sought_across {
                    for axis in [DVec2::Y, DVec2::X, DVec2::Y] {
                        (centre, _) = self.middle(centre, axis, width, is_clear);
                    }
                    // The ellipse has its axes along the lens's.
                    let half = |axis| self.middle(centre, conjugate_rotate(meridian, axis), width, is_clear).1;
                    along = half(DVec2::X);
                    half(DVec2::Y)
                } else {
                    self.edge(centre, DVec2::Y, width, is_clear)
                };
                drift = last.map_or(DVec2::ZERO, |before| centre - before.centre);
                // A pupil thinner than that would make numbers without end.
                let thinnest = 1e-6 * self.glass_radius;
                let ellipse = Ellipse { centre, semi_axes: DVec2::new(along, across).max(DVec2::splat(thinnest)) };
                last = Some(ellipse);
                last
            })
            .collect()
    }

    /// A clear point near `guess`, or anywhere, on the meridian or, if it is sought across, too, beside it.
    fn clear_point(
        &self,
        guess: DVec2,
        width: f64,
        is_sought_across: bool,
        is_clear: impl Fn(DVec2) -> bool,
    ) -> Option<DVec2> {
        let glass = self.glass_radius;
        let near = (0..=32).map(|i| guess + DVec2::X * (width * alternating(i) / 16.0));
        let along = (0..=SCAN).flat_map(|i| {
            let x = guess.x.clamp(-glass, glass) + 2.0 * glass / SCAN as f64 * alternating(i);
            [x, x - x.signum() * 2.0 * glass].map(|x| DVec2::new(x, guess.y))
        });
        let rows = if is_sought_across { SCAN_ACROSS } else { 0 };
        let across = (0..rows * rows).map(|i| {
            let place = |i: usize| glass * ((2 * i + 1) as f64 / rows as f64 - 1.0);
            DVec2::new(place(i % rows), place(i / rows))
        });
        near.chain(along).chain(across).find(|&v| is_clear(v))
    }

    /// The middle of the clear part of the line through the clear point `start` along `axis`, and half its length.
    fn middle(&self, start: DVec2, axis: DVec2, width: f64, is_clear: impl Fn(DVec2) -> bool + Copy) -> (DVec2, f64) {
        let (low, high) = (-self.edge(start, -axis, width, is_clear), self.edge(start, axis, width, is_clear));
        (start + axis * (0.5 * (low + high)), 0.5 * (high - low))
    }

    /// Distance from `start` towards `axis` up to which it is clear.
    fn edge(&self, start: DVec2, axis: DVec2, width: f64, is_clear: impl Fn(DVec2) -> bool) -> f64 {
        let is_clear = |x: f64| is_clear(start + axis * x);
        let mut clear = 0.0;
        let mut step = width * 1e-3;
        while is_clear(clear + step) && clear < 4.0 * self.glass_radius {
            clear += step;
            step *= 2.0;
        }
        bisect(clear, clear + step, PRECISION * step, is_clear).0
    }

    /// The outlines at `places`, all edges searched at once: every step of the search is one bundle of rays.
    ///
    /// `is_symmetric` spares the half below the meridian; `hints` are the outlines of neighbours.
    pub(super) fn outlines(
        &self,
        places: &[FilmPlace],
        is_symmetric: bool,
        hints: &[Option<PupilOutline>],
    ) -> Vec<PupilOutline> {
        let angles = if is_symmetric { ANGLES / 2 + 1 } else { ANGLES };
        let mut edges: Vec<OutlineEdge> = Vec::with_capacity(places.len() * angles);
        for (place, hint) in places.iter().zip(hints) {
            for i in 0..angles {
                let guess = hint.as_ref().map_or(1.0, |hint| hint.outer[i]);
                edges.push(OutlineEdge::new(place, i, guess, 2.0 * self.glass_radius));
            }
        }
        let mut asked: Vec<usize> = (0..edges.len()).collect();
        while !asked.is_empty() {
            let targets: Vec<Target> = asked.iter().map(|&i| edges[i].target(edges[i].asks())).collect();
            for (&i, is_clear) in asked.iter().zip(are_clear(&self.open, self.reference_z, &targets)) {
                edges[i].hear(is_clear);
            }
            asked.retain(|&i| !edges[i].is_found());
        }
        let holes = self.holes(&edges);
        let outline = |place: usize| {
            let at = |i: usize| place * angles + if i < angles { i } else { ANGLES - i };
            PupilOutline {
                outer: std::array::from_fn(|i| edges[at(i)].high),
                inner: std::array::from_fn(|i| holes[at(i)]),
            }
        };
        (0..places.len()).map(outline).collect()
    }

    /// Distances from the centre that an obstruction reaches towards each edge.
    fn holes(&self, edges: &[OutlineEdge]) -> Vec<f64> {
        const STEPS: i32 = 64;
        if self.obstructed.is_empty() {
            return vec![0.0; edges.len()];
        }
        let place = |edge: &OutlineEdge, i: i32| edge.high * f64::from(i) / f64::from(STEPS);
        let hole = |edge: &OutlineEdge| {
            let targets: Vec<Target> = (0..=STEPS).map(|i| edge.target(place(edge, i))).collect();
            let is_clear = are_clear(&self.obstructed, self.reference_z, &targets);
            match (0..=STEPS).find(|&i| is_clear[i as usize]) {
                None => edge.high,
                Some(0) => 0.0,
                Some(i) => {
                    let is_dark = |x: f64| {
                        let Target { film, at } = edge.target(x);
                        !passes(&self.obstructed, film, at.extend(self.reference_z))
                    };
                    bisect(place(edge, i - 1), place(edge, i), PRECISION * edge.high, is_dark).0
                }
            }
        };
        edges.iter().map(hole).collect()
    }
}

/// A film point and a point of the reference plane that it may see light through.
struct Target {
    film: DVec3,
    at: DVec2,
}

/// True for the targets that any tracer finds clear.
fn are_clear(tracers: &[Tracer], reference_z: f64, targets: &[Target]) -> Vec<bool> {
    let mut is_clear = vec![false; targets.len()];
    let mut rest: Vec<usize> = (0..targets.len()).collect();
    for tracer in tracers {
        let mut bundle = tracer.bundle(Travel::FromFilm);
        for &i in &rest {
            let Target { film, at } = targets[i];
            let direction = (at.extend(reference_z) - film).normalize();
            bundle.push(Ray { origin: film, direction });
        }
        tracer.trace(&mut bundle);
        rest.iter().enumerate().for_each(|(place, &i)| is_clear[i] = bundle.is_through(place));
        rest.retain(|&i| !is_clear[i]);
    }
    is_clear
}

/// A film point for which an outline is taken, and its ellipse.
pub(super) struct FilmPlace {
    film: DVec3,
    ellipse: Ellipse,
    meridian: DVec2,
    axes: DVec2,
}

impl FilmPlace {
    /// The film point, the ellipse in units of which the outline is told, and the directions that it is told in.
    pub(super) fn new(film: DVec3, ellipse: Ellipse, meridian: DVec2, axes: DVec2) -> Self {
        Self { film, ellipse, meridian, axes }
    }

    fn in_mm(&self, point: DVec2) -> DVec2 {
        self.ellipse.in_mm(point, self.meridian, self.axes)
    }
}

/// The outline along one direction, as far as it is narrowed down: clear at `low`, not at `high`.
struct OutlineEdge {
    film: DVec3,
    centre: DVec2,
    /// One unit of the ellipse, mm.
    along: DVec2,
    low: f64,
    high: f64,
    limit: f64,
    search: SearchStep,
}

/// The next test of a search.
enum SearchStep {
    /// Tests whether `high` is clear: then the edge lies farther out.
    Out,
    /// Tests just below: a good guess is narrowed at once.
    Below,
    /// Tests the middle of [low, high]; `steps` counts such tests.
    Halve { steps: u32 },
}

impl OutlineEdge {
    fn new(place: &FilmPlace, i: usize, guess: f64, limit_mm: f64) -> Self {
        let centre = place.in_mm(DVec2::ZERO);
        let along = place.in_mm(DVec2::from_angle(i as f64 * TAU / ANGLES as f64)) - centre;
        let limit = limit_mm / along.length();
        let high = guess.max(1e-9 * limit) * 1.02;
        let mut edge = Self { film: place.film, centre, along, low: 0.0, high, limit, search: SearchStep::Out };
        if high >= limit {
            edge.search = SearchStep::Below;
        }
        edge
    }

    fn target(&self, x: f64) -> Target {
        Target { film: self.film, at: self.centre + self.along * x }
    }

    fn asks(&self) -> f64 {
        match self.search {
            SearchStep::Out => self.high,
            SearchStep::Below => self.high * 0.96,
            SearchStep::Halve { .. } => 0.5 * (self.low + self.high),
        }
    }

    fn hear(&mut self, is_clear: bool) {
        let asked = self.asks();
        let halve = SearchStep::Halve { steps: 0 };
        match &mut self.search {
            SearchStep::Out if is_clear => {
                (self.low, self.high) = (asked, asked * 1.25);
                if self.high >= self.limit {
                    self.search = halve;
                }
            }
            SearchStep::Out => self.search = if self.low == 0.0 { SearchStep::Below } else { halve },
            SearchStep::Below => {
                *(if is_clear { &mut self.low } else { &mut self.high }) = asked;
                self.search = halve;
            }
            SearchStep::Halve { steps } => {
                *steps += 1;
                *(if is_clear { &mut self.low } else { &mut self.high }) = asked;
            }
        }
    }

    fn is_found(&self) -> bool {
        let is_narrow = self.high - self.low <= PRECISION * self.high;
        matches!(self.search, SearchStep::Halve { steps } if is_narrow || steps >= 60)
    }
}

/// 0, 1, −1, 2, −2, ...
fn alternating(i: usize) -> f64 {
    let half = i.div_ceil(2) as f64;
    if i % 2 == 1 { half } else { -half }
}

/// Narrows [low, high], where `holds` at low and not at high, to `precision`; for a high end of at most the precision
/// above 0 it goes on until the ends agree in size.
fn bisect(mut low: f64, mut high: f64, precision: f64, holds: impl Fn(f64) -> bool) -> (f64, f64) {
    let mut steps = 0;
    while high - low > precision && steps < 60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
        steps += 1;
    }
    (low, high)
}

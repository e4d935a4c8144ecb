//! The target of rays from a point of the film, so that nearly every ray gets through the lens.
//!
//! Rays are aimed at the reference plane, which touches the vertex of the last surface: it lies between film and glass
//! for every lens, wherever the exit pupil is, at infinity or behind the film. Seen from a film point the clear pupil
//! is star-shaped about a centre for nearly every lens (a disc, a cat's eye, a polygon). The map holds that outline,
//! and the inner one of an obstruction, by distance of the film point from the axis, by the film's z where it is turned,
//! and by azimuth where the diaphragm has blades or the lens itself is not symmetric about its axis. Cells of film
//! points share an outline in units of an ellipse that each film point has for itself: the only difference within a
//! cell is the shape. A small share of the samples covers the whole rear glass, so that nothing is lost where the
//! outline errs.
//!
//! Sampling is rejection-free and its density exact, whatever the outline is: an error of the map costs noise, never
//! bias.

mod aims;
mod axis;
#[cfg(test)]
mod cases;
mod cell;
mod ellipse;
mod lanes;
mod outline;
mod throughput;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::focus::FilmPlane;
use crate::system::System;
use crate::trace::Tracer;

use aims::CellSectors;
pub use aims::PupilSamples;
use axis::CellAxis;
use cell::Cell;
use ellipse::{Ellipse, carried_on, conjugate_rotate, midway};
use lanes::Spot;
use outline::{FilmPlace, PupilOutline, TargetProbe};

pub use throughput::{on_axis_throughput, on_axis_throughput_without_obstructions, unobstructed_part};

/// Part of the samples that covers the whole rear glass. Larger wastes rays; smaller makes light that the outline
/// misses noisier.
const DEFENSIVE_SHARE: f64 = 0.005;

/// A point of the reference plane to aim at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilSample {
    /// The point in lens space, mm.
    pub target: DVec3,
    /// Density with which the sample was chosen, per mm² of the reference plane.
    pub pdf_per_mm2: f64,
}

/// The clear pupil as seen from every point of a film.
#[derive(Clone, Debug)]
pub struct PupilMap {
    reference_z: f64,
    /// Radius of the disc on the reference plane through which every ray to the rear glass passes.
    glass_radius: f64,
    /// One over the disc's area, per mm².
    glass_density: f64,
    radius: CellAxis,
    depth: CellAxis,
    azimuth: CellAxis,
    /// Turn after which the lens looks the same; 0 if any turn leaves it so.
    period: f64,
    /// Cosine and sine of the multiples of the period.
    frames: Vec<DVec2>,
    /// True if the film stands upright and any turn leaves the lens as it is: only the distance from the axis counts.
    is_plain: bool,
    /// Ellipses about the outline, by node of depth, azimuth and radius; by depth and radius if only the blades know of an azimuth.
    ellipses: Vec<Ellipse>,
    ellipses_by_azimuth: bool,
    /// Cells by depth, azimuth and radius.
    cells: Vec<Cell>,
    /// Spots by radius, if nothing else counts.
    spots: Vec<Spot>,
    slices: Vec<CellSectors>,
}

/// A film point and the cell that it lies in.
struct Located<'a> {
    cell: &'a Cell,
    ellipse: Ellipse,
    /// Cosine and sine of the turn of the cell's axes.
    frame: DVec2,
    /// Cosine and sine of the angle of the film point's meridian in the cell's axes.
    meridian: DVec2,
    /// Cosine and sine of the angle of the ellipse's axes in the cell's axes.
    axes: DVec2,
}

impl Located<'_> {
    /// Density of samples in the outline, per mm²; 0 if no light arrives.
    #[inline]
    fn density(&self) -> f64 {
        self.cell.density() / self.ellipse.gain()
    }

    /// The point of the reference plane, in mm, from the cell's units.
    #[inline]
    fn to_plane(&self, point: DVec2) -> DVec2 {
        self.frame.rotate(self.ellipse.in_mm(point, self.meridian, self.axes))
    }

    /// The inverse of [`Self::to_plane`].
    #[inline]
    fn in_cell(&self, flat: DVec2) -> DVec2 {
        self.ellipse.in_units(conjugate_rotate(self.frame, flat), self.meridian, self.axes)
    }
}

/// The numbers of nodes of the map.
struct Resolution {
    radius: usize,
    depth: usize,
    azimuth: usize,
}

impl Resolution {
    /// Finer cells waste fewer samples at the edges of the outline, and take longer to make.
    fn choose(film: &FilmPlane, has_blades: bool, is_symmetric: bool) -> Self {
        if !is_symmetric {
            let depth = if film.is_uneven() { 3 } else { 1 };
            return Self { radius: 12, depth, azimuth: 16 };
        }
        match (film.is_uneven(), has_blades) {
            (false, false) => Self { radius: 32, depth: 1, azimuth: 1 },
            (true, false) => Self { radius: 32, depth: 8, azimuth: 1 },
            (false, true) => Self { radius: 24, depth: 1, azimuth: 6 },
            (true, true) => Self { radius: 12, depth: 4, azimuth: 4 },
        }
    }
}

impl PupilMap {
    /// The map of `tracer`'s wavelength for the part of `film` within `half_width_mm` and `half_height_mm` of the
    /// middle of the picture. Points outside of it may be asked for, too; they cost more lost rays.
    pub fn new(tracer: &Tracer, system: &System, film: &FilmPlane, half_width_mm: f64, half_height_mm: f64) -> Self {
        Self::for_tracers(std::slice::from_ref(tracer), system, film, half_width_mm, half_height_mm)
    }

    /// The map that covers the pupils of all `tracers`: one for a whole spectrum from its ends and middle.
    pub fn for_tracers(
        tracers: &[Tracer],
        system: &System,
        film: &FilmPlane,
        half_width_mm: f64,
        half_height_mm: f64,
    ) -> Self {
        let blades = system.diaphragm().blades();
        let is_symmetric = system.is_rotationally_symmetric();
        let resolution = Resolution::choose(film, blades > 0, is_symmetric);
        let signs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
        let corners = signs.map(|(a, b)| film.point(a * half_width_mm, b * half_height_mm));
        let farthest = corners.iter().fold(0.0f64, |r, p| r.max(p.truncate().length()));
        let depths = corners.iter().map(|p| p.z).chain([film.point(0.0, 0.0).z]);
        let (near, far) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
        let period = match (is_symmetric, blades) {
            (false, _) => TAU,
            (true, 0) => 0.0,
            (true, blades) => TAU / f64::from(blades),
        };
        let reference_z = system.last_vertex_z_mm();
        let turns = if period > 0.0 { (TAU / period).round() as u32 } else { 0 };
        let glass_radius = glass_radius(system, farthest, near, far);
        let mut map = Self {
            reference_z,
            glass_radius,
            glass_density: (PI * glass_radius * glass_radius).recip(),
            radius: CellAxis::new(0.0, farthest, resolution.radius),
            depth: CellAxis::new(near, far, resolution.depth),
            azimuth: CellAxis::new(0.0, period, resolution.azimuth),
            period,
            frames: (0..turns).map(|i| DVec2::from_angle(f64::from(i) * period)).collect(),
            is_plain: period == 0.0 && near == far,
            ellipses: Vec::new(),
            ellipses_by_azimuth: !is_symmetric,
            cells: Vec::new(),
            spots: Vec::new(),
            slices: Vec::new(),
        };
        map.fill(&TargetProbe::new(tracers, reference_z, glass_radius));
        if map.is_plain {
            map.spots =
                (0..map.radius.cells).map(|r| Spot::new(&map.cells[r], map.ellipses[r], map.ellipses[r + 1])).collect();
            map.slices = map.cells.iter().map(CellSectors::new).collect();
        }
        map
    }

    /// Traces the outlines at the nodes of the table, twice as many as cells, and joins them cell by cell.
    fn fill(&mut self, probe: &TargetProbe) {
        let (nr, nz, na) = (2 * self.radius.cells + 1, self.depth.cells + 1, 2 * self.azimuth.cells + 1);
        let na = if self.period > 0.0 { na } else { 1 };
        // A film at right angles has one depth: its second node would repeat the first.
        let nz = if self.depth.cells_per_unit > 0.0 { nz } else { 1 };
        let mut outlines: Vec<Option<PupilOutline>> = Vec::with_capacity(nz * na * nr);
        for z in 0..nz {
            let film_z = self.depth.at(z as f64);
            // By node of azimuth and of radius, of the coarse grid; whether light arrives there, of the fine one.
            let mut ellipses: Vec<Vec<Ellipse>> = Vec::new();
            let mut found: Vec<Vec<bool>> = Vec::new();
            let films = |azimuth: f64| (0..nr).map(move |r| (r as f64 / 2.0, azimuth));
            for a in 0..if self.ellipses_by_azimuth { na } else { 1 } {
                let azimuth = self.azimuth.at(a as f64 / 2.0);
                let films = films(azimuth).map(|(r, azimuth)| (self.radius.at(r), azimuth));
                let row: Vec<Option<Ellipse>> = probe.ellipses(film_z, films, self.ellipses_by_azimuth);
                found.push(row.iter().map(Option::is_some).collect());
                ellipses.push(carried_on(&row, Ellipse::circle(self.glass_radius)));
            }
            // From the middle outwards, all azimuths together: each outline is the next one's first guess.
            let mut rows: Vec<Vec<Option<PupilOutline>>> = vec![Vec::with_capacity(nr); na];
            let mut last: Vec<Option<PupilOutline>> = vec![None; na];
            for r in 0..nr {
                let row = |a: usize| if self.ellipses_by_azimuth { a } else { 0 };
                let lit: Vec<usize> = (0..na).filter(|&a| found[row(a)][r]).collect();
                let place = |&a: &usize| {
                    let meridian = DVec2::from_angle(self.azimuth.at(a as f64 / 2.0));
                    let film = (meridian * self.radius.at(r as f64 / 2.0)).extend(film_z);
                    // Between its even nodes the map interpolates: the outline is taken about that same ellipse.
                    FilmPlace::new(film, midway(&ellipses, row(a), r), meridian, self.axes(meridian))
                };
                let places: Vec<FilmPlace> = lit.iter().map(place).collect();
                let hints: Vec<Option<PupilOutline>> = lit.iter().map(|&a| last[a].clone()).collect();
                rows.iter_mut().for_each(|row| row.push(None));
                for (&a, outline) in lit.iter().zip(probe.outlines(&places, self.period == 0.0, &hints)) {
                    last[a] = Some(outline.clone());
                    rows[a][r] = Some(outline);
                }
            }
            outlines.extend(rows.into_iter().flatten());
            self.ellipses.extend(ellipses.iter().step_by(2).flat_map(|row| row.iter().step_by(2)));
        }
        self.join(&outlines, [nz, na, nr]);
    }

    fn join(&mut self, outlines: &[Option<PupilOutline>], [nz, na, nr]: [usize; 3]) {
        let span = |cell: usize, nodes: usize| if nodes == 1 { 0..=0 } else { cell..=cell + 1 };
        let fine = |cell: usize, nodes: usize| if nodes == 1 { 0..=0 } else { 2 * cell..=2 * cell + 2 };
        for z in 0..self.depth.cells {
            for a in 0..self.azimuth.cells {
                for r in 0..self.radius.cells {
                    let mut union: Option<PupilOutline> = None;
                    for (z, a) in span(z, nz).flat_map(|z| fine(a, na).map(move |a| (z, a))) {
                        for r in fine(r, nr) {
                            let Some(outline) = &outlines[(z * na + a) * nr + r] else { continue };
                            union.get_or_insert_with(|| outline.clone()).join(outline);
                        }
                    }
                    self.cells.push(union.map_or_else(Cell::dark, |outline| Cell::new(&outline)));
                }
            }
        }
    }

    /// The z of the reference plane in lens space, mm: the vertex of the last surface.
    pub fn reference_plane_z(&self) -> f64 {
        self.reference_z
    }

    /// Radius in mm of the disc on the reference plane that holds every ray to the rear glass.
    pub fn glass_radius_mm(&self) -> f64 {
        self.glass_radius
    }

    /// Area in mm² of the outline for a film point; 0 where no light arrives.
    pub fn pupil_area_mm2(&self, film_point: DVec3) -> f64 {
        let located = self.locate(film_point);
        located.cell.area() * located.ellipse.gain()
    }

    /// Corners of the outline for a film point, mm in lens space; none where no light arrives.
    pub fn outline_mm(&self, film_point: DVec3) -> impl Iterator<Item = DVec2> + use<'_> {
        let located = self.locate(film_point);
        located.cell.corners().map(move |corner| located.to_plane(corner))
    }

    #[inline]
    fn locate(&self, film_point: DVec3) -> Located<'_> {
        let plane = film_point.truncate();
        let film_radius = plane.length();
        let (r, r_in) = self.radius.locate(film_radius);
        let inverse = film_radius.max(f64::MIN_POSITIVE).recip();
        let along = if film_radius > 0.0 { plane * inverse } else { DVec2::X };
        if self.is_plain {
            let ellipse = self.ellipses[r].lerp(self.ellipses[r + 1], r_in);
            return Located { cell: &self.cells[r], ellipse, frame: along, meridian: DVec2::X, axes: DVec2::X };
        }
        self.locate_anywhere(film_point.z, along, r, r_in)
    }

    /// [`Self::locate`] for a film that is turned, or a pupil that knows of an azimuth.
    #[inline(never)]
    fn locate_anywhere(&self, film_z: f64, along: DVec2, r: usize, r_in: f64) -> Located<'_> {
        let (z, z_in) = self.depth.locate(film_z);
        let (a, a_in, frame, meridian) = if self.period > 0.0 {
            let angle = along.y.atan2(along.x).rem_euclid(TAU);
            let turns = ((angle / self.period) as usize).min(self.frames.len() - 1);
            let frame = self.frames[turns];
            let (a, a_in) = self.azimuth.locate(angle - turns as f64 * self.period);
            (a, a_in, frame, conjugate_rotate(frame, along))
        } else {
            (0, 0.0, along, DVec2::X)
        };
        let nodes = self.radius.cells + 1;
        let row = |row: usize| self.ellipses[row * nodes + r].lerp(self.ellipses[row * nodes + r + 1], r_in);
        let plane = |z: usize| match self.ellipses_by_azimuth {
            true => {
                let first = z * (self.azimuth.cells + 1) + a;
                row(first).lerp(row(first + 1), a_in)
            }
            false => row(z),
        };
        let mut ellipse = plane(z);
        if self.depth.cells_per_unit > 0.0 {
            ellipse = ellipse.lerp(plane(z + 1), z_in);
        }
        let cell = &self.cells[(z * self.azimuth.cells + a) * self.radius.cells + r];
        Located { cell, ellipse, frame, meridian, axes: self.axes(meridian) }
    }

    /// The turn of ellipses for film points on `meridian`. A lens that is not symmetric shows them all much the same pupil.
    fn axes(&self, meridian: DVec2) -> DVec2 {
        if self.ellipses_by_azimuth { DVec2::X } else { meridian }
    }

    /// Chooses a point to aim at from `film_point` (lens space, mm) by two numbers in [0, 1).
    #[inline]
    pub fn sample(&self, film_point: DVec3, [first, second]: [f64; 2]) -> PupilSample {
        let located = self.locate(film_point);
        let cell = located.cell;
        if first < DEFENSIVE_SHARE || cell.density() == 0.0 {
            return self.sample_defensively(&located, [first, second]);
        }
        let local = cell.sample([(first - DEFENSIVE_SHARE) * (1.0 / (1.0 - DEFENSIVE_SHARE)), second]);
        let flat = located.to_plane(local);
        let pdf_per_mm2 = (1.0 - DEFENSIVE_SHARE) * located.density() + DEFENSIVE_SHARE * self.glass_density(flat);
        PupilSample { target: flat.extend(self.reference_z), pdf_per_mm2 }
    }

    /// Anywhere on the glass.
    #[cold]
    fn sample_defensively(&self, located: &Located<'_>, [first, second]: [f64; 2]) -> PupilSample {
        let share = if located.cell.density() > 0.0 { DEFENSIVE_SHARE } else { 1.0 };
        let (sin, cos) = (TAU * second).sin_cos();
        let flat = DVec2::new(cos, sin) * (self.glass_radius * (first / share).min(1.0).sqrt());
        PupilSample { target: flat.extend(self.reference_z), pdf_per_mm2: self.density(located, flat) }
    }

    /// The density per mm² with which [`Self::sample`] chooses `target` (its x and y count) from `film_point`.
    #[inline]
    pub fn pdf(&self, film_point: DVec3, target: DVec3) -> f64 {
        self.density(&self.locate(film_point), target.truncate())
    }

    #[inline]
    fn density(&self, located: &Located<'_>, flat: DVec2) -> f64 {
        let cell = located.cell;
        let anywhere = self.glass_density(flat);
        if cell.density() == 0.0 {
            return anywhere;
        }
        let inside = if cell.contains(located.in_cell(flat)) { located.density() } else { 0.0 };
        (1.0 - DEFENSIVE_SHARE) * inside + DEFENSIVE_SHARE * anywhere
    }

    /// Density of places on the whole glass, per mm².
    #[inline]
    fn glass_density(&self, flat: DVec2) -> f64 {
        let squared = self.glass_radius * self.glass_radius;
        if flat.length_squared() <= squared { self.glass_density } else { 0.0 }
    }
}

/// Radius of the disc on the reference plane that holds every ray from the film to the rear glass.
///
/// A film point at r, a distance d behind the plane, that looks at glass at radius a and sag z crosses the plane
/// within g a + |1 − g| r of the axis, g = d / (d − z).
pub fn glass_radius(system: &System, farthest_mm: f64, near_mm: f64, far_mm: f64) -> f64 {
    // A film inside of a hollow rear surface would need an unbounded disc; larger discs than this are no use.
    const WIDEST: f64 = 20.0;
    let rear = &system.surfaces()[system.surface_count() - 1];
    let semi = rear.semi_diameter_mm;
    let sag = rear.shape.rim_sag_mm(semi).unwrap_or(semi) * system.light_direction_at_film();
    let distance = (near_mm - rear.z_mm).abs().min((far_mm - rear.z_mm).abs());
    let gain = if distance > sag { (distance / (distance - sag)).min(WIDEST) } else { WIDEST };
    semi.max(gain * semi + (1.0 - gain).abs() * farthest_mm)
}

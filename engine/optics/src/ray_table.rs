//! A lens as a table: the rays that leave it into the scene, by where they come from, traced once and then interpolated.
//!
//! The image-based lens of Heidrich, Slusallek and Seidel 1997. A ray before the film is known by where it crosses two
//! planes, the upright one through the middle of the film and the reference plane of the [pupil map](crate::pupil_map)
//! at the last vertex: a light field. Between them it is straight, so a turned film needs no table of its own. For a
//! lens that is symmetric about its axis the table has three dimensions, the film point's distance from the axis and
//! two of the pupil; else four.
//!
//! The table holds rays that the rims would stop, too, so that the interpolated values stay smooth; and for every ray
//! where it crosses the stop and how far inside of the rims it passes, for those rims that ever are the one that stops a
//! ray. So vignetting and blades come out of the same interpolation, without an outline.
//!
//! A ray in front of the lens is its unit direction and its point nearest to the entrance pupil's centre: both stay finite and smooth at 90
//! degrees from the axis and beyond, where two planes do not.
//!
//! The table leaves out other wavelengths than its own, and aberrations finer than its grid. Wide open these are below 0.04 pixels of 1000
//! across (rms) for every shipped lens but the ball, whose rays part without bound towards its rim.

use glam::{DVec2, DVec3, Vec4};

use crate::diaphragm::Diaphragm;
use crate::focus::FilmPlane;
use crate::paraxial::Paraxial;
use crate::pupil_map::PupilMap;
use crate::system::System;
use crate::trace::{Ray, Tracer};
use crate::vector::Vector;

mod grid;
mod window;

use grid::{NodeAxis, Stencil, fill_gaps};
use window::PlaneWindow;

/// Resolution of a table: nodes of each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Nodes from the axis to the farthest film point, of a lens that is symmetric about its axis.
    pub film_radius: usize,
    /// Nodes across and up the film, of a lens that is not symmetric about its axis.
    pub film_side: usize,
    /// Nodes across and up the pupil, as one film point sees it. Fewer than four nodes of any axis count as four.
    pub pupil: usize,
}

impl Default for Grid {
    fn default() -> Self {
        // Wide open, rms and worst error in pixels of 1000 across the field that a lens is for:
        //
        //              figure-3 lens   double Gauss f/1.35   Biotar f/1.4   170 degrees
        //   16 x 16    0.015 0.13      0.048 0.80            0.074 0.40     0.054 0.49
        //   32 x 12    0.047 0.33      0.218 2.60            0.250 3.85     0.166 5.16
        //   24 x 20    0.006 0.06      0.018 0.17            0.031 0.17     0.023 0.20
        //   32 x 24    0.003 0.03      0.009 0.09            0.015 0.09     0.011 0.11
        //   64 x 16    0.015 0.13      0.048 0.80            0.074 0.40     0.054 0.49
        //
        // The pupil's nodes count, the film's hardly. 24 x 20 takes half a megabyte: it stays in the cache.
        Self { film_radius: 24, film_side: 12, pupil: 20 }
    }
}

/// Coordinates of a ray before those of rims: direction, nearest point, place in the stop.
const FIXED: usize = 8;
/// Groups of four numbers that a ray may have; rims beyond are left out, those first that stop the fewest rays.
const MOST_GROUPS: usize = 8;
/// A ray that is so close to a rim, in parts of the square of its radius, may be found on the other side of it.
const NEAR_RIM: f64 = 0.05;

/// The rays of one lens at one wavelength before one film.
#[derive(Clone, Debug)]
pub struct RayTable {
    film_z: f64,
    reference_z: f64,
    is_symmetric: bool,
    /// Distance from the axis and a single node, or across and up.
    film: [NodeAxis; 2],
    /// Nodes of the pupil lie at equal parts of the window that a film point sees it through.
    window: PlaneWindow,
    pupil: usize,
    groups: usize,
    /// The groups of a ray, by film node, pupil row and pupil column.
    rays: Vec<Vec4>,
    diaphragm: Diaphragm,
    /// The entrance pupil's centre on the axis, and from there to the first vertex.
    centre_z: f64,
    radius: f64,
}

impl RayTable {
    /// The table for the part of `film` within `half_width_mm` and `half_height_mm` of the middle of the picture, at a
    /// vacuum wavelength in nm. `map` is that film's, at that wavelength.
    pub fn new(
        system: &System,
        wavelength_nm: f64,
        map: &PupilMap,
        film: &FilmPlane,
        [half_width_mm, half_height_mm]: [f64; 2],
        grid: Grid,
    ) -> Self {
        let reference_z = map.reference_plane_z();
        let extent = Extent::new(map, film, [half_width_mm, half_height_mm]);
        let upright;
        let map = if film.is_uneven() {
            let half = extent.half_sides();
            let tracer = system.at_wavelength(wavelength_nm);
            upright = PupilMap::new(&tracer, system, &FilmPlane::upright(film.z_mm), half.x, half.y);
            &upright
        } else {
            map
        };
        let is_symmetric = system.is_rotationally_symmetric();
        let axes = match is_symmetric {
            true => {
                [NodeAxis::new(0.0, lit_radius(map, film.z_mm, extent.farthest), grid.film_radius), NodeAxis::single()]
            }
            false => [0, 1].map(|i| NodeAxis::new(extent.low[i], extent.high[i], grid.film_side)),
        };
        let centre_z = Paraxial::new(system, wavelength_nm).entrance_pupil.z_mm.filter(|z| {
            // An entrance pupil far away would take the digits.
            z.abs() < 10.0 * system.last_vertex_z_mm().abs().max(system.surfaces()[0].semi_diameter_mm)
        });
        let centre_z = centre_z.unwrap_or(0.0);
        let mut table = Self {
            film_z: film.z_mm,
            reference_z,
            is_symmetric,
            film: axes,
            window: window(map, film.z_mm, &axes, is_symmetric, system.diaphragm().blades() > 0),
            pupil: grid.pupil.max(4),
            groups: 0,
            rays: Vec::new(),
            diaphragm: system.diaphragm().clone(),
            centre_z,
            radius: centre_z,
        };
        table.trace(system, &system.at_wavelength(wavelength_nm).without_rims());
        table
    }

    /// Traces the rays of all nodes.
    fn trace(&mut self, system: &System, tracer: &Tracer) {
        let surfaces = system.surfaces();
        let [first, second] = &self.film;
        let mut hits = Vec::with_capacity(surfaces.len());
        let mut nodes: Vec<Option<Passed>> = Vec::new();
        for (j, i) in (0..second.nodes()).flat_map(|j| (0..first.nodes()).map(move |i| (j, i))) {
            let film = DVec2::new(first.at(i), second.at(j));
            let (low, sides) = self.window.at(film);
            let step = sides / (self.pupil - 1) as f64;
            let film = film.extend(self.film_z);
            for place in 0..self.pupil * self.pupil {
                let target = low + DVec2::new((place % self.pupil) as f64, (place / self.pupil) as f64) * step;
                let direction = (target.extend(self.reference_z) - film).normalize();
                hits.clear();
                let out = tracer.from_film_recording(Ray { origin: film, direction }, &mut hits);
                nodes.push(out.ok().map(|out| Passed::new(system, out, &hits, self.centre_z)));
            }
        }
        let side = self.pupil;
        let mut rims = limiting_rims(nodes.iter().flatten());
        // The diaphragm is asked itself, by the place in the stop.
        rims.retain(|&rim| rim != system.stop());
        // The last stands for rays that no surface can carry, where they are next to such as get through.
        let carried = 2 * surfaces.len();
        let is_edge = nodes.chunks_exact(side * side).any(|window| is_torn(window, side));
        if is_edge {
            rims.insert(0, carried);
        }
        rims.truncate(4 * MOST_GROUPS - FIXED);
        self.groups = match (FIXED + rims.len()).div_ceil(4) {
            groups @ ..=6 => groups,
            _ => MOST_GROUPS,
        };
        let numbers = |passed: &Passed| {
            let mut row = [-1.0; 4 * MOST_GROUPS];
            row[..FIXED].copy_from_slice(&passed.fixed);
            row[FIXED..].iter_mut().zip(&rims).for_each(|(to, &rim)| *to = passed.beyond_rims[rim]);
            row
        };
        self.rays = Vec::with_capacity(nodes.len() * self.groups);
        for window in nodes.chunks_exact(side * side) {
            let rows: Vec<_> = window.iter().map(|passed| passed.as_ref().map(numbers)).collect();
            // Where nothing can be said the ray is beyond its rims, or beyond the stop if no rim ever counts.
            let mut lost = [1.0; 4 * MOST_GROUPS];
            lost[FIXED - 2] = 4.0 * self.diaphragm.radius_mm();
            for (mut row, passed) in fill_gaps(rows, side, lost).into_iter().zip(window) {
                if is_edge && passed.is_none() {
                    row[FIXED] = 1.0;
                }
                let row = row.map(|number| number as f32);
                self.rays.extend(row.chunks_exact(4).take(self.groups).map(Vec4::from_slice));
            }
        }
    }

    /// Carries a ray from the film to the scene: the ray that leaves the lens after it went from `film_point` to `target`, a point of the
    /// reference plane; `None` if the lens stops it, or if the table does not reach so far. Its origin lies near the first vertex.
    #[inline]
    pub fn from_film(&self, film_point: DVec3, target: DVec3) -> Option<Ray> {
        let mut pupil = target.truncate();
        let onto_upright = (self.film_z - self.reference_z) / (film_point.z - self.reference_z);
        let mut film = pupil + (film_point.truncate() - pupil) * onto_upright;
        let mut meridian = DVec2::X;
        if self.is_symmetric {
            let distance = film.length();
            if distance > 0.0 {
                meridian = film / distance;
            }
            pupil = conjugate(meridian).rotate(pupil);
            film = DVec2::new(distance, 0.0);
        }
        // The sums stay in registers where the compiler knows how many there are.
        let found = match self.groups {
            ..=2 => self.inside_of_rims::<2>(film, pupil),
            3 => self.inside_of_rims::<3>(film, pupil),
            4 => self.inside_of_rims::<4>(film, pupil),
            5 => self.inside_of_rims::<5>(film, pupil),
            6 => self.inside_of_rims::<6>(film, pupil),
            _ => self.inside_of_rims::<MOST_GROUPS>(film, pupil),
        };
        let [a, b] = found?;
        let stop = meridian.rotate(DVec2::new(f64::from(b.z), f64::from(b.w)));
        if !self.diaphragm.is_open(stop.x, stop.y) {
            return None;
        }
        let turned = |v: DVec3| meridian.rotate(v.truncate()).extend(v.z);
        let direction = turned(a.truncate().as_dvec3()).normalize();
        let nearest = turned(DVec3::new(f64::from(a.w), f64::from(b.x), f64::from(b.y)));
        // Onto the sphere about the entrance pupil's centre through the first vertex.
        let along = (self.radius * self.radius - nearest.length_squared()).max(0.0).sqrt().copysign(self.radius);
        let origin = nearest + direction * along + DVec3::new(0.0, 0.0, self.centre_z);
        Some(Ray { origin, direction })
    }

    /// The first two groups of a ray, if no rim stops it.
    #[inline]
    fn inside_of_rims<const G: usize>(&self, film: DVec2, pupil: DVec2) -> Option<[Vec4; 2]> {
        let groups = self.interpolate::<G>(film, pupil)?;
        let (ray, rims) = groups.split_first_chunk()?;
        rims.iter().all(|rims| rims.max_element() <= 0.0).then_some(*ray)
    }

    /// The groups of a ray by cubics along each axis; the first `G` of them count.
    #[inline]
    fn interpolate<const G: usize>(&self, film: DVec2, pupil: DVec2) -> Option<[Vec4; G]> {
        let across = self.film[0].stencil(film.x)?;
        let up = self.film[1].stencil(film.y)?;
        let (low, sides) = self.window.at(film);
        let place = (pupil - low) / sides * (self.pupil - 1) as f64;
        let columns = Stencil::cubic(place.x, self.pupil)?;
        let rows = Stencil::cubic(place.y, self.pupil)?;
        let mut sum = [Vec4::ZERO; G];
        for (j, weight_j) in up.nodes() {
            for (i, weight_i) in across.nodes() {
                let node = j * self.film[0].nodes() + i;
                for (row, weight_row) in rows.nodes() {
                    let start = (node * self.pupil + row) * self.pupil + columns.first();
                    let rays = &self.rays[start * G..(start + 4) * G];
                    let weight = weight_j * weight_i * weight_row;
                    for (ray, weight_column) in rays.chunks_exact(G).zip(columns.weights()) {
                        let weight = weight * weight_column;
                        for (sum, numbers) in sum.iter_mut().zip(ray) {
                            *sum += *numbers * weight;
                        }
                    }
                }
            }
        }
        Some(sum)
    }
}

fn conjugate(v: DVec2) -> DVec2 {
    DVec2::new(v.x, -v.y)
}

/// A ray that went through the lens, whatever the rims say.
struct Passed {
    fixed: [f64; FIXED],
    /// Distances beyond the rims, by surface, and again for the obstructions: above 0 where the surface stops the ray. Last, −1: the
    /// surfaces carry the ray.
    beyond_rims: Vec<f64>,
}

impl Passed {
    /// `hits` come last surface first.
    fn new(system: &System, out: Ray, hits: &[DVec3], centre_z: f64) -> Self {
        let surfaces = system.surfaces();
        let place = |i: usize| {
            let hit = hits[surfaces.len() - 1 - i];
            let local = hit - DVec3::new(0.0, 0.0, surfaces[i].z_mm);
            surfaces[i].pose.point_in(Vector::<f64>::from_f64(local)).of(0).truncate()
        };
        let stop = place(system.stop());
        let from_centre = out.origin - DVec3::new(0.0, 0.0, centre_z);
        let nearest = from_centre - out.direction * from_centre.dot(out.direction);
        let d = out.direction;
        let rim = |i: usize| {
            let opening = match i == system.stop() {
                true => system.diaphragm().radius_mm(),
                false => surfaces[i].semi_diameter_mm,
            };
            place(i).length_squared() / (opening * opening) - 1.0
        };
        let obstruction = |i: usize| match surfaces[i].obstruction_mm {
            0.0 => -1.0,
            radius => 1.0 - place(i).length_squared() / (radius * radius),
        };
        Self {
            fixed: [d.x, d.y, d.z, nearest.x, nearest.y, nearest.z, stop.x, stop.y],
            beyond_rims: (0..surfaces.len())
                .map(rim)
                .chain((0..surfaces.len()).map(obstruction))
                .chain([-1.0])
                .collect(),
        }
    }
}

/// True if a ray that gets through lies next to one that no surface can carry, in a square of so many a `side`.
fn is_torn(window: &[Option<Passed>], side: usize) -> bool {
    let is_through = |ray: &Option<Passed>| ray.as_ref().is_some_and(|ray| ray.beyond_rims.iter().all(|&by| by <= 0.0));
    let is_pair = |a: usize, b: usize| is_through(&window[a]) && window[b].is_none();
    let is_torn = |a: usize, b: usize| is_pair(a, b) || is_pair(b, a);
    (0..side * side).any(|i| (i % side > 0 && is_torn(i - 1, i)) || (i >= side && is_torn(i - side, i)))
}

/// The rims that may be the only one to stop a ray, most often first.
fn limiting_rims<'a>(rays: impl Iterator<Item = &'a Passed>) -> Vec<usize> {
    let mut stopped = Vec::new();
    for ray in rays {
        stopped.resize(ray.beyond_rims.len(), 0usize);
        let worst = ray.beyond_rims.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (count, &beyond) in stopped.iter_mut().zip(&ray.beyond_rims) {
            if beyond > -NEAR_RIM && beyond >= worst - NEAR_RIM {
                *count += 1;
            }
        }
    }
    let mut rims: Vec<usize> = (0..stopped.len()).filter(|&i| stopped[i] > 0).collect();
    rims.sort_by_key(|&i| std::cmp::Reverse(stopped[i]));
    rims
}

/// Extent, on the upright plane through the film's middle, of the points at which rays from the film cross it, mm.
struct Extent {
    low: DVec2,
    high: DVec2,
    farthest: f64,
}

impl Extent {
    fn new(map: &PupilMap, film: &FilmPlane, [half_width, half_height]: [f64; 2]) -> Self {
        // Rays of the picture's edge go farthest; their spread over the pupil is smooth.
        const ACROSS: i32 = 8;
        let mut extent = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, farthest: 0.0 };
        let reference_z = map.reference_plane_z();
        let part = |i: i32| f64::from(2 * i - ACROSS) / f64::from(ACROSS);
        for (u, v) in (0..=ACROSS).flat_map(|i| (0..=ACROSS).map(move |j| (part(i), part(j)))) {
            let point = film.point(u * half_width, v * half_height);
            extent.hold(point.truncate());
            if film.is_uneven() {
                let onto_upright = (film.z_mm - reference_z) / (point.z - reference_z);
                let crossing = |pupil: DVec2| pupil + (point.truncate() - pupil) * onto_upright;
                map.outline_mm(point).for_each(|pupil| extent.hold(crossing(pupil)));
            }
        }
        // Rounding must not put the picture's corner outside.
        extent.farthest *= 1.0 + 1e-9;
        let margin = 1e-9 * (extent.high - extent.low);
        Self { low: extent.low - margin, high: extent.high + margin, ..extent }
    }

    fn hold(&mut self, point: DVec2) {
        (self.low, self.high) = (self.low.min(point), self.high.max(point));
        self.farthest = self.farthest.max(point.length());
    }

    /// Half of the sides of a rectangle about the axis that holds it, or a corner as far from the axis.
    fn half_sides(&self) -> DVec2 {
        self.low.abs().max(self.high.abs()).max(DVec2::splat(self.farthest * std::f64::consts::FRAC_1_SQRT_2))
    }
}

/// The window through which film points see the pupil of `map`.
fn window(
    map: &PupilMap,
    film_z: f64,
    [first, second]: &[NodeAxis; 2],
    is_symmetric: bool,
    has_blades: bool,
) -> PlaneWindow {
    // The blades' outline turns with the meridian: its bounds over all turns are those of a few within 1 %.
    let turns = if is_symmetric && has_blades { 64 } else { 1 };
    let mut bounds = Vec::new();
    for film in second.halves().flat_map(|y| first.halves().map(move |x| DVec2::new(x, y))) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for turn in 0..turns {
            let meridian = DVec2::from_angle(std::f64::consts::TAU * f64::from(turn) / f64::from(turns));
            for corner in map.outline_mm(meridian.rotate(film).extend(film_z)) {
                let corner = conjugate(meridian).rotate(corner);
                (low, high) = (low.min(corner), high.max(corner));
            }
        }
        if low.x < high.x && low.y < high.y {
            bounds.push((film, [low, high]));
        }
    }
    PlaneWindow::around(&bounds, is_symmetric, map.glass_radius_mm())
}

/// The distance from the axis up to which light arrives, at most `farthest`.
fn lit_radius(map: &PupilMap, film_z: f64, farthest: f64) -> f64 {
    const STEPS: u32 = 256;
    let radius = |i: u32| farthest * f64::from(i) / f64::from(STEPS);
    let is_lit = |&i: &u32| map.pupil_area_mm2(DVec3::new(radius(i), 0.0, film_z)) > 0.0;
    (1..=STEPS).rev().find(is_lit).map_or(farthest, radius)
}

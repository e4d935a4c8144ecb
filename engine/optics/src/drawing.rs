//! The drawing of a lens: its surfaces in the y-z plane, and exact rays of several fields in it.
//!
//! Places are (z, y) in lens space, mm.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use glam::{DVec2, DVec3};

use serde::Serialize;

use crate::field::{Field, Origin};
use crate::focus::{FilmPlane, Focus};
use crate::glass::AIR_NAME;
use crate::paraxial::Paraxial;
use crate::system::{Element, Surface, System};
use crate::trace::{Ray, Tracer};
use crate::vector::Vector;
use crate::vignetting::Vignetting;

/// Places of a surface, from its lower rim to the upper: enough for a smooth line.
const PLACES: u32 = 64;
/// Rays are looked for at so many places of the front, and the ends of the beam then found to a part of that in so many halvings.
const LOOKS: u32 = 400;
const HALVINGS: u32 = 30;
/// Rays come into view so far before the lens, in lengths of the drawing.
const APPROACH: f64 = 0.18;

/// The profile of a surface in the y-z plane. Points are (z, y) in lens space, mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceProfile {
    /// Points from the lower rim to the upper.
    pub points: Vec<[f64; 2]>,
    /// Half of the diameter of the missing middle, or 0.
    pub hole_mm: f64,
    /// True if the surface reflects light.
    pub is_mirror: bool,
    /// The glass behind the surface; `None`: air, or a mirror.
    pub glass_behind: Option<String>,
}

/// The rays of a field.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldRays {
    /// Angle of the chief ray to the axis before the lens.
    pub angle_deg: f64,
    /// Places from before the lens to the film; fewer than were asked for only where no light comes through.
    pub rays: Vec<Vec<[f64; 2]>>,
}

/// A drawing of the lens in the y-z plane, with rays of some fields. Points are (z, y) in lens space, mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drawing {
    /// Surfaces, scene side first.
    pub surfaces: Vec<SurfaceProfile>,
    /// Index of the surface with the diaphragm.
    pub stop: usize,
    /// Half of the diaphragm's opening.
    pub stop_semi_diameter_mm: f64,
    /// Rays of each field angle.
    pub fields: Vec<FieldRays>,
    /// Points of the film from the lowest to the highest place where drawn rays hit it.
    pub film: Vec<[f64; 2]>,
}

impl Drawing {
    /// The fields of a drawing: the axis, 0.7 of the design's half field, and that. Where the lens says none, or as it stands is
    /// dark there: the half field where half of the light is left.
    pub fn usual_angles_deg(system: &System, focus: &Focus, wavelength_nm: f64) -> Vec<f64> {
        let seen = Vignetting::new(system, wavelength_nm, focus);
        let is_lit = |half: &f64| seen.largest_field_deg.is_none_or(|largest| *half < largest);
        let half = system.half_field_deg().filter(is_lit).or(seen.half_field_deg).filter(|half| *half > 0.0);
        half.map_or(vec![0.0], |half| vec![0.0, 0.7 * half, half])
    }

    /// The system with the film that `focus` has, rays of a vacuum wavelength in nm from the given angles, `count` (at least 1)
    /// from each, evenly over the beam that comes through in this plane, its rims among them.
    pub fn new(system: &System, focus: &Focus, wavelength_nm: f64, angles_deg: &[f64], count: usize) -> Self {
        let surfaces: Vec<SurfaceProfile> = system.surfaces().iter().map(profile).collect();
        let film = FilmPlane {
            curvature_per_mm: system.film_radius_mm().map_or(0.0, f64::recip),
            ..FilmPlane::upright(focus.film_z_mm)
        };
        let pupil_z_mm = Paraxial::new(system, wavelength_nm).entrance_pupil.z_mm;
        let origin = Origin { object_z_mm: focus.object_plane_mm, pupil_z_mm: pupil_z_mm.unwrap_or(0.0) };
        let beams = Beams { tracer: system.at_wavelength(wavelength_nm), origin, film, surfaces: &surfaces };
        let fields: Vec<FieldRays> = angles_deg.iter().map(|&angle| beams.field(angle, count.max(1))).collect();
        let ends = fields.iter().flat_map(|field| &field.rays).filter_map(|ray| ray.last()).map(|end| end[1]);
        let reach = ends.fold(0.0, |reach: f64, y| reach.max(y.abs()));
        // Closer to one another towards the ends, where a retina is steep.
        let at = |i: u32| film.point(0.0, reach * (FRAC_PI_2 * (2.0 * f64::from(i) / f64::from(PLACES) - 1.0)).sin());
        Self {
            film: (0..=PLACES).map(|i| flat(at(i))).collect(),
            fields,
            surfaces,
            stop: system.stop(),
            stop_semi_diameter_mm: system.stop_semi_diameter_mm(),
        }
    }
}

fn flat(place: DVec3) -> [f64; 2] {
    [place.z, place.y]
}

fn profile(s: &Surface) -> SurfaceProfile {
    let semi = s.semi_diameter_mm.min(s.shape.reach_mm());
    let place = |i: u32| {
        let y = semi * (2.0 * f64::from(i) / f64::from(PLACES) - 1.0);
        let own = DVec3::new(0.0, y, s.shape.sag_mm(0.0, y)?);
        Some(flat(s.pose.point_out(Vector::<f64>::from_f64(own)).of(0) + DVec3::Z * s.z_mm))
    };
    let glass = match &s.element {
        Element::Refract { to, .. } => Some(to.name().to_owned()).filter(|name| name != AIR_NAME),
        Element::Reflect { .. } => None,
    };
    SurfaceProfile {
        points: (0..=PLACES).filter_map(place).collect(),
        hole_mm: s.obstruction_mm,
        is_mirror: matches!(s.element, Element::Reflect { .. }),
        glass_behind: glass,
    }
}

/// The lens through which rays are sent.
struct Beams<'a> {
    tracer: Tracer,
    origin: Origin,
    film: FilmPlane,
    surfaces: &'a [SurfaceProfile],
}

impl Beams<'_> {
    fn field(&self, angle_deg: f64, count: usize) -> FieldRays {
        let field = Field::new(angle_deg.to_radians(), [0.0, 1.0]);
        let runs = self.runs(&field);
        let whole: f64 = runs.iter().map(|run| run[1] - run[0]).sum();
        let ray = |i: usize| {
            // One ray is that in the middle.
            let mut at = whole * if count == 1 { 0.5 } else { i as f64 / (count - 1) as f64 };
            let run = runs.iter().find(|run| {
                let length = run[1] - run[0];
                let is_here = at <= length;
                at -= if is_here { 0.0 } else { length };
                is_here
            });
            // Rounding may leave the last a little too far.
            let height = run.or(runs.last()).map(|run| (run[0] + at).min(run[1]))?;
            self.path(self.origin.ray(&field, DVec2::new(0.0, height)))
        };
        FieldRays { angle_deg, rays: (0..count).filter_map(ray).collect() }
    }

    /// The parts of the field's plane whose rays come through: lower and upper ends.
    fn runs(&self, field: &Field) -> Vec<[f64; 2]> {
        let Some(front) = self.surfaces.first() else { return Vec::new() };
        let heights = front.points.iter().map(|[z, y]| self.origin.crossing(field, DVec3::new(0.0, *y, *z)).y);
        let (low, high) = heights
            .filter(|height| height.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)));
        if low >= high {
            return Vec::new();
        }
        let place = |i: u32| low + (high - low) * f64::from(i) / f64::from(LOOKS);
        let passes = |height: f64| self.tracer.from_scene(self.origin.ray(field, DVec2::new(0.0, height))).is_ok();
        // From one that passes towards one that does not.
        let end = |mut inside: f64, mut outside: f64| {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (inside + outside);
                if passes(middle) { inside = middle } else { outside = middle }
            }
            inside
        };
        let mut runs: Vec<[f64; 2]> = Vec::new();
        let mut was_inside = false;
        for i in 0..=LOOKS {
            let is_inside = passes(place(i));
            match (was_inside, is_inside) {
                (false, true) => {
                    let start = if i == 0 { place(0) } else { end(place(i), place(i - 1)) };
                    runs.push([start, place(i)]);
                }
                (true, false) => runs.last_mut().into_iter().for_each(|run| run[1] = end(place(i - 1), place(i))),
                (true, true) => runs.last_mut().into_iter().for_each(|run| run[1] = place(i)),
                (false, false) => {}
            }
            was_inside = is_inside;
        }
        runs
    }

    /// The path of a ray that comes through.
    fn path(&self, ray: Ray) -> Option<Vec<[f64; 2]>> {
        let (out, hits) = self.tracer.path_from_scene(ray).ok()?;
        let first = *hits.first()?;
        let [front, rear] = self.extent();
        let approach = APPROACH * (rear - front);
        // Rays that come from the side are drawn as far as others.
        let is_steep = ray.direction.z < FRAC_PI_3.cos();
        let back = if is_steep { approach } else { (first.z - (front - approach)) / ray.direction.z };
        let start = match self.origin.object_z_mm {
            Some(z) if first.z - back * ray.direction.z < z => ray.origin,
            _ => first - ray.direction * back,
        };
        let [u, v] = self.film.frame().meet(&out)?;
        let end = self.film.point(u, v);
        Some(std::iter::once(start).chain(hits).chain([end]).map(flat).collect())
    }

    /// The extent along the axis, the film included.
    fn extent(&self) -> [f64; 2] {
        let all = self.surfaces.iter().flat_map(|s| &s.points).map(|p| p[0]).chain([self.film.z_mm]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    }
}

//! A lens as a camera of Cycles, written in the Open Shading Language: its script traces each camera ray as the real lens does.
//!
//! The script holds the surfaces, the indices at one wavelength or three, and a table of boxes about the clear pupil: a ray is aimed
//! evenly into the box that belongs to its film point and opening, and those that miss the pupil are lost. The box lies on the plane of
//! the exit pupil where there is one between a fifth and a thousand times the rear vertex's distance from the film, else on that of the
//! rear vertex: there it hardly depends on the focus. Its weight is that of [`crate::camera::lens::real_lens`].

use crate::camera::lens::setup::{D_LINE_NM, Setup};
use crate::camera::{CameraDescription, CameraError, Model, Spectrum};
use crate::spectrum::FilmSpectrum;
use glam::{DVec2, DVec3};
use petzval_optics::focus::FilmPlane;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::{PupilMap, on_axis_throughput, on_axis_throughput_without_obstructions};
use petzval_optics::surface::Shape;
use petzval_optics::system::{Element, System};
use petzval_optics::trace::Tracer;
use std::fmt::Write;

const TEMPLATE: &str = include_str!("osl/lens_camera.osl");
/// Film radii and openings (1, 1/2, 1/4 ...) at which the boxes are known. The script sets them up for each ray: more cost time,
/// fewer lose rays.
const RADII: usize = 25;
const LEVELS: usize = 5;
/// Part of a box's size added on each side, for points between the known ones.
const MARGIN: f64 = 0.02;
/// Distances of the exit pupil from the film, in that of the rear vertex, at which the boxes lie there.
const PUPIL_PLANES: std::ops::Range<f64> = 0.2..1e3;
/// The film may be this much larger than the camera has it.
const FILM: f64 = 1.1;
/// Most steps to an asphere's crossing.
const ASPHERE_STEPS: usize = 30;

impl CameraDescription {
    /// The script for this camera and pictures of that many pixels; the lens as it is set now, its f-number, film and, where the film
    /// moves to focus, its focus free to be changed in Blender.
    ///
    /// # Errors
    /// [`CameraError`]; it names a surface that the script cannot do.
    pub fn osl_camera(&self, size: [u32; 2]) -> Result<String, CameraError> {
        if self.model != Model::Lens {
            return Err(self.error("only the real lens is written as an OSL camera; choose the model 'Lens'"));
        }
        if self.scale_mm_per_unit.min_element() != self.scale_mm_per_unit.max_element() {
            return Err(self.error("its axes have different scales, which an OSL camera here cannot have; lock them"));
        }
        self.check(size[0], size[1])?;
        let setup = Setup::new(self, size[0], size[1])?;
        self.refuse(&setup)?;
        let system = &setup.system;
        let mut wavelengths: Vec<f64> = match self.wavelength_nm {
            Some(nm) => vec![nm],
            None if !system.is_dispersive() => vec![D_LINE_NM],
            None => FilmSpectrum::three().wavelengths().iter().map(|w| w.nm).collect(),
        };
        if self.spectrum == Spectrum::Bands(1) {
            wavelengths = vec![D_LINE_NM];
        }
        let script = Script { d: self, size, setup: &setup, wavelengths };
        script.written()
    }

    /// Checks that the lens can be written; the error names the part that cannot.
    fn refuse(&self, setup: &Setup) -> Result<(), CameraError> {
        let system = &setup.system;
        for (i, s) in system.surfaces().iter().enumerate() {
            let what = match s.shape {
                Shape::Toroid(_) => Some("is a cylinder or toroid"),
                Shape::Asphere(asphere) if asphere.terms().iter().any(|(power, _)| power % 2 == 1) => {
                    Some("is an asphere with odd powers")
                }
                _ if !s.pose.is_identity() => Some("is tilted or decentred"),
                _ if s.element.behind().gradient().is_some() => Some("has a gradient index behind it"),
                _ => None,
            };
            if let Some(what) = what {
                return Err(self.error(format!(
                    "surface {i} of '{}' {what}, which an OSL camera cannot do: render it by Petzval",
                    system.name()
                )));
            }
        }
        if system.diaphragm().is_masked() {
            return Err(self.error("its diaphragm is a picture, which an OSL camera cannot do: take blades instead"));
        }
        if setup.film.curvature_per_mm != 0.0 {
            return Err(self.error("its film is a retina, which an OSL camera cannot do: render it by Petzval"));
        }
        Ok(())
    }
}

struct Script<'a> {
    d: &'a CameraDescription,
    size: [u32; 2],
    setup: &'a Setup,
    wavelengths: Vec<f64>,
}

/// Boxes about the pupil, and the light in the middle of the film.
struct PupilBoxes {
    bounds: Vec<f64>,
    /// The light in the middle of the film without the central obstruction, over the square of the opening.
    light: Vec<f64>,
    /// The light that the central obstruction takes, equal for all openings; by wavelength.
    hidden: Vec<f64>,
    cells_per_mm: f64,
}

impl Script<'_> {
    #[expect(clippy::too_many_lines, reason = "an entry for each mark of the template")]
    fn written(&self) -> Result<String, CameraError> {
        let Setup { info, system, film, origin_z_mm } = self.setup;
        let surfaces = system.surfaces();
        let line_nm = self.d.wavelength_nm.unwrap_or(D_LINE_NM);
        let paraxial = Paraxial::new(system, line_nm);
        let plane_z = self.plane_z(&paraxial);
        let tables = self.tables(plane_z)?;
        let by_surface = |value: &dyn Fn(usize) -> f64| list((0..surfaces.len()).map(value));
        let mut sides = Vec::new();
        let mut side = 1.0;
        for s in surfaces {
            side = if matches!(s.element, Element::Reflect { .. }) { -side } else { side };
            // Rays go back to the scene.
            sides.push(-side);
        }
        let base = |i: usize| surfaces[i].shape.profile().base;
        let ratios = self.wavelengths.iter().flat_map(|&nm| {
            surfaces.iter().map(move |s| match &s.element {
                Element::Refract { from, to } => to.index(nm) / from.index(nm),
                Element::Reflect { .. } => 1.0,
            })
        });
        let image_index = system.image_index(line_nm);
        let foci = paraxial.efl_mm.zip(paraxial.object_focal_plane_mm).zip(paraxial.image_focal_plane_mm);
        let can_focus = foci.is_some() && !info.focuses_inside && paraxial.entrance_pupil.z_mm.is_some();
        let ((efl, object_focus), image_focus) = foci.unwrap_or(((0.0, 0.0), 0.0));
        let exit_scale = match paraxial.exit_pupil.z_mm.filter(|z| (film.z_mm - z).abs() > 1e-3) {
            Some(z) => format!("({} - ({})) / (film_z - ({}))", number(film.z_mm), number(z), number(z)),
            None => "1.0".to_owned(),
        };
        let count = surfaces.len();
        let lines: Vec<String> = self.wavelengths.iter().map(|nm| format!("{nm}")).collect();
        let facts = format!(
            "Traced at {} nm; widest f-number {:.4}, focal length {}.",
            lines.join(", "),
            system.widest_f_number(),
            info.efl_mm.map_or("none".to_owned(), |f| format!("{f:.4} mm"))
        );
        let focus_help = match can_focus {
            true => "From the camera to what is sharp, along its axis; 0: the film distance counts",
            false => "Of no effect: this lens focuses inside; export it again for another focus",
        };
        let (aspheres, asphere) = self.aspheres();
        let entries = [
            ("TITLE", info.lens_name.replace(['\n', '\r', '\\'], " ")),
            ("FACTS", facts),
            ("SURFACES", count.to_string()),
            ("LINES", self.wavelengths.len().to_string()),
            ("RADII", RADII.to_string()),
            ("LEVELS", LEVELS.to_string()),
            ("F_NUMBER", number(system.f_number().min(1e6))),
            ("FILM_DISTANCE", number(info.film_distance_mm)),
            ("FOCUS_DISTANCE", number(0.0)),
            ("FOCUS_HELP", focus_help.to_owned()),
            ("FILM_WIDTH", number(info.picture_width_mm)),
            ("FILM_HEIGHT", number(info.picture_height_mm)),
            ("SHIFT_X", number(self.d.film.shift_mm[0])),
            ("SHIFT_Y", number(self.d.film.shift_mm[1])),
            ("TILT", number(film.tilt_rad.to_degrees())),
            ("SWING", number(film.swing_rad.to_degrees())),
            ("SCALE", number(self.d.scale_mm_per_unit.x)),
            ("VERTEX", by_surface(&|i| surfaces[i].z_mm)),
            ("CURVATURE", by_surface(&|i| base(i).curvature)),
            ("CONIC", by_surface(&|i| base(i).conic)),
            ("CLEAR", by_surface(&|i| surfaces[i].semi_diameter_mm.min(1e18))),
            ("HOLE", by_surface(&|i| surfaces[i].obstruction_mm)),
            ("SIDE", list(sides.into_iter())),
            (
                "MIRROR",
                join(surfaces.iter().map(|s| u8::from(matches!(s.element, Element::Reflect { .. })).to_string())),
            ),
            ("RATIOS", (count * self.wavelengths.len()).to_string()),
            ("RATIO", list(ratios)),
            ("ASPHERE_TABLES", aspheres),
            ("ASPHERE", asphere),
            ("PLANE_Z", number(plane_z)),
            ("BOUNDS", tables.bounds.len().to_string()),
            ("BOUND", list(tables.bounds.into_iter())),
            ("LIGHTS", tables.light.len().to_string()),
            ("LIGHT", list(tables.light.into_iter())),
            ("HIDDEN", list(tables.hidden.into_iter())),
            ("CELLS_PER_MM", number(tables.cells_per_mm)),
            ("LAST_VERTEX", number(system.last_vertex_z_mm())),
            ("CAN_FOCUS", u8::from(can_focus).to_string()),
            ("PUPIL_Z", number(paraxial.entrance_pupil.z_mm.unwrap_or(0.0))),
            ("OBJECT_FOCUS", number(object_focus)),
            ("IMAGE_FOCUS", number(image_focus)),
            ("FF", number(efl * efl / image_index)),
            ("WIDEST", number(system.widest_f_number().min(1e6))),
            ("CLEAR_STOP", number(surfaces[system.stop()].semi_diameter_mm)),
            ("EXIT_SCALE", exit_scale),
            ("STOP", system.stop().to_string()),
            ("STOP_TEST", self.stop_test()),
            ("ORIGIN_Z", number(*origin_z_mm)),
        ];
        let mut text = TEMPLATE.to_owned();
        for (name, value) in entries {
            text = text.replace(&format!("@{name}@"), &value);
        }
        Ok(text)
    }

    fn plane_z(&self, paraxial: &Paraxial) -> f64 {
        let rear = self.setup.system.last_vertex_z_mm();
        let film = self.setup.film.z_mm;
        let pupil = paraxial.exit_pupil.z_mm;
        pupil.filter(|z| PUPIL_PLANES.contains(&((film - z) / (film - rear)))).unwrap_or(rear)
    }

    /// This camera with the stop closed to that part of its clear radius.
    fn stopped(&self, opening: f64, is_round: bool) -> Result<System, CameraError> {
        let stop = Some(self.setup.system.widest_f_number() / opening).filter(|stop| stop.is_finite());
        // The lens stands as it does; only its diaphragm differs.
        let d = self.d.clone().with(|c| {
            c.lens = self.d.lens.clone().opened(stop);
            c.lens.blades = if is_round { 0 } else { self.d.lens.blades };
        });
        Ok(Setup::new(&d, self.size[0], self.size[1])?.system)
    }

    fn tables(&self, plane_z: f64) -> Result<PupilBoxes, CameraError> {
        let Setup { info, system, film, .. } = self.setup;
        let half = [0.5 * FILM * info.picture_width_mm, 0.5 * FILM * info.picture_height_mm];
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let radius_of = |[x, y]: [f64; 2]| film.point(x * half[0], y * half[1]).truncate().length();
        let farthest = corners.map(radius_of).into_iter().fold(0.0, f64::max);
        let infinity = Paraxial::new(system, self.d.wavelength_nm.unwrap_or(D_LINE_NM)).image_focal_plane_mm;
        // Groups that have moved inside do not belong to that film.
        let infinity = infinity.filter(|_| !info.focuses_inside);
        let films: Vec<f64> = [Some(film.z_mm), infinity].into_iter().flatten().collect();
        let lines =
            |system: &System| -> Vec<Tracer> { self.wavelengths.iter().map(|&nm| system.at_wavelength(nm)).collect() };
        let mut bounds = Vec::new();
        let mut light = vec![0.0; self.wavelengths.len() * LEVELS];
        let mut hidden = vec![0.0; self.wavelengths.len()];
        for level in 0..LEVELS {
            let opening = 0.5f64.powi(level as i32);
            let round = self.stopped(opening, true)?;
            let maps: Vec<(PupilMap, f64)> = films
                .iter()
                .map(|&z| {
                    let film = FilmPlane::upright(z);
                    (PupilMap::for_tracers(&lines(&round), &round, &film, farthest, 0.0), z)
                })
                .collect();
            for i in 0..RADII {
                let radius = farthest * i as f64 / (RADII - 1) as f64;
                bounds.extend(bounding(&maps, radius, plane_z));
            }
            let bladed = self.stopped(opening, false)?;
            for (i, tracer) in lines(&bladed).iter().enumerate() {
                let clear = on_axis_throughput_without_obstructions(tracer, &bladed, film.z_mm);
                light[i * LEVELS + level] = clear / (opening * opening);
                if level == 0 {
                    hidden[i] = clear - on_axis_throughput(tracer, &bladed, film.z_mm);
                }
            }
        }
        let open: Vec<f64> = hidden.iter().enumerate().map(|(i, hidden)| light[i * LEVELS] - hidden).collect();
        if !light.iter().chain(&open).all(|value| *value > 0.0 && value.is_finite()) {
            return Err(crate::camera::lens::real_lens::dark(self.d, &info.lens_name));
        }
        Ok(PupilBoxes { bounds, light, hidden, cells_per_mm: (RADII - 1) as f64 / farthest })
    }

    /// The test of the stop in its own radii, as [`petzval_optics::diaphragm::Diaphragm`] has it.
    fn stop_test(&self) -> String {
        let diaphragm = self.setup.system.diaphragm();
        let mut text = String::from("      if (squared > stop_radius * stop_radius)\n        is_lost = 1;");
        let blades = diaphragm.blades();
        if blades == 0 {
            return text;
        }
        let step = std::f64::consts::TAU / f64::from(blades);
        let curvature = diaphragm.curvature();
        let (sin, cos) = (0.5 * step).sin_cos();
        let bulge = if curvature > 0.0 { 0.5 * curvature / (1.0 - (curvature * sin).powi(2)).sqrt() } else { 0.0 };
        let (slope, bound) = (1.0 - 2.0 * cos * bulge, cos + bulge * (1.0 - 2.0 * cos * cos));
        let _ = write!(
            text,
            "\n      for (int side_of = 0; side_of < {blades}; side_of++) {{
        float turn = {} + (side_of + 0.5) * {};
        float out = (at[0] * cos(turn) + at[1] * sin(turn)) / stop_radius;
        if ({} * squared / (stop_radius * stop_radius) + {} * out > {})
          is_lost = 1;
      }}",
            number(diaphragm.rotation_rad()),
            number(step),
            number(bulge),
            number(slope),
            number(bound)
        );
        text
    }

    /// The text of the surfaces that are aspheres, with their terms, and of the search for their crossings.
    #[expect(clippy::too_many_lines, reason = "the text of a loop")]
    fn aspheres(&self) -> (String, String) {
        let surfaces = self.setup.system.surfaces();
        let terms = |i: usize| match &surfaces[i].shape {
            Shape::Asphere(asphere) => asphere.terms(),
            _ => Vec::new(),
        };
        let highest = (0..surfaces.len()).flat_map(terms).map(|(power, _)| power as usize / 2).max();
        let is_asphere = join((0..surfaces.len()).map(|i| u8::from(!terms(i).is_empty()).to_string()));
        let kinds = format!("  int is_asphere[SURFACES] = {{{is_asphere}}};");
        let Some(highest) = highest else { return (kinds, String::new()) };
        let mut table = Vec::new();
        for i in 0..surfaces.len() {
            let mut row = vec![0.0; highest];
            terms(i).into_iter().for_each(|(power, a)| row[power as usize / 2 - 1] = a);
            table.extend(row);
        }
        let tables = format!(
            "{kinds}\n  // Of r^2, r^4 and so on.\n  float terms[{}] = {{{}}};",
            table.len(),
            list(table.into_iter())
        );
        let steps = format!(
            "    if (is_asphere[i]) {{
      // z - sag(r) rises through 0 along the way to the film: Newton's method from the conicoid, its slope taken as rising; once
      // two places enclose the crossing, what leaves them is replaced by their middle.
      float low = -1e30, high = 1e30, size = 2.0 * (length(vector(A)) + fabs(t)), longest = size;
      int is_found = 0;
      for (int step = 0; step < {ASPHERE_STEPS} && !is_found; step++) {{
        at = A + D * t;
        float r2 = at[0] * at[0] + at[1] * at[1];
        float w = sqrt(max(0.0, 1.0 - (1.0 + k) * c * c * r2));
        float sag = c * r2 / (1.0 + w);
        float slope = 0.5 * c;
        float power = 1.0;
        for (int j = 0; j < {highest}; j++) {{
          slope += (j + 1) * terms[i * {highest} + j] * power * w;
          power *= r2;
          sag += terms[i * {highest} + j] * power;
        }}
        normal_at = vector(-2.0 * slope * at[0], -2.0 * slope * at[1], w);
        float value = (at[2] - sag) * w * side[i];
        if (value < 0.0)
          low = max(low, t);
        else
          high = min(high, t);
        float newton = -value / max(fabs(dot(normal_at, D)), 1e-30);
        float bounded = newton;
        if (fabs(newton) >= longest)
          bounded = longest * sign(newton);
        longest *= 2.0;
        if (fabs(newton) <= 2e-7 * (fabs(t) + size) || fabs(at[2] - sag) <= 2e-7 * (fabs(at[2]) + fabs(sag)))
          is_found = 1;
        else if (low > -1e29 && high < 1e29 && (t + bounded <= low || t + bounded >= high))
          t = 0.5 * (low + high);
        else
          t += bounded;
      }}
      if (!is_found || normal_at[2] <= 0.0 || dot(normal_at, D) * side[i] < 0.0) {{
        is_lost = 1;
        break;
      }}
    }}"
        );
        (tables, steps)
    }
}

/// Nearest, farthest and farthest across: about the outlines of all maps, for a film point on the x axis.
fn bounding(maps: &[(PupilMap, f64)], radius: f64, plane_z: f64) -> [f64; 3] {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (map, film_z) in maps {
        let film = DVec3::new(radius, 0.0, *film_z);
        let part = (plane_z - film_z) / (map.reference_plane_z() - film_z);
        for corner in map.outline_mm(film) {
            let on_plane = film.truncate() + (corner - film.truncate()) * part;
            (low, high) = (low.min(on_plane), high.max(on_plane));
        }
    }
    if low.x >= high.x {
        // Dark.
        return [0.0; 3];
    }
    let margin = (high - low) * MARGIN;
    [low.x - margin.x, high.x + margin.x, high.y.max(-low.y) + margin.y]
}

/// A number as OSL reads it, to more digits than it keeps.
fn number(value: f64) -> String {
    format!("{value:.9e}")
}

fn list(values: impl Iterator<Item = f64>) -> String {
    join(values.map(number))
}

/// The values in lines of some entries.
fn join(values: impl Iterator<Item = String>) -> String {
    let values: Vec<String> = values.collect();
    let lines: Vec<String> = values.chunks(8).map(|line| line.join(", ")).collect();
    lines.join(",\n    ")
}

#[cfg(test)]
mod tests;

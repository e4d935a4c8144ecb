//! A lens while it is read from a design program's file, which says less of it than a prescription needs: how wide the stop is
//! follows from the beam, clear apertures from the fields, and surfaces where nothing happens are none.

use crate::coating::Coating;
use crate::first_order::{Matrix, ParaxialSurface, between_vertices, front_of};
use crate::glass::Medium;
use crate::prescription::moving::{MovingParts, Part, Position};
use crate::prescription::{Metadata, NextMedium, Place, Prescription, SurfaceRow};
use crate::surface::{Conic, LAST_POWER, Shape};
use glam::DAffine3;

use super::beams::{self, FieldBeam, StatedBeam};
use super::configurations::Configurations;
use super::draft_row::DraftRow;
use super::problem::{LensFileError, Problem, at};
use super::remarks::{Reading, Remarks};
use super::text::stem;

/// A file of more surfaces is none.
pub(super) const MOST_SURFACES: usize = 1000;
/// Width of a surface over that of its beams where the file does not state it: the beams are known to about that.
const ROOM: f64 = 1.02;
/// Beams of more fields tell nothing new.
const MOST_FIELDS: usize = 50;
/// Objects farther away are at infinity, mm: programs write 1e10 and more.
pub(super) const INFINITELY_FAR_MM: f64 = 1e8;

/// A point of the field, in the y-z plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldPoint {
    pub(super) y: f64,
    /// The parts of the pupil's radius that are cut off below and above.
    pub(super) cut: [f64; 2],
}

/// The measure of the fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FieldKind {
    Degrees,
    ObjectHeight,
    ImageHeight,
}

/// A lens as far as it is read, before it is checked and completed.
pub(super) struct Draft<'a> {
    pub(super) file: &'a str,
    pub(super) name: Option<String>,
    pub(super) rows: Vec<DraftRow>,
    pub(super) stop: Option<usize>,
    pub(super) beam: Option<StatedBeam>,
    pub(super) field_kind: FieldKind,
    pub(super) fields: Vec<FieldPoint>,
    /// Distance from the object to the first surface; infinite for most.
    pub(super) object_mm: f64,
    /// The wavelength for which beam and fields are meant.
    pub(super) wavelength_nm: f64,
    pub(super) film_radius_mm: Option<f64>,
    /// The change of coordinates from the place that the last row leaves to the film, mm.
    pub(super) film_frame: DAffine3,
    pub(super) metadata: Metadata,
    /// Coating of surfaces where glass meets air.
    pub(super) coating: Option<Coating>,
    /// Surfaces with gaps that move, and their places in the file.
    pub(super) moving: Option<(Vec<Part>, Vec<Position>, Vec<Place>)>,
    /// Configurations, of which moving parts are made.
    pub(super) configurations: Option<Configurations>,
    pub(super) remarks: Remarks,
}

impl<'a> Draft<'a> {
    pub(super) fn new(file: &'a str) -> Self {
        Self {
            file,
            name: None,
            rows: Vec::new(),
            stop: None,
            beam: None,
            field_kind: FieldKind::Degrees,
            fields: Vec::new(),
            object_mm: f64::INFINITY,
            wavelength_nm: crate::glass::line_nm::D,
            film_radius_mm: None,
            film_frame: DAffine3::IDENTITY,
            metadata: Metadata::default(),
            coating: None,
            moving: None,
            configurations: None,
            remarks: Remarks::default(),
        }
    }

    /// Adds a line of a header, as `.lens` files have them.
    pub(super) fn header(&mut self, key: &str, value: impl ToString) {
        self.metadata.all.push((key.to_owned(), value.to_string()));
    }

    pub(super) fn fail<T>(&self, place: Place, problem: Problem) -> Result<T, LensFileError> {
        Err(at(self.file, place.line, place.column, problem))
    }

    /// Makes millimetres of lengths in units of `mm`.
    pub(super) fn scale(&mut self, mm: f64) {
        if mm == 1.0 {
            return;
        }
        for row in &mut self.rows {
            row.curvature /= mm;
            row.thickness_mm *= mm;
            row.obstruction_mm *= mm;
            row.before.translation *= mm;
            row.after.translation *= mm;
            row.semi_diameter_mm = row.semi_diameter_mm.map(|semi| semi * mm);
            row.radius_x_mm = row.radius_x_mm.map(|radius| radius * mm);
            for (power, a) in &mut row.terms {
                *a /= mm.powi(*power as i32 - 1);
            }
        }
        self.object_mm *= mm;
        self.film_frame.translation *= mm;
        self.film_radius_mm = self.film_radius_mm.map(|radius| radius * mm);
        if self.field_kind != FieldKind::Degrees {
            self.fields.iter_mut().for_each(|field| field.y *= mm);
        }
        if let Some(StatedBeam::EntrancePupil(diameter)) = &mut self.beam {
            *diameter *= mm;
        }
        if let Some(configurations) = &mut self.configurations {
            configurations.scale(mm);
        }
    }

    /// The distance of the image at first order from the last surface, mm; `None` without one.
    pub(super) fn image_distance_mm(&self) -> Option<f64> {
        let thin = self.thin();
        let matrix = between_vertices(&thin);
        let ray = if self.object_mm.abs() > INFINITELY_FAR_MM { (1.0, 0.0) } else { (self.object_mm, 1.0) };
        let [height, slope] = matrix.apply(ray.0, ray.1);
        let index = thin.last().map_or(1.0, |s| s.to);
        Some(-height * index / slope).filter(|mm| mm.is_finite())
    }

    /// Puts the film where the image is at first order.
    pub(super) fn film_at_focus(&mut self, place: Place) {
        let distance = self.image_distance_mm();
        if let (Some(last), Some(distance)) = (self.rows.last_mut(), distance) {
            last.thickness_mm = distance;
            self.remarks.say(place, format!("the film is put where the image is at first order, at {distance}"));
        }
    }

    /// The prescription, completed and checked, with the remarks on it: rims and stop that the file leaves out follow from its beams.
    pub(super) fn finish(mut self) -> Result<Reading, LensFileError> {
        let start = Place { line: 1, column: 1 };
        if self.rows.is_empty() {
            return self.fail(start, Problem::Unsupported("there is no surface between object and film".to_owned()));
        }
        for row in &self.rows {
            if let Some((power, _)) = row.terms.iter().find(|(power, a)| *a != 0.0 && !(2..=LAST_POWER).contains(power))
            {
                let what =
                    format!("the asphere has a term in r^{power}; terms from r^2 to r^{LAST_POWER} are supported");
                return self.fail(row.place, Problem::Unsupported(what));
            }
        }
        let stop = self.stop.unwrap_or_else(|| {
            let place = self.rows[0].place;
            self.remarks.say(place, "no surface is the stop; the first is taken");
            0
        });
        if stop >= self.rows.len() {
            return self
                .fail(start, Problem::Unsupported("the stop is the film, or a surface that is not there".to_owned()));
        }
        self.stop = Some(stop);
        if self.object_mm.abs() > INFINITELY_FAR_MM {
            self.object_mm = f64::INFINITY;
        }
        self.unfold()?;
        if self.rows.is_empty() {
            return self.fail(start, Problem::Unsupported("there is no surface but mirrors that fold".to_owned()));
        }
        self.drop_inert();
        let stop = self.stop.unwrap_or(0);
        self.open_stop(stop);
        let widest_mm = self.configure(stop);
        self.open_rims(stop, &widest_mm);
        self.note_design();

        let surfaces = self.surfaces()?;
        let moving = self.moving_parts(&surfaces)?;
        let prescription = Prescription {
            name: self.name.take().filter(|name| !name.is_empty()).unwrap_or_else(|| stem(self.file)),
            surfaces,
            stop,
            metadata: std::mem::take(&mut self.metadata),
            film_radius_mm: self.film_radius_mm,
            moving,
            source_file: self.file.to_owned(),
        };
        let mut prescription = prescription.in_first_position();
        if let Some(coating) = &self.coating {
            prescription.coat(coating);
        }
        if let Err(error) = prescription.check() {
            return self.fail(start, error.into());
        }
        Ok(Reading { prescription, remarks: self.remarks.finish(self.file) })
    }

    /// The surfaces of all rows, checked.
    fn surfaces(&self) -> Result<Vec<SurfaceRow>, LensFileError> {
        let mut surfaces = Vec::with_capacity(self.rows.len());
        for (i, row) in self.rows.iter().enumerate() {
            let base = Conic { curvature: row.curvature, conic: row.conic };
            let surface = SurfaceRow {
                shape: Shape::from_numbers(base, &row.terms, row.radius_x_mm),
                pose: row.pose,
                thickness_mm: row.thickness_mm,
                behind: row.behind.clone(),
                semi_diameter_mm: row.semi_diameter_mm.unwrap_or(0.0),
                obstruction_mm: row.obstruction_mm,
                coating: None,
                place: row.place,
            };
            if let Err(error) = surface.check(i) {
                return self.fail(row.place, error.into());
            }
            surfaces.push(surface);
        }
        Ok(surfaces)
    }

    /// The moving parts of these surfaces, checked.
    fn moving_parts(&mut self, surfaces: &[SurfaceRow]) -> Result<Option<MovingParts>, LensFileError> {
        let Some((parts, positions, places)) = self.moving.take() else { return Ok(None) };
        let moving = MovingParts::new(parts, &positions, surfaces.len());
        match moving.and_then(|moving| moving.check(surfaces, &positions).map(|()| moving)) {
            Ok(moving) => Ok(Some(moving)),
            Err((about, error)) => {
                let place = about.and_then(|i| places.get(i)).or(places.first()).copied();
                self.fail(place.unwrap_or(Place { line: 1, column: 1 }), error.into())
            }
        }
    }

    /// Takes out planes between one medium and the same that neither are the stop nor have a rim: marks of the design program.
    fn drop_inert(&mut self) {
        if self.configurations.is_some() || self.moving.as_ref().is_some_and(|(parts, ..)| !parts.is_empty()) {
            return;
        }
        let mut before = Medium::air();
        let mut kept: Vec<DraftRow> = Vec::with_capacity(self.rows.len());
        let mut stop = self.stop;
        for (i, row) in std::mem::take(&mut self.rows).into_iter().enumerate() {
            let same = matches!(&row.behind, NextMedium::Medium(medium) if *medium == before);
            let flat = row.curvature == 0.0 && row.terms.iter().all(|(_, a)| *a == 0.0) && row.radius_x_mm.is_none();
            let inert = same && flat && !row.has_rim && row.obstruction_mm == 0.0 && self.stop != Some(i);
            if let NextMedium::Medium(medium) = &row.behind {
                before = medium.clone();
            }
            if !inert {
                if self.stop == Some(i) {
                    stop = Some(kept.len());
                }
                kept.push(row);
            } else if let Some(last) = kept.last_mut() {
                last.thickness_mm += row.thickness_mm;
            } else {
                self.object_mm += row.thickness_mm;
            }
        }
        (self.rows, self.stop) = (kept, stop);
    }

    /// The surfaces as Gaussian optics sees them.
    pub(super) fn thin(&self) -> Vec<ParaxialSurface> {
        let (mut sign, mut medium) = (1.0, 1.0);
        let one = |row: &DraftRow| {
            let from = sign * medium;
            match &row.behind {
                NextMedium::Medium(to) => medium = to.index(self.wavelength_nm),
                NextMedium::Mirror => sign = -sign,
            }
            let square = row.terms.iter().filter(|(power, _)| *power == 2).map(|(_, a)| 2.0 * a).sum::<f64>();
            let to = sign * medium;
            let onward = Matrix::travel(row.thickness_mm, to);
            ParaxialSurface { curvature: row.curvature + square, from, to, onward, petzval_onward: 0.0 }
        };
        self.rows.iter().map(one).collect()
    }

    /// Sets the stop's width, by the beam that the file wants.
    pub(super) fn open_stop(&mut self, stop: usize) {
        let thin = self.thin();
        let front = front_of(&thin, stop);
        let semi = match self.beam {
            None => return,
            Some(StatedBeam::EntrancePupil(diameter)) => 0.5 * diameter * front.a.abs(),
            Some(StatedBeam::FNumber(number)) => 0.5 * front.a.abs() / (between_vertices(&thin).c * number).abs(),
            Some(StatedBeam::ObjectNa(na)) => {
                let slope = na / (1.0 - na * na).max(0.0).sqrt();
                ((front.a * self.object_mm + front.b) * slope).abs()
            }
        };
        if semi.is_finite() && semi > 0.0 {
            self.rows[stop].semi_diameter_mm = Some(semi);
        }
    }

    /// Sets the widths of the other surfaces, where the file does not state them: those of the beams of its fields. Widths that nobody
    /// has fixed are at least those of the beams in other configurations.
    fn open_rims(&mut self, stop: usize, widest_mm: &[f64]) {
        let good = |x: f64| x.is_finite() && x > 0.0;
        let given = |row: &DraftRow| row.semi_diameter_mm.filter(|x| good(*x));
        if given(&self.rows[stop]).is_none()
            && let Some(semi) = beams::widest_through_rims(&self.rows, stop, self.wavelength_nm, self.object_mm)
        {
            self.rows[stop].semi_diameter_mm = Some(semi);
            let text = "the stop has no clear aperture in the file; it is opened as far as the other surfaces let light from the axis through";
            self.remarks.say(self.rows[stop].place, text.to_owned());
        }
        let guessed = self.rows.iter().filter(|row| given(row).is_none()).count();
        let mut computed = if guessed > 0 { self.beams(stop) } else { vec![0.0; self.rows.len()] };
        computed.iter_mut().zip(widest_mm).for_each(|(computed, widest)| *computed = computed.max(*widest));
        let largest = self.rows.iter().filter_map(given).fold(0.0, f64::max);
        let spare = if largest > 0.0 { largest } else { 1.0 };
        for (i, row) in self.rows.iter_mut().enumerate() {
            let base = Conic { curvature: row.curvature, conic: row.conic };
            let reach = Shape::from_numbers(base, &[], row.radius_x_mm).reach_mm();
            let known =
                given(row).map(|semi| if i == stop || row.is_width_fixed { semi } else { semi.max(widest_mm[i]) });
            let semi = known.unwrap_or(if good(computed[i]) { ROOM * computed[i] } else { spare });
            if semi > reach && known.is_some() {
                let (wanted, has) = (2.0 * semi, 2.0 * reach);
                let text = format!("the clear diameter {wanted} mm is more than the surface has; it is cut to {has}");
                self.remarks.say(row.place, text);
            }
            row.semi_diameter_mm = Some(semi.min(reach));
        }
        if guessed > 0 {
            let count = self.rows.len();
            let text = format!(
                "{guessed} of {count} surfaces have no clear aperture in the file; they are opened for its beams"
            );
            self.remarks.say(self.rows[0].place, text);
        }
    }

    /// Distances from the axis that the beams of the fields reach on the surfaces.
    pub(super) fn beams(&self, stop: usize) -> Vec<f64> {
        let thin = self.thin();
        let front = front_of(&thin, stop);
        let stop_semi = self.rows[stop].semi_diameter_mm.unwrap_or(0.0);
        let is_far = self.object_mm.is_infinite();
        // (height at the first vertex, slope) of the ray from the axis through the stop's rim, and of rays through its centre.
        let rim = if is_far {
            (stop_semi / front.a, 0.0)
        } else {
            let slope = stop_semi / (front.a * self.object_mm + front.b);
            (slope * self.object_mm, slope)
        };
        let through_centre = |slope: f64| (-slope * front.b / front.a, slope);
        let chief = |y: f64| match self.field_kind {
            FieldKind::Degrees => through_centre(y.to_radians().tan()),
            FieldKind::ObjectHeight => {
                let slope = -front.a * y / (front.a * self.object_mm + front.b);
                (y + slope * self.object_mm, slope)
            }
            FieldKind::ImageHeight => {
                let (height, slope) = through_centre(1.0);
                let [height, slope] = between_vertices(&thin).apply(height, slope);
                let end = thin.last().map_or(0.0, |s| s.onward.apply(height, slope)[0]);
                through_centre(y / end)
            }
        };
        let mut largest = vec![0.0f64; self.rows.len()];
        let axis = FieldPoint { y: 0.0, cut: [0.0; 2] };
        for field in self.fields.iter().chain([&axis]).take(MOST_FIELDS) {
            let (middle, slope) = chief(field.y);
            let origin = (!is_far).then(|| [-self.object_mm, middle - slope * self.object_mm]);
            let [below, above] = field.cut.map(|cut| (1.0 - cut).clamp(0.0, 1.0));
            // A stop that is seen upside down turns below and above.
            let left = if front.a < 0.0 { [above, below] } else { [below, above] };
            let sheaf = FieldBeam { origin, slope, middle, half_width: rim.0.abs(), left };
            let exact = beams::heights(&self.rows, stop, self.wavelength_nm, &sheaf);
            let first_order = |i: usize| {
                let matrix = front_of(&thin, i);
                matrix.apply(middle, slope)[0].abs() + matrix.apply(rim.0, rim.1)[0].abs()
            };
            for (i, largest) in largest.iter_mut().enumerate() {
                *largest = largest.max(exact.as_ref().map_or_else(|| first_order(i), |heights| heights[i]));
            }
        }
        largest
    }

    /// Writes the conditions of the design into the header.
    fn note_design(&mut self) {
        if let Some(StatedBeam::FNumber(number)) = self.beam {
            self.metadata.f_number = Some(number);
            self.header("f_number", number);
        }
        let widest = self.fields.iter().map(|field| field.y.abs()).fold(0.0, f64::max);
        if self.field_kind == FieldKind::Degrees && widest > 0.0 {
            self.metadata.half_field_deg = Some(widest);
            self.header("half_field_deg", widest);
        }
        if self.object_mm.is_finite() {
            self.header("object_distance", self.object_mm);
        }
    }
}

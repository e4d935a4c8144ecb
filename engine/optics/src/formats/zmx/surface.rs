//! The lines of one surface of a `.zmx` file.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::prescription::{NextMedium, Place};
use crate::surface::{Conic, LAST_POWER};

use super::super::draft_row::DraftRow;
use super::super::problem::{LensFileError, Problem, at};
use super::super::text::{Token, finite};
use super::super::{forbes, frames};
use super::ZmxReader;

/// A thickness that follows from others. Lengths in the file's units.
#[derive(Clone, Copy, Debug)]
pub(super) enum ThicknessSolve {
    /// `TCOM`: with the thickness of a surface before it, a total.
    Compensator { surface: usize, total: f64 },
    /// `TOLE`: with all thicknesses from a surface on, a total.
    Position { surface: usize, total: f64 },
    /// `MAZH` with a height of 0: the next surface stands at the image of first order.
    Image,
}

/// A surface while its lines are read. Lengths in the file's units.
pub(super) struct SurfaceLines {
    place: Place,
    kind: String,
    kind_place: Place,
    curvature: f64,
    conic: f64,
    thickness: f64,
    diameter: Option<f64>,
    /// True if the designer has fixed the diameter: else it is that of the beams in the configuration that the file was saved in.
    is_width_fixed: bool,
    mechanical: Option<f64>,
    /// Inner and outer radius of a round aperture.
    aperture: Option<[f64; 2]>,
    is_floating: bool,
    obstruction: f64,
    glass: Option<(Vec<String>, Place)>,
    is_stop: bool,
    /// A solve for the thickness.
    solve: Option<ThicknessSolve>,
    /// `PARM` and `XDAT`, number and value.
    parameters: Vec<(usize, f64, Place)>,
    extra: Vec<(usize, f64, Place)>,
}

impl SurfaceLines {
    pub(super) fn new(place: Place) -> Self {
        Self {
            place,
            kind: "STANDARD".to_owned(),
            kind_place: place,
            curvature: 0.0,
            conic: 0.0,
            thickness: 0.0,
            diameter: None,
            is_width_fixed: false,
            mechanical: None,
            aperture: None,
            is_floating: false,
            obstruction: 0.0,
            glass: None,
            is_stop: false,
            solve: None,
            parameters: Vec::new(),
            extra: Vec::new(),
        }
    }

    fn parameter(&self, number: usize) -> f64 {
        self.parameters.iter().find(|p| p.0 == number).map_or(0.0, |p| p.1)
    }

    fn extra_value(&self, number: usize) -> f64 {
        self.extra.iter().find(|p| p.0 == number).map_or(0.0, |p| p.1)
    }
}

/// Keywords of surfaces that say nothing of how light goes.
const SILENT: [&str; 21] = [
    "FIMP", "HIDE", "MIRR", "SLAB", "VDSZ", "POPS", "COMM", "PPAR", "VPAR", "XPAR", "DRAW", "CONF", "SCOL", "SNAM",
    "PTYP", "MATR", "TCEM", "GRIN", "RSCE", "OPDX", "CHZN",
];

/// True for keywords that stand in surfaces.
pub(super) fn knows(keyword: &str) -> bool {
    const KNOWN: [&str; 25] = [
        "TYPE", "CURV", "DISZ", "DIAM", "MEMA", "CONI", "PARM", "XDAT", "GLAS", "STOP", "CLAP", "FLAP", "OBSC", "SQAP",
        "SQOB", "ELAP", "ELOB", "UDAP", "OBDC", "COAT", "SCBD", "GLCB", "TCOM", "TOLE", "MAZH",
    ];
    KNOWN.contains(&keyword) || SILENT.contains(&keyword)
}

impl ZmxReader<'_> {
    /// A line of the last surface.
    #[expect(clippy::too_many_lines, reason = "an arm for each keyword")]
    pub(super) fn surface_line(
        &mut self,
        line: usize,
        key: &Token<'_>,
        rest: &[Token<'_>],
    ) -> Result<(), LensFileError> {
        let place = Place { line, column: key.column };
        let first = |reader: &Self| reader.number(line, rest, 0, key.text);
        let pair =
            |reader: &Self| Ok([reader.number(line, rest, 0, key.text)?, reader.number(line, rest, 1, key.text)?]);
        let is_object = self.blocks.len() == 1;
        let Some(index) = self.blocks.len().checked_sub(1) else { return Ok(()) };
        match key.text {
            "TYPE" => {
                let kind = rest.first().map_or("STANDARD", |word| word.text);
                self.blocks[index].kind = kind.to_owned();
                self.blocks[index].kind_place = place;
            }
            "CURV" => self.blocks[index].curvature = first(self)?,
            "CONI" => self.blocks[index].conic = first(self)?,
            "DISZ" => {
                let endless = rest.first().is_some_and(|word| word.text.eq_ignore_ascii_case("INFINITY"));
                if endless && !is_object {
                    let what = "an infinite distance can stand only before the first surface".to_owned();
                    return self.draft.fail(place, Problem::Unsupported(what));
                }
                self.blocks[index].thickness = if endless { f64::INFINITY } else { first(self)? };
            }
            "DIAM" => {
                self.blocks[index].diameter = Some(first(self)?);
                self.blocks[index].is_width_fixed = rest.get(1).is_some_and(|word| word.text != "0");
            }
            "MEMA" => self.blocks[index].mechanical = Some(first(self)?),
            "CLAP" | "FLAP" => {
                self.blocks[index].aperture = Some(pair(self)?);
                // A floating one is as wide as the beams of the configuration, however that is fixed.
                self.blocks[index].is_floating = key.text == "FLAP";
            }
            "TCOM" | "TOLE" => {
                let [surface, total] = pair(self)?;
                let surface = surface.clamp(0.0, 1e6) as usize;
                self.blocks[index].solve = Some(match key.text {
                    "TCOM" => ThicknessSolve::Compensator { surface, total },
                    _ => ThicknessSolve::Position { surface, total },
                });
            }
            "MAZH" if rest.first().is_none_or(|word| finite(word.text) == Some(0.0)) => {
                self.blocks[index].solve = Some(ThicknessSolve::Image);
            }
            "MAZH" => {}
            "OBSC" => {
                let [inner, outer] = pair(self)?;
                if inner > 0.0 {
                    self.draft
                        .remarks
                        .say(place, format!("the obstruction is a ring from {inner}; it is taken as a disc"));
                }
                self.blocks[index].obstruction = outer;
            }
            "SQAP" | "SQOB" | "ELAP" | "ELOB" | "UDAP" => {
                let what = format!("the aperture is not round ('{}'); the clear diameter is taken instead", key.text);
                self.draft.remarks.once(key.text, place, what);
            }
            "OBDC" if self.numbers(line, rest, "OBDC")?.iter().any(|x| *x != 0.0) => {
                let what = "an aperture beside the axis (OBDC) is taken on the axis";
                self.draft.remarks.once(key.text, place, what);
            }
            "OBDC" => {}
            "COAT" => {
                let what = "coatings are left out";
                self.draft.remarks.once(key.text, place, what);
            }
            "SCBD" if rest.iter().filter_map(|word| word.text.parse::<f64>().ok()).any(|x| x != 0.0 && x != 1.0) => {
                let what = "the surface is tilted or decentred (SCBD); only lenses on one axis can be read from .zmx"
                    .to_owned();
                return self.draft.fail(place, Problem::Unsupported(what));
            }
            "SCBD" | "GLCB" => {}
            "STOP" => self.blocks[index].is_stop = true,
            "GLAS" => {
                let words = rest.iter().map(|word| word.text.to_owned()).collect();
                let column = rest.first().map_or(key.column, |word| word.column);
                self.blocks[index].glass = Some((words, Place { line, column }));
            }
            "PARM" | "XDAT" => {
                let [number, value] = pair(self)?;
                let block = &mut self.blocks[index];
                let list = if key.text == "PARM" { &mut block.parameters } else { &mut block.extra };
                if list.len() < 300 {
                    list.push((number.clamp(0.0, 1e6) as usize, value, place));
                }
            }
            known if SILENT.contains(&known) => {}
            other => {
                self.draft.remarks.once(other, place, format!("'{other}' is not understood and left out"));
            }
        }
        Ok(())
    }

    /// Object, surfaces and film from the blocks. Returns the row of each block, if it is one.
    pub(super) fn surfaces(&mut self) -> Result<Vec<Option<usize>>, LensFileError> {
        let scale = self.mm_per_unit;
        let blocks = std::mem::take(&mut self.blocks);
        let [object, surfaces @ .., film] = blocks.as_slice() else {
            let place = Place { line: 1, column: 1 };
            let what =
                "there is no lens; SURF 0 is the object, the last SURF the film, the lens stands between".to_owned();
            return self.draft.fail(place, Problem::Unsupported(what));
        };
        self.draft.object_mm = object.thickness * scale;
        if film.curvature != 0.0 {
            self.draft.film_radius_mm = Some(scale / film.curvature);
        }
        let mut pending = DAffine3::IDENTITY;
        let mut rows = vec![None];
        self.thicknesses = blocks.iter().map(|block| block.thickness).collect();
        self.solves = blocks.iter().map(|block| block.solve).collect();
        for block in surfaces {
            rows.push((block.kind != "COORDBRK").then_some(self.draft.rows.len()));
            if block.kind == "COORDBRK" {
                pending *= self.coordinate_break(block);
                continue;
            }
            let mut row = self.row(block, scale)?;
            row.before = std::mem::replace(&mut pending, DAffine3::IDENTITY);
            if block.is_stop {
                self.draft.stop = Some(self.draft.rows.len());
            }
            self.draft.rows.push(row);
        }
        self.draft.film_frame = pending;
        self.plain_breaks();
        Ok(rows)
    }

    /// The change of coordinates of a coordinate break, mm: parameters 1 and 2 decentre, 3 to 5 turn about x, y and z, 6 says the order.
    fn coordinate_break(&self, block: &SurfaceLines) -> DAffine3 {
        let moved_mm = DVec3::new(block.parameter(1), block.parameter(2), 0.0) * self.mm_per_unit;
        let angles_deg = [3, 4, 5].map(|number| block.parameter(number));
        let change = match block.parameter(6) == 0.0 {
            true => frames::change(moved_mm, angles_deg),
            false => frames::change_turned_first(moved_mm, angles_deg),
        };
        change * DAffine3::from_translation(DVec3::Z * block.thickness * self.mm_per_unit)
    }

    /// Makes thicknesses of coordinate breaks that change none but z: most lenses stand on one axis.
    fn plain_breaks(&mut self) {
        let is_plain =
            |change: &DAffine3| change.matrix3 == DMat3::IDENTITY && change.translation.truncate() == DVec2::ZERO;
        let draft = &mut self.draft;
        if !(draft.rows.iter().all(|row| is_plain(&row.before)) && is_plain(&draft.film_frame)) {
            return;
        }
        for i in 0..draft.rows.len() {
            let mm = std::mem::replace(&mut draft.rows[i].before, DAffine3::IDENTITY).translation.z;
            match i.checked_sub(1) {
                Some(last) => draft.rows[last].thickness_mm += mm,
                None => draft.object_mm += mm,
            }
        }
        let mm = std::mem::replace(&mut draft.film_frame, DAffine3::IDENTITY).translation.z;
        if let Some(last) = draft.rows.last_mut() {
            last.thickness_mm += mm;
        }
    }

    fn row(&mut self, block: &SurfaceLines, scale: f64) -> Result<DraftRow, LensFileError> {
        let mut row = DraftRow::new(block.place);
        row.curvature = block.curvature / scale;
        row.conic = block.conic;
        row.thickness_mm = block.thickness * scale;
        row.behind = self.glass(block)?;
        let rim = block.aperture.map(|[_, outer]| outer).filter(|outer| *outer > 0.0);
        row.has_rim = rim.is_some() || block.obstruction > 0.0;
        row.semi_diameter_mm = rim.or(block.diameter.filter(|d| *d > 0.0)).map(|semi| semi * scale);
        if row.semi_diameter_mm.is_none() {
            row.semi_diameter_mm = block.mechanical.filter(|d| *d > 0.0).map(|semi| semi * scale);
        }
        let hole = block.aperture.map_or(0.0, |[inner, _]| inner);
        row.obstruction_mm = hole.max(block.obstruction) * scale;
        row.is_width_fixed = (row.has_rim || block.is_width_fixed) && !block.is_floating;
        self.shape(block, scale, &mut row)?;
        Ok(row)
    }

    /// Reads the part of the shape that the surface's type adds to curvature and conic constant. The row has its clear diameter already.
    fn shape(&mut self, block: &SurfaceLines, scale: f64, row: &mut DraftRow) -> Result<(), LensFileError> {
        // A coefficient of rᵖ, in the file's units, in mm.
        let term = |power: u32, a: f64| (power, a / scale.powi(power as i32 - 1));
        match block.kind.as_str() {
            "STANDARD" => {}
            "EVENASPH" => row.terms = (1..=8).map(|i| term(2 * i as u32, block.parameter(i))).collect(),
            "ODDASPHE" => row.terms = (1..=8).map(|i| term(i as u32, block.parameter(i))).collect(),
            "XASPHERE" | "XOSPHERE" => {
                let value = |number: usize| block.extra_value(number);
                let (count, radius) = (value(1).clamp(0.0, 240.0) as usize, value(2));
                let step = if block.kind == "XASPHERE" { 2 } else { 1 };
                if count > 0 && !(radius > 0.0) {
                    let what = format!("the asphere's normalization radius is {radius}; it must be larger than 0");
                    return self.draft.fail(block.kind_place, Problem::Unsupported(what));
                }
                for i in 1..=count {
                    let power = (step * i) as u32;
                    row.terms.push(term(power, value(i + 2) / radius.powi(power as i32)));
                }
            }
            "TOROIDAL" => {
                // The second is the radius to which the further terms are normalized.
                if let Some((number, _, place)) = block.extra.iter().find(|p| p.0 > 2 && p.1 != 0.0) {
                    let what = format!("the toroid has further terms (XDAT {number}), which are not supported");
                    return self.draft.fail(*place, Problem::Unsupported(what));
                }
                row.radius_x_mm = Some(block.parameter(1) * scale);
                row.terms = (2..=8).map(|i| term(2 * (i as u32 - 1), block.parameter(i))).collect();
            }
            "QED_TYPE" => row.terms = self.forbes(block, scale, row)?,
            other => {
                let what = format!(
                    "surface type '{other}' is not supported; STANDARD, EVENASPH, ODDASPHE, XASPHERE, XOSPHERE, QED_TYPE and TOROIDAL \
                     are"
                );
                return self.draft.fail(block.kind_place, Problem::Unsupported(what));
            }
        }
        row.terms.retain(|(_, a)| *a != 0.0);
        Ok(())
    }

    /// The terms of a Q-type asphere: XDAT 1 is 0 for Qbfs and 1 for Qcon, 2 the number of coefficients, 3 the radius to which they are
    /// normalized, then the coefficients in the file's units.
    fn forbes(&mut self, block: &SurfaceLines, scale: f64, row: &DraftRow) -> Result<forbes::Terms, LensFileError> {
        let value = |number: usize| block.extra_value(number);
        let (kind, count, radius_mm) = (value(1), value(2).clamp(0.0, 240.0) as usize, value(3) * scale);
        let coefficients_mm: Vec<f64> = (0..count).map(|i| value(i + 4) * scale).collect();
        if coefficients_mm.iter().all(|a| *a == 0.0) {
            return Ok(Vec::new());
        }
        if !(radius_mm > 0.0) {
            let what = format!("the asphere's normalization radius is {radius_mm}; it must be larger than 0");
            return self.draft.fail(block.kind_place, Problem::Unsupported(what));
        }
        if kind == 1.0 {
            return Ok(forbes::conic_based(&coefficients_mm, radius_mm));
        }
        if kind != 0.0 {
            let what = format!("Q-type aspheres are of type 0 (Qbfs) or 1 (Qcon), not {kind}");
            return self.draft.fail(block.kind_place, Problem::Unsupported(what));
        }
        let base = Conic { curvature: row.curvature, conic: row.conic };
        let clear_mm = row.semi_diameter_mm.unwrap_or(radius_mm);
        let Some((terms, miss_mm)) = forbes::slope_orthogonal(&coefficients_mm, radius_mm, base, clear_mm) else {
            let what = format!(
                "the Q-type asphere ends, or is no polynomial of r^{LAST_POWER}, before its clear radius of {clear_mm} mm"
            );
            return self.draft.fail(block.kind_place, Problem::Unsupported(what));
        };
        let what = format!(
            "the Qbfs asphere is taken as powers to r^{LAST_POWER}, which follow its sag within {miss_mm:.1e} mm"
        );
        self.draft.remarks.say(block.kind_place, what);
        Ok(terms)
    }

    fn glass(&mut self, block: &SurfaceLines) -> Result<NextMedium, LensFileError> {
        let Some((words, place)) = &block.glass else { return Ok(NextMedium::Medium(crate::glass::Medium::air())) };
        let name = words.first().map_or("", String::as_str);
        if name.eq_ignore_ascii_case("mirror") {
            return Ok(NextMedium::Mirror);
        }
        let number = |i: usize| words.get(i).and_then(|word| word.parse::<f64>().ok()).filter(|x| x.is_finite());
        let kind = number(1).unwrap_or(0.0);
        let medium = match number(3) {
            // A model glass; a pickup says the same numbers of the glass that it follows.
            Some(nd) if kind == 1.0 || (kind == 2.0 && name.starts_with("___")) => {
                if number(5).is_some_and(|partial| partial != 0.0) {
                    let what = "a model glass departs from the normal line (dPgF); that is left out";
                    self.draft.remarks.once("dPgF", *place, what);
                }
                self.glasses.by_numbers(nd, number(4).unwrap_or(0.0))
            }
            _ => self.glasses.listed(name, *place, &mut self.draft.remarks),
        };
        // An offset: the last two numbers are added to nd and Vd of the catalogue's glass.
        let [more_nd, more_abbe] = [9, 10].map(|i| number(i).filter(|_| kind == 4.0).unwrap_or(0.0));
        if more_abbe != 0.0 {
            let what = format!("'{name}' has an offset of its Abbe number by {more_abbe}; that is left out");
            self.draft.remarks.once("offset", *place, what);
        }
        let medium = medium.map(|medium| if more_nd == 0.0 { medium } else { medium.with_index_shift(more_nd) });
        medium.map(NextMedium::Medium).map_err(|error| at(self.draft.file, place.line, place.column, error.into()))
    }
}

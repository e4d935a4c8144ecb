//! The lines `# key: text` before the rows of a lens file.

use crate::coating::Coating;
use crate::glass::{Dispersion, Gradient, GradientTerm, InternalTransmittance, Medium};
use crate::prescription::{LensGroup, Metadata, Place, PrescriptionError};

use super::columns::{ElementLine, element};
use super::moving::MovingLines;
use super::problem::{LensFileError, Problem};
use super::text::{finite, not_a_number};
use crate::formats::draft::Draft;
use crate::formats::problem::at;

/// Glasses that a file may define, and names that it may give: as many as surfaces.
const MOST_GLASSES: usize = 1000;

fn too_many_glasses() -> Problem {
    Problem::Unsupported(format!("a lens file defines no more than {MOST_GLASSES} glasses"))
}

/// The contents of the lines beside the metadata.
#[derive(Clone, Default)]
pub(crate) struct Header {
    pub(crate) name: Option<String>,
    pub(crate) film_radius_mm: Option<f64>,
    /// Coating of surfaces where glass meets air, if no row says otherwise.
    pub(crate) coating: Option<Coating>,
    pub(super) elements: Vec<ElementLine>,
    pub(super) moving: MovingLines,
    /// Glasses that the file defines itself.
    pub(crate) glasses: Vec<Medium>,
    /// Numbers of the glasses that were added or changed since `Glasses::define_new`.
    pub(crate) changed_glasses: Vec<usize>,
    /// Names that the file has for glasses of the catalogues, since then: name, token, and the line's place.
    pub(crate) new_aliases: Vec<(String, String, Place)>,
    /// Lines about a glass that define none: the name in small letters, the line's place, and its fault. One that no surface asks
    /// for is a remark.
    pub(super) undefined: Vec<(String, Place, Problem)>,
    alias_count: usize,
    /// Files of glasses beside this one, and the places of their names.
    pub(crate) catalogues: Vec<(String, Place)>,
}

/// Keys whose lines are written from the lens itself, not from its file.
pub(super) const OF_THE_LENS: [&str; 9] =
    ["name", "film_radius", "coating", "element", "moving", "position", "glass", "gradient", "transmittance"];

/// Takes a line without its `#`; `place` is its beginning. One without a colon is a remark.
pub(crate) fn line(
    header: &mut Header,
    metadata: &mut Metadata,
    text: &str,
    place: Place,
    file: &str,
) -> Result<(), LensFileError> {
    let Some((key, value)) = text.split_once(':') else { return Ok(()) };
    let (key, value) = (key.trim().to_lowercase(), value.trim());
    let before = value.as_ptr() as usize - text.as_ptr() as usize;
    let place = Place { column: place.column + text[..before].chars().count(), ..place };
    header.take(metadata, &key, value, place).map_err(|problem| at(file, place.line, place.column, problem))?;
    metadata.all.push((key, value.to_owned()));
    Ok(())
}

impl Header {
    fn take(&mut self, metadata: &mut Metadata, key: &str, value: &str, place: Place) -> Result<(), Problem> {
        let number = |text: &str| finite(text).ok_or_else(|| not_a_number(key, text));
        let published = |text: &str| if text == Metadata::NOT_PUBLISHED { Ok(None) } else { number(text).map(Some) };
        match key {
            "name" => self.name = Some(value.to_owned()),
            "source" => metadata.source = Some(value.to_owned()),
            "group" => {
                let group = LensGroup::of_word(value);
                metadata.group = Some(group.ok_or_else(|| Problem::Group(value.to_owned()))?);
            }
            "first_choice" => {
                metadata.is_first_choice = match value {
                    "yes" => true,
                    "no" => false,
                    other => return Err(Problem::YesOrNo(other.to_owned())),
                }
            }
            "focal_length" => metadata.focal_length_mm = published(value)?,
            "f_number" => metadata.f_number = published(value)?,
            "back_focus" => metadata.back_focus_mm = published(value)?,
            "half_field_deg" => metadata.half_field_deg = Some(number(value)?),
            "element" => {
                let element = element(value, place);
                self.elements.push(element.ok_or_else(|| Problem::Element(value.to_owned()))?);
            }
            "moving" => self.moving.moved(value, place)?,
            "position" => self.moving.position(value, place)?,
            "glass" if value.contains('=') => {
                let (name, token) = value.split_once('=').unwrap_or_default();
                self.alias_count += 1;
                if self.alias_count > MOST_GLASSES {
                    return Err(too_many_glasses());
                }
                self.new_aliases.push((name.trim().to_owned(), token.trim().to_owned(), place));
            }
            // A remark about the glasses is none of these, but it may be meant as one.
            "glass" if !is_formula(value) => {
                if let Some(name) = value.split_whitespace().next() {
                    self.undefined.push((name.to_lowercase(), place, Problem::GlassLine(value.to_owned())));
                }
            }
            "glass" if self.glasses.len() >= MOST_GLASSES => return Err(too_many_glasses()),
            "glass" => {
                self.changed_glasses.push(self.glasses.len());
                self.glasses.push(glass(value).ok_or_else(|| Problem::GlassLine(value.to_owned()))?);
            }
            "transmittance" if value.contains('@') => self.transmittance(value)?,
            "gradient" => self.gradient(value)?,
            "catalogue" if is_glass_file(value) => self.catalogues.push((value.to_owned(), place)),
            "coating" => self.coating = Some(Coating::parse(value)?),
            "film_radius" => self.film_radius_mm = Some(number(value)?),
            "film" => {
                let (width, height) = value.split_once('x').unwrap_or((value, value));
                metadata.film_mm = Some([number(width.trim())?, number(height.trim())?]);
            }
            _ => {}
        }
        if self.film_radius_mm == Some(0.0) {
            return Err(PrescriptionError::FilmRadius { radius_mm: 0.0 }.into());
        }
        Ok(())
    }

    /// `NAME 400:0.98@10 ...`: wavelength in nm, transmittance, thickness in mm, of a glass that was defined before.
    fn transmittance(&mut self, value: &str) -> Result<(), Problem> {
        let bad = || Problem::TransmittanceLine(value.to_owned());
        let mut words = value.split_whitespace();
        let name = words.next().ok_or_else(bad)?;
        let number = self.glass_called(name).ok_or_else(bad)?;
        let point = |word: &str| {
            let (nm, rest) = word.split_once(':')?;
            let (part, mm) = rest.split_once('@')?;
            Some([finite(nm)?, finite(part)?, finite(mm)?])
        };
        let points: Option<Vec<[f64; 3]>> = words.map(point).collect();
        let known = points.and_then(InternalTransmittance::new).ok_or_else(bad)?;
        self.glasses[number] = self.glasses[number].clone().with_transmittance(known);
        self.changed_glasses.push(number);
        Ok(())
    }

    /// The number of a glass that was defined before, in any case of letters, as surfaces name it.
    fn glass_called(&self, name: &str) -> Option<usize> {
        self.glasses.iter().position(|glass| glass.name().eq_ignore_ascii_case(name))
    }

    /// Reads `NAME from=1.59 z1=0.05 r2=-0.002 z1r2=0.001`: the gradient of a glass that was defined before, by coefficients of powers of z
    /// and r, and the place of z = 0.
    fn gradient(&mut self, value: &str) -> Result<(), Problem> {
        let bad = |found: &str| Problem::GradientLine(found.to_owned());
        let mut words = value.split_whitespace();
        let name = words.next().ok_or_else(|| bad(value))?;
        let number = self.glass_called(name).ok_or_else(|| bad(name))?;
        let (mut terms, mut from_mm) = (Vec::new(), 0.0);
        for word in words {
            let (key, number) = word.split_once('=').ok_or_else(|| bad(word))?;
            let number = finite(number).ok_or_else(|| bad(word))?;
            match (key, powers(key)) {
                ("from", _) => from_mm = number,
                (_, Some([z, r])) => terms.push(GradientTerm { z, r, coefficient: number }),
                _ => return Err(bad(word)),
            }
        }
        let gradient = Gradient::new(terms, from_mm).ok_or_else(|| bad(value))?;
        self.glasses[number] = self.glasses[number].clone().with_gradient(gradient);
        self.changed_glasses.push(number);
        Ok(())
    }

    /// The line that was to define this glass and does not, and its fault.
    pub(super) fn undefined(&self, name: &str) -> Option<(Place, Problem)> {
        let name = name.to_lowercase();
        self.undefined
            .iter()
            .find(|(undefined, ..)| *undefined == name)
            .map(|(_, place, problem)| (*place, problem.clone()))
    }

    /// Applies the lines to a lens that is read from another program's file.
    pub(crate) fn apply(self, draft: &mut Draft<'_>) -> Result<(), LensFileError> {
        draft.name = self.name.or(draft.name.take());
        draft.coating = self.coating.or(draft.coating.take());
        if let Some((parts, positions, places)) = self.moving.parts() {
            draft.moving = Some((parts, positions, places));
        }
        Ok(())
    }
}

/// True if the second word names a formula.
fn is_formula(value: &str) -> bool {
    value.split_whitespace().nth(1).is_some_and(|word| Dispersion::WORDS.contains(&word.to_lowercase().as_str()))
}

/// True if this is the name of a glass catalogue's file.
fn is_glass_file(value: &str) -> bool {
    let lower = value.to_lowercase();
    lower.ends_with(".agf") || lower.ends_with(".yml")
}

/// `z2`, `r4`, `z1r2`: the powers of z and r.
fn powers(key: &str) -> Option<[u32; 2]> {
    let (z, r) = match key.split_once('r') {
        Some((z, r)) => (z, r.parse().ok()?),
        None => (key, 0),
    };
    let z = if z.is_empty() { 0 } else { z.strip_prefix('z')?.parse().ok()? };
    Some([z, r])
}

/// `NAME FORMULA FROM-TO NUMBERS`: the range in nm, the formula and its numbers as glass files have them.
fn glass(value: &str) -> Option<Medium> {
    let mut words = value.split_whitespace();
    let (name, formula, range) = (words.next()?, words.next()?, words.next()?);
    let (from, to) = range.split_once('-')?;
    let end = |text: &str| if text == "inf" { Some(f64::INFINITY) } else { finite(text) };
    let range_nm = [end(from)?, end(to)?];
    let numbers: Option<Vec<f64>> = words.map(finite).collect();
    let dispersion = Dispersion::from_words(&formula.to_lowercase(), &numbers?)?;
    let medium = Medium::new(name, dispersion, range_nm, "the lens file");
    let is_range = range_nm[0] >= 0.0 && range_nm[0] < range_nm[1];
    (is_range && medium.is_plausible()).then_some(medium)
}

/// The line of a glass that stands in no catalogue; `None` for a medium that cannot be written.
pub(super) fn glass_lines(medium: &Medium) -> Option<Vec<String>> {
    let (word, numbers) = medium.dispersion().words()?;
    let [from, to] = medium.range_nm();
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    let mut lines = vec![format!("glass: {} {word} {from}-{to} {}", medium.name(), numbers.join(" "))];
    if let Some(gradient) = medium.gradient() {
        let from = if gradient.from_mm() == 0.0 { String::new() } else { format!(" from={}", gradient.from_mm()) };
        let power = |letter: &str, power: u32| if power == 0 { String::new() } else { format!("{letter}{power}") };
        let term = |t: &GradientTerm| format!(" {}{}={}", power("z", t.z), power("r", t.r), t.coefficient);
        let terms: String = gradient.terms().iter().map(term).collect();
        lines.push(format!("gradient: {}{from}{terms}", medium.name()));
    }
    if let Some(known) = medium.transmittance() {
        let points: Vec<String> = known.points().iter().map(|[nm, part, mm]| format!("{nm}:{part}@{mm}")).collect();
        lines.push(format!("transmittance: {} {}", medium.name(), points.join(" ")));
    }
    Some(lines)
}

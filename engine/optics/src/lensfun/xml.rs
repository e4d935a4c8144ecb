//! A lensfun database's XML, versions 1 and 2, as lenses and camera bodies.

use petzval_files::one_line;
use roxmltree::{Document, Node, ParsingOptions};

use super::calibrated_lens::{CalibratedLens, CalibrationSet, DistortionRow, LateralColourRow, VignettingRow};
use super::distortion::DistortionModel;
use super::lateral_colour::LateralColourModel;
use super::vignetting::VignettingModel;
use super::{Body, LensfunError, Projection, Sensor};

/// The most elements, attributes and texts of a file: 40 times those of lensfun's largest.
const MOST_NODES: u32 = 2_000_000;

/// The largest number of a lens, and the smallest of those above zero: the formulae's powers of them are numbers, too.
const LARGEST: f64 = 1e9;
const SMALLEST: f64 = 1e-9;

/// A file that is being read.
struct Reader<'a> {
    file: &'a str,
    document: &'a Document<'a>,
}

/// The lenses and camera bodies in the text of a file.
pub(super) fn parse(text: &str, file: &str) -> Result<(Vec<CalibratedLens>, Vec<Body>), LensfunError> {
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        let what = one_line(&format!("this is no XML ({error}); give a lensfun database"));
        LensfunError::Content { file: file.to_owned(), line: at.row, column: at.col, what }
    })?;
    let reader = Reader { file, document: &document };
    let root = document.root_element();
    if !root.has_tag_name("lensdatabase") {
        let what = format!("<{}> where <lensdatabase> belongs; give a lensfun database", root.tag_name().name());
        return Err(reader.wrong(root, what));
    }
    let lenses = children(root, "lens").map(|lens| reader.lens(lens)).collect::<Result<_, _>>()?;
    let bodies = children(root, "camera").map(|body| reader.body(body)).collect::<Result<_, _>>()?;
    Ok((lenses, bodies))
}

fn children<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// The English text of the first child of that name, else as [`text`].
fn english_text<'a>(node: Node<'a, '_>, name: &'static str) -> Option<&'a str> {
    let english = children(node, name).find(|child| child.attribute("lang") == Some("en"));
    english.map_or_else(|| text(node, name), |child| child.text().map(str::trim))
}

/// The text of the first child of that name that is in no other language.
fn text<'a>(node: Node<'a, '_>, name: &'static str) -> Option<&'a str> {
    let named = || children(node, name);
    let plain = named().find(|child| child.attribute("lang").is_none_or(|lang| lang == "en"));
    plain.or_else(|| named().next())?.text().map(str::trim)
}

/// A name, its words parted by single blanks however the file breaks its lines.
fn name_of(text: Option<&str>) -> String {
    text.unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

impl Reader<'_> {
    fn wrong(&self, node: Node<'_, '_>, what: String) -> LensfunError {
        let at = self.document.text_pos_at(node.range().start);
        LensfunError::Content { file: self.file.to_owned(), line: at.row, column: at.col, what: one_line(&what) }
    }

    /// An attribute that is a number.
    fn number(&self, node: Node<'_, '_>, name: &str) -> Result<Option<f64>, LensfunError> {
        let Some(given) = node.attribute(name) else { return Ok(None) };
        let value = given.trim().parse::<f64>().ok().filter(|value| value.abs() <= LARGEST);
        let what = || {
            format!("{name}=\"{given}\" of <{}> is not a finite number up to 1e9; write one", node.tag_name().name())
        };
        value.map(Some).ok_or_else(|| self.wrong(node, what()))
    }

    fn term(&self, node: Node<'_, '_>, name: &str) -> Result<f64, LensfunError> {
        Ok(self.number(node, name)?.unwrap_or(0.0))
    }

    /// An attribute that is a number above zero.
    fn positive(&self, node: Node<'_, '_>, name: &str) -> Result<f64, LensfunError> {
        let value = self.number(node, name)?.filter(|value| *value >= SMALLEST);
        value.ok_or_else(|| self.wrong(node, format!("<{}> needs {name} above zero", node.tag_name().name())))
    }

    fn lens(&self, node: Node<'_, '_>) -> Result<CalibratedLens, LensfunError> {
        let model = name_of(text(node, "model"));
        let sensor = Sensor {
            crop_factor: self.positive_text(node, "cropfactor", 1.0)?,
            aspect_ratio: self.positive_text(node, "aspect-ratio", 1.5)?,
        };
        let sets = children(node, "calibration").map(|set| self.set(set, sensor)).collect::<Result<Vec<_>, _>>()?;
        let mut centre = [0.0; 2];
        if let Some(given) = children(node, "center").next() {
            centre = [self.term(given, "x")?, self.term(given, "y")?];
        }
        let projection = match text(node, "type") {
            None => Some(Projection::default()),
            Some("panoramic" | "equirectangular") => None,
            Some(word) => {
                let known = Projection::by_word(word);
                Some(known.ok_or_else(|| self.wrong(node, format!("'{word}' is no type of lens that lensfun has")))?)
            }
        };
        let focal_range_mm = match children(node, "focal").next() {
            Some(given) => self.focal_range(given)?,
            None => None,
        };
        let focal_range_mm = focal_range_mm.or_else(|| focal_range_of_name(&model)).unwrap_or_else(|| of_rows(&sets));
        Ok(CalibratedLens {
            maker: name_of(text(node, "maker")),
            model,
            mounts: children(node, "mount").filter_map(|mount| Some(mount.text()?.trim().to_owned())).collect(),
            projection,
            focal_range_mm,
            centre,
            sets,
            place: (self.file.to_owned(), self.document.text_pos_at(node.range().start).row),
        })
    }

    fn body(&self, node: Node<'_, '_>) -> Result<Body, LensfunError> {
        Ok(Body {
            maker: name_of(english_text(node, "maker")),
            model: name_of(english_text(node, "model")),
            crop_factor: self.positive_text(node, "cropfactor", 1.0)?,
        })
    }

    fn focal_range(&self, node: Node<'_, '_>) -> Result<Option<[f64; 2]>, LensfunError> {
        let both = self.number(node, "value")?;
        let (low, high) = (self.number(node, "min")?.or(both), self.number(node, "max")?.or(both));
        Ok(low.zip(high).map(|(low, high)| [low, high]).filter(|[low, high]| *low >= SMALLEST && high >= low))
    }

    /// A child's text that is a number above zero, or a ratio of two such.
    fn positive_text(&self, node: Node<'_, '_>, name: &'static str, otherwise: f64) -> Result<f64, LensfunError> {
        let Some(given) = text(node, name) else { return Ok(otherwise) };
        self.ratio(node, name, given)
    }

    fn ratio(&self, node: Node<'_, '_>, name: &str, given: &str) -> Result<f64, LensfunError> {
        let (above, below) = given.split_once(':').unwrap_or((given, "1"));
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
        let value = number(above).zip(number(below)).map(|(above, below)| above / below);
        let value = value.filter(|value| (SMALLEST..=LARGEST).contains(value));
        value.ok_or_else(|| self.wrong(node, format!("{name} '{given}' is not a number above zero; write one")))
    }

    fn set(&self, node: Node<'_, '_>, mut sensor: Sensor) -> Result<CalibrationSet, LensfunError> {
        if let Some(given) = node.attribute("cropfactor") {
            sensor.crop_factor = self.ratio(node, "cropfactor", given)?;
        }
        if let Some(given) = node.attribute("aspect-ratio") {
            sensor.aspect_ratio = self.ratio(node, "aspect-ratio", given)?;
        }
        let mut set = CalibrationSet { sensor, distortion: vec![], lateral_colour: vec![], vignetting: vec![] };
        for row in node.children().filter(Node::is_element) {
            match (row.tag_name().name(), row.attribute("model").unwrap_or("none")) {
                (_, "none") => {}
                ("distortion", model) => set.distortion.push(self.distortion(row, model)?),
                ("tca", model) => set.lateral_colour.push(self.lateral_colour(row, model)?),
                ("vignetting", model) => set.vignetting.push(self.vignetting(row, model)?),
                // Real focal lengths of version 1 and crops of fisheye pictures are none of these.
                _ => {}
            }
        }
        Ok(set)
    }

    fn distortion(&self, row: Node<'_, '_>, model: &str) -> Result<DistortionRow, LensfunError> {
        let term = |name: &str| self.term(row, name);
        let model = match model {
            "poly3" => DistortionModel::Poly3([term("k1")?]),
            "poly5" => DistortionModel::Poly5([term("k1")?, term("k2")?]),
            "ptlens" => DistortionModel::PtLens([term("a")?, term("b")?, term("c")?]),
            "acm" => DistortionModel::Adobe([term("k1")?, term("k2")?, term("k3")?, term("k4")?, term("k5")?]),
            other => return Err(self.unknown(row, other)),
        };
        if !(model.central_scale() > 0.0) {
            return Err(self.wrong(row, "this distortion leaves no picture on the axis; check its terms".to_owned()));
        }
        let focal_mm = self.positive(row, "focal")?;
        let measured = self.number(row, "real-focal")?.filter(|focal| *focal >= SMALLEST);
        let real_focal_mm = measured.unwrap_or(focal_mm * model.central_scale());
        Ok(DistortionRow { focal_mm, real_focal_mm, model })
    }

    fn lateral_colour(&self, row: Node<'_, '_>, model: &str) -> Result<LateralColourRow, LensfunError> {
        let pair = |red: &str, blue: &str, otherwise: f64| -> Result<[f64; 2], LensfunError> {
            let value = |name| Ok(self.number(row, name)?.unwrap_or(otherwise));
            Ok([value(red)?, value(blue)?])
        };
        let model = match model {
            "linear" => LateralColourModel::Linear(pair("kr", "kb", 1.0)?),
            "poly3" => {
                LateralColourModel::Poly3([pair("vr", "vb", 1.0)?, pair("cr", "cb", 0.0)?, pair("br", "bb", 0.0)?])
            }
            "acm" => LateralColourModel::Adobe([
                pair("alpha0", "beta0", 1.0)?,
                pair("alpha1", "beta1", 0.0)?,
                pair("alpha2", "beta2", 0.0)?,
                pair("alpha3", "beta3", 0.0)?,
                pair("alpha4", "beta4", 0.0)?,
                pair("alpha5", "beta5", 0.0)?,
            ]),
            other => return Err(self.unknown(row, other)),
        };
        Ok(LateralColourRow { focal_mm: self.positive(row, "focal")?, model })
    }

    fn vignetting(&self, row: Node<'_, '_>, model: &str) -> Result<VignettingRow, LensfunError> {
        let term = |name: &str| self.term(row, name);
        let model = match model {
            "pa" => VignettingModel::Pa([term("k1")?, term("k2")?, term("k3")?]),
            "acm" => VignettingModel::Adobe([term("alpha1")?, term("alpha2")?, term("alpha3")?]),
            other => return Err(self.unknown(row, other)),
        };
        let [focal_mm, f_number, distance_m] =
            [self.positive(row, "focal")?, self.positive(row, "aperture")?, self.positive(row, "distance")?];
        Ok(VignettingRow { focal_mm, f_number, distance_m, model })
    }

    fn unknown(&self, row: Node<'_, '_>, model: &str) -> LensfunError {
        let what = format!("the model '{model}' of <{}> is none that is known of lensfun", row.tag_name().name());
        self.wrong(row, what)
    }
}

/// Marked focal lengths in a lens's name, as `24-70mm` or `50 mm`; lensfun guesses them likewise where the database has none. Converters
/// and adapters state no focal length of their own.
fn focal_range_of_name(model: &str) -> Option<[f64; 2]> {
    let model = model.to_lowercase();
    if ["adapter", "reducer", "booster", "extender", "converter", "magnifier"].iter().any(|word| model.contains(word)) {
        return None;
    }
    let before = model.match_indices("mm").map(|(at, _)| model[..at].trim_end());
    let range = |text: &str| {
        let other = |c: char| !(c.is_ascii_digit() || c == '.' || c == '-');
        let number = text.rsplit(other).next()?.trim_matches('-');
        let (low, high) = number.split_once('-').unwrap_or((number, number));
        let (low, high) = (low.parse::<f64>().ok()?, high.parse::<f64>().ok()?);
        (low >= SMALLEST && high >= low && high <= LARGEST).then_some([low, high])
    };
    before.filter_map(range).next()
}

/// The shortest and the longest focal length of the rows; 1 where there is none.
fn of_rows(sets: &[CalibrationSet]) -> [f64; 2] {
    let focal = sets.iter().flat_map(|set| {
        let distortion = set.distortion.iter().map(|row| row.focal_mm);
        let colour = set.lateral_colour.iter().map(|row| row.focal_mm);
        distortion.chain(colour).chain(set.vignetting.iter().map(|row| row.focal_mm))
    });
    let ends = focal.map(|f| [f, f]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    ends.unwrap_or([1.0, 1.0])
}

#[cfg(test)]
mod tests {
    use super::focal_range_of_name;

    #[test]
    fn names_have_focal_lengths() {
        assert_eq!(focal_range_of_name("Nikkor Z 24-70mm f/4 S"), Some([24.0, 70.0]));
        assert_eq!(focal_range_of_name("E PZ 16-50mm f/3.5-5.6 OSS"), Some([16.0, 50.0]));
        assert_eq!(focal_range_of_name("Fisheye 7.5 mm f/3.5 UMC"), Some([7.5, 7.5]));
        assert_eq!(focal_range_of_name("Ø10mm – 5mm"), Some([10.0, 10.0]));
        assert_eq!(focal_range_of_name("300mm + 1.4x converter"), None);
        assert_eq!(focal_range_of_name("GR & compatibles"), None);
    }
}

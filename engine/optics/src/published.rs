//! Numbers that the source of a lens states, beside those computed from its surfaces.
//!
//! Focal length, f-number and back focus in the header of a lens file are the source's. They are held against the computed values at
//! the d line, to half of a unit of their last digit. Where a source rounds more than that, or its numbers do not give its published
//! values, the header says why: `# differs: f_number: the clear apertures are modelled`.

use serde::Serialize;

use crate::axial_beam;
use crate::glass::line_nm;
use crate::paraxial::Paraxial;
use crate::prescription::{Metadata, Prescription};
use crate::system::{LensSettings, System, SystemError};

/// A whole number of millimetres is no claim to half of one where the lens is short: of a focal length no more than this part is left to
/// rounding, and of an f-number, of which makers engrave the nearest usual one, this.
const FOCAL_LENGTH_PART: f64 = 0.01;
const F_NUMBER_PART: f64 = 0.03;
/// Numbers that are written out of other numbers are off in their last place.
const ROUNDING: f64 = 1e-9;

/// The focal length of one position of a zoom.
const ZOOM: &str = "zoom";

/// One number of the source.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Published {
    /// The key in the header; `zoom`: the focal length of a position.
    pub key: &'static str,
    /// The text in the header; `None`: it states nothing.
    pub text: Option<String>,
    /// The number; `None` also where the header says that none is published.
    pub value: Option<f64>,
    /// The number computed from the surfaces; `None`: the lens has no such number.
    pub computed: Option<f64>,
    /// True if the computed number is the published one, to its digits; `None`: none is published.
    pub agrees: Option<bool>,
    /// The reason of the difference, from the header.
    pub why: Option<String>,
}

impl Published {
    fn new(metadata: &Metadata, key: &'static str, text: Option<String>, computed: Option<f64>) -> Self {
        let value = text.as_deref().and_then(|text| text.parse::<f64>().ok());
        let agrees = value.zip(text.as_deref()).map(|(value, text)| {
            let part = match key {
                "f_number" => F_NUMBER_PART,
                "back_focus" => f64::INFINITY,
                _ => FOCAL_LENGTH_PART,
            };
            let room = half_unit(text).min(part * value.abs()) + ROUNDING * value.abs();
            computed.is_some_and(|computed| (computed - value).abs() <= room)
        });
        // Of a zoom's positions some agree and some do not.
        let why = metadata.difference(key).filter(|_| key != ZOOM || agrees == Some(false));
        Self { key, text, value, computed, agrees, why: why.map(str::to_owned) }
    }

    /// True if nothing is left to explain: the numbers agree and the header does not say otherwise, or they differ and the header says why,
    /// or the header says that the source states none.
    pub fn is_accounted_for(&self) -> bool {
        match self.agrees {
            Some(agrees) => agrees == self.why.is_none(),
            None => self.text.as_deref() == Some(Metadata::NOT_PUBLISHED) && self.why.is_none(),
        }
    }
}

/// The numbers of a lens's source beside those of its surfaces, at the d line: focal length on the side of the scene (of a zoom at each
/// of its positions instead), f-number of the beam that comes through wide open, and back focus. Of a zoom f-number and back focus are
/// those of its first position.
pub fn compare(lens: &Prescription) -> Result<Vec<Published>, SystemError> {
    let metadata = &lens.metadata;
    let of =
        |key: &'static str, computed| Published::new(metadata, key, metadata.text(key).map(str::to_owned), computed);
    let settings = LensSettings::default();
    let system = System::new(lens, &settings)?;
    let mut found = Vec::new();
    let zooms: Vec<f64> = match &lens.moving {
        Some(moving) if moving.zoom_range_mm().is_some() => {
            let at_infinity = moving.positions().into_iter().filter(|position| position.focus_mm.is_infinite());
            at_infinity.filter_map(|position| position.zoom_mm).collect()
        }
        _ => Vec::new(),
    };
    if zooms.is_empty() {
        found.push(of("focal_length", axial_beam::front_focal_length_mm(&system, line_nm::D)));
    }
    for zoom_mm in zooms {
        let there = System::new(&lens.at_position(zoom_mm, 0.0), &settings)?;
        let computed = axial_beam::front_focal_length_mm(&there, line_nm::D);
        found.push(Published::new(metadata, ZOOM, Some(zoom_mm.to_string()), computed));
    }
    found.push(of("f_number", axial_beam::f_number(&system, line_nm::D)));
    found.push(of("back_focus", Paraxial::new(&system, line_nm::D).bfd_mm));
    Ok(found)
}

/// Half of a unit of the last digit of a number: 0.05 of `5.6`, 0.5 of `100`.
fn half_unit(text: &str) -> f64 {
    let digits =
        text.split_once('.').map_or(0, |(_, fraction)| fraction.chars().take_while(char::is_ascii_digit).count());
    0.5 * 0.1f64.powi(i32::try_from(digits).unwrap_or(i32::MAX))
}

#[cfg(test)]
mod tests {
    use super::{Published, compare, half_unit};
    use crate::formats::lens::parse;
    use crate::glass::Catalogue;

    /// A paraboloid of 1000 mm and 200 mm diameter.
    fn of_header(header: &str) -> Vec<Published> {
        let text = format!("{header}\n-2000 -1000 mirror 200 -1 1");
        compare(&parse(&text, "test", Catalogue::shipped()).unwrap()).unwrap()
    }

    #[test]
    fn digits_say_how_near() {
        assert_eq!((half_unit("5.6"), half_unit("100"), half_unit("22.0")), (0.05, 0.5, 0.05));
        let agrees = |header: &str| of_header(header).iter().map(|one| one.agrees).collect::<Vec<_>>();
        assert_eq!(
            agrees("# focal_length: 1000\n# f_number: 5\n# back_focus: -1000.4"),
            [Some(true), Some(true), Some(false)]
        );
        assert_eq!(
            agrees("# focal_length: 1000.06\n# f_number: 4.8\n# back_focus: -1000"),
            [Some(false), Some(false), Some(true)]
        );
    }

    #[test]
    fn what_differs_is_explained_and_what_does_not_is_not() {
        let accounted = |header: &str| of_header(header).iter().map(Published::is_accounted_for).collect::<Vec<_>>();
        assert_eq!(accounted(""), [false; 3]);
        let nothing = "# focal_length: not published\n# f_number: not published\n# back_focus: not published";
        assert_eq!(accounted(nothing), [true; 3]);
        assert_eq!(accounted("# focal_length: 999\n# f_number: 5\n# back_focus: -1000"), [false, true, true]);
        let why = "# differs: focal_length: a misprint";
        assert_eq!(accounted(&format!("# focal_length: 999\n# f_number: 5\n# back_focus: -1000\n{why}")), [true; 3]);
        assert!(!accounted(&format!("# focal_length: 1000\n# f_number: 5\n# back_focus: -1000\n{why}"))[0]);
        assert!(!accounted(&format!("{nothing}\n{why}"))[0]);
    }
}

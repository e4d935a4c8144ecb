//! Lens files from prescriptions: a written file reads back as the same lens, to the last bit.

use std::borrow::Cow;
use std::fmt::Write;

use crate::coating::Coating;
use crate::glass::{Catalogue, Medium};
use crate::prescription::{NextMedium, Prescription, SurfaceRow};
use crate::surface::{Section, Shape};

use super::super::columns::{COATING, Misalignment, NO_COATING_SAID, OBSTRUCTION, POSE, RADIUS_X};
use super::super::header::{OF_THE_LENS, glass_lines};

/// The text of a lens file, and the parts of the lens that cannot stand in one.
pub fn write(lens: &Prescription, catalogue: &Catalogue) -> (String, Vec<String>) {
    let lens = &*with_glasses_apart(lens, catalogue);
    let mut text = String::new();
    let mut lost = Vec::new();
    for line in header_lines(lens, catalogue, &mut lost) {
        let _ = writeln!(text, "# {line}");
    }
    let extra = extra_columns(lens);
    let _ = writeln!(
        text,
        "#radius thickness glass diameter conic isstop{}",
        extra.iter().map(Extra::name).collect::<String>()
    );
    for (i, row) in lens.surfaces.iter().enumerate() {
        let profile = row.shape.profile();
        let glass = match &row.behind {
            NextMedium::Mirror => "mirror".to_owned(),
            NextMedium::Medium(medium) => token(medium, catalogue),
        };
        let _ = write!(
            text,
            "{} {} {glass} {} {} {}",
            radius_text(profile.base.curvature),
            row.thickness_mm,
            2.0 * row.semi_diameter_mm,
            profile.base.conic,
            u8::from(i == lens.stop)
        );
        for column in &extra {
            let _ = write!(text, " {}", column.cell(row, i, &mut lost));
        }
        text.push('\n');
    }
    (text, lost)
}

/// The lens, with a name of its own for each glass that a file of it defines: files of other programs may define a name again, and the
/// rows before it keep their glass. Later glasses of a name are numbered from 2.
pub(in crate::formats) fn with_glasses_apart<'a>(
    lens: &'a Prescription,
    catalogue: &Catalogue,
) -> Cow<'a, Prescription> {
    let mut named = Cow::Borrowed(lens);
    // Each glass as it stands in the lens, and by the name that it gets.
    let mut known: Vec<(Medium, Medium)> = Vec::new();
    for (i, row) in lens.surfaces.iter().enumerate() {
        let NextMedium::Medium(medium) = &row.behind else { continue };
        let defined = medium.as_defined();
        if catalogue.token_of(&defined).is_some() {
            continue;
        }
        let name = match known.iter().find(|(before, _)| *before == defined) {
            Some((_, after)) => after.name().to_owned(),
            None => {
                let is_taken = |name: &str| known.iter().any(|(_, after)| after.name().eq_ignore_ascii_case(name));
                let own = defined.name();
                let numbered = (2..).map(|number| format!("{own}_{number}"));
                let mut names = std::iter::once(own.to_owned())
                    .filter(|name| !is_taken(name))
                    .chain(numbered.filter(|name| !is_taken(name) && catalogue.medium(name).is_err()));
                let name = names.next().expect("endless");
                known.push((defined.clone(), defined.with_name(&name)));
                name
            }
        };
        if name != medium.name() {
            named.to_mut().surfaces[i].behind = NextMedium::Medium(medium.with_name(&name));
        }
    }
    named
}

/// The lines of the header, without their `#`.
pub(in crate::formats) fn header_lines(
    lens: &Prescription,
    catalogue: &Catalogue,
    lost: &mut Vec<String>,
) -> Vec<String> {
    let mut lines = vec![format!("name: {}", one_line(&lens.name))];
    for (key, value) in lens.metadata.all.iter().filter(|(key, _)| !OF_THE_LENS.contains(&key.as_str())) {
        lines.push(format!("{key}: {}", one_line(value)));
    }
    if let Some(radius_mm) = lens.film_radius_mm {
        lines.push(format!("film_radius: {radius_mm}"));
    }
    if let Some(coating) = common_coating(lens) {
        lines.push(format!("coating: {}", coating.name()));
    }
    let mut defined: Vec<Medium> = Vec::new();
    let media = lens.surfaces.iter().filter_map(|row| match &row.behind {
        NextMedium::Medium(medium) => Some(medium.as_defined()),
        NextMedium::Mirror => None,
    });
    for medium in media {
        let is_known = catalogue.token_of(&medium).is_some() || defined.contains(&medium);
        if !is_known {
            match glass_lines(&medium) {
                Some(glass) => lines.extend(glass),
                None => lost.push(format!("the medium '{}' cannot be written", medium.name())),
            }
            defined.push(medium);
        }
    }
    if let Some(moving) = &lens.moving {
        let parts: Vec<String> = moving.parts().iter().map(ToString::to_string).collect();
        lines.push(format!("moving: {}", parts.join(" ")));
        for position in moving.positions() {
            let zoom = position.zoom_mm.map_or(String::new(), |mm| format!("zoom={mm} "));
            let values: Vec<String> = position.values.iter().map(f64::to_string).collect();
            lines.push(format!("position: {zoom}focus={} {}", position.focus_mm, values.join(" ")));
        }
    }
    lines
}

/// The coating of all surfaces where glass meets air, if they have one in common and no other surface has any.
pub(in crate::formats) fn common_coating(lens: &Prescription) -> Option<&Coating> {
    let in_air = lens.in_air();
    let first = lens.surfaces[*in_air.first()?].coating.as_ref()?;
    let agrees = |(i, row): (usize, &SurfaceRow)| match row.coating.as_ref() {
        Some(coating) => in_air.contains(&i) && coating == first,
        None => !in_air.contains(&i),
    };
    lens.surfaces.iter().enumerate().all(agrees).then_some(first)
}

/// A text without line ends.
pub(in crate::formats) fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ").trim().to_owned()
}

/// The text for a medium: its name in the catalogues, or that of a glass defined in the header.
fn token(medium: &Medium, catalogue: &Catalogue) -> String {
    catalogue.token_of(&medium.as_defined()).unwrap_or_else(|| medium.name().to_owned())
}

/// The shortest radius whose reciprocal is `curvature`, or `1/curvature` where no number has that.
fn radius_text(curvature: f64) -> String {
    if curvature == 0.0 {
        return "0".to_owned();
    }
    let mut radius = 1.0 / curvature;
    for _ in 0..4 {
        radius = radius.next_down();
    }
    let mut best: Option<String> = None;
    for _ in 0..9 {
        if 1.0 / radius == curvature {
            let text = radius.to_string();
            if best.as_ref().is_none_or(|best| text.len() < best.len()) {
                best = Some(text);
            }
        }
        radius = radius.next_up();
    }
    best.unwrap_or_else(|| format!("1/{curvature}"))
}

/// A column after the usual ones.
enum Extra {
    Obstruction,
    RadiusX,
    Coating,
    Term(u32),
    /// A decentre or tilt: its index in [`POSE`].
    Pose(usize),
}

impl Extra {
    fn name(&self) -> String {
        match self {
            Self::Obstruction => format!(" {OBSTRUCTION}"),
            Self::RadiusX => format!(" {RADIUS_X}"),
            Self::Coating => format!(" {COATING}"),
            Self::Term(power) => format!(" a{power}"),
            Self::Pose(part) => format!(" {}", POSE[*part]),
        }
    }

    fn cell(&self, row: &SurfaceRow, surface: usize, lost: &mut Vec<String>) -> String {
        match self {
            Self::Obstruction => (2.0 * row.obstruction_mm).to_string(),
            Self::RadiusX => {
                let profile = row.shape.profile();
                let is_sphere = profile.base.conic == 0.0 && profile.terms().is_empty();
                if row.shape.is_rotationally_symmetric() && !is_sphere {
                    lost.push(format!(
                        "surface {surface} is one of revolution, which beside a toroid comes back as one"
                    ));
                }
                let text = radius_text(row.shape.curvature_at_vertex(Section::X));
                if let Some(curvature) = text.strip_prefix("1/") {
                    lost.push(format!("surface {surface}: radius_x is rounded"));
                    return curvature.parse::<f64>().map_or(text.clone(), |c| (1.0 / c).to_string());
                }
                text
            }
            Self::Coating => row.coating.as_ref().map_or(NO_COATING_SAID, Coating::name).to_owned(),
            Self::Pose(part) => Misalignment::of(&row.pose)[*part].to_string(),
            Self::Term(power) => {
                let terms = row.shape.profile().terms();
                terms.iter().find(|(p, _)| p == power).map_or("0".to_owned(), |(_, a)| a.to_string())
            }
        }
    }
}

/// The columns that some surface needs.
fn extra_columns(lens: &Prescription) -> Vec<Extra> {
    let mut columns = Vec::new();
    if lens.surfaces.iter().any(|row| row.obstruction_mm != 0.0) {
        columns.push(Extra::Obstruction);
    }
    if lens.surfaces.iter().any(|row| matches!(row.shape, Shape::Toroid(_))) {
        columns.push(Extra::RadiusX);
    }
    if common_coating(lens).is_none() && lens.surfaces.iter().any(|row| row.coating.is_some()) {
        columns.push(Extra::Coating);
    }
    let mut powers: Vec<u32> =
        lens.surfaces.iter().flat_map(|row| row.shape.profile().terms()).map(|(power, _)| power).collect();
    powers.sort_unstable();
    powers.dedup();
    columns.extend(powers.into_iter().map(Extra::Term));
    let poses: Vec<[f64; 6]> = lens.surfaces.iter().map(|row| Misalignment::of(&row.pose)).collect();
    columns.extend((0..POSE.len()).filter(|&part| poses.iter().any(|pose| pose[part] != 0.0)).map(Extra::Pose));
    columns
}

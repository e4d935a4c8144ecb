//! `.zmx` files from prescriptions. The reader of this crate gets the same lens back, to the last bit; OpticStudio gets surfaces,
//! glasses, apertures, fields and wavelengths.

use std::fmt::Write;

use crate::glass::{Catalogue, Medium, line_nm};
use crate::prescription::moving::{MovingParts, Quantity};
use crate::prescription::{NextMedium, Prescription, SurfaceRow};
use crate::surface::{Section, Shape};

use super::super::lens::{common_coating, header_lines, one_line, with_glasses_apart};

/// The catalogues that OpticStudio calls so, by our makers.
const CATALOGUES: [(&str, &str); 8] = [
    ("schott", "SCHOTT"),
    ("schott-old", "SCHOTT"),
    ("ohara", "OHARA"),
    ("hoya", "HOYA"),
    ("hikari", "NIKON-HIKARI"),
    ("cdgm", "CDGM"),
    ("sumita", "SUMITA"),
    ("other", "MISC"),
];

/// The text of a file, and the parts of the lens that cannot stand in one.
pub fn write(lens: &Prescription, catalogue: &Catalogue) -> (String, Vec<String>) {
    let lens = &*with_glasses_apart(lens, catalogue);
    let mut text = String::new();
    let mut lost = Vec::new();
    let glasses: Vec<Glass> = lens.surfaces.iter().map(|row| glass(row, catalogue)).collect();
    let mut listed: Vec<&str> = glasses.iter().filter_map(|glass| glass.listed).collect();
    listed.sort_unstable();
    listed.dedup();

    let _ = writeln!(text, "VERS 161019 0 0\nMODE SEQ\nNAME {}", one_line(&lens.name));
    for line in header_lines(lens, catalogue, &mut lost) {
        let _ = writeln!(text, "NOTE 0 # {line}");
    }
    // Names that several makers use, for those who read them here.
    let mut said: Vec<&str> = Vec::new();
    for (name, token) in glasses.iter().filter_map(|glass| glass.alias.as_ref()) {
        if !said.contains(&name.as_str()) {
            let _ = writeln!(text, "NOTE 0 # glass: {name} = {token}");
            said.push(name);
        }
    }
    let _ = writeln!(text, "UNIT MM X W X CM MR CPMM\nFLOA\nENVD 20 1 0");
    if !listed.is_empty() {
        let _ = writeln!(text, "GCAT {}", listed.join(" "));
    }
    let field = lens.metadata.half_field_deg.unwrap_or(0.0);
    let count = if field > 0.0 { 3 } else { 1 };
    let _ = writeln!(text, "FTYP 0 0 {count} 3 0 0 0\nXFLN 0 0 0\nYFLN 0 {} {field}", 0.7 * field);
    for (i, nm) in [line_nm::F, line_nm::D, line_nm::C].into_iter().enumerate() {
        let _ = writeln!(text, "WAVM {} {} 1", i + 1, nm / 1000.0);
    }
    text.push_str("PWAV 2\nSURF 0\n  TYPE STANDARD\n  CURV 0 0 0 0 0 \"\"\n  DISZ INFINITY\n");
    for (i, (row, glass)) in lens.surfaces.iter().zip(&glasses).enumerate() {
        let _ = writeln!(text, "SURF {}", i + 1);
        if i == lens.stop {
            text.push_str("  STOP\n");
        }
        surface(&mut text, row, glass, i, &mut lost);
    }
    let film = lens.film_radius_mm.map_or(0.0, f64::recip);
    let _ = writeln!(text, "SURF {}\n  TYPE STANDARD\n  CURV {film} 0 0 0 0 \"\"\n  DISZ 0", lens.surfaces.len() + 1);
    if let Some(moving) = &lens.moving {
        configurations(&mut text, moving, &mut lost);
    }
    if common_coating(lens).is_none() && lens.surfaces.iter().any(|row| row.coating.is_some()) {
        lost.push("coatings that differ from surface to surface are left out".to_owned());
    }
    (text, lost)
}

/// The gaps in each position by zoom and focus, as configurations. Other moving parts stand in the notes only.
fn configurations(text: &mut String, moving: &MovingParts, lost: &mut Vec<String>) {
    let positions = moving.positions();
    if positions.len() < 2 {
        return;
    }
    let _ = writeln!(text, "BLNK \nMNUM {} 1", positions.len());
    let mut operand = |surface: usize, values: &mut dyn Iterator<Item = f64>| {
        for (i, value) in values.enumerate() {
            let _ = writeln!(text, "THIC {surface} {} {value} 0 0 0 1 1 1 0 0 \"\" 0", i + 1);
        }
    };
    // A number for infinity: OpticStudio takes no word for it there.
    if positions.iter().any(|position| position.focus_mm.is_finite()) {
        operand(0, &mut positions.iter().map(|position| position.focus_mm.min(1e10)));
    }
    for (i, part) in moving.parts().iter().enumerate() {
        match part.quantity {
            Quantity::Gap => operand(part.surface + 1, &mut positions.iter().map(|position| position.values[i])),
            _ => lost.push(format!("'{part}' changes with the position; that stands in the notes only")),
        }
    }
}

fn surface(text: &mut String, row: &SurfaceRow, glass: &Glass, i: usize, lost: &mut Vec<String>) {
    let profile = row.shape.profile();
    let terms = profile.terms();
    let even = terms.iter().all(|(power, _)| power % 2 == 0);
    let highest = terms.last().map_or(0, |(power, _)| *power);
    let coefficient = |power: u32| terms.iter().find(|(p, _)| *p == power).map_or(0.0, |(_, a)| *a);
    let kind = match &row.shape {
        Shape::Conic(_) => "STANDARD",
        Shape::Asphere(_) if even && highest <= 16 => "EVENASPH",
        Shape::Asphere(_) if !even && highest <= 8 => "ODDASPHE",
        Shape::Asphere(_) if even => "XASPHERE",
        Shape::Asphere(_) => "XOSPHERE",
        Shape::Toroid(_) => "TOROIDAL",
    };
    let _ = writeln!(text, "  TYPE {kind}\n  CURV {} 0 0 0 0 \"\"", profile.base.curvature);
    if profile.base.conic != 0.0 {
        let _ = writeln!(text, "  CONI {}", profile.base.conic);
    }
    match kind {
        "EVENASPH" => (1..=8u32).for_each(|n| {
            let _ = writeln!(text, "  PARM {n} {}", coefficient(2 * n));
        }),
        "ODDASPHE" => (1..=8u32).for_each(|n| {
            let _ = writeln!(text, "  PARM {n} {}", coefficient(n));
        }),
        // Of radius 1, so that coefficients stay as they are.
        "XASPHERE" | "XOSPHERE" => {
            let step = if kind == "XASPHERE" { 2 } else { 1 };
            let count = highest / step;
            let _ = writeln!(text, "  XDAT 1 {count} 0 0\n  XDAT 2 1 0 0");
            for n in 1..=count {
                let _ = writeln!(text, "  XDAT {} {} 0 0", n + 2, coefficient(step * n));
            }
        }
        "TOROIDAL" => {
            let across = row.shape.curvature_at_vertex(Section::X);
            let _ = writeln!(text, "  PARM 1 {}", if across == 0.0 { 0.0 } else { exact_radius(across) });
            for n in 2..=8u32 {
                let _ = writeln!(text, "  PARM {n} {}", coefficient(2 * (n - 1)));
            }
            if !even || highest > 14 {
                lost.push(format!("surface {i}: a toroid's terms beyond r^14 and odd ones are left out"));
            }
        }
        _ => {}
    }
    let _ = writeln!(text, "  DISZ {}", row.thickness_mm);
    if let Some(words) = &glass.words {
        let _ = writeln!(text, "  GLAS {words}");
    }
    let semi = row.semi_diameter_mm;
    let _ = writeln!(text, "  DIAM {semi} 1 0 0 1 \"\"\n  CLAP {} {semi} 0", row.obstruction_mm);
    if matches!(&row.behind, NextMedium::Medium(medium) if medium.gradient().is_some()) {
        lost.push(format!("surface {i}: the gradient of its medium stands in the notes only"));
    }
    if !row.pose.is_identity() {
        lost.push(format!("surface {i} stands beside its place; it is written on the axis"));
    }
}

/// A radius whose reciprocal is `curvature`, if there is one near.
fn exact_radius(curvature: f64) -> f64 {
    let radius = 1.0 / curvature;
    let near = [radius, radius.next_up(), radius.next_down()];
    near.into_iter().find(|r| 1.0 / r == curvature).unwrap_or(radius)
}

/// The text of a medium.
struct Glass {
    /// The words after `GLAS`; `None` for air.
    words: Option<String>,
    /// The catalogue that must be listed.
    listed: Option<&'static str>,
    /// The name that stands in the file and its meaning here, where the name alone would be several glasses.
    alias: Option<(String, String)>,
}

fn glass(row: &SurfaceRow, catalogue: &Catalogue) -> Glass {
    let NextMedium::Medium(medium) = &row.behind else {
        return Glass { words: Some("MIRROR 0 0 1.5 40 0 0 0 0 0 0".to_owned()), listed: None, alias: None };
    };
    if *medium == Medium::air() {
        return Glass { words: None, listed: None, alias: None };
    }
    let name = medium.name();
    let numbers = format!("0 0 {} {} 0 0 0 0 0 0", medium.index(line_nm::D), finite(medium.abbe()));
    // Stated by numbers: index, or index and Abbe number.
    if name.starts_with(|c: char| c.is_ascii_digit() || c == '.' || c == '+') && catalogue.medium(name).is_ok() {
        let (nd, abbe) = name.split_once('/').unwrap_or((name, "0"));
        return Glass { words: Some(format!("___BLANK 1 0 {nd} {abbe} 0 0 0 0 0 0")), listed: None, alias: None };
    }
    let bare = name.rsplit(':').next().unwrap_or(name);
    let makers = catalogue.makers_of(bare);
    let is_it = |maker: &&str| catalogue.medium(&format!("{maker}:{bare}")).is_ok_and(|found| found == *medium);
    let owner = makers.iter().copied().find(|maker| is_it(maker));
    let listed = owner.and_then(|maker| CATALOGUES.iter().find(|(ours, _)| *ours == maker)).map(|(_, theirs)| *theirs);
    match owner {
        Some(maker) if makers.len() > 1 => {
            // The first maker's glass keeps the plain name, so that two of them do not meet in one file.
            let written = if maker == makers[0] { bare.to_owned() } else { format!("{bare}_{}", maker.to_uppercase()) };
            let alias = Some((written.clone(), format!("{maker}:{bare}")));
            Glass { words: Some(format!("{written} {numbers}")), listed, alias }
        }
        _ => Glass { words: Some(format!("{bare} {numbers}")), listed, alias: None },
    }
}

fn finite(abbe: f64) -> f64 {
    if abbe.is_finite() { abbe } else { 0.0 }
}

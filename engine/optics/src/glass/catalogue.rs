//! The glass catalogues that ship with Petzval, and the grammar of a glass token.

use std::collections::HashMap;
use std::sync::OnceLock;

use serde::Deserialize;
use thiserror::Error;

use super::dispersion::Dispersion;
use super::medium::Medium;
use super::transmittance::InternalTransmittance;

/// The makers' files, in the order in which a bare name prefers them.
const FILES: [(&str, &str); 9] = [
    ("schott", include_str!("../../../../lenses/glass/schott.json")),
    ("ohara", include_str!("../../../../lenses/glass/ohara.json")),
    ("hoya", include_str!("../../../../lenses/glass/hoya.json")),
    ("hikari", include_str!("../../../../lenses/glass/hikari.json")),
    ("cdgm", include_str!("../../../../lenses/glass/cdgm.json")),
    ("sumita", include_str!("../../../../lenses/glass/sumita.json")),
    ("schott-old", include_str!("../../../../lenses/glass/schott-old.json")),
    ("robb1983", include_str!("../../../../lenses/glass/robb1983.json")),
    ("other", include_str!("../../../../lenses/glass/other.json")),
];

/// Indices that a glass token may state. Beyond them the column was surely meant for something else.
const PLAUSIBLE_INDEX: std::ops::RangeInclusive<f64> = 0.9..=6.0;

/// An error by which a glass token names no medium.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GlassError {
    /// The name stands in no catalogue.
    #[error("unknown glass '{name}'; {}", proposal(near))]
    Unknown {
        /// The glass token of the lens file.
        name: String,
        /// Names that look alike, best first.
        near: Vec<String>,
    },
    /// A token that starts like a number and is none, or an index or Abbe number out of range.
    #[error("'{token}' is no glass; write a catalogue name, n/V as in 1.62041/60.32, or an index from 0.9 to 6")]
    NotAnIndex {
        /// The glass token of the lens file.
        token: String,
    },
    /// `mirror` is not a medium.
    #[error("'mirror' is a surface, not a medium; it can stand only in the glass column of a lens file")]
    Mirror,
}

fn proposal(near: &[String]) -> String {
    if near.is_empty() {
        "name a glass of the catalogues, or give n/V as in 1.62041/60.32".to_owned()
    } else {
        format!("did you mean {}?", near.join(", "))
    }
}

#[derive(Deserialize)]
struct File {
    source: String,
    glasses: serde_json::Map<String, serde_json::Value>,
}

#[derive(Deserialize)]
struct CatalogueEntry {
    formula: String,
    coefficients: Vec<f64>,
    range_um: [f64; 2],
    source: Option<String>,
    /// (µm, internal transmittance of 10 mm).
    #[serde(default)]
    through_10mm: Vec<[f64; 2]>,
}

/// Optical media by the names of their glasses.
pub struct Catalogue {
    media: HashMap<String, Medium>,
    broken: Vec<String>,
}

impl Catalogue {
    /// The catalogues under `lenses/glass`, parsed once.
    pub fn shipped() -> &'static Self {
        static SHIPPED: OnceLock<Catalogue> = OnceLock::new();
        SHIPPED.get_or_init(|| {
            let mut catalogue = Self { media: HashMap::new(), broken: Vec::new() };
            for (maker, text) in FILES {
                catalogue.add(maker, text);
            }
            catalogue
        })
    }

    /// Adds a maker's file; a bare name that is already taken stays with the earlier maker.
    fn add(&mut self, maker: &str, text: &str) {
        let Ok(file) = serde_json::from_str::<File>(text) else {
            self.broken.push(maker.to_owned());
            return;
        };
        for (name, value) in file.glasses {
            let Some(medium) = read_entry(&name, value, &file.source) else {
                self.broken.push(format!("{maker}:{name}"));
                continue;
            };
            let key = name.to_lowercase();
            let bare = key.rsplit(':').next().unwrap_or(&key);
            self.media.insert(format!("{maker}:{bare}"), medium.clone());
            self.media.entry(key).or_insert(medium);
        }
    }

    /// Number of media with a name.
    pub fn len(&self) -> usize {
        self.media.len()
    }

    /// True if no medium has a name.
    pub fn is_empty(&self) -> bool {
        self.media.is_empty()
    }

    /// Files and entries of the shipped catalogues that could not be read; empty, as a test sees to.
    pub fn broken(&self) -> &[String] {
        &self.broken
    }

    /// The medium that a glass token names, in any case of letters: a catalogue name, `maker:name`, `air`,
    /// `vacuum` (1 / n_air, since catalogue indices are relative to air), `water`, `n/V`, or a bare index.
    pub fn medium(&self, token: &str) -> Result<Medium, GlassError> {
        let key = token.to_lowercase();
        match key.as_str() {
            "air" => return Ok(Medium::air()),
            "vacuum" => return self.vacuum(),
            "mirror" => return Err(GlassError::Mirror),
            _ => {}
        }
        if let Some(medium) = self.media.get(&key) {
            return Ok(medium.clone());
        }
        if token.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-')) {
            return numeric(token);
        }
        Err(GlassError::Unknown { name: token.to_owned(), near: self.near(&key) })
    }

    /// `maker:name` of every glass, the makers in the order in which a bare name prefers them.
    pub fn names(&self) -> Vec<String> {
        let rank = |maker: &str| FILES.iter().position(|(known, _)| *known == maker);
        let mut found: Vec<(usize, &String)> =
            self.media.keys().filter_map(|key| Some((rank(key.split_once(':')?.0)?, key))).collect();
        found.sort_unstable();
        found.into_iter().map(|(_, key)| key.clone()).collect()
    }

    /// The makers that have a glass of this name, in any case of letters, in the order in which a bare name prefers them.
    pub fn makers_of(&self, name: &str) -> Vec<&'static str> {
        let key = name.to_lowercase();
        FILES
            .iter()
            .map(|(maker, _)| *maker)
            .filter(|maker| self.media.contains_key(&format!("{maker}:{key}")))
            .collect()
    }

    /// `maker:name` of the glasses whose names have these letters and digits, whatever stands between them: programs that
    /// allow no hyphens write NBK7 for N-BK7. In the order of [`Self::makers_of`].
    pub fn of_letters(&self, letters: &str) -> Vec<String> {
        let bare = |text: &str| -> String {
            text.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
        };
        let wanted = bare(letters);
        let rank = |maker: &str| FILES.iter().position(|(known, _)| *known == maker);
        let mut found: Vec<(usize, &String)> = self
            .media
            .keys()
            .filter_map(|key| {
                let (maker, name) = key.split_once(':')?;
                (bare(name) == wanted).then_some((rank(maker)?, key))
            })
            .collect();
        found.sort_unstable();
        found.into_iter().map(|(_, key)| key.clone()).collect()
    }

    /// The name by which a lens file gets this medium; `None` if it stands in no catalogue.
    pub fn token_of(&self, medium: &Medium) -> Option<String> {
        let is_it = |token: &String| self.medium(token).is_ok_and(|found| found == *medium);
        let makers = self.makers_of(medium.name());
        let bare = medium.name().rsplit(':').next().unwrap_or_default().to_owned();
        let with_maker = makers.iter().map(|maker| format!("{maker}:{bare}"));
        std::iter::once(medium.name().to_owned()).chain(with_maker).find(is_it)
    }

    fn vacuum(&self) -> Result<Medium, GlassError> {
        let air = self.medium("air-ciddor")?;
        let dispersion = Dispersion::Reciprocal(Box::new(air.dispersion().clone()));
        Ok(Medium::new("vacuum", dispersion, air.range_nm(), air.source()))
    }

    /// Up to three names that differ from `key` by few letters.
    fn near(&self, key: &str) -> Vec<String> {
        const FARTHEST: usize = 2;
        if key.len() > 40 {
            return Vec::new();
        }
        let bare = |candidate: &&String| candidate.contains(':') == key.contains(':');
        let mut found: Vec<(usize, &str)> = self
            .media
            .keys()
            .filter(bare)
            .map(|candidate| (edit_distance(key, candidate), candidate.as_str()))
            .filter(|&(distance, _)| distance <= FARTHEST)
            .collect();
        found.sort_unstable();
        found.iter().take(3).map(|(_, name)| self.media[*name].name().to_owned()).collect()
    }
}

/// `n/V` or a bare index.
fn numeric(token: &str) -> Result<Medium, GlassError> {
    let bad = || GlassError::NotAnIndex { token: token.to_owned() };
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(bad);
    let (index, abbe) = match token.split_once('/') {
        Some((n, v)) => (number(n)?, Some(number(v)?)),
        None => (number(token)?, None),
    };
    if !PLAUSIBLE_INDEX.contains(&index) {
        return Err(bad());
    }
    match abbe {
        None => Ok(Medium::constant(token, index)),
        Some(v) if v > 0.0 => Ok(Medium::from_index_and_abbe(token, index, v)),
        Some(_) => Err(bad()),
    }
}

fn read_entry(name: &str, value: serde_json::Value, file_source: &str) -> Option<Medium> {
    let entry = serde_json::from_value::<CatalogueEntry>(value).ok()?;
    let range_nm = entry.range_um.map(|um| um * 1000.0);
    let source = entry.source.as_deref().unwrap_or(file_source);
    let dispersion = Dispersion::from_words(&entry.formula, &entry.coefficients)?;
    let medium = Medium::new(name, dispersion, range_nm, source);
    let points = entry.through_10mm.iter().map(|[um, part]| [um * 1000.0, *part, 10.0]);
    Some(match InternalTransmittance::new(points.collect()) {
        Some(known) => medium.with_transmittance(known),
        None => medium,
    })
}

/// Levenshtein's distance: the fewest letters put in, taken out or changed.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &to) in b.iter().enumerate() {
            let changed = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::super::line_nm;
    use super::*;

    #[test]
    fn every_shipped_entry_reads() {
        let catalogue = Catalogue::shipped();
        assert_eq!(catalogue.broken(), &[] as &[String]);
        assert!(catalogue.len() > 1876);
        for medium in catalogue.media.values() {
            assert!((1.0..2.6).contains(&medium.index(line_nm::D)), "{medium:?}");
        }
    }

    #[test]
    fn a_name_in_any_case_is_one_glass() {
        let catalogue = Catalogue::shipped();
        let glass = catalogue.medium("n-bk7").unwrap();
        assert_eq!(glass, catalogue.medium("N-BK7").unwrap());
        assert_eq!(glass, catalogue.medium("schott:N-BK7").unwrap());
        assert!((glass.index(line_nm::D) - 1.5168).abs() < 1e-6);
        assert!((glass.abbe() - 64.17).abs() < 0.01);
    }

    /// Transmittances agree with Schott's data sheets, three decimals, for 10 mm; and a flint is yellow.
    #[test]
    fn glasses_let_through_what_their_makers_say() {
        let through = |name: &str, nm: f64| Catalogue::shipped().medium(name).unwrap().internal_transmittance(nm, 10.0);
        for (nm, printed) in [(350.0, 0.967), (365.0, 0.988), (400.0, 0.997), (546.0, 0.998), (700.0, 0.998)] {
            assert!((through("N-BK7", nm).unwrap() - printed).abs() < 1.1e-3, "{nm}");
        }
        assert!(through("SF6", 400.0).unwrap() < 0.95 && through("SF6", 550.0).unwrap() > 0.99);
        assert_eq!(through("1.5/60", 400.0), None);
        let known = Catalogue::shipped().media.values().filter(|medium| medium.transmittance().is_some()).count();
        assert!(known > 1600, "{known}");
    }

    #[test]
    fn old_schott_names_stand() {
        for name in ["BK7", "LAK10", "LAKN6", "SF18", "robb1983:BAF5", "hikari:SF11", "water", "WATER"] {
            assert!(Catalogue::shipped().medium(name).is_ok(), "{name}");
        }
    }

    #[test]
    fn a_glass_by_numbers_has_them() {
        let glass = Catalogue::shipped().medium("1.62041/60.32").unwrap();
        assert!((glass.index(line_nm::D) - 1.62041).abs() < 1e-15);
        assert!((glass.abbe() - 60.32).abs() < 1e-10);
        assert_eq!(Catalogue::shipped().medium("1.5").unwrap().index(400.0), 1.5);
    }

    #[test]
    fn vacuum_is_thinner_than_air() {
        let vacuum = Catalogue::shipped().medium("vacuum").unwrap();
        assert!((vacuum.index(line_nm::D) - 1.0 / 1.0002772).abs() < 1e-7);
    }

    #[test]
    fn unknown_names_meet_their_neighbours() {
        let error = Catalogue::shipped().medium("NBK7").unwrap_err();
        assert!(error.to_string().contains("N-BK7"), "{error}");
        for bad in ["1.5/0", "1.5/x", "-1.5", "99", "1.5/-3", "nan/3", "1.5/", "", "mirror", "1e400", "βάλος"] {
            assert!(Catalogue::shipped().medium(bad).is_err(), "{bad}");
        }
    }
}

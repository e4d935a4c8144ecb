//! The glass names of design programs: who made the glass, by the file's own list of catalogues or the name's ending.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use crate::glass::{Catalogue, Dispersion, GlassError, Medium};

use super::agf;
use super::header::Header;
use super::problem::{LensFileError, Problem, at};
use super::remarks::Remarks;
use super::rii;
use super::text;
use crate::prescription::Place;

/// A larger catalogue is none.
const LARGEST_CATALOGUE: usize = 8 << 20;
/// Files of glasses that one lens file may name.
const MOST_CATALOGUES: usize = 16;

/// Catalogues as design programs call them, and ours, in the order in which they are asked.
const CATALOGUES: [(&str, &[&str]); 12] = [
    ("schott", &["schott", "schott-old", "robb1983"]),
    ("ohara", &["ohara"]),
    ("hoya", &["hoya"]),
    ("hikari", &["hikari"]),
    ("nikon", &["hikari"]),
    ("cdgm", &["cdgm"]),
    ("china", &["cdgm"]),
    ("sumita", &["sumita"]),
    ("misc", &["other"]),
    ("corning", &["other"]),
    ("infrared", &["other"]),
    ("special", &["other"]),
];

/// Materials that the programs call otherwise than our catalogues.
const ALIASES: [(&str, &str); 14] = [
    ("silica", "fused-silica"),
    ("f_silica", "fused-silica"),
    ("fused silica", "fused-silica"),
    ("quartz_fused", "fused-silica"),
    // Corning's fused silica HPFS 7980, in its catalogue and in makers' files.
    ("c79-80", "fused-silica"),
    ("uvfs", "fused-silica"),
    ("calfluor", "caf2"),
    ("fluorite", "caf2"),
    ("fluorspar", "caf2"),
    ("acrylic", "pmma"),
    ("polycarb", "polycarbonate"),
    ("pc", "polycarbonate"),
    ("polystyr", "polystyrene"),
    ("ps", "polystyrene"),
];

/// Glasses of which no curve is published, by nd and Vd: name, and their places in the file.
const BY_NUMBERS: [(&str, f64, f64, &str); 1] = [("B270", 1.5230, 58.57, "SCHOTT, B 270 i")];
/// Glasses that are made no more, and those that took their place with the same glass code.
const SUCCESSORS: [(&str, &str); 1] = [("KZFS4 OF SCHOTT", "schott:KZFSN4")];

/// The catalogues in which the names of a file are looked up.
pub(super) struct Glasses<'a> {
    catalogue: &'a Catalogue,
    /// The folder of the lens file, for catalogues beside it.
    folder: Option<PathBuf>,
    /// Glasses that the file, or a catalogue beside it, defines.
    own: HashMap<String, Medium>,
    /// Own glasses that are other names for glasses of the catalogues.
    renamed: HashSet<String>,
    /// Files of glasses that were read.
    read: HashSet<PathBuf>,
    /// The file's own list of catalogues, as it writes them.
    listed: Vec<String>,
}

impl<'a> Glasses<'a> {
    pub(super) fn new(catalogue: &'a Catalogue, folder: Option<PathBuf>) -> Self {
        Self {
            catalogue,
            folder,
            own: HashMap::new(),
            renamed: HashSet::new(),
            read: HashSet::new(),
            listed: Vec::new(),
        }
    }

    pub(super) fn catalogue(&self) -> &'a Catalogue {
        self.catalogue
    }

    /// A glass of the file's own, which goes before all others of its name.
    pub(super) fn define(&mut self, medium: Medium) {
        self.own.insert(medium.name().to_lowercase(), medium);
    }

    /// Defines the glasses and names that a header has got or changed since the last time. A name that the header gives to a glass
    /// of the catalogues goes before a glass that it defines.
    pub(super) fn define_new(&mut self, header: &mut Header) {
        for changed in std::mem::take(&mut header.changed_glasses) {
            let medium = header.glasses[changed].clone();
            if !self.renamed.contains(&medium.name().to_lowercase()) {
                self.define(medium);
            }
        }
        for (name, token, place) in std::mem::take(&mut header.new_aliases) {
            match self.catalogue.medium(&token) {
                Ok(medium) => {
                    self.own.insert(name.to_lowercase(), medium);
                    self.renamed.insert(name.to_lowercase());
                }
                Err(error) => header.undefined.push((name.to_lowercase(), place, error.into())),
            }
        }
    }

    /// A glass of the file's own.
    pub(super) fn own(&self, name: &str) -> Option<&Medium> {
        self.own.get(&name.to_lowercase())
    }

    /// The catalogues that a file names, in their order. One that does not ship is sought beside the file, as NAME.agf.
    pub(super) fn list(
        &mut self,
        names: &[&str],
        place: Place,
        file: &str,
        remarks: &mut Remarks,
    ) -> Result<(), LensFileError> {
        for name in names {
            self.listed.push((*name).to_owned());
            if makers(name).is_some() {
                continue;
            }
            if !self.beside(&format!("{name}.agf"), place, file, remarks)? {
                let text =
                    format!("the glass catalogue '{name}' is not known; {name}.agf beside the file would be read");
                remarks.say(place, text);
            }
        }
        Ok(())
    }

    /// Reads a catalogue from the lens file's folder; false if there is none of that name.
    pub(super) fn beside(
        &mut self,
        name: &str,
        place: Place,
        file: &str,
        remarks: &mut Remarks,
    ) -> Result<bool, LensFileError> {
        let Some(folder) = &self.folder else { return Ok(false) };
        // No path: what a lens file from elsewhere names must not lead out of its folder.
        let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ' | '(' | ')');
        if !name.chars().all(plain) || name.starts_with('.') || name.len() > 100 {
            return Ok(false);
        }
        let upper = name.to_uppercase();
        let found = [name, &upper, &name.replace(".agf", ".AGF")].map(|name| folder.join(name));
        let Some(path) = found.into_iter().find(|path| path.is_file()) else { return Ok(false) };
        let shown = path.display().to_string();
        let wrong = |why: String| at(file, place.line, place.column, Problem::Beside { name: name.to_owned(), why });
        if self.read.contains(&path) {
            return Ok(true);
        }
        if self.read.len() >= MOST_CATALOGUES {
            return Err(wrong(format!("a lens has glasses of at most {MOST_CATALOGUES} files")));
        }
        let bytes = text::bytes(&path, &shown, LARGEST_CATALOGUE).map_err(|error| wrong(error.to_string()))?;
        let media = if name.to_lowercase().ends_with(".yml") {
            let medium = rii::parse_bytes(&bytes, &shown, &one_word(&text::stem(name)))
                .map_err(|error| wrong(error.to_string()))?;
            vec![medium]
        } else {
            let (media, said) = agf::parse_bytes(&bytes, &shown).map_err(|error| wrong(error.to_string()))?;
            said.into_iter().for_each(|remark| remarks.say(place, remark.to_string()));
            media
        };
        for medium in media {
            self.own.entry(medium.name().to_lowercase()).or_insert(medium);
        }
        self.read.insert(path);
        Ok(true)
    }

    /// The glass of a name in a file that lists its catalogues: the first listed one that has it. If none has it, the glass
    /// that a bare name means here, with a remark.
    pub(super) fn listed(&self, name: &str, place: Place, remarks: &mut Remarks) -> Result<Medium, GlassError> {
        if let Some(medium) = self.own(name) {
            return Ok(medium.clone());
        }
        let alias = alias(name);
        for maker in self.listed.iter().filter_map(|name| makers(name)).flatten() {
            if let Ok(medium) = self.catalogue.medium(&format!("{maker}:{alias}")) {
                return Ok(medium);
            }
        }
        let medium = match self.catalogue.medium(alias) {
            Ok(medium) => medium,
            Err(error) => return self.stand_in(name, place, remarks).ok_or(error),
        };
        let has = self.catalogue.makers_of(alias);
        if !self.listed.is_empty() {
            let list = self.listed.join(", ");
            let text = format!(
                "'{name}' stands in none of the file's catalogues ({list}); that of {} is taken",
                has.join(" or ")
            );
            remarks.once(&format!("glass {name}"), place, text);
        } else {
            self.of_several(name, &has, place, remarks);
        }
        Ok(medium)
    }

    /// The glass that comes nearest to one of which the catalogues have no curve, with a remark: pressed glass by the glass that it was
    /// before, others by nd and Vd.
    fn stand_in(&self, name: &str, place: Place, remarks: &mut Remarks) -> Option<Medium> {
        let upper = name.to_uppercase();
        if let Some((_, nd, abbe, source)) = BY_NUMBERS.iter().find(|(known, ..)| *known == upper) {
            let text =
                format!("of '{name}' only nd {nd} and Vd {abbe} are known ({source}); the curve between is estimated");
            remarks.once(&format!("glass {name}"), place, text);
            return self.by_numbers(*nd, *abbe).ok();
        }
        if let Some((_, successor)) = SUCCESSORS.iter().find(|(known, _)| *known == upper) {
            let text = format!("'{name}' is made no more; {successor} of the same glass code is taken");
            remarks.once(&format!("glass {name}"), place, text);
            return self.catalogue.medium(successor).ok();
        }
        let of_cdgm = upper.strip_suffix('M').filter(|bare| bare.starts_with("D-"));
        let bare = upper.strip_suffix("_MOLD").or(of_cdgm)?;
        let medium = self.catalogue.medium(bare).ok()?;
        let text = format!(
            "'{name}' is pressed glass; {bare} is taken, whose index is higher by some thousandths before pressing"
        );
        remarks.once(&format!("glass {name}"), place, text);
        Some(medium)
    }

    /// The glass of a name in which hyphens may be missing, with its maker or without.
    pub(super) fn squeezed(
        &self,
        name: &str,
        maker: Option<&str>,
        place: Place,
        remarks: &mut Remarks,
    ) -> Result<Medium, GlassError> {
        if let Some(medium) = self.own(name) {
            return Ok(medium.clone());
        }
        let alias = alias(name);
        let found = self.catalogue.of_letters(alias);
        let of_maker = |maker: &&str| found.iter().find(|key| key.split(':').next() == Some(maker));
        if let Some(wanted) = maker {
            if let Some(key) = makers(wanted).into_iter().flatten().find_map(of_maker) {
                return self.catalogue.medium(key);
            }
            if let Some(medium) = self.stand_in(&format!("{name} of {wanted}"), place, remarks) {
                return Ok(medium);
            }
            // Makers rename a glass when lead leaves it: N-BK7 is no BK7, and nobody else's either.
            if makers(wanted).is_some() {
                let near = self.catalogue.medium(alias).err();
                return Err(near.unwrap_or_else(|| GlassError::Unknown {
                    name: format!("{name} of {wanted}"),
                    near: found.into_iter().take(3).collect(),
                }));
            }
        }
        let Some(first) = found.first() else {
            return self.catalogue.medium(alias).or_else(|error| self.stand_in(name, place, remarks).ok_or(error));
        };
        let has: Vec<&str> = found.iter().filter_map(|key| key.split(':').next()).collect();
        self.of_several(name, &has, place, remarks);
        self.catalogue.medium(first)
    }

    /// Adds a remark on whose glass is taken, if those of the makers differ.
    fn of_several(&self, name: &str, makers: &[&str], place: Place, remarks: &mut Remarks) {
        let index =
            |maker: &&str| self.catalogue.medium(&format!("{maker}:{name}")).ok().map(|medium| medium.index(500.0));
        let indices: Vec<f64> = makers.iter().filter_map(index).collect();
        if indices.iter().any(|n| (n - indices[0]).abs() > 1e-5) {
            let text = format!("'{name}' is made by {}; that of {} is taken", makers.join(", "), makers[0]);
            remarks.once(&format!("glass {name}"), place, text);
        }
    }

    /// A glass that a file states by index and Abbe number; 0 for no dispersion.
    pub(super) fn by_numbers(&self, nd: f64, abbe: f64) -> Result<Medium, GlassError> {
        if abbe == 0.0 {
            self.catalogue.medium(&nd.to_string())
        } else {
            self.catalogue.medium(&format!("{nd}/{abbe}"))
        }
    }

    /// A glass that a file states by its indices at some wavelengths, (µm, n).
    pub(super) fn measured(name: &str, points: Vec<[f64; 2]>) -> Option<Medium> {
        let low = points.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(|p| p[0]).fold(0.0, f64::max);
        let good = points.iter().all(|p| (0.5..=6.0).contains(&p[1]));
        let is_table = points.len() > 3;
        let dispersion = Dispersion::through(points).filter(|_| good)?;
        let over = |range_nm| Medium::new(&one_word(name), dispersion.clone(), range_nm, "the lens file");
        // Up to three lines stand for all light, as far as their formula is a glass there; a table stands for what it covers.
        let everywhere = Some([0.0, f64::INFINITY]).filter(|_| !is_table).map(&over).filter(Medium::is_plausible);
        everywhere.or_else(|| Some(over([low * 1000.0, high * 1000.0])).filter(Medium::is_plausible))
    }
}

/// Our catalogues for one of a design program: SCHOTT, HOYA_2017.
fn makers(name: &str) -> Option<&'static [&'static str]> {
    let name = name.to_lowercase();
    let known = CATALOGUES.iter().find(|(known, _)| name.starts_with(known));
    known.map(|(_, ours)| *ours)
}

/// A name as it can stand in a lens file: one word, no remark, no number of its own.
fn one_word(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_whitespace() || "#=:".contains(c) { '_' } else { c }).collect();
    if plain.is_empty() || plain.eq_ignore_ascii_case("mirror") { format!("glass_{plain}") } else { plain }
}

fn alias(name: &str) -> &str {
    let lower = name.to_lowercase();
    ALIASES.iter().find(|(known, _)| *known == lower).map_or(name, |(_, ours)| ours)
}

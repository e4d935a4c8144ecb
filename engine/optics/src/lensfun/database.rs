//! Lensfun databases: files and folders of them, installed ones, and lenses by their names.

use std::path::{Path, PathBuf};

use super::{Body, CalibratedLens, LensfunError, xml};

/// The most bytes of a file; lensfun's largest has 1.6 million.
const MOST_BYTES: u64 = 64 << 20;
/// The most files of a folder; lensfun has 57.
const MOST_FILES: usize = 2000;
/// Folders in which a database is installed, the first that there is: updated by `lensfun-update-data`, then Debian's and those of others.
const INSTALLED: [&str; 7] = [
    "/var/lib/lensfun-updates/version_2",
    "/var/lib/lensfun-updates/version_1",
    "/usr/local/share/lensfun/version_2",
    "/usr/local/share/lensfun/version_1",
    "/usr/share/lensfun/version_2",
    "/usr/share/lensfun/version_1",
    "/opt/homebrew/share/lensfun/version_1",
];

/// The lenses and camera bodies of a lensfun database.
#[derive(Clone, Debug, Default)]
pub struct Database {
    lenses: Vec<CalibratedLens>,
    bodies: Vec<Body>,
}

impl Database {
    /// The database in a file, or in the `.xml` files of a folder.
    ///
    /// # Errors
    /// [`LensfunError`]: it cannot be read, or is no database.
    pub fn read(path: &Path) -> Result<Self, LensfunError> {
        let unreadable = |path: &Path, why: &dyn std::fmt::Display| LensfunError::Unreadable {
            path: path.to_owned(),
            why: why.to_string(),
        };
        let mut files = vec![path.to_owned()];
        if path.is_dir() {
            let entries = path.read_dir().map_err(|error| unreadable(path, &error))?;
            files = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|file| is_xml(file)).collect();
            // The order of a folder is none.
            files.sort_unstable();
            files.truncate(MOST_FILES);
            if files.is_empty() {
                return Err(LensfunError::NoFiles { path: path.to_owned() });
            }
        }
        let mut all = Self::default();
        for file in files {
            let text =
                petzval_files::read_text_bounded(&file, MOST_BYTES).map_err(|error| unreadable(&file, &error))?;
            let Self { lenses, bodies } = Self::parse(&text, &file.to_string_lossy())?;
            all.lenses.extend(lenses);
            all.bodies.extend(bodies);
        }
        Ok(all)
    }

    /// The database in the text of a file; `file` is its name in messages.
    ///
    /// # Errors
    /// [`LensfunError::Content`]: it is none.
    pub fn parse(text: &str, file: &str) -> Result<Self, LensfunError> {
        let (lenses, bodies) = xml::parse(text, file)?;
        Ok(Self { lenses, bodies })
    }

    /// The database that is installed on this computer: the user's own, updated, of the system.
    ///
    /// # Errors
    /// [`LensfunError::NotInstalled`], or the error of reading the installed one.
    pub fn installed() -> Result<Self, LensfunError> {
        let home = std::env::var_os("XDG_DATA_HOME").map(PathBuf::from);
        let home = home.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/share")));
        let own = home.into_iter().flat_map(|home| {
            let lensfun = home.join("lensfun");
            [lensfun.join("updates/version_2"), lensfun.join("updates/version_1"), lensfun]
        });
        let places: Vec<PathBuf> = own.chain(INSTALLED.map(PathBuf::from)).collect();
        let has_files = |place: &&PathBuf| {
            place
                .read_dir()
                .is_ok_and(|mut entries| entries.any(|entry| entry.is_ok_and(|entry| is_xml(&entry.path()))))
        };
        let Some(found) = places.iter().find(has_files) else {
            let looked = places.iter().map(|place| place.display().to_string()).collect::<Vec<_>>().join(", ");
            return Err(LensfunError::NotInstalled { looked });
        };
        Self::read(found)
    }

    /// All lenses, in the order of the files.
    pub fn lenses(&self) -> &[CalibratedLens] {
        &self.lenses
    }

    /// The lens of a name. Case and blanks do not count. The model, or maker and model, in full; else words, or beginnings of words, that stand in the name
    /// of one lens only. Entries of one name, measured with several sensors, are one lens with all their sets.
    ///
    /// # Errors
    /// [`LensfunError::Unknown`], [`LensfunError::Ambiguous`].
    pub fn find(&self, name: &str) -> Result<CalibratedLens, LensfunError> {
        let names: Vec<_> = self.lenses.iter().map(|lens| [lens.model.clone(), lens.name()]).collect();
        let entries = matching(&names, name, "lens")?;
        let (first, others) = entries.split_first().ok_or_else(|| unknown(&names, name, "lens"))?;
        let mut lens = self.lenses[*first].clone();
        lens.sets.extend(others.iter().flat_map(|other| self.lenses[*other].sets.clone()));
        Ok(lens)
    }

    /// All camera bodies, in the order of the files.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The camera body of a name, which is looked for as a lens's is; of bodies of one name the first.
    ///
    /// # Errors
    /// [`LensfunError::Unknown`], [`LensfunError::Ambiguous`].
    pub fn body(&self, name: &str) -> Result<&Body, LensfunError> {
        let names: Vec<_> = self.bodies.iter().map(|body| [body.model.clone(), body.name()]).collect();
        let found = matching(&names, name, "camera body")?;
        found.first().map(|first| &self.bodies[*first]).ok_or_else(|| unknown(&names, name, "camera body"))
    }
}

/// The numbers of the entries of a name, all of one name, each known by model and by maker and model; `what` is their kind, for messages.
fn matching(names: &[[String; 2]], name: &str, what: &'static str) -> Result<Vec<usize>, LensfunError> {
    let wanted = key(name);
    let numbers = |holds: &dyn Fn(&[String; 2]) -> bool| -> Vec<usize> {
        names.iter().enumerate().filter(|(_, names)| holds(names)).map(|(i, _)| i).collect()
    };
    let exact = numbers(&|[model, full]| key(model) == wanted || key(full) == wanted);
    if !exact.is_empty() {
        return Ok(exact);
    }
    let words: Vec<&str> = wanted.split(' ').collect();
    let like = numbers(&|[_, full]| {
        let known = key(full);
        !wanted.is_empty() && words.iter().all(|word| begins_a_word(&known, word))
    });
    let mut all: Vec<String> = like.iter().map(|i| names[*i][1].clone()).collect();
    all.sort_unstable();
    all.dedup();
    match all.len() {
        1 => Ok(like),
        0 => Err(unknown(names, name, what)),
        _ => Err(LensfunError::Ambiguous { what, name: name.to_owned(), all }),
    }
}

fn unknown(names: &[[String; 2]], name: &str, what: &'static str) -> LensfunError {
    LensfunError::Unknown { what, name: name.to_owned(), near: near(names, &key(name)) }
}

/// The names that have the most words, or parts of words, of a key in common with it.
fn near(names: &[[String; 2]], wanted: &str) -> Vec<String> {
    const LEAST: f64 = 0.3;
    const MOST: usize = 6;
    let pairs = |text: &str| -> Vec<[char; 2]> {
        let letters: Vec<char> = text.chars().filter(|c| *c != ' ').collect();
        letters.windows(2).map(|pair| [pair[0], pair[1]]).collect()
    };
    let wanted = pairs(wanted);
    // Dice's coefficient of the pairs of letters.
    let likeness = |name: &str| {
        let mut left = pairs(&key(name));
        let all = (left.len() + wanted.len()).max(1);
        let shared = wanted.iter().filter(|pair| {
            let at = left.iter().position(|other| other == *pair);
            at.map(|at| left.swap_remove(at)).is_some()
        });
        2.0 * shared.count() as f64 / all as f64
    };
    let mut names: Vec<(f64, &String)> = names.iter().map(|[_, full]| (likeness(full), full)).collect();
    names.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(b.1)));
    names.dedup_by(|a, b| a.1 == b.1);
    names.into_iter().take(MOST).filter(|(likeness, _)| *likeness >= LEAST).map(|(_, name)| name.clone()).collect()
}

/// True if a text has a word that begins so: 8mm is not in 28mm, and nikkor is in Zoom-Nikkor.
fn begins_a_word(text: &str, word: &str) -> bool {
    text.match_indices(word).any(|(at, _)| !text[..at].ends_with(char::is_alphanumeric))
}

/// A name in small letters with single blanks.
fn key(name: &str) -> String {
    name.to_lowercase().split_whitespace().collect::<Vec<_>>().join(" ")
}

fn is_xml(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("xml"))
}

//! Errors in lensfun databases, and about lenses that they do not have.

use std::path::PathBuf;

use thiserror::Error;

/// An error by which a lensfun database gives no calibration.
#[derive(Debug, Error)]
pub enum LensfunError {
    /// A file or folder cannot be read.
    #[error("{}: cannot be read ({why}); give a lensfun database: an .xml file, or the folder that holds them", path.display())]
    Unreadable {
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// A folder has no database in it.
    #[error("{}: no .xml file is in this folder; give lensfun's folder version_1 or version_2, or its data/db", path.display())]
    NoFiles {
        /// The folder.
        path: PathBuf,
    },
    /// No path was given, and no database is installed.
    #[error(
        "no lensfun database is installed ({looked}); install Debian's liblensfun-data-v1, or give a file or folder"
    )]
    NotInstalled {
        /// The folders that were looked for.
        looked: String,
    },
    /// A place of a file has other content than a database.
    #[error("{file}:{line}:{column}: {what}")]
    Content {
        /// The file.
        file: String,
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// The fault, and the content that belongs there.
        what: String,
    },
    /// No lens is named, and there are several.
    #[error("there are {count} lenses in the lensfun database; name one")]
    NotChosen {
        /// The number of lenses.
        count: usize,
    },
    /// No lens or camera body has this name.
    #[error("no {what} in the lensfun database is called '{name}'; {}", proposal(near))]
    Unknown {
        /// The kind that was looked for.
        what: &'static str,
        /// The name that was asked for.
        name: String,
        /// The names nearest to it, best first.
        near: Vec<String>,
    },
    /// Several lenses or camera bodies have this in their names.
    #[error("'{name}' may be {} of the lensfun database: {}; give more of the name", several(all.len(), what), some(all))]
    Ambiguous {
        /// The kind that was looked for.
        what: &'static str,
        /// The name that was asked for.
        name: String,
        /// The names that hold it.
        all: Vec<String>,
    },
}

/// The most names that a message lists.
const MOST: usize = 6;

fn several(count: usize, what: &str) -> String {
    format!("{count} {}", if what == "lens" { "lenses" } else { "camera bodies" })
}

fn some(names: &[String]) -> String {
    let more = if names.len() > MOST { ", …" } else { "" };
    format!("{}{more}", names.iter().take(MOST).cloned().collect::<Vec<_>>().join(", "))
}

fn proposal(near: &[String]) -> String {
    if near.is_empty() {
        "give its maker and model as lensfun has them".to_owned()
    } else {
        format!("did you mean {}?", some(near))
    }
}

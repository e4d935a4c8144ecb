//! Remarks of a reader on parts of a file that it left out or took for something else, line by line.

use std::collections::HashMap;
use std::fmt;

use crate::prescription::{Place, Prescription};

/// A lens as it was read, with remarks on the parts of its file that were left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The prescription of the lens.
    pub prescription: Prescription,
    /// Remarks on parts that were left out, in the order of the file's lines.
    pub remarks: Vec<Remark>,
}

/// Something that was left out of a file, or taken for something else: one line, `FILE:LINE:COLUMN: remark`.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// The file, as it was named.
    pub file: String,
    /// The place in the file, counted from 1.
    pub place: Place,
    /// The remark itself, without its place.
    pub text: String,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { line, column } = self.place;
        write!(f, "{}:{line}:{column}: {}", self.file, self.text)
    }
}

/// Largest number of kinds of remarks: more tell nothing.
const MOST: usize = 60;

/// Remarks while they are collected: of one kind only the first, with a count of the others.
#[derive(Default)]
pub(super) struct Remarks {
    list: Vec<(Place, String)>,
    kinds: HashMap<String, (usize, usize)>,
}

impl Remarks {
    pub(super) fn say(&mut self, place: Place, text: impl Into<String>) {
        if self.list.len() < MOST {
            self.list.push((place, text.into()));
        }
    }

    /// Adds a remark like [`Self::say`], but only once for each `kind`.
    pub(super) fn once(&mut self, kind: &str, place: Place, text: impl Into<String>) {
        if let Some((_, count)) = self.kinds.get_mut(kind) {
            *count += 1;
        } else if self.kinds.len() < MOST {
            self.kinds.insert(kind.to_owned(), (self.list.len(), 1));
            self.say(place, text);
        }
    }

    /// Returns all remarks, by line.
    pub(super) fn finish(mut self, file: &str) -> Vec<Remark> {
        for (at, count) in self.kinds.values().filter(|(_, count)| *count > 1) {
            if let Some((_, text)) = self.list.get_mut(*at) {
                text.push_str(&format!(" (and in {} more lines)", count - 1));
            }
        }
        self.list.sort_by_key(|(place, _)| (place.line, place.column));
        let remark = |(place, text)| Remark { file: file.to_owned(), place, text };
        self.list.into_iter().map(remark).collect()
    }
}

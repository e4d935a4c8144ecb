//! Errors of reading, joining and writing pictures.

use std::path::PathBuf;

/// An error by which pictures cannot be joined.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// There are fewer than two pictures.
    #[error("{0} picture: name two or more")]
    TooFew(usize),
    /// A file that is none, or of a kind that is not read.
    #[error("{}: cannot be read: {reason}", file.display())]
    Read {
        /// The file that cannot be read.
        file: PathBuf,
        /// The reason that the library states.
        reason: String,
    },
    /// A file that cannot be written.
    #[error("{}: cannot be written: {reason}", file.display())]
    Write {
        /// The file that cannot be written.
        file: PathBuf,
        /// The reason that the library states.
        reason: String,
    },
    /// Pictures of different things.
    #[error("{}: {what}: only renders of the same picture can be joined", file.display())]
    Unlike {
        /// The one that is not like the first.
        file: PathBuf,
        /// The property that differs.
        what: String,
    },
    /// The header claims more pixels than there is memory for, or than a file of that length can hold.
    #[error("{}: its {width} x {height} pixels need {} MB of memory: {why}", file.display(), bytes / 1_000_000)]
    TooLarge {
        /// The file of the picture.
        file: PathBuf,
        /// Width of the picture, pixels.
        width: usize,
        /// Height of the picture, pixels.
        height: usize,
        /// All channels as they are in memory.
        bytes: u64,
        /// The reason why the pixels do not fit: too little free memory, or too short a file.
        why: String,
    },
    /// The number of samples of the picture is not known.
    #[error("{}: it does not say how many samples its pixels have: render it with --mergeable", .0.display())]
    Counts(PathBuf),
    /// Samples that would count twice.
    #[error(
        "{}: samples {} to {} of seed {seed} are in {} too: give one another --seed, or the --sample-offset {}",
        file.display(), range[0], range[1] - 1, other.display(), range[1]
    )]
    Twice {
        /// The file whose samples count twice.
        file: PathBuf,
        /// The other file with these samples.
        other: PathBuf,
        /// The seed of both.
        seed: u64,
        /// The samples of the other, first and behind the last.
        range: [u64; 2],
    },
}

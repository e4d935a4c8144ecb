//! The file of a film: its header says of which picture, and of which of its tiles.

use crate::film::{FilmPiece, FilmState, KeptFilm};
use crate::job::adaptive::AdaptiveState;
use crate::job::share::Share;
use crate::pipeline::Counts;
use petzval_files::Identity;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Write};
use std::path::Path;

/// The beginning of each file; another layout has another number. Then come the length of the header, the header and its checksum, and blocks,
/// each with its length and its checksum before it: [`Progress`], and as many pieces of the film as that says. Numbers are little-endian.
pub(super) const MAGIC: &[u8; 16] = b"Petzval film   5";
/// The part of [`MAGIC`] that all layouts share.
const MAGIC_STEM: &[u8] = b"Petzval film";
/// Length of the longest header, bytes; it has a version and a fingerprint.
const LONGEST_HEADER: u32 = 1 << 16;
/// Pieces that are packed before they are written.
const PIECES_AHEAD: usize = 32;
/// Version of the engine, and true if products and sums are rounded together: besides the fingerprint, these decide the bits of a picture.
const MADE_BY: (&str, bool) = (env!("CARGO_PKG_VERSION"), cfg!(target_feature = "fma"));

/// The first part of a file: whose it is.
#[derive(Serialize, Deserialize)]
pub(crate) struct CheckpointHeader {
    made_by: (String, bool),
    fingerprint: String,
    /// The tiles that were to be rendered.
    pub share: Share,
    /// True if all passes of these are there.
    pub is_complete: bool,
}

impl CheckpointHeader {
    pub(crate) fn new(fingerprint: &str, share: Share, is_complete: bool) -> Self {
        let made_by = (MADE_BY.0.to_owned(), MADE_BY.1);
        Self { made_by, fingerprint: fingerprint.to_owned(), share, is_complete }
    }
}

/// The state of a render, to be written.
pub(crate) struct CheckpointBody {
    pub seconds: f64,
    pub counts: Counts,
    pub film: FilmState,
    pub adaptive: Option<AdaptiveState>,
}

/// The first block of a file.
#[derive(Serialize, Deserialize)]
pub(crate) struct Progress {
    pub seconds: f64,
    pub counts: Counts,
    pub adaptive: Option<AdaptiveState>,
    films: u32,
    pieces: u64,
}

/// The state of a render, as it was read.
pub(crate) struct KeptBody {
    pub progress: Progress,
    pub film: KeptFilm,
}

/// The reason why a file is not used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Unusable {
    #[error("{0}")]
    Io(#[from] std::io::Error),
    #[error("it is no checkpoint, and is left as it is: name another file")]
    Foreign,
    #[error("it is damaged")]
    Damaged,
    #[error("it is of another version of Petzval")]
    Version,
    #[error("it is of another picture: the scene or a setting is not the same")]
    Picture,
    #[error("it is of another part of the picture")]
    Share,
    #[error("it is not finished")]
    Unfinished,
}

/// Checks that a file may be replaced by a checkpoint: there is none, or it is empty or a checkpoint of any version.
///
/// # Errors
/// One line that describes the file.
pub fn check_file(file: &Path) -> Result<(), String> {
    begin(file).map(drop).map_err(|why| why.to_string())
}

/// The file behind its magic; `None` where there is nothing to take up.
fn begin(path: &Path) -> Result<Option<BufReader<File>>, Unusable> {
    match path.metadata() {
        // Opening a pipe would wait for its other end.
        Ok(metadata) if !metadata.is_file() => return Err(Unusable::Foreign),
        Ok(metadata) if metadata.len() == 0 => return Ok(None),
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error.into()),
    }
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut magic = [0; MAGIC.len()];
    match file.read_exact(&mut magic) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Err(Unusable::Foreign),
        read => read?,
    }
    if !magic.starts_with(MAGIC_STEM) {
        return Err(Unusable::Foreign);
    }
    Ok((magic == *MAGIC).then_some(file))
}

/// A part of a file of so many bytes.
fn part(file: &mut impl Read, bytes: u64) -> Result<Vec<u8>, Unusable> {
    let mut part = Vec::new();
    file.take(bytes).read_to_end(&mut part)?;
    if part.len() as u64 == bytes { Ok(part) } else { Err(Unusable::Damaged) }
}

fn number<const N: usize>(file: &mut impl Read) -> Result<[u8; N], Unusable> {
    part(file, N as u64)?.try_into().map_err(|_| Unusable::Damaged)
}

/// A block with its checksum, which is not looked at yet.
fn block(file: &mut impl Read) -> Result<(u32, Vec<u8>), Unusable> {
    let [length, checksum] = [number(file)?, number(file)?].map(u32::from_le_bytes);
    Ok((checksum, part(file, length.into())?))
}

fn write_block(file: &mut impl Write, bytes: &[u8]) -> std::io::Result<()> {
    let length = u32::try_from(bytes.len()).map_err(std::io::Error::other)?;
    file.write_all(&length.to_le_bytes())?;
    file.write_all(&crc32fast::hash(bytes).to_le_bytes())?;
    file.write_all(bytes)
}

/// The film of a picture of that fingerprint; `None` where there is no file, or an empty one.
pub(crate) fn read(path: &Path, fingerprint: &str) -> Result<Option<(CheckpointHeader, KeptBody, Identity)>, Unusable> {
    let Some(mut file) = begin(path)? else {
        // Another version's, unless there is none.
        return if path.metadata().is_ok_and(|m| m.len() > 0) { Err(Unusable::Version) } else { Ok(None) };
    };
    let metadata = file.get_ref().metadata()?;
    let header_bytes = u32::from_le_bytes(number(&mut file)?);
    if header_bytes > LONGEST_HEADER {
        return Err(Unusable::Damaged);
    }
    let header = part(&mut file, header_bytes.into())?;
    if crc32fast::hash(&header) != u32::from_le_bytes(number(&mut file)?) {
        return Err(Unusable::Damaged);
    }
    let header: CheckpointHeader = postcard::from_bytes(&header).map_err(|_| Unusable::Damaged)?;
    if (header.made_by.0.as_str(), header.made_by.1) != MADE_BY {
        return Err(Unusable::Version);
    }
    if header.fingerprint != fingerprint {
        return Err(Unusable::Picture);
    }
    let (checksum, progress) = block(&mut file)?;
    if crc32fast::hash(&progress) != checksum {
        return Err(Unusable::Damaged);
    }
    let progress: Progress = postcard::from_bytes(&progress).map_err(|_| Unusable::Damaged)?;
    let mut pieces = Vec::new();
    for _ in 0..progress.pieces {
        pieces.push(block(&mut file)?);
    }
    let is_whole = pieces.par_iter().all(|(checksum, piece)| crc32fast::hash(piece) == *checksum);
    if !is_whole || file.read(&mut [0])? != 0 {
        return Err(Unusable::Damaged);
    }
    let pieces = pieces.into_iter().map(|(_, piece)| piece).collect();
    let film = KeptFilm { films: progress.films, pieces };
    Ok(Some((header, KeptBody { progress, film }, Identity::of_metadata(&metadata))))
}

/// Writes a film; the old file stays until the new one is whole and on the disk. `is_alone`: no render goes on meanwhile, so that it may be
/// packed by all threads of the current rayon pool.
pub(crate) fn write(
    path: &Path,
    header: &CheckpointHeader,
    body: CheckpointBody,
    is_alone: bool,
) -> std::io::Result<()> {
    let header = postcard::to_stdvec(header).map_err(std::io::Error::other)?;
    let CheckpointBody { seconds, counts, film, adaptive } = body;
    let pieces = film.pieces();
    let progress = Progress { seconds, counts, adaptive, films: film.film_count(), pieces: pieces.len() as u64 };
    let progress = postcard::to_stdvec(&progress).map_err(std::io::Error::other)?;
    petzval_files::write(path, |file| {
        file.write_all(MAGIC)?;
        file.write_all(&(header.len() as u32).to_le_bytes())?;
        file.write_all(&header)?;
        file.write_all(&crc32fast::hash(&header).to_le_bytes())?;
        write_block(file, &progress)?;
        for some in pieces.chunks(PIECES_AHEAD) {
            let packed: Result<Vec<_>, _> = if is_alone {
                some.par_iter().map(FilmPiece::bytes).collect()
            } else {
                some.iter().map(FilmPiece::bytes).collect()
            };
            for piece in packed.map_err(std::io::Error::other)? {
                write_block(file, &piece)?;
            }
        }
        Ok(())
    })
}

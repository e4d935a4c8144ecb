//! The file of a film: its header says of which picture, and of which of its tiles.

use crate::film::FilmState;
use crate::job::adaptive::AdaptiveState;
use crate::job::share::Share;
use crate::pipeline::Counts;
use petzval_files::Identity;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Write};
use std::path::Path;

/// The beginning of each file; another layout has another number. Then come the length of the header, the header, its checksum, the
/// [`CheckpointBody`], and the body's length and checksum. Numbers are little-endian.
pub(super) const MAGIC: &[u8; 16] = b"Petzval film   4";
/// The part of [`MAGIC`] that all layouts share.
const MAGIC_STEM: &[u8] = b"Petzval film";
/// Length of the longest header, bytes; it has a version and a fingerprint.
const LONGEST_HEADER: u32 = 1 << 16;
/// The bytes after the body: its length and its checksum.
const TAIL_BYTES: u64 = 12;
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

/// The second part of a file: the state of the render.
#[derive(Serialize, Deserialize)]
pub(crate) struct CheckpointBody {
    pub seconds: f64,
    pub counts: Counts,
    pub film: FilmState,
    pub adaptive: Option<AdaptiveState>,
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
/// One line that says what the file is.
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

/// A writer that counts and sums up its bytes.
struct Summed<W> {
    inner: W,
    length: u64,
    checksum: crc32fast::Hasher,
    /// The first error of the inner writer.
    failed: Option<std::io::Error>,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(bytes).inspect_err(|error| {
            let same = error.raw_os_error().map_or_else(|| error.kind().into(), std::io::Error::from_raw_os_error);
            self.failed.get_or_insert(same);
        })?;
        self.length += written as u64;
        self.checksum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// The film of a picture of that fingerprint; `None` where there is no file, or an empty one.
pub(crate) fn read(
    path: &Path,
    fingerprint: &str,
) -> Result<Option<(CheckpointHeader, CheckpointBody, Identity)>, Unusable> {
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
    let before = MAGIC.len() as u64 + 4 + u64::from(header_bytes) + 4;
    let length = metadata.len().checked_sub(before + TAIL_BYTES).ok_or(Unusable::Damaged)?;
    let body = part(&mut file, length)?;
    let told = (u64::from_le_bytes(number(&mut file)?), u32::from_le_bytes(number(&mut file)?));
    if told != (length, crc32fast::hash(&body)) {
        return Err(Unusable::Damaged);
    }
    let (body, rest) = postcard::take_from_bytes::<CheckpointBody>(&body).map_err(|_| Unusable::Damaged)?;
    if !rest.is_empty() {
        return Err(Unusable::Damaged);
    }
    Ok(Some((header, body, Identity::of_metadata(&metadata))))
}

/// Writes a film; the old file stays until the new one is whole and on the disk.
pub(crate) fn write(path: &Path, header: &CheckpointHeader, body: &CheckpointBody) -> std::io::Result<()> {
    let header = postcard::to_stdvec(header).map_err(std::io::Error::other)?;
    petzval_files::write(path, |file| {
        file.write_all(MAGIC)?;
        file.write_all(&(header.len() as u32).to_le_bytes())?;
        file.write_all(&header)?;
        file.write_all(&crc32fast::hash(&header).to_le_bytes())?;
        let mut summed = Summed { inner: &mut *file, length: 0, checksum: crc32fast::Hasher::new(), failed: None };
        // The serialiser forgets why its writer failed.
        if let Err(error) = postcard::to_io(body, &mut summed) {
            return Err(summed.failed.unwrap_or_else(|| std::io::Error::other(error)));
        }
        let (length, checksum) = (summed.length, summed.checksum.finalize());
        file.write_all(&length.to_le_bytes())?;
        file.write_all(&checksum.to_le_bytes())
    })
}

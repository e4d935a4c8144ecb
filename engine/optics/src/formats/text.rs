//! Files as text: how much is read, in which encoding, and the words of a line.

use std::io::ErrorKind;
use std::path::Path;

use super::problem::{LensFileError, Problem, at};

/// The bytes of a regular file of at most `largest` bytes.
pub(super) fn bytes(path: &Path, file: &str, largest: usize) -> Result<Vec<u8>, LensFileError> {
    petzval_files::read_bounded(path, largest as u64).map_err(|error| {
        let problem = match error.kind() {
            ErrorKind::FileTooLarge => Problem::TooLong { largest },
            _ => Problem::Unreadable(error.to_string()),
        };
        at(file, 1, 1, problem)
    })
}

/// Text in UTF-8, without its mark.
pub(super) fn utf8(bytes: &[u8], file: &str) -> Result<String, LensFileError> {
    let (valid, whole) = match std::str::from_utf8(bytes) {
        Ok(text) => (text, true),
        Err(error) => (std::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or(""), false),
    };
    let control = valid.find(is_no_text);
    match control.or((!whole).then_some(valid.len())) {
        None => Ok(valid.trim_start_matches(MARK).to_owned()),
        Some(offset) => Err(not_text(&valid[..offset], file)),
    }
}

/// Text of a design program: UTF-8 or UTF-16 with or without its mark, else, since older ones write their country's
/// code page, in which only remarks and names differ, that of western Europe.
pub(super) fn any_encoding(bytes: &[u8], file: &str) -> Result<String, LensFileError> {
    let zeros = |first: usize| bytes.iter().skip(first).step_by(2).filter(|&&byte| byte == 0).count();
    let half = bytes.len() / 2;
    let order: Option<fn([u8; 2]) -> u16> = match bytes {
        [0xff, 0xfe, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] => Some(u16::from_be_bytes),
        // Nine in ten characters of a lens are ASCII.
        _ if half > 1 && zeros(1) * 10 > half * 9 => Some(u16::from_le_bytes),
        _ if half > 1 && zeros(0) * 10 > half * 9 => Some(u16::from_be_bytes),
        _ => None,
    };
    let text = match order {
        Some(order) => {
            let (units, odd) = bytes.as_chunks::<2>();
            let text: Result<String, _> = char::decode_utf16(units.iter().map(|pair| order(*pair))).collect();
            match text {
                Ok(text) if odd.is_empty() => text,
                _ => return Err(at(file, 1, 1, Problem::Encoding)),
            }
        }
        None => match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(_) => bytes.iter().map(|&byte| western(byte)).collect(),
        },
    };
    let text = text.trim_start_matches(MARK);
    match text.find(is_no_text) {
        // What DOS put at the end of a file.
        Some(offset) if text[offset..].trim_end_matches(['\u{1a}', '\0']).is_empty() => Ok(text[..offset].to_owned()),
        Some(offset) => Err(not_text(&text[..offset], file)),
        None => Ok(text.to_owned()),
    }
}

/// The byte order mark that some editors put before a text.
const MARK: char = '\u{feff}';

fn is_no_text(c: char) -> bool {
    c.is_control() && !c.is_ascii_whitespace() && c != '\u{b}'
}

/// A byte in Windows' code page 1252: Latin-1, but for letters and marks where that has control codes (Unicode Consortium,
/// CP1252.TXT). Bytes without a letter there are marked as unreadable.
fn western(byte: u8) -> char {
    const FROM_80: [char; 32] = [
        '€', '\u{fffd}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{fffd}', 'Ž', '\u{fffd}',
        '\u{fffd}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{fffd}', 'ž', 'Ÿ',
    ];
    match byte {
        0x80..=0x9f => FROM_80[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

fn not_text(before: &str, file: &str) -> LensFileError {
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    at(file, line, column, Problem::NotText)
}

/// A word of a line and the column it starts in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub(super) text: &'a str,
    pub(super) column: usize,
}

/// The words of a line. Takes time in proportion to its length, however long it is.
pub(super) fn tokens(line: &str) -> Vec<Token<'_>> {
    let (mut offset, mut column) = (0, 1);
    let place = |text: &'_ str| {
        let start = text.as_ptr() as usize - line.as_ptr() as usize;
        column += line[offset..start].chars().count();
        offset = start;
        column
    };
    let columns: Vec<usize> = line.split_whitespace().map(place).collect();
    line.split_whitespace().zip(columns).map(|(text, column)| Token { text, column }).collect()
}

pub(super) fn finite(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|x| x.is_finite())
}

pub(super) fn not_a_number(what: &str, found: &str) -> Problem {
    Problem::NotANumber { what: what.to_owned(), found: found.to_owned() }
}

/// The file's name without folders and ending: the name of a lens that has none.
pub(super) fn stem(file: &str) -> String {
    Path::new(file).file_stem().map_or_else(|| file.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writers refuse nothing that readers take: control codes are no text in any encoding.
    #[test]
    fn old_code_pages_have_letters_where_others_have_controls() {
        let read = |bytes: &[u8]| any_encoding(bytes, "x");
        assert_eq!(read(b"\x93Petzval\x94 \x80 \xe9\x81").unwrap(), "“Petzval” € é\u{fffd}");
        for text in ["a\u{98}b", "a\u{1}b"] {
            assert!(read(text.as_bytes()).is_err() && utf8(text.as_bytes(), "x").is_err(), "{text:?}");
        }
        assert_eq!(utf8("a\u{b}\tb".as_bytes(), "x").unwrap(), "a\u{b}\tb");
    }
}

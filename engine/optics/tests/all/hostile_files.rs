//! Files that mean harm, or nothing: whatever they hold, a lens or one clear line, soon, and never a panic.
//!
//! `engine/fuzz` looks for the like with a fuzzer; this one needs no other compiler. It starts from good files and breaks them.

use std::path::{Path, PathBuf};
use std::time::Instant;

use petzval_optics::formats::{self, agf, lens, zmx};
use petzval_optics::glass::Catalogue;
use petzval_optics::system::{LensSettings, System};
use proptest::prelude::*;

use crate::common::repository;

const KINDS: [&str; 7] = ["x.lens", "x.zmx", "x.seq", "x.len", "x.dat", "x.txt", "flare.lens"];

fn foreign() -> PathBuf {
    repository("tests/reference/foreign")
}

/// Asserts the promises of every reader; also that a lens that it reads can be set up, and comes back.
fn judge(bytes: &[u8], name: &str) {
    match formats::parse_bytes(bytes, Path::new(name), Catalogue::shipped(), None) {
        Ok(reading) => {
            let lens = &reading.prescription;
            let _ = System::new(lens, &LensSettings::default());
            for (write, name) in [(lens::write as fn(&_, &_) -> _, "x.lens"), (zmx::write, "x.zmx")] {
                let (text, lost): (String, Vec<String>) = write(lens, Catalogue::shipped());
                if lost.is_empty() {
                    let back = formats::parse_bytes(text.as_bytes(), Path::new(name), Catalogue::shipped(), None);
                    let back = back.unwrap_or_else(|error| panic!("{error}\n{text}")).prescription;
                    let shapes = |lens: &petzval_optics::prescription::Prescription| {
                        lens.surfaces.iter().map(|row| (row.shape, row.semi_diameter_mm)).collect::<Vec<_>>()
                    };
                    assert_eq!(shapes(&back), shapes(lens), "{text}");
                }
            }
        }
        Err(error) => {
            let text = error.to_string();
            assert!(!text.contains('\n') && text.starts_with(&format!("{name}:")), "{text:?}");
        }
    }
}

/// Words that readers know, and numbers at the edges.
const WORDS: [&str; 40] = [
    "SURF",
    "CURV",
    "DISZ",
    "GLAS",
    "PARM",
    "STOP",
    "TYPE",
    "EVENASPH",
    "TOROIDAL",
    "INFINITY",
    "MIRROR",
    "NOTE 0 # position:",
    "S",
    "SO",
    "SI",
    "ASP",
    "K",
    "A",
    "REFL",
    "PRV",
    "END",
    "NXT",
    "RD",
    "TH",
    "AST",
    "[lens data]",
    "AS",
    "d5\t",
    "Bf",
    "surfaces:",
    "nan",
    "inf",
    "1e308",
    "-1e-308",
    "0",
    "1e400",
    "99999999999999999999",
    "-0",
    "\t",
    ";",
];

fn breaks() -> impl Strategy<Value = Vec<(f64, usize, usize)>> {
    prop::collection::vec((0.0..1.0f64, 0..6usize, 0..WORDS.len()), 1..8)
}

/// The file with pieces cut out, doubled, moved, or put in.
fn broken(good: &[u8], breaks: &[(f64, usize, usize)]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for &(place, how, word) in breaks {
        let at = (place * bytes.len() as f64) as usize;
        let end = (at + 1 + word * 3).min(bytes.len());
        match how {
            0 => drop(bytes.drain(at..end)),
            1 => drop(bytes.splice(at..at, WORDS[word].bytes())),
            2 => drop(bytes.splice(at..end, format!(" {} ", WORDS[word]).bytes())),
            3 => bytes.truncate(at),
            4 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << (word % 8);
                }
            }
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn broken_files(breaks in breaks(), kind in 0..KINDS.len()) {
        for entry in std::fs::read_dir(foreign()).unwrap() {
            let path = entry.unwrap().path();
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            if ["zmx", "seq", "len", "txt"].contains(&ending.as_str()) {
                let bytes = broken(&std::fs::read(&path).unwrap(), &breaks);
                judge(&bytes, &format!("x.{ending}"));
                // And what another reader says of it.
                judge(&bytes, KINDS[kind]);
            }
        }
        let dat = broken(b"# lens\n60 6 1.5168 30\n0 2 0 20\n-60 55 1 30\n", &breaks);
        judge(&dat, "x.dat");
        let flare = broken(b"name: x\nsurfaces:\n60 6 1.5 64 15 1\nstop 2 1 0 10 0\n-60 55 1 0 15 1\n", &breaks);
        judge(&flare, "x.lens");
        let agf = broken(b"CC x\nNM N-BK7 2 0 1.5168 64 0 1\nCD 1.0 0.006 0.2 0.02 1.0 103.5\nLD 0.3 2.5\nIT 0.4 0.99 10\n", &breaks);
        let _ = agf::parse_bytes(&agf, "x.agf");
    }

    #[test]
    fn anything(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        for kind in KINDS {
            judge(&bytes, kind);
        }
        let _ = agf::parse_bytes(&bytes, "x.agf");
    }

    #[test]
    fn words_of_lens_files(words in prop::collection::vec((0..WORDS.len(), any::<bool>()), 0..300)) {
        let text: String = words.iter().map(|&(word, end)| format!("{}{}", WORDS[word], if end { "\n" } else { " " })).collect();
        for kind in KINDS {
            judge(text.as_bytes(), kind);
        }
    }
}

/// Megabytes, as one line, as many lines, as nested brackets: no reader takes more than a moment.
#[test]
fn long_files_take_no_time() {
    let megabytes = |piece: &str| piece.repeat((2 << 20) / piece.len()).into_bytes();
    let pieces = [
        "1 ",
        "1\t",
        "(((([[[[",
        "S 1 1;",
        "NXT\n",
        "SURF 1\n",
        "60 6 1.5 30\n",
        "PARM 1 1\n",
        "A 1;",
        "&",
        "'",
        "\n",
        "# a: b\n",
        "\u{feff}",
    ];
    for piece in pieces {
        let bytes = megabytes(piece);
        for kind in KINDS {
            let begun = Instant::now();
            judge(&bytes, kind);
            // Tens of milliseconds, tenfold for slow machines, and more for busy ones.
            assert!(begun.elapsed().as_secs_f64() < 20.0, "{piece:?} as {kind}: {:?}", begun.elapsed());
        }
    }
    let too_long = formats::parse_bytes(&vec![b' '; (8 << 20) + 1], Path::new("x.zmx"), Catalogue::shipped(), None);
    assert!(too_long.unwrap_err().to_string().contains("longer than 8388608 bytes"));
}

/// A gigabyte of one line: not even read. (A sparse file, which takes no room.)
#[test]
fn a_gigabyte_of_one_line() {
    for kind in KINDS {
        let path = std::env::temp_dir().join(format!("petzval-hostile-{}-{kind}", std::process::id()));
        std::fs::File::create(&path).unwrap().set_len(1 << 30).unwrap();
        let begun = Instant::now();
        let error = formats::read(&path, Catalogue::shipped()).unwrap_err().to_string();
        std::fs::remove_file(&path).unwrap();
        assert!(error.contains("longer than"), "{error}");
        assert!(begun.elapsed().as_secs_f64() < 5.0, "{kind}: {:?}", begun.elapsed());
    }
}

#[test]
fn wrong_encodings_are_named() {
    for kind in ["x.zmx", "x.seq", "x.len", "x.dat", "x.txt"] {
        let refused = |bytes: &[u8]| {
            formats::parse_bytes(bytes, Path::new(kind), Catalogue::shipped(), None).unwrap_err().to_string()
        };
        let odd = refused(b"\xff\xfeM\0O\0D");
        // What has no ending of its own is read as the engine's own file, which is UTF-8.
        let wanted = if kind == "x.txt" { "x.txt:1:1: this is not text" } else { "neither UTF-8 nor UTF-16" };
        assert!(odd.contains(wanted), "{odd}");
        assert!(refused(b"MODE SEQ\n\x00\x01\x02\x00 SURF").contains("this is not text"), "{kind}");
    }
}

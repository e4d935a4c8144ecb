//! Lens files of other programs: a lens that is read is the one of those programs, a written file reads back the same, and
//! faults are reported in one line.

mod catalogues;
mod configurations;
mod frames;
mod kinds;
mod other_packages;
mod there_and_back;

use std::path::Path;

use petzval_optics::formats::{self, LensFileError, Reading};
use petzval_optics::glass::Catalogue;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{LensSettings, System};

use crate::common::repository;

fn foreign(name: &str) -> Reading {
    let path = repository("tests/reference/foreign").join(name);
    formats::read(&path, Catalogue::shipped()).unwrap_or_else(|error| panic!("{error}"))
}

fn parse(name: &str, text: &str) -> Result<Reading, LensFileError> {
    formats::parse_bytes(text.as_bytes(), Path::new(name), Catalogue::shipped(), None)
}

fn refused(name: &str, text: &str) -> String {
    let error = parse(name, text).map(|reading| reading.prescription.name).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

fn remarks(reading: &Reading) -> String {
    reading.remarks.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn system(lens: &Prescription) -> System {
    System::new(lens, &LensSettings::default()).unwrap()
}

/// A lens of Zemax's.
const ZMX: &str = "VERS 1\nMODE SEQ\nNAME Täst\nUNIT MM X W X CM MR CPMM\nENPD 10\nGCAT HOYA SCHOTT\nFTYP 0 0 2 1 0 0 0\n\
    YFLN 0 10\nWAVM 1 0.5875618 1\nPWAV 1\nSURF 0\n  TYPE STANDARD\n  CURV 0 0 0 0 0 \"\"\n  DISZ INFINITY\n\
    SURF 1\n  STOP\n  TYPE STANDARD\n  CURV 2.0E-002 0 0 0 0 \"\"\n  DISZ 4\n  GLAS F2 0 0 1.5 40 0 0 0 0 0 0\n  DIAM 6 1 0 0 1 \"\"\n  MEMA 12.7 0 0 0 1 \"\"\n\
    SURF 2\n  TYPE EVENASPH\n  CURV -0.02 0\n  PARM 1 1e-4\n  PARM 2 2e-6\n  CONI -1.5\n  DISZ 45\n  DIAM 6.5 1 0 0 1 \"\"\nSURF 3\n  CURV -0.01\n  DISZ 0\n";

//! The properties that every target tests of a reader.

use std::path::Path;

use petzval_optics::formats::{self, agf, lens, rii, zmx};
use petzval_optics::glass::Catalogue;
use petzval_optics::system::{LensSettings, System};

/// A lens is read or refused in one line; a lens that is read can be set up, and comes back from its written file.
pub fn lens(bytes: &[u8], name: &str) {
    let bytes = if name == "flare.lens" { &[b"surfaces:\n", bytes].concat()[..] } else { bytes };
    match formats::parse_bytes(bytes, Path::new(name), Catalogue::shipped(), None) {
        Ok(reading) => {
            let _ = System::new(&reading.prescription, &LensSettings::default());
            for (write, name) in [(lens::write as fn(&_, &_) -> _, "x.lens"), (zmx::write, "x.zmx")] {
                let (text, lost): (String, Vec<String>) = write(&reading.prescription, Catalogue::shipped());
                let back = formats::parse_bytes(text.as_bytes(), Path::new(name), Catalogue::shipped(), None);
                if lost.is_empty() {
                    let back = back.unwrap_or_else(|error| panic!("{error}\n{text}")).prescription;
                    assert_eq!(back.surfaces.len(), reading.prescription.surfaces.len(), "{text}");
                }
            }
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

/// A glass catalogue is read or refused in one line; its indices are finite.
pub fn catalogue(bytes: &[u8]) {
    match agf::parse_bytes(bytes, "x.agf") {
        Ok((media, _)) => media.iter().for_each(|medium| assert!(medium.index(587.6).is_finite())),
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

/// A glass of refractiveindex.info is read or refused in one line; its index is finite.
pub fn glass_page(bytes: &[u8]) {
    match rii::parse_bytes(bytes, "x.yml", "X") {
        Ok(medium) => assert!(medium.index(587.6).is_finite()),
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

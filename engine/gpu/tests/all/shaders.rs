// SPDX-License-Identifier: GPL-3.0-or-later
//! Every shader is valid WGSL, in both kinds of numbers, for every lens of the library. No device is needed.

use crate::common::{lens_paths, system};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use petzval_gpu::lens::LensTable;
use petzval_gpu::number::Number;
use petzval_gpu::shader::{self, Style};
use petzval_optics::system::LensSettings;
use petzval_optics::trace::Travel;

fn validate(what: &str, text: &str, capabilities: Capabilities) {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{what}: {}", error.emit_to_string(text)));
    let mut validator = Validator::new(ValidationFlags::all(), capabilities);
    validator.validate(&module).unwrap_or_else(|error| panic!("{what}: {}", error.emit_to_string(text)));
}

fn validate_all<N: Number>(what: &str, lens: &LensTable, capabilities: Capabilities) {
    for style in [Style::Loaded, Style::Written] {
        let name = format!("{what} {} {style:?}", N::NAME);
        validate(&name, &shader::trace::<N>(lens, style, 64), capabilities);
        validate(&name, &shader::flood::<N>(lens, style, 128), capabilities);
    }
}

#[test]
fn every_shader_is_valid() {
    let mut valid = 0;
    for path in lens_paths() {
        let settings = LensSettings { blades: 7, blade_curvature: 0.4, ..LensSettings::default() };
        let lens = LensTable::new(&system(&path, &settings), &[486.1, 656.3], Travel::FromFilm);
        let lens = lens.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let name = path.display().to_string();
        validate_all::<f32>(&name, &lens, Capabilities::empty());
        validate_all::<f64>(&name, &lens, Capabilities::FLOAT64);
        valid += 1;
    }
    assert!(valid > 50, "{valid} lenses");
}

//! Gaussian properties and Seidel sums of every reference lens against a 50-digit trace.

// A comparison that NaN fails.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use crate::common::{ASPHERES, lens_names, number, reference_json, system};
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::seidel::{Seidel, Sums};
use petzval_optics::surface::Section;

const RELATIVE: f64 = 1e-12;

fn every_lens() -> impl Iterator<Item = String> {
    lens_names().into_iter().chain(ASPHERES.map(str::to_owned))
}

#[test]
fn gaussian_properties_are_those_of_the_reference() {
    let table = reference_json("paraxial.json");
    let mut bad = Vec::new();
    for name in every_lens() {
        let system = system(&name);
        let last = system.last_vertex_z_mm();
        for (line, nm) in [("F", line_nm::F), ("d", line_nm::D), ("C", line_nm::C)] {
            let p = Paraxial::new(&system, nm);
            let expected = |key: &str| number(&table[&name][line][key]);
            // A length that is a difference of longer ones can be right only to a part of those.
            let scale = expected("efl").abs().max(last.abs());
            let mut compare = |key: &str, found: Option<f64>, expected: f64, scale: f64| {
                let found = found.unwrap_or(f64::INFINITY);
                let error = (found - expected).abs() / expected.abs().max(scale);
                if !(error <= RELATIVE) {
                    bad.push(format!("{name} {line} {key}: {found} {expected} ({error:e})"));
                }
            };
            let image_index = expected("n_image").abs();
            compare("efl", p.efl_mm, expected("efl") * image_index, 0.0);
            compare("bfd", p.bfd_mm, expected("bfd"), scale);
            compare("ffd", p.ffd_mm, expected("ffd"), scale);
            compare("pp_front", p.object_principal_plane_mm, expected("pp_front"), scale);
            compare("pp_rear", p.image_principal_plane_mm.map(|z| z - last), expected("pp_rear"), scale);
            compare("bfd plane", p.image_focal_plane_mm.map(|z| z - last), expected("bfd"), scale);
            compare("enp", p.entrance_pupil.z_mm, expected("enp"), scale);
            compare("exp", p.exit_pupil.z_mm.map(|z| z - last), expected("exp"), scale);
            compare("enp_diameter", p.entrance_pupil.diameter_mm, expected("enp_diameter"), 0.0);
            compare("exp_diameter", p.exit_pupil.diameter_mm, expected("exp_diameter"), 0.0);
            compare("f_number_stop", p.f_number, expected("f_number_stop"), 0.0);
            compare("petzval_radius", p.petzval_radius_mm, expected("petzval_radius"), 0.0);
            if line == "d" {
                compare("widest", Some(system.widest_f_number()), expected("f_number_stop"), 0.0);
            }
        }
    }
    assert!(bad.is_empty(), "{} values:\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn seidel_and_chromatic_sums_are_those_of_the_reference() {
    let table = reference_json("paraxial.json");
    let mut bad = Vec::new();
    for name in every_lens() {
        let expected = &table[&name]["seidel_d"];
        let field = number(&expected["field_deg"]);
        let system = system(&name);
        // The aspheres of the reference are read from its JSON, which has no header.
        let seidel = Seidel::at_field(&system, line_nm::D, None, field).unwrap();
        if !ASPHERES.contains(&name.as_str()) {
            assert_eq!(Seidel::new(&system, line_nm::D, None).unwrap(), seidel, "{name}");
        }
        assert_eq!(seidel.by_surface.len(), system.surface_count());
        let Sums { seidel, chromatic } = seidel.total();
        let mut compare = |keys: &[&str], sums: &[f64]| {
            let largest = keys.iter().fold(0.0f64, |m, key| m.max(number(&expected[key]).abs()));
            for (key, sum) in keys.iter().zip(sums) {
                let mut expected = number(&expected[key]);
                if name == "plano-hyperbolic-50mm" && *key == "SV" {
                    expected += term_at_a_plane_pupil(&system, field.to_radians());
                }
                let error = (sum - expected).abs() / largest;
                // Without glass there is no colour.
                if !(error <= RELATIVE || *sum == expected) {
                    bad.push(format!("{name} {key}: {sum} {expected} ({error:e})"));
                }
            }
        };
        compare(&["SI", "SII", "SIII", "SIV", "SV"], &seidel);
        compare(&["CL", "CT"], &chromatic);
    }
    assert!(bad.is_empty(), "{} values:\n{}", bad.len(), bad.join("\n"));
}

/// −Ā³ y Δ(1/n²): the term of a plane in the pupil in S_V of an object at infinity. There Snell's invariant A of the
/// marginal ray is 0, Welford's form of S_V divides by it, and the reference leaves the surface out; the limit of a
/// surface that becomes plane is this term, and the form of `seidel.rs` contains it.
fn term_at_a_plane_pupil(system: &petzval_optics::system::System, field_rad: f64) -> f64 {
    let n = 1.0 / Paraxial::new(system, line_nm::D).efl_mm.unwrap()
        * -system.surfaces()[1].shape.curvature_at_vertex(Section::Y).recip();
    let n = 1.0 + n;
    -field_rad.tan().powi(3) * system.stop_semi_diameter_mm() * (1.0 / (n * n) - 1.0)
}

// SPDX-License-Identifier: GPL-3.0-or-later
//! The lens library and rays for it.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Once;

use glam::DVec3;
use petzval_gpu::device::{DeviceChoice, Gpu};
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Travel};

/// The folder of the library: that of the repository, or where this program runs without one, that of PETZVAL_LENSES.
pub(crate) fn lens_folder() -> PathBuf {
    std::env::var_os("PETZVAL_LENSES")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses"), PathBuf::from)
}

pub(crate) fn lens_paths() -> Vec<PathBuf> {
    let files = std::fs::read_dir(lens_folder()).expect("the lens library is there");
    let mut paths: Vec<PathBuf> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == "lens"));
    paths.sort();
    paths
}

pub(crate) fn system(path: &Path, settings: &LensSettings) -> System {
    let prescription = lens::read(path, Catalogue::shipped()).unwrap_or_else(|error| panic!("{error}"));
    System::new(&prescription, settings).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

pub(crate) fn shipped(name: &str) -> System {
    system(&lens_folder().join(format!("{name}.lens")), &LensSettings::default())
}

/// The device that PETZVAL_GPU names, or any; `None`, and a line, where there is none.
pub(crate) fn gpu() -> Option<Gpu> {
    let asked = std::env::var("PETZVAL_GPU").unwrap_or_else(|_| "any".to_owned());
    let choice: DeviceChoice = asked.parse().expect("every word is a choice");
    match Gpu::open(&choice) {
        Ok(Some(gpu)) => Some(gpu),
        Ok(None) => None,
        Err(error) => {
            static SAID: Once = Once::new();
            // Not by println, which tests that pass keep to themselves.
            SAID.call_once(|| {
                let _ = writeln!(std::io::stderr(), "tests of devices are skipped: {error}");
            });
            None
        }
    }
}

/// A number in [0, 1), one for each pair of numbers.
pub(crate) fn random(i: u32, axis: u32) -> f64 {
    let mut state = (u64::from(i) << 32 | u64::from(axis)).wrapping_add(0x9E37_79B9_7F4A_7C15);
    for factor in [0xBF58_476D_1CE4_E5B9u64, 0x94D0_49BB_1331_11EB] {
        state = (state ^ (state >> 30)).wrapping_mul(factor);
        state ^= state >> 27;
    }
    (state >> 11) as f64 / (1u64 << 53) as f64
}

/// A point of a disc, evenly.
fn in_disc(i: u32, axis: u32) -> [f64; 2] {
    let (sin, cos) = (random(i, axis) * std::f64::consts::TAU).sin_cos();
    let out = random(i, axis + 1).sqrt();
    [out * cos, out * sin]
}

/// Rays over the field, and over the aperture: every other one over that of the first surface, the rest over the pupil as
/// it is seen from the axis, a twentieth beyond the rims.
pub(crate) fn rays(system: &System, travel: Travel, count: u32) -> Vec<Ray> {
    let info = Paraxial::new(system, line_nm::D);
    let field = system.half_field_deg().unwrap_or(15.0).min(50.0).to_radians().tan();
    let efl = info.efl_mm.map_or(50.0, f64::abs);
    let (pupil, z, semi) = match travel {
        Travel::FromScene => (info.entrance_pupil, 0.0, system.surfaces()[0].semi_diameter_mm),
        Travel::FromFilm => (info.exit_pupil, system.last_vertex_z_mm(), system.rear_radius_mm()),
    };
    let ray = |i: u32| {
        let [[x, y], [u, v]] = [in_disc(i, 0), in_disc(i, 2)].map(|point| point.map(|x| 1.05 * x));
        let target = match (i % 2, pupil.z_mm, pupil.diameter_mm) {
            (0, Some(z), Some(diameter)) => DVec3::new(0.5 * x * diameter, 0.5 * y * diameter, z),
            _ => DVec3::new(x * semi, y * semi, z),
        };
        // More of them near the axis.
        let field = field * random(i, 4);
        match travel {
            Travel::FromScene => {
                let direction = DVec3::new(u * field, v * field, 1.0).normalize();
                Ray { origin: target - direction * (500.0 + 10.0 * efl), direction }
            }
            Travel::FromFilm => {
                let half = efl * field;
                let origin = DVec3::new(u * half, v * half, system.film_z_published_mm());
                let direction = (target - origin).normalize();
                // The pupil may lie behind the film.
                Ray { origin, direction: direction * (direction.z * (z - origin.z)).signum() }
            }
        }
    };
    (0..count).map(ray).collect()
}

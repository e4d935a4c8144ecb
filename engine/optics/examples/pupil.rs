//! Times the pupil map and counts the rays that it loses. (`cargo bench -p petzval-optics` times the tracer.)
//!
//! `cargo run --release -p petzval-optics --example pupil [LENS...]`; without a lens: those of `lenses/`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;
use petzval_optics::focus::{FilmPlane, film_z_for_focus_mm};
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};

fn main() {
    let mut files: Vec<PathBuf> = std::env::args().skip(1).map(PathBuf::from).collect();
    if files.is_empty() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
        files = std::fs::read_dir(folder).map(|d| d.flatten().map(|e| e.path()).collect()).unwrap_or_default();
        files.retain(|f| f.extension().is_some_and(|e| e == "lens"));
        files.sort();
    }
    println!("lens f-number blades: map ms, sample ns | passed at 0 .. 1 of the field");
    for file in files {
        match lens::read(&file, Catalogue::shipped()) {
            Ok(prescription) => {
                for (f_number, blades) in [(None, 0), (Some(8.0), 0), (Some(8.0), 6)] {
                    let settings = LensSettings { f_number, blades, ..LensSettings::default() };
                    match System::new(&prescription, &settings) {
                        Ok(system) => report(&system, blades),
                        Err(error) => println!("{}: {error}", file.display()),
                    }
                }
            }
            Err(error) => println!("{error}"),
        }
    }
}

/// Half of the picture's diagonal: to the edge of the field that the design is for.
fn image_radius_mm(system: &System) -> f64 {
    let efl = Paraxial::new(system, line_nm::D).efl_mm.map_or(50.0, f64::abs);
    let half_field = system.half_field_deg().unwrap_or(20.0).min(40.0);
    efl / system.image_index(line_nm::D) * half_field.to_radians().tan()
}

fn report(system: &System, blades: u32) {
    let Ok(z_mm) = film_z_for_focus_mm(system, line_nm::D, f64::INFINITY) else {
        println!("{}: no film", system.name());
        return;
    };
    let tracer = system.at_wavelength(line_nm::D);
    let film = FilmPlane::upright(z_mm);
    let radius = image_radius_mm(system);
    let start = Instant::now();
    let map = PupilMap::new(&tracer, system, &film, radius * 0.8, radius * 0.6);
    let map_ms = start.elapsed().as_secs_f64() * 1e3;
    let passed: Vec<String> =
        (0..=5).map(|i| pass_rate(&tracer, &map, film.point(radius * 0.2 * f64::from(i), 0.0))).collect();
    let sample_ns = time(&map, &film, radius);
    println!(
        "{} f/{:.2} {blades}: {map_ms:.1} ms, {sample_ns:.0} ns | {}",
        system.name(),
        system.f_number(),
        passed.join(" ")
    );
}

const GRID: u32 = 160;

fn aimed(map: &PupilMap, point: DVec3, u: [f64; 2]) -> Ray {
    let target = map.sample(point, u).target;
    Ray { origin: point, direction: (target - point).normalize() }
}

fn pass_rate(tracer: &Tracer, map: &PupilMap, point: DVec3) -> String {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID);
    let count =
        (0..GRID * GRID).filter(|i| tracer.from_film(aimed(map, point, [at(i / GRID), at(i % GRID)])).is_ok()).count();
    format!("{:.1}%", 100.0 * count as f64 / f64::from(GRID * GRID))
}

fn time(map: &PupilMap, film: &FilmPlane, radius: f64) -> f64 {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID);
    let points: Vec<(DVec3, [f64; 2])> = (0..GRID * GRID)
        .map(|i| {
            let point = film.point(radius * at(i / GRID) * 0.7, radius * at(i * 7 % GRID) * 0.7);
            (point, [at(i * 13 % GRID), at(i % GRID)])
        })
        .collect();
    let start = Instant::now();
    let sum: f64 = points.iter().map(|&(point, u)| aimed(map, point, u).direction.z).sum();
    std::hint::black_box(sum);
    start.elapsed().as_secs_f64() * 1e9 / points.len() as f64
}

//! Proves the fates of all rays through lenses: `prove [--undecided 0.001] [--seconds 600] LENS...`.

use std::path::Path;

use petzval_optics::focus::{FilmPlane, film_z_for_focus_mm};
use petzval_optics::formats;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::system::{LensSettings, System};
use petzval_proof::{ProofOptions, prove};

fn main() {
    let mut files: Vec<String> = std::env::args().skip(1).collect();
    let mut option = |name: &str, value: f64| match files.iter().position(|word| word == name) {
        Some(i) => files.drain(i..i + 2).nth(1).unwrap().parse().unwrap(),
        None => value,
    };
    let undecided = option("--undecided", 1e-3);
    let seconds = option("--seconds", 600.0);
    let film_radius_mm = option("--film-radius", 21.6);
    for file in files {
        let reading = formats::read(Path::new(&file), Catalogue::shipped()).unwrap();
        let system = System::new(&reading.prescription, &LensSettings::default()).unwrap();
        let Ok(film_z) = film_z_for_focus_mm(&system, line_nm::D, f64::INFINITY) else {
            println!("{file}: no film");
            continue;
        };
        let film = FilmPlane {
            curvature_per_mm: system.film_radius_mm().map_or(0.0, f64::recip),
            ..FilmPlane::upright(film_z)
        };
        let options = ProofOptions { film_radius_mm, wavelengths_nm: [380.0, 780.0], undecided, seconds, threads: 2 };
        match prove(&system, &film, &options) {
            Ok(proof) => println!(
                "{file}: {} surfaces, {} columns, {} cells, passes {:.4}, undecided {:.5}, {:.1} s",
                system.surface_count(),
                proof.columns.len(),
                proof.columns.iter().map(|c| c.cells.len()).sum::<usize>(),
                proof.passes,
                proof.undecided,
                proof.seconds
            ),
            Err(error) => println!("{file}: {error}"),
        }
    }
}

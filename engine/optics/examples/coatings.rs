//! The tables of docs/coatings.md: the reflectance of recipes, and the transmittance of shipped lenses.
//!
//! `cargo run --release -p petzval-optics --example coatings`

use std::error::Error;
use std::path::Path;

use petzval_optics::coating::{Coating, RECIPES};
use petzval_optics::focus::Focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::system::{LensSettings, System};
use petzval_optics::transmission::Passages;

const NM: [f64; 7] = [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0];

fn main() -> Result<(), Box<dyn Error>> {
    let head = |first: &str| {
        let columns: Vec<String> = NM.iter().map(|nm| format!(" {nm} |")).collect();
        println!("| {first} |{}", columns.concat());
        println!("|---|{}", "---:|".repeat(NM.len()));
    };
    head("recipe, on glass of 1.52 (mirrors: in air), %");
    for recipe in &RECIPES {
        let coating = Coating::parse(recipe.name)?;
        let is_mirror = coating.split(1.0, 1.52, 550.0, 1.0).mean_transmitted() < 1e-3;
        let reflected = |nm: &f64| match is_mirror {
            true => coating.mirrored(1.0, *nm, 1.0).mean_reflected(),
            false => coating.split(1.0, 1.52, *nm, 1.0).mean_reflected(),
        };
        let cells: Vec<String> = NM.iter().map(|nm| format!(" {:.2} |", 100.0 * reflected(nm))).collect();
        println!("| {} |{}", recipe.name, cells.concat());
    }
    println!();
    println!("| lens | coatings | bare: 450 | 550 | 650 nm | MgF2: 450 | 550 | 650 nm | triple: 450 | 550 | 650 nm |");
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
    let mut paths: Vec<_> = std::fs::read_dir(folder)?.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "lens"));
    paths.sort();
    for path in paths {
        let system = System::new(&lens::read(&path, Catalogue::shipped())?, &LensSettings::default())?;
        let film_z_mm = Focus::at_infinity(&system, line_nm::D).film_z_mm;
        let mut cells = String::new();
        for name in ["none", "MgF2", "triple"] {
            let coated = system.clone().coated(&Coating::parse(name)?);
            let parts = Passages::new(&coated, line_nm::D).in_the_middle(film_z_mm, &[450.0, 550.0, 650.0]);
            for i in 0..3 {
                let part = parts.as_ref().map_or("dark".to_owned(), |parts| format!("{:.1}", 100.0 * parts[i]));
                cells += &format!(" {part} |");
            }
        }
        let name = path.file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
        println!("| {name} | {} |{cells}", system.coatings().join(", "));
    }
    Ok(())
}

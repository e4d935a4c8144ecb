//! Writes docs/numerics.md: the error of hard rays in f64, in f32, and by the paper's printed equations.
//!
//! `cargo run --release -p petzval-optics --example numerics [RAYS]`, or `make numerics`.

#[path = "../tests/all/numerics/measure.rs"]
mod measure;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use measure::{By, Errors, Tally, measure};
use petzval_testkit::hard_rays::Category;

const HEAD: &str = include_str!("numerics/head.md");
const READING: &str = include_str!("numerics/reading.md");

fn main() -> std::io::Result<()> {
    let rays: f64 = std::env::args().nth(1).map_or(5e6, |text| text.parse().expect("the number of rays"));
    let start = Instant::now();
    let mut tallies = measure(rays as u64, 1);
    let seconds = start.elapsed().as_secs_f64();
    let all: u64 = tallies.iter().map(|(_, [tally, ..])| tally.rays).sum();
    let mut page = HEAD.replace("{RAYS}", &grouped(all));
    for (title, errors) in [("Directions", direction as fn(&mut Tally) -> &mut Errors), ("Points", point)] {
        write_errors(&mut page, title, &mut tallies, errors);
    }
    write_reasons(&mut page, &tallies);
    page += READING;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/numerics.md");
    std::fs::write(path, page)?;
    println!("petzval: wrote docs/numerics.md from {} rays in {seconds:.0} s", grouped(all));
    Ok(())
}

fn direction(tally: &mut Tally) -> &mut Errors {
    &mut tally.direction
}

fn point(tally: &mut Tally) -> &mut Errors {
    &mut tally.point
}

type Tallies = [(Category, [Tally; 3])];

fn write_errors(page: &mut String, title: &str, tallies: &mut Tallies, of: fn(&mut Tally) -> &mut Errors) {
    let _ = write!(
        page,
        "\n## {title}\n\n| category | f64 median | f64 worst | worst / data | f32 median | f32 worst | worst / data \
         | printed median | printed worst | worst / data |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    for (category, tallies) in tallies {
        let _ = write!(page, "| {} |", category.name());
        for tally in tallies {
            if tally.rays == 0 {
                *page += " | | |";
                continue;
            }
            let errors = of(tally);
            let (median, worst) = (errors.median(), errors.worst());
            let _ = write!(page, " {} | {} | {} |", short(median), short(worst), short(errors.worst_over_data));
        }
        *page += "\n";
    }
}

fn write_reasons(page: &mut String, tallies: &Tallies) {
    *page += "\n## Reasons\n\n| category | rays | lost | other in f64 | roundings | other in f32 | roundings | other \
              as printed | roundings |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    for (category, tallies) in tallies {
        let _ = write!(page, "| {} | {} | {} |", category.name(), grouped(tallies[0].rays), grouped(tallies[0].lost));
        for (by, tally) in By::ALL.iter().zip(tallies) {
            let _ = match (by, tally.rays, tally.other_status) {
                (_, 0, _) => write!(page, " | |"),
                (_, _, 0) => write!(page, " 0 | |"),
                (_, _, other) => write!(page, " {} | {} |", grouped(other), short(tally.worst_margin)),
            };
        }
        *page += "\n";
    }
}

/// Two digits, or a power of ten.
fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return "∞".to_owned();
    }
    match x {
        ..0.01 => format!("{x:.0e}"),
        ..10.0 => format!("{x:.1}"),
        ..10_000.0 => format!("{x:.0}"),
        _ => {
            // 9.7·10⁹ is 1·10¹⁰ in one digit.
            let digits = format!("{x:.0e}");
            let (digit, power) = digits.split_once('e').unwrap_or((&digits, "0"));
            format!("{digit}·10^{power}")
        }
    }
}

/// The count with thin spaces between thousands.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).unwrap_or("")).collect();
    groups.join(" ")
}

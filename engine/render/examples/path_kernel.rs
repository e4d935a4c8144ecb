//! Renders the bench scene on one thread and says what a sample cost: for profilers, and for counting instructions.
//!
//! `cargo run --release -p petzval-render --example path_kernel -- [pinhole|thin|one|exact] [SAMPLES] [small|large] [noise]`
//!
//! With `noise` it renders twice, with other random numbers, and says by how much the two differ.

#[path = "../benches/stage/mod.rs"]
mod stage;

use petzval_render::camera::Model;
use petzval_render::job::{Job, Settings};
use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

const SIZE: [u32; 2] = [480, 270];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize, otherwise: &str| arguments.get(i).cloned().unwrap_or_else(|| otherwise.to_owned());
    let (model, wavelength_nm) = match word(0, "pinhole").as_str() {
        "pinhole" => (Model::Pinhole, None),
        "thin" => (Model::Thin, None),
        "one" => (Model::Lens, Some(587.5618)),
        "exact" => (Model::Lens, None),
        other => return Err(format!("no camera '{other}': pinhole, thin, one or exact").into()),
    };
    let samples: u32 = word(1, "4").parse()?;
    let bodies = if word(2, "small") == "large" { stage::LARGE } else { stage::SMALL };
    let stage = Arc::new(stage::stage(bodies));
    let render = |seed: u32| -> Result<_, Box<dyn Error>> {
        let settings = Settings {
            width: SIZE[0],
            height: SIZE[1],
            samples,
            seed,
            sample_offset: 0,
            threads: 1,
            max_bounces: 8,
            clamp_indirect: 0.0,
            filter_width_px: 0.0,
            transparent_film: false,
            pipeline: Default::default(),
            with_data: false,
            integrator: Default::default(),
        };
        let job = Job::start(stage.clone(), stage::camera(model, wavelength_nm, SIZE), settings)?;
        while !job.wait(Duration::from_secs(1)) {}
        Ok((job.statistics(), job.film().picture()))
    };
    let (statistics, picture) = render(1)?;
    let count = f64::from(SIZE[0] * SIZE[1] * samples);
    let mean = picture.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>() / (3 * picture.len()) as f64;
    println!(
        "{:.3} us a sample, {:.2} rays a sample, mean radiance {mean:.4}, stage built in {:.2} s",
        statistics.render_seconds / count * 1e6,
        statistics.counts.rays as f64 / count,
        stage.build_seconds
    );
    if word(3, "") == "noise" {
        let (_, other) = render(2)?;
        let noise = relative_error(&picture, &other, mean);
        println!("relMSE {noise:.5}, by samples {:.4}", noise * f64::from(samples));
    }
    Ok(())
}

/// Mean of the squared errors, each relative to the square of its own brightness, of either of two pictures that differ
/// in noise alone, the worst thousandth of the pixels left out.
fn relative_error(a: &[[f32; 4]], b: &[[f32; 4]], mean: f64) -> f64 {
    let floor = (0.01 * mean).powi(2);
    let error = |(a, b): (&[f32; 4], &[f32; 4])| {
        let one = |i: usize| {
            let (a, b) = (f64::from(a[i]), f64::from(b[i]));
            0.5 * (a - b).powi(2) / ((0.5 * (a + b)).powi(2) + floor)
        };
        (one(0) + one(1) + one(2)) / 3.0
    };
    let mut errors: Vec<f64> = a.iter().zip(b).map(error).collect();
    errors.sort_by(f64::total_cmp);
    errors.truncate(errors.len() * 999 / 1000);
    errors.iter().sum::<f64>() / errors.len() as f64
}

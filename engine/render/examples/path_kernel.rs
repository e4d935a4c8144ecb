//! Renders the bench scene on one thread and says what a sample cost: for profilers, and for counting instructions.
//!
//! `cargo run --release -p petzval-render --example path_kernel -- [pinhole|thin|one|exact] [SAMPLES] [small|large]`

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
    let settings = Settings {
        width: SIZE[0],
        height: SIZE[1],
        samples,
        seed: 1,
        sample_offset: 0,
        noise_threshold: 0.0,
        min_samples: 0,
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
    let statistics = job.statistics();
    let count = f64::from(SIZE[0] * SIZE[1] * samples);
    let picture = job.film().picture();
    let mean = picture.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>() / (3 * picture.len()) as f64;
    println!(
        "{:.3} us a sample, {:.2} rays a sample, mean radiance {mean:.4}, stage built in {:.2} s",
        statistics.render_seconds / count * 1e6,
        statistics.counts.rays as f64 / count,
        stage.build_seconds
    );
    Ok(())
}

//! Savings by adaptive sampling: the bench scene with as many samples everywhere, and with as many as are needed.
//!
//! `cargo run --release -p petzval-render --example adaptive -- [pinhole|one|exact] [WIDTH] [REFERENCE SAMPLES] [COUNTS.pgm]`
//!
//! It prints for each render: camera rays a pixel, also those that serve the error alone; and the error to the reference, relative (trimmed
//! relMSE, as `tools/bench/noise.py` has it) and as seen (mean square of the difference of the square roots, values brighter than white
//! cut off), of the whole picture and of the block of 8 x 8 pixels that is worse than 95 in a hundred. COUNTS.pgm is a picture of the last
//! render's counts, its most as white.

#[path = "../../benches/stage/mod.rs"]
mod stage;

use petzval_render::camera::Model;
use petzval_render::job::{Job, Settings};
use std::error::Error;
use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

/// Part of the pixels, the worst ones, that are left out.
const TRIMMED: f64 = 1e-3;
/// Least brightness for relative errors, as a part of the reference's mean.
const FLOOR: f64 = 0.01;
const MOST: u32 = 512;
/// Pixels on a side.
const BLOCK: u32 = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize, otherwise: &str| arguments.get(i).cloned().unwrap_or_else(|| otherwise.to_owned());
    let (model, wavelength_nm) = match word(0, "exact").as_str() {
        "pinhole" => (Model::Pinhole, None),
        "one" => (Model::Lens, Some(587.5618)),
        "exact" => (Model::Lens, None),
        other => return Err(format!("no camera '{other}': pinhole, one or exact").into()),
    };
    let width: u32 = word(1, "240").parse()?;
    let size = [width, width * 9 / 16];
    let reference_samples: u32 = word(2, "1024").parse()?;
    let stage = Arc::new(stage::stage(stage::SMALL));
    let render = |samples: u32, noise_threshold: f32, seed: u32| -> Result<Job, Box<dyn Error>> {
        let camera = stage::camera(model, wavelength_nm, size);
        let job = Job::start(stage.clone(), camera, settings(size, samples, noise_threshold, seed))?;
        while !job.wait(Duration::from_secs(1)) {}
        Ok(job)
    };
    let reference = render(reference_samples, 0.0, 77)?.film().picture();
    println!("threshold  samples (least mean most)  camera rays a pixel    relMSE   as seen  bad blocks");
    let uniform = [16, 32, 64, 128].map(|n| (n, 0.0));
    let adaptive = [0.2, 0.14, 0.1, 0.07].map(|threshold| (MOST, threshold));
    let mut counts = Vec::new();
    for (samples, threshold) in uniform.into_iter().chain(adaptive) {
        let job = render(samples, threshold, 1)?;
        let s = job.statistics();
        let rays = s.counts.camera_rays as f64 / f64::from(size[0] * size[1]);
        let [relative, seen, bad] = errors(&job.film().picture(), &reference, size);
        let row = format!("{:4} {:8.1} {:4}", s.samples, s.mean_samples, s.most_samples);
        println!("{threshold:9.3}  {row:>25}  {rays:19.1}  {relative:.3e} {seen:.3e}   {bad:.3e}");
        counts = job.film().sample_counts();
    }
    if let Some(path) = arguments.get(3) {
        let mut file = std::fs::File::create(path)?;
        writeln!(file, "P5 {} {} 255", size[0], size[1])?;
        let grey = |n: &u32| (f64::from(*n) / f64::from(MOST) * 255.0).round() as u8;
        counts
            .chunks(size[0] as usize)
            .rev()
            .try_for_each(|row| file.write_all(&row.iter().map(grey).collect::<Vec<_>>()))?;
    }
    Ok(())
}

fn settings([width, height]: [u32; 2], samples: u32, noise_threshold: f32, seed: u32) -> Settings {
    Settings { width, height, samples, noise_threshold, seed, max_bounces: 8, ..Settings::default() }
}

/// Relative; as seen; as seen in bad blocks.
fn errors(picture: &[[f32; 4]], reference: &[[f32; 4]], [width, height]: [u32; 2]) -> [f64; 3] {
    let mean =
        reference.iter().flat_map(|p| &p[..3]).map(|&v| f64::from(v)).sum::<f64>() / (3 * reference.len()) as f64;
    let floor = FLOOR * mean;
    let mut relative = Vec::new();
    let mut blocks = vec![0.0; (width.div_ceil(BLOCK) * height.div_ceil(BLOCK)) as usize];
    for (i, (p, r)) in (0..).zip(picture.iter().zip(reference)) {
        let channel = |c: usize| (f64::from(p[c]), f64::from(r[c]));
        relative.push((0..3).map(channel).map(|(p, r)| (p - r).powi(2) / (r * r + floor * floor)).sum::<f64>() / 3.0);
        let root = |v: f64| v.clamp(0.0, 1.0).sqrt();
        let seen = (0..3).map(channel).map(|(p, r)| (root(p) - root(r)).powi(2)).sum::<f64>() / 3.0;
        blocks[(i / width / BLOCK * width.div_ceil(BLOCK) + i % width / BLOCK) as usize] += seen;
    }
    relative.sort_by(f64::total_cmp);
    let kept = (relative.len() as f64 * (1.0 - TRIMMED)) as usize;
    let seen = blocks.iter().sum::<f64>() / reference.len() as f64;
    blocks.sort_by(f64::total_cmp);
    let bad = blocks[blocks.len() * 95 / 100] / f64::from(BLOCK * BLOCK);
    [relative[..kept].iter().sum::<f64>() / kept as f64, seen, bad]
}

//! Renders the bench scene on one thread and prints the cost of a sample: for profilers, and for counting instructions.
//!
//! `cargo run --release -p petzval-render --example path_kernel -- [pinhole|thin|one|exact] [SAMPLES] [WIDTHxHEIGHT]
//! [small|large] [noise] [blue] [lossy]`
//!
//! With `lossy` light is lost at the lens's surfaces and in its glasses. With `noise` it renders twice, with other
//! random numbers, and prints the difference of the two, pixel by pixel and in blocks of 4 x 4; with `blue` the errors
//! of neighbours cancel.

#[path = "../../benches/stage/mod.rs"]
mod stage;

use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::job::{Job, Settings};
use petzval_render::sampler::warp::Filter;
use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

/// The options of a run.
struct Wish {
    model: Model,
    wavelength_nm: Option<f64>,
    samples: u32,
    size: [u32; 2],
    bodies: u32,
    with_noise: bool,
    blue_noise: bool,
    /// True if light is lost at surfaces and in glasses.
    transmission: bool,
}

impl Wish {
    fn new(words: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let (model, wavelength_nm, bodies) = (Model::Pinhole, None, stage::SMALL);
        let mut wish = Self {
            model,
            wavelength_nm,
            samples: 4,
            size: [480, 270],
            bodies,
            with_noise: false,
            blue_noise: false,
            transmission: false,
        };
        for word in words {
            match word.as_str() {
                "pinhole" => wish.model = Model::Pinhole,
                "thin" => wish.model = Model::Thin,
                "one" => (wish.model, wish.wavelength_nm) = (Model::Lens, Some(587.5618)),
                "exact" => wish.model = Model::Lens,
                "small" => wish.bodies = stage::SMALL,
                "large" => wish.bodies = stage::LARGE,
                "noise" => wish.with_noise = true,
                "lossy" => wish.transmission = true,
                "blue" => wish.blue_noise = true,
                other => match other.split_once('x') {
                    Some((width, height)) => wish.size = [width.parse()?, height.parse()?],
                    None => wish.samples = other.parse().map_err(|_| format!("what is '{other}'?"))?,
                },
            }
        }
        Ok(wish)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let Wish { model, wavelength_nm, samples, size, bodies, with_noise, blue_noise, transmission } =
        Wish::new(std::env::args().skip(1))?;
    let stage = Arc::new(stage::stage(bodies));
    let render = |seed: u32| -> Result<_, Box<dyn Error>> {
        let settings = Settings {
            width: size[0],
            height: size[1],
            samples,
            seed,
            blue_noise,
            threads: 1,
            max_bounces: 8,
            filter: Filter::Box,
            ..Settings::default()
        };
        let d = CameraDescription { transmission, ..stage::description(model, wavelength_nm) };
        let job = Job::start(stage.clone(), Camera::new(&d, size[0], size[1])?, settings)?;
        while !job.wait(Duration::from_secs(1)) {}
        Ok((job.statistics(), job.film().picture()))
    };
    let (statistics, picture) = render(1)?;
    let count = f64::from(size[0] * size[1] * samples);
    let mean = picture.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>() / (3 * picture.len()) as f64;
    println!(
        "{:.3} us a sample, {:.2} rays a sample, mean radiance {mean:.4}, stage built in {:.2} s",
        statistics.render_seconds / count * 1e6,
        statistics.counts.rays as f64 / count,
        stage.build_seconds
    );
    if with_noise {
        let (_, other) = render(2)?;
        let noise = relative_error(&picture, &other, mean);
        let [coarse, other] = [&picture, &other].map(|picture| in_blocks(picture, size));
        println!(
            "relMSE {noise:.5}, by samples {:.4}; of blocks of 4 x 4 {:.6}",
            noise * f64::from(samples),
            relative_error(&coarse, &other, mean)
        );
    }
    Ok(())
}

/// Means of blocks of 4 x 4 pixels, as an eye at a distance sees them.
fn in_blocks(picture: &[[f32; 4]], [width, height]: [u32; 2]) -> Vec<[f32; 4]> {
    let [columns, rows] = [width / 4, height / 4];
    let block = |b: u32| {
        let pixel = |i: u32| picture[((b / columns * 4 + i / 4) * width + b % columns * 4 + i % 4) as usize];
        std::array::from_fn(|channel| (0..16).map(|i| pixel(i)[channel]).sum::<f32>() / 16.0)
    };
    (0..columns * rows).map(block).collect()
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

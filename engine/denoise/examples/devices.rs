//! Times the filter on the processor and on a graphics card, and holds both pictures against each other.
//!
//! ```sh
//! cargo run --release -p petzval-denoise --example devices -- LIBRARY [WIDTH HEIGHT]
//! ```
//!
//! The picture is a pattern with noise; how well it is denoised is measured elsewhere. One row for each quality and guide: seconds of the
//! first, second and third run, on the card and on the processor, and the difference of both pictures in the mean, relative to the mean.
//! Then how soon the filter stops when it is told to.

use std::cell::Cell;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

use petzval_denoise::{DenoiseError, Denoiser, Prefilter, Quality, Request};

/// A number below one, from a place in the picture: the finaliser of SplitMix64.
fn random(index: usize) -> f32 {
    let mut x = (index as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 40) as f32 / (1u32 << 24) as f32
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [library, size @ ..] = arguments.as_slice() else { return Err("say where the library lies".into()) };
    let size = size.iter().map(|text| text.parse()).collect::<Result<Vec<usize>, _>>()?;
    let [width, height] = size.try_into().unwrap_or([1500, 1000]);
    let threads = std::thread::available_parallelism()?.get();
    let denoiser = Denoiser::open(Path::new(library))?;
    println!("Open Image Denoise {:?}, {width} x {height} pixels, {threads} threads", denoiser.version());

    let albedo: Vec<f32> = (0..width * height)
        .flat_map(|at| {
            let [x, y] = [at % width, at / width].map(|place| (place / 24) as f32);
            [0.5 + 0.4 * x.sin(), 0.5 + 0.4 * y.cos(), 0.5 + 0.4 * (x + y).sin()]
        })
        .collect();
    let normal = vec![0.577f32; albedo.len()];
    let colour: Vec<f32> = albedo.iter().enumerate().map(|(at, a)| a * -random(at).max(1e-6).ln()).collect();
    let request = |use_gpu, quality, guided: bool| Request {
        width,
        height,
        colour: &colour,
        albedo: guided.then_some(&albedo),
        normal: guided.then_some(&normal),
        prefilter: Prefilter::Accurate,
        quality,
        use_gpu,
        threads,
        memory_mb: Some(2000),
    };
    println!("quality, guides | card, s | processor, s | difference");
    for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
        for guided in [false, true] {
            let mut pictures = Vec::new();
            let mut seconds = Vec::new();
            for use_gpu in [true, false] {
                let mut picture = Vec::new();
                seconds.push(Vec::new());
                for _ in 0..3 {
                    let began = Instant::now();
                    picture = denoiser.denoise(&request(use_gpu, quality, guided), &|_| true)?;
                    seconds.last_mut().into_iter().for_each(|row| row.push(began.elapsed().as_secs_f64()));
                }
                pictures.push(picture);
            }
            let sum: f64 = pictures[1].iter().map(|x| f64::from(x.abs())).sum();
            let apart: f64 = pictures[0].iter().zip(&pictures[1]).map(|(a, b)| f64::from((a - b).abs())).sum();
            println!("{quality:?}, {guided} | {:.3?} | {:.3?} | {:.2e}", seconds[0], seconds[1], apart / sum);
        }
    }
    for use_gpu in [true, false] {
        let (began, told) = (Instant::now(), Cell::new(None));
        let stopped = denoiser.denoise(&request(use_gpu, Quality::High, true), &|part| {
            let go_on = part < 0.4;
            told.set(told.get().or_else(|| (!go_on).then(Instant::now)));
            go_on
        });
        let since = told.get().map_or(f64::NAN, |told| told.elapsed().as_secs_f64());
        let how = if stopped == Err(DenoiseError::Stopped) { "stopped" } else { "not stopped" };
        println!("{how}, card {use_gpu}: after {:.3} s, {since:.3} s since it was told", began.elapsed().as_secs_f64());
    }
    Ok(())
}

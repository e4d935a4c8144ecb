// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays a second through lenses, on a device and on all cores of the processor, as JSON.
//!
//! `cargo run --release --example lens_bench -- [--device gpu|any|NAME] [--lens FILE ...] [--seconds S] [--quick] [--if-any] [--out FILE]`
//!
//! Rays are made on the device from their numbers, and summed up there: nothing is uploaded. The first lens is timed in several cuts;
//! the others in the best of them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use petzval_gpu::device::{DeviceChoice, Gpu, devices};
use petzval_gpu::flood::{Beam, Cut, Flood, Flooded};
use petzval_gpu::lens::LensTable;
use petzval_gpu::number::Number;
use petzval_gpu::shader::Style;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Traced, Tracer, Travel};
use serde_json::{Value, json};

const LENSES: [&str; 3] = ["wide-angle-smith-f3.4", "double-gauss-f2-tronnier", "cellphone-5.6mm-f3.5"];
/// Rays of a bundle on the processor.
const BUNDLE: usize = 4096;

struct Options {
    device: DeviceChoice,
    lenses: Vec<PathBuf>,
    seconds: f64,
    is_quick: bool,
    if_any: bool,
    out: Option<PathBuf>,
}

fn options() -> Result<Options, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
    let mut found = Options {
        device: DeviceChoice::Any,
        lenses: Vec::new(),
        seconds: 0.3,
        is_quick: false,
        if_any: false,
        out: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--device" => found.device = value()?.parse().unwrap_or(DeviceChoice::Any),
            "--lens" => found.lenses.push(value()?.into()),
            "--seconds" => found.seconds = value()?.parse().map_err(|_| "--seconds needs a number".to_owned())?,
            "--quick" => found.is_quick = true,
            "--if-any" => found.if_any = true,
            "--out" => found.out = Some(value()?.into()),
            _ => return Err(format!("unknown option {word}")),
        }
    }
    if found.lenses.is_empty() {
        found.lenses = LENSES.map(|name| folder.join(format!("{name}.lens"))).into();
    }
    Ok(found)
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// The subject of a timing: a lens and its rays.
struct Subject {
    name: String,
    system: System,
    tracer: Tracer,
    beam: Beam,
}

impl Subject {
    fn read(path: &Path) -> Result<Self, String> {
        let prescription = lens::read(path, Catalogue::shipped()).map_err(|error| error.to_string())?;
        let system = System::new(&prescription, &LensSettings::default()).map_err(|error| error.to_string())?;
        let tracer = system.at_wavelength(line_nm::D);
        let beam = Beam::fitted(&system, &tracer);
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self { name, system, tracer, beam })
    }

    /// Rays of the beam, and the number of those that pass.
    fn rays(&self, count: u32) -> (Vec<Ray>, usize) {
        let z = self.system.last_vertex_z_mm();
        let rays: Vec<Ray> = (0..count).map(|i| self.beam.ray(i, z)).collect();
        let passed = rays.iter().filter(|ray| self.tracer.from_film(**ray).is_ok()).count();
        (rays, passed)
    }
}

/// The time of a lens in one cut: the median of some runs of about `seconds` each.
fn on_device<N: Number>(
    gpu: &Gpu,
    subject: &Subject,
    style: Style,
    cut: Cut,
    options: &Options,
) -> Result<(f64, Value), String> {
    let table = LensTable::new(&subject.system, &[line_nm::D], Travel::FromFilm).map_err(|error| error.to_string())?;
    let began = Instant::now();
    let text = |error: petzval_gpu::error::GpuError| error.to_string();
    let one = Flood::<N>::new(gpu, &table, style, Cut { dispatches: 1, ..cut }, &subject.beam).map_err(text)?;
    // The first run compiles what is left to compile.
    let first: Flooded = one.run().map_err(text)?;
    let compiled_s = began.elapsed().as_secs_f64() - first.wall_s;
    let second = one.run().map_err(text)?;
    let dispatches = (options.seconds / second.wall_s).clamp(1.0, 200.0) as u32;
    let many = Flood::<N>::new(gpu, &table, style, Cut { dispatches, ..cut }, &subject.beam).map_err(text)?;
    let repeats = if options.is_quick { 2 } else { 5 };
    let runs: Vec<Flooded> = (0..repeats).map(|_| many.run()).collect::<Result<_, _>>().map_err(text)?;
    let rays = runs[0].rays as f64;
    let rate = rays / median(runs.iter().map(|run| run.wall_s).collect());
    let clocks: Option<Vec<f64>> = runs.iter().map(|run| run.device_s).collect();
    let report = json!({
        "number": N::NAME,
        "shader": format!("{style:?}").to_lowercase(),
        "group": cut.group,
        "rays_each": cut.rays_each,
        "groups": cut.groups,
        "dispatches": dispatches,
        "runs": repeats,
        "rays_a_run": runs[0].rays,
        "grays_s": rate * 1e-9,
        "grays_s_of_runs": runs.iter().map(|run| rays / run.wall_s * 1e-9).collect::<Vec<_>>(),
        "grays_s_by_device_clock": clocks.map(|times| rays / median(times) * 1e-9),
        "passed": runs[0].passed as f64 / rays,
        "first_run_s": compiled_s,
    });
    Ok((rate, report))
}

/// Rays a second of the processor's tracer on all cores, with their filling into bundles.
fn on_processor<R: Traced>(subject: &Subject, rays: &[Ray], seconds: f64) -> f64 {
    let tracer: Tracer<R> = subject.tracer.cast();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut filled = tracer.bundle(Travel::FromFilm);
    rays.iter().take(BUNDLE).for_each(|ray| filled.push(*ray));
    let work = || {
        let start = Instant::now();
        let mut bundle = filled.clone();
        let (mut count, mut passed) = (0usize, 0usize);
        while start.elapsed().as_secs_f64() < seconds {
            bundle.clone_from(&filled);
            tracer.trace(&mut bundle);
            passed += bundle.passed();
            count += bundle.len();
        }
        (count as f64 / start.elapsed().as_secs_f64(), std::hint::black_box(passed)).0
    };
    let once = || -> f64 {
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap_or(0.0)).sum()
        })
    };
    median((0..3).map(|_| once()).collect())
}

fn bench(gpu: &Gpu, options: &Options) -> Result<Value, String> {
    let (cuts, small) = cuts(gpu, options);
    let mut best = cuts[0];
    let mut lenses = Vec::new();
    for (i, path) in options.lenses.iter().enumerate() {
        let subject = Subject::read(path)?;
        let (rays, passed) = subject.rays(20_000);
        let mut timed = Vec::new();
        if i == 0 {
            let mut fastest = 0.0;
            for cut in &cuts {
                let (rate, report) = on_device::<f32>(gpu, &subject, Style::Written, *cut, options)?;
                eprintln!("{}: {cut:?}: {:.3} G rays/s", subject.name, rate * 1e-9);
                timed.push(report);
                if rate > fastest {
                    (fastest, best) = (rate, *cut);
                }
            }
        } else {
            timed.push(on_device::<f32>(gpu, &subject, Style::Written, best, options)?.1);
        }
        timed.push(on_device::<f32>(gpu, &subject, Style::Loaded, best, options)?.1);
        if gpu.has::<f64>() {
            for style in [Style::Written, Style::Loaded] {
                let cut = Cut { groups: best.groups.div_ceil(4), ..best };
                timed.push(on_device::<f64>(gpu, &subject, style, cut, options)?.1);
            }
        }
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let seconds = if options.is_quick { 0.2 } else { 0.5 };
        let cpu = [on_processor::<f32>(&subject, &rays, seconds), on_processor::<f64>(&subject, &rays, seconds)];
        eprintln!("{}: done", subject.name);
        lenses.push(json!({
            "lens": subject.name,
            "surfaces": subject.system.surface_count(),
            "half_film_mm": subject.beam.half_film_mm,
            "half_pupil_mm": subject.beam.half_pupil_mm,
            "passed_on_cpu": passed as f64 / rays.len() as f64,
            "device": timed,
            "cpu": {"cores": cores, "grays_s_f32": cpu[0] * 1e-9, "grays_s_f64": cpu[1] * 1e-9},
        }));
    }
    let days = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |time| time.as_secs());
    Ok(json!({
        "device": gpu.info().name,
        "kind": format!("{:?}", gpu.info().kind),
        "driver": gpu.info().driver,
        "wavelength_nm": line_nm::D,
        "unix_time_s": days,
        "command": std::env::args().enumerate().map(|(i, word)| match i {
            0 => Path::new(&word).file_name().map_or(word.clone(), |name| name.to_string_lossy().into_owned()),
            _ => word,
        }).collect::<Vec<_>>().join(" "),
        "is_small": small,
        "lenses": lenses,
    }))
}

/// The cuts that the first lens is timed in; of a software driver one small one.
fn cuts(gpu: &Gpu, options: &Options) -> (Vec<Cut>, bool) {
    let cut = |group, rays_each, groups| Cut { group, rays_each, groups, dispatches: 1 };
    if gpu.info().kind == petzval_gpu::device::DeviceKind::Software {
        let groups = if options.is_quick { 64 } else { 256 };
        return (vec![cut(64, 16, groups), cut(128, 8, groups)], true);
    }
    let mut cuts = Vec::new();
    for group in [64, 128, 256] {
        for rays_each in [4, 16, 64] {
            cuts.push(cut(group, rays_each, (1 << 27) / (group * rays_each)).clamped());
        }
    }
    (cuts, false)
}

trait Clamped {
    fn clamped(self) -> Self;
}

impl Clamped for Cut {
    fn clamped(self) -> Self {
        Self { groups: self.groups.min(65_535), ..self }
    }
}

fn run() -> Result<(), String> {
    let options = options()?;
    let gpu = match Gpu::open(&options.device) {
        Ok(Some(gpu)) => gpu,
        Ok(None) => return Err("cpu has no device to time; choose gpu, any or a name".to_owned()),
        Err(error) if options.if_any => {
            println!("not timed: {error}");
            return Ok(());
        }
        Err(error) => return Err(error.to_string()),
    };
    for device in devices() {
        eprintln!("there is: {} ({:?}, {})", device.name, device.kind, device.driver);
    }
    let report = serde_json::to_string_pretty(&bench(&gpu, &options)?).map_err(|error| error.to_string())?;
    println!("{report}");
    if let Some(out) = options.out {
        std::fs::write(&out, report).map_err(|error| format!("{}: {error}", out.display()))?;
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lens_bench: {error}");
            ExitCode::FAILURE
        }
    }
}

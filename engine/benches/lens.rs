//! Time of a ray and surface, by lens and by kind of lane.
//!
//! `cargo bench -p petzval-benches --bench lens`; `make speed` writes the table of docs/lens-speed.md from it.

use std::hint::black_box;
use std::path::Path;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use petzval_optics::focus::{FilmPlane, film_z_for_focus_mm};
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::lane::{Lane, LaneKernel, Level, Real};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Traced, Tracer, Travel};

/// Kind of lens and its file in `lenses/`.
const LENSES: [(&str, &str); 5] = [
    ("wide angle (figure 3)", "wide-angle-smith-f3.4"),
    ("double Gauss", "double-gauss-f2-tronnier"),
    ("fisheye", "laikin-fisheye-170"),
    ("aspheres", "cellphone-5.6mm-f3.5"),
    ("mirrors", "cassegrain-f12"),
];
/// Enough rays that filling and emptying registers does not count, few enough for the nearest cache but one.
const RAYS: u32 = 4096;

/// Rays from all over the film that get through.
fn rays(system: &System, tracer: &Tracer) -> Vec<Ray> {
    let film_z = film_z_for_focus_mm(system, line_nm::D, f64::INFINITY).expect("the lens focuses");
    let film = FilmPlane::upright(film_z);
    let efl = Paraxial::new(system, line_nm::D).efl_mm.map_or(50.0, f64::abs);
    let radius = efl * system.half_field_deg().unwrap_or(20.0).min(40.0).to_radians().tan();
    let map = PupilMap::new(tracer, system, &film, radius * 0.8, radius * 0.6);
    let at = |i: u32, by: u32| f64::from(i * by % 10_007) / 10_007.0;
    let aimed = |i: u32| {
        let origin = film.point(radius * 0.6 * (2.0 * at(i, 7919) - 1.0), radius * 0.5 * (2.0 * at(i, 6007) - 1.0));
        let target: DVec3 = map.sample(origin, [at(i, 4001), at(i, 5003)]).target;
        Ray { origin, direction: (target - origin).normalize() }
    };
    (0..).map(aimed).filter(|&ray| tracer.from_film(ray).is_ok()).take(RAYS as usize).collect()
}

fn levels() -> Vec<(&'static str, Level)> {
    let mut levels = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        let best = Level::new();
        levels.extend(best.as_sse2().map(|token| ("SSE2", Level::Sse2(token))));
        levels.extend(best.as_avx2().map(|token| ("AVX2", Level::Avx2(token))));
        levels.extend(best.as_avx512().map(|token| ("AVX-512", Level::Avx512(token))));
    }
    if levels.is_empty() {
        levels.push(("best", Level::new()));
    }
    levels
}

fn bench_kind<R: Traced>(c: &mut Criterion, lens: &str, kind: &str, tracer: &Tracer, rays: &[Ray]) {
    let mut group = c.benchmark_group(lens);
    group.throughput(Throughput::Elements((rays.len() * tracer.surface_count()) as u64));
    let tracer: Tracer<R> = tracer.cast();
    group.bench_function(BenchmarkId::new(kind, "one"), |b| {
        b.iter(|| rays.iter().filter_map(|&ray| tracer.from_film(ray).ok()).map(|ray| ray.direction.z).sum::<f64>());
    });
    let mut filled = tracer.bundle(Travel::FromFilm);
    rays.iter().for_each(|&ray| filled.push(ray));
    for (name, level) in levels() {
        let mut bundle = filled.clone();
        group.bench_function(BenchmarkId::new(kind, name), |b| {
            b.iter(|| {
                bundle.clone_from(&filled);
                tracer.trace_with(level, &mut bundle);
                bundle.passed()
            });
        });
    }
    group.finish();
}

/// Two roots and two divisions of each number, which depend on nothing else: the least operations to trace a sphere.
struct RootsAndDivisions<'a, R>(&'a mut [R]);

impl<R: Real> LaneKernel<R> for RootsAndDivisions<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane<Real = R>>(self, zero: L) {
        let one = zero + R::ONE;
        for numbers in self.0.chunks_exact_mut(L::WIDTH) {
            let x = zero.load(numbers);
            let y = x + R::ONE;
            (x.sqrt() + y.sqrt() + one / x + one / y).store(numbers);
        }
    }
}

fn bench_limit<R: Real>(c: &mut Criterion, kind: &str) {
    let mut group = c.benchmark_group("two roots and two divisions");
    group.throughput(Throughput::Elements(u64::from(RAYS)));
    for (name, level) in levels() {
        let mut numbers = vec![R::ONE; RAYS as usize];
        group.bench_function(BenchmarkId::new(kind, name), |b| {
            b.iter(|| R::run_wide(level, RootsAndDivisions(black_box(&mut numbers))));
        });
    }
    group.finish();
}

fn limit(c: &mut Criterion) {
    bench_limit::<f64>(c, "f64");
    bench_limit::<f32>(c, "f32");
}

fn lenses(c: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
    for (kind, file) in LENSES {
        let path = folder.join(format!("{file}.lens"));
        let prescription = lens::read(&path, Catalogue::shipped()).unwrap_or_else(|error| panic!("{error}"));
        let system = System::new(&prescription, &LensSettings::default()).expect("the lens is shipped");
        let tracer = system.at_wavelength(line_nm::D);
        let rays = rays(&system, &tracer);
        bench_kind::<f64>(c, kind, "f64", &tracer, &rays);
        bench_kind::<f32>(c, kind, "f32", &tracer, &rays);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30);
    targets = limit, lenses
}
criterion_main!(benches);

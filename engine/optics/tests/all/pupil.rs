//! The pupil map: nothing lost, nothing counted twice, few rays wasted.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::OnceLock;

use crate::common::{prescription, system};
use glam::DVec3;
use petzval_optics::diaphragm::ApertureMask;
use petzval_optics::focus::{FilmPlane, film_z_for_focus_mm};
use petzval_optics::formats::lens::parse;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::pupil_map::{PupilMap, on_axis_throughput, unobstructed_part};
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};

struct Camera {
    name: String,
    system: System,
    tracer: Tracer,
    film: FilmPlane,
    half: [f64; 2],
    map: PupilMap,
}

impl Camera {
    fn new(name: &str, system: System, film: impl Fn(f64) -> FilmPlane, half: [f64; 2]) -> Self {
        let tracer = system.at_wavelength(line_nm::D);
        let film = film(film_z_for_focus_mm(&system, line_nm::D, f64::INFINITY).unwrap());
        let map = PupilMap::new(&tracer, &system, &film, half[0], half[1]);
        Self { name: name.to_owned(), system, tracer, film, half, map }
    }

    /// cos θ cos θ′ / d² where the ray passes, else 0.
    fn contribution(&self, point: DVec3, target: DVec3) -> f64 {
        let towards = target - point;
        let squared = towards.length_squared();
        let direction = towards / squared.sqrt();
        let passed = self.tracer.from_film(Ray { origin: point, direction }).is_ok();
        let cosines = (direction.dot(self.film.normal()) * direction.z).abs();
        if passed { cosines / squared } else { 0.0 }
    }

    /// The integral of the contribution from the map's samples, and its standard error.
    fn by_map(&self, point: DVec3) -> (f64, f64) {
        let n = 400;
        let mut sums = [0.0; 2];
        for u in points(n) {
            let sample = self.map.sample(point, u);
            let x = self.contribution(point, sample.target) / sample.pdf_per_mm2;
            sums[0] += x;
            sums[1] += x * x;
        }
        let count = f64::from(n * n);
        let mean = sums[0] / count;
        (mean, ((sums[1] / count - mean * mean).max(0.0) / count).sqrt())
    }

    /// The integral of the contribution and its standard error, by even samples of everything that a ray to the rear glass can cross.
    fn by_brute_force(&self, point: DVec3, n: u32) -> (f64, f64) {
        let radius = 1.02 * self.map.glass_radius_mm();
        let mut sums = [0.0; 2];
        for [u, v] in points(n) {
            let target = DVec3::new(radius * (2.0 * u - 1.0), radius * (2.0 * v - 1.0), self.map.reference_plane_z());
            let x = self.contribution(point, target) * 4.0 * radius * radius;
            sums[0] += x;
            sums[1] += x * x;
        }
        let count = f64::from(n * n);
        let mean = sums[0] / count;
        (mean, ((sums[1] / count - mean * mean).max(0.0) / count).sqrt())
    }

    fn pass_rate(&self, point: DVec3) -> f64 {
        let n = 200;
        let passed = points(n).filter(|&u| self.contribution(point, self.map.sample(point, u).target) > 0.0).count();
        passed as f64 / f64::from(n * n)
    }
}

/// n² points, one in each cell of a grid, placed in it by a hash of the run's seed.
fn points(n: u32) -> impl Iterator<Item = [f64; 2]> {
    let random = |seed: u32| {
        let run = petzval_testkit::sampling::seed();
        let mut x =
            u64::from(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5DEE_CE66 ^ run.wrapping_mul(0xD6E8_FEB8_6659_FD93);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n * n).map(move |i| {
        let place = |cell: u32, seed: u32| (f64::from(cell) + random(seed)) / f64::from(n);
        [place(i / n, 2 * i), place(i % n, 2 * i + 1)]
    })
}

fn cameras() -> &'static [Camera] {
    static CAMERAS: OnceLock<Vec<Camera>> = OnceLock::new();
    CAMERAS.get_or_init(make_cameras)
}

fn make_cameras() -> Vec<Camera> {
    let stopped = |name: &str, f_number: f64, blades: u32| {
        let settings = LensSettings { f_number: Some(f_number), blades, blade_rotation_rad: 0.2, ..Default::default() };
        System::new(&prescription(name), &settings).unwrap()
    };
    let turned = |z| FilmPlane { tilt_rad: 0.15, swing_rad: -0.1, shift_mm: [2.0, -1.0], ..FilmPlane::upright(z) };
    // A mirror lens with an obstruction by the secondary.
    let text = "#radius thickness glass diameter conic isstop obstruction\n\
                -2000 -700 mirror 250 -1 1 90\n-900 900 mirror 85 -4 0 0";
    let obstructed = parse(text, "obstructed", Catalogue::shipped()).unwrap();
    let obstructed = System::new(&obstructed, &LensSettings::default()).unwrap();
    let shipped = |name: &str, blades: u32, more: &str| {
        let text = std::fs::read_to_string(crate::common::repository("lenses").join(format!("{name}.lens"))).unwrap();
        let lens = parse(&format!("{more}\n{text}"), name, Catalogue::shipped()).unwrap();
        let settings = LensSettings { f_number: Some(4.0), blades, ..Default::default() };
        System::new(&lens, &settings).unwrap()
    };
    let anamorphic = shipped("anamorphic-2x-double-gauss", 0, "");
    let six_blades = shipped("anamorphic-2x-double-gauss", 6, "");
    let curved = LensSettings { blades: 5, blade_curvature: 0.6, f_number: Some(4.0), ..Default::default() };
    let curved = System::new(&prescription("double-gauss-f2-available"), &curved).unwrap();
    let misaligned = shipped("double-gauss-f2-available", 0, "# element: 0-1 decenter_x=3 tilt_x=-4 tilt_y=6");
    vec![
        Camera::new("anamorphic", anamorphic, FilmPlane::upright, [11.0, 9.0]),
        Camera::new("anamorphic, six blades", six_blades, turned, [11.0, 9.0]),
        Camera::new("misaligned", misaligned, FilmPlane::upright, [18.0, 12.0]),
        Camera::new("wide angle", system("seed-wide-angle"), FilmPlane::upright, [40.0, 40.0]),
        Camera::new("double Gauss", system("double-gauss-f2-available"), FilmPlane::upright, [18.0, 12.0]),
        Camera::new("Cassegrain", system("cassegrain-f12"), FilmPlane::upright, [12.0, 12.0]),
        Camera::new("obstructed", obstructed, FilmPlane::upright, [12.0, 12.0]),
        Camera::new("Newtonian", system("newtonian-f5"), FilmPlane::upright, [8.0, 8.0]),
        Camera::new("turned", system("double-gauss-f2-available"), turned, [18.0, 12.0]),
        Camera::new("six blades", stopped("tessar-brendel", 5.6, 6), FilmPlane::upright, [18.0, 12.0]),
        Camera::new("turned blades", stopped("double-gauss-f2-available", 4.0, 5), turned, [18.0, 12.0]),
        Camera::new("curved blades", curved, FilmPlane::upright, [18.0, 12.0]),
        Camera::new("fisheye", system("pbrt-fisheye-10mm"), FilmPlane::upright, [10.0, 7.0]),
    ]
}

#[test]
fn the_map_is_unbiased() {
    let brute_side = if petzval_testkit::is_thorough() { 1000 } else { 700 };
    for camera in cameras() {
        // The middle of an even film has a test of its own, `throughput_on_axis_is_that_of_brute_force`.
        let is_in_all = camera.film.is_uneven() || petzval_testkit::is_thorough();
        for &(u, v) in &[(0.0, 0.0), (0.6, -0.3), (-1.0, 1.0)][usize::from(!is_in_all)..] {
            let point = camera.film.point(u * camera.half[0], v * camera.half[1]);
            let (map, map_error) = camera.by_map(point);
            let (brute, brute_error) = camera.by_brute_force(point, brute_side);
            // Both errors are those of unstratified points and so larger than the true ones.
            let allowed = 3.0 * map_error.hypot(brute_error);
            assert!((map - brute).abs() <= allowed, "{} ({u}, {v}): {map} {brute} ± {allowed}", camera.name);
        }
    }
}

#[test]
fn few_rays_are_lost() {
    for camera in cameras() {
        // Of them the defensive samples take 0.5 %, the margin about the outline 0.6 %; a film that is turned behind blades
        // has the coarsest cells.
        let least = if camera.name == "turned blades" { 0.955 } else { 0.975 };
        for (u, v) in [(0.0, 0.0), (0.5, 0.3), (0.9, -0.8)] {
            let point = camera.film.point(u * camera.half[0], v * camera.half[1]);
            let rate = camera.pass_rate(point);
            println!("{} ({u}, {v}): {:.1} %", camera.name, 100.0 * rate);
            assert!(rate > least, "{} ({u}, {v}): {rate}", camera.name);
        }
    }
}

/// Targets of samples follow the density that is said of them.
#[test]
fn targets_follow_their_density() {
    for camera in cameras() {
        let point = camera.film.point(0.5 * camera.half[0], 0.4 * camera.half[1]);
        // The outline's margin may reach past the glass.
        let radius = 1.03 * camera.map.glass_radius_mm();
        let at = |[x, y]: [f64; 2]| DVec3::new(x, y, camera.map.reference_plane_z());
        petzval_testkit::sampling::places(
            &format!("pupil map of {}", camera.name),
            1 << 16,
            [[-radius, radius]; 2],
            |random| {
                let target = camera.map.sample(point, [random.number(), random.number()]).target;
                Some([target.x as f32, target.y as f32])
            },
            |place| camera.map.pdf(point, at(place.map(f64::from))),
        );
    }
}

/// A hunt over the whole film and the whole rear glass: of a hundred thousand rays that get through, not one is outside.
#[test]
fn light_outside_of_the_outline_is_rare() {
    let film_side = if petzval_testkit::is_thorough() { 7 } else { 4 };
    for camera in cameras() {
        let mut inside = 0.0;
        let mut outside = 0.0;
        for [u, v] in points(film_side) {
            let point = camera.film.point((2.0 * u - 1.0) * camera.half[0], (2.0 * v - 1.0) * camera.half[1]);
            // In the outline the density is nearly 1 / area; outside, a hundredth of 1 / glass.
            let glass = PI * camera.map.glass_radius_mm().powi(2);
            for [a, b] in points(250) {
                let r = camera.map.glass_radius_mm();
                let target = DVec3::new(r * (2.0 * a - 1.0), r * (2.0 * b - 1.0), camera.map.reference_plane_z());
                let x = camera.contribution(point, target);
                let is_inside = camera.map.pdf(point, target) > 0.1 / glass;
                *(if is_inside { &mut inside } else { &mut outside }) += x;
            }
        }
        let part = outside / (inside + outside);
        println!("{}: {part:e}", camera.name);
        assert!(part < 1e-5, "{}: {part:e} of the light", camera.name);
    }
}

#[test]
fn the_density_sums_to_one_and_is_that_of_the_samples() {
    for camera in cameras() {
        for (u, v) in [(0.0, 0.0), (0.5, 0.4), (1.0, -1.0)] {
            let point = camera.film.point(u * camera.half[0], v * camera.half[1]);
            // The outline's margin may reach past the glass.
            let radius = 1.03 * camera.map.glass_radius_mm();
            let n = 1000;
            let sum: f64 = points(n)
                .map(|[a, b]| {
                    let x = DVec3::new(radius * (2.0 * a - 1.0), radius * (2.0 * b - 1.0), 0.0);
                    camera.map.pdf(point, x)
                })
                .sum();
            let total = sum * 4.0 * radius * radius / f64::from(n * n);
            // An outline of area A on a grid of cells a errs by about the cells on its rim.
            let area = camera.map.pupil_area_mm2(point);
            let cell = 4.0 * radius * radius / f64::from(n * n);
            let allowed = 1e-3 + 4.0 * (cell / area).sqrt() * (cell / area).powf(0.25);
            assert!((total - 1.0).abs() < allowed, "{} ({u}, {v}): {total} ± {allowed}", camera.name);
            // 1/pdf of the samples sums to the area that they cover: the outline's and, by the rest, the glass.
            for u in points(60) {
                let sample = camera.map.sample(point, u);
                assert!(sample.pdf_per_mm2 > 0.0 && sample.target.z == camera.map.reference_plane_z());
                assert_eq!(sample.pdf_per_mm2, camera.map.pdf(point, sample.target));
            }
        }
    }
}

/// Chi-square of the samples against the density over a grid of bins.
#[test]
fn samples_follow_the_density() {
    for camera in cameras() {
        let point = camera.film.point(0.7 * camera.half[0], 0.5 * camera.half[1]);
        // Bins over the outline's neighbourhood: the box of the samples that lie in it.
        let n = 300;
        let all: Vec<DVec3> = points(n).map(|u| camera.map.sample(point, u).target).collect();
        let dense = |p: &&DVec3| camera.map.pdf(point, **p) > 0.5 / camera.map.pupil_area_mm2(point);
        let low = all.iter().filter(dense).fold(DVec3::INFINITY, |m, p| m.min(*p));
        let high = all.iter().filter(dense).fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
        const BINS: usize = 12;
        let size = (high - low) / BINS as f64;
        let bin = |p: DVec3| {
            let at = (p - low) / size;
            let is_in = |x: f64| (0.0..BINS as f64).contains(&x);
            (is_in(at.x) && is_in(at.y)).then(|| at.y as usize * BINS + at.x as usize)
        };
        let mut counted = [0.0; BINS * BINS];
        all.iter().filter_map(|&p| bin(p)).for_each(|i| counted[i] += 1.0);
        let mut expected = [0.0; BINS * BINS];
        for [a, b] in points(900) {
            let p = low + (high - low) * DVec3::new(a, b, 0.0);
            if let Some(i) = bin(p) {
                let area = (high.x - low.x) * (high.y - low.y);
                expected[i] += camera.map.pdf(point, p) * area / (900.0 * 900.0) * f64::from(n * n);
            }
        }
        let (mut chi, mut bins) = (0.0, 0.0);
        for (c, e) in counted.iter().zip(expected).filter(|(_, e)| *e > 10.0) {
            chi += (c - e) * (c - e) / e;
            bins += 1.0;
        }
        // Mean `bins`, variance 2 `bins`; stratified points stay below.
        assert!(chi < bins + 4.0 * (2.0f64 * bins).sqrt(), "{}: {chi} of {bins}", camera.name);
    }
}

#[test]
fn throughput_on_axis_is_that_of_brute_force() {
    for camera in cameras().iter().filter(|c| !c.film.is_uneven()) {
        let exact = on_axis_throughput(&camera.tracer, &camera.system, camera.film.z_mm);
        let centre = DVec3::new(0.0, 0.0, camera.film.z_mm);
        let (map, error) = camera.by_map(centre);
        assert!((map / exact - 1.0).abs() < 4e-4, "{}: {exact} {map} ± {error}", camera.name);
        let (brute, error) = camera.by_brute_force(centre, 1000);
        assert!((brute - exact).abs() < 3.0 * error, "{}: {exact} {brute} ± {error}", camera.name);
    }
}

#[test]
fn a_dark_corner_is_dark_and_harmless() {
    let camera = Camera::new("dark", system("kreitzer-tele"), FilmPlane::upright, [100.0, 100.0]);
    let point = camera.film.point(100.0, 100.0);
    assert_eq!(camera.map.pupil_area_mm2(point), 0.0);
    for u in points(30) {
        let sample = camera.map.sample(point, u);
        assert!(sample.pdf_per_mm2 > 0.0 && sample.target.is_finite());
    }
}

/// A thin lens's own case: the stop is the last surface and plane, so the integral over a polygon is known.
#[test]
fn throughput_of_a_polygon_is_exact() {
    let lens = parse("0 50 air 40 0 1", "hole", Catalogue::shipped()).unwrap();
    for (blades, curvature) in [(3, 0.0), (4, 0.0), (7, 0.0), (3, 0.5), (6, 0.9)] {
        let settings =
            LensSettings { blades, blade_curvature: curvature, blade_rotation_rad: 0.3, ..Default::default() };
        let system = System::new(&lens, &settings).unwrap();
        let found = on_axis_throughput(&system.at_wavelength(550.0), &system, 50.0);
        // With r(φ) from the middle of a side, π mean of r² / (r² + d²), by the midpoint rule. A straight side lies at
        // a / cos φ; an arc of the radius s about the point c towards the side at c cos φ + √(s² − c² sin² φ).
        let (a, d, n) = (20.0 * (PI / f64::from(blades)).cos(), 50.0, 20_000);
        let s = 20.0 / curvature;
        let c = a - (s * s - (20.0 * (PI / f64::from(blades)).sin()).powi(2)).sqrt();
        let term = |i: i32| {
            let (sin, cos) = ((f64::from(i) + 0.5) / f64::from(n) * PI / f64::from(blades)).sin_cos();
            let r = if curvature > 0.0 { c * cos + (s * s - c * c * sin * sin).sqrt() } else { a / cos };
            r * r / (r * r + d * d)
        };
        let expected = PI * (0..n).map(term).sum::<f64>() / f64::from(n);
        assert!((found / expected - 1.0).abs() < 1e-6, "{blades} {curvature}: {found} {expected}");
    }
}

/// A hole half as wide as the opening that is its own pupil: of r² / (r² + d²), the part inside.
#[test]
fn an_obstruction_takes_its_part() {
    let part = |radius: f64| radius * radius / (radius * radius + 50.0 * 50.0);
    let text = "#radius thickness glass diameter conic isstop obstruction\n0 50 air 40 0 1 20";
    let settings = LensSettings::default();
    let system = System::new(&parse(text, "ring", Catalogue::shipped()).unwrap(), &settings).unwrap();
    let found = unobstructed_part(&system.at_wavelength(550.0), &system, 50.0);
    assert!((found - (1.0 - part(10.0) / part(20.0))).abs() < 1e-9, "{found}");
    let system = System::new(&parse("0 50 air 40 0 1", "hole", Catalogue::shipped()).unwrap(), &settings).unwrap();
    assert_eq!(unobstructed_part(&system.at_wavelength(550.0), &system, 50.0), 1.0);
}

/// A mask that is dark in its middle, off centre and turned: the map bounds it and stays unbiased.
#[test]
fn a_mask_is_bounded_and_exposes_as_much_as_by_brute_force() {
    let side = 64;
    let ring = |i: usize| {
        let at = |i: usize| (2.0 * i as f64 + 1.0) / f64::from(side) - 1.0;
        let out = (at(i % 64) - 0.2).hypot(at(i / 64));
        (1.0 - 2.0 * (out - 0.5).abs()).clamp(0.0, 1.0) as f32
    };
    let values: Vec<f32> = (0..64 * 64).map(ring).collect();
    let mask = Arc::new(ApertureMask::new(64, &values).unwrap());
    let masked = |film: fn(f64) -> FilmPlane| {
        let system = system("double-gauss-f2-available").with_aperture_mask(mask.clone(), 0.4).unwrap();
        Camera::new("masked", system, film, [18.0, 12.0])
    };
    let turned = |z| FilmPlane { tilt_rad: 0.15, swing_rad: -0.1, shift_mm: [2.0, -1.0], ..FilmPlane::upright(z) };
    for camera in [masked(FilmPlane::upright), masked(turned)] {
        for (u, v) in [(0.0, 0.0), (0.6, -0.3), (-1.0, 1.0)] {
            let point = camera.film.point(u * camera.half[0], v * camera.half[1]);
            let (map, map_error) = camera.by_map(point);
            let (brute, brute_error) = camera.by_brute_force(point, 1000);
            // Both errors are those of unstratified points and so larger than the true ones.
            let allowed = 3.0 * map_error.hypot(brute_error);
            assert!((map - brute).abs() <= allowed, "({u}, {v}): {map} {brute} ± {allowed}");
        }
    }
    let camera = masked(FilmPlane::upright);
    let exact = on_axis_throughput(&camera.tracer, &camera.system, camera.film.z_mm);
    let (brute, error) = camera.by_brute_force(DVec3::new(0.0, 0.0, camera.film.z_mm), 1000);
    assert!((brute - exact).abs() < 3.0 * error, "{exact} {brute} ± {error}");
    // A ring of 0.25 to 0.75 of the stop's radius, cut off nowhere: half of its area.
    let part = camera.system.diaphragm().area_mm2() / (PI * camera.system.stop_semi_diameter_mm().powi(2));
    assert!((part - 0.5).abs() < 2e-3, "{part}");
}

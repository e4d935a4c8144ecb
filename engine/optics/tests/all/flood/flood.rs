//! Sends random rays, most of them hopeless, through every shipped lens both ways, and looks for one that does not end
//! as it should: finite, of unit length, or lost for a named reason.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Bundle, Ray, Traced, Tracer, Travel};

/// Rays in a bundle.
const BUNDLE: u64 = 4096;

/// Small, fast and good enough for rays (Steele, Lea and Flood 2014, splitmix64).
struct Dice(u64);

impl Dice {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    }

    /// A number from −1 to 1.
    fn even(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.even(), self.even(), self.even());
            if (1e-6..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// 10 to a power from −`powers` to `powers`.
    fn magnitude(&mut self, powers: f64) -> f64 {
        (self.even() * powers * std::f64::consts::LN_10).exp()
    }
}

/// A ray of one of five kinds: aimed at the glass from a usual distance, from anywhere between a nanometre and ten
/// kilometres, from any place in any direction, along the axis, from far beyond all sense.
fn ray(dice: &mut Dice, semi: f64, towards: f64, vertex: f64) -> Ray {
    let across = |dice: &mut Dice| DVec3::new(dice.even() * semi, dice.even() * semi, 0.0);
    let glass = across(dice) * 1.1 + DVec3::new(0.0, 0.0, vertex);
    let from = |dice: &mut Dice, distance: f64| {
        let aside = dice.direction() * DVec3::new(0.7, 0.7, 0.0) * dice.even();
        glass + (aside - DVec3::Z * towards).normalize() * distance
    };
    let origin = match dice.bits() % 8 {
        0..4 => {
            let distance = 3.0 * semi * dice.magnitude(1.0);
            from(dice, distance)
        }
        4 => {
            let distance = dice.magnitude(8.0);
            from(dice, distance)
        }
        5 => dice.direction() * semi * dice.magnitude(2.0),
        6 => {
            let origin = if dice.bits().is_multiple_of(2) { across(dice) } else { DVec3::ZERO };
            return Ray {
                origin: origin + DVec3::new(0.0, 0.0, vertex - towards * semi),
                direction: DVec3::Z * towards,
            };
        }
        _ => dice.direction() * dice.magnitude(300.0),
    };
    let direction =
        if dice.bits().is_multiple_of(8) { Some(dice.direction()) } else { (glass - origin).try_normalize() };
    Ray { origin, direction: direction.unwrap_or(DVec3::Z) }
}

/// Traces `rays`; returns the number that passed, or the first that is wrong.
fn trace<R: Traced>(tracer: &Tracer<R>, bundle: &mut Bundle<R>, rays: impl Fn(u64) -> Ray) -> Result<u64, String> {
    bundle.clear();
    (0..BUNDLE).for_each(|i| bundle.push(rays(i)));
    tracer.trace(bundle);
    let mut passed = 0;
    for i in 0..BUNDLE {
        if let Ok(out) = bundle.result(i as usize) {
            passed += 1;
            // Twice checked: a comparison with a number that is none is false.
            let is_good = out.origin.is_finite() && (out.direction.length() - 1.0).abs() < 1e-9;
            if !is_good {
                return Err(format!("{:?} became {out:?}", rays(i)));
            }
        }
    }
    Ok(passed)
}

fn systems() -> Vec<System> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
    let mut files: Vec<_> =
        std::fs::read_dir(folder).expect("the lenses").flatten().map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "lens"));
    files.sort();
    let system = |file: &Path| {
        let prescription = lens::read(file, Catalogue::shipped()).unwrap_or_else(|error| panic!("{error}"));
        System::new(&prescription, &LensSettings { blades: 7, ..LensSettings::default() }).expect("a shipped lens")
    };
    files.iter().map(|file| system(file)).collect()
}

/// The results of a flood.
pub struct Flood {
    pub rays: u64,
    pub passed: u64,
    pub lenses: usize,
}

/// Sends about `rays` rays on all cores.
///
/// # Panics
/// If one does not end as it should.
pub fn flood(rays: u64) -> Flood {
    let systems = systems();
    let bundles = rays.div_ceil(BUNDLE);
    let (next, passed) = (AtomicU64::new(0), AtomicU64::new(0));
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= bundles {
                return;
            }
            let system = &systems[number as usize / 4 % systems.len()];
            match flood_lens(system, number) {
                Ok(count) => _ = passed.fetch_add(count, Ordering::Relaxed),
                Err(what) => panic!("{}: {what}", system.name()),
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    Flood { rays: bundles * BUNDLE, passed: passed.into_inner(), lenses: systems.len() }
}

/// Bundle `number`: its bits choose the way and the kind of numbers.
fn flood_lens(system: &System, number: u64) -> Result<u64, String> {
    let (travel, semi, towards, vertex) = match number % 2 {
        0 => (Travel::FromScene, system.surfaces()[0].semi_diameter_mm, 1.0, 0.0),
        _ => {
            let towards = -system.light_direction_at_film();
            (Travel::FromFilm, system.rear_radius_mm(), towards, system.last_vertex_z_mm())
        }
    };
    let rays = |i: u64| ray(&mut Dice((number * BUNDLE + i) << 8), semi, towards, vertex);
    let tracer = system.at_wavelength(380.0 + (number % 401) as f64);
    match number / 2 % 2 {
        0 => trace(&tracer, &mut tracer.bundle(travel), rays),
        _ => {
            let tracer: Tracer<f32> = tracer.cast();
            trace(&tracer, &mut tracer.bundle(travel), rays)
        }
    }
}

//! Whole lens systems, made of a fuzzer's bytes, and their rays in machine numbers beside the same in 320-bit numbers.
//!
//! The exact ray is laid through the prescription surface by surface, with its own sums of thicknesses and its own turns and shifts of
//! surfaces; nothing of the tracer's layout is used but the numbers of poses. An error that a machine number makes at one surface grows on the
//! way behind it: how much is found by exact rays that are moved there by as much. So the tolerance of a hit is the sum, over the surfaces up to
//! it, of the moves of it that come of errors ten times as large as what the data at that surface allow, the bound which `docs/numerics.md` has of
//! single surfaces.

mod chain;

use glam::DVec3;
use petzval_optics::glass::{Gradient, GradientTerm, Medium};
use petzval_optics::prescription::{Metadata, NextMedium, Place, Prescription, SurfaceRow};
use petzval_optics::surface::{Conic, Pose, Shape};
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Lost, Ray};

use self::chain::{Chain, Way};
use super::bytes::Bytes;

/// The most surfaces of a system: the time of its exact rays grows with their square.
const MOST_SURFACES: usize = 6;
/// The most rays of an input, each way.
const MOST_RAYS: usize = 3;

/// The kinds of media that [`prescription`] may make.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kinds {
    /// Those that the 320-bit tracer knows.
    Exact,
    /// Media with gradients, too.
    WithGradients,
}

/// A surface's shape. Its slopes within the rim stay moderate, so that a ray crosses it there once.
fn shape(bytes: &mut Bytes<'_>, semi_mm: f64) -> Shape {
    let kind = bytes.below(8);
    // A rim at no more than 0.6 of the radius of curvature.
    let curvature = |bytes: &mut Bytes<'_>| if bytes.once_in(32) { 0.0 } else { 0.6 * bytes.part() / semi_mm };
    let base =
        Conic { curvature: curvature(bytes), conic: if bytes.once_in(96) { 2.0 * bytes.part() - 0.5 } else { 0.0 } };
    if kind < 3 {
        return Shape::Conic(base);
    }
    let count = bytes.below(4);
    let terms: Vec<(u32, f64)> = (0..count)
        .map(|_| {
            let power = 2 + bytes.below(19) as u32;
            // A slope of at most 0.05 at the rim.
            (power, 0.05 * bytes.part() / (f64::from(power) * semi_mm.powi(power as i32 - 1)))
        })
        .collect();
    let across = curvature(bytes);
    let radius_x_mm = (kind >= 6).then(|| if across == 0.0 { 0.0 } else { 1.0 / across });
    Shape::from_numbers(base, &terms, radius_x_mm)
}

/// A decentre of at most a fifth of the rim, and tilts of at most 17 degrees.
fn pose(bytes: &mut Bytes<'_>, semi_mm: f64) -> Pose {
    if !bytes.once_in(80) {
        return Pose::identity();
    }
    let [x, y, a, b, c] = std::array::from_fn(|_| bytes.part());
    Pose::misaligned([0.2 * semi_mm * x, 0.2 * semi_mm * y], [0.3 * a, 0.3 * b, 3.0 * c])
}

/// A medium whose index changes by at most a twentieth over a length and a rim.
fn with_gradient(base: Medium, bytes: &mut Bytes<'_>, length_mm: f64, semi_mm: f64) -> Medium {
    let mut term = |z: u32, r: u32| {
        let coefficient = 0.02 * bytes.part() / (length_mm.powi(z as i32) * semi_mm.powi(r as i32));
        GradientTerm { z, r, coefficient }
    };
    match Gradient::new(vec![term(1, 0), term(0, 2), term(2, 0)], 0.0) {
        Some(gradient) => base.with_gradient(gradient),
        None => base,
    }
}

/// A lens system of a few surfaces.
pub fn prescription(bytes: &mut Bytes<'_>, kinds: Kinds) -> Prescription {
    let scale = 10f64.powf(1.5 * bytes.part());
    let count = 1 + bytes.below(MOST_SURFACES);
    let mut along = 1.0;
    let mut surfaces = Vec::new();
    for i in 0..count {
        let semi_mm = 10.0 * scale * (1.0 + 0.5 * bytes.part());
        let shape = shape(bytes, semi_mm);
        let behind = match bytes.byte() {
            0..=25 => NextMedium::Mirror,
            26..=90 => NextMedium::Medium(Medium::air()),
            91..=120 if kinds == Kinds::WithGradients && i + 1 < count => {
                let base = Medium::constant(&format!("gradient{i}"), 1.6 + 0.2 * bytes.part());
                NextMedium::Medium(with_gradient(base, bytes, 5.0 * scale, semi_mm))
            }
            _ => NextMedium::Medium(Medium::constant(&format!("glass{i}"), 1.55 + 0.45 * bytes.part())),
        };
        if behind == NextMedium::Mirror {
            along = -along;
        }
        surfaces.push(SurfaceRow {
            shape,
            pose: pose(bytes, semi_mm),
            thickness_mm: along * scale * (8.0 + 7.0 * bytes.part()),
            behind,
            semi_diameter_mm: semi_mm,
            obstruction_mm: if bytes.once_in(24) { 0.3 * semi_mm * bytes.part().abs() } else { 0.0 },
            coating: None,
            place: Place::default(),
        });
    }
    Prescription {
        name: "fuzz".to_owned(),
        stop: bytes.below(count),
        surfaces,
        metadata: Metadata::default(),
        film_radius_mm: None,
        moving: None,
        source_file: "fuzz".to_owned(),
    }
}

/// Rays that come to the first surface from the scene, or to the last from the film.
fn rays(bytes: &mut Bytes<'_>, system: &System, way: Way) -> Vec<Ray> {
    let surfaces = system.surfaces();
    let surface = match way {
        Way::FromScene => &surfaces[0],
        Way::FromFilm => &surfaces[surfaces.len() - 1],
    };
    let towards = match way {
        Way::FromScene => 1.0,
        Way::FromFilm => -system.light_direction_at_film(),
    };
    let semi = surface.semi_diameter_mm;
    let mut rays = Vec::new();
    while !bytes.is_empty() && rays.len() < MOST_RAYS {
        let aim = DVec3::new(0.9 * semi * bytes.part(), 0.9 * semi * bytes.part(), surface.z_mm);
        let direction = DVec3::new(0.4 * bytes.part(), 0.4 * bytes.part(), towards).normalize();
        let far = semi * 2f64.powf(8.0 * bytes.part());
        rays.push(Ray { origin: aim - direction * far, direction });
    }
    rays
}

/// Numbers of comparisons that were made: so that a test can tell that there were some.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compared {
    /// Hits whose place was held against the exact one.
    pub hits: u64,
    /// Directions behind the last surface.
    pub directions: u64,
    /// Rays that are lost at the same surface.
    pub losses: u64,
}

impl Compared {
    fn add(&mut self, other: Self) {
        self.hits += other.hits;
        self.directions += other.directions;
        self.losses += other.losses;
    }
}

/// Rays through a whole system, both ways, in f64 and in f32, beside those of the 320-bit tracer.
pub fn system(bytes: &[u8]) {
    compared(bytes);
}

/// [`system`], and how much was compared.
pub fn compared(bytes: &[u8]) -> Compared {
    let mut sum = Compared::default();
    let mut bytes = Bytes::new(bytes);
    let lens = prescription(&mut bytes, Kinds::Exact);
    let Ok(system) = System::new(&lens, &LensSettings::default()) else { return sum };
    let mut index = 1.0;
    let mut after = Vec::new();
    for row in &lens.surfaces {
        if let NextMedium::Medium(medium) = &row.behind {
            index = medium.index(550.0);
        }
        after.push(index);
    }
    let tracer = system.with_indices(550.0, &after);
    let single = tracer.cast::<f32>();
    for way in [Way::FromScene, Way::FromFilm] {
        let chain = Chain::new(&lens, &after, way, system.last_vertex_z_mm());
        for ray in rays(&mut bytes, &system, way) {
            let passages = chain.passages_of(ray);
            sum.add(chain.compare(&tracer, ray, &passages));
            sum.add(chain.compare(&single, ray, &passages));
        }
    }
    sum
}

/// Rays through a system with gradients, which the 320-bit tracer does not know: their numbers are finite, and directions of unit length.
pub fn gradient(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let lens = prescription(&mut bytes, Kinds::WithGradients);
    let Ok(system) = System::new(&lens, &LensSettings::default()) else { return };
    let tracer = system.at_wavelength(550.0);
    let single = tracer.cast::<f32>();
    let sound = |ray: Ray, result: Result<Ray, Lost>| {
        if let Ok(out) = result {
            assert!(out.origin.is_finite() && out.direction.is_finite(), "{ray:?}: {out:?}");
            assert!((out.direction.length() - 1.0).abs() < 1e-15, "{ray:?}: {out:?}");
        }
    };
    for way in [Way::FromScene, Way::FromFilm] {
        for ray in rays(&mut bytes, &system, way) {
            match way {
                Way::FromScene => {
                    sound(ray, tracer.from_scene(ray));
                    sound(ray, single.from_scene(ray));
                }
                Way::FromFilm => {
                    sound(ray, tracer.from_film(ray));
                    sound(ray, single.from_film(ray));
                }
            }
        }
    }
}

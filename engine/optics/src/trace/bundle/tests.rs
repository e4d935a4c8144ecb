//! A ray in a bundle is the ray alone, with all kinds of instructions.

use super::*;
use crate::diaphragm::ApertureMask;
use crate::formats::lens;
use crate::glass::Catalogue;
use crate::system::{LensSettings, System};
use std::sync::Arc;

/// All kinds of instructions that this processor has.
fn levels() -> Vec<Level> {
    #[allow(unused_mut)]
    let mut levels = vec![Level::new()];
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(Level::new().as_sse2().map(Level::Sse2));
        levels.extend(Level::new().as_sse4_2().map(Level::Sse4_2));
        levels.extend(Level::new().as_avx2().map(Level::Avx2));
    }
    levels
}

/// Rays from the film to anywhere on the rear glass, and as many from the scene.
fn rays(system: &System, travel: Travel, count: u32) -> impl Iterator<Item = Ray> {
    let (glass, from, semi) = match travel {
        Travel::FromFilm => (system.last_vertex_z_mm(), system.film_z_published_mm(), system.rear_radius_mm()),
        Travel::FromScene => {
            let semi = system.surfaces()[0].semi_diameter_mm;
            (0.0, -4.0 * semi, semi)
        }
    };
    (0..count).map(move |i| {
        let at = |by: u32| f64::from(i * by % 101) / 50.0 - 1.0;
        let origin = DVec3::new(at(17) * semi * 0.3, at(29) * semi * 0.3, from);
        let target = DVec3::new(at(41) * semi, at(59) * semi, glass);
        Ray { origin, direction: (target - origin).normalize() }
    })
}

fn check<R: Traced>(system: &System, travel: Travel) -> usize {
    let tracer: Tracer<R> = system.at_wavelength(550.0).cast();
    let mut passed = 0;
    for level in levels() {
        let mut bundle = tracer.bundle(travel);
        // Not a whole number of registers.
        rays(system, travel, 1003).for_each(|ray| bundle.push(ray));
        tracer.trace_with(level, &mut bundle);
        for (i, ray) in rays(system, travel, 1003).enumerate() {
            let alone = match travel {
                Travel::FromScene => tracer.from_scene(ray),
                Travel::FromFilm => tracer.from_film(ray),
            };
            assert_eq!(bundle.result(i), alone, "{} {level:?} {travel:?} {i}", system.name());
        }
        passed += bundle.passed();
    }
    passed
}

/// Open in stripes of a ninth of the stop, dark in the middle.
fn masked(system: System) -> System {
    let values: Vec<f32> = (0..81).map(|i| if (i % 9) % 2 == 0 && i / 9 != 4 { 1.0 } else { 0.1 }).collect();
    system.with_aperture_mask(Arc::new(ApertureMask::new(9, &values).unwrap()), 0.3).unwrap()
}

#[test]
fn a_ray_in_a_bundle_is_the_ray_alone() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/lenses");
    let both = [Travel::FromScene, Travel::FromFilm];
    let mut passed = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let Ok(prescription) = lens::read(&path, Catalogue::shipped()) else { continue };
        for (blades, blade_curvature) in [(0, 0.0), (5, 0.0), (5, 0.5)] {
            let settings = LensSettings { blades, blade_curvature, ..LensSettings::default() };
            let system = System::new(&prescription, &settings).unwrap();
            let systems = [Some(system.clone()), (blades == 0).then(|| masked(system))];
            for (system, travel) in systems.iter().flatten().flat_map(|s| both.map(|travel| (s, travel))) {
                passed += check::<f64>(system, travel) + check::<f32>(system, travel);
            }
        }
    }
    assert!(passed > 50_000, "{passed}");
}

#[test]
fn a_bundle_can_be_filled_again() {
    let text = "0 5 1.5 10 0 1";
    let prescription = lens::parse(text, "test", Catalogue::shipped()).unwrap();
    let tracer = System::new(&prescription, &LensSettings::default()).unwrap().at_wavelength(550.0);
    let mut bundle = tracer.bundle(Travel::FromScene);
    let ray = |x: f64| Ray { origin: DVec3::new(x, 0.0, -1.0), direction: DVec3::Z };
    tracer.trace(&mut bundle);
    assert!(bundle.is_empty());
    for x in [1.0, 6.0] {
        bundle.clear();
        bundle.push(ray(x));
        tracer.trace(&mut bundle);
        assert_eq!((bundle.len(), bundle.passed()), (1, usize::from(x < 5.0)));
    }
}

//! The models of one lens against each other: their difference is of third order in aperture and field.

use crate::camera::{Camera, CameraDescription, Model, lens_info};
use glam::Vec2;
use proptest::prelude::*;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// A lens file that goes when it is dropped.
struct LensFile(PathBuf);

impl LensFile {
    fn new(text: &str) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("petzval-{}-{}.lens", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::File::create(&path).unwrap().write_all(text.as_bytes()).unwrap();
        Self(path)
    }
}

impl Drop for LensFile {
    fn drop(&mut self) {
        // Nothing is lost if it stays.
        std::fs::remove_file(&self.0).ok();
    }
}

/// One element of weak power: curvatures in 1/m of front and rear, thickness in mm, index, and how far in front of it,
/// in mm, the stop stands.
#[derive(Clone, Debug)]
struct Element {
    curvatures: [f64; 2],
    thickness: f64,
    index: f64,
    stop_before: f64,
}

fn elements() -> impl Strategy<Value = Element> {
    (-4.0..14.0f64, 4.0..12.0f64, 1.0..5.0f64, 1.45..1.9f64, 0.0..8.0f64).prop_map(
        |(front, bend, thickness, index, stop_before)| {
            // The front's curvature less the rear's is the power over n − 1: a focal length of 80 to 500 mm.
            Element { curvatures: [front, front - bend], thickness, index, stop_before }
        },
    )
}

impl Element {
    fn file(&self) -> LensFile {
        let radius = |curvature: f64| if curvature.abs() < 0.1 { 0.0 } else { 1000.0 / curvature };
        let [front, rear] = self.curvatures.map(radius);
        LensFile::new(&format!(
            "#radius thickness glass diameter conic isstop\n\
             0 {} air 60 0 1\n{front} {} {} 70 0 0\n{rear} 100 air 70 0 0\n",
            self.stop_before, self.thickness, self.index
        ))
    }
}

/// A camera at infinity with beams of f/`f_number` and a film of that part of the focal length on a side.
fn description(model: Model, file: &LensFile, focal_length_mm: f64, f_number: f64, field: f64) -> CameraDescription {
    let film_mm = field * focal_length_mm;
    CameraDescription {
        model,
        lens_path: file.0.clone(),
        wavelength_nm: Some(587.5618),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.perspective.focal_length_mm = focal_length_mm;
        c.perspective.film_width_mm = film_mm;
        c.lens.f_number = Some(f_number);
        c.film.width_mm = film_mm;
        c.film.height_mm = film_mm;
    })
}

/// The largest angle between the directions of two models at the same place of the picture, rad. The rays of a film point are
/// parallel in front of a lens of first order that is focused at infinity, so it does not matter which go together.
fn apart(a: &Camera, b: &Camera) -> f32 {
    let mut largest = 0.0f32;
    for i in 0..256 {
        let [x, y, u, v] = sobol_burley::sample_4d(i, 0, 2);
        let p = Vec2::new(x - 0.5, y - 0.5);
        if let (Some(a), Some(b)) = (a.sample(p, [u, v], 0.0), b.sample(p, [u, v], 0.0)) {
            largest = largest.max((a.ray.direction - b.ray.direction).length());
        }
    }
    largest
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn models_part_by_the_third_order(element in elements()) {
        let file = element.file();
        let any = description(Model::Lens, &file, 100.0, 20.0, 0.1);
        let f_mm = lens_info(&any, 100, 100).unwrap().efl_mm.unwrap();
        let camera = |model, part: f64| {
            Camera::new(&description(model, &file, f_mm, 12.0 / part, 0.16 * part), 100, 100).unwrap()
        };
        // Of rays in f32.
        const ROUNDING: f32 = 4e-7;
        let mut parting = [0.0; 2];
        for (parting, part) in parting.iter_mut().zip([1.0, 0.5]) {
            let exact = camera(Model::Lens, part);
            let first_order = [Model::Thick, Model::Paraxial, Model::Thin].map(|model| camera(model, part));
            let largest = first_order.each_ref().map(|model| apart(&exact, model));
            // Among themselves they agree: focused at infinity a thick lens sees what a thin one does.
            prop_assert!((largest[0] - largest[1]).abs() < ROUNDING && (largest[0] - largest[2]).abs() < ROUNDING);
            // The table knows the third order, too; what it leaves out is far below.
            let table = apart(&exact, &camera(Model::ImageBased, part));
            prop_assert!(table < 1e-4 * largest[0] + ROUNDING, "{element:?} {part}: {table} of {largest:?}");
            *parting = largest[0];
        }
        let [all, half] = parting;
        // The beam is 1/24 of the focal length to either side, the corner of the film 0.11 from its middle.
        prop_assert!(all < 3.0 * (1.0f32 / 24.0 + 0.11).powi(3), "{element:?}: {all}");
        // Half of aperture and field: an eighth; the fifth order, of some hundredths, moves that by a little.
        prop_assert!(half < all / 7.0 + ROUNDING, "{element:?}: {all} {half}");
        prop_assert!(half > all / 9.0 - ROUNDING, "{element:?}: {all} {half}");
    }
}

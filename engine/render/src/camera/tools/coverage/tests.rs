//! Coverage, tested by lenses whose circle of light is known.

use super::*;
use crate::camera::tests::with_lens;

const PIXELS: [u32; 2] = [300, 200];

/// A lens that is focused at infinity.
fn far(file: &str, width_mm: f64, height_mm: f64) -> CameraDescription {
    with_lens(file, width_mm, height_mm, 0.0).with(|c| c.focus.distance = None)
}

#[test]
fn a_lens_lights_the_film_that_it_is_made_for() {
    for file in ["nikkor-z-50-f1.8.lens", "biogon-21-f4.5.lens", "nikkor-28-f1.4.lens", "hologon-15-f8.lens"] {
        let found = far(file, 36.0, 24.0).coverage(PIXELS).unwrap();
        assert_eq!((found.dark_part, found.complaint), (0.0, None), "{file}");
        assert!((found.lit_diameter_mm - 36f64.hypot(24.0)).abs() < 1e-9, "{file}");
    }
}

#[test]
fn a_film_that_is_too_large_is_said_to_be() {
    // iPhone 7: 4.8 x 3.6 mm.
    let found = far("phone-4.1-f1.8.lens", 36.0, 24.0).coverage(PIXELS).unwrap();
    let area = std::f64::consts::PI * 0.25 * found.lit_diameter_mm.powi(2);
    assert!((6.0..12.0).contains(&found.lit_diameter_mm), "{found:?}");
    // The circle's area is what is left of the film's, but for the places' own size.
    assert!((1.0 - found.dark_part - area / (36.0 * 24.0)).abs() < 0.03, "{found:?}");
    let said = found.complaint.unwrap();
    assert!(said.contains("36.0 x 24.0 mm") && said.contains("Of the Lens"), "{said}");
}

#[test]
fn movements_are_told_from_a_film_that_is_too_large() {
    let lens = far("nikkor-z-50-f1.8.lens", 36.0, 24.0);
    let shifted = lens.clone().with(|c| c.film.shift_mm = [0.0, 20.0]).coverage(PIXELS).unwrap();
    assert!(shifted.dark_part > 0.05 && shifted.complaint.as_ref().unwrap().contains("shifted so far"), "{shifted:?}");
    let tilted = lens.with(|c| c.film.tilt_rad = 60f64.to_radians()).coverage(PIXELS).unwrap();
    assert!(tilted.complaint.as_ref().unwrap().contains("tilted so far"), "{tilted:?}");
}

#[test]
fn models_without_rims_light_everything() {
    let thick = far("phone-4.1-f1.8.lens", 36.0, 24.0).with(|c| c.model = Model::Thick);
    assert_eq!(thick.coverage(PIXELS).unwrap().complaint, None);
}

#[test]
fn the_film_of_a_lens_is_that_of_its_file_at_its_present_size() {
    let lens = far("phone-4.1-f1.8.lens", 36.0, 24.0);
    assert_eq!(lens.film_of_lens_mm(PIXELS).unwrap(), [4.8, 3.6]);
    let twice = lens.with(|c| c.lens.focal_length = FocalLength::Scale(2.0)).film_of_lens_mm(PIXELS).unwrap();
    assert!((twice[0] - 9.6).abs() < 1e-9 && (twice[1] - 7.2).abs() < 1e-9, "{twice:?}");
    // Zoomed it is no larger.
    let zoom = far("nikkor-z-24-70-f4.lens", 1.0, 1.0).with(|c| c.lens.focal_length = FocalLength::Millimetres(60.0));
    assert_eq!(zoom.film_of_lens_mm(PIXELS).unwrap(), [36.0, 24.0]);
}

#[test]
fn a_lens_without_a_film_has_the_one_that_its_field_fills() {
    // Double Gauss F/2, 22 degrees: 2 f tan of that, but for its distortion.
    let lens = far("double-gauss-f2-tronnier.lens", 36.0, 24.0);
    let [width, height] = lens.film_of_lens_mm(PIXELS).unwrap();
    let info = crate::camera::lens_info(&lens, PIXELS[0], PIXELS[1]).unwrap();
    let half_field_deg = lens.lens_file().unwrap().prescription.metadata.half_field_deg.unwrap();
    let expected = 2.0 * info.efl_mm.unwrap() * half_field_deg.to_radians().tan();
    assert!((width.hypot(height) / expected - 1.0).abs() < 0.05, "{width} x {height}, {expected}");
    assert!((width / height - 1.5).abs() < 1e-9);
}

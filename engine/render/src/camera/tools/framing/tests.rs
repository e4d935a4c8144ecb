//! Framing, tested by the angles of the lens.

use super::*;
use crate::camera::lens_info;
use crate::camera::tests::with_lens;

const PIXELS: [u32; 2] = [300, 200];

fn blenders(focal_length: f64, shift: [f64; 2], file: &str) -> CameraDescription {
    with_lens(file, 36.0, 24.0, 0.0).with(|c| {
        c.perspective.focal_length_mm = focal_length;
        c.perspective.film_width_mm = 36.0;
        c.perspective.shift = shift;
    })
}

fn applied(d: &CameraDescription, f: &Framing) -> CameraDescription {
    d.clone().with(|c| {
        c.lens.focal_length = f.focal_length_mm.map_or(d.lens.focal_length, FocalLength::Millimetres);
        c.film.width_mm = f.film_width_mm;
        c.film.height_mm = f.film_height_mm;
        c.film.shift_mm = f.shift_mm;
    })
}

#[test]
fn the_lens_then_sees_the_same_angle() {
    for (by, shift) in
        [(Framed::ByFocalLength, [0.0; 2]), (Framed::ByFilm, [0.0; 2]), (Framed::ByFocalLength, [0.1, 0.05])]
    {
        let d = blenders(60.0, shift, "double-gauss-f2-available.lens");
        let found = d.framed_like_blender(PIXELS, by).unwrap();
        let info = lens_info(&applied(&d, &found), PIXELS[0], PIXELS[1]).unwrap();
        assert!(found.reaches_edges);
        let wanted = ((0.5 + shift[0]) * 36.0 / 60.0f64).atan() - ((shift[0] - 0.5) * 36.0 / 60.0).atan();
        assert!((info.fov_horizontal_rad.unwrap() - wanted).abs() < 1e-6, "{by:?}");
        assert!((found.angle_rad - wanted).abs() < 1e-12);
        // Its distortion and its breathing make it another focal length than Blender's.
        if by == Framed::ByFocalLength {
            assert!((found.focal_length_mm.unwrap() / 60.0 - 1.0).abs() < 0.1, "{found:?}");
            assert_eq!(found.film_width_mm, 36.0);
        } else {
            assert_eq!(found.focal_length_mm, None);
        }
    }
}

#[test]
fn a_picture_that_is_dark_at_its_edges_is_framed_too() {
    let d = blenders(40.0, [0.0; 2], "double-gauss-f2-available.lens");
    let found = d.framed_like_blender(PIXELS, Framed::ByFocalLength).unwrap();
    assert!(!found.reaches_edges);
    assert!((found.focal_length_mm.unwrap() / 40.0 - 1.0).abs() < 0.1);
}

#[test]
fn an_upright_picture_is_framed_along_its_height() {
    let d = blenders(60.0, [0.0; 2], "double-gauss-f2-available.lens");
    let d = d.with(|c| c.perspective.film_width_mm = 24.0);
    let found = d.framed_like_blender([200, 300], Framed::ByFocalLength).unwrap();
    let info = lens_info(&applied(&d, &found), 200, 300).unwrap();
    assert!((info.fov_vertical_rad.unwrap() - 2.0 * (18.0 / 60.0f64).atan()).abs() < 1e-6);
}

#[test]
fn zooms_stay_within_their_range() {
    let file = "nikkor-z-24-70-f4.lens";
    let d = blenders(50.0, [0.0; 2], file);
    let found = d.framed_like_blender(PIXELS, Framed::ByFocalLength).unwrap();
    assert!((24.0..70.0).contains(&found.focal_length_mm.unwrap()));
    let error = blenders(200.0, [0.0; 2], file).framed_like_blender(PIXELS, Framed::ByFocalLength).unwrap_err();
    assert!(error.to_string().contains("zoom"), "{error}");
}

#[test]
fn what_the_lens_cannot_see_is_said() {
    let d = blenders(4.0, [0.0; 2], "double-gauss-f2-available.lens");
    let error = d.framed_like_blender(PIXELS, Framed::ByFocalLength).unwrap_err();
    assert!(error.to_string().contains("degrees"), "{error}");
}

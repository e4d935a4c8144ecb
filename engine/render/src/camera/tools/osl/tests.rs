//! Tests of the text that is written, and of refused lenses. The script itself is run by Cycles in
//! `tests/cli/test_osl_camera.py`.

use super::*;
use crate::camera::tests::with_lens;

const PIXELS: [u32; 2] = [300, 200];

#[test]
fn every_place_is_filled_and_numbers_are_finite() {
    for file in ["double-gauss-f2-available.lens", "phone-4.1-f1.8.lens", "nikkor-z-24-70-f4.lens", "newtonian-f5.lens"]
    {
        let d = with_lens(file, 4.0, 3.0, 0.05).with(|c| c.focus.distance = Some(30.0));
        let text = d.osl_camera(PIXELS).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert!(!text.contains('@'), "{file}");
        assert!(!["inf,", "inf}", "inf ", "NaN"].iter().any(|bad| text.contains(bad)), "{file}");
        assert_eq!(text.matches('{').count(), text.matches('}').count());
    }
}

#[test]
fn what_cannot_be_done_is_named() {
    let refused = |file: &str| with_lens(file, 10.0, 8.0, 0.0).osl_camera(PIXELS).unwrap_err().to_string();
    assert!(
        refused("eye-liou-brennan.lens").contains("gradient") || refused("eye-liou-brennan.lens").contains("tilted")
    );
    let pinhole = CameraDescription { model: Model::Pinhole, ..with_lens("newtonian-f5.lens", 10.0, 8.0, 0.0) };
    assert!(pinhole.osl_camera(PIXELS).is_err());
}

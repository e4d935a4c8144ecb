//! The distance from a bright source in the picture up to which light spread by diffraction is seen.

use super::look::SceneProbe;
use crate::camera::tools::survey::Survey;
use std::f64::consts::PI;

/// The least light that is seen, as a part of the exposure.
const SEEN: f64 = 1.0 / 255.0;
/// J₁'s first zero, of the first dark ring.
const DARK_RING: f64 = 3.831_706;
/// Half of a pixel: from its middle to its edge.
const EDGE_PX: f64 = 0.5;

/// Pixels from the edge of the pixel of the brightest source in the picture to where a round opening's pattern, which falls as
/// the cube of the distance r, is below a 255th of the exposure; 0 without a source. Spikes of blades reach farther.
///
/// The part 2 / (π x) of a point's light lands beyond x = 3.83 r / r₁, r₁ the first dark ring (Born and Wolf, section 8.5.2), so that on a
/// pixel at r lands r₁ / (3.83 π² r³).
pub(super) fn seen_px(survey: &Survey, look: &SceneProbe, airy_px: f64) -> f64 {
    let Some(focal_length_mm) = survey.info().efl_mm else { return 0.0 };
    let [width, height] = survey.pixel_mm();
    let pixel_sr = width * height / (focal_length_mm * focal_length_mm);
    let in_picture = look.brightest.iter().filter(|one| one.place.is_some());
    let brightest = in_picture.map(|one| f64::from(one.irradiance)).fold(0.0, f64::max);
    let over_exposure = brightest / pixel_sr / f64::from(look.exposure);
    let distance_px = (airy_px / (DARK_RING * PI * PI) * over_exposure / SEEN).cbrt();
    if distance_px.is_finite() { (distance_px - EDGE_PX).max(0.0) } else { 0.0 }
}

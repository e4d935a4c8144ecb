//! Colours of light by temperature and by wavelength: Blackbody and Wavelength.
//!
//! Source of the table: CIE 015:2018, colour-matching functions of the 1931 2-degree observer.

use crate::lanes::most;
use glam::Vec3A;
use std::sync::LazyLock;

const FIRST_NM: f32 = 380.0;
const STEP_NM: f32 = 5.0;

/// The observer's x, y and z, every 5 nm.
#[rustfmt::skip]
const OBSERVER: [[f32; 3]; 81] = [
    [0.001368, 3.9e-05, 0.006450001], [0.002236, 6.4e-05, 0.01054999], [0.004243, 0.00012, 0.02005001],
    [0.00765, 0.000217, 0.03621], [0.01431, 0.000396, 0.06785001], [0.02319, 0.00064, 0.1102],
    [0.04351, 0.00121, 0.2074], [0.07763, 0.00218, 0.3713], [0.13438, 0.004, 0.6456],
    [0.21477, 0.0073, 1.0390501], [0.2839, 0.0116, 1.3856], [0.3285, 0.01684, 1.62296],
    [0.34828, 0.023, 1.74706], [0.34806, 0.0298, 1.7826], [0.3362, 0.038, 1.77211],
    [0.3187, 0.048, 1.7441], [0.2908, 0.06, 1.6692], [0.2511, 0.0739, 1.5281],
    [0.19536, 0.09098, 1.28764], [0.1421, 0.1126, 1.0419], [0.09564, 0.13902, 0.8129501],
    [0.05795001, 0.1693, 0.6162], [0.03201, 0.20802, 0.46518], [0.0147, 0.2586, 0.3533],
    [0.0049, 0.323, 0.272], [0.0024, 0.4073, 0.2123], [0.0093, 0.503, 0.1582],
    [0.0291, 0.6082, 0.1117], [0.06327, 0.71, 0.07824999], [0.1096, 0.7932, 0.05725001],
    [0.1655, 0.862, 0.04216], [0.2257499, 0.9148501, 0.02984], [0.2904, 0.954, 0.0203],
    [0.3597, 0.9803, 0.0134], [0.4334499, 0.9949501, 0.008749999], [0.5120501, 1.0, 0.005749999],
    [0.5945, 0.995, 0.0039], [0.6784, 0.9786, 0.002749999], [0.7621, 0.952, 0.0021],
    [0.8425, 0.9154, 0.0018], [0.9163, 0.87, 0.001650001], [0.9786, 0.8163, 0.0014],
    [1.0263, 0.757, 0.0011], [1.0567, 0.6949, 0.001], [1.0622, 0.631, 0.0008],
    [1.0456, 0.5668, 0.0006], [1.0026, 0.503, 0.00034], [0.9384, 0.4412, 0.00024],
    [0.8544499, 0.381, 0.00019], [0.7514, 0.321, 0.0001], [0.6424, 0.265, 4.999999e-05],
    [0.5419, 0.217, 3e-05], [0.4479, 0.175, 2e-05], [0.3608, 0.1382, 1e-05],
    [0.2835, 0.107, 2.1175824e-22], [0.2187, 0.0816, 0.0], [0.1649, 0.061, 0.0],
    [0.1212, 0.04458, 0.0], [0.0874, 0.032, 0.0], [0.0636, 0.0232, 0.0],
    [0.04677, 0.017, 0.0], [0.0329, 0.01192, 0.0], [0.0227, 0.00821, 0.0],
    [0.01584, 0.005723, 0.0], [0.01135916, 0.004102, 0.0], [0.008110916, 0.002929, 0.0],
    [0.005790346, 0.002091, 0.0], [0.004109457, 0.001484, 0.0], [0.002899327, 0.001047, 0.0],
    [0.00204919, 0.00074, 0.0], [0.001439971, 0.00052, 0.0], [0.0009999493, 0.0003611, 0.0],
    [0.0006900786, 0.0002492, 0.0], [0.0004760213, 0.0001719, 0.0], [0.0003323011, 0.00012, 0.0],
    [0.0002348261, 8.48e-05, 0.0], [0.0001661505, 6e-05, 0.0], [0.000117413, 4.24e-05, 0.0],
    [8.307527e-05, 3e-05, 0.0], [5.870652e-05, 2.12e-05, 0.0], [4.150994e-05, 1.499e-05, 0.0],
];

/// XYZ to linear Rec.709, whose white is D65 at x = 0.3127, y = 0.3290.
pub(crate) fn rec709(xyz: Vec3A) -> Vec3A {
    Vec3A::new(
        xyz.dot(Vec3A::new(3.240_97, -1.537_383_2, -0.498_610_8)),
        xyz.dot(Vec3A::new(-0.969_243_6, 1.875_967_5, 0.041_555_06)),
        xyz.dot(Vec3A::new(0.055_630_08, -0.203_976_96, 1.056_971_5)),
    )
}

/// The colour of one wavelength, at the brightness that Blender gives it.
pub(crate) fn wavelength(nm: f32) -> Vec3A {
    // Blender's: the brightest channel of the spectrum comes near to 1.
    const BRIGHTNESS: f32 = 1.0 / 2.52;
    let place = (nm - FIRST_NM) / STEP_NM;
    if !(place >= 0.0 && place < (OBSERVER.len() - 1) as f32) {
        return Vec3A::ZERO;
    }
    let row = place as usize;
    let [before, after] = [row, row + 1].map(|row| Vec3A::from_array(OBSERVER[row]));
    most(rec709(before.lerp(after, place - row as f32)) * BRIGHTNESS, Vec3A::ZERO)
}

const COOLEST_K: f32 = 800.0;
const HOTTEST_K: f32 = 12_000.0;
const STEPS: usize = 512;

/// The colour of a glowing body; its luminance is 1 where no channel is cut off at 0.
pub fn blackbody(kelvin: f32) -> Vec3A {
    // Even steps of the inverse temperature: along them colours change about evenly.
    static TABLE: LazyLock<Vec<Vec3A>> = LazyLock::new(|| {
        let [low, high] = [1.0 / f64::from(COOLEST_K), 1.0 / f64::from(HOTTEST_K)];
        (0..=STEPS).map(|step| planck(1.0 / (low + (high - low) * step as f64 / STEPS as f64))).collect()
    });
    let kelvin = if kelvin.is_nan() { COOLEST_K } else { kelvin.clamp(COOLEST_K, HOTTEST_K) };
    let place = (1.0 / COOLEST_K - 1.0 / kelvin) / (1.0 / COOLEST_K - 1.0 / HOTTEST_K) * STEPS as f32;
    let step = (place as usize).min(STEPS - 1);
    most(TABLE[step].lerp(TABLE[step + 1], place - step as f32), Vec3A::ZERO)
}

/// Planck's law seen by the observer, at luminance 1.
fn planck(kelvin: f64) -> Vec3A {
    // h c / k in nm K.
    const SECOND_RADIATION_NM_K: f64 = 1.438_776_877e7;
    let mut xyz = [0.0_f64; 3];
    for (row, observer) in OBSERVER.iter().enumerate() {
        let nm = f64::from(FIRST_NM) + f64::from(STEP_NM) * row as f64;
        let power = nm.powi(-5) / ((SECOND_RADIATION_NM_K / (nm * kelvin)).exp() - 1.0);
        for (sum, seen) in xyz.iter_mut().zip(observer) {
            *sum += power * f64::from(*seen);
        }
    }
    rec709(Vec3A::from_array(xyz.map(|part| (part / xyz[1]) as f32)))
}

//! Sunlight scattered once on its way through the air.
//!
//! The atmosphere is that of Nishita, Sirai, Tadamura and Nakamae, "Display of the Earth taking into account atmospheric
//! scattering", SIGGRAPH 1993, with ozone; the numbers are those of Blender's model of it (intern/sky, Lukas Stockner and
//! Marco Pavanello), so that the same sky appears. Lengths are metres.

use super::panorama::{COLUMNS, Panorama, RowPlace};
use glam::Vec3A;
use std::f32::consts::{PI, TAU};

const GROUND_RADIUS_M: f32 = 6_360e3;
const TOP_RADIUS_M: f32 = 6_420e3;
/// Air and aerosols thin out by e in so much height.
const SCALE_HEIGHT_M: [f32; 2] = [8_000.0, 1_200.0];
/// Scattering coefficient of an aerosol, at every wavelength, per metre; its extinction is 1.11 times that.
const AEROSOL_PER_M: f32 = 2e-5;
const AEROSOL_EXTINCTION: f32 = 1.11 * AEROSOL_PER_M;
/// Forward scattering of aerosols.
const ASYMMETRY: f32 = 0.76;
const STEPS: usize = 32;
const LINES: usize = 21;
const LINE_STEP_NM: f32 = 20.0;

/// The data of a wavelength: the sun's irradiance above the air (W/m²/nm), scattering by air and absorption by ozone (1/m), and the CIE
/// 1931 observer. From 380 nm, every 20 nm.
struct SkyWavelength {
    sun: f32,
    air: f32,
    ozone: f32,
    observer: [f32; 3],
}

const fn line(sun: f32, air: f32, ozone: f32, observer: [f32; 3]) -> SkyWavelength {
    SkyWavelength { sun, air, ozone, observer }
}

#[rustfmt::skip]
const SPECTRUM: [SkyWavelength; LINES] = [
    line(1.457_568_3, 5.424_82e-5, 3.251_268_5e-9, [0.001_368, 0.000_039, 0.006_450_001]),
    line(1.565_963_1, 4.418_549_9e-5, 5.853_953_7e-9, [0.014_31, 0.000_396, 0.067_850_01]),
    line(1.651_484_5, 3.635_151_9e-5, 1.977_191_2e-8, [0.134_38, 0.004, 0.645_6]),
    line(1.714_962_4, 3.017_929e-5, 7.309_569e-8, [0.348_28, 0.023, 1.747_06]),
    line(1.757_979_8, 2.526_320_2e-5, 2.008_456_2e-7, [0.290_8, 0.06, 1.669_2]),
    line(1.782_564, 2.130_859_3e-5, 4.038_395_8e-7, [0.095_64, 0.139_02, 0.812_950_1]),
    line(1.790_951_1, 1.809_838e-5, 6.355_133_6e-7, [0.004_9, 0.323, 0.272]),
    line(1.785_415_5, 1.547_057e-5, 9.670_704e-7, [0.063_27, 0.71, 0.078_249_99]),
    line(1.768_155_5, 1.330_285e-5, 1.547_974e-6, [0.290_4, 0.954, 0.020_3]),
    line(1.741_220_7, 1.150_184_8e-5, 2.090_386_5e-6, [0.594_5, 0.995, 0.003_9]),
    line(1.706_471_3, 9.995_574e-6, 2.461_280_6e-6, [0.916_3, 0.87, 0.001_650_001]),
    line(1.665_560_9, 8.728e-6, 2.735_513e-6, [1.062_2, 0.631, 0.000_8]),
    line(1.619_932_4, 7.655_137e-6, 2.151_258_6e-6, [0.854_449_9, 0.381, 0.000_19]),
    line(1.570_836, 6.742_172e-6, 1.590_518_4e-6, [0.447_9, 0.175, 0.000_02]),
    line(1.519_323_4, 5.961_341e-6, 1.123_562e-6, [0.164_9, 0.061, 0.0]),
    line(1.466_284_9, 5.290_346e-6, 7.352_755e-7, [0.046_77, 0.017, 0.0]),
    line(1.412_458_5, 4.711_157e-6, 4.645_013e-7, [0.011_359_16, 0.004_102, 0.0]),
    line(1.358_449_6, 4.209_105e-6, 3.309_608e-7, [0.002_899_327, 0.001_047, 0.0]),
    line(1.304_749_1, 3.772_183_8e-6, 2.251_261_2e-7, [0.000_690_078_6, 0.000_249_2, 0.0]),
    line(1.251_749_6, 3.390_512_6e-6, 1.487_912_9e-7, [0.000_166_150_5, 0.000_06, 0.0]),
    line(1.199_76, 3.055_915_3e-6, 1.682_862_4e-7, [0.000_041_509_94, 0.000_014_99, 0.0]),
];

/// Places along a ray to the top of the air, as parts of it, and their weights: Gauss-Laguerre of eight places, cut off where
/// the last is still in the air.
const PLACES: [[f32; 2]; 8] = [
    [0.006_811_185_3, 0.017_508_936],
    [0.036_148_07, 0.041_354_775],
    [0.090_043_46, 0.066_788_39],
    [0.170_668, 0.095_076_99],
    [0.281_836_2, 0.128_341_64],
    [0.430_340_64, 0.170_743_02],
    [0.629_627_15, 0.232_723_33],
    [0.914_525_3, 0.356_249_05],
];

/// The contents of the air, as shares of the Earth's.
#[derive(Clone, Copy, Debug)]
pub(super) struct AirContents {
    /// Densities of molecules, aerosols and ozone.
    densities: Vec3A,
    altitude_m: f32,
    place: RowPlace,
}

/// Densities of molecules, aerosols and ozone, as shares of the most.
fn densities(height_m: f32) -> Vec3A {
    let [air, aerosol] = SCALE_HEIGHT_M.map(|scale| (-height_m / scale).exp());
    Vec3A::new(air, aerosol, (1.0 - (height_m - 25_000.0).abs() / 15_000.0).max(0.0))
}

fn height_m(p: Vec3A) -> f32 {
    p.length() - GROUND_RADIUS_M
}

/// Distance to the top of the air.
fn to_top_m(p: Vec3A, direction: Vec3A) -> f32 {
    let along = p.dot(direction);
    // In f64: the squares have more digits than f32 keeps.
    let beyond = f64::from(along) * f64::from(along) + f64::from(TOP_RADIUS_M).powi(2) - p.as_dvec3().length_squared();
    (beyond.sqrt() - f64::from(along)) as f32
}

/// True if the ground is in the way.
fn meets_ground(p: Vec3A, direction: Vec3A) -> bool {
    let along = f64::from(p.dot(direction));
    direction.z < 0.0 && along * along >= p.as_dvec3().length_squared() - f64::from(GROUND_RADIUS_M).powi(2)
}

/// Densities summed along a ray to the top, metres.
fn depths_m(p: Vec3A, direction: Vec3A) -> Vec3A {
    let length = to_top_m(p, direction);
    PLACES.iter().map(|[place, weight]| densities(height_m(p + direction * (place * length))) * *weight).sum::<Vec3A>()
        * length
}

fn direction(elevation_rad: f32, azimuth_rad: f32) -> Vec3A {
    let ((sin_e, cos_e), (sin_a, cos_a)) = (elevation_rad.sin_cos(), azimuth_rad.sin_cos());
    Vec3A::new(cos_e * cos_a, cos_e * sin_a, sin_e)
}

fn xyz(mut spectrum: impl FnMut(&SkyWavelength) -> f32) -> Vec3A {
    SPECTRUM.iter().map(|line| Vec3A::from(line.observer) * spectrum(line)).sum::<Vec3A>() * LINE_STEP_NM
}

impl AirContents {
    pub(super) fn new(densities: Vec3A, altitude_m: f32, place: RowPlace) -> Self {
        // Below the ground and above the air the formulas have no meaning.
        Self { densities, altitude_m: altitude_m.clamp(1.0, 59_999.0), place }
    }

    fn viewer(&self) -> Vec3A {
        Vec3A::new(0.0, 0.0, GROUND_RADIUS_M + self.altitude_m)
    }

    /// The sky above the horizon; below it, the horizon fading out.
    pub(super) fn panorama(&self, sun_elevation_rad: f32) -> Panorama {
        let sun = direction(sun_elevation_rad, 0.0);
        let at = |azimuth_rad: f32, elevation_rad: f32| self.scattered(direction(elevation_rad, azimuth_rad - PI), sun);
        let horizon: Vec<Vec3A> = (0..COLUMNS / 2).map(|i| at(TAU * i as f32 / COLUMNS as f32, 0.0)).collect();
        Panorama::new(self.place, |azimuth_rad, elevation_rad| {
            if elevation_rad >= 0.0 {
                return at(azimuth_rad, elevation_rad);
            }
            let column = (azimuth_rad / TAU * COLUMNS as f32).round() as usize;
            horizon[column.min(horizon.len() - 1)] * (1.0 + 2.5 * elevation_rad.sin()).max(0.0).powi(3)
        })
    }

    /// Light scattered towards the viewer along a ray.
    fn scattered(&self, ray: Vec3A, sun: Vec3A) -> Vec3A {
        let cosine = ray.dot(sun);
        let g2 = ASYMMETRY * ASYMMETRY;
        let air_phase = 3.0 / (16.0 * PI) * (1.0 + cosine * cosine);
        let aerosol_phase = 3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + cosine * cosine)
            / ((2.0 + g2) * (1.0 + g2 - 2.0 * ASYMMETRY * cosine).powf(1.5));
        let step_m = to_top_m(self.viewer(), ray) / STEPS as f32;
        let mut depths = Vec3A::ZERO;
        let mut sums = [0.0f32; LINES];
        for i in 0..STEPS {
            let p = self.viewer() + ray * (step_m * (i as f32 + 0.5));
            let here = self.densities * densities(height_m(p));
            depths += here * step_m;
            if meets_ground(p, sun) {
                continue;
            }
            let all = depths + self.densities * depths_m(p, sun);
            for (sum, line) in sums.iter_mut().zip(&SPECTRUM) {
                let lost = all.dot(Vec3A::new(line.air, AEROSOL_EXTINCTION, line.ozone));
                let scattered = air_phase * here.x * line.air + aerosol_phase * here.y * AEROSOL_PER_M;
                *sum += (-lost).exp() * scattered;
            }
        }
        let mut sums = sums.into_iter();
        xyz(|line| sums.next().unwrap_or_default() * line.sun * step_m)
    }

    /// The sun's disc at its lowest and highest point, as XYZ: nothing below the horizon.
    pub(super) fn sun(&self, elevation_rad: f32, diameter_rad: f32) -> [Vec3A; 2] {
        let solid_angle = 2.0 * PI * (1.0 - (0.5 * diameter_rad).cos());
        if elevation_rad + 0.5 * diameter_rad <= 0.0 {
            return [Vec3A::ZERO; 2];
        }
        [-0.5, 0.5].map(|half| {
            let elevation_rad = (elevation_rad + half * diameter_rad).max(0.0);
            let depths = self.densities * depths_m(self.viewer(), direction(elevation_rad, 0.0));
            // Blender leaves the ozone out here.
            xyz(|line| line.sun * (-depths.x * line.air - depths.y * AEROSOL_EXTINCTION).exp() / solid_angle)
        })
    }
}

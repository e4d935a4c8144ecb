//! Sunlight scattered many times on its way through the air.
//!
//! The model is Fernando García Liñán's ("Spectral sky", 2024: <https://fgarlin.com/posts/2024-12-06-spectral_sky/>), which
//! Blender 5 uses (intern/sky): four wavelengths that sum up the visible ones, and a fit for all light that has been scattered
//! before. Its numbers are kept, so that the same sky appears. Lengths are kilometres.

use super::panorama::{Panorama, RowPlace};
use glam::{Vec3A, Vec4};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

const GROUND_RADIUS_KM: f32 = 6_371.0;
const THICKNESS_KM: f32 = 100.0;
const TOP_RADIUS_KM: f32 = GROUND_RADIUS_KM + THICKNESS_KM;
const STEPS: usize = 64;
/// Columns and rows of the table of transmittances.
const TABLE: [usize; 2] = [256, 64];
/// Forward scattering of aerosols.
const ASYMMETRY: f32 = 0.8;
const GROUND_ALBEDO: f32 = 0.3;

// At 630, 560, 490 and 430 nm. Coefficients are per kilometre.
const SUN: Vec4 = Vec4::new(1.679, 1.828, 1.986, 1.307);
const AIR: Vec4 = Vec4::new(6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2);
const OZONE: Vec4 = Vec4::new(3.472e-25, 3.914e-25, 1.349e-25, 1.103e-26);
const OZONE_DOBSON: f32 = 334.5;
const AEROSOL_ABSORBS: Vec4 = Vec4::new(2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23);
const AEROSOL_SCATTERS: Vec4 = Vec4::new(1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22);
const AEROSOLS: f32 = 1.3681e20;
const AEROSOLS_EVERYWHERE: f32 = 2e6;
const AEROSOL_SCALE_KM: f32 = 0.73;
/// The light of further scatterings, over the sun's.
const FURTHER: Vec4 = Vec4::new(0.217, 0.347, 0.594, 1.0);
/// The XYZ of the four.
const OBSERVER: [Vec3A; 4] = [
    Vec3A::new(53.386_917, 22.981_338, 0.0),
    Vec3A::new(43.904_845, 71.347_8, 0.102_506_87),
    Vec3A::new(1.613_727_8, 18.422_96, 31.742_92),
    Vec3A::new(20.762_669, 2.361_421_3, 110.480_095),
];

fn xyz(spectrum: Vec4) -> Vec3A {
    OBSERVER.iter().zip(spectrum.to_array()).map(|(observer, part)| *observer * part).sum()
}

fn exp(v: Vec4) -> Vec4 {
    v.exp()
}

/// Coefficients of scattering and extinction at a height, per kilometre.
struct Matter {
    air: Vec4,
    aerosol: Vec4,
    extinction: Vec4,
}

/// Distance to a sphere around the Earth's middle, if the ray hits it.
fn to_sphere_km(p: Vec3A, direction: Vec3A, radius_km: f32) -> Option<f32> {
    let (along, above) = (p.dot(direction), p.dot(p) - radius_km * radius_km);
    if above > 0.0 && along > 0.0 {
        return None;
    }
    let under_root = along * along - above;
    if under_root < 0.0 {
        return None;
    }
    let root = under_root.sqrt();
    Some(if above <= 0.0 { root - along } else { -root - along })
}

/// The direction towards the sun, whose azimuth is that of -x.
fn towards(cos_zenith: f32) -> Vec3A {
    Vec3A::new(-(1.0 - cos_zenith * cos_zenith).max(0.0).sqrt(), 0.0, cos_zenith)
}

/// An atmosphere: shares of the Earth's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    /// Densities of molecules, aerosols and ozone.
    densities: Vec3A,
    altitude_km: f32,
}

impl Air {
    pub(super) fn new(densities: Vec3A, altitude_m: f32) -> Self {
        Self { densities, altitude_km: altitude_m.clamp(1.0, 99_999.0) / 1000.0 }
    }

    fn matter(&self, height_km: f32) -> Matter {
        let log = height_km.max(1e-4).ln();
        let ozone = 3.785_474e20 * (-(log - 3.226_61).powi(2) * 5.555_556 - log).exp();
        let aerosols = AEROSOLS * (-height_km / AEROSOL_SCALE_KM).exp() + AEROSOLS_EVERYWHERE;
        let aerosols = aerosols * self.densities.y;
        let air = AIR * (-0.077_719_71 * height_km.powf(1.163_642_4)).exp() * self.densities.x;
        let absorbed = OZONE * (OZONE_DOBSON * ozone * self.densities.z) + AEROSOL_ABSORBS * aerosols;
        let aerosol = AEROSOL_SCATTERS * aerosols;
        Matter { air, aerosol, extinction: air + aerosol + absorbed }
    }

    /// Transmittance from the sun to a height.
    fn transmittance(&self, cos_zenith: f32, height_km: f32) -> Vec4 {
        let (p, ray) = (Vec3A::new(0.0, 0.0, GROUND_RADIUS_KM + height_km), towards(cos_zenith));
        let step_km = to_sphere_km(p, ray, TOP_RADIUS_KM).unwrap_or(-1.0) / STEPS as f32;
        let lost = |i: usize| {
            let height_km = (p + ray * (step_km * (i as f32 + 0.5))).length() - GROUND_RADIUS_KM;
            self.matter(height_km.max(0.0)).extinction * step_km
        };
        exp(-(0..STEPS).map(lost).sum::<Vec4>())
    }

    /// The sun's disc at its lowest and highest point, as XYZ.
    pub(super) fn sun(&self, elevation_rad: f32, diameter_rad: f32) -> [Vec3A; 2] {
        let solid_angle = TAU * (1.0 - (0.5 * diameter_rad).cos());
        [-0.5, 0.5].map(|half| {
            let cos_zenith = (elevation_rad + half * diameter_rad).sin();
            xyz(SUN * self.transmittance(cos_zenith, self.altitude_km) / solid_angle)
        })
    }

    /// The light of the sky, and of the air before the ground.
    pub(super) fn panorama(&self, sun_elevation_rad: f32) -> Panorama {
        let table = Transmittances::new(self);
        let sun = towards(sun_elevation_rad.sin());
        let viewer = Vec3A::new(0.0, 0.0, GROUND_RADIUS_KM + self.altitude_km);
        Panorama::new(RowPlace::Middle, |azimuth_rad, elevation_rad| {
            let ((sin_e, cos_e), (sin_a, cos_a)) = (elevation_rad.sin_cos(), azimuth_rad.sin_cos());
            let ray = Vec3A::new(cos_e * cos_a, cos_e * sin_a, sin_e);
            let end = to_sphere_km(viewer, ray, GROUND_RADIUS_KM).or_else(|| to_sphere_km(viewer, ray, TOP_RADIUS_KM));
            xyz(self.scattered(&table, viewer, ray, end.unwrap_or(0.0), sun))
        })
    }

    /// Light scattered towards the viewer along a ray of so many kilometres.
    fn scattered(&self, table: &Transmittances, viewer: Vec3A, ray: Vec3A, length_km: f32, sun: Vec3A) -> Vec4 {
        let cosine = ray.dot(sun);
        let g2 = ASYMMETRY * ASYMMETRY;
        let air_phase = 3.0 / (16.0 * PI) * (1.0 + cosine * cosine);
        let aerosol_phase = (1.0 - g2) / (4.0 * PI * (1.0 + g2 - 2.0 * ASYMMETRY * cosine).powf(1.5));
        let step_km = length_km / STEPS as f32;
        let (mut sum, mut transmittance) = (Vec4::ZERO, Vec4::ONE);
        for i in 0..STEPS {
            let p = viewer + ray * (step_km * (i as f32 + 0.5));
            let radius_km = p.length();
            let height_km = (radius_km - GROUND_RADIUS_KM).max(0.0);
            let cos_zenith = p.dot(sun) / radius_km;
            let Matter { air, aerosol, extinction } = self.matter(height_km);
            let height = height_km / THICKNESS_KM;
            let direct = table.at(cos_zenith, height);
            let before = table.scattered_before(cos_zenith, height, radius_km);
            let source = SUN * (air * (direct * air_phase + before) + aerosol * (direct * aerosol_phase + before));
            let passed = exp(-extinction * step_km);
            // Within a step the source is even and the light dies away (Hillaire, SIGGRAPH 2016 course).
            sum += transmittance * (source - source * passed) / extinction.max(Vec4::splat(1e-7));
            transmittance *= passed;
        }
        sum
    }
}

/// Transmittances from the sun, by the cosine of its zenith angle and by height.
struct Transmittances(Vec<Vec4>);

impl Transmittances {
    fn new(air: &Air) -> Self {
        let [columns, rows] = TABLE;
        let at = |i: usize| {
            let cosine = (i % columns) as f32 / (columns - 1) as f32 * 2.0 - 1.0;
            air.transmittance(cosine, (i / columns) as f32 / (rows - 1) as f32 * THICKNESS_KM)
        };
        Self((0..columns * rows).into_par_iter().map(at).collect())
    }

    /// The transmittance at a height from 0, the ground, to 1.
    fn at(&self, cos_zenith: f32, height: f32) -> Vec4 {
        let [columns, rows] = TABLE;
        let x = (0.5 * cos_zenith + 0.5).clamp(0.0, 1.0) * (columns - 1) as f32;
        let y = height.clamp(0.0, 1.0) * (rows - 1) as f32;
        let row = |y: usize| {
            let at = |x: usize| self.0[y.min(rows - 1) * columns + x.min(columns - 1)];
            at(x as usize).lerp(at(x as usize + 1), x.fract())
        };
        row(y as usize).lerp(row(y as usize + 1), y.fract())
    }

    /// The light that has been scattered before, from all around: a fit, and once from the ground.
    fn scattered_before(&self, cos_zenith: f32, height: f32, radius_km: f32) -> Vec4 {
        let solid_angle = TAU * (1.0 - (1.0 - (GROUND_RADIUS_KM / radius_km).powi(2)).max(0.0).sqrt());
        let from_ground = self.at(1.0, 0.0) / self.at(1.0, height);
        let ground =
            self.at(cos_zenith, 0.0) * from_ground * (solid_angle / (4.0 * PI) * GROUND_ALBEDO / PI * cos_zenith);
        ground + FURTHER * (0.02 / (1.0 + 5.0 * (-17.92 * cos_zenith).exp()))
    }
}

//! A sky computed from the constituents of the air: a table of its light, and the sun's disc.

use super::panorama::{Panorama, RowPlace};
use super::{SunDisc, multiple_scattering, single_scattering};
use crate::spectral::rec709;
use glam::Vec3A;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::{Arc, Mutex};

/// Number of scatterings of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScatteringOrders {
    /// Single scattering, as Blender 4 tabulates it or as Blender 5 does.
    Once {
        /// True for Blender 4's tables, false for Blender 5's.
        older: bool,
    },
    /// Light after one scattering or more.
    Multiple,
}

/// The settings of a Sky Texture node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AtmosphereSettings {
    pub(crate) scattering: ScatteringOrders,
    pub(crate) sun_disc: bool,
    pub(crate) sun_diameter_rad: f32,
    pub(crate) sun_intensity: f32,
    pub(crate) sun_elevation_rad: f32,
    /// Rotation of the sun from +y towards +x.
    pub(crate) sun_rotation_rad: f32,
    pub(crate) altitude_m: f32,
    /// Densities of molecules, aerosols and ozone, over the Earth's.
    pub(crate) densities: [f32; 3],
}

#[derive(Clone, Debug)]
pub(crate) struct Atmosphere {
    settings: AtmosphereSettings,
    sun: Vec3A,
    table: Arc<Panorama>,
    /// The disc's lowest and highest point, XYZ.
    disc: [Vec3A; 2],
    /// The elevation of the horizon, which hides the sun.
    horizon_rad: f32,
}

/// The values that the tables depend on: the kind, the sun's elevation, altitude, densities.
type Key = (ScatteringOrders, [f32; 5]);

/// The last tables made: a sync after a change elsewhere need not wait for them. Newest last.
static TABLES: Mutex<Vec<(Key, Arc<Panorama>)>> = Mutex::new(Vec::new());
const KEPT: usize = 4;

impl Atmosphere {
    pub(crate) fn new(mut settings: AtmosphereSettings) -> Self {
        // A sun beyond the zenith stands on the other side.
        let mut elevation = (settings.sun_elevation_rad + PI).rem_euclid(TAU) - PI;
        if elevation.abs() > FRAC_PI_2 {
            elevation = PI.copysign(elevation) - elevation;
            settings.sun_rotation_rad += PI;
        }
        settings.sun_elevation_rad = elevation;
        let (sin_e, cos_e) = elevation.sin_cos();
        let (sin_r, cos_r) = settings.sun_rotation_rad.sin_cos();
        let diameter = settings.sun_diameter_rad;
        let densities = Vec3A::from(settings.densities);
        let disc = match settings.scattering {
            ScatteringOrders::Multiple => {
                multiple_scattering::Air::new(densities, settings.altitude_m).sun(elevation, diameter)
            }
            ScatteringOrders::Once { older } => once(densities, settings.altitude_m, older).sun(elevation, diameter),
        };
        // The Earth of the multiple scattering, for both.
        let height_km = settings.altitude_m / 1000.0;
        let horizon_rad = (6_371.0 / (6_371.0 + height_km)).min(1.0).asin() - FRAC_PI_2;
        let sun = Vec3A::new(cos_e * sin_r, cos_e * cos_r, sin_e);
        Self { settings, sun, table: table(&settings), disc, horizon_rad }
    }

    /// The sun; `None` if its disc is not to be seen.
    pub(super) fn sun(&self) -> Option<SunDisc> {
        let AtmosphereSettings { sun_disc, sun_diameter_rad, .. } = self.settings;
        sun_disc.then_some(SunDisc { direction: self.sun, diameter_rad: sun_diameter_rad })
    }

    pub(super) fn at(&self, direction: Vec3A, with_sun: bool) -> Vec3A {
        let direction = direction.normalize_or(Vec3A::Z);
        let elevation_rad = direction.z.clamp(-1.0, 1.0).asin();
        let azimuth_rad = direction.x.atan2(direction.y) - self.settings.sun_rotation_rad + PI;
        let scattering = self.settings.scattering;
        let sky = if direction.z < 0.0 && scattering == (ScatteringOrders::Once { older: true }) {
            // The table has only the horizon, which fades out; where it fades, 5's table is read as roughly as it is made.
            rec709(self.table.at_row(azimuth_rad, 0.508)).max(Vec3A::ZERO) * (1.0 + 2.5 * direction.z).max(0.0).powi(3)
        } else {
            rec709(self.table.at(azimuth_rad, elevation_rad)).max(Vec3A::ZERO)
        };
        let hidden = direction.z < 0.0 && scattering != ScatteringOrders::Multiple;
        if with_sun && self.settings.sun_disc && !hidden { sky + self.disc_at(direction, elevation_rad) } else { sky }
    }

    fn disc_at(&self, direction: Vec3A, elevation_rad: f32) -> Vec3A {
        let AtmosphereSettings { sun_diameter_rad, sun_intensity, sun_elevation_rad, .. } = self.settings;
        // The cosine of so small an angle has too few digits.
        let angle_rad = 2.0 * (0.5 * (direction - self.sun).length()).min(1.0).asin();
        let from_middle = angle_rad / (0.5 * sun_diameter_rad);
        if !(from_middle < 1.0 && elevation_rad > self.horizon_rad) {
            return Vec3A::ZERO;
        }
        let height = (elevation_rad - sun_elevation_rad) / sun_diameter_rad + 0.5;
        let limb = 1.0 - 0.6 * (1.0 - (1.0 - from_middle * from_middle).sqrt());
        rec709(self.disc[0].lerp(self.disc[1], height)).max(Vec3A::ZERO) * (limb * sun_intensity)
    }
}

fn once(densities: Vec3A, altitude_m: f32, older: bool) -> single_scattering::AirContents {
    single_scattering::AirContents::new(
        densities,
        altitude_m,
        if older { RowPlace::CornerBeyond } else { RowPlace::Corner },
    )
}

fn table(settings: &AtmosphereSettings) -> Arc<Panorama> {
    let AtmosphereSettings { scattering, sun_elevation_rad, altitude_m, densities: [air, aerosol, ozone], .. } =
        *settings;
    let key = (scattering, [sun_elevation_rad, altitude_m, air, aerosol, ozone]);
    let lock = || TABLES.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    if let Some((_, table)) = lock().iter().find(|(of, _)| *of == key) {
        return table.clone();
    }
    let densities = Vec3A::from(settings.densities);
    let made = Arc::new(match scattering {
        ScatteringOrders::Multiple => multiple_scattering::Air::new(densities, altitude_m).panorama(sun_elevation_rad),
        ScatteringOrders::Once { older } => once(densities, altitude_m, older).panorama(sun_elevation_rad),
    });
    let mut tables = lock();
    if tables.len() >= KEPT {
        tables.remove(0);
    }
    tables.push((key, made.clone()));
    made
}

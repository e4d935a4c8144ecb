//! The lens seen from the scene: the points that light paths aim at, and the light that arrives at the film.
//!
//! Rays are counted per unit of etendue in render space: Blender units squared times steradians at right angles to the
//! ray. One sample of the camera and one light path belong to each pixel; their densities are those of a single one,
//! with the pixel left to chance, so that both can be compared.

use super::real_lens::RealLens;
use super::real_lens::packet::{HeroSample, Splats};
use crate::sampler::raster::Raster;
use glam::{DVec3, Vec3A};
use petzval_optics::trace::Ray as LensRay;

/// The contribution of a ray from the scene to the picture.
#[derive(Clone, Copy, Debug)]
pub struct Landed {
    /// Contributions of radiance along the ray to pixels, for each unit of etendue, when each pixel has one light path.
    pub splats: Splats,
    /// The density, per unit of etendue, with which the camera leads to this ray.
    pub density: f64,
}

impl RealLens {
    /// True if light paths can end in this lens: world and lens space are similar.
    pub fn takes_light_paths(&self) -> bool {
        self.mount.scale().is_some()
    }

    /// Prepares the data that every light path needs.
    pub fn prepare_for_light_paths(&self) {
        self.entrance();
    }

    /// The middle of the entrance pupil, render space.
    pub fn entrance_at(&self) -> Vec3A {
        self.mount.to_render(&LensRay { origin: self.entrance().middle(), direction: DVec3::Z }).origin
    }

    /// A direction from a point to the lens, chosen by `u`, and its density per steradian; render space.
    pub fn aim(&self, from: Vec3A, u: [f32; 2]) -> Option<(Vec3A, f32)> {
        let aim = self.entrance().sample(self.mount.to_lens(from.as_dvec3()), u.map(f64::from))?;
        Some((self.mount.direction_to_render(aim.direction).as_vec3a(), aim.pdf_per_sr as f32))
    }

    /// The density per steradian with which [`Self::aim`] chooses a direction from a point.
    pub fn aim_pdf(&self, from: Vec3A, direction: Vec3A) -> f32 {
        let place = self.mount.to_lens(from.as_dvec3());
        self.entrance().pdf(place, self.mount.direction_to_lens(direction.as_dvec3())) as f32
    }

    /// Millimetres of the lens in a Blender unit, where all axes have one scale.
    pub fn scale_mm(&self) -> f64 {
        self.mount.scale().unwrap_or(1.0)
    }

    /// A point of render space in lens space, mm: light comes along +z.
    pub fn in_lens_space(&self, point: Vec3A) -> DVec3 {
        self.mount.to_lens(point.as_dvec3())
    }

    /// Number of sets of wavelengths to choose from.
    pub fn sets(&self) -> usize {
        self.spectrum.sets()
    }

    /// The distance from `from` to the lens of a ray that was aimed at it, Blender units: to the plane of the first vertex, or to the point
    /// where the ray passes it by.
    pub fn distance_from(&self, from: Vec3A, direction: Vec3A) -> f32 {
        let place = self.mount.to_lens(from.as_dvec3());
        let along = self.mount.direction_to_lens(direction.as_dvec3());
        let to_plane = -place.z / along.z;
        let passing = -place.dot(along);
        // Rays of a fisheye may come from the side, or from behind.
        let mm = if along.z > 0.1 && to_plane > 0.0 { to_plane } else { passing };
        (mm.max(0.0) / self.mount.scale().unwrap_or(1.0)) as f32
    }

    /// Carries a ray of render space to the film at the wavelengths of a set; `None` where no light arrives at all.
    pub fn land(
        &self,
        set: usize,
        from: Vec3A,
        direction: Vec3A,
        raster: &Raster,
        u_pixels: [f32; 2],
    ) -> Option<Landed> {
        let origin = self.mount.to_lens(from.as_dvec3());
        let ray = LensRay { origin, direction: self.mount.direction_to_lens(direction.as_dvec3()) };
        let arrivals = self.arrivals(set, ray, raster, u_pixels);
        let per_etendue = self.per_etendue();
        let density: f64 = arrivals.iter().flatten().map(|a| a.density).sum();
        if arrivals.iter().all(Option::is_none) {
            return None;
        }
        let splats = Splats::new(&arrivals, set, self.spectrum.sets(), per_etendue as f32);
        Some(Landed { splats, density: density * per_etendue })
    }

    /// The density per unit of etendue of a ray that a wavelength of its set led to.
    pub fn led_density(&self, led: &HeroSample) -> f64 {
        led.density * self.per_etendue()
    }

    /// Factor from densities per mm² sr, for each pixel and the sum of a set's wavelengths, to those of render space, for the whole picture
    /// and the mean of the wavelengths.
    fn per_etendue(&self) -> f64 {
        let scale = self.mount.scale().unwrap_or(1.0);
        let picture_mm2 = self.mount.info.picture_width_mm * self.mount.info.picture_height_mm;
        scale * scale / (picture_mm2 * self.packet_size() as f64)
    }
}

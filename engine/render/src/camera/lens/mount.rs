//! The lens and its film in the world: from picture to film, from lens space to render space, and back.

use super::setup::{LensInfo, Setup};
use crate::accel::Ray;
use crate::camera::{CameraDescription, CameraError};
use glam::{DMat3, DVec3, Vec2};
use petzval_optics::focus::{FilmFrame, FilmPlane, FilmPoint};
use petzval_optics::system::System;
use petzval_optics::trace::Ray as LensRay;

/// A film behind a lens, and the places of both.
pub(in crate::camera) struct Mount {
    pub(in crate::camera) info: LensInfo,
    pub(in crate::camera) film: FilmPlane,
    pub(in crate::camera) frame: FilmFrame,
    /// Lens space to render space.
    axes: DMat3,
    origin_z_mm: f64,
    per_unit: DVec3,
    /// The matrix of vectors from lens space to render space, with its scale.
    vectors: DMat3,
}

impl Mount {
    /// The mount of a camera, and the lens that was set up for it.
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<(Self, System), CameraError> {
        let Setup { info, system, film, origin_z_mm } = Setup::new(d, width, height)?;
        let frame = film.frame();
        let per_unit = d.scale_mm_per_unit;
        let vectors = axes * DMat3::from_diagonal(per_unit.recip());
        Ok((Self { info, film, frame, axes, origin_z_mm, per_unit, vectors }, system))
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        &self.axes
    }

    /// Vectors of lens space to render space, with its scale.
    pub(in crate::camera) fn vectors(&self) -> &DMat3 {
        &self.vectors
    }

    /// The z in lens space, mm, of the point that stands at the camera's origin.
    pub(in crate::camera) fn origin_z_mm(&self) -> f64 {
        self.origin_z_mm
    }

    /// The film point of a picture point, lens space: the picture on the film is turned by half a turn.
    #[inline]
    pub(in crate::camera) fn film_at(&self, p: Vec2) -> FilmPoint {
        self.frame.at(-p.x as f64 * self.info.picture_width_mm, -p.y as f64 * self.info.picture_height_mm)
    }

    /// The picture point where a ray from the lens hits the film.
    #[inline]
    pub(in crate::camera) fn picture_point(&self, ray: &LensRay) -> Option<Vec2> {
        let [u, v] = self.frame.meet(ray)?;
        Some(Vec2::new((-u / self.info.picture_width_mm) as f32, (-v / self.info.picture_height_mm) as f32))
    }

    /// Millimetres of lens space in a unit of render space; `None` if they differ between the axes.
    #[inline]
    pub(in crate::camera) fn scale(&self) -> Option<f64> {
        let s = self.per_unit;
        (s.x == s.y && s.y == s.z).then_some(s.x)
    }

    /// A direction of render space in lens space, where all axes have one scale.
    pub(in crate::camera) fn direction_to_lens(&self, d: DVec3) -> DVec3 {
        (self.axes.transpose() * d).normalize()
    }

    /// A direction of lens space, where all axes have one scale, in render space.
    pub(in crate::camera) fn direction_to_render(&self, d: DVec3) -> DVec3 {
        (self.axes * d).normalize()
    }

    /// A ray in front of the lens, from lens space to render space: camera space has the lens's axes, with the anchor of
    /// the focus as origin.
    #[inline]
    pub(in crate::camera) fn to_render(&self, ray: &LensRay) -> Ray {
        let origin = self.vectors * (ray.origin - DVec3::new(0.0, 0.0, self.origin_z_mm));
        let direction = match self.scale() {
            Some(_) => self.axes * ray.direction,
            None => (self.vectors * ray.direction).normalize(),
        };
        Ray::new(origin.as_vec3a(), direction.as_vec3a())
    }

    /// A point of render space in lens space.
    pub(in crate::camera) fn to_lens(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * point * self.per_unit + DVec3::new(0.0, 0.0, self.origin_z_mm)
    }

    /// Puts another film behind the lens, and another point of the axis at the camera's origin. Of `info` nothing changes
    /// but by [`Setup::new`].
    pub(in crate::camera) fn refocus(&mut self, film: FilmPlane, origin_z_mm: f64) {
        (self.film, self.frame, self.origin_z_mm) = (film, film.frame(), origin_z_mm);
    }
}

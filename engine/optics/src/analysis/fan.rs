//! Fans: transverse aberrations of the rays of a line across the pupil, from the ray through its middle, and their optical path
//! differences.

use glam::{DVec2, DVec3};

use super::wavefront::Eikonal;
use super::{Analysis, FieldView};
use crate::paraxial::Paraxial;

/// The two fans of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct Fans {
    /// Angle of the field from the axis, counted at the entrance pupil.
    pub angle_deg: f64,
    /// The fan across the pupil in the plane of the field.
    pub tangential: Vec<FanLine>,
    /// The fan across the pupil at right angles to the plane of the field.
    pub sagittal: Vec<FanLine>,
}

/// A fan in one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct FanLine {
    /// The wavelength in vacuum.
    pub wavelength_nm: f64,
    /// The rays, by rising place in the pupil.
    pub rays: Vec<FanRay>,
}

/// A ray of a fan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FanRay {
    /// The place at which it hits the stop, in radii of its opening, along the fan.
    pub pupil: f64,
    /// The place at which it hits the film, along the fan: the tangential part of a tangential fan, the sagittal one of the other; from
    /// the ray of the main wavelength through the middle of the stop.
    pub error_mm: f64,
    /// Path difference to the middle ray of the same wavelength, in wavelengths: to the sphere through the middle of the exit pupil whose
    /// centre is that ray's hit on the film, the plane at infinity if the exit pupil is there.
    pub path_waves: f64,
}

impl Analysis<'_> {
    /// The fans of a field, of rays at `count` places evenly over the beam's window that come through.
    ///
    /// `None`: no ray goes through the middle of the stop to the film.
    pub fn fans(&self, angle_deg: f64, count: usize) -> Option<Fans> {
        let view = self.view(angle_deg)?;
        let [tangential, sagittal] = [DVec2::Y, DVec2::X].map(|axis| self.fan(&view, axis, count));
        Some(Fans { angle_deg, tangential: tangential?, sagittal: sagittal? })
    }

    /// A fan along an axis of the field's plane, whose y lies in the plane of the field.
    fn fan(&self, view: &FieldView, axis: DVec2, count: usize) -> Option<Vec<FanLine>> {
        let frame = self.film.frame();
        let middle = DVec2::from(frame.meet(&self.chief_out(self.main, view)?)?);
        let of_line = |line: usize| {
            let probe = &self.lines[line].probe;
            let chief = self.chief(line, view)?;
            let own = DVec2::from(frame.meet(&self.chief_out(line, view)?)?);
            let touching = self.touching(own);
            let eikonal = Eikonal::new(self.system, &self.lines[line].tracer, touching);
            // The middle ray's way is taken whether it comes through or not.
            let whole = Eikonal::new(self.system, &probe.tracer, touching);
            let start = whole.of(probe.origin.ray(&view.field, chief))?.path_mm;
            let pupil = Paraxial::new(self.system, self.lines[line].wavelength_nm).exit_pupil.z_mm;
            let from_pupil = |z: f64| {
                let way = touching.point - DVec3::Z * z;
                way.length().copysign(way.z * self.system.light_direction_at_film())
            };
            let radius_mm = pupil.map_or(f64::INFINITY, from_pupil);
            let ray = |i: usize| {
                let unit = if count < 2 { 0.0 } else { 2.0 * i as f64 / (count - 1) as f64 - 1.0 };
                // Across the middle of the stop, as far as the window goes.
                let at = view.window.centre + view.window.half * unit;
                let at = chief + axis * (at - chief).dot(axis);
                let stop = probe.pass(&view.field, at).ok()?.stop;
                let found = eikonal.of(probe.origin.ray(&view.field, at))?;
                let landing = DVec2::from(frame.meet(&found.out)?);
                Some(FanRay {
                    pupil: self.turned(stop).dot(axis),
                    error_mm: self.turned(landing - middle).dot(axis),
                    path_waves: (found.to_sphere_mm(radius_mm) - start) / (self.lines[line].wavelength_nm * 1e-6),
                })
            };
            let rays = (0..count).filter_map(ray).collect();
            Some(FanLine { wavelength_nm: self.lines[line].wavelength_nm, rays })
        };
        (0..self.lines.len()).map(of_line).collect()
    }
}

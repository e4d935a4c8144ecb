//! The surface of the scene that is sharp, as a map from the picture: where rays are aimed at that start in the scene.
//!
//! The surface serves to choose rays, so it need not be where the lens is sharpest; it must cover the field of view, no place twice,
//! and its density must be known exactly. A film point is projected through the exit pupil onto an upright film; the chief rays give the
//! angle from the axis at which the lens sees a point there, by its distance from the axis; and in that direction the surface lies at the
//! distance that is focused on: a plane, far off the axis a ball.

use super::beam;
use super::mount::Mount;
use glam::{DVec2, DVec3, Vec2};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::surface::Section;
use petzval_optics::system::System;
use petzval_optics::trace::Tracer;

/// Distances from the axis at which chief rays are traced.
const NODES: usize = 96;
/// Rays whose mean is a chief ray.
const RAYS: u32 = 48;
/// Radius of the map, as a multiple of the picture's half diagonal.
const BEYOND: f64 = 1.4;
/// Distance of the surface of a lens that is focused at infinity, focal lengths.
const FAR: f64 = 1e4;
/// The plane ends where the cosine of the angle from the axis falls below this.
const PLANE_ENDS: f64 = 0.3;

/// The map of the surface that is in focus.
pub(in crate::camera) struct FocalSurface {
    /// Directions are counted from here: the entrance pupil's middle.
    middle: DVec3,
    /// The exit pupil's middle; `None` if it is at infinity.
    exit: Option<DVec3>,
    film_z: f64,
    /// Factor of the film's x, so that the lens sees all azimuths alike: not 1 for anamorphic lenses.
    squeeze: f64,
    /// Distance between the nodes, mm on the film.
    step: f64,
    /// Angle from the axis by node, rad, counted to the side on which the film point lies; and its slope, rad per mm.
    angles: Vec<[f64; 2]>,
    /// Distance of the plane from the middle, mm.
    distance: f64,
}

/// A point of the surface.
#[derive(Clone, Copy, Debug)]
pub(in crate::camera) struct FocalPoint {
    /// The point, lens space, mm.
    pub(in crate::camera) point: DVec3,
    /// Element of the surface for one of the film, as a vector along its normal.
    pub(in crate::camera) area_per_film_area: DVec3,
}

impl FocalSurface {
    /// The map of a lens, its film and its pupil. `middle` is the entrance pupil's.
    pub(in crate::camera) fn new(
        mount: &Mount,
        system: &System,
        tracer: &Tracer,
        map: &PupilMap,
        middle: DVec3,
    ) -> Self {
        let nm = tracer.wavelength_nm();
        let efl = |section| Paraxial::in_section(system, section, nm).efl_mm.map(f64::abs);
        let squeeze = match (efl(Section::X), efl(Section::Y)) {
            (Some(x), Some(y)) if x > 0.0 && y > 0.0 => y / x,
            _ => 1.0,
        };
        let film_z = mount.film.z_mm;
        let size = mount.info.viewport_focal_length_mm;
        let distance = mount.info.focus_distance_mm.filter(|d| *d < FAR * size).unwrap_or(FAR * size).abs();
        // As far as the picture reaches when it is projected on the upright film.
        let exit = Paraxial::new(system, nm).exit_pupil.z_mm.map(|z| DVec3::new(0.0, 0.0, z));
        let mut surface = Self { middle, exit, film_z, squeeze, step: 1.0, angles: vec![[0.0; 2]; NODES], distance };
        let corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)];
        let radius =
            |(x, y): (f32, f32)| surface.flat(mount.film_at(Vec2::new(x, y)).point).map_or(0.0, |(p, _)| p.length());
        let farthest = corners.into_iter().map(radius).fold(0.0, f64::max);
        surface.step = BEYOND * farthest / (NODES - 1) as f64;
        surface.trace(tracer, map);
        surface
    }

    /// The angle of each node by the mean of the rays that get through.
    fn trace(&mut self, tracer: &Tracer, map: &PupilMap) {
        let mut seen: Vec<Option<f64>> = Vec::with_capacity(NODES);
        for node in 0..NODES {
            // Along y: there the film is not squeezed.
            let film = DVec3::new(0.0, self.step * node as f64, self.film_z);
            let through = beam::through(tracer, map, film, RAYS);
            seen.push(beam::mean(through.iter()).map(|ray| {
                let at = ray.origin + ray.direction * self.distance - self.middle;
                at.y.atan2(-at.z)
            }));
        }
        // Strictly onwards, to the side that the second node says, also through what is dark: no direction twice.
        let side = seen[1..].iter().flatten().find(|a| a.abs() > 1e-6).map_or(-1.0, |a| a.signum());
        let least = 1e-6 * self.step / self.distance.min(1e6);
        let mut last = [0.0f64; 2];
        for (node, angle) in seen.into_iter().enumerate().skip(1) {
            let on = last[0] + last[1].max(least);
            let angle = angle.map_or(on, |a| (a * side).max(last[0] + least)).min(3.1);
            last = [angle, angle - last[0]];
            self.angles[node][0] = angle * side;
        }
        // Slopes by the harmonic mean of those on both sides: the curve stays monotone (Fritsch and Butland 1984).
        let rises: Vec<f64> = self.angles.windows(2).map(|w| (w[1][0] - w[0][0]) / self.step).collect();
        let rise = |i: usize| rises[i];
        for node in 0..NODES {
            let slope = match node {
                0 => rise(0),
                n if n == NODES - 1 => rise(n - 1),
                n if rise(n - 1) * rise(n) > 0.0 => 2.0 * rise(n - 1) * rise(n) / (rise(n - 1) + rise(n)),
                _ => 0.0,
            };
            self.angles[node][1] = slope;
        }
    }

    /// A film point on the upright film, and the magnification of areas there.
    fn flat(&self, film_point: DVec3) -> Option<(DVec2, f64)> {
        let squeezed = |p: DVec3| DVec2::new(p.x * self.squeeze, p.y);
        let Some(exit) = self.exit.filter(|exit| (exit.z - self.film_z).abs() > 1e-6) else {
            return Some((squeezed(film_point), self.squeeze));
        };
        let from = film_point - exit;
        let scale = (self.film_z - exit.z) / from.z;
        let larger = scale * scale * self.squeeze;
        (scale > 0.0 && scale.is_finite()).then(|| (squeezed(exit + from * scale), larger))
    }

    /// The point that is sharp at a film point, both in lens space; `normal` is the film's. `None` where the map ends.
    pub(in crate::camera) fn point(&self, film_point: DVec3, normal: DVec3) -> Option<FocalPoint> {
        let (flat, larger) = self.flat(film_point)?;
        // The projected element stands upright: of a turned film's, its share along the line through the pupil.
        let tilt = match self.exit {
            Some(exit) => {
                let from = film_point - exit;
                (normal.dot(from) / from.z).abs()
            }
            None => normal.z.abs(),
        };
        let radius = flat.length();
        let place = radius / self.step;
        let node = place as usize;
        let [[a, slope_a], [b, slope_b]] = [*self.angles.get(node)?, *self.angles.get(node + 1)?];
        // Cubic Hermite.
        let (t, h) = (place - node as f64, self.step);
        let (rise, da, db) = (b - a, slope_a * h, slope_b * h);
        let (c2, c3) = (3.0 * rise - 2.0 * da - db, da + db - 2.0 * rise);
        let angle = a + t * (da + t * (c2 + t * c3));
        let slope = (da + t * (2.0 * c2 + t * 3.0 * c3)) / h;
        let (sin, cos) = angle.sin_cos();
        let sin_by_radius = if radius > 1e-9 * self.step { sin / radius } else { slope };
        let radial = if radius > 0.0 { flat / radius } else { DVec2::Y };
        let towards = (radial * sin).extend(-cos);
        let steradians = (sin_by_radius * slope).abs() * larger * tilt;
        // The plane, then the ball that goes on from its edge: the distance's slope over itself is the tangent, then 0.
        let (far, tangent) = match cos > PLANE_ENDS {
            true => (self.distance / cos, sin / cos),
            false => (self.distance / PLANE_ENDS, 0.0),
        };
        let outwards = (radial * cos).extend(sin);
        Some(FocalPoint {
            point: self.middle + towards * far,
            area_per_film_area: (towards - outwards * tangent) * (far * far * steradians),
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::camera::{Camera, CameraDescription, tests};

    /// The element of the surface is the area that neighbouring points span, on upright and turned films.
    #[test]
    fn elements_are_what_neighbours_span() {
        for (file, width_mm, tilt) in [
            ("wide-angle-smith-f3.4.lens", 36.0, 0.0),
            ("wide-angle-smith-f3.4.lens", 36.0, 0.3),
            ("laikin-fisheye-170.lens", 8.0, 0.0),
            ("anamorphic-2x-double-gauss.lens", 24.0, 0.1),
            ("reflex-nikkor-500-f8.lens", 36.0, 0.0),
        ] {
            let height_mm = width_mm / 1.5;
            // One wavelength: the surface is that of the one that is sharp.
            let d = tests::with_lens(file, width_mm, height_mm, tilt);
            let d = CameraDescription { wavelength_nm: Some(587.6), ..d };
            let camera = Camera::new(&d, 300, 200).unwrap();
            let lens = camera.traced_lens().unwrap();
            let focal = lens.focal_surface();
            let film = lens.mount.film.frame();
            let at = |u: f64, v: f64| focal.point(film.at(u, v).point, film.at(u, v).normal);
            let mut compared = 0;
            for i in 0..200 {
                let [u, v] = [(f64::from(i) * 0.618).fract() - 0.5, (f64::from(i) * 0.755).fract() - 0.5];
                let [u, v] = [u * width_mm, v * height_mm];
                let h = 1e-4;
                let ends = [at(u + h, v), at(u - h, v), at(u, v + h), at(u, v - h), at(u, v)];
                let [Some(a), Some(b), Some(c), Some(d), Some(middle)] = ends else { continue };
                let span = ((a.point - b.point) / (2.0 * h)).cross((c.point - d.point) / (2.0 * h));
                let stated = middle.area_per_film_area;
                // Either way round; differences of second order, and the surface's edge between plane and ball.
                let error = (span - stated).length().min((span + stated).length()) / stated.length();
                compared += usize::from(error < 1e-4);
            }
            assert!(compared >= 195, "{file} {tilt}: {compared}");
        }
    }
}

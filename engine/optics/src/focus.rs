//! The place of the film at which a distance is sharp, and the film plane itself (Wu et al. 2011, §4).
//!
//! Conjugates are the exact paraxial ones. Distances to the scene are measured along the axis from the centre of the
//! entrance pupil, positive in front of the lens; [`Focusing`] knows of other ways to count them.

mod groups;
mod scale;

use glam::{DMat3, DVec2, DVec3};
use thiserror::Error;

use crate::first_order::{Matrix, between_vertices};
use crate::paraxial::Paraxial;
use crate::prescription::Prescription;
use crate::prescription::moving::MovingParts;
use crate::system::{LensSettings, System};
use crate::trace::Ray;

pub use groups::{Focused, GroupsError};
pub use scale::{Anchor, Focusing, Relation};

/// An error by which no film plane makes a distance sharp.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FocusError {
    /// The distance is no positive number.
    #[error("the focus distance is {distance_mm} mm; give a number larger than 0, or inf")]
    NotPositive {
        /// The focus distance that was asked for.
        distance_mm: f64,
    },
    /// Closer than the lens can focus: its image would be virtual, or the object inside of the lens.
    #[error("the focus distance is {distance_mm:.1} mm, too close for this lens; give more than {nearest_mm:.1} mm")]
    TooClose {
        /// The focus distance that was asked for.
        distance_mm: f64,
        /// Every distance beyond this one can be focused.
        nearest_mm: f64,
    },
    /// The lens diverges: it forms no real image.
    #[error("the lens forms no real image, so nothing can be focused; choose another lens or set the film's distance")]
    NoRealImage,
    /// The entrance pupil is at infinity: only infinity can be asked for.
    #[error("the entrance pupil is at infinity, so no distance can be measured from it; focus at infinity")]
    NoEntrancePupil,
}

/// The paraxial conjugates of a system at one wavelength.
struct Conjugates {
    matrix: Matrix,
    last_z_mm: f64,
    /// Signed index before the film.
    image_index: f64,
    /// Signed direction of the light before the film.
    towards_film: f64,
    pupil_z_mm: Option<f64>,
}

impl Conjugates {
    fn new(system: &System, wavelength_nm: f64) -> Self {
        let surfaces = system.thin(wavelength_nm);
        Self {
            matrix: between_vertices(&surfaces),
            last_z_mm: system.last_vertex_z_mm(),
            image_index: surfaces.last().map_or(1.0, |s| s.to),
            towards_film: system.light_direction_at_film(),
            pupil_z_mm: Paraxial::new(system, wavelength_nm).entrance_pupil.z_mm,
        }
    }

    /// Image plane of the ray that enters the first vertex plane as (y, ν).
    fn image_z_mm(&self, y: f64, nu: f64) -> f64 {
        let [y, nu] = self.matrix.apply(y, nu);
        self.last_z_mm - y / nu * self.image_index
    }

    /// Object plane in lens space of the film plane `film_z_mm`; infinite if that is the focal plane.
    fn object_z_mm(&self, film_z_mm: f64) -> f64 {
        // The ray (y, ν) on the last vertex plane that hits the film on the axis, taken back: the inverse matrix.
        let distance = (film_z_mm - self.last_z_mm) / self.image_index;
        let Matrix { a, b, c, d } = self.matrix;
        let (y, nu) = (-d * distance - b, c * distance + a);
        // A film at the focal plane to within rounding sees infinity.
        if nu.abs() <= 1e-13 * (c * distance).abs() { f64::INFINITY } else { -y / nu }
    }
}

/// The z in lens space (mm) at which the film shows the plane at `distance_from_entrance_pupil_mm` sharp.
///
/// The distance may be infinite. The object plane lies at z = entrance pupil − distance.
pub fn film_z_for_focus_mm(
    system: &System,
    wavelength_nm: f64,
    distance_from_entrance_pupil_mm: f64,
) -> Result<f64, FocusError> {
    Focusing::default().film_z_mm(system, wavelength_nm, distance_from_entrance_pupil_mm)
}

/// The distance in mm from the entrance pupil to the plane that is sharp on a film at `film_z_mm`.
///
/// Infinite if the film stands in the focal plane; negative if the plane would lie behind the entrance pupil, as it
/// does for a film inside of the focal length.
pub fn focus_distance_for_film_mm(system: &System, wavelength_nm: f64, film_z_mm: f64) -> f64 {
    let conjugates = Conjugates::new(system, wavelength_nm);
    let object_z = conjugates.object_z_mm(film_z_mm);
    match conjugates.pupil_z_mm {
        Some(pupil_z) if object_z.is_finite() => pupil_z - object_z,
        _ => f64::INFINITY,
    }
}

/// Height of the image on a film at `film_z_mm` over the height of the object in the plane that is sharp there.
///
/// Negative: upside down. 0 if the film stands in the focal plane.
pub fn magnification(system: &System, wavelength_nm: f64, film_z_mm: f64) -> f64 {
    let conjugates = Conjugates::new(system, wavelength_nm);
    let object_z = conjugates.object_z_mm(film_z_mm);
    if object_z.is_infinite() {
        return 0.0;
    }
    // The matrix from object to image has m in its corner, and the determinant 1 of its parts makes it ν-free.
    let distance = (film_z_mm - conjugates.last_z_mm) / conjugates.image_index;
    conjugates.matrix.a + distance * conjugates.matrix.c
}

/// The film and the plane that is sharp on it. In lens space, mm; on the axis, to first order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// z of the film on the axis.
    pub film_z_mm: f64,
    /// The plane that is sharp; `None`: at infinity.
    pub object_plane_mm: Option<f64>,
    /// Height of the image over that of the object, negative if upside down; 0 for an object at infinity, `None` if
    /// its image lies there too.
    pub magnification: Option<f64>,
    /// 1 / (2 n′ |u′|), u′ the slope at the film of the ray past the rim of the entrance pupil; `None` if that is 0.
    /// For an object at infinity it is the f-number.
    pub working_f_number: Option<f64>,
}

/// The lens with these settings, and its focus on a distance from the entrance pupil, mm, `None` or infinite for infinity. Groups that focus
/// move, and the film stays; without such the film moves.
///
/// # Errors
/// [`GroupsError`].
pub fn focused(
    prescription: &Prescription,
    settings: &LensSettings,
    wavelength_nm: f64,
    distance_mm: Option<f64>,
) -> Result<(System, Focus), GroupsError> {
    let by_groups = prescription.moving.as_ref().is_some_and(MovingParts::focuses);
    let system = match distance_mm.filter(|mm| by_groups && *mm != f64::INFINITY) {
        Some(mm) => Focusing::default().by_groups(prescription, settings, wavelength_nm, mm)?.system,
        None => System::new(prescription, settings)?,
    };
    let focus = Focus::new(&system, wavelength_nm, distance_mm)?;
    Ok((system, focus))
}

impl Focus {
    /// [`Self::at_distance`], or [`Self::at_infinity`] for `None` and an infinite distance.
    pub fn new(system: &System, wavelength_nm: f64, distance_mm: Option<f64>) -> Result<Self, FocusError> {
        match distance_mm.filter(|mm| *mm != f64::INFINITY) {
            Some(mm) => Self::at_distance(system, wavelength_nm, mm),
            None => Ok(Self::at_infinity(system, wavelength_nm)),
        }
    }

    /// Infinity, on the film of [`Paraxial::film_z_mm`]: also for lenses that form no real image.
    pub fn at_infinity(system: &System, wavelength_nm: f64) -> Self {
        let info = Paraxial::new(system, wavelength_nm);
        Self {
            film_z_mm: info.film_z_mm,
            object_plane_mm: None,
            magnification: info.efl_mm.map(|_| 0.0),
            working_f_number: info.f_number,
        }
    }

    /// A distance along the axis from the entrance pupil, which may be infinite, as [`film_z_for_focus_mm`] has it.
    pub fn at_distance(system: &System, wavelength_nm: f64, distance_mm: f64) -> Result<Self, FocusError> {
        let film_z_mm = film_z_for_focus_mm(system, wavelength_nm, distance_mm)?;
        let pupil = Paraxial::new(system, wavelength_nm).entrance_pupil;
        let (Some(pupil_z), true) = (pupil.z_mm, distance_mm.is_finite()) else {
            return Ok(Self { film_z_mm, ..Self::at_infinity(system, wavelength_nm) });
        };
        let surfaces = system.thin(wavelength_nm);
        let index = surfaces.first().map_or(1.0, |s| s.from);
        let working_f_number = pupil.diameter_mm.and_then(|diameter| {
            let slope = diameter / (2.0 * distance_mm);
            let [_, nu] = between_vertices(&surfaces).apply((distance_mm - pupil_z) * slope, index * slope);
            Some(0.5 / nu.abs()).filter(|f_number| f_number.is_finite())
        });
        Ok(Self {
            film_z_mm,
            object_plane_mm: Some(pupil_z - distance_mm),
            magnification: Some(magnification(system, wavelength_nm, film_z_mm)),
            working_f_number,
        })
    }
}

/// The plane that the film lies in. In lens space, mm and rad.
///
/// The film is centred on the axis at `z_mm`, turned about its own vertical axis (`swing_rad`) and then about the
/// lens's horizontal axis (`tilt_rad`), and last shifted in its own plane. Its coordinates u (right) and v (up) are
/// lens space's x and y while it is not turned. Positive tilt moves the upper edge away from the scene (towards +z),
/// positive swing the right edge towards it (−z): both turn right-handed about the axis named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmPlane {
    /// The z at which the axis intersects the film before it is shifted.
    pub z_mm: f64,
    /// Turn about the horizontal axis x.
    pub tilt_rad: f64,
    /// Turn about the vertical axis y.
    pub swing_rad: f64,
    /// The place of the picture's middle in the film's own coordinates (shift, rise).
    pub shift_mm: [f64; 2],
    /// Curvature of a ball-shaped film, a retina: one over its radius, negative if its edge lies nearer to the lens than its middle where
    /// light goes towards +z, as a lens surface's. Its coordinates u and v are those of the plane that touches it.
    pub curvature_per_mm: f64,
}

impl FilmPlane {
    /// A flat film at right angles to the axis.
    pub fn upright(z_mm: f64) -> Self {
        Self { z_mm, tilt_rad: 0.0, swing_rad: 0.0, shift_mm: [0.0; 2], curvature_per_mm: 0.0 }
    }

    fn rotation(&self) -> DMat3 {
        DMat3::from_rotation_x(self.tilt_rad) * DMat3::from_rotation_y(self.swing_rad)
    }

    /// The axes of the film worked out, for use with many points.
    pub fn frame(&self) -> FilmFrame {
        FilmFrame {
            axes: self.rotation(),
            vertex: DVec3::new(0.0, 0.0, self.z_mm),
            shift: DVec2::from(self.shift_mm),
            curvature: self.curvature_per_mm,
        }
    }

    /// The point of the film at (u, v) from the middle of the picture, in lens space.
    pub fn point(&self, u_mm: f64, v_mm: f64) -> DVec3 {
        self.frame().at(u_mm, v_mm).point
    }

    /// The unit normal of the middle that looks towards −z: to the lens, unless an odd number of mirrors sends light towards −z.
    pub fn normal(&self) -> DVec3 {
        self.rotation() * DVec3::NEG_Z
    }

    /// True if the film's points have not all the same z.
    pub fn is_uneven(&self) -> bool {
        self.tilt_rad != 0.0 || self.swing_rad != 0.0 || self.curvature_per_mm != 0.0
    }

    /// True if the film reaches to (u, v): a ball ends.
    pub fn reaches(&self, u_mm: f64, v_mm: f64) -> bool {
        let from_vertex = DVec2::new(u_mm, v_mm) + DVec2::from(self.shift_mm);
        from_vertex.length() * self.curvature_per_mm.abs() < STEEPEST
    }
}

/// A curved film ends where the sine of its slope is this: steeper parts are hardly seen from the lens.
const STEEPEST: f64 = 0.98;

/// A film's axes in lens space: [`FilmPlane::frame`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmFrame {
    /// Right, up, and away from the scene.
    axes: DMat3,
    /// The point where the axis intersects the film, and about which the film turns.
    vertex: DVec3,
    shift: DVec2,
    curvature: f64,
}

/// A point of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmPoint {
    /// The point, lens space, mm.
    pub point: DVec3,
    /// Unit normal, as [`FilmPlane::normal`].
    pub normal: DVec3,
    /// Area of the film for an area of its coordinates: 1 on a flat film.
    pub area: f64,
}

impl FilmFrame {
    /// Right, up and away from the scene, and the point (0, 0), of a film that is flat.
    pub fn flat(&self) -> Option<(DMat3, DVec3)> {
        (self.curvature == 0.0).then(|| (self.axes, self.at(0.0, 0.0).point))
    }

    /// The point at (u, v), mm from the middle of the picture. Beyond the end of a curved film: its edge.
    #[inline]
    pub fn at(&self, u_mm: f64, v_mm: f64) -> FilmPoint {
        let flat = DVec2::new(u_mm, v_mm) + self.shift;
        let c = self.curvature;
        if c == 0.0 {
            let point = self.vertex + self.axes.x_axis * flat.x + self.axes.y_axis * flat.y;
            return FilmPoint { point, normal: -self.axes.z_axis, area: 1.0 };
        }
        let flat = flat.clamp_length_max(STEEPEST / c.abs());
        let cosine = (1.0 - c * c * flat.length_squared()).sqrt();
        let sag = c * flat.length_squared() / (1.0 + cosine);
        let normal = DVec3::new(c * flat.x, c * flat.y, -cosine);
        FilmPoint {
            point: self.vertex + self.axes * flat.extend(sag),
            normal: self.axes * normal,
            area: cosine.recip(),
        }
    }

    /// The point at which a ray from the lens hits the film: its coordinates (u, v), mm. `None` if it misses it or goes away.
    #[inline]
    pub fn meet(&self, ray: &Ray) -> Option<[f64; 2]> {
        let to = self.axes.transpose();
        let (p, d) = (to * (ray.origin - self.vertex), to * ray.direction);
        let c = self.curvature;
        let t = if c == 0.0 {
            -p.z / d.z
        } else {
            // As a surface of a lens: from the ray's point nearest the vertex, on the sheet of the vertex.
            let b = c * p.dot(d) - d.z;
            let q = b * b - c * (c * p.dot(p) - 2.0 * p.z);
            (c * p.dot(p) - 2.0 * p.z) / (-b + q.sqrt().copysign(d.z))
        };
        let hit = p + d * t;
        let is_there = t > 0.0 && t.is_finite() && hit.truncate().length() * c.abs() < STEEPEST && c * hit.z < 1.0;
        is_there.then(|| (hit.truncate() - self.shift).to_array())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_to_a_film_point_meets_it_there() {
        for curvature_per_mm in [0.0, -1.0 / 30.0, 1.0 / 45.0] {
            let film =
                FilmPlane { z_mm: 30.0, tilt_rad: 0.3, swing_rad: -0.2, shift_mm: [1.0, -2.0], curvature_per_mm };
            for (u, v) in [(0.0, 0.0), (12.0, -7.0), (-18.0, 12.0)] {
                let point = film.point(u, v);
                let origin = DVec3::new(3.0, -1.0, 2.0);
                let ray = Ray { origin, direction: (point - origin).normalize() };
                let [a, b] = film.frame().meet(&ray).unwrap();
                assert!((a - u).abs() < 1e-11 && (b - v).abs() < 1e-11, "{curvature_per_mm}: {a} {b}");
                assert_eq!(film.frame().meet(&Ray { direction: -ray.direction, ..ray }), None);
            }
        }
    }

    /// Normal and area against neighbouring points; all points of a retina lie at its radius from its centre.
    #[test]
    fn a_retina_is_a_ball() {
        let film = FilmPlane { tilt_rad: 0.1, curvature_per_mm: -1.0 / 12.0, ..FilmPlane::upright(24.0) };
        let frame = film.frame();
        let centre = frame.at(0.0, 0.0).point + frame.at(0.0, 0.0).normal * 12.0;
        for (u, v) in [(0.0, 0.0), (5.0, -3.0), (-2.0, 9.0)] {
            let FilmPoint { point, normal, area } = frame.at(u, v);
            assert!(((point - centre).length() - 12.0).abs() < 1e-12);
            let h = 1e-5;
            let along = (frame.at(u + h, v).point - frame.at(u - h, v).point) / (2.0 * h);
            let up = (frame.at(u, v + h).point - frame.at(u, v - h).point) / (2.0 * h);
            let element = up.cross(along);
            assert!((element - normal * area).length() < 1e-8, "{element} {normal} {area}");
        }
        assert!(film.reaches(8.0, 8.0) && !film.reaches(9.0, 9.0));
    }
}

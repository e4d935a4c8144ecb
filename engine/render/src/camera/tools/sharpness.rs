//! The sharp distances of a camera: over the picture, the distance at which the light of a film point comes together in the scene, and from
//! where to where it stays within a circle of confusion.
//!
//! The distances follow from rays: those of a film point through all of the pupil, followed into the scene. Across their mean ray each is a
//! straight line, so their spread there is a quadratic in the distance, and the distance of its least, and those at which it comes to a
//! given size on the film, are known without a search.

use crate::camera::lens::beam;
use crate::camera::lens::mount::Mount;
use crate::camera::lens::setup::D_LINE_NM;
use crate::camera::{CameraDescription, CameraError};
use glam::{DVec2, DVec3, Vec2};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::trace::{Ray, Tracer};
use serde::Serialize;

/// Rays of a film point.
const RAYS: u32 = 192;
/// Rays of a place's neighbours, for the scale of the picture.
const NEIGHBOUR_RAYS: u32 = 48;
/// Distance of the neighbours, parts of the picture's diagonal.
const BESIDE: f64 = 1e-3;

/// The sharp range along the mean ray of a picture point. World space, Blender units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SharpPoint {
    /// Place in the picture, from -0.5 to 0.5, x to the right and y up.
    pub place: Vec2,
    /// The point where the mean ray leaves the lens.
    pub from: DVec3,
    /// Direction of the mean ray, unit.
    pub towards: DVec3,
    /// The sharpest distance along the mean ray; `None` is infinity.
    pub sharp: Option<f64>,
    /// Distance along the mean ray from which on it is sharp enough: its blur on the film, squared, is at most the sum of the squares of
    /// the circle of confusion and of the blur at the sharpest distance. `None` where all of that lies behind the camera.
    pub near: Option<f64>,
    /// Distance along the mean ray up to which it is sharp enough; infinite if everything behind is.
    pub far: Option<f64>,
}

/// The zone of sharpness of a picture, by points.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sharpness {
    /// Diameter of the circle of confusion, mm on the film.
    pub confusion_mm: f64,
    /// Row by row from below; `None` where no light comes from.
    pub points: Vec<Option<SharpPoint>>,
    /// The middle of the entrance pupil on the axis, world space.
    pub pupil: Option<DVec3>,
    /// Radii of the entrance pupil across and up, Blender units.
    pub pupil_radii: [f64; 2],
}

/// The sharp distances over a grid of so many columns and rows, the outer ones at the picture's edges; both two or more.
///
/// # Errors
/// [`CameraError`], also for cameras without a lens.
pub fn sharpness(
    d: &CameraDescription,
    size: [u32; 2],
    [columns, rows]: [usize; 2],
    confusion_mm: Option<f64>,
) -> Result<Sharpness, CameraError> {
    if !d.model.is_of_lens() {
        return Err(d.error("it has no lens to be traced; choose a camera model that is made from a lens file"));
    }
    d.check(size[0], size[1])?;
    let (mount, system) = Mount::new(d, d.axes()?, size[0], size[1])?;
    let line_nm = d.wavelength_nm.unwrap_or(D_LINE_NM);
    let tracer = system.at_wavelength(line_nm);
    let (width, height) = (mount.info.picture_width_mm, mount.info.picture_height_mm);
    let map = PupilMap::new(&tracer, &system, &mount.film, 0.5 * width, 0.5 * height);
    let diagonal = width.hypot(height);
    let confusion_mm = confusion_mm.filter(|c| *c > 0.0).unwrap_or(diagonal / 1500.0);
    let look = Look { mount: &mount, tracer: &tracer, map: &map, step: BESIDE * diagonal, confusion_mm };
    let step = |i: usize, count: usize| i as f32 / (count.max(2) - 1) as f32 - 0.5;
    let places = (0..rows * columns).map(|i| Vec2::new(step(i % columns, columns), step(i / columns, rows)));
    let world = |point: DVec3| mount.vectors() * (point - DVec3::Z * mount.origin_z_mm()) + d.position();
    let points = places.map(|place| look.at(place).map(|found| found.in_world(&mount, &world))).collect();
    let pupil = Paraxial::new(&system, line_nm).entrance_pupil;
    let radius = 0.5 * pupil.diameter_mm.unwrap_or(0.0);
    Ok(Sharpness {
        confusion_mm,
        points,
        pupil: pupil.z_mm.map(|z| world(DVec3::Z * z)),
        pupil_radii: [radius / d.scale_mm_per_unit.x, radius / d.scale_mm_per_unit.y],
    })
}

/// A lens that is looked through.
struct Look<'a> {
    mount: &'a Mount,
    tracer: &'a Tracer,
    map: &'a PupilMap,
    /// Distance between neighbours on the film, mm.
    step: f64,
    confusion_mm: f64,
}

/// The sharp distances of a place in the picture, lens space, mm.
struct SharpDistances {
    place: Vec2,
    mean: Ray,
    distances: [Option<f64>; 3],
}

impl SharpDistances {
    fn in_world(self, mount: &Mount, world: &impl Fn(DVec3) -> DVec3) -> SharpPoint {
        let from = world(self.mean.origin);
        let stretch = (mount.vectors() * self.mean.direction).length();
        let [sharp, near, far] = self.distances.map(|distance| distance.map(|mm| mm * stretch));
        let towards = (mount.vectors() * self.mean.direction).normalize();
        SharpPoint { place: self.place, from, towards, sharp, near, far }
    }
}

impl Look<'_> {
    /// The rays of a film point that get through, in the scene.
    fn rays(&self, film: DVec3, count: u32) -> Vec<Ray> {
        beam::through(self.tracer, self.map, film, count)
    }

    fn at(&self, place: Vec2) -> Option<SharpDistances> {
        let film = self.mount.film_at(place).point;
        let rays = self.rays(film, RAYS);
        let mean = beam::mean(rays.iter())?;
        let across = PlanesAcross::of(&mean);
        let spread = across.spread(&rays);
        // By how much a step on the film moves the view, there: the mean over two directions of the film.
        let size = DVec2::new(self.mount.info.picture_width_mm, self.mount.info.picture_height_mm);
        let mut scale = Parabola::default();
        let own = beam::mean(self.rays(film, NEIGHBOUR_RAYS).iter())?;
        for step in [DVec2::X, DVec2::Y] {
            let beside = place + (step * self.step / size).as_vec2();
            let point = self.mount.film_at(beside).point;
            let neighbour = beam::mean(self.rays(point, NEIGHBOUR_RAYS).iter())?;
            let (a, b) = (across.line(&neighbour), across.line(&own));
            let apart = Parabola::squared(a.0 - b.0, a.1 - b.1);
            scale = scale + apart * (0.5 / film.distance_squared(point));
        }
        // An even disc's diameter, squared, is so many times the mean squared distance of its points from the middle.
        let disc = 8.0;
        // The lens's own blur where it is least counts as sharp: what defocus adds to it is limited.
        let least = spread.least().filter(|t| *t > 0.0);
        let own = least.map_or(spread.a / scale.a, |t| spread.at(t) / scale.at(t));
        let limit = spread * disc + scale * -(self.confusion_mm.powi(2) + disc * own);
        Some(SharpDistances { place, mean, distances: distances(spread, limit) })
    }
}

/// The distances along the mean ray at which the spread is least, and at which it begins and ends to be below the limit; a far end that is
/// infinite is infinity, and points behind the camera are beyond infinity.
fn distances(spread: Parabola, limit: Parabola) -> [Option<f64>; 3] {
    let least = spread.least();
    let sharp = least.filter(|t| *t > 0.0);
    let Some([low, high]) = limit.roots() else {
        // All or nothing.
        let all = limit.at(sharp.unwrap_or(0.0)) < 0.0;
        return [sharp, all.then_some(0.0), all.then_some(f64::INFINITY)];
    };
    if limit.a > 0.0 {
        // Between the roots.
        let is_before = high > 0.0;
        return [sharp, is_before.then_some(low.max(0.0)), is_before.then_some(high)];
    }
    // Outside of them: from the nearest of them that is before the camera on to infinity.
    let near = [low, high].into_iter().filter(|t| *t > 0.0).reduce(f64::max).unwrap_or(0.0);
    [sharp, Some(near), Some(f64::INFINITY)]
}

/// Planes across a ray.
struct PlanesAcross {
    origin: DVec3,
    along: DVec3,
    axes: [DVec3; 2],
}

impl PlanesAcross {
    fn of(mean: &Ray) -> Self {
        let (x, y) = mean.direction.any_orthonormal_pair();
        Self { origin: mean.origin, along: mean.direction, axes: [x, y] }
    }

    /// The point of a ray on these axes at distance 0, and its derivative by the distance.
    fn line(&self, ray: &Ray) -> (DVec2, DVec2) {
        let flat = |v: DVec3| DVec2::new(v.dot(self.axes[0]), v.dot(self.axes[1]));
        let from = ray.origin - self.origin;
        let slope = flat(ray.direction) / ray.direction.dot(self.along);
        (flat(from) - slope * from.dot(self.along), slope)
    }

    /// The mean squared distance of rays from their middle.
    fn spread(&self, rays: &[Ray]) -> Parabola {
        let lines: Vec<(DVec2, DVec2)> = rays.iter().map(|ray| self.line(ray)).collect();
        let count = lines.len() as f64;
        let middle = lines.iter().fold((DVec2::ZERO, DVec2::ZERO), |sum, line| (sum.0 + line.0, sum.1 + line.1));
        let middle = (middle.0 / count, middle.1 / count);
        let all = lines.iter().map(|line| Parabola::squared(line.0 - middle.0, line.1 - middle.1));
        all.fold(Parabola::default(), |sum, one| sum + one) * (1.0 / count)
    }
}

/// a t^2 + b t + c.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Parabola {
    a: f64,
    b: f64,
    c: f64,
}

impl Parabola {
    /// The squared length of `from + slope t`.
    fn squared(from: DVec2, slope: DVec2) -> Self {
        Self { a: slope.length_squared(), b: 2.0 * from.dot(slope), c: from.length_squared() }
    }

    fn at(self, t: f64) -> f64 {
        (self.a * t + self.b) * t + self.c
    }

    /// The place of the least value of one that is nowhere negative.
    fn least(self) -> Option<f64> {
        (self.a > 0.0).then(|| -0.5 * self.b / self.a).filter(|t| t.is_finite())
    }

    /// The roots, in ascending order, without cancellation. `None` where there are none.
    fn roots(self) -> Option<[f64; 2]> {
        let q = -0.5 * (self.b + (self.b * self.b - 4.0 * self.a * self.c).sqrt().copysign(self.b));
        let roots = [q / self.a, self.c / q];
        roots.iter().all(|t| t.is_finite()).then(|| if roots[0] < roots[1] { roots } else { [roots[1], roots[0]] })
    }
}

impl std::ops::Add for Parabola {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }
}

impl std::ops::Mul<f64> for Parabola {
    type Output = Self;

    fn mul(self, by: f64) -> Self {
        Self { a: self.a * by, b: self.b * by, c: self.c * by }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Model;
    use glam::{DMat4, DQuat};
    use petzval_optics::system::FocalLength;
    use std::path::Path;

    fn camera(lens: &str, f_number: f64, focus: f64) -> CameraDescription {
        CameraDescription {
            model: Model::Lens,
            lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses").join(lens),
            ..CameraDescription::default()
        }
        .with(|c| {
            c.lens.f_number = Some(f_number);
            c.focus.distance = Some(focus);
            c.film.width_mm = 36.0;
            c.film.height_mm = 24.0;
        })
    }

    /// The sharp range of a lens that is stopped down, on the axis, is that of photographers' formulas: with the hyperfocal distance H =
    /// f^2 / (N c) + f, sharp from s (H - f) / (H + s - 2f) to s (H - f) / (H - s) (e.g. Ray, Applied Photographic Optics, 3rd edition, ch.
    /// 22; distances from the entrance pupil, which in a symmetrical lens is hardly beside the principal plane).
    #[test]
    fn limits_of_sharpness_are_those_of_the_formulas() {
        let (f, n, c, s) = (100.0, 8.0, 36.0_f64.hypot(24.0) / 1500.0, 3000.0);
        let d =
            camera("double-gauss-f2-tronnier.lens", n, 3.0).with(|c| c.lens.focal_length = FocalLength::Millimetres(f));
        let found = sharpness(&d, [36, 24], [3, 3], None).unwrap();
        assert!((found.confusion_mm - c).abs() < 1e-12);
        let middle = found.points[4].unwrap();
        let h = f * f / (n * c) + f;
        let near = s * (h - f) / (h + s - 2.0 * f);
        let far = s * (h - f) / (h - s);
        // The lens's own aberrations, and the pupil that is not the principal plane, take some of it.
        let close = |a: f64, mm: f64| assert!((a * 1e3 / mm - 1.0).abs() < 0.02, "{} {mm}", a * 1e3);
        let depth = |t: f64| -(middle.from + middle.towards * t).z;
        close(depth(middle.sharp.unwrap()), s);
        close(depth(middle.near.unwrap()), near);
        close(depth(middle.far.unwrap()), far);
        assert!((found.pupil_radii[0] * 2e3 - f / n).abs() < 0.05, "{:?}", found.pupil_radii);
        // Beyond the hyperfocal distance all is sharp to infinity.
        let beyond = d.clone().with(|c| c.focus.distance = Some(h * 1.3e-3));
        let middle = sharpness(&beyond, [36, 24], [3, 3], None).unwrap().points[4].unwrap();
        assert_eq!(middle.far, Some(f64::INFINITY));
        let infinity = d.with(|c| c.focus.distance = None);
        let middle = sharpness(&infinity, [36, 24], [3, 3], None).unwrap().points[4].unwrap();
        // Spherical aberration brings the sharpest to some hundred metres: the near limit lies so much nearer.
        let s = middle.sharp.map_or(f64::INFINITY, |t| t * 1e3);
        let near = 1.0 / (1.0 / h + 1.0 / s);
        assert!((middle.near.unwrap() * 1e3 / near - 1.0).abs() < 0.02, "{middle:?} {near}");
        assert!(s > 1e5 && middle.far == Some(f64::INFINITY), "{middle:?}");
    }

    /// A tilted film's plane of focus meets film and lens in one line (Scheimpflug): its points lie in a plane.
    #[test]
    fn a_tilted_film_is_sharp_in_a_tilted_plane() {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.4, 1.0);
        let d = CameraDescription {
            matrix_world: DMat4::from_rotation_translation(turn, DVec3::new(7.0, -2.0, 3.0)),
            ..camera("double-gauss-f2-tronnier.lens", 8.0, 2.0)
        }
        .with(|c| c.film.tilt_rad = 0.05);
        let points = sharpness(&d, [36, 24], [5, 3], None).unwrap().points;
        let at = |i: usize| points[i].map(|p| p.from + p.towards * p.sharp.unwrap()).unwrap();
        let (a, b, c) = (at(6), at(8), at(12));
        let normal = (b - a).cross(c - a).normalize();
        // Field curvature bends it a little.
        for i in [1, 2, 3, 7, 11, 13] {
            assert!((at(i) - a).dot(normal).abs() < 0.02 * (at(i) - d.position()).length(), "{i}");
        }
        let forward = turn * DVec3::NEG_Z;
        let upright = normal.dot(forward).abs();
        // By 0.05 rad at 2 m with 50 mm: the plane's lean is some 60 degrees.
        assert!((0.2..0.8).contains(&upright), "{upright}");
    }

    /// Cameras without a traced lens are refused with an error that says so.
    #[test]
    fn cameras_without_a_lens_are_refused() {
        let d = CameraDescription { model: Model::Pinhole, ..CameraDescription::default() };
        assert!(sharpness(&d, [30, 20], [3, 3], None).unwrap_err().to_string().contains("no lens to be traced"));
    }

    #[test]
    fn roots_are_exact_where_one_is_far() {
        let q = Parabola { a: 1e-9, b: -1.0, c: 3.0 };
        let [low, high] = q.roots().unwrap();
        assert!((low - 3.0).abs() < 1e-7 && (high / 1e9 - 1.0).abs() < 1e-7);
        assert_eq!(Parabola { a: 1.0, b: 0.0, c: 1.0 }.roots(), None);
    }
}

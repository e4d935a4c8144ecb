//! The target of rays from the scene, so that nearly every ray gets through the lens: the entrance pupil as it is, moving and closing with
//! the angle from the axis.
//!
//! Seen from a direction the clear pupil lies in a disc at right angles to it. The map holds the centre and radius of
//! that disc by the angle from the axis, up to directions behind the lens: a fisheye's pupil turns round to meet them. A
//! share of the samples covers the whole front glass, so that nothing is lost where the disc errs: for points near the
//! lens, and where the beam is cut to odd shapes.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::paraxial::Paraxial;
use crate::system::System;
use crate::trace::{Ray, Tracer, Travel};

/// Part of the samples that covers the whole front glass.
const DEFENSIVE_SHARE: f64 = 0.05;
/// Angles at which the disc is known, 0 to 180 degrees.
const NODES: usize = 91;
/// Rays along the disc's diameter that look for it.
const GRID: usize = 48;
/// Discs are widened by this part, for the beams between the nodes and those that are not parallel.
const MARGIN: f64 = 0.04;
/// Azimuths tried where the lens is not symmetric about its axis.
const AZIMUTHS: usize = 12;

/// The clear pupil as seen from the scene.
#[derive(Clone, Debug)]
pub struct EntranceMap {
    /// The middle of the map, on the axis; directions are counted from here.
    middle: DVec3,
    discs: Vec<BeamDisc>,
    /// Ball that holds the front glass.
    front: DVec3,
    front_radius: f64,
}

/// The beam from one direction.
#[derive(Clone, Copy, Debug, Default)]
struct BeamDisc {
    /// Offset of the centre from the map's middle, towards the side that the beam comes from, mm.
    offset: f64,
    /// Radius; 0 if nothing gets through.
    radius: f64,
}

/// A ray to the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Direction of the ray, unit.
    pub direction: DVec3,
    /// Density of the choice per steradian, seen from where the ray starts.
    pub pdf_per_sr: f64,
}

/// A point of the scene and the discs at right angles to the line from it to the map's middle.
struct ScenePoint {
    distance: f64,
    /// Direction to the point.
    towards: DVec3,
    /// Axes in the plane of the axis and the point, and at right angles to that plane.
    axes: [DVec3; 2],
    disc: BeamDisc,
    /// The disc that hides the whole front glass.
    front_offset: f64,
    front_radius: f64,
}

impl EntranceMap {
    /// The map of all `tracers` together: one for a whole spectrum from its ends and middle.
    pub fn new(tracers: &[Tracer], system: &System) -> Self {
        // A mask's circle holds all of its openings.
        let tracers: &[Tracer] = &tracers.iter().map(Tracer::without_mask).collect::<Vec<_>>();
        let wavelength_nm = tracers.first().map_or(crate::glass::line_nm::D, Tracer::wavelength_nm);
        let pupil = Paraxial::new(system, wavelength_nm).entrance_pupil;
        let first = &system.surfaces()[0];
        let sag = first.shape.rim_sag_mm(first.semi_diameter_mm).unwrap_or(0.0);
        let front = DVec3::new(0.0, 0.0, first.z_mm + 0.5 * sag);
        // Decentred glass moves within its own rim's width.
        let front_radius =
            first.semi_diameter_mm.hypot(0.5 * sag) * if system.is_rotationally_symmetric() { 1.0 } else { 1.2 };
        // A telecentric entrance has its pupil at infinity: the front glass stands for it.
        let reach = 100.0 * front_radius;
        let middle_z = pupil.z_mm.filter(|z| (z - front.z).abs() < reach).unwrap_or(front.z);
        let mut map =
            Self { middle: DVec3::new(0.0, 0.0, middle_z), discs: Vec::with_capacity(NODES), front, front_radius };
        let azimuths = if system.is_rotationally_symmetric() { 1 } else { AZIMUTHS };
        let mut last = BeamDisc { offset: 0.0, radius: 0.5 * pupil.diameter_mm.unwrap_or(0.0) };
        for node in 0..NODES {
            let angle = PI * node as f64 / (NODES - 1) as f64;
            let whole = BeamDisc { offset: (front.z - middle_z) * angle.sin(), radius: front_radius };
            // A small pupil falls between the rays of a coarse search: then it is looked for about the last one.
            let near = BeamDisc { radius: 2.0 * last.radius, ..last };
            let found = map
                .search(tracers, azimuths, angle, whole)
                .and_then(|disc| map.search(tracers, azimuths, angle, disc))
                .or_else(|| map.search(tracers, azimuths, angle, near));
            last = found.unwrap_or(last);
            map.discs.push(found.unwrap_or_default());
        }
        map
    }

    /// The disc about the rays of a beam that get through, of those through `within`, wider by their spacing.
    fn search(&self, tracers: &[Tracer], azimuths: usize, angle: f64, within: BeamDisc) -> Option<BeamDisc> {
        let spacing = 2.0 * within.radius / (GRID - 1) as f64;
        let mut passed: Vec<DVec2> = Vec::new();
        for azimuth in 0..azimuths {
            let radial = DVec2::from_angle(TAU * azimuth as f64 / azimuths as f64);
            let towards = (radial * angle.sin()).extend(-angle.cos());
            let along = (radial * angle.cos()).extend(angle.sin());
            let across = DVec3::new(-radial.y, radial.x, 0.0);
            let away = 4.0 * (self.front_radius + (self.front - self.middle).length());
            let place = |i: usize| {
                let on_grid = |k: usize| spacing * k as f64 - within.radius;
                DVec2::new(within.offset + on_grid(i % GRID), on_grid(i / GRID))
            };
            for tracer in tracers {
                let mut bundle = tracer.bundle(Travel::FromScene);
                for i in 0..GRID * GRID {
                    let at = place(i);
                    let origin = self.middle + along * at.x + across * at.y + towards * away;
                    bundle.push(Ray { origin, direction: -towards });
                }
                tracer.trace(&mut bundle);
                passed.extend((0..GRID * GRID).filter(|&i| bundle.is_through(i)).map(place));
            }
        }
        let ends = passed.iter().fold(None, |ends: Option<[f64; 2]>, p| {
            Some(ends.map_or([p.x; 2], |[low, high]| [low.min(p.x), high.max(p.x)]))
        });
        let [low, high] = ends?;
        let offset = 0.5 * (low + high);
        let farthest = passed.iter().map(|p| (*p - DVec2::new(offset, 0.0)).length()).fold(0.0, f64::max);
        Some(BeamDisc { offset, radius: farthest + spacing })
    }

    /// The point on the axis from which the angles are counted, lens space, mm.
    pub fn middle(&self) -> DVec3 {
        self.middle
    }

    /// Largest angle from the axis, in rad, from which light gets through, to a node of the map.
    pub fn largest_angle_rad(&self) -> f64 {
        let last = self.discs.iter().rposition(|disc| disc.radius > 0.0).unwrap_or(0);
        PI * (last + 1).min(NODES - 1) as f64 / (NODES - 1) as f64
    }

    /// The point of a ray to the lens where it comes close to the front glass: nothing of the scene is nearer.
    pub fn before(&self, from: DVec3, direction: DVec3) -> DVec3 {
        let to = self.front - from;
        let along = to.dot(direction);
        let aside2 = to.length_squared() - along * along;
        let half = (self.front_radius * self.front_radius - aside2).max(0.0).sqrt();
        from + direction * (along - half)
    }

    fn view(&self, from: DVec3) -> Option<ScenePoint> {
        let to = from - self.middle;
        let distance = to.length();
        // In the glass nothing can be aimed at.
        if !((from - self.front).length() > 1.001 * self.front_radius && distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let towards = to / distance;
        let (disc, [along, across]) = self.disc(towards);
        // The ball's outline from here, on the plane through the middle: an ellipse, longest along the meridian.
        let ball = self.front - self.middle;
        let depth = distance - ball.dot(towards);
        let aside = ball.dot(along).atan2(depth);
        let half = (self.front_radius / ball.dot(along).hypot(depth)).asin();
        if !(aside.abs() + half < 0.49 * PI) {
            return None;
        }
        let [low, high] = [aside - half, aside + half].map(|angle| distance * angle.tan());
        let (front_offset, front_radius) = (0.5 * (low + high), 0.5001 * (high - low));
        let disc = BeamDisc { radius: disc.radius * (1.0 + MARGIN), ..disc };
        Some(ScenePoint { distance, towards, axes: [along, across], disc, front_offset, front_radius })
    }

    /// The middle of the pupil as it is for light from a direction; `towards`, a unit vector, points there. Lens space, mm.
    pub fn centre(&self, towards: DVec3) -> DVec3 {
        let (disc, [along, _]) = self.disc(towards);
        self.middle + along * disc.offset
    }

    /// The disc for light from a direction, and its axes: in the plane of the direction and the lens's axis, and across.
    fn disc(&self, towards: DVec3) -> (BeamDisc, [DVec3; 2]) {
        let flat = towards.truncate();
        let sin = flat.length();
        let radial = if sin > 0.0 { flat / sin } else { DVec2::X };
        let along = (radial * -towards.z).extend(sin);
        let across = DVec3::new(-radial.y, radial.x, 0.0);
        let place = sin.atan2(-towards.z) / PI * (NODES - 1) as f64;
        let node = (place as usize).min(NODES - 2);
        let [a, b] = [self.discs[node], self.discs[node + 1]];
        let disc = match (a.radius > 0.0, b.radius > 0.0) {
            (true, true) => {
                let part = place - node as f64;
                BeamDisc { offset: a.offset + (b.offset - a.offset) * part, radius: a.radius.max(b.radius) }
            }
            (true, false) => a,
            _ => b,
        };
        (disc, [along, across])
    }

    /// Chooses a ray from a point of the scene (lens space, mm) to the lens by two numbers in [0, 1). `None` from within
    /// the front glass, and from behind it.
    pub fn sample(&self, from: DVec3, [u, v]: [f64; 2]) -> Option<Aim> {
        let view = self.view(from)?;
        let share = view.defensive_share();
        let (radius, offset, u) = if u < share {
            (view.front_radius, view.front_offset, u / share)
        } else {
            (view.disc.radius, view.disc.offset, (u - share) / (1.0 - share))
        };
        let at = DVec2::from_angle(TAU * v) * (radius * u.sqrt()) + DVec2::new(offset, 0.0);
        let [along, across] = view.axes;
        let target = self.middle + along * at.x + across * at.y;
        let direction = (target - from).normalize();
        Some(Aim { direction, pdf_per_sr: view.density(at) })
    }

    /// The density per steradian with which [`Self::sample`] chooses `direction`, a unit vector, from a point.
    pub fn pdf(&self, from: DVec3, direction: DVec3) -> f64 {
        let Some(view) = self.view(from) else { return 0.0 };
        let nearing = -direction.dot(view.towards);
        if nearing <= 0.0 {
            return 0.0;
        }
        let hit = from + direction * (view.distance / nearing) - self.middle;
        view.density(DVec2::new(hit.dot(view.axes[0]), hit.dot(view.axes[1])))
    }
}

impl ScenePoint {
    fn defensive_share(&self) -> f64 {
        if self.disc.radius > 0.0 { DEFENSIVE_SHARE } else { 1.0 }
    }

    /// Per steradian, of the ray through a place of the plane.
    fn density(&self, at: DVec2) -> f64 {
        let share = self.defensive_share();
        let mut per_mm2 = 0.0;
        if (at - DVec2::new(self.front_offset, 0.0)).length_squared() <= self.front_radius * self.front_radius {
            per_mm2 += share / (PI * self.front_radius * self.front_radius);
        }
        if (at - DVec2::new(self.disc.offset, 0.0)).length_squared() <= self.disc.radius * self.disc.radius {
            per_mm2 += (1.0 - share) / (PI * self.disc.radius * self.disc.radius);
        }
        // dω = cos dA / d², cos = distance / d.
        let squared = at.length_squared() + self.distance * self.distance;
        per_mm2 * squared * squared.sqrt() / self.distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::LensSettings;

    const LENSES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses");

    fn systems(paths: &[std::path::PathBuf]) -> Vec<System> {
        let read = |path: &std::path::PathBuf| lens::read(path, Catalogue::shipped()).ok();
        let open = |p: &_| System::new(p, &LensSettings::default()).unwrap();
        paths.iter().filter_map(read).map(|p| open(&p)).collect()
    }

    fn points(n: u32) -> impl Iterator<Item = [f64; 2]> {
        (0..n).map(move |i| [(f64::from(i) + 0.5) / f64::from(n), (f64::from(i) * 0.618_033_988_75).fract()])
    }

    /// The solid angle of all rays that get through, by the map and by shooting at the whole front glass, from points
    /// near and far, on and off the axis. Through every third lens; through all by `make test-all`.
    #[test]
    fn the_same_light_as_through_the_whole_front_glass() {
        let mut compared = 0;
        for system in systems(&petzval_testkit::lenses::third(LENSES, 1)) {
            let tracer = system.at_wavelength(587.5618);
            let map = EntranceMap::new(std::slice::from_ref(&tracer), &system);
            let size = map.front_radius;
            for (distance, angle) in [(1e5, 0.0), (30.0, 0.2f64), (1e4, 0.5), (8.0, 0.05), (1e3, 1.0)] {
                let from = map.front + DVec3::new(angle.sin(), 0.0, -angle.cos()) * (distance * size);
                let through = |aim: Aim| tracer.from_scene(Ray { origin: from, direction: aim.direction }).is_ok();
                let mut shots = 0;
                let estimate = |share: f64, n: u32, shots: &mut u32| {
                    let mut sum = 0.0;
                    for [u, v] in points(n) {
                        let Some(mut aim) = map.sample(from, [u * share, v]) else { continue };
                        if share < 1.0 {
                            // All of them at the front glass.
                            let view = map.view(from).unwrap();
                            let there = from + aim.direction * (view.distance / -aim.direction.dot(view.towards));
                            let at =
                                (there - map.middle).dot(view.axes[0]).hypot((there - map.middle).dot(view.axes[1]));
                            let squared = at * at + view.distance * view.distance;
                            let area = PI * view.front_radius * view.front_radius;
                            aim.pdf_per_sr = squared * squared.sqrt() / view.distance / area;
                        }
                        if through(aim) {
                            *shots += 1;
                            sum += aim.pdf_per_sr.recip();
                        }
                    }
                    sum / f64::from(n)
                };
                let by_map = estimate(1.0, 8192, &mut 0);
                let brute = estimate(DEFENSIVE_SHARE, 32_768, &mut shots);
                if shots < 300 {
                    continue;
                }
                // Points are stratified: the noise falls faster than by the square root of the hits.
                let noise = 2.0 / f64::from(shots).sqrt() + 0.02;
                assert!((by_map / brute - 1.0).abs() < noise, "{} {distance} {angle}: {by_map} {brute}", system.name());
                compared += 1;
            }
        }
        assert!(compared > 25, "{compared}");
    }

    /// Rays have the density that is said of them.
    #[test]
    fn samples_have_their_density() {
        for system in systems(&petzval_testkit::lenses::shipped(LENSES)).iter().step_by(5) {
            let tracer = system.at_wavelength(550.0);
            let map = EntranceMap::new(std::slice::from_ref(&tracer), system);
            for from in [DVec3::new(300.0, -200.0, -1500.0), DVec3::new(0.0, 0.0, -3e4)] {
                for u in points(200) {
                    let Some(aim) = map.sample(from, u) else { continue };
                    let pdf = map.pdf(from, aim.direction);
                    // A ray on the rim of a disc may fall on either side by rounding.
                    let is_rim = u[0] > 0.999 || (u[0] - DEFENSIVE_SHARE).abs() < 1e-3;
                    assert!((pdf / aim.pdf_per_sr - 1.0).abs() < 1e-6 || is_rim, "{} {u:?}", system.name());
                }
            }
        }
    }

    /// Few rays are lost: the cost of light tracing.
    #[test]
    fn nearly_all_get_through_ordinary_lenses() {
        for system in systems(&petzval_testkit::lenses::shipped(LENSES)) {
            let is_ordinary = ["Double Gauss F/1.35", "Planar"].iter().any(|name| system.name().contains(name));
            if !is_ordinary {
                continue;
            }
            let tracer = system.at_wavelength(587.5618);
            let map = EntranceMap::new(std::slice::from_ref(&tracer), &system);
            let from = DVec3::new(0.0, 0.0, -5000.0);
            let n = 2000;
            let through = |u| {
                let aim = map.sample(from, u).unwrap();
                tracer.from_scene(Ray { origin: from, direction: aim.direction }).is_ok()
            };
            let passed = points(n).filter(|&u| through(u)).count();
            // The margins and the defensive share.
            assert!(passed as f64 > 0.75 * f64::from(n), "{}: {passed}", system.name());
        }
    }
}

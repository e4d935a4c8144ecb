//! Times of samples while the shutter is open, and places of the camera.

use super::unit_axes;
use crate::accel::Ray;
use crate::scene::motion::AnimatedTransform;
use glam::{Affine3A, DAffine3, DMat3, DMat4, DVec3};
use serde::{Deserialize, Deserializer};

/// Places of a camera that moves, as bits of the exposure's moments.
const WAY_BITS: u32 = 12;

/// The opening and closing of the shutter, and the places of the camera meanwhile.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shutter {
    /// Openness at times that lie evenly over the exposure, the first and the last at its ends; fewer than two: fully, all the time.
    pub openness: Vec<f32>,
    /// Rolling shutter: rows are exposed from the top to the bottom, each for this part of the exposure; `None`: all rows at once.
    pub rolling: Option<f32>,
    /// Camera space to world space at keys that lie evenly over the exposure; empty: the camera stands still. Deserialized row by row.
    #[serde(deserialize_with = "all_by_rows")]
    pub camera_keys: Vec<DMat4>,
}

/// Matrices, each of a sequence of rows.
fn all_by_rows<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<DMat4>, D::Error> {
    let all = Vec::<[[f64; 4]; 4]>::deserialize(from)?;
    Ok(all.iter().map(|rows| DMat4::from_cols_array_2d(rows).transpose()).collect())
}

/// The time of an exposure.
#[derive(Clone, Debug)]
pub struct Exposure {
    /// The openness over time; `None` where it is even.
    openness: Option<Openness>,
    rolling: Option<f32>,
    /// The transform from the camera's place in the middle of the exposure to its place at each moment, render space.
    way: Option<Vec<Affine3A>>,
}

impl Exposure {
    /// The exposure of a shutter, with the camera's places meanwhile; `origin` is render space's.
    pub fn of(shutter: &Shutter, origin: DVec3) -> Self {
        let exposure = Self::new(shutter);
        if shutter.camera_keys.is_empty() { exposure } else { exposure.along(&shutter.camera_keys, origin) }
    }

    /// The exposure of a camera that stands still.
    pub fn new(shutter: &Shutter) -> Self {
        let rolling = shutter.rolling.map(|part| part.clamp(0.0, 1.0));
        Self { openness: Openness::new(&shutter.openness), rolling, way: None }
    }

    /// The exposure of a camera whose axes are taken to the world by these matrices, at keys that lie evenly over the exposure; `origin` is
    /// render space's. Their scale counts nothing.
    pub fn along(self, keys: &[DMat4], origin: DVec3) -> Self {
        let poses: Vec<DMat4> = keys.iter().map(unscaled).collect();
        if poses.iter().all(|pose| *pose == poses[0]) {
            return self;
        }
        let way = AnimatedTransform::new(&poses).map(|way| {
            let to_origin = DAffine3::from_translation(-origin);
            let back = (to_origin * way.at(0.5)).inverse();
            let count = 1u32 << WAY_BITS;
            let place = |i: u32| to_origin * way.at((f64::from(i) + 0.5) / f64::from(count)) * back;
            let single = |map: DAffine3| Affine3A::from_mat4(DMat4::from(map).as_mat4());
            (0..count).map(|i| single(place(i))).collect()
        });
        Self { way, ..self }
    }

    /// The exposure of a camera that stands at a distance from render space's origin, rather than there.
    pub fn displaced(self, by: DVec3) -> Self {
        if by == DVec3::ZERO {
            return self;
        }
        let there = Affine3A::from_translation(by.as_vec3());
        let way = self.way.map_or_else(|| vec![there], |way| way.into_iter().map(|place| place * there).collect());
        Self { way: Some(way), ..self }
    }

    /// The time of a sample, as a part of the exposure: by a uniform number, and its height above the picture's middle, as a part of the
    /// picture's height.
    pub fn part(&self, u: f32, up: f32) -> f32 {
        let mut part = self.openness.as_ref().map_or(u, |openness| openness.time(u));
        if let Some(row_part) = self.rolling {
            part = 0.5 + (part - 0.5) * row_part - up * (1.0 - row_part);
        }
        part.clamp(0.0, 1.0)
    }

    /// A ray of the camera as it goes out at a moment.
    #[inline]
    pub fn sent(&self, ray: Ray, moment: u16) -> Ray {
        let Some(place) = self.way(moment) else { return ray.at(moment) };
        let direction = place.transform_vector3a(ray.direction).normalize();
        Ray { origin: place.transform_point3a(ray.origin), direction, moment, ..ray }
    }

    /// The transform from the camera's place in the middle of the exposure to its place at a moment, render space; `None` where it stands
    /// still.
    #[inline]
    pub fn way(&self, moment: u16) -> Option<Affine3A> {
        // One place is that of all moments.
        self.way.as_ref().map(|way| way[usize::from(moment >> (16 - WAY_BITS)).min(way.len() - 1)])
    }

    /// True if the camera moves.
    pub fn has_way(&self) -> bool {
        self.way.is_some()
    }

    /// The position at which a point that the camera sees in the middle of the exposure would be seen at a moment: as if the point, not the
    /// camera, had moved. Render space.
    pub fn seen(&self, point: DVec3, moment: u16) -> DVec3 {
        let Some(place) = self.way(moment) else { return point };
        place.inverse().transform_point3a(point.as_vec3a()).as_dvec3()
    }
}

impl Default for Exposure {
    fn default() -> Self {
        Self::new(&Shutter::default())
    }
}

fn unscaled(m: &DMat4) -> DMat4 {
    DMat4::from_mat3_translation(unit_axes(m).unwrap_or(DMat3::IDENTITY), m.w_axis.truncate())
}

/// The openness of a shutter, straight between times that lie evenly over the exposure.
#[derive(Clone, Debug)]
struct Openness {
    values: Vec<f64>,
    /// The light that has come in by each time, in any unit.
    sums: Vec<f64>,
}

impl Openness {
    /// `None` where it is even.
    fn new(values: &[f32]) -> Option<Self> {
        let values: Vec<f64> =
            values.iter().map(|v| f64::from(if v.is_finite() { v.clamp(0.0, 1.0) } else { 0.0 })).collect();
        if values.len() < 2 || values.iter().all(|v| *v == values[0]) {
            return None;
        }
        let mut sums = vec![0.0];
        for pair in values.windows(2) {
            sums.push(sums[sums.len() - 1] + 0.5 * (pair[0] + pair[1]));
        }
        Some(Self { values, sums })
    }

    /// The time by which a part of the light has come in, as a part of the exposure.
    fn time(&self, light: f32) -> f32 {
        let last = self.sums.len() - 1;
        let wanted = self.sums[last] * f64::from(light);
        let next = self.sums.partition_point(|sum| *sum < wanted).clamp(1, last);
        let within = wanted - self.sums[next - 1];
        // Light comes in as a straight line says: its sum is a parabola.
        let (a, b) = (self.values[next - 1], self.values[next]);
        let root = (a * a + 2.0 * within * (b - a)).max(0.0).sqrt();
        let part = if root + a > 0.0 { 2.0 * within / (root + a) } else { 0.0 };
        (((next - 1) as f64 + part.clamp(0.0, 1.0)) / last as f64) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::motion::MIDDLE;
    use glam::Vec3A;
    use petzval_testkit::sampling;
    use std::f64::consts::FRAC_PI_2;

    /// A shutter that opens as a triangle: as many samples in each part as it lets light in.
    #[test]
    fn samples_are_taken_as_the_shutter_opens() {
        let count = 10_000;
        let share = |exposure: &Exposure, until: f32| {
            let taken = (0..count).filter(|i| exposure.part((*i as f32 + 0.5) / count as f32, 0.0) < until).count();
            taken as f32 / count as f32
        };
        let triangle = Exposure::new(&Shutter { openness: vec![0.0, 1.0, 0.0], ..Shutter::default() });
        for (until, want) in [(0.25, 0.125), (0.5, 0.5), (0.75, 0.875)] {
            assert!((share(&triangle, until) - want).abs() < 1e-3, "{until}: {}", share(&triangle, until));
        }
        let sample = |random: &mut sampling::Random| Some(triangle.part(random.numbers::<1>()[0], 0.0).into());
        let openness = |time: f64| 2.0 - 4.0 * (time - 0.5).abs();
        sampling::values("shutter", 1 << 14, [0.0, 1.0], sample, openness);
        let even = Exposure::new(&Shutter { openness: vec![0.7; 5], ..Shutter::default() });
        assert!((share(&even, 0.3) - 0.3).abs() < 1e-3);
    }

    /// A rolling shutter exposes from the top down, each row for its part of the time.
    #[test]
    fn a_rolling_shutter_begins_at_the_top() {
        let rolling = |part| Exposure::new(&Shutter { rolling: Some(part), ..Shutter::default() });
        let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} {b}");
        for (up, want) in [(0.5, 0.0), (0.0, 0.5), (-0.5, 1.0)] {
            close(rolling(0.0).part(0.3, up), want);
        }
        close(rolling(0.2).part(0.0, 0.5), 0.0);
        close(rolling(0.2).part(1.0, 0.5), 0.2);
        close(rolling(0.2).part(0.0, -0.5), 0.8);
        close(rolling(1.0).part(0.3, 0.5), 0.3);
    }

    /// A camera that turns about itself by a quarter: its rays turn with it, and in the middle nothing happens.
    #[test]
    fn rays_go_with_the_camera() {
        let origin = DVec3::new(3.0, 4.0, 5.0);
        let at = |angle: f64| DMat4::from_translation(origin) * DMat4::from_rotation_z(angle);
        let exposure = Exposure::default().along(&[at(-FRAC_PI_2), at(0.0), at(FRAC_PI_2)], origin);
        let ray = Ray::new(Vec3A::X * 0.1, Vec3A::X);
        let sent = |moment: u16| exposure.sent(ray, moment);
        assert!(sent(MIDDLE).direction.distance(Vec3A::X) < 1e-3);
        assert!(sent(0).direction.distance(Vec3A::NEG_Y) < 1e-3 && sent(0).origin.distance(Vec3A::NEG_Y * 0.1) < 1e-4);
        assert!(sent(65535).direction.distance(Vec3A::Y) < 1e-3);
        let still = Exposure::default().along(&[at(0.0); 3], origin);
        assert!(!still.has_way());
        // From beside the origin the same, farther on.
        let by = DVec3::new(0.0, 0.0, 2.0);
        let (beside, standing) = (exposure.clone().displaced(by), still.displaced(by));
        for moment in [0, MIDDLE, 65535] {
            let (near, far) = (exposure.sent(ray, moment), beside.sent(ray, moment));
            assert!(far.origin.distance(near.origin + by.as_vec3a()) < 1e-5 && far.direction == near.direction);
            assert_eq!(standing.sent(ray, moment).origin, ray.origin + by.as_vec3a());
        }
    }
}

//! Point clouds: balls, each known by its number, checked once so that nothing later needs to.

use super::SceneError;
use super::motion::Pose;
use glam::{Vec3, Vec4};

/// A point cloud as it arrives.
#[derive(Clone, Debug, Default)]
pub struct PointsDescription {
    /// The name for messages.
    pub name: String,
    /// Positions in object space, and radii.
    pub points: Vec<Vec4>,
    /// Attributes by name, a value for each point.
    pub attributes: Vec<(String, Vec<Vec4>)>,
    /// The places a frame before and a frame after; `None` where they keep them.
    pub moved_points: Option<[Vec<Vec3>; 2]>,
    /// Positions and radii at keys that lie evenly over the time that the shutter is open; empty where they are constant.
    pub poses: Vec<Vec<Vec4>>,
}

/// Checked points: all finite, every radius at least zero.
#[derive(Clone, Debug)]
pub struct Points {
    /// Positions in object space, and radii.
    pub points: Vec<Vec4>,
    /// The numbers that seed random numbers, where they are not the points' indices.
    numbers: Option<Vec<u32>>,
    attributes: Vec<(String, Vec<Vec4>)>,
    /// The places a frame before and a frame after.
    pub moved_points: Option<[Vec<Vec3>; 2]>,
    /// Positions and radii by key over the time that the shutter is open; empty where nothing changes.
    pub(super) poses: Vec<Vec<Vec4>>,
}

impl Points {
    /// Checks a description. The second value is a warning about points left out.
    ///
    /// # Errors
    /// [`SceneError::BadPoints`].
    pub fn new(mut d: PointsDescription) -> Result<(Self, Option<String>), SceneError> {
        let bad = |what: String| SceneError::BadPoints { points: d.name.clone(), what };
        let count = d.points.len();
        let fits = |len: usize, what: &str| {
            if len == count { Ok(()) } else { Err(bad(format!("{len} values of {what} for {count} points"))) }
        };
        if u32::try_from(count).is_err() {
            return Err(bad(format!("{count} points are more than 2^32")));
        }
        for (name, values) in &d.attributes {
            fits(values.len(), &format!("attribute '{name}'"))?;
        }
        for moved in d.moved_points.iter().flatten() {
            fits(moved.len(), "moved points")?;
        }
        for pose in &d.poses {
            fits(pose.len(), "points over time")?;
        }
        if d.poses.len() == 1 {
            return Err(bad("one shape over time: give none, or several".into()));
        }
        let is_sound = |point: &Vec4| point.is_finite() && point.abs().max_element() <= 1e12;
        let always_sound = |i: usize| is_sound(&d.points[i]) && d.poses.iter().all(|pose| is_sound(&pose[i]));
        let keep: Vec<bool> = (0..count).map(always_sound).collect();
        let dropped = keep.iter().filter(|&&kept| !kept).count();
        let warning = (dropped > 0).then(|| {
            format!("points '{}': {dropped} of {count} are not finite or farther than 1e12 units; left out", d.name)
        });
        let mut numbers = None;
        if dropped > 0 {
            numbers = Some((0u32..).zip(&keep).filter(|(_, kept)| **kept).map(|(i, _)| i).collect());
            retain(&mut d.points, &keep);
            d.attributes.iter_mut().for_each(|(_, values)| retain(values, &keep));
            d.moved_points.iter_mut().flatten().for_each(|moved| retain(moved, &keep));
            d.poses.iter_mut().for_each(|pose| retain(pose, &keep));
        }
        for point in d.points.iter_mut().chain(d.poses.iter_mut().flatten()) {
            point.w = point.w.max(0.0);
        }
        let PointsDescription { points, attributes, moved_points, poses, .. } = d;
        Ok((Self { points, numbers, attributes, moved_points, poses }, warning))
    }

    /// Place and radius of a point, as it is in a pose.
    #[inline]
    pub fn at(&self, point: u32, pose: Pose) -> Vec4 {
        let (key, point) = (pose.key as usize, point as usize);
        if self.poses.is_empty() {
            return self.points[point];
        }
        self.poses[key][point].lerp(self.poses[key + 1][point], pose.part)
    }

    /// Number of keys over the time that the shutter is open; 0 where nothing changes.
    pub fn key_count(&self) -> usize {
        self.poses.len()
    }

    /// A random number of a point, 0 to 1, by the point's number.
    pub fn random(&self, point: u32) -> f32 {
        let number = self.numbers.as_ref().map_or(point, |numbers| numbers[point as usize]);
        petzval_nodes::random_of_pair([number, 0])
    }

    /// An attribute of a point; `None` where there is none of that name.
    pub fn attribute(&self, name: &str, point: u32) -> Option<Vec4> {
        let (_, values) = self.attributes.iter().find(|(own, _)| own == name)?;
        Some(values[point as usize])
    }
}

fn retain<T: Copy>(list: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    list.retain(|_| *flags.next().expect("lengths were checked"));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three() -> PointsDescription {
        let point = |x: f32| Vec4::new(x, 0.0, 0.0, 0.1);
        PointsDescription {
            name: "cloud".into(),
            points: vec![point(0.0), point(1.0), point(2.0)],
            attributes: vec![("heat".into(), (0..3).map(|i| Vec4::splat(i as f32)).collect())],
            poses: vec![vec![point(0.0), point(1.0), point(2.0)], vec![point(1.0), point(3.0), point(2.0)]],
            ..Default::default()
        }
    }

    #[test]
    fn points_know_their_place_at_each_time() {
        let (points, warning) = Points::new(three()).unwrap();
        assert!(warning.is_none());
        let half = points.at(1, Pose { key: 0, part: 0.5 });
        assert_eq!(half, Vec4::new(2.0, 0.0, 0.0, 0.1));
        assert_eq!(points.attribute("heat", 2), Some(Vec4::splat(2.0)));
        assert_eq!(points.attribute("cold", 2), None);
    }

    #[test]
    fn points_that_are_not_finite_are_left_out_and_the_others_keep_their_numbers() {
        let (whole, _) = Points::new(three()).unwrap();
        let mut d = three();
        d.poses[1][1].y = f32::NAN;
        d.points[2].w = -1.0;
        let (points, warning) = Points::new(d).unwrap();
        assert!(warning.unwrap().contains("points 'cloud': 1 of 3"));
        assert_eq!(points.points.len(), 2);
        assert_eq!(points.random(1), whole.random(2));
        assert_eq!(points.attribute("heat", 1), Some(Vec4::splat(2.0)));
        assert_eq!(points.points[1].w, 0.0);
    }

    #[test]
    fn arrays_that_do_not_fit_are_named() {
        let mut d = three();
        d.attributes[0].1.pop();
        assert!(Points::new(d).unwrap_err().to_string().contains("attribute 'heat'"));
        let mut d = three();
        d.poses.pop();
        assert!(Points::new(d).is_err());
    }
}

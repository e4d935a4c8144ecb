//! The first surfaces that a pixel sees through the lens: position, depth and normal.
//!
//! A pixel sees many places through a lens. Each ray that gets through the lens counts alike, with the first surface that it does not pass;
//! the pass is their mean. In focus that is the surface; out of focus it is blurred as the picture is, with the same rays, so that a
//! compositor's masks fit the picture. By hero the ray is that of the wavelength that leads; scene-first, the ray that the pixel started.
//! If less than half of the rays hit anything, the pixel is background.

use crate::integrator::path::FirstSurface;
use glam::{Vec3, Vec4};

/// Sums of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DataSums {
    /// Rays that got through the lens.
    pub rays: f32,
    /// Rays that hit a surface.
    pub hits: f32,
    /// Sum of positions, render space.
    pub position: Vec3,
    /// Sum of unit normals, render space.
    pub normal: Vec3,
}

impl DataSums {
    /// Adds the surface that a ray found.
    #[inline]
    pub fn add(&mut self, found: Option<FirstSurface>) {
        self.rays += 1.0;
        if let Some(surface) = found {
            self.hits += 1.0;
            self.position += Vec3::from(surface.position);
            self.normal += Vec3::from(surface.normal);
        }
    }

    pub(super) fn join(&mut self, other: &Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.position += other.position;
        self.normal += other.normal;
    }

    /// The mean surface; `None` for the background.
    pub fn mean(&self) -> Option<(Vec3, Vec3)> {
        (self.hits > 0.0 && 2.0 * self.hits >= self.rays).then(|| (self.position / self.hits, self.normal / self.hits))
    }
}

/// Sums of the motion vectors of the hits of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VectorSums {
    /// Rays whose way is known.
    pub(super) rays: f32,
    pub(super) sum: Vec4,
}

impl VectorSums {
    /// Adds the motion vector of a ray.
    #[inline]
    pub fn add(&mut self, vector: [f32; 4]) {
        self.rays += 1.0;
        self.sum += Vec4::from(vector);
    }

    pub(super) fn join(&mut self, other: &Self) {
        self.rays += other.rays;
        self.sum += other.sum;
    }

    /// The mean way; zero if none is known.
    pub fn mean(&self) -> [f32; 4] {
        (self.sum / self.rays.max(1.0)).to_array()
    }
}

/// A pass of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataPass {
    /// Distance from the camera along its axis, or of a panoramic camera straight away from it, Blender units; 1e10 for the background, as
    /// Cycles has it. One channel.
    Depth,
    /// Position in world space; 0 for the background. Three channels.
    Position,
    /// Normal in world space, towards the camera; 0 for the background. Three channels.
    Normal,
    /// Motion vectors: from the place in the picture of the surface that a pixel sees to its place a frame before, and from its place a
    /// frame after to here; pixels, right and up. Four channels.
    Vector,
    /// Number of samples of the pixel. One channel.
    Samples,
}

/// The depth of the background.
pub const FARTHEST: f32 = 1e10;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    #[test]
    fn the_background_is_where_most_rays_meet_nothing() {
        let surface = FirstSurface {
            position: Vec3A::new(1.0, 2.0, -3.0),
            normal: Vec3A::Z,
            instance: 0,
            triangle: 0,
            material: 0,
            barycentric: [0.0; 2],
        };
        let mut sums = DataSums::default();
        assert_eq!(sums.mean(), None);
        sums.add(Some(surface));
        sums.add(None);
        assert_eq!(sums.mean(), Some((Vec3::new(1.0, 2.0, -3.0), Vec3::Z)));
        sums.add(None);
        assert_eq!(sums.mean(), None);
    }
}

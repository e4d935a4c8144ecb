//! The picture of Blender's own camera. Shader graphs may ask for places in its space and on its picture; which lens takes the photograph
//! does not matter to them.

use crate::projection::{Panorama, Projection};
use glam::{Affine3A, DAffine3, DMat3, DMat4, DVec2, DVec3, Mat3A, Vec2, Vec3A};

/// A perspective, orthographic or panoramic camera, as the scene's description has it.
#[derive(Clone, Copy, Debug)]
pub struct ViewportDescription {
    /// The viewport's axes to the world; it looks along its -z. Scale counts nothing.
    pub matrix: DMat4,
    /// Focal length over the picture's width and height; of an orthographic camera 1 over width and height in Blender units.
    pub focal: DVec2,
    /// The point of the picture on the camera's axis, from 0 to 1 both ways.
    pub center: DVec2,
    /// Columns and rows of pixels.
    pub pixels: [u32; 2],
    /// The projection of the picture.
    pub projection: ViewportProjection,
}

/// The projection of a viewport's picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ViewportProjection {
    /// Perspective: rays go through the camera's origin.
    #[default]
    Perspective,
    /// Orthographic: rays are parallel.
    Orthographic,
    /// The projection of a panoramic camera; focal length and centre say nothing of it.
    Panoramic(Panorama),
}

impl Default for ViewportDescription {
    fn default() -> Self {
        Self {
            matrix: DMat4::IDENTITY,
            focal: DVec2::ONE,
            center: DVec2::splat(0.5),
            pixels: [1000; 2],
            projection: ViewportProjection::Perspective,
        }
    }
}

/// A [`ViewportDescription`] in the form that shader graphs read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    /// The transform from Blender's world to the camera's space, in which z grows away from the camera. A panoramic camera's space is as
    /// Cycles has it: it looks along x, with z up.
    pub from_world: Affine3A,
    /// The transform from render space to the camera's space.
    pub from_render: Affine3A,
    focal: Vec2,
    center: Vec2,
    /// A pixel's sides: at depth 1, of an orthographic camera everywhere.
    pixel: Vec2,
    projection: ViewportProjection,
    /// The map from the camera's space to the camera's axes: right, up, backwards.
    to_axes: Mat3A,
}

impl Viewport {
    pub(super) fn new(description: &ViewportDescription, origin: DVec3) -> Self {
        let ViewportDescription { matrix, focal, center, pixels: [columns, rows], projection } = *description;
        let unit = |axis: DVec3, otherwise: DVec3| axis.try_normalize().unwrap_or(otherwise);
        let own = DAffine3::from_mat4(matrix);
        let x = unit(own.matrix3.x_axis, DVec3::X);
        let y = unit(own.matrix3.y_axis, DVec3::Y);
        let z = unit(own.matrix3.z_axis, DVec3::Z);
        let to_axes = match projection {
            ViewportProjection::Perspective | ViewportProjection::Orthographic => {
                DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0))
            }
            // As Cycles has them: a ball is looked at along y, all other pictures are of the directions about x.
            ViewportProjection::Panoramic(Panorama { projection: Projection::MirrorBall, .. }) => {
                DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y)
            }
            ViewportProjection::Panoramic(_) => DMat3::from_cols(DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y),
        };
        let to_world = DAffine3 { matrix3: DMat3::from_cols(x, y, z) * to_axes, translation: own.translation };
        let from_world = to_world.inverse();
        let size = DVec2::new(f64::from(columns), f64::from(rows));
        let single = |map: DAffine3| Affine3A::from_mat4(DMat4::from(map).as_mat4());
        Self {
            from_world: single(from_world),
            from_render: single(from_world * DAffine3::from_translation(origin)),
            focal: focal.as_vec2(),
            center: center.as_vec2(),
            pixel: match projection {
                ViewportProjection::Perspective | ViewportProjection::Orthographic => (1.0 / (focal * size)).as_vec2(),
                ViewportProjection::Panoramic(panorama) => DVec2::from(panorama.step_rad(1.0 / size)).as_vec2(),
            },
            projection,
            to_axes: Mat3A::from(to_axes.as_mat3()),
        }
    }

    /// The place on the picture of a place of the camera's space, from 0 to 1 both ways; zero where it has none, as beside the camera.
    pub fn window(&self, place: Vec3A) -> Vec3A {
        let across = Vec2::new(place.x, place.y);
        match &self.projection {
            ViewportProjection::Panoramic(panorama) => {
                let at = panorama.place((self.to_axes * place).as_dvec3());
                at.map_or(Vec3A::ZERO, |at| (at.as_vec2() + 0.5).extend(0.0).into())
            }
            ViewportProjection::Orthographic => (across * self.focal + self.center).extend(0.0).into(),
            ViewportProjection::Perspective if place.z == 0.0 => Vec3A::ZERO,
            ViewportProjection::Perspective => (across / place.z * self.focal + self.center).extend(0.0).into(),
        }
    }

    /// True if the picture is one by parallel rays.
    pub fn is_orthographic(&self) -> bool {
        self.projection == ViewportProjection::Orthographic
    }

    /// Width of a pixel at distance 1, in the middle of the picture.
    pub fn pixel_angle_rad(&self) -> f32 {
        0.5 * (self.pixel.x + self.pixel.y)
    }

    /// Width of a pixel that an edge at a place of the camera's space is diced by, world units: that of the middle of the picture at the
    /// same distance. Beyond the frame it is as if the place were `off_screen` - 1 times its distance from the frame farther away. As
    /// `Camera::world_to_raster_size` of Cycles.
    pub fn diced_width(&self, place: Vec3A, off_screen: f32) -> f32 {
        let Vec2 { x: left, y: bottom } = -self.center / self.focal;
        let Vec2 { x: right, y: top } = (Vec2::ONE - self.center) / self.focal;
        match self.projection {
            ViewportProjection::Perspective => {}
            // Any place may be seen.
            ViewportProjection::Panoramic(_) => return self.pixel_angle_rad() * place.length(),
            ViewportProjection::Orthographic => {
                // A frame that is none, of no width or of no numbers, holds nothing back; `clamp` would panic.
                let within = |at: f32, low: f32, high: f32| at.max(low).min(high);
                let framed = Vec3A::new(within(place.x, left, right), within(place.y, bottom, top), place.z.max(0.0));
                // In units of the frame's half diagonal over the square root of two.
                let outside =
                    place.distance(framed) / (0.5 * (right * right + top * top)).sqrt().max(f32::MIN_POSITIVE);
                return self.pixel.min_element() * (1.0 + outside * (off_screen - 1.0).max(0.0));
            }
        }
        let beyond = |out: Vec3A| place.dot(out.normalize());
        let sides = [
            Vec3A::new(1.0, 0.0, -right),
            Vec3A::new(-1.0, 0.0, left),
            Vec3A::new(0.0, 1.0, -top),
            Vec3A::new(0.0, -1.0, bottom),
        ];
        let outside = sides.map(beyond).into_iter().fold(0.0, f32::max);
        self.pixel.min_element() * (place.length() + outside * (off_screen - 1.0).max(0.0))
    }

    /// Width of a pixel across the line of sight at a place of the camera's space: the mean of both ways, world units.
    pub fn pixel_width(&self, place: Vec3A) -> f32 {
        match self.projection {
            ViewportProjection::Perspective => {}
            ViewportProjection::Orthographic => return self.pixel_angle_rad(),
            ViewportProjection::Panoramic(_) => return self.pixel_angle_rad() * place.length(),
        }
        let ahead = place / place.z.abs().max(1e-6);
        let step = |to: Vec3A| (ahead + to).normalize_or_zero().distance(ahead.normalize_or_zero());
        let [x, y] = [Vec3A::X * self.pixel.x, Vec3A::Y * self.pixel.y].map(step);
        0.5 * (x + y) * place.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera at (1, 2, 3) that looks along +y, its axes scaled; 90 degrees wide, twice as wide as high, shifted.
    fn viewport() -> Viewport {
        let turn = DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let matrix = DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)) * turn * DMat4::from_scale(DVec3::splat(2.0));
        let (focal, center) = (DVec2::new(0.5, 1.0), DVec2::new(0.5, 0.4));
        let description = ViewportDescription {
            matrix,
            focal,
            center,
            pixels: [200, 100],
            projection: ViewportProjection::Perspective,
        };
        Viewport::new(&description, DVec3::new(1.0, 0.0, 0.0))
    }

    #[test]
    fn places_are_found_in_its_space_and_on_its_picture() {
        let viewport = viewport();
        let place = viewport.from_world.transform_point3a(Vec3A::new(4.0, 5.0, 3.6));
        assert!(place.distance(Vec3A::new(3.0, 0.6, 3.0)) < 1e-6, "{place}");
        let same = viewport.from_render.transform_point3a(Vec3A::new(3.0, 5.0, 3.6));
        assert!(same.distance(place) < 1e-6, "{same}");
        let seen = viewport.window(place);
        assert!(seen.distance(Vec3A::new(1.0, 0.6, 0.0)) < 1e-6, "{seen}");
    }

    #[test]
    fn a_pixel_grows_with_the_distance() {
        let viewport = viewport();
        // 2 units wide at depth 1, by 200 pixels.
        for depth in [1.0, 3.0] {
            let width = viewport.pixel_width(Vec3A::Z * depth);
            assert!((width - 0.01 * depth).abs() < 1e-5 * depth, "{width} at {depth}");
        }
    }

    /// 2 units by 1, shifted: everything is as large at any depth.
    #[test]
    fn an_orthographic_picture_has_no_depth() {
        let viewport = Viewport { projection: ViewportProjection::Orthographic, ..viewport() };
        for depth in [1.0, 3.0] {
            let place = Vec3A::new(0.5, -0.2, depth);
            assert!(viewport.window(place).distance(Vec3A::new(0.75, 0.2, 0.0)) < 1e-6);
            assert_eq!([viewport.pixel_width(place), viewport.diced_width(place, 4.0)], [0.01; 2]);
        }
        assert!(viewport.diced_width(Vec3A::new(3.0, 0.0, 1.0), 4.0) > 0.02);
    }

    /// Widths of pixels of a frame that is none are some number, and no panic.
    #[test]
    fn a_frame_that_is_none_is_no_panic() {
        let sizes = [f64::NAN, f64::INFINITY, 0.0, -1.0, 2.0];
        for (focal, center) in sizes.into_iter().flat_map(|focal| sizes.map(|center| (focal, center))) {
            let projection = ViewportProjection::Orthographic;
            let description = ViewportDescription {
                focal: DVec2::splat(focal),
                center: DVec2::splat(center),
                projection,
                ..ViewportDescription::default()
            };
            let width = Viewport::new(&description, DVec3::ZERO).diced_width(Vec3A::new(0.3, -0.2, 1.0), 4.0);
            assert!(
                focal != 2.0 || center.is_nan() || center.is_infinite() || width > 0.0,
                "{focal} {center}: {width}"
            );
        }
    }
}

//! The pipeline of bakes: paths start at points of one object's surface, a pixel of its texture each, where a camera would have sent rays.
//!
//! As `init_from_bake.h` of Cycles: a ray comes from straight above the surface, or from where the camera stands, and nothing is in its way.

use super::RenderContext;
use super::stretch::CameraSampler;
use crate::Rgb;
use crate::accel::{Hit, Ray, offset_origin};
use crate::camera::lens::real_lens::packet::Request;
use crate::film::TileAccumulator;
use crate::integrator::path::SurfaceStart;
use crate::sampler::hashed::HashedNumbers;
use crate::scene::Scene;
use crate::scene::motion::MIDDLE;
use crate::surface::SurfacePoint;
use glam::{Vec2, Vec3, Vec3A};

/// Tries to find a place in the pixel that lies in the point's triangle, too.
const TRIES: u32 = 10;
/// Part of an object's coordinates by which a point on a vertex is moved into its triangle.
const OFF_VERTEX: f32 = 1e-4;
/// Least share of a corner in a point that was moved off a vertex.
const LEAST_SHARE: f32 = 1e-5;
/// Least cosine of the view from the camera to the shading normal: surfaces that face away are still seen, at a slant.
const LEAST_COSINE: f32 = 0.2;
/// Least cosine of that view to the triangle's own normal.
const ABOVE: f32 = 1e-5;

/// A point of a surface that a pixel of its texture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakePoint {
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Barycentric weights of the first and second corner in the middle of the pixel.
    pub weights: [f32; 2],
    /// Changes of both from one pixel to the next: of the first along columns and rows, then of the second.
    pub steps: [[f32; 2]; 2],
    /// The pixel whose random numbers this one has: corners of faces that share a vertex share them.
    pub numbers_of: [u32; 2],
}

/// The place from which the surface is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewFrom {
    /// The view from straight above each point.
    Above,
    /// The view from a place in render space.
    Place(Vec3A),
    /// The view from far away, where this direction leads; unit.
    Far(Vec3A),
    /// The sky is looked at, in the direction of the point from this place of render space.
    Sky(Vec3A),
}

/// The points of one object that are baked.
#[derive(Clone, Debug)]
pub struct BakePoints {
    /// Width of the texture, pixels.
    pub width: u32,
    /// Index of the instance.
    pub instance: u32,
    /// Points pixel by pixel, rows from below; `None` where the object is not.
    pub points: Vec<Option<BakePoint>>,
    /// The place from which they are seen.
    pub view: ViewFrom,
}

impl BakePoints {
    /// The point of a pixel.
    pub(super) fn point(&self, [x, y]: [u32; 2]) -> Option<&BakePoint> {
        self.points[y as usize * self.width as usize + x as usize].as_ref()
    }

    /// Rays to some of the points, evenly chosen, at most `most`: for statistics.
    pub fn some_rays(&self, scene: &Scene, most: usize) -> Vec<Ray> {
        let all: Vec<&BakePoint> = self.points.iter().flatten().collect();
        let step = all.len().div_ceil(most).max(1);
        all.into_iter().step_by(step).map(|point| self.start(scene, point, [0.5; 2]).ray).collect()
    }

    /// The start of a path at a point, where `u` chooses the place in the pixel.
    fn start(&self, scene: &Scene, point: &BakePoint, u: [f32; 2]) -> BakeLead {
        let instance = &scene.instances[self.instance as usize];
        let corners = instance.corners(&scene.meshes[instance.mesh as usize], point.triangle);
        let [first, second] = point.place(&corners, u);
        let (u, v, moment) = (second, 1.0 - first - second, MIDDLE);
        // As Cycles: the ray is one unit long.
        let hit = Hit { t: 1.0, u, v, instance: self.instance, triangle: point.triangle, moment };
        let edge = |to: usize| instance.to_render.transform_vector3a(Vec3A::from(corners[to] - corners[2]));
        let [along_first, along_second] = point.steps;
        let across = |i: usize| (edge(0) * along_first[i] + edge(1) * along_second[i]).length();
        let footprint = 0.5 * (across(0) + across(1));
        let flat = SurfacePoint::new(scene, &hit, Vec3A::ZERO);
        if let ViewFrom::Sky(from) = self.view {
            let ray = Ray::new(flat.position, (flat.position - from).normalize_or(Vec3A::Z));
            return BakeLead { ray, start: SurfaceStart { hit: None, footprint } };
        }
        let direction = -self.towards_view(&flat);
        let origin = offset_origin(flat.position, flat.geometric_normal, flat.position_error);
        BakeLead { ray: Ray::new(origin, direction), start: SurfaceStart { hit: Some(hit), footprint } }
    }

    /// The direction from which a point of the front side is seen, unit.
    fn towards_view(&self, point: &SurfacePoint) -> Vec3A {
        let (normal, outward) = (point.shading_normal, point.geometric_normal);
        let mut d = match self.view {
            ViewFrom::Above | ViewFrom::Sky(_) => return normal,
            ViewFrom::Place(place) => (place - point.position).normalize_or(normal),
            ViewFrom::Far(d) => d,
        };
        let cos = d.dot(normal);
        if cos <= LEAST_COSINE {
            d = (d - normal * (cos - LEAST_COSINE)).normalize_or(normal);
        }
        if cos <= 0.0 {
            d = d.lerp(normal, -cos).normalize_or(normal);
        }
        let above = d.dot(outward);
        if above <= ABOVE { (d - outward * (above - ABOVE)).normalize_or(normal) } else { d }
    }
}

impl BakePoint {
    /// Weights of the first and second corner at a place in the pixel that `u` chooses. Where the pixel reaches over the triangle's border
    /// other places are tried; where none is found, the middle.
    fn place(&self, corners: &[Vec3; 3], u: [f32; 2]) -> [f32; 2] {
        let is_end = |weight: f32| weight == 0.0 || weight == 1.0;
        let middle = Vec2::from(self.weights);
        let middle = if is_end(middle.x) && is_end(middle.y) { off_vertex(corners, middle) } else { middle };
        let [of_first, of_second] = self.steps.map(Vec2::from);
        let mut numbers = HashedNumbers::new([u[0], u[1], 0.0]);
        let mut u = Vec2::from(u);
        for _ in 0..TRIES {
            let off = u - 0.5;
            let at = middle + Vec2::new(of_first.dot(off), of_second.dot(off));
            if at.x > 0.0 && at.y > 0.0 && at.x + at.y < 1.0 {
                return at.to_array();
            }
            u = Vec2::new(numbers.next(), numbers.next());
        }
        middle.to_array()
    }
}

/// A vertex, moved a little towards the middle of its triangle: rays that leave it would hit its neighbours.
fn off_vertex(corners: &[Vec3; 3], weights: Vec2) -> Vec2 {
    let at = corners[0] * weights.x + corners[1] * weights.y + corners[2] * (1.0 - weights.x - weights.y);
    let away = (corners[0] + corners[1] + corners[2]) / 3.0 - at;
    let by = OFF_VERTEX * at.abs().max_element().max(1.0);
    let part = (by / away.length().max(f32::MIN_POSITIVE)).clamp(3.0 * LEAST_SHARE, 1.0);
    weights.lerp(Vec2::splat(1.0 / 3.0), part)
}

/// The start of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct BakeLead {
    ray: Ray,
    start: SurfaceStart,
}

/// Starts of paths on the points of a bake.
pub(super) struct Bake<'a> {
    scene: &'a Scene,
    points: &'a BakePoints,
}

impl<'a> Bake<'a> {
    pub(super) fn new(shot: &RenderContext<'a>, points: &'a BakePoints) -> Self {
        Self { scene: &shot.stage.scene, points }
    }
}

impl CameraSampler for Bake<'_> {
    type Lead = BakeLead;

    fn ask(&mut self, _: usize, requests: &[Request], leads: &mut Vec<Option<BakeLead>>) {
        let start = |r: &Request| Some(self.points.start(self.scene, self.points.point(r.pixel)?, r.u_place));
        leads.extend(requests.iter().map(start));
    }

    fn ray(lead: &BakeLead) -> Ray {
        lead.ray
    }

    fn start(lead: &BakeLead) -> Option<SurfaceStart> {
        Some(lead.start)
    }

    fn add(&self, _: usize, request: &Request, _: &BakeLead, radiance: Rgb, light: &mut TileAccumulator) {
        light.add(request.pixel[0], request.pixel[1], radiance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneBuilder;
    use crate::scene::mesh::MeshDescription;
    use glam::{DMat4, DVec3};

    /// A triangle in the plane z = 0 that faces up, 1000 units beside the world's origin, which render space's is as well.
    fn scene() -> Scene {
        let mut builder = SceneBuilder::new();
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mesh =
            MeshDescription { name: "triangle".into(), positions, triangles: vec![[0, 1, 2]], ..Default::default() };
        let mesh = builder.add_mesh(mesh).unwrap();
        let place = DVec3::new(1000.0, 0.0, 0.0);
        builder.add_instance("triangle", mesh, DMat4::from_translation(place), &[], true, true).unwrap();
        builder.build(place)
    }

    fn baked(view: ViewFrom, point: BakePoint) -> BakePoints {
        BakePoints { width: 1, instance: 0, points: vec![Some(point)], view }
    }

    const MIDDLE_OF_IT: BakePoint =
        BakePoint { triangle: 0, weights: [0.25, 0.25], steps: [[0.0, 0.1], [0.2, 0.0]], numbers_of: [0, 0] };

    #[test]
    fn the_ray_comes_from_above() {
        let (scene, points) = (scene(), baked(ViewFrom::Above, MIDDLE_OF_IT));
        let lead = points.start(&scene, &MIDDLE_OF_IT, [0.5; 2]);
        assert_eq!(lead.ray.direction, Vec3A::NEG_Z);
        let hit = lead.start.hit.unwrap();
        // Weights of the second and the third corner.
        assert_eq!([hit.u, hit.v], [0.25, 0.5]);
        assert!((lead.ray.origin - Vec3A::new(0.25, 0.5, 0.0)).length() < 1e-4);
        // Along a row the second corner's weight grows at the cost of the third: by 0.2 sqrt(2); up a column the first's: by 0.1.
        assert!((lead.start.footprint - 0.5 * (0.2 * 2.0_f32.sqrt() + 0.1)).abs() < 1e-6);
    }

    #[test]
    fn a_slanting_view_stays_above_the_surface() {
        let scene = scene();
        let flat = SurfacePoint::new(
            &scene,
            &baked(ViewFrom::Above, MIDDLE_OF_IT).start(&scene, &MIDDLE_OF_IT, [0.5; 2]).start.hit.unwrap(),
            Vec3A::ZERO,
        );
        for (from, least) in
            [(Vec3A::new(0.0, 0.0, 5.0), 0.99), (Vec3A::new(50.0, 0.0, 1.0), 0.19), (Vec3A::new(1.0, 0.0, -5.0), 0.19)]
        {
            let d = baked(ViewFrom::Place(from), MIDDLE_OF_IT).towards_view(&flat);
            assert!(d.is_normalized() && d.z > least, "{from} {d}");
        }
        assert_eq!(baked(ViewFrom::Far(Vec3A::Z), MIDDLE_OF_IT).towards_view(&flat), Vec3A::Z);
    }

    #[test]
    fn the_sky_is_looked_at_from_the_worlds_origin() {
        let scene = scene();
        let points = baked(ViewFrom::Sky((-scene.origin).as_vec3a()), MIDDLE_OF_IT);
        let lead = points.start(&scene, &MIDDLE_OF_IT, [0.5; 2]);
        assert!(lead.start.hit.is_none());
        assert!((lead.ray.direction - Vec3A::new(1000.25, 0.5, 0.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn places_lie_in_the_pixel_and_in_the_triangle() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let at_border = BakePoint { weights: [0.02, 0.5], steps: [[0.3, 0.0], [0.0, 0.3]], ..MIDDLE_OF_IT };
        for i in 0..100 {
            let u = [(i % 10) as f32 / 10.0, (i / 10) as f32 / 10.0];
            let [first, second] = at_border.place(&corners, u);
            assert!(first > 0.0 && second > 0.0 && first + second < 1.0);
            assert!((first - 0.02).abs() <= 0.15 && (second - 0.5).abs() <= 0.15);
        }
        // Outside, with no room for any other place: the middle stays.
        let outside = BakePoint { weights: [-0.5, 0.2], steps: [[0.1, 0.0], [0.0, 0.1]], ..MIDDLE_OF_IT };
        assert_eq!(outside.place(&corners, [0.1, 0.9]), [-0.5, 0.2]);
    }

    #[test]
    fn points_on_a_vertex_move_off_it() {
        let corners = [Vec3::splat(100.0), Vec3::new(101.0, 100.0, 100.0), Vec3::new(100.0, 101.0, 100.0)];
        for weights in [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]] {
            let vertex = BakePoint { weights, steps: [[0.0; 2]; 2], ..MIDDLE_OF_IT };
            let [first, second] = vertex.place(&corners, [0.5; 2]);
            let third = 1.0 - first - second;
            assert!(first > 0.0 && second > 0.0 && third > 0.0);
            let moved = (Vec2::new(first, second) - Vec2::from(weights)).length();
            // A ten thousandth of the coordinates.
            assert!((1e-3..0.03).contains(&moved), "{moved}");
        }
    }
}

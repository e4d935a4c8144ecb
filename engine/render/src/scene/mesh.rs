//! Triangle meshes, checked once so that nothing later needs to.

use super::SceneError;
use super::corners::{self, Corners, Named, Numbers};
use super::curves::Curves;
use super::grid::Grid;
use super::motion::{Poses, bounds_of};
use super::points::Points;
use glam::{Vec2, Vec3, Vec4};

/// The name by which a mesh keeps its undeformed coordinates in its box.
pub const GENERATED: &str = ".generated";

/// The fineness to which a mesh is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dicing {
    /// The length of an edge, about.
    pub edge: EdgeLength,
    /// Factor on the length of edges far beyond the picture's frame: see [`super::viewport::Viewport::diced_width`].
    pub off_screen: f32,
    /// The most times that an edge is halved.
    pub halvings: u32,
    /// The triangles that there is memory for beside those of the meshes as they are.
    pub room: usize,
}

/// The length of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeLength {
    /// A length in pixels of Blender's own camera.
    Pixels(f32),
    /// A length in units of the mesh's space.
    Units(f32),
}

/// A mesh as it arrives; arrays by triangle have one entry a triangle.
#[derive(Clone, Debug, Default)]
pub struct MeshDescription {
    /// The name for messages.
    pub name: String,
    /// Vertices in object space.
    pub positions: Vec<Vec3>,
    /// Three indices into `positions`, anticlockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Corners of faces by triangle: numbers for [`Corners::Loops`]; empty where there are none.
    pub loops: Vec<[u32; 3]>,
    /// Normals at the corners, object space; `None` is flat.
    pub corner_normals: Option<Corners<Vec3>>,
    /// UV maps by name, in Blender's order.
    pub uv_maps: Vec<Named<Vec2>>,
    /// Attributes at the corners, by name, for shader graphs.
    pub attributes: Vec<Named<Vec4>>,
    /// Material slot by triangle; `None` is slot 0.
    pub material_slots: Option<Vec<u32>>,
    /// `positions` a frame before and a frame after; `None` where the mesh keeps its shape.
    pub moved_positions: Option<[Vec<Vec3>; 2]>,
    /// The mesh's shapes while the shutter is open; `None` where it keeps its shape.
    pub poses: Option<Poses>,
    /// Values known in the mesh's space, for volumes.
    pub grids: Vec<Grid>,
    /// True if the mesh's volume has the same opacity whatever the object's size.
    pub keeps_opacity: bool,
    /// The fineness to which it is divided before it is displaced; `None` where it stays as it is.
    pub dicing: Option<Dicing>,
}

impl MeshDescription {
    /// Checks that all that is listed by triangle, corner or vertex fits the mesh.
    fn check(&self) -> Result<(), SceneError> {
        let bad = |what: String| SceneError::BadMesh { mesh: self.name.clone(), what };
        let n = self.triangles.len();
        let fits = |len: usize, what: &str| {
            if len == n { Ok(()) } else { Err(bad(format!("{what} for {len} triangles, but there are {n}"))) }
        };
        let (numbers, vertices) = (Numbers { triangles: &self.triangles, loops: &self.loops }, self.positions.len());
        let of_corners = |misfit: Option<String>, what: &str| match misfit {
            None => Ok(()),
            Some(why) => Err(bad(format!("{what}: {why}"))),
        };
        if let Some(normals) = &self.corner_normals {
            of_corners(normals.misfit(numbers, vertices), "corner normals")?;
        }
        for (name, uvs) in &self.uv_maps {
            of_corners(uvs.misfit(numbers, vertices), &format!("UV map '{name}'"))?;
        }
        for (name, values) in &self.attributes {
            of_corners(values.misfit(numbers, vertices), &format!("attribute '{name}'"))?;
        }
        if let Some(slots) = &self.material_slots {
            fits(slots.len(), "material slots")?;
        }
        if let Some(moved) = self.moved_positions.iter().flatten().find(|moved| moved.len() != self.positions.len()) {
            return Err(bad(format!("{} moved positions for {} vertices", moved.len(), self.positions.len())));
        }
        if let Some(poses) = &self.poses {
            let (keys, vertices) = (poses.key_count(), self.positions.len());
            let fit = poses.positions.iter().all(|key| key.len() == vertices);
            let normals_fit = poses.corner_normals.iter().flatten().all(|key| key.misfit(numbers, vertices).is_none())
                && poses.corner_normals.as_ref().is_none_or(|normals| normals.len() == keys);
            if keys < 2 || !fit || !normals_fit {
                return Err(bad(format!("its {keys} shapes over time do not fit its {vertices} vertices")));
            }
        }
        if u32::try_from(n).is_err() {
            return Err(bad(format!("{n} triangles are more than 2^32")));
        }
        if let Some(t) = self.triangles.iter().find(|t| t.iter().any(|&i| i as usize >= self.positions.len())) {
            return Err(bad(format!("triangle {t:?} points past its {} vertices", self.positions.len())));
        }
        Ok(())
    }
}

/// A checked mesh: every index valid, every position finite, every triangle with area.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The name for messages.
    pub name: String,
    /// Vertices in object space.
    pub positions: Vec<Vec3>,
    /// Three indices into `positions`, anticlockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Corners of faces by triangle; empty where nothing is kept by these.
    pub loops: Vec<[u32; 3]>,
    /// Unit normals at the corners, object space.
    pub corner_normals: Option<Corners<Vec3>>,
    /// UV maps by name.
    pub uv_maps: Vec<Named<Vec2>>,
    /// Attributes at the corners, by name.
    pub attributes: Vec<Named<Vec4>>,
    /// Material slot by triangle.
    pub material_slots: Option<Vec<u32>>,
    /// `positions` a frame before and a frame after.
    pub moved_positions: Option<[Vec<Vec3>; 2]>,
    /// Values known in the mesh's space, for volumes.
    pub grids: Vec<Grid>,
    /// True if the mesh's volume has the same opacity whatever the object's size.
    pub keeps_opacity: bool,
    /// The fineness to which it is divided before it is displaced.
    pub dicing: Option<Dicing>,
    /// The corners of the box that holds `positions`.
    pub bounds: [Vec3; 2],
    /// Hair or other curves, instead of triangles.
    pub curves: Option<Box<Curves>>,
    /// A point cloud, instead of triangles.
    pub points: Option<Box<Points>>,
    /// The mesh's shapes while the shutter is open.
    pub poses: Option<Box<Poses>>,
    /// True if the mesh has curves, points or several shapes: one test for features that most meshes do not have.
    pub is_special: bool,
}

impl Mesh {
    /// Checks a description. The second value is a warning about triangles left out; those without area, which nothing can hit, are left
    /// out without one, as in Cycles.
    ///
    /// # Errors
    /// [`SceneError::BadMesh`].
    pub fn new(d: MeshDescription) -> Result<(Self, Option<String>), SceneError> {
        d.check()?;
        let n = d.triangles.len();
        let shapes = || d.poses.iter().flat_map(|poses| &poses.positions);
        let is_near = |t: &[u32; 3]| {
            t.iter().all(|&i| within_reach(&d.positions[i as usize]))
                && shapes().all(|shape| t.iter().all(|&i| within_reach(&shape[i as usize])))
        };
        let mut far = 0;
        let mut is_kept = |t: &[u32; 3]| {
            let near = is_near(t);
            far += usize::from(!near);
            let [a, b, c] = t.map(|i| d.positions[i as usize]);
            near && has_area(a, b, c)
        };
        let keep: Vec<bool> = d.triangles.iter().map(&mut is_kept).collect();
        let warning = (far > 0).then(|| {
            format!(
                "mesh '{}': {far} of {n} triangles have a vertex that is not finite or farther than 1e12 units; left out",
                d.name
            )
        });
        let bounds = bounds_of(&d.positions);
        let grids = d.grids.into_iter().map(|grid| grid.checked(&d.name)).collect::<Result<_, _>>()?;
        let mut mesh = Self {
            bounds,
            name: d.name,
            positions: d.positions,
            triangles: d.triangles,
            loops: d.loops,
            corner_normals: d.corner_normals,
            uv_maps: d.uv_maps,
            attributes: d.attributes,
            material_slots: d.material_slots,
            moved_positions: d.moved_positions,
            grids,
            keeps_opacity: d.keeps_opacity,
            dicing: d.dicing,
            curves: None,
            points: None,
            is_special: d.poses.is_some(),
            poses: d.poses.map(Box::new),
        };
        if keep.contains(&false) {
            mesh.keep_only(&keep);
        }
        mesh.mend();
        Ok((mesh, warning))
    }

    /// Positions of a triangle's corners, object space.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|i| self.positions[i as usize])
    }

    /// The material slot of a triangle.
    #[inline]
    pub fn slot(&self, triangle: u32) -> u32 {
        self.material_slots.as_ref().map_or(0, |s| s[triangle as usize])
    }

    /// True if the mesh is neither hair nor a point cloud.
    pub fn is_of_triangles(&self) -> bool {
        self.curves.is_none() && self.points.is_none()
    }

    /// The UV map of that name, or the first where no name is given.
    pub fn uv_map(&self, name: Option<&str>) -> Option<usize> {
        match name {
            None => (!self.uv_maps.is_empty()).then_some(0),
            Some(name) => self.uv_maps.iter().position(|(n, _)| n == name),
        }
    }

    /// The values of an attribute at the corners.
    pub fn attribute(&self, name: &str) -> Option<&Corners<Vec4>> {
        corners::named(&self.attributes, name)
    }

    /// The indices for [`Corners::at`].
    #[inline]
    pub fn numbers(&self) -> Numbers<'_> {
        Numbers { triangles: &self.triangles, loops: &self.loops }
    }

    /// The normals at a triangle's corners, object space; `None` of a mesh that has none.
    #[inline]
    pub fn normals(&self, triangle: u32) -> Option<[Vec3; 3]> {
        Some(self.corner_normals.as_ref()?.at(self.numbers(), triangle))
    }

    fn keep_only(&mut self, keep: &[bool]) {
        corners::keep_only(&mut self.triangles, keep);
        if !self.loops.is_empty() {
            corners::keep_only(&mut self.loops, keep);
        }
        if let Some(normals) = &mut self.corner_normals {
            normals.keep_only(keep);
        }
        let posed = self.poses.as_mut().and_then(|poses| poses.corner_normals.as_mut());
        posed.into_iter().flatten().for_each(|normals| normals.keep_only(keep));
        self.uv_maps.iter_mut().for_each(|(_, uvs)| uvs.keep_only(keep));
        self.attributes.iter_mut().for_each(|(_, values)| values.keep_only(keep));
        if let Some(slots) = &mut self.material_slots {
            corners::keep_only(slots, keep);
        }
    }

    /// Normals of length one, and UVs that are finite.
    fn mend(&mut self) {
        if let Some(mut normals) = self.corner_normals.take() {
            corners::normalise(&mut normals, self.numbers(), |triangle| {
                let [a, b, c] = self.corners(triangle);
                (b - a).cross(c - a).normalize_or(Vec3::Z)
            });
            self.corner_normals = Some(normals);
        }
        self.uv_maps.iter_mut().for_each(|(_, uvs)| corners::finish(uvs));
    }
}

/// True if a point is finite, and near enough for products of coordinates to stay finite in single precision.
fn within_reach(p: &Vec3) -> bool {
    p.is_finite() && p.abs().max_element() <= 1e12
}

/// True if a triangle has area in double precision, with single-precision corners.
fn has_area(a: Vec3, b: Vec3, c: Vec3) -> bool {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a).length_squared() > 0.0
}

/// The places of balls over time as a mesh keeps them; `None` where there are none.
fn poses_of(balls: &[Vec<Vec4>]) -> Option<Box<Poses>> {
    let places = |balls: &Vec<Vec4>| balls.iter().map(|ball| ball.truncate()).collect();
    let positions: Vec<Vec<Vec3>> = balls.iter().map(places).collect();
    (!positions.is_empty()).then(|| Box::new(Poses { positions, corner_normals: None }))
}

impl Curves {
    /// The curves as a mesh without triangles.
    pub(super) fn into_mesh(self, name: String) -> Mesh {
        let poses = poses_of(&self.poses);
        Mesh { name, bounds: self.bounds(), poses, curves: Some(Box::new(self)), is_special: true, ..Mesh::default() }
    }
}

impl Points {
    /// The points as a mesh without triangles.
    pub(super) fn into_mesh(self, name: String) -> Mesh {
        let poses = poses_of(&self.poses);
        let low = self.points.iter().map(|p| p.truncate() - p.w).fold(Vec3::MAX, Vec3::min);
        let high = self.points.iter().map(|p| p.truncate() + p.w).fold(Vec3::MIN, Vec3::max);
        Mesh { name, bounds: [low, high], poses, points: Some(Box::new(self)), is_special: true, ..Mesh::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad() -> MeshDescription {
        MeshDescription {
            name: "quad".into(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        }
    }

    #[test]
    fn bad_triangles_are_left_out_and_counted() {
        let mut d = quad();
        d.positions.push(Vec3::new(f32::NAN, 0.0, 0.0));
        d.positions.push(Vec3::new(1e30, 0.0, 0.0));
        d.triangles.extend([[0, 1, 4], [0, 0, 1], [0, 1, 1], [0, 1, 5]]);
        d.material_slots = Some(vec![0, 1, 2, 3, 4, 5]);
        let (mesh, warning) = Mesh::new(d).unwrap();
        assert_eq!(mesh.triangles.len(), 2);
        assert_eq!(mesh.material_slots, Some(vec![0, 1]));
        // Those without area are silent.
        assert!(warning.unwrap().contains("2 of 6"));
        assert!(Mesh::new(quad()).unwrap().1.is_none());
        let mut flat = quad();
        flat.triangles.push([0, 0, 1]);
        let (mesh, warning) = Mesh::new(flat).unwrap();
        assert_eq!((mesh.triangles.len(), warning), (2, None));
    }

    #[test]
    fn arrays_that_do_not_fit_are_named() {
        let mut d = quad();
        d.uv_maps = vec![("UVMap".into(), Corners::Each(vec![[Vec2::ZERO; 3]]))];
        assert!(Mesh::new(d).unwrap_err().to_string().contains("UV map 'UVMap'"));
        let mut d = quad();
        d.triangles[0][2] = 9;
        assert!(Mesh::new(d).unwrap_err().to_string().contains("points past its 4 vertices"));
        let mut d = quad();
        d.material_slots = Some(vec![]);
        assert!(Mesh::new(d).is_err());
    }

    #[test]
    fn normals_are_made_usable() {
        let mut d = quad();
        d.corner_normals = Some(Corners::Each(vec![[Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::NAN]; 2]));
        d.uv_maps = vec![("UVMap".into(), Corners::Vertices(vec![Vec2::NAN; 4]))];
        let (mesh, _) = Mesh::new(d).unwrap();
        for n in [0, 1].map(|triangle| mesh.normals(triangle).unwrap()).iter().flatten() {
            assert!((n.length() - 1.0).abs() < 1e-6);
        }
        assert_eq!(mesh.uv_maps[0].1.at(mesh.numbers(), 1), [Vec2::ZERO; 3]);
    }
}

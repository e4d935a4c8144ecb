//! Values at the corners of a mesh's triangles, as often as there are different ones: by vertex where all faces about it share them, by the
//! corners of Blender's faces, of which two triangles share some, or by triangle. Every corner of every triangle by itself takes two to six
//! times the memory.

use glam::{Vec2, Vec3, Vec4};

/// Values of vertices, triangles or corners; [`super::mesh::Mesh::at_corners`] finds those of a triangle.
#[derive(Clone, Debug, PartialEq)]
pub enum Corners<T> {
    /// One value for each vertex.
    Vertices(Vec<T>),
    /// One value for each corner of a face, as the mesh's `loops` number them.
    Loops(Vec<T>),
    /// One value for each triangle.
    Triangles(Vec<T>),
    /// Three values for each triangle.
    Each(Vec<[T; 3]>),
}

/// The indices of triangles: those of their vertices, and those of the corners of faces.
#[derive(Clone, Copy, Debug)]
pub struct Numbers<'a> {
    /// Indices of the vertices by triangle.
    pub triangles: &'a [[u32; 3]],
    /// Corners of faces by triangle; empty where nothing is kept by corners of faces.
    pub loops: &'a [[u32; 3]],
}

impl<T: Copy> Corners<T> {
    /// The values of a triangle.
    #[inline]
    pub fn at(&self, numbers: Numbers<'_>, triangle: u32) -> [T; 3] {
        let triangle = triangle as usize;
        match self {
            Self::Vertices(values) => numbers.triangles[triangle].map(|i| values[i as usize]),
            Self::Loops(values) => numbers.loops[triangle].map(|i| values[i as usize]),
            Self::Triangles(values) => [values[triangle]; 3],
            Self::Each(values) => values[triangle],
        }
    }

    /// The error of values that do not fit these triangles and so many vertices; `None` if they fit.
    pub(super) fn misfit(&self, numbers: Numbers<'_>, vertices: usize) -> Option<String> {
        let triangles = numbers.triangles.len();
        let (have, need, of) = match self {
            Self::Vertices(values) => (values.len(), vertices, "vertices"),
            Self::Loops(values) => {
                if numbers.loops.len() != triangles {
                    return Some(format!(
                        "corners of {} faces, but there are {triangles} triangles",
                        numbers.loops.len()
                    ));
                }
                let past = numbers.loops.iter().flatten().any(|&i| i as usize >= values.len());
                return past.then(|| format!("a corner past its {} values", values.len()));
            }
            Self::Triangles(values) => (values.len(), triangles, "triangles"),
            Self::Each(values) => (values.len(), triangles, "triangles"),
        };
        (have != need).then(|| format!("{have} values for {need} {of}"))
    }

    /// Leaves out the values of triangles that are not kept; others are not asked for any more.
    pub(super) fn keep_only(&mut self, keep: &[bool]) {
        match self {
            Self::Vertices(_) | Self::Loops(_) => {}
            Self::Triangles(values) => keep_only(values, keep),
            Self::Each(values) => keep_only(values, keep),
        }
    }

    /// All values, each once.
    pub(super) fn values_mut(&mut self) -> &mut [T] {
        match self {
            Self::Vertices(values) | Self::Loops(values) | Self::Triangles(values) => values,
            Self::Each(values) => values.as_flattened_mut(),
        }
    }

    /// The values of the three corners of every triangle.
    pub fn each(&self, numbers: Numbers<'_>) -> Vec<[T; 3]> {
        (0..numbers.triangles.len() as u32).map(|triangle| self.at(numbers, triangle)).collect()
    }
}

/// Leaves out those that are not flagged.
pub(super) fn keep_only<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    list.retain(|_| *flags.next().expect("lengths were checked"));
}

/// Normals of length one; those that are not finite or have no length become the face's own, which `own` tells by triangle.
pub(super) fn normalise(normals: &mut Corners<Vec3>, numbers: Numbers<'_>, own: impl Fn(u32) -> Vec3) {
    let mut is_whole = true;
    for n in normals.values_mut() {
        match n.try_normalize() {
            Some(unit) => *n = unit,
            None => is_whole = false,
        }
    }
    if is_whole {
        return;
    }
    // Faces about a vertex or corner that has none have different ones.
    let mut each = normals.each(numbers);
    for (triangle, corners) in each.iter_mut().enumerate() {
        for n in corners {
            *n = n.try_normalize().unwrap_or_else(|| own(triangle as u32));
        }
    }
    *normals = Corners::Each(each);
}

/// A UV that is not finite would poison a texture lookup.
pub(super) fn finish(uvs: &mut Corners<Vec2>) {
    uvs.values_mut().iter_mut().filter(|uv| !uv.is_finite()).for_each(|uv| *uv = Vec2::ZERO);
}

/// Values with a name.
pub type Named<T> = (String, Corners<T>);

/// The values of an attribute of that name.
pub(super) fn named<'a>(list: &'a [Named<Vec4>], name: &str) -> Option<&'a Corners<Vec4>> {
    list.iter().find(|(own, _)| own == name).map(|(_, values)| values)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: Numbers<'_> = Numbers { triangles: &[[0, 1, 2], [0, 2, 3]], loops: &[[4, 5, 6], [4, 6, 7]] };

    #[test]
    fn all_ways_give_the_same_where_they_can() {
        let by_vertex = Corners::Vertices(vec![10, 11, 12, 13]);
        let by_loop = Corners::Loops(vec![0, 0, 0, 0, 10, 11, 12, 13]);
        let each = Corners::Each(vec![[10, 11, 12], [10, 12, 13]]);
        for values in [&by_vertex, &by_loop, &each] {
            assert!(values.misfit(NUMBERS, 4).is_none());
            assert_eq!(values.at(NUMBERS, 1), [10, 12, 13]);
            assert_eq!(Corners::Each(values.each(NUMBERS)), each);
        }
        assert_eq!(Corners::Triangles(vec![5, 6]).at(NUMBERS, 1), [6; 3]);
    }

    #[test]
    fn what_does_not_fit_is_told() {
        for values in [
            Corners::Vertices(vec![0; 3]),
            Corners::Loops(vec![0; 7]),
            Corners::Triangles(vec![0; 3]),
            Corners::Each(vec![[0; 3]; 1]),
        ] {
            assert!(values.misfit(NUMBERS, 4).is_some(), "{values:?}");
        }
        let without = Numbers { loops: &[], ..NUMBERS };
        assert!(Corners::Loops(vec![0; 8]).misfit(without, 4).is_some());
    }

    /// A normal that is none is each face's own; the others are theirs still.
    #[test]
    fn a_vertex_without_normal_has_that_of_each_face() {
        let mut normals = Corners::Vertices(vec![Vec3::ZERO, Vec3::X * 3.0, Vec3::NAN, Vec3::Y]);
        let own = [Vec3::Z, Vec3::NEG_Z];
        normalise(&mut normals, NUMBERS, |triangle| own[triangle as usize]);
        assert_eq!(normals.at(NUMBERS, 0), [Vec3::Z, Vec3::X, Vec3::Z]);
        assert_eq!(normals.at(NUMBERS, 1), [Vec3::NEG_Z, Vec3::NEG_Z, Vec3::Y]);
    }
}

//! Points given by hand, a table of them, for programs that run without a renderer.

use crate::choice::Choice;
use crate::context::{Attribute, AttributeKind, Context, Direction, Field, Shift, Space};
use glam::{Affine3A, Vec3A, Vec4};

/// A field or attribute at all points.
#[derive(Clone, Debug, Default)]
pub struct Column {
    /// One value a point.
    pub values: Vec<Vec4>,
    /// The derivative over the footprint in x, one a point; empty where the column does not change.
    pub along_x: Vec<Vec4>,
    /// The derivative over the footprint in y, one a point; empty where the column does not change.
    pub along_y: Vec<Vec4>,
}

impl Column {
    fn at(&self, point: usize, shift: Shift) -> Vec4 {
        let of = |values: &[Vec4]| values.get(point).copied().unwrap_or_default();
        of(&self.values) + of(&self.along_x) * shift.x + of(&self.along_y) * shift.y
    }
}

/// A table of shading points, by the columns of their values.
#[derive(Clone, Debug, Default)]
pub struct Points {
    fields: Vec<(Field, Column)>,
    attributes: Vec<(Attribute, Column)>,
    /// The transform from world space to the object's.
    pub world_to_object: Affine3A,
    /// The transform from world space to the camera's.
    pub world_to_camera: Affine3A,
}

/// The kinds of attributes by the words before their colon.
const KINDS: [(&str, AttributeKind); 7] = [
    ("uv", AttributeKind::Uv),
    ("colour", AttributeKind::Colour),
    ("tangent", AttributeKind::Tangent),
    ("geometry", AttributeKind::Geometry),
    ("object", AttributeKind::Object),
    ("instancer", AttributeKind::Instancer),
    ("view_layer", AttributeKind::ViewLayer),
];

impl Points {
    /// Adds a field by its name in small letters, `true_normal`, or an attribute as `uv:UVMap`. False if there is no
    /// such field.
    pub fn add(&mut self, name: &str, column: Column) -> bool {
        if let Some((kind, name)) = name.split_once(':') {
            let Some((_, kind)) = KINDS.iter().find(|(word, _)| *word == kind) else { return false };
            self.attributes.push((Attribute { kind: *kind, name: name.to_owned() }, column));
            return true;
        }
        let field = Field::named(name);
        self.fields.extend(field.map(|field| (field, column)));
        field.is_some()
    }

    /// The point of this number, for a program that reads these attributes.
    pub fn point<'a>(&'a self, number: usize, attributes: &'a [Attribute]) -> impl Context + 'a {
        TablePoint { table: self, number, attributes }
    }

    fn world_to(&self, space: Space) -> Affine3A {
        match space {
            Space::World => Affine3A::IDENTITY,
            Space::Object => self.world_to_object,
            Space::Camera => self.world_to_camera,
        }
    }
}

struct TablePoint<'a> {
    table: &'a Points,
    number: usize,
    attributes: &'a [Attribute],
}

impl Context for TablePoint<'_> {
    /// A table may hold any field; fields that it does not hold are zero.
    fn knows(_: Field) -> bool {
        true
    }

    fn answer(&self, field: Field, shift: Shift) -> Option<Vec3A> {
        let column = self.table.fields.iter().find(|(other, _)| *other == field);
        Some(column.map_or(Vec3A::ZERO, |(_, column)| Vec3A::from_vec4(column.at(self.number, shift))))
    }

    fn attribute(&self, index: usize, shift: Shift) -> Vec4 {
        let column = self.table.attributes.iter().find(|(other, _)| *other == self.attributes[index]);
        column.map_or(Vec4::ZERO, |(_, column)| column.at(self.number, shift))
    }

    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vec3A) -> Vec3A {
        let map = self.table.world_to(to) * self.table.world_to(from).inverse();
        match direction {
            Direction::Point => map.transform_point3a(vector),
            Direction::Vector => map.transform_vector3a(vector),
            Direction::Normal => (map.matrix3.inverse().transpose() * vector).normalize_or_zero(),
        }
    }
}
